"""Draw the table of `contensou sweep`: results over one or two of its parameters."""

from __future__ import annotations

import sys
from dataclasses import dataclass, field
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm, ListedColormap, LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from . import labels, style
from .results import ResultError, UsageError
from .tables import Column, Sweep, is_logarithmic, read

# Kinds of picture.
KINDS = ("lines", "map", "scatter")

# So many values of a parameter still become one line each.
MAX_LINES = 8

# So many results are drawn when none is asked for.
MAX_PANELS = 4

# So many whole numbers still get a colour each.
MAX_CLASSES = 12

COMPLETE = 0

# Colour and marker of the cases that have no result, by status; the names are those of the table.
TROUBLE = {
    "failed": (style.RED, "x"),
    "invalid_scene": (style.PINK, "+"),
    "time_limit": (style.ORANGE, "1"),
    "crashed": (style.DARK, "*"),
}
NO_VALUE = "#D5D5D5"

COLOURS = "viridis"


@dataclass(frozen=True)
class Wishes:
    """What the command line asks for; what is None is chosen by the data."""

    results: list[str] | None = None
    over: list[str] | None = None
    kind: str | None = None
    where: dict[str, str] = field(default_factory=dict)


def draw(path: Path, wishes: Wishes) -> Figure:
    """The whole picture."""
    style.apply()
    sweep = read(path)
    over, kind = axes_of(sweep, wishes)
    sweep, fixed = fix_others(sweep, over, kind, wishes)
    results = results_of(sweep, wishes)
    drawing = {"lines": draw_lines, "map": draw_maps, "scatter": draw_scatter}[kind]
    figure = drawing(sweep, over, results)
    style.headline(figure, sweep.title, describe(sweep, fixed))
    return figure


def describe(sweep: Sweep, fixed: dict[str, str]) -> str:
    """The line under the title: program, cases and what is held fixed."""
    parts = [f"contensou {sweep.version}".strip(), f"{count(len(sweep.status), 'case')}"]
    parts += [
        f"{np.count_nonzero(sweep.status == code)} {word.replace('_', ' ')}"
        for code, word in sweep.meanings.items()
        if code != COMPLETE and (sweep.status == code).any()
    ]
    parts += [f"{name.replace('_', ' ')} {value}" for name, value in fixed.items()]
    return "  ·  ".join(parts)


def count(number: int, noun: str) -> str:
    """A number with its noun: 1 case, 10,000 cases."""
    return f"{number:,} {noun}{'' if number == 1 else 's'}"


# ---- What is drawn -----------------------------------------------------------------------------


def known(name: str, columns: dict[str, Column], what: str) -> Column:
    """A column by its name; an error with the possible names if there is none."""
    if name not in columns:
        raise UsageError(f"there is no {what} '{name}'; possible are {', '.join(columns)}")
    return columns[name]


def results_of(sweep: Sweep, wishes: Wishes) -> list[Column]:
    """The results to draw: those asked for, else those that vary if they are few, else one."""
    if wishes.results:
        return [known(name, sweep.results, "result") for name in wishes.results]
    if not sweep.results:
        raise ResultError(f"{sweep.path} holds no results")
    varied = []
    for result in sweep.results.values():
        finite = result.values[np.isfinite(result.values)]
        # A result that some cases have and others do not says something, too.
        if finite.size and (finite.min() < finite.max() or finite.size < len(result.values)):
            varied.append(result)
    varied = varied or list(sweep.results.values())
    if len(varied) <= MAX_PANELS:
        return varied

    # First touches tell most, those most that not every case has; then what the user has defined,
    # which comes last.
    def rank(result: Column) -> tuple[bool, int]:
        lacking = np.count_nonzero(np.isnan(result.values.astype(float)))
        return result.name.startswith("first_touch"), lacking

    best = max(varied, key=rank)
    chosen = best if best.name.startswith("first_touch") else varied[-1]
    others = [name for name in sweep.results if name != chosen.name]
    print(
        f"drawing {chosen.name}; others with --result NAME[,NAME]: {', '.join(others)}",
        file=sys.stderr,
    )
    return [chosen]


def axes_of(sweep: Sweep, wishes: Wishes) -> tuple[list[str], str]:
    """The parameters to draw over, and the kind of picture."""
    free = [name for name in sweep.varied() if name not in wishes.where]
    if wishes.over:
        over = [known(name, sweep.parameters, "parameter").name for name in wishes.over]
        others = [name for name in free if name not in over]
        few = len(others) == 1 and len(sweep.parameters[others[0]].levels()) <= MAX_LINES
        if len(over) == 1 and few and is_grid(sweep, over + others):
            return over + others, wishes.kind or "lines"
        for name in set(over) & set(wishes.where):
            raise UsageError(f"{name} is drawn over and cannot be held fixed at the same time")
    else:
        # Parameters with most values first; equal ones in the order of the sweep.
        over = sorted(free, key=lambda name: -len(sweep.parameters[name].levels()))[:2]
        over.sort(key=free.index)
    if not over:
        over = [known(name, sweep.parameters, "parameter").name for name in sweep.parameters][:1]
    kind = wishes.kind or kind_of(sweep, over)
    if kind == "map" and len(over) != 2:
        raise UsageError("a map needs two parameters; name them with --over")
    if kind == "lines" and len(over) == 2 and not wishes.over:
        # The one with fewer values, or with words, tells the lines apart.
        first, second = (sweep.parameters[name] for name in over)
        if (first.is_text, -len(first.levels())) > (second.is_text, -len(second.levels())):
            over = over[::-1]
    return over, kind


def is_grid(sweep: Sweep, over: list[str]) -> bool:
    """Whether the values repeat: much fewer values of each than cases, which fill the product."""
    counts = [len(sweep.parameters[name].levels()) for name in over]
    return len(sweep.status) >= 0.5 * np.prod(counts, dtype=float)


def kind_of(sweep: Sweep, over: list[str]) -> str:
    """Lines over one parameter or for few values of a second, a map of a grid, else scatter."""
    if len(over) == 1:
        return "lines" if is_grid(sweep, over) and len(sweep.varied()) <= 1 else "scatter"
    if not is_grid(sweep, over):
        return "scatter"
    fewest = min(len(sweep.parameters[name].levels()) for name in over)
    words = any(sweep.parameters[name].is_text for name in over)
    return "lines" if fewest <= (MAX_LINES if words else MAX_LINES // 2 + 1) else "map"


def fix_others(
    sweep: Sweep, over: list[str], kind: str, wishes: Wishes
) -> tuple[Sweep, dict[str, str]]:
    """Keep the cases that belong into the picture; the values at which the others are held."""
    fixed = {}
    for name, text in wishes.where.items():
        value = nearest(known(name, sweep.parameters, "parameter"), text)
        sweep = sweep.select(sweep.parameters[name].values == value)
        fixed[name] = sweep.parameters[name].text_of(value)
    if kind == "scatter":
        return sweep, fixed
    for name in sweep.varied():
        if name in over or name not in sweep.varied():
            continue
        column = sweep.parameters[name]
        levels = column.levels()
        value = levels[(len(levels) - 1) // 2]
        sweep = sweep.select(column.values == value)
        fixed[name] = column.text_of(value)
        print(
            f"{name} is held at {column.text_of(value)}; others with --where {name}=VALUE",
            file=sys.stderr,
        )
    return sweep, fixed


def nearest(column: Column, text: str) -> object:
    """The value of a parameter that is nearest to what is asked for."""
    levels = column.levels()
    if column.is_text:
        for level in levels:
            if str(level).lower() == text.lower():
                return level
        raise UsageError(
            f"{column.name} is never '{text}'; possible are {', '.join(map(str, levels))}"
        )
    try:
        return levels[np.argmin(np.abs(levels - float(text)))]
    except ValueError:
        raise UsageError(f"{column.name} is a number, and '{text}' is none") from None


# ---- Axes --------------------------------------------------------------------------------------


def coordinates(parameter: Column) -> np.ndarray:
    """Where the cases stand on the axis of a parameter; words stand at 0, 1, ..."""
    if not parameter.is_text:
        return parameter.values.astype(float)
    place = {level: i for i, level in enumerate(parameter.levels())}
    return np.array([place[value] for value in parameter.values], dtype=float)


def dress(axis: object, parameter: Column) -> None:
    """Label, scale and ticks of the axis of a parameter."""
    axis.set_label_text(parameter.label)
    if parameter.is_text:
        levels = parameter.levels()
        axis.set_ticks(np.arange(len(levels)), [str(level) for level in levels])
    elif is_logarithmic(parameter.values):
        style.log_scale(axis)


def never(result: Column) -> str:
    """What it means that a complete case has no value of a result."""
    for event in ("touch", "lift"):
        if result.name.startswith((f"first_{event}_", f"last_{event}_")):
            return f"no {event}"
    return "no value"


def troubles(sweep: Sweep) -> list[tuple[str, np.ndarray]]:
    """The ways in which cases have failed, each with these cases."""
    ways = [
        (word, sweep.status == code) for code, word in sweep.meanings.items() if code != COMPLETE
    ]
    return [(word, where) for word, where in ways if where.any()]


def frame(
    results: list[Column], height: float, columns: int, beside: float, beneath: float = 0.0
) -> tuple[Figure, list[Axes]]:
    """One panel for each result, with inches free for its key to its right and beneath it."""
    columns = min(columns, len(results))
    rows = -(-len(results) // columns)
    left, above, below, between = 0.95, 1.0, 0.55 + beneath, 0.85 + beneath
    wide = 10.0 if columns == 1 else 13.0
    high = above + below + rows * height + (rows - 1) * between
    panel = (wide - columns * (left + beside)) / columns
    figure = plt.figure(figsize=(wide, high))
    panels = []
    for i in range(len(results)):
        row, place = divmod(i, columns)
        x = left + place * (panel + left + beside)
        y = high - above - (row + 1) * height - row * between
        panels.append(figure.add_axes((x / wide, y / high, panel / wide, height / high)))
    return figure, panels


def legend_below(axes: Axes, handles: list) -> None:
    """A legend below the panel, where it covers neither data nor the heading."""
    if handles:
        high = axes.get_position().height * axes.figure.get_figheight()
        axes.legend(
            handles=handles,
            loc="upper left",
            bbox_to_anchor=(0.0, -0.45 / high),
            borderaxespad=0,
            ncols=3,
            handlelength=1.0,
            columnspacing=1.4,
        )


def heading(axes: Axes, result: Column) -> None:
    """The meaning of a result above its panel."""
    meaning = labels.drawn(result.meaning or result.name.replace("_", " "), 120)
    axes.set_title(meaning[0].upper() + meaning[1:])


# ---- Lines -------------------------------------------------------------------------------------


def draw_lines(sweep: Sweep, over: list[str], results: list[Column]) -> Figure:
    """Results over one parameter, a line for each value of the second."""
    many = len(over) == 2 and len(sweep.parameters[over[1]].levels()) > MAX_LINES
    high = 2.6 if len(results) > 1 else 4.2
    figure, panels = frame(results, high, 1, *((1.3, 0.5) if many else (2.3, 0.0)))
    x = sweep.parameters[over[0]]
    if len(over) == 1:
        groups = [("", np.full(len(sweep.status), True))]
    else:
        second = sweep.parameters[over[1]]
        groups = [
            (v if second.is_text else f"{v:.4g}", second.values == v) for v in second.levels()
        ]
    places = coordinates(x)
    colours = [
        style.colour_of(name, colour)
        for (name, _), colour in zip(groups, style.CYCLE, strict=False)
    ]
    if len(groups) > MAX_LINES:
        shade = shade_of(sweep.parameters[over[1]])
        colours = plt.get_cmap(COLOURS)(shade(levels_of(sweep.parameters[over[1]])))
    for axes, result in zip(panels, results, strict=True):
        for i, (name, where) in enumerate(groups):
            order = np.flatnonzero(where)
            order = order[np.argsort(places[order], kind="stable")]
            axes.plot(
                places[order],
                shown(sweep, result)[order],
                color=colours[i],
                marker="o" if len(order) <= 60 else None,
                markersize=3.5,
                label=name if len(groups) <= MAX_LINES else None,
            )
        if np.isfinite(shown(sweep, result)).any() and is_logarithmic(shown(sweep, result)):
            style.log_scale(axes.yaxis)
        mark_missing(axes, sweep, result, places)
        dress(axes.xaxis, x)
        axes.set_ylabel(result.label)
        heading(axes, result)
        if len(groups) > MAX_LINES:
            shades = ScalarMappable(shade_of(sweep.parameters[over[1]]), COLOURS)
            key(axes, shades, sweep.parameters[over[1]], "neither")
            legend_below(axes, axes.get_legend_handles_labels()[0])
        else:
            title = None if len(over) == 1 else sweep.parameters[over[1]].label
            style.legend_beside(axes, title=title, alignment="left", title_fontsize=8.5)
    return figure


def levels_of(parameter: Column) -> np.ndarray:
    """The levels of a parameter as numbers; words are 0, 1, ..."""
    levels = parameter.levels()
    return np.arange(len(levels), dtype=float) if parameter.is_text else levels.astype(float)


def shade_of(parameter: Column) -> Normalize:
    """Scale of the colours of many lines."""
    levels = levels_of(parameter)
    return (LogNorm if is_logarithmic(levels) else Normalize)(levels.min(), levels.max())


def shown(sweep: Sweep, result: Column) -> np.ndarray:
    """Values of a result, NaN where the case is not complete."""
    return np.where(sweep.status == COMPLETE, result.values.astype(float), np.nan)


def mark_missing(axes: Axes, sweep: Sweep, result: Column, places: np.ndarray) -> None:
    """Marks along the lower edge for the cases that have no value, failed or not."""
    marks = [
        (word.replace("_", " "), *TROUBLE.get(word, (style.RED, "x")), where)
        for word, where in troubles(sweep)
    ]
    empty = (sweep.status == COMPLETE) & ~np.isfinite(result.values.astype(float))
    if empty.any():
        marks.append((never(result), style.GREY, "|", empty))
    for i, (name, colour, marker, where) in enumerate(marks):
        axes.plot(
            places[where],
            np.full(np.count_nonzero(where), 0.02 + 0.03 * i),
            marker,
            color=colour,
            transform=axes.get_xaxis_transform(),
            markersize=6,
            clip_on=False,
            zorder=5,
            label=f"{name}: {count(np.count_nonzero(where), 'case')}",
        )


# ---- Maps --------------------------------------------------------------------------------------


def draw_maps(sweep: Sweep, over: list[str], results: list[Column]) -> Figure:
    """A heat map of each result over two parameters."""
    figure, panels = frame(results, 4.6 if len(results) == 1 else 3.9, 2, 1.15, 0.3)
    x, y = (sweep.parameters[name] for name in over)
    columns, rows = places_of(x), places_of(y)
    for axes, result in zip(panels, results, strict=True):
        values = np.full((len(y.levels()), len(x.levels())), np.nan)
        values[rows, columns] = shown(sweep, result)
        axes.grid(False)
        mesh = None
        if np.isfinite(values).any():
            colours, norm, extend = scale_of(values)
            mesh = axes.pcolormesh(edges(x), edges(y), values, cmap=colours, norm=norm)
            key(axes, mesh, result, extend)
        overlay = np.full(values.shape, np.nan)
        patches = []
        flat = []
        empty = (sweep.status == COMPLETE) & ~np.isfinite(result.values.astype(float))
        kinds = [(never(result), NO_VALUE, empty)] if empty.any() else []
        kinds += [
            (word.replace("_", " "), TROUBLE.get(word, (style.RED, ""))[0], where)
            for word, where in troubles(sweep)
        ]
        for i, (name, colour, where) in enumerate(kinds):
            overlay[rows[where], columns[where]] = i
            flat.append(colour)
            number = count(np.count_nonzero(where), "case")
            patches.append(Patch(facecolor=colour, edgecolor="none", label=f"{name}: {number}"))
        if kinds:
            colour_map = ListedColormap(flat)
            norm = BoundaryNorm(np.arange(len(flat) + 1) - 0.5, len(flat))
            axes.pcolormesh(edges(x), edges(y), overlay, cmap=colour_map, norm=norm)
        absent = values.size - len(sweep.status)
        if absent > 0:
            patches.append(
                Patch(
                    facecolor="white", edgecolor=style.GREY, label=f"not in the table: {absent:,}"
                )
            )
        legend_below(axes, patches)
        dress(axes.xaxis, x)
        dress(axes.yaxis, y)
        heading(axes, result)
    return figure


def places_of(parameter: Column) -> np.ndarray:
    """Position of each case among the levels of a parameter."""
    place = {level: i for i, level in enumerate(parameter.levels().tolist())}
    return np.array([place[value] for value in parameter.values.tolist()])


def edges(parameter: Column) -> np.ndarray:
    """Borders of the cells, in the middle between the levels on the scale of the axis."""
    if parameter.is_text:
        return np.arange(len(parameter.levels()) + 1) - 0.5
    levels = parameter.levels().astype(float)
    logarithmic = is_logarithmic(levels)
    if logarithmic:
        levels = np.log(levels)
    middle = 0.5 * (levels[1:] + levels[:-1])
    borders = np.concatenate(
        [[2 * levels[0] - middle[0]], middle, [2 * levels[-1] - middle[-1]]]
        if len(levels) > 1
        else [levels - 0.5, levels + 0.5]
    )
    return np.exp(borders) if logarithmic else borders


def scale_of(values: np.ndarray) -> tuple[object, Normalize, str]:
    """Colours, their scale, and at which ends values lie beyond it."""
    finite = values[np.isfinite(values)]
    levels = np.unique(finite)
    whole = np.all(levels == np.round(levels))
    if whole and 1 < len(levels) <= MAX_CLASSES and np.ptp(levels) < MAX_CLASSES:
        bounds = np.arange(levels[0] - 0.5, levels[-1] + 1)
        return (
            plt.get_cmap(COLOURS, len(bounds) - 1),
            BoundaryNorm(bounds, len(bounds) - 1),
            "neither",
        )
    low, high = finite.min(), finite.max()
    if low > 0 and high > 100 * low and is_logarithmic(finite):
        return plt.get_cmap(COLOURS), LogNorm(low, high), "neither"
    # Few values far out do not take the colours from the others.
    inner_low, inner_high = np.percentile(finite, [1, 99])
    extend = "neither"
    if inner_high > inner_low and high - low > 3 * (inner_high - inner_low):
        cut_low, cut_high = low < inner_low, high > inner_high
        extend = {(1, 1): "both", (1, 0): "min", (0, 1): "max"}[cut_low, cut_high]
        low, high = inner_low, inner_high
    if low == high:
        low, high = low - 0.5, high + 0.5
    return plt.get_cmap(COLOURS), Normalize(low, high), extend


def key(axes: Axes, mesh: object, result: Column, extend: str) -> None:
    """The colours of a result, to the right of its panel."""
    place = axes.inset_axes((1.03, 0.0, 0.035, 1.0))
    bar = axes.figure.colorbar(mesh, cax=place, extend=extend)
    bar.outline.set_visible(False)
    place.grid(False)
    if isinstance(mesh.norm, BoundaryNorm):
        middle = 0.5 * (mesh.norm.boundaries[1:] + mesh.norm.boundaries[:-1])
        bar.set_ticks(middle, labels=[f"{value:g}" for value in middle])
        place.minorticks_off()
    bar.set_label(result.label)


# ---- Points ------------------------------------------------------------------------------------


def draw_scatter(sweep: Sweep, over: list[str], results: list[Column]) -> Figure:
    """A point for each case: a result over one parameter, or as colour over two."""
    if len(over) == 1:
        return draw_points(sweep, over[0], results)
    figure, panels = frame(results, 4.6 if len(results) == 1 else 3.9, 2, 1.15, 0.3)
    x, y = (sweep.parameters[name] for name in over)
    across, up = coordinates(x), coordinates(y)
    size = point_size(len(sweep.status))
    for axes, result in zip(panels, results, strict=True):
        values = shown(sweep, result)
        finite = np.isfinite(values)
        handles = []
        empty = (sweep.status == COMPLETE) & ~finite
        if empty.any():
            axes.scatter(across[empty], up[empty], s=size, color=NO_VALUE, linewidths=0)
            name = f"{never(result)}: {count(np.count_nonzero(empty), 'case')}"
            handles.append(Line2D([], [], linestyle="", marker="o", color=NO_VALUE, label=name))
        if finite.any():
            colours, norm, extend = scale_of(values)
            points = axes.scatter(
                across[finite],
                up[finite],
                c=values[finite],
                s=size,
                cmap=colours,
                norm=norm,
                linewidths=0,
            )
            key(axes, points, result, extend)
        for word, where in troubles(sweep):
            colour, marker = TROUBLE.get(word, (style.RED, "x"))
            name = f"{word.replace('_', ' ')}: {count(np.count_nonzero(where), 'case')}"
            axes.scatter(
                across[where],
                up[where],
                s=max(size, 16),
                c=colour,
                marker=marker,
                linewidths=1.2,
                zorder=4,
            )
            handles.append(Line2D([], [], linestyle="", marker=marker, color=colour, label=name))
        legend_below(axes, handles)
        dress(axes.xaxis, x)
        dress(axes.yaxis, y)
        heading(axes, result)
    return figure


def draw_points(sweep: Sweep, over: str, results: list[Column]) -> Figure:
    """Each result over one parameter."""
    figure, panels = frame(results, 2.6 if len(results) > 1 else 4.2, 1, 2.3)
    x = sweep.parameters[over]
    places = coordinates(x)
    for axes, result in zip(panels, results, strict=True):
        values = shown(sweep, result)
        axes.scatter(places, values, s=point_size(len(values)), color=style.BLUE, linewidths=0)
        if np.isfinite(values).any() and is_logarithmic(values):
            style.log_scale(axes.yaxis)
        mark_missing(axes, sweep, result, places)
        dress(axes.xaxis, x)
        axes.set_ylabel(result.label)
        heading(axes, result)
        style.legend_beside(axes)
    return figure


def point_size(number: int) -> float:
    """Area of a point, smaller for more of them [points squared]."""
    return float(np.clip(4e4 / max(number, 1), 1.5, 36.0))
