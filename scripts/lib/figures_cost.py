"""Error against cost of every way to compute a kernel, from `contensou bench kernels`."""

from __future__ import annotations

import csv
import math
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import LogLocator, NullFormatter
from matplotlib.transforms import Bbox

from . import program, style


@dataclass(frozen=True)
class Kernel:
    """What is drawn of a kernel, each tuple of cases a row of panels."""

    title: str
    unit: str  # of the errors
    floor: float  # smallest error that is shown
    quantities: tuple[str, ...]  # of which the worst one counts
    cases: tuple[tuple[str, ...], ...]
    exact: tuple[str, ...]  # ours that are exact to rounding


KERNELS = {
    "elliptic": Kernel(
        "complete elliptic integrals and their derivatives",
        "ulp",
        3e-2,
        ("K", "E", "B", "D", "dKdc", "dEdc"),
        (("even", "wide", "near_circle"),),
        ("tables",),
    ),
    "hertz": Kernel(
        "Hertz contact",
        "ulp",
        3e-2,
        ("c1", "a", "b", "N", "p0"),
        (("full", "slender"),),
        ("tables", "tables_fixed"),
    ),
    "wrench": Kernel(
        "friction wrench",
        "$fN$, $fNa$",
        3e-18,
        ("F", "T"),
        tuple(
            tuple(f"{spot}_{place}" for place in ("inside", "rim", "outside"))
            for spot in ("circle", "k0.3", "k0.05")
        ),
        ("contensou_exact",),
    ),
}

# Colours of the points and their labels; others are blue.
COLOURS = {
    **{name: colour for name, (colour, _) in style.MODELS.items()},
    **style.OTHER_MODELS,
    "tables": style.RED,
    "tables_fixed": style.RED,
    "agm": style.GREEN,
    "gsl": style.GREY,
    "boost": style.GREY,
    "newton_gsl": style.GREY,
    "brewe_hamrock": style.ORANGE,
    "greenwood": style.GREEN,
    **dict.fromkeys(("vilke_chord", "vilke_power", "vilke_exact"), style.OTHER_MODELS["vilke"]),
}

# Labels that differ from the names of the rungs.
LABELS = {
    **{name: label for name, (_, label) in style.MODELS.items()},
    "coulomb": "Coulomb",
    "tables_fixed": "tables, fixed curvatures",
    "agm": "AGM",
    "gsl": "GSL",
    "boost": "Boost",
    "newton_agm": "Newton, AGM",
    "newton_gsl": "Newton, GSL",
    "newton": "Newton",
    "brewe_hamrock": "Brewe-Hamrock",
    "greenwood": "Greenwood",
    "vilke_chord": "Vil'ke, chord",
    "vilke_power": "Vil'ke, power",
    "vilke_exact": "Vil'ke, exact $c$",
}

# What the cases of the benchmark are.
CASES = {
    "even": "$c_1$ even in (0, 1)",
    "wide": "$\\log c_1$ even, $10^{-300}$ to 1",
    "near_circle": "next to the circle, $\\log c$ even",
    "full": "$\\log A/B$ even, $10^{-3}$ to 1",
    "slender": "$\\log A/B$ even, $10^{-20}$ to $10^{-3}$",
    "circle": "circle",
    "k0.3": "$b/a$ = 0.3",
    "k0.05": "$b/a$ = 0.05",
    "inside": "centre inside the spot",
    "rim": "centre next to the rim",
    "outside": "centre outside",
}


@dataclass(frozen=True)
class Rung:
    """One way to compute a kernel, on one case."""

    name: str
    cost: float  # a call in throughput, in units of a call of log()
    largest: float  # error
    median: float
    without: float  # share of the arguments that give no result


def measure(place: Path) -> list[dict[str, str]]:
    """The table of a short benchmark."""
    print("figures: measuring the kernels", file=sys.stderr)
    program.call("bench", "kernels", "--quick", "-o", place / "bench")
    with open(place / "bench.csv", encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def rungs_of(table: list[dict[str, str]], kernel: str, case: str) -> list[Rung]:
    """The rungs of a case; the errors are those of the worst quantity."""
    quantities = KERNELS[kernel].quantities
    rows: dict[str, list[dict[str, str]]] = {}
    for row in table:
        if (row["kernel"], row["case"]) == (kernel, case) and row["quantity"] in quantities:
            rows.setdefault(row["rung"], []).append(row)
    return [
        Rung(
            name,
            float(own[0]["log_ratio"]),
            max(float(row["error_max"]) for row in own),
            max(float(row["error_median"]) for row in own),
            int(own[0]["misses"]) / int(own[0]["checked"]),
        )
        for name, own in rows.items()
    ]


def label_of(rung: Rung) -> str:
    """Name of a rung, with the share of what it cannot do."""
    name = LABELS.get(rung.name, rung.name)
    if rung.without > 0:
        name += f" ({max(1, round(100 * rung.without))} % NaN)"
    return name


def draw_rungs(axes: Axes, rungs: list[Rung], kernel: Kernel) -> None:
    """A point for each rung at its largest error, and a line down to the median."""
    for rung in rungs:
        low, high = max(rung.median, kernel.floor), max(rung.largest, kernel.floor)
        colour = COLOURS.get(rung.name, style.BLUE)
        axes.plot([rung.cost] * 2, [low, high], color=colour, linewidth=1.1, alpha=0.6)
        axes.plot(rung.cost, high, "o", color=colour, markersize=6)
        axes.plot(rung.cost, low, "_", color=colour, markersize=7, markeredgewidth=1.4)


def put_labels(axes: Axes, rungs: list[Rung], kernel: Kernel) -> None:
    """Name the points, each where there is room."""
    renderer = axes.figure.canvas.get_renderer()
    frame = axes.get_window_extent(renderer)
    taken = []
    for rung in rungs:
        x, y = axes.transData.transform((rung.cost, max(rung.largest, kernel.floor)))
        bottom = axes.transData.transform((rung.cost, max(rung.median, kernel.floor)))[1]
        taken += [Bbox.from_extents(x - 4, y - 4, x + 4, y + 4)]
        taken += [Bbox.from_extents(x - 1, bottom, x + 1, y)]
    places = [(6, 0, "left", "center"), (-6, 0, "right", "center"), (0, 6, "center", "bottom")]
    for shift in (5, 10, 15, 20, 26, 32):
        places += [
            (6, shift, "left", "center"),
            (6, -shift, "left", "center"),
            (-6, shift, "right", "center"),
            (-6, -shift, "right", "center"),
        ]
    for rung in sorted(rungs, key=lambda rung: -rung.largest):
        label = axes.annotate(
            label_of(rung),
            (rung.cost, max(rung.largest, kernel.floor)),
            xytext=(6, 0),
            textcoords="offset points",
            fontsize=8,
            color=COLOURS.get(rung.name, style.BLUE),
            fontweight="bold" if rung.name in kernel.exact else "normal",
        )
        best = None
        for place in places:
            label.set_position(place[:2])
            label.set_horizontalalignment(place[2])
            label.set_verticalalignment(place[3])
            box = label.get_window_extent(renderer)
            outside = box.x0 < frame.x0 or box.x1 > frame.x1 or box.y1 > frame.y1
            conflicts = sum(box.overlaps(other) for other in taken) + 3 * outside
            if best is None or conflicts < best[0]:
                best = (conflicts, place)
            if conflicts == 0:
                break
        label.set_position(best[1][:2])
        label.set_horizontalalignment(best[1][2])
        label.set_verticalalignment(best[1][3])
        taken.append(label.get_window_extent(renderer))


def title_of(case: str) -> str:
    """What is in a case."""
    if case in CASES:
        return CASES[case]
    return ", ".join(CASES.get(word, word) for word in case.split("_"))


def figure_cost(table: list[dict[str, str]], name: str, path: Path) -> None:
    """Error against cost of a kernel, a panel for each case."""
    kernel = KERNELS[name]
    n_rows, n_columns = len(kernel.cases), len(kernel.cases[0])
    width = {2: 11.0, 3: 13.0}[n_columns]
    tall = 4.2 if n_rows == 1 else 2.7
    above, below = 0.98, 0.55
    height = above + below + n_rows * tall + (n_rows - 1) * 0.4
    figure, grid = plt.subplots(
        n_rows,
        n_columns,
        sharex=True,
        sharey=True,
        squeeze=False,
        figsize=(width, height),
        gridspec_kw={
            "left": 0.75 / width,
            "right": 1 - 0.15 / width,
            "top": 1 - above / height,
            "bottom": below / height,
            "hspace": 0.4 / tall,
            "wspace": 0.05,
        },
    )
    panels = {
        place: [
            rung
            for rung in rungs_of(table, name, kernel.cases[place[0]][place[1]])
            if math.isfinite(rung.largest) and math.isfinite(rung.median)
        ]
        for place in np.ndindex(grid.shape)
    }
    shown = [rung for rungs in panels.values() for rung in rungs]
    for place, rungs in panels.items():
        draw_rungs(grid[place], rungs, kernel)
        grid[place].set_title(title_of(kernel.cases[place[0]][place[1]]))
    axes = grid[0, 0]
    style.log_scale(axes.xaxis)
    style.log_scale(axes.yaxis)
    # Room for labels on both sides.
    axes.set_xlim(min(r.cost for r in shown) / 2.2, max(r.cost for r in shown) * 2.2)
    axes.set_ylim(kernel.floor / 2, max(rung.largest for rung in shown) * 100)
    axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5) if n_rows > 1 else (1,)))
    axes.xaxis.set_minor_formatter(NullFormatter())
    for axes in grid[-1]:
        axes.set_xlabel("time of a call, in units of log()")
    for axes in grid[:, 0]:
        axes.set_ylabel(f"error  [{kernel.unit}]")
    figure.canvas.draw()
    for place, rungs in panels.items():
        put_labels(grid[place], rungs, kernel)
    style.headline(
        figure,
        f"Error against cost: {kernel.title}",
        "contensou bench kernels --quick, random arguments. Point: largest error of the worst "
        "result; dash: median. Bold: exact to rounding.",
    )
    style.save(figure, path)


def draw(folder: Path, _: list[str]) -> list[Path]:
    """Measure and draw error against cost, a picture for each kernel, into the folder."""
    with tempfile.TemporaryDirectory(prefix="contensou-") as place:
        table = measure(Path(place))
    pictures = {name: folder / f"cost_{name}.png" for name in KERNELS}
    for name, picture in pictures.items():
        figure_cost(table, name, picture)
    return list(pictures.values())
