"""Read the table of `contensou sweep`."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import h5py
import numpy as np

from . import labels
from .results import ResultError, as_text, keyword_values, names, open_file

FILETYPE = "contensou-sweep"


@dataclass(frozen=True)
class Column:
    """One parameter or result: values over the cases, text values as words."""

    name: str
    unit: str
    meaning: str
    values: np.ndarray

    @property
    def is_text(self) -> bool:
        """Whether the values are words."""
        return self.values.dtype.kind in "OUS"

    @property
    def label(self) -> str:
        """Name and unit for an axis."""
        name = labels.drawn(self.name.replace("_", " "))
        return name if self.unit in ("", "1") else f"{name} [{self.unit}]"

    def levels(self) -> np.ndarray:
        """The distinct values, words in the order in which they come."""
        if not self.is_text:
            return np.unique(self.values)
        return np.array(list(dict.fromkeys(self.values)), dtype=object)

    def text_of(self, value: object) -> str:
        """One value as text, with its unit."""
        if self.is_text:
            return str(value)
        return f"{value:.4g}" if self.unit in ("", "1") else f"{value:.4g} {self.unit}"


@dataclass
class Sweep:
    """The table of a sweep; every array goes over its cases."""

    path: Path
    title: str
    version: str
    total: int
    parameters: dict[str, Column]
    results: dict[str, Column]
    status: np.ndarray
    meanings: dict[int, str] = field(default_factory=dict)

    def select(self, where: np.ndarray) -> Sweep:
        """The same for some of the cases."""
        few = {}
        for kind in ("parameters", "results"):
            columns = getattr(self, kind)
            few[kind] = {
                name: Column(c.name, c.unit, c.meaning, c.values[where])
                for name, c in columns.items()
            }
        return Sweep(
            self.path, self.title, self.version, self.total, **few, status=self.status[where],
            meanings=self.meanings,
        )  # fmt: skip

    def varied(self) -> list[str]:
        """The parameters that have more than one value here."""
        return [name for name, column in self.parameters.items() if len(column.levels()) > 1]


def is_sweep(path: Path) -> bool:
    """Whether a file is the table of a sweep."""
    try:
        with h5py.File(path, "r", locking=False) as file:
            return as_text(file.attrs.get("filetype", "")) == FILETYPE
    except OSError:
        return False


def read(path: Path) -> Sweep:
    """The table in a file."""
    with open_file(path) as file:
        parameters = {name: column(name, data) for name, data in file["parameters"].items()}
        status = file["status"]
        attributes = {name: as_text(value) for name, value in file.attrs.items()}
        title = attributes.get("title", "")
        if not title and "input/scene" in file:
            title = next(iter(keyword_values(as_text(file["input/scene"][()]), "title")), "")
        sweep = Sweep(
            path=path,
            title=title or path.stem,
            version=attributes.get("program_version", ""),
            total=int(np.ravel(file.attrs.get("case_count", len(status)))[0]),
            parameters=parameters,
            results={name: column(name, data) for name, data in file["results"].items()},
            status=np.asarray(status[()]),
            meanings=meanings_of(status),
        )
    if not len(sweep.status):
        raise ResultError(f"{path} holds no cases")
    return sweep


def meanings_of(status: h5py.Dataset) -> dict[int, str]:
    """The word for each status, from the CF attributes of the data set."""
    words = as_text(status.attrs["flag_meanings"]).split()
    numbers = np.atleast_1d(status.attrs["flag_values"]).tolist()
    return dict(zip(numbers, words, strict=True))


def column(name: str, data: h5py.Dataset) -> Column:
    """One column of the table."""
    values = np.array(names(data), dtype=object) if data.dtype.kind in "OS" else data[()]
    return Column(
        name,
        as_text(data.attrs.get("units", "")),
        as_text(data.attrs.get("long_name", "")),
        values,
    )


def is_logarithmic(values: np.ndarray) -> bool:
    """Whether values are spread more evenly in their logarithm, by more than a little."""
    values = np.unique(values[np.isfinite(values)].astype(float))
    if len(values) < 4 or values[0] <= 0 or values[-1] < 8 * values[0]:
        return False
    even = np.linspace(0, 1, len(values))
    logs = np.log(values)

    def distance(v: np.ndarray) -> float:
        return np.abs((v - v[0]) / (v[-1] - v[0]) - even).max()

    return distance(logs) < distance(values)
