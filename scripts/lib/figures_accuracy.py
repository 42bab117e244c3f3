"""Work-precision pictures and tables of docs/accuracy.md, from `contensou cost`."""

from __future__ import annotations

import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from lib import program, style, work_precision


@dataclass(frozen=True)
class Scene:
    """A scene of the page."""

    name: str
    title: str
    file: str
    settings: tuple[str, ...] = ()


SCENES = (
    Scene("tippe_top", "Tippe-Top, damping 100 s/m", "tippe_top.nml"),
    Scene(
        "tippe_top_light",
        "Tippe-Top, damping 0.2 s/m",
        "tippe_top.nml",
        ("contact.damping_coefficient=0.2",),
    ),
)

# Errors for which the cheapest run is named.
ERRORS = (1e-2, 1e-4, 1e-6)


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
                cells.append("-")
                continue
            i = int(np.flatnonzero(where)[0])
            cells.append(f"{study.numerical[i]:.1e} in {study.cpu[i]:.2f} s")
        lines.append(f"| {method} | {' | '.join(cells)} |")
    return lines


def cheapest_lines(study: work_precision.Study) -> list[str]:
    """The cheapest run for some errors."""
    lines = []
    for error in ERRORS:
        within = np.where(np.isfinite(study.bound), study.bound, np.inf) <= error
        if not within.any():
            lines.append(f"- error {error:.0e}: none")
            continue
        i = int(np.argmin(np.where(within, study.cpu, np.inf)))
        lines.append(
            f"- error {error:.0e}: {study.model[i]}, {study.method[i]} at rtol "
            f"{study.rtol[i]:.0e}, {study.cpu[i]:.2f} s"
        )
    return lines


def draw(folder: Path, wanted: list[str]) -> list[Path]:
    """A picture for each scene, and accuracy_tables.md."""
    pictures = []
    page: list[str] = []
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
            style.save(work_precision.draw(output), picture)
            pictures.append(picture)
            study = work_precision.read(output)
            page += [f"## {scene.title}", "", f"![{scene.title}](accuracy_{scene.name}.png)", ""]
            page += ["Numerical error and CPU time of the exact model:", "", *runs_table(study), ""]
            with h5py.File(output) as file:
                page += ["Models:", "", *models_table(file), ""]
            page += ["Cheapest run:", "", *cheapest_lines(study), ""]
    tables = folder / "accuracy_tables.md"
    tables.write_text("\n".join(page))
    return [*pictures, tables]
