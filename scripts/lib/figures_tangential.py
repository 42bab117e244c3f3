"""Pictures of tangential elasticity: an impact, an incline, a spot sheared to and fro, a dish."""

from __future__ import annotations

import csv
import io
import itertools
import sys
import tempfile
from pathlib import Path

import h5py
import numpy as np

from lib import program, style
from lib.figures_top import run

INPUTS = program.ROOT / "inputs" / "examples"
SWEEP = program.ROOT / "inputs" / "sweeps" / "impact_angle.nml"
MEASURED = program.ROOT / "tests" / "reference" / "impact_kharaz.csv"
SPEED = 3.9

# Models of tangential elasticity, and how they are drawn.
MODELS = {
    "elastic": (style.RED, "elastic", "-"),
    "spring": (style.ORANGE, "spring", "--"),
    "none": (style.GREY, "none", "-"),
}

# Slopes of the incline, f = 0.3.
SLOPES = {
    0.2: (style.GREEN, "slope 0.2"),
    0.3: (style.BLUE, "slope 0.3"),
    0.31: (style.RED, "slope 0.31"),
}


def measured(quantity: str) -> np.ndarray:
    """Angles [degrees] and measured values."""
    with open(MEASURED, encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["quantity"] == quantity]
    return np.array([(float(row["angle_deg"]), float(row["measured"])) for row in rows]).T


def impact(path: Path, place: Path) -> None:
    """Tangential restitution and spin after the impact over its angle, and what was measured."""
    figure, grid = style.panels([1.6, 1.6])
    restitution, spin = grid[:, 0]
    table = place / "impact_angle.h5"
    program.call("sweep", SWEEP, "-o", table, "-q")
    with h5py.File(table) as file:
        models = file["parameters/skin_plate.tangential"].asstr()[:]
        angles = file["parameters/angle"][()]
        velocity = file["results/velocity"][()]
        spins = np.abs(file["results/spin"][()])
    for model, (colour, label, line) in MODELS.items():
        of = models == model
        for axes, numbers in ((restitution, velocity / (SPEED * np.sin(angles))), (spin, spins)):
            axes.plot(np.degrees(angles[of]), numbers[of], line, color=colour, label=label)
    for axes, quantity in (
        (restitution, "tangential_restitution"),
        (spin, "rebound_spin_rad_per_s"),
    ):
        axes.plot(*measured(quantity), "o", color=style.DARK, label="measured", zorder=5)
        axes.yaxis.set_label_coords(-0.07, 0.5)
        axes.set_ylim(bottom=0)
        style.legend_beside(axes)
    restitution.set_title("Tangential velocity of the centre, after over before")
    restitution.set_ylim(0.5, 1.0)
    spin.set_title("Spin after the impact")
    spin.set_ylabel("ω [rad/s]")
    spin.set_xlabel("angle of the impact from the normal [°]")
    spin.set_xlim(0, np.degrees(angles.max()))
    style.headline(
        figure,
        "Oblique impact of a ball of alumina on glass",
        "inputs/sweeps/impact_angle.nml; measured: Kharaz, Gorham, Salman (2001)",
    )
    style.save(figure, path)


def incline(path: Path, place: Path) -> None:
    """Way of a stool below, at and above the limit of friction, and how it would creep."""
    figure, grid = style.panels([2.0, 1.6])
    way, detail = grid[:, 0]
    scene = INPUTS / "incline.nml"
    rigid = place / "rigid.nml"
    text = scene.read_text(encoding="utf-8")
    rigid.write_text(text.replace("'elastic'", "'none'"), encoding="utf-8")
    for slope, (colour, label) in SLOPES.items():
        held = run(scene, place / "held.h5", constants__slope=slope)
        free = run(rigid, place / "free.h5", constants__slope=slope)
        for result, line in ((held, "-"), (free, ":")):
            shift = np.abs(result.column("position")[:, 0, 0])
            name = label if line == "-" else None
            way.plot(result.time[1:], shift[1:], line, color=colour, label=name)
            if abs(slope - 0.2) < 1e-9:
                name = "elastic" if line == "-" else "none"
                detail.plot(result.time, 1e9 * shift, line, color=colour, label=name)
    way.set_yscale("log")
    way.set_ylabel("way [m]")
    way.set_title("Way down the incline, f = 0.3; dotted: without tangential elasticity")
    detail.set_ylabel("way [nm]")
    detail.set_title("The same at the slope 0.2")
    detail.set_xlabel("time [s]")
    detail.set_xlim(0, held.time[-1])
    for axes in (way, detail):
        axes.yaxis.set_label_coords(-0.07, 0.5)
        style.legend_beside(axes)
    style.headline(figure, "What sticks, holds", "inputs/examples/incline.nml")
    style.save(figure, path)


def cattaneo(path: Path, place: Path) -> None:
    """Loops of force and shift at constant load: of a run, and without and with a twist held."""
    figure, grid = style.panels([2.2, 2.6])
    swing, loop = grid[:, 0]
    result = run(INPUTS / "cattaneo.nml", place / "cattaneo.h5")
    axis = result.column("tangential_axis")[0, 0]
    limit = 0.3 * result.column("normal_force")[0, 0]
    bearing = -result.column("friction_force")[:, 0] @ axis / limit
    # Steel on steel; the radius of its spot does not change.
    stiffness = 4 * (2.1e11 / 2.6) * result.column("semi_axes")[0, 0, 0] / 1.7
    swing.plot(result.column("shift_along")[:, 0] * stiffness / (1.5 * limit), bearing)
    swing.set_ylabel("F/(f N)")
    swing.set_title("inputs/examples/cattaneo.nml: pulled to and fro by a carriage")
    swing.yaxis.set_label_coords(-0.07, 0.5)
    loop.yaxis.set_label_coords(-0.07, 0.5)
    load, a, f, g, nu = 2.0, 1e-3, 0.3, 8e10, 0.3
    unit = 1.5 * f * load * (2 - nu) / (4 * g * a)
    corners = [0.0, 1.1, -0.4, 0.4, -1.1, 1.1]
    places = np.concatenate([np.linspace(p, q, 60)[1:] for p, q in itertools.pairwise(corners)])
    cases = (
        (0.0, "shells", style.RED, "-", "elastic"),
        (0.5, "shells", style.BLUE, "-", "elastic, twisted"),
        (0.0, "spring", style.ORANGE, "--", "spring"),
    )
    for twist, model, colour, line, label in cases:
        rows = [(load, a, a, f, g, nu, x * unit, 0, twist * unit / a) for x in places]
        rows.insert(0, (load, a, a, f, g, nu, 0, 0, twist * unit / a))
        text = "N,a,b,f,G,nu,dx,dy,twist\n"
        text += "".join(",".join(repr(float(x)) for x in row) + "\n" for row in rows)
        answer = program.call("eval", "tangential", "--model", model, text=text)
        table = np.loadtxt(io.StringIO(answer), delimiter=",", skiprows=1)
        loop.plot(table[:, 6] / unit, -table[:, 9] / (f * load), line, color=colour, label=label)
    loop.set_xlabel("shift over that at which it slides")
    loop.set_ylabel("F/(f N)")
    loop.set_title("Force against the shift, to and fro at constant load")
    style.legend_beside(loop)
    title = "Hysteresis of a spot that slips from its rim"
    style.headline(figure, title, "contensou run, contensou eval tangential")
    style.save(figure, path)


def dish(path: Path, place: Path) -> None:
    """Place of a ball that rocks in a dish, and the share of its spot that sticks."""
    figure, grid = style.panels([2.0, 1.2])
    way, share = grid[:, 0]
    result = run(INPUTS / "dish.nml", place / "dish.h5")
    way.plot(result.time, 1e3 * result.column("position")[:, 0, 0], color=style.BLUE)
    way.set_ylabel("x [mm]")
    way.set_title("Place of the ball")
    late = result.time > 4.9
    inset = way.inset_axes([0.72, 0.62, 0.26, 0.34])
    inset.plot(result.time[late], 1e3 * result.column("position")[late, 0, 0], color=style.BLUE)
    inset.axhline(0.0, color=style.GREY, linewidth=0.8)
    share.plot(result.time, result.column("stuck_share")[:, 0], color=style.GREEN)
    share.set_ylim(0, 1.05)
    share.set_title("Share of the spot that sticks in a step")
    share.set_xlabel("time [s]")
    share.set_xlim(0, result.time[-1])
    for axes in (way, share):
        axes.yaxis.set_label_coords(-0.07, 0.5)
    style.headline(figure, "A ball rocks in a dish until it sticks", "inputs/examples/dish.nml")
    style.save(figure, path)


DRAWINGS = {"impact": impact, "incline": incline, "cattaneo": cattaneo, "dish": dish}


def draw(folder: Path, wanted: list[str]) -> list[Path]:
    """Run what is needed and draw the wanted pictures into the folder."""
    pictures = []
    for name in wanted:
        print(f"figures: running {name}", file=sys.stderr)
        with tempfile.TemporaryDirectory(prefix="contensou-") as place:
            pictures.append(folder / f"{name}.png")
            drawing = DRAWINGS[name]
            drawing(pictures[-1], Path(place))
    return pictures
