"""Panels of a run that show how bodies move: what varies, and nothing of what is at rest.

A component counts as varying when it changes by more than MOTION of the largest change of its kind,
so that noise is not spread over a panel. Up to MOST bodies have a line each; of more, those whose
names differ in their number alone are drawn as a band from the least to the largest with the median
in it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import partial

import numpy as np
from matplotlib.axes import Axes

from . import style
from .results import Result

MOST = 8
MOTION = 1e-6
COMPONENTS = ("x", "y", "z")


def groups(names: list[str], most: int = MOST) -> list[tuple[str, list[int]]]:
    """Names with their positions, one by one, or grouped by what they share if they are many."""
    if len(names) <= most:
        return [(name, [i]) for i, name in enumerate(names)]
    alike: dict[str, list[int]] = {}
    for i, name in enumerate(names):
        alike.setdefault(re.sub(r"\d+", "*", name), []).append(i)
    if len(alike) > most:
        return [(f"all {len(names)}", list(range(len(names))))]
    return [
        (names[at[0]] if len(at) == 1 else f"{stem} ({len(at)})", at) for stem, at in alike.items()
    ]


def curve(axes: Axes, time: np.ndarray, values: np.ndarray, label: str, **looks: object) -> None:
    """The line of one body, or the band of several: least, median and largest of columns."""
    if values.shape[1] == 1:
        axes.plot(time, values[:, 0], label=label, **looks)
        return
    # A spot without a place has no gap.
    values = np.ma.masked_invalid(values)
    axes.plot(time, np.ma.median(values, axis=1), label=f"{label}, median", **looks)
    axes.fill_between(
        time,
        values.min(axis=1),
        values.max(axis=1),
        color=looks["color"],
        alpha=0.2,
        linewidth=0,
        label="least to largest",
    )


def moving(values: np.ndarray, scale: float = 0.0) -> np.ndarray:
    """Which components (bodies, 3) of a vector (time, bodies, 3) vary, against all of them."""
    ranges = np.ptp(values, axis=0)
    return ranges > MOTION * max(ranges.max(initial=0), scale)


def scale_of_length(result: Result) -> float:
    """The length against which a change of a position is noise [m]."""
    position = result.column("position")
    return float(np.abs(position).max(initial=0))


def components_panels(
    result: Result, column: str, shown: np.ndarray, title: str, label: tuple[str, str, float]
) -> Iterator[tuple]:
    """Panels for the components of a vector, with their heights: one for all of a single body, or
    one for each component with all bodies."""
    symbol, unit, factor = label
    values = factor * result.column(column)
    single = len(result.bodies) == 1
    wanted = np.flatnonzero(shown.any(axis=0))

    def panel(axes: Axes, result: Result, k: int | None = None) -> None:
        if k is None:
            for c in wanted:
                axes.plot(result.time, values[:, 0, c], color=style.CYCLE[c], label=COMPONENTS[c])
            name = symbol or ", ".join(COMPONENTS[c] for c in wanted)
        else:
            for i, (label, at) in enumerate(groups(result.bodies)):
                if shown[at, k].any():
                    curve(axes, result.time, values[:, at, k], label, color=style.CYCLE[i])
            name = f"{symbol}$_{COMPONENTS[k]}$" if symbol else COMPONENTS[k]
        style.hold_scale(axes, np.abs(values).max())
        axes.set_title(title)
        axes.set_ylabel(f"{name} [{unit}]")
        style.legend_beside(axes)

    for k in [None] if single else wanted:
        yield partial(panel, k=k), 1.3 if single else 1.0


def position_panels(result: Result) -> Iterator[tuple]:
    """Where the centres of mass are: the components that vary."""
    position = result.column("position")
    if position is None:
        return
    shown = moving(position, scale_of_length(result))
    factor, unit = style.unit_for(scale_of_length(result), "m")
    yield from components_panels(
        result, "position", shown, "Position of the centre of mass", ("", unit, factor)
    )


def spin_panels(result: Result) -> Iterator[tuple]:
    """Angular velocities: about the vertical and its axis for a body that has one, else the
    components that are not zero."""
    values = result.column("angular_velocity")
    if values is None or not values.any():
        return
    if len(result.symmetric_bodies()) == len(result.bodies) <= MOST // 2:
        yield spin_panel, 1.3
        return
    largest = np.abs(values).max(axis=0)
    shown = largest > MOTION * largest.max()
    yield from components_panels(
        result, "angular_velocity", shown, "Angular velocity", ("ω", "rad/s", 1.0)
    )


def spin_panel(axes: Axes, result: Result) -> None:
    """Angular velocity about the vertical and about the body's axis."""
    vertical = result.column("angular_velocity")[:, :, 2]
    several = len(result.bodies) > 1
    for i, name in enumerate(result.bodies):
        colour = style.CYCLE[i if several else 0]
        prefix = f"{name}, " if several else ""
        axes.plot(result.time, vertical[:, i], color=colour, label=f"{prefix}about the vertical")
        axes.plot(
            result.time,
            result.axial_spin(i),
            color=colour if several else style.RED,
            linestyle=(0, (4, 1.5)) if several else "-",
            label=f"{prefix}about its axis",
        )
    axes.axhline(0, color=style.GREY, linewidth=0.8, zorder=1)
    style.hold_scale(axes, np.abs(result.column("angular_velocity")).max())
    axes.set_title("Angular velocity")
    axes.set_ylabel("ω [rad/s]")
    style.legend_beside(axes)


def inclination_panels(result: Result) -> Iterator[tuple]:
    """Angle between the axis and the vertical of the bodies that have one and tilt."""
    bodies = result.symmetric_bodies()
    if result.column("quaternion") is None or not 0 < len(bodies) <= MOST:
        return
    theta = np.degrees(np.stack([result.inclination(body) for body in bodies], axis=1))
    tilting = np.ptp(theta, axis=0) > MOTION * 180
    if not tilting.any():
        return

    def panel(axes: Axes, result: Result) -> None:
        for i, body in enumerate(bodies):
            if tilting[i]:
                name = result.bodies[body]
                axes.plot(result.time, theta[:, i], color=style.CYCLE[i], label=name)
        axes.set_title("Inclination of the body's axis")
        axes.set_ylabel("θ [°]")
        style.hold_scale(axes, 180)
        low, high = axes.get_ylim()
        if high - low > 60:
            axes.set_yticks(np.arange(0, 181, 45))
            axes.set_ylim(max(low, -8), min(high, 188))
        style.legend_beside(axes)

    yield panel, 1.3


def speed_panels(result: Result) -> Iterator[tuple]:
    """Speeds of the centres of mass."""
    velocity = result.column("velocity")
    if velocity is None or not velocity.any():
        return
    speed = np.linalg.norm(velocity, axis=2)
    factor, unit = style.unit_for(speed.max(), "m/s")

    def panel(axes: Axes, result: Result) -> None:
        for i, (label, at) in enumerate(groups(result.bodies)):
            if speed[:, at].max() > MOTION * speed.max():
                curve(axes, result.time, factor * speed[:, at], label, color=style.CYCLE[i])
        axes.set_title("Speed of the centre of mass")
        axes.set_ylabel(f"|v| [{unit}]")
        style.hold_scale(axes, factor * speed.max())
        style.legend_beside(axes)

    yield panel, 1.0


def path_plane(result: Result) -> tuple[int, int] | None:
    """The two components over which the path is drawn, or None if it is a line along one."""
    position = result.column("position")
    if position is None or not len(result.bodies):
        return None
    ranges = np.ptp(position, axis=0).max(axis=0)
    # A path a thousandth as wide as long is a line.
    wide = ranges > max(1e-3 * ranges.max(), MOTION * scale_of_length(result))
    if wide.sum() < 2:
        return None
    if wide[0] and wide[1]:
        return 0, 1
    return (0, 2) if wide[0] else (1, 2)


def path_panel(axes: Axes, result: Result) -> None:
    """Paths of the centres of mass, seen from above or from the side."""
    across, up = path_plane(result)
    position = result.column("position")
    factor, unit = style.unit_for(np.ptp(position, axis=0).max(initial=0), "m")
    position = factor * position
    travel = np.ptp(position, axis=0).max(axis=1)
    many = len(result.bodies) > MOST
    for i, name in enumerate(result.bodies):
        if travel[i] <= MOTION * travel.max():
            continue
        colour = style.DARK if many else style.CYCLE[i]
        path = position[:, i]
        axes.plot(
            path[:, across],
            path[:, up],
            color=colour,
            linewidth=0.6 if many else 1.3,
            alpha=0.5 if many else 1.0,
            label=None if many else name,
        )
        axes.plot(path[0, across], path[0, up], "o", color=colour, markersize=4, zorder=4)
    axes.plot([], [], "o", color=style.GREY, markersize=4, label="start")
    if many:
        axes.plot([], [], color=style.DARK, linewidth=0.6, label=f"{(travel > 0).sum()} bodies")
    axes.set_title("Path, seen from above" if up == 1 else "Path, seen from the side")
    axes.set_xlabel(f"{COMPONENTS[across]} [{unit}]")
    axes.set_ylabel(f"{COMPONENTS[up]} [{unit}]")
    axes.set_aspect("equal", adjustable="datalim")
    style.legend_beside(axes)
