"""Surfaces of a run as triangles, for programs that draw meshes.

Triangles turn their front out of the material, so that who draws fronts alone looks into a hollow
from behind. Planes end with the scene, and of a groove there is the part that is touched.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .drawable import Run
from .results import ResultError

FINE = 48  # edges of a circle
COARSE = 16  # where there are many surfaces
MANY = 200
MOST_CELLS = 40  # of a plane, across

# Colours of the surfaces of a body, of those of the ground, and of planes of the ground.
PALETTE = (
    (0x2F, 0x7F, 0xD1),
    (0xE0, 0x8A, 0x2E),
    (0x3F, 0x9E, 0x58),
    (0xC0, 0x50, 0x4D),
    (0x80, 0x64, 0xA2),
    (0x2A, 0xA3, 0xA3),
    (0xB0, 0x45, 0x7F),
    (0x7A, 0x8A, 0x2F),
)
GROUND = (0x9A, 0xA3, 0xB2)
FLOOR = ((0xAA, 0xB3, 0xC0), (0x9A, 0xA4, 0xB3))


@dataclass
class Mesh:
    """Triangles of two colours, by which one sees a body turn."""

    points: np.ndarray  # (points, 3) [m]
    normals: np.ndarray  # (points, 3)
    triangles: tuple[np.ndarray, np.ndarray]  # of each colour, (triangles, 3)


@dataclass
class Placed:
    """A surface as it is drawn: its mesh, and the pose of its frame on its body."""

    name: str
    body: int  # -1 is the ground
    shape: str
    inside: bool
    material: str
    mesh: Mesh
    centre: np.ndarray
    axes: np.ndarray  # rows are the axes of the frame
    colours: tuple[tuple[int, int, int], tuple[int, int, int]]

    def to_body(self, vectors: np.ndarray) -> np.ndarray:
        """Vectors in the frame of the body."""
        return vectors @ self.axes


Patch = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]


def grid(patch: Patch, counts: tuple[int, int], fields: tuple[int, int], inside: bool) -> Mesh:
    """Triangles of points and normals over u and v from 0 to 1, chequered in so many fields. The
    normals are those out of the solid; along v, then u, triangles turn their front to them."""
    nu, nv = counts
    u, v = (a.ravel() for a in np.meshgrid(np.arange(nu + 1), np.arange(nv + 1), indexing="ij"))
    points, normals = patch(u / nu, v / nv)
    i, j = (a.ravel() for a in np.meshgrid(np.arange(nu), np.arange(nv), indexing="ij"))
    a = i * (nv + 1) + j
    b, c, d = a + nv + 1, a + nv + 2, a + 1
    triangles = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    field = ((2 * i + 1) * fields[0] // (2 * nu) + (2 * j + 1) * fields[1] // (2 * nv)) % 2
    field = np.concatenate([field, field])
    corners = points[triangles]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    # Of the two triangles beside a pole one is none.
    size = np.linalg.norm(across, axis=1)
    good = size > 1e-9 * size.max()
    triangles, field, across = triangles[good], field[good], across[good]
    behind = np.sum(across * normals[triangles].sum(1), axis=1) < 0
    if inside:
        behind = ~behind
        normals = -normals
    triangles[behind] = triangles[behind][:, ::-1]
    return Mesh(points, normals, (triangles[field == 0], triangles[field == 1]))


def joined(meshes: list[Mesh]) -> Mesh:
    """One mesh of several."""
    shifts = np.cumsum([0] + [len(mesh.points) for mesh in meshes[:-1]])
    pairs = [
        np.concatenate(
            [mesh.triangles[k] + shift for mesh, shift in zip(meshes, shifts, strict=True)]
        )
        for k in (0, 1)
    ]
    return Mesh(
        np.concatenate([mesh.points for mesh in meshes]),
        np.concatenate([mesh.normals for mesh in meshes]),
        (pairs[0], pairs[1]),
    )


def unit(vectors: np.ndarray) -> np.ndarray:
    """Vectors of length 1."""
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def disc(radius: tuple[float, float], z: float, up: int, fine: int) -> Mesh:
    """A flat end: an ellipse across the third axis, its normal along or against that."""

    def patch(u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        turn = 2 * np.pi * u
        x, y = radius[0] * v * np.cos(turn), radius[1] * v * np.sin(turn)
        normals = np.zeros((len(u), 3))
        normals[:, 2] = up
        return np.stack([x, y, np.full_like(u, z)], 1), normals

    return grid(patch, (fine, 1), (1, 1), False)


def ellipsoid(surface: dict, scale: float, fine: int) -> Mesh:
    """A sphere, an ellipsoid, or half of one with its flat side."""
    del scale
    sizes, part = surface["sizes"], surface["part"]
    axes = np.array(sizes.get("semi_axes") or [sizes["radius"]] * 3)
    low, high = {"lower_half": (0.5, 1.0), "upper_half": (0.0, 0.5)}.get(part, (0.0, 1.0))

    def patch(u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        polar, turn = np.pi * (low + v * (high - low)), 2 * np.pi * u
        sine = np.sin(polar)
        round_ = np.stack([sine * np.cos(turn), sine * np.sin(turn), np.cos(polar)], 1)
        return axes * round_, unit(round_ / axes)

    half = high - low < 1
    shell = grid(
        patch, (fine, fine // (4 if half else 2)), (6, 1 if half else 2), surface["inside"]
    )
    if not half or surface["inside"]:
        return shell
    return joined([shell, disc((axes[0], axes[1]), 0.0, 1 if low else -1, fine)])


def torus(surface: dict, scale: float, fine: int) -> Mesh:
    """A torus, or of a groove the part that is touched."""
    del scale
    sizes = surface["sizes"]
    major, minor = sizes["major_radius"], sizes["minor_radius"]
    middle, wide = surface.get("band") or (0.0, np.pi)

    def patch(u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        turn, tube = 2 * np.pi * u, middle + wide * (2 * v - 1)
        normals = np.stack(
            [np.cos(tube) * np.cos(turn), np.cos(tube) * np.sin(turn), np.sin(tube)], 1
        )
        ring = np.stack([np.cos(turn), np.sin(turn), np.zeros_like(u)], 1)
        return major * ring + minor * normals, normals

    fields = (12, 1 if "band" in surface else 2)
    return grid(patch, (2 * fine, fine // 2), fields, surface["inside"])


def turned(surface: dict, fine: int, counts: tuple[int, int], outline: Callable) -> Mesh:
    """What has an axis of revolution: radius, height, and slope of the radius over v."""

    def patch(u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        radius, z, across, along = (np.broadcast_to(x, u.shape) for x in outline(v))
        c, s = np.cos(2 * np.pi * u), np.sin(2 * np.pi * u)
        normals = unit(np.stack([across * c, across * s, along], 1))
        return np.stack([radius * c, radius * s, z], 1), normals

    return grid(patch, (fine, counts[0]), (6, counts[1]), surface["inside"])


def cylinder(surface: dict, scale: float, fine: int) -> Mesh:
    """A cylinder about its centre."""
    del scale
    radius = surface["sizes"]["radius"]
    half = (surface["length"] or 4 * radius) / 2
    low, high = surface.get("ends") or (-half, half)
    shell = turned(surface, fine, (2, 2), lambda v: (radius, low + v * (high - low), 1.0, 0.0))
    if surface["inside"]:
        return shell
    ends = [disc((radius, radius), z, up, fine) for z, up in ((high, 1), (low, -1))]
    return joined([shell, *ends])


def cone(surface: dict, scale: float, fine: int) -> Mesh:
    """A cone from its apex up, or the part of it that is touched."""
    low, high = surface.get("ends") or (0.0, surface["length"] or scale)
    half = surface["sizes"]["half_angle"]
    slope = np.tan(half)

    def outline(v: np.ndarray) -> tuple:
        z = low + v * (high - low)
        return slope * z, z, np.cos(half), -np.sin(half)

    shell = turned(surface, fine, (4, 1), outline)
    if surface["inside"]:
        return shell
    ends = [disc((slope * high,) * 2, high, 1, fine)]
    if low > 0:
        ends.append(disc((slope * low,) * 2, low, -1, fine))
    return joined([shell, *ends])


def paraboloid(surface: dict, scale: float, fine: int) -> Mesh:
    """A paraboloid from its vertex up."""
    vertex = surface["sizes"]["vertex_radius"]
    height = surface["length"] or max(scale, vertex) / 2
    wide = np.sqrt(2 * vertex * height)
    shell = turned(
        surface, fine, (fine // 2, 1), lambda v: (wide * v, height * v * v, wide * v, -vertex)
    )
    return shell if surface["inside"] else joined([shell, disc((wide, wide), height, 1, fine)])


def plane(middle: np.ndarray, wide: float) -> Mesh:
    """A chequered square about a point, at least so wide."""
    cell = 10.0 ** np.floor(np.log10(wide / 4))
    cells = 2 * int(np.clip(np.ceil(wide / cell / 2), 4, MOST_CELLS // 2))
    half = cells * cell / 2
    x, y = np.round(middle[:2] / cell) * cell

    def patch(u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        points = np.stack([x + (2 * u - 1) * half, y + (2 * v - 1) * half, 0 * u], 1)
        return points, np.broadcast_to([0.0, 0.0, 1.0], points.shape).copy()

    return grid(patch, (cells, cells), (cells, cells), False)


# The shapes that have ends of their own, or get them from the scene. Planes are drawn apart.
SHAPES: dict[str, Callable[[dict, float, int], Mesh]] = {
    "sphere": ellipsoid,
    "ellipsoid": ellipsoid,
    "torus": torus,
    "cylinder": cylinder,
    "cone": cone,
    "paraboloid": paraboloid,
}


def placed(run: Run, box: tuple[np.ndarray, np.ndarray]) -> list[Placed]:
    """All surfaces of a run, whose bodies move within a box. Those alike share a mesh."""
    middle, travel = (box[0] + box[1]) / 2, float(np.linalg.norm(box[1] - box[0]))
    fine = COARSE if len(run.surfaces) > MANY else FINE
    found, kept, seen = [], {}, {}
    for surface in run.surfaces:
        body, shape = surface["body"], surface["shape"]
        order = seen[body] = seen.get(body, -1) + 1
        base = GROUND if body < 0 else PALETTE[(body + 3 * order) % len(PALETTE)]
        light = tuple(round(0.45 * x + 0.55 * 255) for x in base)
        colours = FLOOR if shape == "plane" and body < 0 else (base, light)
        centre, axes = np.array(surface["centre"]), np.array(surface["axes"]).reshape(3, 3)
        if shape == "plane" and body < 0:
            mesh = plane(axes @ (middle - centre), max(5 * run.scale, 1.4 * travel))
        elif shape == "plane":
            mesh = plane(np.zeros(3), 2 * run.scale)
        elif shape in SHAPES:
            key = repr([surface[k] for k in ("shape", "inside", "part", "length", "sizes")])
            key += repr([surface.get(k) for k in ("band", "ends")])
            if key not in kept:
                kept[key] = SHAPES[shape](surface, run.scale, fine)
            mesh = kept[key]
        else:
            raise ResultError(
                f"surface {surface['name']} of {run.path} is a {shape}, of which export knows no "
                "mesh (scripts/lib/meshes.py)"
            )
        found.append(
            Placed(
                surface["name"],
                body,
                shape,
                surface["inside"],
                surface["material"],
                mesh,
                centre,
                axes,
                colours,
            )
        )
    return found
