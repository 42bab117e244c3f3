"""A run that can be drawn: its rows, its surfaces, the size of the scene, and where it is up."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import h5py
import numpy as np

from . import surfaces
from .results import ResultError, as_text, complete_rows, names

PORTION = 1 << 23  # numbers that are read at a time


@dataclass
class Run:
    """A file that is being looked at."""

    file: h5py.File
    path: Path
    time: np.ndarray
    rows: int
    bodies: list[str]
    contacts: list[str]
    surfaces: list[dict] = field(default_factory=list)
    scale: float = 1.0

    def column(self, name: str) -> h5py.Dataset | None:
        """A column of the trajectory."""
        return self.file["trajectory"].get(name)

    def parts(self, count: int, each: int) -> list[slice]:
        """Slices of bodies or contacts whose columns fit into the memory."""
        step = max(1, PORTION // max(1, each * self.rows))
        return [slice(i, min(i + step, count)) for i in range(0, count, step)]


def open_run(path: Path, file: h5py.File) -> Run:
    """See that a file can be drawn, or say what it lacks."""
    kind = as_text(file.attrs.get("filetype", ""))
    if kind and kind != "contensou-trajectory":
        raise ResultError(f"{path} is a {kind}, not a run; scripts/plot draws it")
    if "trajectory/time" not in file or "body/name" not in file:
        raise ResultError(f"{path} is no output file of contensou")
    if "surface/shape" not in file:
        version = as_text(file.attrs.get("filetype_version", "")) or "without version"
        raise ResultError(
            f"{path} does not say what its bodies look like: contensou-trajectory {version}, "
            "1.5 or later is needed. Run the scene again; it is in /input/namelist"
        )
    time, rows = complete_rows(file["trajectory"])
    rows = min(
        [rows]
        + [
            len(data)
            for data in file["trajectory"].values()
            if data.ndim > 0 and data.dtype.kind == "f" and data.maxshape[0] is None
        ]
    )
    if rows < 1:
        raise ResultError(f"{path} holds no rows as yet")
    run = Run(file, path, time[:rows], rows, names(file["body/name"]), [])
    run.contacts = names(file["contact/name"]) if "contact/name" in file else []
    run.surfaces = surfaces.read(run)
    surfaces.find_ends(run)
    run.scale = surfaces.scale(run)
    return run


def up_of(run: Run) -> np.ndarray:
    """Where it is up: against gravity, or z."""
    gravity = gravity_of(run)
    return -gravity / np.linalg.norm(gravity) if gravity.any() else np.array([0.0, 0.0, 1.0])


def gravity_of(run: Run) -> np.ndarray:
    """Acceleration of gravity as the scene gives it."""
    text = as_text(run.file["input/resolved"][()]) if "input/resolved" in run.file else ""
    found = re.search(r"(?im)^\s*gravity\s*=\s*([-+0-9.eEdD, ]+)", text)
    numbers = re.findall(r"[-+0-9.eE]+", found[1].replace("D", "E")) if found else []
    try:
        gravity = np.array([float(number) for number in numbers[:3]])
    except ValueError:
        return np.zeros(3)
    return gravity if len(gravity) == 3 else np.zeros(3)


def columns_of_bodies(run: Run, rows: slice) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Position, attitude and angular velocity of each body, some read at a time."""
    for part in run.parts(len(run.bodies), 10):
        columns = [
            np.asarray(run.column(name)[rows, part])
            for name in ("position", "quaternion", "angular_velocity")
        ]
        for column in columns:
            if not np.isfinite(column).all():
                raise ResultError(f"{run.path} has positions or attitudes that are no numbers")
        for i in range(part.stop - part.start):
            yield tuple(column[:, i] for column in columns)
