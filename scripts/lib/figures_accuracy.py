"""Work-precision pictures and tables of docs/accuracy.md, from `contensou cost` and `run`.

The page holds each table between `<!-- NAME -->` and `<!-- end -->`. What is written to the folder
is the page with new tables beside new pictures, so that `scripts/figures docs --only accuracy`
brings it up to date; its sentences are for the reader of the new numbers to check.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import h5py
import matplotlib.pyplot as plt
import numpy as np

from . import explicit_libraries, program, style, work_precision
from .results import ResultError

PAGE = program.ROOT / "docs" / "accuracy.md"
TABLE = re.compile(r"<!-- (\w+) -->\n(.*?)<!-- end -->\n", re.DOTALL)

WORK = re.compile(r"(\d+) steps, (\d+) right-hand sides, (\d+) Jacobians")

# What cvode_bdf is run with for the table of Jacobians: the analytic one, differences instead, and
# differences as often as CVODE renews them by its own choice.
JACOBIANS = (
    ("integrator.jacobian=analytic",),
    ("integrator.jacobian=differences",),
    ("integrator.jacobian=differences", "integrator.jacobian_steps=51"),
)

# Dots per inch of the pictures, which are part of the repository.
DOTS = 90

# Errors for which the cheapest run is named.
ERRORS = (1e-2, 1e-4, 1e-6)


@dataclass(frozen=True)
class Scene:
    """A scene of the page."""

    name: str
    title: str
    file: str
    settings: tuple[str, ...] = ()


BOTH = ("cost.friction=contensou_exact,contensou_simplified", "cost.normal=hertz,vilke")

SCENES = (
    Scene("tippe_top", "Tippe-Top, damping 100 s/m", "tippe_top.nml", ("cost.repeats=1",)),
    Scene(
        "tippe_top_light",
        "Tippe-Top, damping 0.2 s/m, first 1.7 s",
        "tippe_top.nml",
        ("contact.damping_coefficient=0.2", "scene.t_end=1.7", "cost.repeats=1"),
    ),
    Scene(
        "bearing",
        "Ball bearing 6205, first 1 ms",
        "bearing_6205.nml",
        ("scene.t_end=1e-3", "cost.rtol=1e-4,1e-6,1e-8", "cost.repeats=1", *BOTH),
    ),
    Scene(
        "rattleback",
        "Rattleback, first 0.5 s",
        "rattleback.nml",
        ("scene.t_end=0.5", "cost.repeats=1", *BOTH),
    ),
)


def table_names() -> list[str]:
    """Names of all tables of the page."""
    kinds = ("runs", "models", "cheapest")
    names = [f"{scene.name}_{kind}" for scene in SCENES for kind in kinds]
    return [*names, "jacobian", "explicit_libraries"]


def tables_of(page: str) -> dict[str, list[str]]:
    """The tables in the text of a page, by name."""
    return {match[1]: match[2].splitlines() for match in TABLE.finditer(page)}


def with_tables(page: str, tables: dict[str, list[str]]) -> str:
    """The page with new tables in place of those of the same names."""

    def fill(match: re.Match[str]) -> str:
        lines = tables.get(match[1], match[2].splitlines())
        return f"<!-- {match[1]} -->\n" + "".join(f"{line}\n" for line in lines) + "<!-- end -->\n"

    return TABLE.sub(fill, page)


def models_table(file: h5py.File) -> list[str]:
    """Reference, check and error of each model."""
    group = file["model"]
    lines = ["| model | references agree to | model error | position [m] | angle [rad] |"]
    lines.append("|---|---|---|---|---|")
    for i, name in enumerate(group["name"][()]):
        values = [
            group[key][i]
            for key in ("agreement", "error", "error_position_largest", "error_angle_largest")
        ]
        if i == 0:
            values[1:] = [np.nan] * 3
        cells = ["-" if not np.isfinite(value) else f"{value:.1e}" for value in values]
        lines.append(f"| {work_precision.text(name).strip()} | {' | '.join(cells)} |")
    return lines


def runs_table(study: work_precision.Study) -> list[str]:
    """Numerical error and CPU time of the exact model by method and tolerance."""
    exact = study.model_names[0]
    tolerances = sorted(set(study.rtol), reverse=True)
    lines = ["| method | " + " | ".join(f"rtol {rtol:.0e}" for rtol in tolerances) + " |"]
    lines.append("|---|" + "---|" * len(tolerances))
    for method in work_precision.METHODS:
        cells = []
        for rtol in tolerances:
            where = (study.model == exact) & (study.method == method) & (study.rtol == rtol)
            if not (where & study.done).any():
                cells.append("given up")
                continue
            i = int(np.flatnonzero(where)[0])
            cells.append(f"{study.numerical[i]:.1e} in {study.cpu[i]:.2g} s")
        lines.append(f"| {method} | {' | '.join(cells)} |")
    return lines


def cheapest_table(study: work_precision.Study) -> list[str]:
    """The cheapest run for some errors against the exact model."""
    lines = ["| error | model | method | rtol | CPU [s] |", "|---|---|---|---|---|"]
    for error in ERRORS:
        within = np.where(np.isfinite(study.bound), study.bound, np.inf) <= error
        if not within.any():
            lines.append(f"| {error:.0e} | none | - | - | - |")
            continue
        i = int(np.argmin(np.where(within, study.cpu, np.inf)))
        lines.append(
            f"| {error:.0e} | {study.model[i]} | {study.method[i]} | {study.rtol[i]:.0e} "
            f"| {study.cpu[i]:.2g} |"
        )
    return lines


def jacobian_table(scenes: list[Path], place: Path) -> list[str]:
    """Work of cvode_bdf in each scene with each of JACOBIANS, and of all scenes together."""
    lines = [
        "| scene | unknowns | analytic: steps | right-hand sides | Jacobians "
        "| differences: steps | right-hand sides | ratio "
        "| differences each 51 steps: steps | right-hand sides | ratio |",
        "|" + "---|" * 11,
    ]
    sums = np.zeros(7, dtype=int)
    for scene in scenes:
        output = place / f"{scene.stem}.h5"
        work = []
        for settings in JACOBIANS:
            shown = program.call(
                "run", scene, "-q", "--force", "-o", output, "--set", "integrator.method=cvode_bdf",
                *(word for setting in settings for word in ("--set", setting)),
            )  # fmt: skip
            counted = WORK.search(shown)
            if not counted:
                raise ResultError(f"{scene} was run without a line on the work:\n{shown}")
            work.append(list(map(int, counted.groups())))
        with h5py.File(output) as file:
            unknowns = 13 * len(file["body/name"])
        row = np.array([*work[0], *work[1][:2], *work[2][:2]])
        sums += row
        lines.append(jacobian_row(scene.stem, str(unknowns), row))
    return [*lines, jacobian_row("all", "-", sums)]


def jacobian_row(name: str, unknowns: str, work: np.ndarray) -> str:
    """A line of the table of the Jacobians."""
    cells = list(map(str, work))
    for i in (6, 4):
        cells.insert(i + 1, f"{work[i] / work[1]:.2f}")
    return f"| {name} | {unknowns} | " + " | ".join(cells) + " |"


def explicit_libraries_table() -> list[str]:
    """What explicit methods of libraries need beside explicit8 for the error of a touch."""
    build = program.PROGRAM.parent.parent
    target = "tests/cost/library_explicit8"
    done = subprocess.run(
        ["ninja", "-C", str(build), target], capture_output=True, text=True, check=False
    )
    if done.returncode != 0:
        raise ResultError(
            f"{target} cannot be compiled; it needs ERKStep of SUNDIALS:\n{done.stdout}"
        )
    return explicit_libraries.table(build, program.ROOT / "inputs")


def draw(folder: Path, wanted: list[str]) -> list[Path]:
    """A picture for each scene, and the page with its tables."""
    pictures = []
    tables: dict[str, list[str]] = {}
    with tempfile.TemporaryDirectory() as place:
        for scene in SCENES:
            print(f"accuracy: {scene.title}", file=sys.stderr)
            output = Path(place) / f"{scene.name}.h5"
            settings = [word for setting in scene.settings for word in ("--set", setting)]
            title = f"scene.title='{scene.title}'"
            program.call(
                "cost", program.ROOT / "inputs" / scene.file, "-q", "-o", output, "--set", title,
                *settings,
            )  # fmt: skip
            picture = folder / f"accuracy_{scene.name}.png"
            figure = work_precision.draw(output)
            with plt.rc_context({"savefig.dpi": DOTS}):
                style.save(figure, picture)
            pictures.append(picture)
            study = work_precision.read(output)
            tables[f"{scene.name}_runs"] = runs_table(study)
            tables[f"{scene.name}_cheapest"] = cheapest_table(study)
            with h5py.File(output) as file:
                tables[f"{scene.name}_models"] = models_table(file)
        print("accuracy: Jacobians", file=sys.stderr)
        scenes = sorted((program.ROOT / "inputs").glob("*.nml"))
        tables["jacobian"] = jacobian_table(scenes, Path(place))
    print("accuracy: explicit methods of libraries", file=sys.stderr)
    tables["explicit_libraries"] = explicit_libraries_table()
    page = folder / PAGE.name
    page.write_text(with_tables(PAGE.read_text(encoding="utf-8"), tables), encoding="utf-8")
    return [*pictures, page]
