"""Charts of the quantities of a run for its page."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from .drawable import Run, up_of
from .pages import Package

CHART_BUCKETS = 400
CHARTED = 6  # bodies or contacts of a chart


def pack_charts(run: Run, package: Package, buckets: int = CHART_BUCKETS) -> list[dict]:
    """The strips of a run with the numbers of their lines."""
    found = []
    for strip in charts_of(run, up_of(run)):
        lines = []
        for name, read in strip["lines"]:
            at, values = decimate(run.time, read(), buckets)
            if len(at) and np.ptp(values) > 0:
                lines.append(
                    {
                        "name": name,
                        "at": package.put(at - run.time[0], "f4"),
                        "values": package.put(values, "f4"),
                    }
                )
        if lines:
            found.append({**strip, "lines": lines})
    return found


def charts_of(run: Run, up: np.ndarray) -> list[dict]:
    """Strips of the quantities of the run: title, unit, and lines as functions that read them."""

    def plain(name: str, scale: float = 1.0):
        return lambda: scale * np.asarray(run.column(name)[: run.rows])

    def vector(name: str, i: int) -> np.ndarray:
        return np.asarray(run.column(name)[: run.rows, i])

    def axis(i: int) -> np.ndarray:
        w, x, y, z = vector("quaternion", i).T
        tilt = up[0] * 2 * (x * z + w * y) + up[1] * 2 * (y * z - w * x)
        tilt += up[2] * (1 - 2 * (x * x + y * y))
        return np.degrees(np.arccos(np.clip(tilt, -1, 1)))

    bodies = list(enumerate(run.bodies))
    if len(bodies) > CHARTED:
        ends = np.ptp(run.column("position")[:: max(1, run.rows // 50)], axis=0).max(axis=1)
        bodies = [pair for pair in bodies if ends[pair[0]] > 1e-6 * ends.max()][:CHARTED]
    contacts = list(enumerate(run.contacts))[:CHARTED]
    energies = ("kinetic", "potential", "elastic")
    works = ("work_friction", "work_damping", "work_applied")
    strips = [
        ("Energy", "J", [(name, plain(f"energy_{name}")) for name in energies]),
        ("Work", "J", [(name[5:], plain(name)) for name in works]),
        ("Height", "m", [(n, lambda i=i: vector("position", i) @ up) for i, n in bodies]),
        (
            "Inclination of the axis",
            "°",
            [(n, lambda i=i: axis(i)) for i, n in bodies if has_axis(run.file["body/inertia"][i])],
        ),
        (
            "Speed",
            "m/s",
            [(n, lambda i=i: np.linalg.norm(vector("velocity", i), axis=1)) for i, n in bodies],
        ),
        (
            "Angular velocity about the vertical",
            "rad/s",
            [(n, lambda i=i: vector("angular_velocity", i) @ up) for i, n in bodies],
        ),
        ("Normal force", "N", [(n, lambda i=i: vector("normal_force", i)) for i, n in contacts]),
        (
            "Slip velocity",
            "m/s",
            [
                (n, lambda i=i: np.linalg.norm(vector("slip_velocity", i), axis=1))
                for i, n in contacts
            ],
        ),
        ("Gap", "m", [(n, lambda i=i: vector("gap", i)) for i, n in contacts]),
    ]
    return [{"title": t, "unit": u, "lines": lines} for t, u, lines in strips if lines]


def has_axis(inertia: np.ndarray) -> bool:
    """Whether the first two principal moments alone are equal, or all differ: z is an axis then."""
    first, second, third = inertia
    return not np.isclose(first, third, rtol=1e-9) and not np.isclose(second, third, rtol=1e-9)


def decimate(time: np.ndarray, values: np.ndarray, buckets: int) -> tuple[np.ndarray, np.ndarray]:
    """A line that looks the same: of each bucket the least and the largest value, in order."""
    good = np.flatnonzero(np.isfinite(values))
    if len(good) <= 2 * buckets:
        return time[good], values[good]
    edges = np.linspace(0, len(good), buckets + 1).astype(int)
    kept = {int(good[0]), int(good[-1])}
    for first, last in pairwise(edges):
        part = values[good[first:last]]
        kept |= {int(good[first + part.argmin()]), int(good[first + part.argmax()])}
    rows = np.array(sorted(kept))
    return time[rows], values[rows]
