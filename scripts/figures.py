"""Draw figures of Kosenko and Aleksandrov (2009), error against cost, and scenes.

Everything comes from fresh runs of the program: figures 2 and 3, the friction force and torque of
each model, from `contensou eval wrench`; figures 6 to 8, the Tippe-Top, figure 10, the bearing, the
rattleback and the egg, what tangential elasticity does, what rolls, from `contensou run`; `creep`,
the laws of creep and what of a spot sticks, from `contensou eval creep`; the figures of error
against cost, one for each kernel, from `contensou bench kernels`; `accuracy`, those and the tables
of docs/accuracy.md, from `contensou cost`, only if it is named. The choice of curves and scales is
ours; the figures are no copies of the printed ones.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from lib import (
    figures_accuracy,
    figures_bearing,
    figures_cost,
    figures_creep,
    figures_rolling,
    figures_scenes,
    figures_tangential,
    figures_top,
    figures_wrench,
    program,
    style,
)
from lib.results import ResultError

# What draws which figures; each gets the names of those that are wanted.
FIGURES = {
    figures_wrench.draw: ["2", "3"],
    figures_top.draw: ["6", "7", "8"],
    figures_bearing.draw: ["10"],
    figures_cost.draw: ["cost"],
    figures_scenes.draw: ["rattleback", "egg"],
    figures_tangential.draw: ["impact", "incline", "cattaneo", "dish"],
    figures_creep.draw: ["creep"],
    figures_rolling.draw: ["rolling"],
    figures_accuracy.draw: ["accuracy"],
}
NAMES = [name for names in FIGURES.values() for name in names]


def names_of(text: str) -> list[str]:
    """The figures that an option names, in their usual order."""
    words = [word.strip() for word in text.split(",")]
    for word in words:
        if word not in NAMES:
            raise argparse.ArgumentTypeError(f"no figure '{word}'; possible are {','.join(NAMES)}")
    return [name for name in NAMES if name in words]


def draw(folder: Path, wanted: list[str]) -> list[Path]:
    """Draw the wanted figures into the folder."""
    style.apply()
    folder.mkdir(parents=True, exist_ok=True)
    pictures = []
    for drawing, names in FIGURES.items():
        if chosen := [name for name in names if name in wanted]:
            pictures += drawing(folder, chosen)
    return pictures


def main() -> int:
    """Read the command line, draw, and print the names of the pictures."""
    parser = argparse.ArgumentParser(
        prog="scripts/figures",
        description="Draws figures 2, 3, 6, 7, 8 and 10 of Kosenko and Aleksandrov (2009), error "
        "against cost of each kernel, and shipped scenes, from fresh runs.",
    )
    parser.add_argument(
        "folder",
        nargs="?",
        type=Path,
        default=program.ROOT / "results" / "figures",
        metavar="FOLDER",
        help="where the pictures go (results/figures)",
    )
    parser.add_argument(
        "--only",
        type=names_of,
        default=[name for name in NAMES if name != "accuracy"],
        metavar="LIST",
        help=f"some of {','.join(NAMES)}",
    )
    arguments = parser.parse_args()
    try:
        pictures = draw(arguments.folder, arguments.only)
    except ResultError as problem:
        print(f"error: {problem}", file=sys.stderr)
        return 2
    except OSError as problem:
        print(f"error: {arguments.folder}: {problem.strerror}", file=sys.stderr)
        return 2
    print(*pictures, sep="\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
