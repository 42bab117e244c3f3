"""Pictures of tangential elasticity: an oblique impact, an incline, a shift to and fro."""

from __future__ import annotations

import csv
import io
import itertools
import sys
import tempfile
from pathlib import Path

import numpy as np

from lib import program, style
from lib.figures_top import run

INPUTS = program.ROOT / "inputs" / "examples"
MEASURED = program.ROOT / "tests" / "reference" / "impact_kharaz.csv"
RADIUS = 2.5e-3

# Models of tangential elasticity, and how they are drawn.
MODELS = {
    "elastic": (style.RED, "elastic", "-"),
    "spring": (style.ORANGE, "spring", "--"),
    "none": (style.GREY, "none", "-"),
}
ANGLES = np.concatenate([[1.0, 1.84, 3.0], np.arange(5.0, 66.0, 2.5)])

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
    for model, (colour, label, line) in MODELS.items():
        values = np.array([after(angle, model, place) for angle in ANGLES]).T
        for axes, numbers in zip((restitution, spin), values, strict=True):
            axes.plot(ANGLES, numbers, line, color=colour, label=label)
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
    spin.set_xlim(0, ANGLES[-1])
    style.headline(
        figure,
        "Oblique impact of a ball of alumina on glass",
        "inputs/examples/oblique_impact.nml; measured: Kharaz, Gorham, Salman (2001)",
    )
    style.save(figure, path)


def after(angle: float, model: str, place: Path) -> tuple[float, float]:
    """Tangential restitution and spin [rad/s] after an impact at an angle [degrees]."""
    text = (INPUTS / "oblique_impact.nml").read_text(encoding="utf-8")
    scene = place / "impact.nml"
    text = text.replace("'elastic'", f"'{model}'")
    if model == "none":
        text = text.replace("'explicit8'", "'cvode_bdf'")  # friction that sticks is stiff
    scene.write_text(text, encoding="utf-8")
    result = run(scene, place / "impact.h5", constants__angle=float(np.radians(angle)))
    velocity = result.column("velocity")[:, 0, 0]
    return velocity[-1] / velocity[0], abs(result.column("angular_velocity")[-1, 0, 1])


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


def cattaneo(path: Path, _: Path) -> None:
    """Loops of force and shift at constant load, without and with a twist that is held."""
    figure, grid = style.panels([2.6])
    loop = grid[0, 0]
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
    style.headline(figure, title, "contensou eval tangential")
    style.save(figure, path)


def draw(folder: Path, wanted: list[str]) -> list[Path]:
    """Run what is needed and draw the wanted pictures into the folder."""
    pictures = []
    for name in wanted:
        print(f"figures: running {name}", file=sys.stderr)
        with tempfile.TemporaryDirectory(prefix="contensou-") as place:
            pictures.append(folder / f"{name}.png")
            drawing = {"impact": impact, "incline": incline, "cattaneo": cattaneo}[name]
            drawing(pictures[-1], Path(place))
    return pictures
