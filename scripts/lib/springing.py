"""The springs of a run: where they hold, the forces in them, and coils that stand for them."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from . import meshes, thinning
from .drawable import Run
from .pages import Package
from .results import names

DRAWN_FORCE = 0.02  # parts of the largest force of a spring

# As in view/springs.js.
WIDTH = 0.05  # of a coil, parts of the size of the scene
TURNS, EACH = 8, 10
COLOUR = (0x8A, 0x4F, 0xB0)

WIRE = 0.06  # radius of the wire of a coil, parts of its width
SIDES = 6  # of the wire


@dataclass
class Spring:
    """A spring, and where it holds its bodies."""

    name: str
    kind: str
    bodies: tuple[int, int]  # -1 is the ground
    points: tuple[np.ndarray, np.ndarray]  # in the frames of the bodies [m]


def read(run: Run) -> list[Spring]:
    """The springs of a run."""
    if "spring" not in run.file:
        return []
    group = run.file["spring"]
    bodies = group["bodies"].asstr()[()].tolist()
    first, second = (group[key][()] for key in ("first_point", "second_point"))
    kinds = names(group["kind"])
    index = {name: i for i, name in enumerate(run.bodies)}
    return [
        Spring(
            name,
            kinds[i],
            (index.get(bodies[i][0], -1), index.get(bodies[i][1], -1)),
            (first[i], second[i]),
        )
        for i, name in enumerate(names(group["name"]))
    ]


def pack(run: Run, package: Package, times: Callable[[np.ndarray], list]) -> list[dict]:
    """Names, kinds, bodies and points of the springs, and their forces on B, for the page."""
    forces = run.column("spring_force")
    if forces is None:
        return []
    largest = float(np.max(np.abs(forces[: run.rows]), initial=0.0)) or 1.0
    found = []
    for i, spring in enumerate(read(run)):
        force = np.asarray(forces[: run.rows, i])
        kept = thinning.keys(run.rows, thinning.line_error(run.time, force, DRAWN_FORCE * largest))
        found.append(
            {
                "name": spring.name,
                "kind": spring.kind,
                "bodies": spring.bodies,
                "points": [point.tolist() for point in spring.points],
                "at": times(kept),
                "force": package.put(force[kept], "f4"),
            }
        )
    return found


def ends(
    spring: Spring, poses: dict[int, tuple[np.ndarray, np.ndarray]], times: int
) -> tuple[np.ndarray, np.ndarray]:
    """Where a spring holds its bodies, of which there are positions and attitudes over the times;
    twice (times, 3)."""
    found = []
    for body, point in zip(spring.bodies, spring.points, strict=True):
        place = np.broadcast_to(point, (times, 3))
        if body >= 0:
            position, quaternion = poses[body]
            place = position + thinning.matrices(quaternion) @ point
        found.append(place)
    return found[0], found[1]


def axis(first: np.ndarray, second: np.ndarray, size: float) -> tuple[np.ndarray, np.ndarray]:
    """Begin of a coil and the way to its end, between two points (times, 3). Points that are closer
    than a coil is wide have one about their middle, the more along z the closer they are."""
    way = second - first
    length = np.linalg.norm(way, axis=1)
    drawn = way + np.array([0.0, 0.0, 1.0]) * np.maximum(size - length, 0.0)[:, None]
    drawn[np.linalg.norm(drawn, axis=1) < 1e-3 * size] = [1e-3 * size, 0.0, 0.0]
    return (first + second - drawn) / 2, drawn


def coil(size: float) -> np.ndarray:
    """Points along a coil from z = 0 to 1."""
    s = np.arange(TURNS * EACH + 1) / (TURNS * EACH)
    wide, turn = 0.5 * size * np.sin(np.pi * s) ** 0.25, 2 * np.pi * TURNS * s
    points = np.stack([wide * np.cos(turn), wide * np.sin(turn), 0.1 + 0.8 * s], axis=1)
    return np.concatenate([[[0.0, 0.0, 0.0]], points, [[0.0, 0.0, 1.0]]])


@functools.cache
def wire(size: float, length: float) -> meshes.Mesh:
    """The wire of a coil from z = 0 to 1, round where it is drawn so long; one for all alike."""
    line = coil(size) * [1.0, 1.0, length]
    tangent = meshes.unit(np.gradient(line, axis=0))
    across = np.zeros_like(line)
    across[0] = [1.0, 0.0, 0.0]
    for i in range(1, len(line)):
        # What was across is, but for what has become along.
        across[i] = across[i - 1] - (across[i - 1] @ tangent[i]) * tangent[i]
        across[i] /= np.linalg.norm(across[i])
    third = np.cross(tangent, across)
    turn = 2 * np.pi * np.arange(SIDES) / SIDES
    out = np.cos(turn)[:, None, None] * across + np.sin(turn)[:, None, None] * third
    points = line + WIRE * size * out
    # Under the stretching of z by the length normals become those of the stretched wire.
    normals = meshes.unit(out * [1.0, 1.0, length])
    count = len(line)
    i, j = (a.ravel() for a in np.meshgrid(np.arange(SIDES), np.arange(count - 1), indexing="ij"))
    a, d = i * count + j, (i + 1) % SIDES * count + j
    triangles = np.concatenate([np.stack([a, d, d + 1], 1), np.stack([a, d + 1, a + 1], 1)])
    flat = (points / [1.0, 1.0, length]).reshape(-1, 3)
    return meshes.Mesh(
        flat, normals.reshape(-1, 3), (triangles, np.zeros((0, 3), dtype=triangles.dtype))
    )


def placed(name: str, scale: float, length: float) -> meshes.Placed:
    """The wire of a spring as a surface of the ground, from z = 0 to 1."""
    mesh = wire(WIDTH * scale, length)
    colours = (COLOUR, COLOUR)
    return meshes.Placed(name, -1, "coil", False, "springs", mesh, np.zeros(3), np.eye(3), colours)


def frames(way: np.ndarray) -> np.ndarray:
    """Attitudes w, x, y, z (times, 4) that turn z to directions, from one to the next by the
    shortest rotation."""
    unit = meshes.unit(way)
    found = np.empty((len(unit), 4))
    before, last = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0, 0.0])
    for k, now in enumerate(unit):
        cosine = before @ now
        if cosine > -1 + 1e-12:
            turn = meshes.unit(np.concatenate([[1 + cosine], np.cross(before, now)]))
        else:
            some = np.eye(3)[np.argmin(np.abs(now))]
            turn = np.concatenate([[0.0], meshes.unit(np.cross(now, some))])
        last = thinning.product(turn, last)
        before, found[k] = now, last / np.linalg.norm(last)
    return found
