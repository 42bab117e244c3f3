"""Draw one output file of contensou: a run, a study of `contensou cost` or the table of a sweep."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from . import labels, motion, style, sweeps, work_precision
from . import loads as bearing_loads
from .results import Result, ResultError, UsageError, damage_told
from .tables import is_sweep

MAX_LANDMARKS = 4


def gap_panel(axes: Axes, result: Result) -> None:
    """Contact indicators with the touches and lifts."""
    gaps = result.column("gap")
    style.gap_axis(axes, gaps)
    for i, (name, at) in enumerate(motion.groups(result.contacts)):
        colour = style.CYCLE[i]
        motion.curve(axes, result.time, gaps[:, at], name, color=colour, linewidth=1.3)
        if len(at) > 1:
            continue
        for kind, marker, face in (("touch", "v", colour), ("lift", "^", "white")):
            times = [e.time for e in result.events if e.contact == name and e.kind == kind]
            detailed = times and len(result.contacts) <= 2
            axes.plot(
                times,
                np.zeros(len(times)),
                marker,
                markersize=6,
                color=colour,
                markerfacecolor=face,
                clip_on=False,
                zorder=4,
                label=f"{kind}, {len(times)} ×" if detailed else None,
            )
    axes.annotate(
        "overlap",
        (1, 0),
        xycoords="axes fraction",
        xytext=(-4, 3),
        textcoords="offset points",
        ha="right",
        color=style.GREY,
        fontsize=8,
    )
    axes.set_title("Contact indicators")
    axes.set_ylabel("gap")
    style.legend_beside(axes)


def energy_panel(axes: Axes, result: Result) -> None:
    """Changes of the terms of the balance; the legend gives what is too small to be seen."""
    terms = result.energies()
    factor, unit = style.unit_for(max(np.abs(values).max() for values in terms.values()), "J")
    total = np.zeros_like(result.time)
    for name, values in terms.items():
        total += values
        last = style.prefixed(values[-1], "J")
        axes.plot(
            result.time, factor * values, color=style.ENERGY_COLOURS[name], label=f"{name}: {last}"
        )
    axes.plot(
        result.time,
        factor * total,
        color=style.DARK,
        linewidth=1.1,
        linestyle=(0, (5, 3)),
        label=f"sum: {style.prefixed(total[-1], 'J')}",
    )
    axes.set_title("Energy balance")
    axes.set_ylabel(f"change [{unit}]")
    style.legend_beside(axes, title="change at the end", alignment="left", title_fontsize=8.5)


def residual_panel(axes: Axes, result: Result) -> None:
    """What the balance leaves open, in parts of the initial energy."""
    scale = result.initial_energy()
    share = np.abs(result.residual()) / (scale or 1)
    shown = np.where(share > 0, share, np.nan)
    axes.plot(result.time, shown, color=style.DARK, linewidth=1.0)
    if np.isfinite(shown).any():
        style.log_scale(axes.yaxis)
        low, high = np.nanpercentile(shown, 5), np.nanmax(shown)
        axes.set_ylim(10 ** np.floor(np.log10(low) - 0.2), 10 ** np.ceil(np.log10(high) + 0.2))
        axes.yaxis.set_major_locator(plt.LogLocator(numticks=4))
        axes.yaxis.set_minor_locator(plt.NullLocator())
    axes.set_title("Residual of the energy balance")
    axes.set_ylabel("|residual|" + (" / $E_0$" if scale else " [J]"))
    axes.text(
        1.018,
        1.0,
        f"largest {share.max():.1e}" + (f"\n$E_0$ = {style.prefixed(scale, 'J')}" if scale else ""),
        transform=axes.transAxes,
        va="top",
        fontsize=8.5,
        linespacing=1.5,
    )


def panels_of(result: Result) -> list[tuple]:
    """The panels that the file has data for, with their relative heights."""
    panels = [
        *motion.inclination_panels(result),
        *motion.position_panels(result),
        *motion.speed_panels(result),
        *motion.spin_panels(result),
    ]
    gaps = result.column("gap")
    if result.contacts and gaps is not None and gaps.size:
        panels.append((gap_panel, 1.5))
    if result.energies():
        panels.append((energy_panel, 1.5))
    if result.residual() is not None:
        panels.append((residual_panel, 0.65))
    return panels


def landmarks(result: Result) -> list[tuple[float, str]]:
    """First touch of a contact that begins apart, last lift of one that begins closed."""
    marks = []
    gaps = result.column("gap")
    for i, name in enumerate(result.contacts):
        events = [event for event in result.events if event.contact == name]
        if events and events[0].kind == "touch":
            marks.append((events[0].time, f"{name} touches"))
        elif events and events[-1].kind == "lift" and gaps[-1, i] > 0:
            marks.append((events[-1].time, f"{name} lifts for the last time"))
    return sorted(marks)


def draw_landmarks(panels: list[Axes], result: Result) -> None:
    """Thin lines through all panels where contacts change for good, named beside the first one."""
    marks = landmarks(result)
    if not 0 < len(marks) <= MAX_LANDMARKS:
        return
    for time, text in marks:
        for axes in panels:
            label = f"{text} at {time:.4f} s" if axes is panels[0] else None
            axes.axvline(
                time, color=style.GREY, linewidth=0.8, linestyle=(0, (2, 2)), zorder=1, label=label
            )
    style.legend_beside(panels[0])


def draw(result: Result) -> Figure:
    """The whole picture."""
    style.apply()
    result.bodies = list(map(labels.drawn, result.bodies))
    result.contacts = list(map(labels.drawn, result.contacts))
    result.events = [replace(e, contact=labels.drawn(e.contact)) for e in result.events]
    panels = panels_of(result)
    if not panels:
        raise ResultError(f"{result.path} holds nothing that could be drawn")
    path = motion.path_plane(result) is not None
    heights = [height for _, height in panels] + [2.0] * path
    figure, grid = style.panels(heights, alone=path)
    style.headline(figure, title_of(result), describe(result), alert=not result.complete)
    column = list(grid[:, 0])
    if path:
        motion.path_panel(column.pop(), result)
    for axes, (panel, _) in zip(column, panels, strict=True):
        panel(axes, result)
        axes.yaxis.set_label_coords(-0.092, 0.5)
        axes.set_xlim(result.time[0], result.time[-1])
        axes.tick_params(labelbottom=axes is column[-1])
    draw_landmarks(column, result)
    column[-1].set_xlabel("time [s]")
    return figure


def title_of(result: Result) -> str:
    """The scene's title and, when the run did not reach its end, what became of it."""
    if result.complete:
        return result.title
    return f"{result.title}: {result.status or 'unfinished'} at {result.time[-1]:.4g} s"


def describe(result: Result) -> str:
    """The line under the title: program and the models that the scene names."""
    parts = [f"contensou {result.version}".strip()]
    for key in ("normal", "friction", "damping", "method"):
        if values := result.choices(key):
            parts.append(f"{key} {', '.join(values)}")
    return "  ·  ".join(parts)


def figure_of(file: Path, wishes: sweeps.Wishes, *, loads: bool = False) -> Figure:
    """The picture of a file; an error in words, however damaged it is."""
    with damage_told(file):
        return bearing_loads.draw(Result(file)) if loads else draw_file(file, wishes)


def draw_file(file: Path, wishes: sweeps.Wishes) -> Figure:
    """The picture of a file of one of the three kinds."""
    if is_sweep(file):
        return sweeps.draw(file, wishes)
    if wishes != sweeps.Wishes():
        raise UsageError(f"{file} is no table of a sweep: no --result, --over, --kind, --where")
    if work_precision.is_study(file):
        return work_precision.draw(file)
    return draw(Result(file))
