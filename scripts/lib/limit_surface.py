"""The limit surface of a spot, all forces and torques that dry friction can take, as a page."""

from __future__ import annotations

import numpy as np

from .kernels import described, evaluated
from .pages import Package, library, page
from .results import UsageError

MODELS = ("contensou_exact", "coulomb", "pade11", "pade22", "contensou_simplified")
DEFAULTS = {"f": 1.0, "N": 1.0, "model": MODELS[0]}
AROUND, UP = 72, 49


def read(words: str) -> dict:
    """The spot of an option such as a=1e-3,b=5e-4,f=0.3,N=10,model=pade22."""
    numbers = ("a", "b", "f", "N")
    spot = {**DEFAULTS, **described(words, numbers, numbers, ("model",))}
    if spot["model"] not in MODELS:
        raise UsageError(f"model '{spot['model']}': expected one of {', '.join(MODELS)}")
    return spot


def wrenches(spot: dict, slip: np.ndarray) -> np.ndarray:
    """Forces and torques of friction against slips vx, vy [m/s], w [rad/s], by the program."""
    at = [spot[key] for key in ("N", "a", "b", "f")]
    return evaluated(
        "wrench",
        ("N", "a", "b", "f", "vx", "vy", "w"),
        [at + row for row in slip.tolist()],
        ("Fx", "Fy", "Tz"),
        *("--model", spot["model"]),
    )


def directions(spot: dict) -> tuple[np.ndarray, np.ndarray]:
    """Slips that go once over all directions, and the triangles of their neighbours: pure spins,
    first and last, and between them rings of equal shares of spin."""
    length = 0.6 * np.sqrt(spot["a"] * spot["b"])
    share = np.linspace(-np.pi / 2, np.pi / 2, UP)[1:-1, None]
    way = 2 * np.pi * np.arange(AROUND)[None] / AROUND
    ring = np.broadcast_arrays(
        np.cos(share) * np.cos(way), np.cos(share) * np.sin(way), np.sin(share)
    )
    slip = np.concatenate([[[0, 0, -1]], np.stack(ring, axis=-1).reshape(-1, 3), [[0, 0, 1]]])
    slip = slip * (1, 1, 1 / length)
    at = 1 + np.arange((UP - 2) * AROUND).reshape(UP - 2, AROUND)
    beside = np.roll(at, -1, axis=1)
    last = len(slip) - 1
    triangles = [
        np.stack([np.zeros(AROUND, int), beside[0], at[0]], axis=-1),
        np.stack([at[:-1], beside[:-1], beside[1:]], axis=-1).reshape(-1, 3),
        np.stack([at[:-1], beside[1:], at[1:]], axis=-1).reshape(-1, 3),
        np.stack([np.full(AROUND, last), at[-1], beside[-1]], axis=-1),
    ]
    return slip, np.concatenate(triangles)


def view(words: str) -> str:
    """The page of a spot."""
    spot = read(words)
    slip, triangles = directions(spot)
    found = -wrenches(spot, slip)
    largest = np.abs(found).max(axis=0)
    force, torque = largest[:2].max(), largest[2]
    scale = np.array([force, force, torque if torque > 0 else 1.0])
    package = Package()
    says = [
        f"{key} = {spot[key]:g}{unit}"
        for key, unit in zip("abfN", (" m", " m", "", " N"), strict=True)
    ]
    still = {"name": "limit surface", "at": package.put(np.zeros(1), "u4")}
    still["position"] = package.put(np.zeros(3), "f4")
    still["turned_at"] = still["at"]
    still["quaternion"] = package.put(np.array([32767, 0, 0, 0]), "i2")
    still["turn"] = package.put(np.zeros(3), "f4")
    shape = {
        "points": package.put(found / scale, "f4"),
        "triangles": package.put(triangles, "u4"),
    }
    surface = {
        "name": "limit surface", "body": 0, "shape": "mesh", "inside": False, "part": "",
        "centre": [0, 0, 0], "axes": np.eye(3).ravel().tolist(), "length": 0, "sizes": {},
        "mesh": shape,
    }  # fmt: skip
    head = {
        "title": "Limit surface of a spot",
        "about": f"{', '.join(says)}, {spot['model']}: the forces and torques at which it slips "
        "in all directions; a click tells how",
        "start": 0, "end": 0, "tick": 1, "rows": 1, "scale": 2.6, "up": [0, 0, 1],
        "surfaces": [surface], "bodies": [still], "contacts": [], "forces": [1] * 9,
        "charts": [], "drawn": True, "scene": "",
        "events": {
            "time": package.put(np.zeros(0), "f8"),
            "touch": package.put(np.zeros(0), "u1"),
            "contact": package.put(np.zeros(0), "u4"),
        },
        "asked": {
            "slip": package.put(slip, "f4"),
            "wrench": package.put(found, "f4"),
            "labels": [f"Fx {force:.4g} N", f"Fy {force:.4g} N", f"T {torque:.4g} N m"],
        },
    }  # fmt: skip
    return page("view", package.text(head), [library()])
