"""How the pictures look: colours, fonts, and an axis that shows nanometres beside centimetres."""

from __future__ import annotations

import math
import warnings
from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import XAxis, YAxis
from matplotlib.figure import Figure
from matplotlib.ticker import LogFormatterSciNotation

from . import labels
from .results import UsageError, whole_file

# Distinct also to the colour-blind (Okabe and Ito).
BLUE, ORANGE, GREEN, PINK, SKY, RED = (
    "#0072B2",
    "#E69F00",
    "#009E73",
    "#CC79A7",
    "#56B4E9",
    "#D55E00",
)
DARK, GREY, LIGHT = "#222222", "#8A8A8A", "#E3E3E3"
CYCLE = [BLUE, RED, GREEN, PINK, ORANGE, SKY, DARK, GREY]

# Colour and name of each friction model.
MODELS = {
    "contensou_exact": (RED, "exact"),
    "contensou_simplified": (BLUE, "simplified"),
    "pade11": (GREEN, "Padé 1/1"),
    "pade22": (ORANGE, "Padé 2/2"),
}

# Colours of models that have no name of their own in pictures.
OTHER_MODELS = {"coulomb": PINK, "hertz": DARK, "vilke": SKY}

ENERGY_COLOURS = {
    "kinetic": BLUE,
    "potential": GREEN,
    "elastic": PINK,
    "work of friction": RED,
    "work of damping": ORANGE,
    "less work supplied": SKY,
}


def apply() -> None:
    """Set the defaults of every figure."""
    mpl.rcParams.update(
        {
            "figure.dpi": 100,
            "savefig.dpi": 160,
            "figure.facecolor": "white",
            "font.family": "DejaVu Sans",
            "font.size": 9,
            "axes.titlesize": 10,
            "axes.titleweight": "bold",
            "axes.titlelocation": "left",
            "axes.edgecolor": GREY,
            "axes.labelcolor": DARK,
            "axes.linewidth": 0.8,
            "axes.spines.top": False,
            "axes.spines.right": False,
            "axes.grid": True,
            "axes.axisbelow": True,
            "grid.color": LIGHT,
            "grid.linewidth": 0.7,
            "xtick.color": GREY,
            "ytick.color": GREY,
            "xtick.labelcolor": DARK,
            "ytick.labelcolor": DARK,
            "lines.linewidth": 1.6,
            "lines.solid_capstyle": "round",
            "legend.frameon": False,
            "legend.fontsize": 8.5,
            "legend.handlelength": 1.8,
            "agg.path.chunksize": 20000,
        }
    )


def panels(
    heights: list[float],
    columns: int = 1,
    width: float = 10.0,
    legend: float = 2.3,
    alone: bool = False,
) -> tuple[Figure, np.ndarray]:
    """Panels over one time axis per column, with room for legends on the right; sizes in inches.

    With `alone` the last row has an axis of its own, and the row before it the time axis.
    """
    above, below = 0.98, 0.5
    between = 0.5 if columns == 1 else 0.8  # room for a time axis of its own
    if alone:
        heights = [*heights[:-1], 0.1, heights[-1]]
    tall = [1.25 * height for height in heights]
    height = above + below + sum(tall) + between * (len(tall) - 1)
    figure, grid = plt.subplots(
        len(tall),
        columns,
        sharex="col" if columns == 1 and not alone else False,
        squeeze=False,
        figsize=(width, height),
        gridspec_kw={
            "height_ratios": heights,
            "left": 0.95 / width,
            "right": 1 - legend / width,
            "top": 1 - above / height,
            "bottom": below / height,
            "hspace": between * len(tall) / sum(tall),
            "wspace": 0.24,
        },
    )
    if alone:
        for axes in grid[-2]:
            axes.remove()
        grid = np.delete(grid, -2, axis=0)
    return figure, grid


def headline(figure: Figure, title: str, line: str, alert: bool = False) -> None:
    """A title and a line of small print above the panels."""
    height = figure.get_figheight()
    figure.text(
        0.2 / figure.get_figwidth(),
        1 - 0.12 / height,
        labels.shown(title),
        va="top",
        fontsize=14,
        fontweight="bold",
        color=RED if alert else DARK,
        parse_math=False,
    )
    figure.text(
        0.2 / figure.get_figwidth(),
        1 - 0.40 / height,
        line,
        va="top",
        fontsize=9,
        color=GREY,
        parse_math=False,
    )


def legend_beside(axes: Axes, **options: object) -> None:
    """A legend to the right of the panel, where it covers no data."""
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1.03), borderaxespad=0, **options)


def colour_of(model: str, otherwise: str) -> str:
    """Colour of a model, the same in all pictures, or what others have."""
    return MODELS[model][0] if model in MODELS else OTHER_MODELS.get(model, otherwise)


class LogLabels(LogFormatterSciNotation):
    """Labels of a logarithmic axis: 0.6 and not 6x10^-1; powers of ten where zeros get many."""

    def __call__(self, x: float, pos: int | None = None) -> str:
        """The label of a tick; none for minor ones where they would be too many."""
        label = super().__call__(x, pos)
        low, high = sorted(self.axis.get_view_interval())
        return f"{x:g}" if label and low > 2e-4 and high < 5e5 else label


def log_scale(axis: XAxis | YAxis) -> None:
    """Make an axis logarithmic."""
    (axis.axes.set_xscale if axis.axis_name == "x" else axis.axes.set_yscale)("log")
    axis.set_major_formatter(LogLabels())
    axis.set_minor_formatter(LogLabels(labelOnlyBase=False))


def hold_scale(axes: Axes, scale: float) -> None:
    """Keep noise, a millionth of the scale of what is drawn, from filling the panel."""
    low, high = axes.get_ylim()
    if high - low < 2e-6 * scale:
        middle = (low + high) / 2
        axes.set_ylim(middle - 0.05 * scale, middle + 0.05 * scale)


def prefixed(value: float, unit: str, digits: int = 3) -> str:
    """A number with its unit under an SI prefix: 1.2e-8, "J" gives "12 nJ"."""
    if value == 0 or not math.isfinite(value):
        return f"{value:g} {unit}"
    exponent = min(max(3 * math.floor(math.log10(abs(value)) / 3 + 1e-9), -15), 9)
    return f"{float(f'{value / 10.0**exponent:.{digits}g}'):g} {PREFIX[exponent]}{unit}"


PREFIX = {-15: "f", -12: "p", -9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}


def unit_for(values: float, unit: str) -> tuple[float, str]:
    """Factor and unit that bring the largest value between 1 and 1000."""
    if values == 0 or not math.isfinite(values):
        return 1.0, unit
    exponent = min(max(3 * math.floor(math.log10(values) / 3 + 1e-9), -15), 9)
    return 10.0**-exponent, PREFIX[exponent] + unit


def gap_axis(axes: Axes, gaps: np.ndarray) -> None:
    """Scale an axis of gaps [m]: linear where bodies overlap, logarithmic far apart."""
    finite = gaps[np.isfinite(gaps)]
    deepest = max(-finite.min(initial=0.0), 0.0)
    widest = max(finite.max(initial=0.0), 0.0)
    # The linear part holds the usual overlap, not the deepest of an impact.
    negative = -finite[finite < 0]
    usual = float(np.percentile(negative, 90)) if negative.size else 1e-7
    threshold = 10.0 ** math.ceil(math.log10(max(usual, 1e-12)) - 1e-9)
    axes.set_yscale("symlog", linthresh=threshold, linscale=1.0)

    ticks = [0.0]
    tick = threshold
    while tick <= max(widest, threshold) * 1.001:
        ticks.append(tick)
        tick *= 10
    tick = threshold
    while tick <= max(deepest, threshold) * 1.001:
        ticks.insert(0, -tick)
        tick *= 10
    axes.set_yticks(
        ticks, [prefixed(tick, "m").replace("-", "−") if tick else "0" for tick in ticks]
    )
    axes.minorticks_off()
    low = -1.5 * max(deepest, threshold * 0.8)
    axes.set_ylim(low, max(widest, threshold) * 3)
    axes.axhspan(low, 0, color=LIGHT, alpha=0.55, linewidth=0, zorder=0)


def save(figure: Figure, path: str | Path, **options: object) -> None:
    """Write the figure; the same data give the same file."""
    ending = Path(path).suffix[1:].lower() or "png"
    if ending not in (known := figure.canvas.get_supported_filetypes()):
        raise UsageError(f"{path}: no picture has the ending .{ending}, only {', '.join(known)}")
    looks = {"format": ending, "bbox_inches": "tight", "pad_inches": 0.15}
    if ending == "png":
        looks["metadata"] = {"Software": None}
    with warnings.catch_warnings(), whole_file(Path(path)) as place:
        # A box for a character is answer enough.
        warnings.filterwarnings("ignore", message="Glyph .* missing from")
        figure.savefig(place, **(looks | options))
    plt.close(figure)
