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


def around(result: Result, name: str, count: int, rows: slice) -> tuple[np.ndarray, np.ndarray]:
    """Mean places of the balls and the plane in which they lie: (balls, 3) and two axes."""
    balls = [result.bodies.index(f"{name}_ball_{i + 1}") for i in range(count)]
    places = result.column("position")[rows][-1, balls]
    arms = places - places.mean(axis=0)
    _, _, axes = np.linalg.svd(arms)
    # The first axis points as nearly along x as it can, or y, as nobody knows the other one.
    normal = axes[2] * np.sign(axes[2][np.argmax(np.abs(axes[2]))])
    seed = np.eye(3)[0 if abs(normal[0]) < 0.9 else 1]
    first = seed - seed @ normal * normal
    first /= np.linalg.norm(first)
    return arms, np.stack([first, np.cross(normal, first)])


def draw(result: Result) -> Figure:
    """A round diagram for each bearing: means over the second half of the run."""
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
        arms, plane = around(result, name, count, rows)
        angles = np.arctan2(arms @ plane[1], arms @ plane[0])
        order = np.argsort(angles)
        order = np.append(order, order[0])
        for ring, colour in RINGS.items():
            for arc, line in (("", "-"), (ARCS[0], "-"), (ARCS[1], "--")):
                if f"{name}_{ring}{arc}_1" not in result.contacts:
                    continue
                at = [result.contacts.index(f"{name}_{ring}{arc}_{i + 1}") for i in range(count)]
                means = forces[rows][:, at].mean(axis=0)
                axes.plot(
                    angles[order],
                    means[order],
                    line,
                    color=colour,
                    marker="o",
                    markersize=4,
                    linewidth=1.3,
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
        f"{result.time[rows][0]:.4g} s to {result.time[-1]:.4g} s, at their places at the end",
        alert=not result.complete,
    )
    return figure
