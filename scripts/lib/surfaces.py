"""The surfaces of a run: what is drawn of them, and how far they reach."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from . import thinning
from .results import names

if TYPE_CHECKING:
    from .drawable import Run
    from .pages import Package

SHAPES = ("sphere", "ellipsoid", "torus", "cylinder", "cone", "paraboloid", "plane")
SAMPLES = 200  # rows that tell what is touched
TOUCHED = 500  # points of a shape that the page does not know
SIZES = ("radius", "semi_axes", "major_radius", "minor_radius", "half_angle", "vertex_radius")


def read(run: Run) -> list[dict]:
    """The surfaces, with what the page needs to draw them."""
    group = run.file["surface"]
    table = {key: names(group[key]) for key in ("name", "body", "shape", "side", "material")}
    parts = names(group["solid_part"])
    lengths = group["solid_length"][()]
    found = []
    for i, name in enumerate(table["name"]):
        sizes = {}
        for key in SIZES:
            if key in group and np.isfinite(group[key][i]).all():
                sizes[key] = np.asarray(group[key][i]).tolist()
        body = table["body"][i]
        found.append(
            {
                "name": name,
                "body": run.bodies.index(body) if body in run.bodies else -1,
                "shape": table["shape"][i],
                "inside": table["side"][i] == "inside",
                "material": table["material"][i],
                "centre": group["centre"][i].tolist(),
                "axes": group["axes"][i].ravel().tolist(),
                "part": parts[i],
                "length": float(lengths[i]) if np.isfinite(lengths[i]) else 0,
                "sizes": sizes,
            }
        )
    return found


def reach(surface: dict) -> float:
    """How far a surface reaches from the origin of its body; 0 if it has no end [m]."""
    sizes = surface["sizes"]
    if "ends" in surface:
        return max(
            float(np.linalg.norm(np.add(surface["centre"], np.multiply(z, surface["axes"][6:]))))
            + radius_at(surface, z)
            for z in surface["ends"]
        )
    size = {
        "sphere": lambda: sizes["radius"],
        "ellipsoid": lambda: max(sizes["semi_axes"]),
        "torus": lambda: sizes["major_radius"] + sizes["minor_radius"],
        "cylinder": lambda: float(np.hypot(sizes["radius"], 0.5 * surface["length"])),
        "paraboloid": lambda: max(sizes["vertex_radius"], surface["length"]),
        "cone": lambda: surface["length"],
    }.get(surface["shape"], lambda: 0.0)()
    return float(np.linalg.norm(surface["centre"])) + size if size else 0.0


def radius_at(surface: dict, z: float) -> float:
    """Radius of a cylinder or a cone at a height of its axis [m]."""
    sizes = surface["sizes"]
    return sizes["radius"] if "radius" in sizes else z * float(np.tan(sizes["half_angle"]))


def scale(run: Run) -> float:
    """Size of the scene at its beginning [m]."""
    reaches = np.zeros(len(run.bodies))
    for surface in run.surfaces:
        if surface["body"] >= 0:
            reaches[surface["body"]] = max(reaches[surface["body"]], reach(surface))
    if not len(run.bodies):
        return 1.0
    start = run.column("position")[0]
    size = float(
        np.linalg.norm((start + reaches[:, None]).max(0) - (start - reaches[:, None]).min(0))
    )
    if not size > 0:
        ends = np.stack([start, run.column("position")[run.rows - 1]])
        size = float(np.linalg.norm(np.ptp(ends.reshape(-1, 3), axis=0)))
    return size if np.isfinite(size) and size > 0 else 1.0


def of_body(
    body: int, points: np.ndarray, position: np.ndarray, attitude: np.ndarray
) -> np.ndarray:
    """Points (rows, contacts, 3) as a body sees them."""
    if body < 0:
        return points
    turn = thinning.matrices(attitude[:, body])
    return np.einsum("tji,tcj->tci", turn, points - position[:, None, body])


def touched_of(run: Run, package: Package) -> list[dict]:
    """The surfaces as the page gets them; those of shapes that it does not know, such as those of
    extensions, with the points at which they were touched."""
    found = [dict(surface) for surface in run.surfaces]
    unknown = [surface for surface in found if surface["shape"] not in SHAPES]
    for surface in unknown:
        surface["touched"] = package.put(np.zeros(0), "f4")
    if not unknown or run.column("contact_point") is None or not run.contacts:
        return found
    pairs = np.asarray(run.file["contact/surfaces"].asstr()[()])
    rows = np.unique(np.linspace(0, run.rows - 1, 2 * TOUCHED).astype(int))
    point, position, attitude, force = (
        run.column(name)[rows]
        for name in ("contact_point", "position", "quaternion", "normal_force")
    )
    for surface in unknown:
        at = np.flatnonzero((pairs == surface["name"]).any(axis=1))
        x = of_body(surface["body"], point[:, at], position, attitude)
        x = x[(force[:, at] > 0) & np.isfinite(x).all(axis=-1)]
        surface["touched"] = package.put(x[:: 1 + len(x) // TOUCHED], "f4")
    return found


def find_ends(run: Run) -> None:
    """What there is to draw of surfaces that are more than what is touched: for grooves the part of
    the tube, as `band` of angles across it, for cylinders and cones without ends those of the part
    along the axis, as `ends`, in the surface."""
    wanted = [
        surface
        for surface in run.surfaces
        if (surface["shape"] == "torus" and surface["inside"])
        or (surface["shape"] in ("cylinder", "cone") and not surface["length"])
    ]
    if not wanted or run.column("contact_point") is None or not run.contacts:
        return
    pairs = np.asarray(run.file["contact/surfaces"].asstr()[()])
    rows = np.unique(np.linspace(0, run.rows - 1, SAMPLES).astype(int))
    point, gap = run.column("contact_point")[rows], run.column("gap")[rows]
    position, attitude = run.column("position")[rows], run.column("quaternion")[rows]
    for surface in wanted:
        at = np.flatnonzero((pairs == surface["name"]).any(axis=1))
        axes = np.array(surface["axes"]).reshape(3, 3)
        x = of_body(surface["body"], point[:, at], position, attitude)
        x = (x - np.array(surface["centre"])) @ axes.T
        apart = gap[:, at]
        seen = np.isfinite(apart) & np.isfinite(x).all(axis=-1)
        if surface["shape"] == "torus":
            find_band(surface, x[seen & (apart < surface["sizes"]["minor_radius"])])
        else:
            find_length(surface, x[seen][:, 2])


def find_band(surface: dict, x: np.ndarray) -> None:
    """The part of the tube of a groove that is touched at places (points, 3) of its frame."""
    if not len(x):
        return
    across = np.hypot(x[:, 0], x[:, 1]) - surface["sizes"]["major_radius"]
    angles = np.arctan2(x[:, 2], across)
    middle = np.angle(np.exp(1j * angles).mean())
    off = np.abs(np.angle(np.exp(1j * (angles - middle)))).max()
    if off < np.radians(80):
        surface["band"] = [float(middle), float(off + np.radians(35))]


def find_length(surface: dict, z: np.ndarray) -> None:
    """The part of a cylinder or cone that is touched at heights of its axis, and a bit more. A cone
    that is touched near its apex keeps this."""
    if not len(z):
        return
    low, high = float(z.min()), float(z.max())
    if surface["shape"] == "cylinder":
        more = 2 * surface["sizes"]["radius"]
        surface["ends"] = [low - more, high + more]
        return
    more = 0.3 * radius_at(surface, high)
    if low - more > 0.5 * high:
        surface["ends"] = [low - more, high + more]
    elif surface["inside"]:
        surface["ends"] = [0.0, 1.2 * high]
