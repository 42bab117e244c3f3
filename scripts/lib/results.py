"""Read an output file of contensou into arrays that are ready to draw."""

from __future__ import annotations

import contextlib
import os
import re
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from . import seal

# As those of the program: bad usage, and files that cannot be read or written.
STATUS_USAGE, STATUS_FILE = 2, 74


class ResultError(Exception):
    """The file cannot be used; the text says why, for the user."""

    status = STATUS_FILE


class UsageError(ResultError):
    """What was asked for cannot be."""

    status = STATUS_USAGE


@dataclass(frozen=True)
class Event:
    """One touch or lift of one contact."""

    time: float
    kind: str
    contact: str


class Result:
    """The trajectory of one run, SI units, first axis time."""

    def __init__(self, path: Path) -> None:
        self.path = path
        with open_file(path) as file:
            self._read(file)

    def _read(self, file: h5py.File) -> None:
        if "trajectory/time" not in file or "body/name" not in file:
            raise ResultError(f"{self.path} is no output file of contensou")
        attributes = {name: as_text(value) for name, value in file.attrs.items()}
        self.status = attributes.get("status", "")
        self.version = attributes.get("program_version", "")
        self.namelist = as_text(file["input/namelist"][()]) if "input/namelist" in file else ""
        titles = keyword_values(self.namelist, "title")
        self.title = attributes.get("title") or (titles[0] if titles else self.path.stem)

        group = file["trajectory"]
        self.time, rows = complete_rows(group)
        if rows < 2:
            raise ResultError(f"{self.path} holds {rows} rows; a plot needs at least two")
        self._columns = {
            name: np.asarray(data[:rows])
            for name, data in group.items()
            if isinstance(data, h5py.Dataset) and data.ndim > 0 and len(data) >= rows
            if data.dtype.kind in "fiu"
        }

        self.bodies = names(file["body/name"])
        self.inertia = np.asarray(file["body/inertia"][()]) if "body/inertia" in file else None
        self.contacts = names(file["contact/name"]) if "contact/name" in file else []
        self.events = read_events(file, self.contacts, self.time[-1])

    def column(self, name: str) -> np.ndarray | None:
        """A variable of /trajectory, or None when the run did not record it."""
        return self._columns.get(name)

    @property
    def complete(self) -> bool:
        """Whether the run reached its end."""
        return self.status == "complete"

    def symmetric_bodies(self) -> list[int]:
        """Bodies of which the first two principal moments alone are equal: they have an axis, z."""
        if self.inertia is None:
            return []
        return [
            i
            for i, (first, second, third) in enumerate(self.inertia)
            if np.isclose(first, second, rtol=1e-9) and not np.isclose(first, third, rtol=1e-9)
        ]

    def body_axis(self, body: int) -> np.ndarray | None:
        """The body's z axis in the inertial frame, (time, 3)."""
        quaternion = self.column("quaternion")
        if quaternion is None:
            return None
        w, x, y, z = quaternion[:, body, :].T
        return np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], axis=1)

    def inclination(self, body: int) -> np.ndarray | None:
        """Angle between the body's z axis and the vertical [rad]."""
        axis = self.body_axis(body)
        if axis is None:
            return None
        return np.arctan2(np.hypot(axis[:, 0], axis[:, 1]), axis[:, 2])

    def axial_spin(self, body: int) -> np.ndarray | None:
        """Angular velocity about the body's z axis [rad/s]."""
        axis, spin = self.body_axis(body), self.column("angular_velocity")
        if axis is None or spin is None:
            return None
        return np.sum(axis * spin[:, body, :], axis=1)

    def energies(self) -> dict[str, np.ndarray]:
        """The terms of the balance by name [J], as changes since the start; their sum is zero."""
        terms = {}
        for name, column in (
            ("kinetic", "energy_kinetic"),
            ("potential", "energy_potential"),
            ("elastic", "energy_elastic"),
            ("work of friction", "work_friction"),
            ("work of damping", "work_damping"),
        ):
            values = self.column(column)
            if values is not None:
                terms[name] = values - values[0]
        supplied = self.column("work_applied")
        if supplied is not None and supplied.any():
            terms["less work supplied"] = supplied[0] - supplied
        return terms

    def initial_energy(self) -> float:
        """Scale for the residual [J]: energy at the start, or the largest term if that is 0."""
        start = [self.column(f"energy_{name}") for name in ("kinetic", "potential", "elastic")]
        total = abs(sum(values[0] for values in start if values is not None))
        return total or max(
            (np.abs(values).max() for values in self.energies().values()), default=0
        )

    def residual(self) -> np.ndarray | None:
        """What the energy balance leaves open [J]."""
        recorded = self.column("energy_error")
        if recorded is not None:
            return recorded
        terms = self.energies()
        if "kinetic" not in terms:
            return None
        return sum(terms.values())

    def choices(self, key: str) -> list[str]:
        """The distinct text values that the scene gives a key, such as friction, in order."""
        return list(dict.fromkeys(value.lower() for value in keyword_values(self.namelist, key)))


@contextlib.contextmanager
def damage_told(path: Path) -> Iterator[None]:
    """While a file is read: an error in words, however damaged it is."""
    sealed = False
    try:
        if path.is_file():
            sealed = seal.check(path)
        yield
    except (ResultError, MemoryError):
        raise
    except seal.DamageError as problem:
        raise ResultError(f"{path} is damaged: {problem}") from None
    except Exception as problem:
        # What is known to be as it was written cannot be the reason.
        if sealed:
            raise
        raise ResultError(
            f"{path} is damaged, or no output file of contensou: {problem}"
        ) from problem


def open_file(path: Path) -> h5py.File:
    """Open for reading, also while a run is writing; say in plain words why not."""
    if not path.exists():
        raise ResultError(f"{path} does not exist")
    if path.is_dir():
        raise ResultError(f"{path} is a folder")
    try:
        return h5py.File(path, "r", locking=False)
    except PermissionError:
        raise ResultError(f"{path} may not be read") from None
    except OSError:
        if not h5py.is_hdf5(path):
            raise ResultError(f"{path} is no HDF5 file") from None
        raise ResultError(f"{path} is incomplete or damaged and cannot be opened") from None


def complete_rows(group: h5py.Group) -> tuple[np.ndarray, int]:
    """Times of the rows that every variable has; the last may be missing when a run was killed."""
    time = np.asarray(group["time"][()], dtype=float)
    rows = len(time)
    for name in ("quaternion", "gap", "energy_kinetic", "angular_velocity"):
        if name in group:
            rows = min(rows, len(group[name]))
    backwards = np.flatnonzero(np.diff(time[:rows]) <= 0)
    if len(backwards):
        rows = int(backwards[0]) + 1
    return time[:rows], rows


def read_events(file: h5py.File, contacts: list[str], end: float) -> list[Event]:
    """The touches and lifts up to the time end, in order."""
    if "events/time" not in file or len(file["events/time"]) == 0:
        return []
    group = file["events"]
    kinds = labels(group["kind"], ["touch", "lift"])
    touched = labels(group["contact"], contacts)
    events = [
        Event(float(t), *what) for t, *what in zip(group["time"][()], kinds, touched, strict=False)
    ]
    return sorted((event for event in events if event.time <= end), key=lambda event: event.time)


def labels(data: h5py.Dataset, choice: list[str]) -> list[str]:
    """The texts of a variable of text, of an enumeration, of CF flags or of positions in choice."""
    if data.dtype.kind in "OS":
        return names(data)
    if enumeration := h5py.check_enum_dtype(data.dtype):
        meaning = {number: text for text, number in enumeration.items()}
    elif "flag_values" in data.attrs and "flag_meanings" in data.attrs:
        words = as_text(data.attrs["flag_meanings"]).split()
        meaning = dict(zip(np.atleast_1d(data.attrs["flag_values"]).tolist(), words, strict=False))
    else:
        first = 0 if 0 in data[()] else 1
        meaning = dict(enumerate(choice, first))
    return [meaning.get(number, str(number)) for number in data[()].tolist()]


def names(data: h5py.Dataset) -> list[str]:
    """A variable of text as a list, without padding."""
    return [as_text(value) for value in np.atleast_1d(data[()]).ravel()]


def as_text(value: object) -> str:
    """Text of an attribute or of a scalar variable."""
    if isinstance(value, np.ndarray):
        value = value.ravel()[0] if value.size else ""
    if isinstance(value, bytes):
        value = value.decode("utf-8", "replace")
    return str(value).strip()


def keyword_values(namelist: str, key: str) -> list[str]:
    """The text values of a key in a namelist; a doubled quote stands for one."""
    text = re.sub(
        r"^((?:[^'\"!\n]|'[^'\n]*'|\"[^\"\n]*\")*)!.*", r"\1", namelist, flags=re.MULTILINE
    )
    pattern = rf"(?<!\w){key}\s*=\s*('(?:[^']|'')*'|\"(?:[^\"]|\"\")*\")"
    found = re.findall(pattern, text, re.IGNORECASE)
    return [value[1:-1].replace(2 * value[0], value[0]) for value in found]


def default_output(file: Path, ending: str) -> Path:
    """Beside the file and of its name: run.h5 and run.h5.part both give run.glb."""
    stem = file.with_suffix("") if file.suffix == ".part" else file
    return stem.with_suffix(ending)


def check_output(
    file: Path | None, output: Path, *, force: bool, what: str = "output file"
) -> None:
    """See that nothing is lost by writing a file."""
    if not os.path.lexists(output):
        return
    if file and file.exists() and output.exists() and output.samefile(file):
        raise UsageError(f"the {what} {output} is the file that is read")
    if output.is_symlink() or not output.is_file():
        raise ResultError(f"the {what} {output} would replace what is no regular file")
    if not force:
        raise ResultError(f"{output} exists; --force replaces it")


@contextlib.contextmanager
def whole_file(output: Path) -> Iterator[Path]:
    """Where to write a file that has its name only when it is complete."""
    descriptor, name = tempfile.mkstemp(
        prefix=f"{output.stem[:40]}.part-", suffix=output.suffix, dir=output.parent
    )
    os.close(descriptor)
    try:
        yield Path(name)
        mask = os.umask(0)
        os.umask(mask)
        os.chmod(name, 0o666 & ~mask)
        os.replace(name, output)
    except BaseException:
        os.unlink(name)
        raise
