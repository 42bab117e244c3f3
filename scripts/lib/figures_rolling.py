"""Pictures of the scenes that roll: with a law of creep, and as if the whole spot slid."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np

from . import program, style
from .figures_top import run
from .results import Result

EXAMPLES = program.ROOT / "inputs" / "examples"

SPEEDS = {40.0: style.BLUE, 60.0: style.RED}
LAWS = {"rolling": (style.RED, "rolls by a law of creep"), "none": (style.BLUE, "slides")}


# Lines of the contacts of a ball with the races.
RACES = {"inner": "-", "outer": "--"}


def both(name: str, contact: str, place: Path) -> dict[str, Result]:
    """Runs of an example with a law of creep and with sliding alone."""
    return {
        law: run(
            EXAMPLES / f"{name}.nml",
            place / f"{law}.h5",
            **{f"{contact}__tangential": law},
        )
        for law in LAWS
    }


def rolling_wheelset(path: Path, place: Path) -> None:
    """Lateral displacement and yaw over the way, below and above the critical speed."""
    figure, (side, yaw) = panels([1.6, 1.2])
    for speed, colour in SPEEDS.items():
        values = {"constants__speed": speed, "scene__t_end": 240 / speed}
        result = run(EXAMPLES / "wheelset.nml", place / f"{speed}.h5", **values)
        x, y, _ = result.column("position")[:, 0].T
        turned = result.column("quaternion")[:, 0]
        w, a, b, c = turned.T
        angle = np.arcsin(2 * (w * c - a * b))
        side.plot(x, 1e3 * y, color=colour, linewidth=1.2, label=f"{speed:g} m/s")
        yaw.plot(x, 1e3 * angle, color=colour, linewidth=1.2, label=f"{speed:g} m/s")
    label(side, "Displacement of the wheelset to the left", "y [mm]")
    label(yaw, "Yaw", "ψ [mrad]", "way [m]")
    style.headline(figure, "A wheelset hunts", "inputs/examples/wheelset.nml")
    style.save(figure, path)


def rolling_bend(path: Path, place: Path) -> None:
    """The path of the ball, and its spin."""
    figure, (way, spin) = panels([1.6, 1.2])
    for law, result in both("rolling_bend", "foot", place).items():
        colour, name = LAWS[law]
        x, y, _ = result.column("position")[:, 0].T
        way.plot(x, 1e3 * y, color=colour, label=name)
        spin.plot(x, result.column("angular_velocity")[:, 0, 2], color=colour, label=name)
    label(way, "Path, seen from above", "y [mm]")
    label(spin, "Spin about the vertical", "ω [rad/s]", "x [m]")
    style.headline(figure, "A ball rolls round a bend", "inputs/examples/rolling_bend.nml")
    style.save(figure, path)


def bowling_hook(path: Path, place: Path) -> None:
    """The path of the bowling ball, and the friction force across it."""
    figure, (way, force) = panels([1.6, 1.2])
    for law, result in both("bowling_hook", "spot", place).items():
        colour, name = LAWS[law]
        x, y, _ = result.column("position")[:, 0].T
        way.plot(x, y, color=colour, label=name)
        force.plot(x, result.column("friction_force")[:, 0, 1], color=colour, label=name)
    label(way, "Path, seen from above", "y [m]")
    label(force, "Friction across the lane", "F [N]", "x [m]")
    style.headline(figure, "A bowling ball hooks", "inputs/examples/bowling_hook.nml")
    style.save(figure, path)


def euler_disc(path: Path, place: Path) -> None:
    """Inclination and energy of the disc."""
    figure, (tilt, lost) = panels([1.6, 1.2])
    for law, result in both("euler_disc", "rim", place).items():
        colour, name = LAWS[law]
        tilt.plot(result.time, np.degrees(result.inclination(0)), color=colour, label=name)
        lost.plot(result.time, 1e3 * result.column("work_friction"), color=colour, label=name)
    label(tilt, "Inclination", "θ [°]")
    label(lost, "Lost in friction", "W [mJ]", "time [s]")
    style.headline(figure, "Euler's disc", "inputs/examples/euler_disc.nml")
    style.save(figure, path)


def rolling_bearing(path: Path, place: Path) -> None:
    """Friction moment of the bearing, and pivoting of a ball."""
    figure, (moment, pivot) = panels([1.6, 1.2])
    scenes = {
        "rolling": EXAMPLES / "bearing_6205_rolling.nml",
        "none": program.ROOT / "inputs" / "bearing_6205.nml",
    }
    for law, scene in scenes.items():
        colour, name = LAWS[law]
        result = run(scene, place / f"{law}.h5")
        torque = result.column("drive_torque")[:, :, 2]
        driven = np.abs(torque).sum(axis=0).argmax()
        moment.plot(result.time, 1e3 * torque[:, driven], color=colour, label=name)
        for race, dashes in RACES.items():
            spin = result.column("spin")[:, result.contacts.index(f"bearing_{race}_1")]
            pivot.plot(result.time, np.abs(spin), dashes, color=colour, label=f"{name}, {race}")
    label(moment, "Moment that the inner ring takes", "M [mN m]")
    label(pivot, "Pivoting of a ball on the races", "|ω| [rad/s]", "time [s]")
    style.headline(figure, "The bearing 6205 rolls", "inputs/examples/bearing_6205_rolling.nml")
    style.save(figure, path)


def panels(heights: list[float]) -> tuple:
    """A figure with panels one above the other."""
    figure, grid = style.panels(heights)
    return figure, grid[:, 0]


def label(axes: object, title: str, values: str, over: str = "") -> None:
    """Title, label and legend of a panel."""
    axes.set_title(title)
    axes.set_ylabel(values)
    if over:
        axes.set_xlabel(over)
    axes.yaxis.set_label_coords(-0.08, 0.5)
    style.legend_beside(axes)


PICTURES = {
    "rolling_wheelset": rolling_wheelset,
    "rolling_bend": rolling_bend,
    "bowling_hook": bowling_hook,
    "euler_disc": euler_disc,
    "rolling_bearing": rolling_bearing,
}


def draw(folder: Path, wanted: list[str]) -> list[Path]:
    """Run what is needed and draw the pictures into the folder."""
    pictures = []
    for name, drawing in PICTURES.items():
        print(f"figures: running {name}", file=sys.stderr)
        with tempfile.TemporaryDirectory(prefix="contensou-") as place:
            pictures.append(folder / f"{name}.png")
            drawing(pictures[-1], Path(place))
    return pictures
