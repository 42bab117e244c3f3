"""Loads of the balls of a ball bearing around its ring, from the run of a scene with `&bearing`."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from . import style
from .results import Result, UsageError

RINGS = {"inner": style.BLUE, "outer": style.RED}
ARCS = ("_upper", "_lower")


def bearings_of(result: Result) -> dict[str, int]:
    """Names of the bearings and their numbers of balls."""
    found = {}
    for body in result.bodies:
        name, first, rest = body.rpartition("_ball_1")
        if not first or rest:
            continue
        count = 1
        while f"{name}_ball_{count + 1}" in result.bodies:
            count += 1
        if any(f"{name}_inner{arc}_1" in result.contacts for arc in ("", *ARCS)):
            found[name] = count
    return found


def around(result: Result, name: str, count: int, rows: slice) -> np.ndarray:
    """Angles of the balls around the axis, (rows, balls)."""
    balls = [result.bodies.index(f"{name}_ball_{i + 1}") for i in range(count)]
    places = result.column("position")[rows][:, balls]
    arms = places - places.mean(axis=1, keepdims=True)
    _, _, axes = np.linalg.svd(arms[-1])
    # The first axis points as nearly along x as it can, or y, as nobody knows the other one.
    normal = axes[2] * np.sign(axes[2][np.argmax(np.abs(axes[2]))])
    seed = np.eye(3)[0 if abs(normal[0]) < 0.9 else 1]
    first = seed - seed @ normal * normal
    first /= np.linalg.norm(first)
    return np.arctan2(arms @ np.cross(normal, first), arms @ first)


def by_place(
    angles: np.ndarray, loads: np.ndarray, time: np.ndarray, count: int
) -> tuple[np.ndarray, np.ndarray]:
    """Means over time by sector of the ring in which balls were: angles and loads, closed."""
    sectors = max(72, 4 * count)
    weights = np.gradient(time) if len(time) > 1 else np.ones(1)
    weights = np.repeat(weights, angles.shape[1])
    sector = (angles.ravel() / (2 * np.pi) % 1.0 * sectors).astype(int) % sectors
    weight = np.bincount(sector, weights, sectors)
    load = np.bincount(sector, weights * loads.ravel(), sectors)
    # The mean direction of what is in a sector, which may lie anywhere in it.
    centre = (np.arange(sectors) + 0.5) * 2 * np.pi / sectors
    off = np.angle(np.exp(1j * (angles.ravel() - centre[sector])))
    shift = np.bincount(sector, weights * off, sectors)
    filled = np.flatnonzero(weight > 0)
    filled = np.append(filled, filled[0])
    return (centre + shift / np.maximum(weight, 1e-300))[filled], load[filled] / weight[filled]


def draw(result: Result) -> Figure:
    """A round diagram for each bearing: means over the second half of the run by place."""
    style.apply()
    bearings = bearings_of(result)
    forces = result.column("normal_force")
    if not bearings or forces is None or result.column("position") is None:
        raise UsageError(f"{result.path} is no run of a scene with a group &bearing")
    rows = slice(len(result.time) // 2, None)
    figure, grid = plt.subplots(
        1,
        len(bearings),
        squeeze=False,
        figsize=(max(5.2 * len(bearings), 8.0), 5.6),
        subplot_kw={"projection": "polar"},
    )
    figure.subplots_adjust(top=0.78, bottom=0.06, left=0.07, right=0.93, wspace=0.3)
    for axes, (name, count) in zip(grid[0], bearings.items(), strict=True):
        angles = around(result, name, count, rows)
        for ring, colour in RINGS.items():
            for arc, line in (("", "-"), (ARCS[0], "-"), (ARCS[1], "--")):
                if f"{name}_{ring}{arc}_1" not in result.contacts:
                    continue
                at = [result.contacts.index(f"{name}_{ring}{arc}_{i + 1}") for i in range(count)]
                places, means = by_place(angles, forces[rows][:, at], result.time[rows], count)
                # What both rings carry is nearly the same: the inner one shows below.
                below = ring == "inner"
                axes.plot(
                    places,
                    means,
                    line,
                    color=colour,
                    marker="o",
                    markersize=6 if below else 3,
                    linewidth=3.2 if below else 1.2,
                    label=ring + arc.replace("_", ", "),
                )
        axes.set_rmin(0.0)
        axes.set_rlabel_position(22.5)
        axes.set_title(name, pad=18)
        axes.legend(loc="lower left", bbox_to_anchor=(-0.12, -0.1), fontsize=8.5)
    style.headline(
        figure,
        result.title,
        f"contensou {result.version} · loads of the balls [N], means from "
        f"{result.time[rows][0]:.4g} s to {result.time[-1]:.4g} s by place around the axis",
        alert=not result.complete,
    )
    return figure
