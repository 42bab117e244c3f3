"""Draw one output file of contensou.

A run: what moves of its bodies, contacts and energy balance over time, and the paths. A study of
`contensou cost`: error against CPU time. The table of `contensou sweep`: results over one or two
parameters. With --loads the loads of ball bearings around their rings.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from lib import labels, style, sweeps
from lib.drawing import figure_of
from lib.results import STATUS_FILE, ResultError, check_output


def main(name: str = "scripts/plot") -> int:
    """Read the command line, draw, and print the name of the picture."""
    parser = argparse.ArgumentParser(
        prog=name,
        description="Draws one output file of contensou into one PNG and prints its name.",
    )
    parser.add_argument("file", type=Path, metavar="FILE", help="output file (HDF5, also .part)")
    parser.add_argument(
        "-o", "--output", type=Path, metavar="PNG", help="picture; default beside FILE, as .png"
    )
    parser.add_argument(
        "--loads", action="store_true", help="loads of the balls of bearings around their rings"
    )
    of_sweeps = parser.add_argument_group(
        "tables of sweeps", "What is not given is chosen by the data; names are those of the table."
    )
    of_sweeps.add_argument("--result", metavar="NAME[,NAME]", help="results, a panel for each")
    of_sweeps.add_argument("--over", metavar="NAME[,NAME]", help="one or two parameters")
    of_sweeps.add_argument(
        "--kind", choices=sweeps.KINDS, help="lines, heat map, or a point for each case"
    )
    of_sweeps.add_argument(
        "--where",
        metavar="NAME=VALUE",
        action="append",
        default=[],
        help="hold another parameter at its nearest value; may be repeated",
    )
    options = parser.parse_args()
    wishes = wishes_of(parser, options)
    picture = options.output or default_picture(options.file)
    try:
        check_output(options.file, picture, force=True, what="picture")
        figure = figure_of(options.file, wishes, loads=options.loads)
        style.save(figure, picture)
    except ResultError as problem:
        print(f"error: {labels.shown(str(problem))}", file=sys.stderr)
        return problem.status
    except OSError as problem:
        print(
            f"error: {labels.shown(str(picture))} cannot be written: {problem.strerror}",
            file=sys.stderr,
        )
        return STATUS_FILE
    print(labels.shown(str(picture)))
    return 0


def wishes_of(parser: argparse.ArgumentParser, options: argparse.Namespace) -> sweeps.Wishes:
    """What is asked for of a sweep; ends with a message when it cannot be understood."""

    def words(text: str | None) -> list[str] | None:
        return [word.strip() for word in text.split(",")] if text is not None else None

    where = {}
    for text in options.where:
        name, equals, value = text.partition("=")
        if not equals:
            parser.error(f"--where takes NAME=VALUE, not '{text}'")
        where[name.strip()] = value.strip()
    over = words(options.over)
    if over and (len(over) > 2 or len(set(over)) < len(over)):
        parser.error("--over takes one or two different parameters")
    return sweeps.Wishes(words(options.result), over, options.kind, where)


def default_picture(file: Path) -> Path:
    """Beside the file and of its name: run.h5 and run.h5.part both give run.png."""
    stem = file.with_suffix("") if file.suffix == ".part" else file
    return stem.with_suffix(".png")


if __name__ == "__main__":
    sys.exit(main())
