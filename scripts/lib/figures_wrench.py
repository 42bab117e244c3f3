"""Figures 2 and 3 of Kosenko and Aleksandrov (2009): friction force and torque of each model.

Both are drawn over u = v/(a |w|), the ratio of sliding to spinning, for spots of different
eccentricity and several directions of sliding, with one evaluation of all states per model.
"""

from __future__ import annotations

import io
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from . import program, style

SOURCE = (
    "After Kosenko and Aleksandrov (2009), doi 10.3384/ecp09430006; from contensou eval wrench. "
    "Grey: the rotation centre is inside the spot."
)

# Parameter c = 1 - (b/a)^2 of the spots, directions of sliding from the major axis [degrees].
PARAMETERS = (0.0, 0.687, 0.95)
DIRECTIONS = (0, 30, 60, 90)

EXACT = "contensou_exact"

U_MAX = 3.0
U = np.linspace(0.0, U_MAX, 301)


def evaluate() -> dict[str, np.ndarray]:
    """Force along -v, force across v, torque against the spin: (spot, direction, u, component)."""
    c, psi, u = np.meshgrid(PARAMETERS, np.radians(DIRECTIONS), U, indexing="ij")
    cos, sin = np.cos(psi), np.sin(psi)
    one = np.ones_like(u)
    table = np.stack([one, one, np.sqrt(1 - c), one, u * cos, u * sin, one], axis=-1)
    text = io.StringIO()
    np.savetxt(
        text,
        table.reshape(-1, 7),
        fmt="%.17g",
        delimiter=",",
        header="N,a,b,f,vx,vy,w",
        comments="",
    )
    found = {}
    for model in style.MODELS:
        answer = program.call("eval", "wrench", "--model", model, text=text.getvalue())
        rows = np.loadtxt(io.StringIO(answer), delimiter=",", skiprows=1)
        fx, fy, torque = np.moveaxis(rows[:, -3:].reshape(*u.shape, 3), -1, 0)
        found[model] = np.stack([-fx * cos - fy * sin, fx * sin - fy * cos, -torque], axis=-1)
    return found


def grid_of_panels(title: str) -> tuple[Figure, np.ndarray]:
    """One row of panels for each spot, one column for each direction."""
    figure, grid = plt.subplots(
        len(PARAMETERS),
        len(DIRECTIONS),
        sharex=True,
        sharey=True,
        figsize=(12.5, 8.6),
        gridspec_kw={
            "left": 0.095,
            "right": 0.985,
            "top": 0.845,
            "bottom": 0.065,
            "hspace": 0.1,
            "wspace": 0.06,
        },
    )
    for row, c in zip(grid, PARAMETERS, strict=True):
        ratio = np.sqrt(1 - c)
        row[0].annotate(
            f"$c$ = {c:g}" + (", circle" if c == 0 else f", $b/a$ = {ratio:.2f}"),
            (-0.275, 0.5),
            xycoords="axes fraction",
            rotation=90,
            va="center",
            ha="right",
            fontsize=10,
            fontweight="bold",
        )
    for axes, direction in zip(grid[0], DIRECTIONS, strict=True):
        along = {0: ", along the major axis", 90: ", along the minor axis"}.get(direction, "")
        axes.set_title(f"ψ = {direction}°{along}")
    for i, j in np.ndindex(grid.shape):
        c, psi = PARAMETERS[i], np.radians(DIRECTIONS[j])
        rim = np.sqrt((1 - c) / (np.cos(psi) ** 2 + (1 - c) * np.sin(psi) ** 2))
        grid[i, j].axvspan(0, rim, color=style.LIGHT, alpha=0.5, linewidth=0, zorder=0)
    for axes in grid[-1]:
        axes.set_xticks(np.arange(0, U_MAX + 0.5))
        axes.set_xlabel("$u = v/(a|ω|)$")
    style.headline(figure, title, SOURCE)
    return figure, grid


def draw_curves(grid: np.ndarray, found: dict[str, np.ndarray], component: int) -> list[Line2D]:
    """Draw a component for every model, the exact one last; return handles for a legend."""
    handles = []
    for model, (colour, name) in reversed(style.MODELS.items()):
        line = {"color": colour, "linewidth": 2.2 if model == EXACT else 1.2}
        for i, j in np.ndindex(grid.shape):
            grid[i, j].plot(U, found[model][i, j, :, component], **line)
        handles.insert(0, Line2D([], [], label=name, **line))
    return handles


def figure_2(found: dict[str, np.ndarray], path: Path) -> None:
    """Force along and, for the exact model, across the direction of sliding."""
    figure, grid = grid_of_panels("Figure 2: friction force over the ratio of sliding to spinning")
    handles = draw_curves(grid, found, 0)
    colour, name = style.MODELS[EXACT]
    across = {"color": colour, "linewidth": 1.4, "linestyle": (0, (2, 1.2))}
    for i, j in np.ndindex(grid.shape):
        force = found[EXACT][i, j, :, 1]
        if np.abs(force).max() > 1e-3:
            grid[i, j].plot(U, force, **across)
    handles.append(Line2D([], [], label=f"{name}, force across $v$", **across))
    grid[0, 0].set_xlim(0, U_MAX)
    grid[0, 0].set_ylim(-0.23, 1.06)
    grid[0, 0].set_yticks(np.arange(-0.2, 1.1, 0.2))
    for axes in grid[:, 0]:
        axes.set_ylabel("force against $v$  [$fN$]")
    figure.legend(handles=handles, loc="upper left", bbox_to_anchor=(0.085, 0.925), ncols=5)
    style.save(figure, path)


def figure_3(found: dict[str, np.ndarray], path: Path) -> None:
    """Torque against the spin."""
    figure, grid = grid_of_panels("Figure 3: friction torque over the ratio of sliding to spinning")
    handles = draw_curves(grid, found, 2)
    grid[0, 0].set_xlim(0, U_MAX)
    grid[0, 0].set_ylim(0, 0.63)
    for axes in grid[:, 0]:
        axes.set_ylabel("torque against $ω$  [$fNa$]")
    figure.legend(handles=handles, loc="upper left", bbox_to_anchor=(0.085, 0.925), ncols=5)
    style.save(figure, path)


def draw(folder: Path, wanted: list[str]) -> list[Path]:
    """Evaluate and draw the wanted ones of the figures 2 and 3 into the folder."""
    found = evaluate()
    pictures = []
    for number, drawing in (("2", figure_2), ("3", figure_3)):
        if number in wanted:
            pictures.append(folder / f"figure_{number}.png")
            drawing(found, pictures[-1])
    return pictures
