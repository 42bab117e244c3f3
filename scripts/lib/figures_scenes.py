"""Pictures of shipped scenes: the rattleback that turns back, and the egg that rises."""

from __future__ import annotations

import re
import sys
import tempfile
from pathlib import Path

import numpy as np

from . import program, style
from .figures_top import run
from .results import Result

INPUTS = program.ROOT / "inputs"

# Steel, and how many times as stiff; the last is what the scene has.
STIFFNESSES = {2.1e11: (style.ORANGE, "steel"), 2.1e14: (style.RED, "1000 times as stiff")}

# Principal moments of the egg [kg m2]: across and along its axis.
ACROSS, ALONG = 1.56e-5, 9.6e-6


def rattleback(path: Path, place: Path) -> None:
    """Angular velocity about the vertical, spun either way, for two stiffnesses; the energies."""
    figure, grid = style.panels([2.2, 1.6])
    spin, energy = grid[:, 0]
    scene = INPUTS / "rattleback.nml"
    for young, (colour, name) in STIFFNESSES.items():
        result = run(scene, place / "stone.h5", hard__young=young)
        spin.plot(result.time, vertical(result), color=colour, linewidth=1.2, label=name)
    factor, unit = style.unit_for(result.initial_energy(), "J")
    for term, values in result.energies().items():
        if term in ("kinetic", "potential", "work of friction"):
            energy.plot(
                result.time,
                factor * values,
                color=style.ENERGY_COLOURS[term],
                linewidth=0.9,
                label=term,
            )
    mirrored = place / "other.nml"
    mirrored.write_text(backwards(scene.read_text(encoding="utf-8")), encoding="utf-8")
    other = run(mirrored, place / "other.h5")
    spin.plot(other.time, vertical(other), color=style.BLUE, linewidth=1.2, label="the other way")
    spin.axhline(0, color=style.GREY, linewidth=0.8, zorder=1)
    spin.set_title("Angular velocity about the vertical")
    spin.set_ylabel("ω [rad/s]")
    energy.set_title("Changes of the energies, 1000 times as stiff as steel")
    energy.set_ylabel(f"change [{unit}]")
    energy.set_xlabel("time [s]")
    energy.set_xlim(0, result.time[-1])
    for axes in (spin, energy):
        axes.yaxis.set_label_coords(-0.07, 0.5)
        style.legend_beside(axes)
    style.headline(figure, "A rattleback turns back", "inputs/rattleback.nml")
    style.save(figure, path)


def backwards(scene: str) -> str:
    """A scene whose bodies start the other way."""

    def negated(match: re.Match) -> str:
        return match[1] + ", ".join(repr(-float(word)) for word in match[2].split(","))

    return re.sub(r"(?m)^( +(?:velocity|spin) = )(.+)$", negated, scene)


def vertical(result: Result) -> np.ndarray:
    """Angular velocity of the first body about the vertical [rad/s]."""
    return result.column("angular_velocity")[:, 0, 2]


def egg(path: Path, place: Path) -> None:
    """Inclination of the long axis, gap with its jumps, and the number of Jellett."""
    result = run(INPUTS / "ellipsoid_egg.nml", place / "egg.h5", scene__t_end=2.0)
    figure, grid = style.panels([1.7, 1.7, 1.2])
    tilt, gap, jellett = grid[:, 0]
    tilt.plot(result.time, np.degrees(result.inclination(0)), color=style.RED)
    tilt.set_yticks(np.arange(0, 91, 30))
    tilt.set_ylabel("θ [°]")
    tilt.set_title("Angle between the long axis and the vertical")
    gap.plot(result.time, result.column("gap")[:, 0], color=style.BLUE, linewidth=1.2)
    style.gap_axis(gap, result.column("gap"))
    gap.set_ylabel("gap")
    gap.set_title("Gap between egg and floor (grey: overlap)")
    momentum = ACROSS * vertical(result) + (ALONG - ACROSS) * result.axial_spin(0) * np.cos(
        result.inclination(0)
    )
    number = momentum * result.column("position")[:, 0, 2]
    jellett.plot(result.time, number / number[0], color=style.GREEN)
    jellett.set_ylim(0.8, 1.2)
    jellett.set_ylabel("J / J₀")
    jellett.set_title("Jellett number: vertical angular momentum times height")
    jellett.set_xlabel("time [s]")
    jellett.set_xlim(0, result.time[-1])
    for axes in (tilt, gap, jellett):
        axes.yaxis.set_label_coords(-0.07, 0.5)
    style.headline(figure, "A spinning egg rises", "inputs/ellipsoid_egg.nml")
    style.save(figure, path)


def draw(folder: Path, wanted: list[str]) -> list[Path]:
    """Run what is needed and draw the wanted pictures into the folder."""
    pictures = []
    for name in wanted:
        print(f"figures: running {name}", file=sys.stderr)
        with tempfile.TemporaryDirectory(prefix="contensou-") as place:
            pictures.append(folder / f"{name}.png")
            {"rattleback": rattleback, "egg": egg}[name](pictures[-1], Path(place))
    return pictures
