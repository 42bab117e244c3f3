"""The springs of a run for its page: where they hold, and the forces in them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from . import thinning
from .drawable import Run
from .pages import Package
from .results import names

DRAWN_FORCE = 0.02  # parts of the largest force of a spring


def pack(run: Run, package: Package, times: Callable[[np.ndarray], list]) -> list[dict]:
    """Names, kinds, bodies (-1 is the ground) and points of the springs, and their forces on B."""
    forces = run.column("spring_force")
    if "spring" not in run.file or forces is None:
        return []
    group = run.file["spring"]
    bodies = group["bodies"].asstr()[()].tolist()
    points = [group[key][()] for key in ("first_point", "second_point")]
    largest = float(np.max(np.abs(forces[: run.rows]), initial=0.0)) or 1.0
    found = []
    for i, name in enumerate(names(group["name"])):
        force = np.asarray(forces[: run.rows, i])
        kept = thinning.keys(run.rows, thinning.line_error(run.time, force, DRAWN_FORCE * largest))
        found.append(
            {
                "name": name,
                "kind": names(group["kind"])[i],
                "bodies": [
                    run.bodies.index(body) if body in run.bodies else -1 for body in bodies[i]
                ],
                "points": [point[i].tolist() for point in points],
                "at": times(kept),
                "force": package.put(force[kept], "f4"),
            }
        )
    return found
