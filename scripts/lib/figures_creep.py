"""Pictures of the laws of creep: force and torque over creepage, and what sticks of a spot."""

from __future__ import annotations

import csv
import io
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Ellipse

from . import bristles, program, style

COLUMNS = "N,a,b,f,G,nu,vx,vy,w,cx,cy"

# Steel: N [N], a, b [m], f, G [Pa], nu; it rolls along x by 1 m/s.
SPOT = (1.0e3, 1.2e-3, 0.8e-3, 0.3, 8.0e10, 0.3)
ROLLS = (-1.0, 0.0)

LAWS = {
    "table": (style.RED, "-"),
    "brush": (style.BLUE, "-"),
    "fastsim": (style.GREEN, "-"),
    "strip": (style.ORANGE, "-"),
    "linear": (style.GREY, "--"),
    "sliding": (style.DARK, ":"),
}
EXACT = "boundary_elements"

SPINS = (0.0, 0.5, 2.0)

# Creepages along, across, and spins, in e0 and e0/sqrt(a b), of the spots that are drawn.
STATES = ((0.5, 0.0, 0.0), (0.0, 0.5, 0.0), (0.0, 0.0, 1.0), (0.5, -0.5, 1.0))

# Places across a spot of what sticks, and arrows.
PLACES, ARROWS = 301, 11

SOURCE = "Steel, a/b = 1.5, rolling along a; from contensou eval creep."


def wrenches(law: str, creepages: np.ndarray) -> np.ndarray:
    """Force over f N and torque over f N sqrt(a b), of creepages in e0, e0/sqrt(a b)."""
    load, a, b, f, modulus, _ = SPOT
    root = np.sqrt(a * b)
    slip = creepages * 1.5 * f * load / (np.pi * a * b * modulus) / [1, 1, root]
    rows = [",".join(map(repr, map(float, (*SPOT, *row, *ROLLS)))) for row in slip]
    answer = program.call("eval", "creep", "--model", law, text="\n".join([COLUMNS, *rows, ""]))
    found = [
        [float(row[name]) for name in ("Fx", "Fy", "Tz")]
        for row in csv.DictReader(io.StringIO(answer))
    ]
    return np.array(found) / (f * load * np.array([1, 1, root]))


def creep_curves(path: Path) -> None:
    """Forces against creepage along and across, and the torque, with spins."""
    figure, grid = plt.subplots(
        3, len(SPINS), figsize=(10, 7.6), sharex=True, sharey="row", layout="constrained"
    )
    x = np.linspace(0, 3, 121)
    few = x[::20]
    for column, spin in zip(grid.T, SPINS, strict=True):
        column[0].set_title(f"spin {spin:g} e₀/√(ab)")
        for law, (colour, dashes) in LAWS.items():
            along, across = (wrenches(law, on(x, axis, spin)) for axis in (0, 1))
            for axes, values in zip(
                column, (-along[:, 0], -across[:, 1], -across[:, 2]), strict=True
            ):
                axes.plot(x, values, dashes, color=colour, linewidth=1.3)
        along, across = (wrenches(EXACT, on(few, axis, spin)) for axis in (0, 1))
        for axes, values in zip(column, (-along[:, 0], -across[:, 1], -across[:, 2]), strict=True):
            axes.plot(few, values, "o", color="black", markersize=4, zorder=5)
    for axes, limits, name in zip(
        grid[:, 0],
        ((-0.05, 1.1), (-0.35, 1.1), (-0.2, 0.75)),
        ("−Fx/(f N), creepage ξ", "−Fy/(f N), creepage η", "−T/(f N √(ab)), creepage η"),
        strict=True,
    ):
        axes.set_ylim(*limits)
        axes.set_ylabel(name)
    for axes in grid[-1]:
        axes.set_xlabel("creepage [e₀]")
    handles = [Line2D([], [], color=c, linestyle=d, label=law) for law, (c, d) in LAWS.items()]
    handles.append(Line2D([], [], color="black", marker="o", linestyle="", label=EXACT))
    figure.legend(handles=handles, loc="outside lower center", ncols=7, frameon=False)
    figure.suptitle(f"Creep with spin. {SOURCE}", x=0.01, ha="left")
    style.save(figure, path)


def on(values: np.ndarray, axis: int, spin: float) -> np.ndarray:
    """Creepages along (0) or across (1) the rolling, with a spin."""
    states = np.zeros((len(values), 3))
    states[:, axis] = values
    states[:, 2] = spin
    return states


def creep_zones(path: Path) -> None:
    """What of a spot sticks, and its tractions: of bristles that come nearest to the wrench."""
    figure, grid = plt.subplots(2, 2, figsize=(10, 6.2), layout="constrained")
    for axes, state in zip(grid.flat, STATES, strict=True):
        zone(axes, state)
    grid[1, 0].set_xlabel("x [mm]")
    grid[1, 1].set_xlabel("x [mm]")
    for axes in grid[:, 0]:
        axes.set_ylabel("y [mm]")
    figure.suptitle(
        "Zones of stick (hatched) and of slip, with the tractions on body 1. " + SOURCE,
        x=0.01,
        ha="left",
    )
    style.save(figure, path)


def zone(axes: Axes, state: tuple[float, float, float]) -> None:
    """One spot: material enters on the right."""
    load, a, b, f, _, _ = SPOT
    root = np.sqrt(a * b)
    found = wrenches("table", np.array([state]))[0]
    names = ("N", "a", "b", "f", "vx", "vy", "w", "cx", "cy")
    slip = np.array(state) / [1, 1, root]
    spot = dict(zip(names, (load, a, b, f, *slip, *ROLLS), strict=True))
    field = bristles.field(spot, found * f * load * np.array([1, 1, root]))
    x, y = np.meshgrid(np.linspace(-1, 1, PLACES), np.linspace(-1, 1, PLACES))
    inside = x**2 + y**2 < 1
    sticks = inside & field(x, y)[2]
    place = (1e3 * a * x, 1e3 * b * y)
    axes.contourf(*place, inside.astype(float), [0.5, 2], colors=["#fbe6d2"])
    plt.rcParams["hatch.color"] = style.GREEN
    axes.contourf(*place, sticks.astype(float), [0.5, 2], colors="none", hatches=["///"])
    axes.add_patch(Ellipse((0, 0), 2e3 * a, 2e3 * b, fill=False, color="black", lw=1.2))
    steps = np.linspace(-1, 1, 2 * ARROWS + 1)[1::2]
    px, py = (values.ravel() for values in np.meshgrid(steps, steps))
    keep = px**2 + py**2 < 0.97
    px, py = px[keep], py[keep]
    tx, ty, _ = field(px, py)
    axes.quiver(
        1e3 * a * px, 1e3 * b * py, tx, ty, color=style.DARK, scale=1.6 * ARROWS, width=0.004
    )
    axes.annotate(
        "rolls",
        (1.42e3 * a, 0),
        (1.12e3 * a, 0),
        arrowprops={"arrowstyle": "->", "color": style.BLUE},
        color=style.BLUE,
        va="center",
    )
    share = sticks.sum() / inside.sum()
    xi, eta, phi = state
    axes.set_title(
        f"ξ = {xi:g}, η = {eta:g}, φ = {phi:g}: sticks in {share:.2f} of the spot", fontsize=10
    )
    axes.set(aspect="equal", xlim=(-1.15e3 * a, 1.6e3 * a), ylim=(-1.15e3 * b, 1.15e3 * b))


PICTURES = {"creep_curves": creep_curves, "creep_zones": creep_zones}


def draw(folder: Path, wanted: list[str]) -> list[Path]:
    """Draw the pictures into the folder."""
    pictures = []
    for name, drawing in PICTURES.items():
        print(f"figures: evaluating {name}", file=sys.stderr)
        pictures.append(folder / f"{name}.png")
        drawing(pictures[-1])
    return pictures
