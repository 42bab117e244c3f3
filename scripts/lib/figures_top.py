"""Figures 6, 7 and 8 of Kosenko and Aleksandrov (2009), from fresh runs of the Tippe-Top.

The scenes are inputs/tippe_top*.nml, one for each friction model. Figure 6 is the inclination of
the top's axis, figure 7 the contact indicators with zooms on the hand-over from the ball to the
stem, and figure 8 the energies and the angular velocity. The zooms follow the events of the run.
"""

from __future__ import annotations

import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from . import program, style
from .results import Event, Result, ResultError, keyword_values

SOURCE = (
    "Own runs of the example in Kosenko and Aleksandrov (2009), doi 10.3384/ecp09430006. "
    "No copy: the choice of curves and scales is ours."
)

# The two models compared, and those that figure 6 shows besides.
SIMPLIFIED, EXACT = "contensou_simplified", "contensou_exact"
COMPARED = {model: style.MODELS[model] for model in (SIMPLIFIED, EXACT)}
OTHERS = {model: style.MODELS[model] for model in ("pade11", "pade22")}

INTERVAL = 1.0e-3
ZOOM_INTERVAL = 1.0e-5


@dataclass(frozen=True)
class HandOver:
    """When the stem takes over from the ball."""

    ball: int
    stem: int
    start: float  # the stem's first touch [s]
    end: float  # the ball's last lift [s]
    attempts: list[tuple[float, float]]  # first and last event of each group of events [s]


def find_scenes() -> dict[str, Path]:
    """The first scene of each friction model."""
    scenes: dict[str, Path] = {}
    for scene in sorted((program.ROOT / "inputs").glob("tippe_top*.nml")):
        models = {model.lower() for model in keyword_values(scene.read_text("utf-8"), "friction")}
        if len(models) == 1:
            scenes.setdefault(models.pop(), scene)
    missing = [model for model in COMPARED if model not in scenes]
    if missing:
        raise ResultError(f"no scene inputs/tippe_top*.nml has friction = {' or '.join(missing)}")
    return scenes


def run(scene: Path, output: Path, **settings: float) -> Result:
    """Run a scene with some settings, group__key = value, and read the result."""
    words = ["run", scene, "-o", output, "--force", "-q"]
    for name, value in settings.items():
        words += ["--set", f"{name.replace('__', '.')}={value!r}"]
    program.call(*words)
    return Result(output)


def find_hand_over(result: Result) -> HandOver:
    """The hand-over by the events; contacts are told apart by their gaps at the start."""
    if len(result.contacts) != 2:
        raise ResultError(f"{result.path} has {len(result.contacts)} contacts, expected two")
    ball, stem = (int(i) for i in np.argsort(result.column("gap")[0]))
    touches = times(result.events, "touch", result.contacts[stem])
    lifts = times(result.events, "lift", result.contacts[ball])
    if not touches or not lifts or lifts[-1] <= touches[0]:
        raise ResultError(f"{result.path}: the stem does not take over from the ball")
    start, end = touches[0], lifts[-1]
    groups: list[list[float]] = []
    for event in result.events:
        if event.time < start:
            continue
        if not groups or event.time - groups[-1][-1] > 0.05 * (end - start):
            if event.time > end:
                break
            groups.append([])
        groups[-1].append(event.time)
    return HandOver(ball, stem, start, end, [(group[0], group[-1]) for group in groups])


def times(events: list[Event], kind: str, contact: str) -> list[float]:
    """Times of one kind of event of one contact."""
    return [event.time for event in events if event.kind == kind and event.contact == contact]


def window(start: float, end: float, before: float = 0.15, after: float = 0.3) -> tuple:
    """An interval with margins, in parts of its length."""
    length = end - start
    return start - before * length, end + after * length


def figure_6(runs: dict[str, Result], path: Path) -> None:
    """Inclination over the whole run, all models."""
    figure, grid = style.panels([2.6])
    axes = grid[0, 0]
    for model, (colour, name) in {**OTHERS, **COMPARED}.items():
        if model in runs:
            other = model in OTHERS
            axes.plot(
                runs[model].time,
                np.degrees(runs[model].inclination(0)),
                color=colour,
                linewidth=1.0 if other else 1.8,
                linestyle=(0, (4, 2)) if other else "-",
                label=name,
            )
            if not other:
                hand_over = find_hand_over(runs[model])
                axes.axvspan(
                    hand_over.start,
                    hand_over.end,
                    color=colour,
                    alpha=0.18,
                    linewidth=0,
                    label=f"hand-over, {hand_over.start:.3f}\nto {hand_over.end:.3f} s",
                )
    axes.set_yticks(np.arange(0, 181, 45))
    axes.set_ylim(-8, 188)
    axes.set_xlim(0, max(result.time[-1] for result in runs.values()))
    axes.set_xlabel("time [s]")
    axes.set_ylabel("θ [°]")
    axes.set_title("Angle between the axis and the vertical")
    style.legend_beside(axes)
    style.headline(figure, "Figure 6: inclination of the top's axis", SOURCE)
    style.save(figure, path)


def draw_gaps(axes: Axes, result: Result, hand_over: HandOver, span: tuple, fine: bool) -> None:
    """The two indicators within a time span; fine: ms and µm, else s and the two-level axis."""
    inside = (result.time >= span[0]) & (result.time <= span[1])
    origin, clock = (round_origin(span), 1e3) if fine else (0.0, 1.0)
    gaps = result.column("gap")[inside]
    for contact, colour, name in (
        (hand_over.ball, style.BLUE, "large ball"),
        (hand_over.stem, style.RED, "stem"),
    ):
        axes.plot(
            (result.time[inside] - origin) * clock,
            gaps[:, contact] * (1e6 if fine else 1.0),
            color=colour,
            linewidth=1.4,
            label=name,
        )
    axes.set_xlim((span[0] - origin) * clock, (span[1] - origin) * clock)
    if fine:
        # What bounces is of interest, not how high the other one is by then.
        closed = gaps[:, [hand_over.ball, hand_over.stem]].min(axis=1).min()
        axes.set_ylim(1.4e6 * closed, -6e6 * closed)
        axes.axhspan(axes.get_ylim()[0], 0, color=style.LIGHT, alpha=0.55, linewidth=0, zorder=0)
        axes.set_xlabel(f"time − {origin:.3f} s [ms]")
    else:
        style.gap_axis(axes, gaps)


def round_origin(span: tuple) -> float:
    """A round time, to the millisecond, from which a zoom counts."""
    return np.floor(span[0] * 1e3) / 1e3


def figure_7(runs: dict[str, Result], zooms: dict[str, Result], path: Path) -> None:
    """Contact indicators: the whole run, the hand-over, the first attempt, the ball's last lift."""
    figure, grid = style.panels([1.5, 1.5, 1.3, 1.3], columns=2, width=12.5, legend=1.3)
    for column, (model, (_, name)) in zip(grid.T, COMPARED.items(), strict=True):
        whole, zoom = runs[model], zooms[model]
        hand_over = find_hand_over(whole)
        span = window(hand_over.start, hand_over.end, 0.1, 0.1)
        draw_gaps(column[0], whole, hand_over, (whole.time[0], whole.time[-1]), fine=False)
        draw_gaps(column[1], zoom, hand_over, span, fine=False)
        draw_gaps(column[2], zoom, hand_over, window(*hand_over.attempts[0]), fine=True)
        draw_gaps(column[3], zoom, hand_over, window(*hand_over.attempts[-1]), fine=True)
        column[0].set_title(f"{name.capitalize()} model, whole run")
        column[1].set_title(f"Hand-over, {hand_over.start:.4f} to {hand_over.end:.4f} s")
        column[2].set_title("The stem's first touches")
        column[3].set_title("The ball leaves for good")
        column[0].set_xlabel("time [s]")
        column[1].set_xlabel("time [s]")
    for axes in grid[:2, 0]:
        axes.set_ylabel("gap")
    for axes in grid[2:, 0]:
        axes.set_ylabel("gap [µm]")
    for axes in grid[:, 0]:
        axes.yaxis.set_label_coords(-0.16, 0.5)
    style.legend_beside(grid[0, 1])
    style.headline(figure, "Figure 7: contact indicators (grey: overlap)", SOURCE)
    style.save(figure, path)


def figure_8(runs: dict[str, Result], path: Path) -> None:
    """Energies and angular velocity of the top, both models."""
    figure, grid = style.panels([2.0, 1.8])
    energy, spin = grid[:, 0]
    factor, unit = style.unit_for(runs[EXACT].initial_energy(), "J")
    for model, (_, name) in COMPARED.items():
        result = runs[model]
        line = {"linestyle": "-" if model == EXACT else (0, (4, 1.5))}
        for term, values in result.energies().items():
            if term in ("kinetic", "potential", "work of friction"):
                colour = style.ENERGY_COLOURS[term]
                energy.plot(result.time, factor * values, color=colour, **line)
        spin.plot(result.time, result.column("angular_velocity")[:, 0, 2], color=style.BLUE, **line)
        spin.plot(result.time, result.axial_spin(0), color=style.RED, **line)
        for axes in (energy, spin):
            axes.plot([], [], color=style.DARK, label=name, **line)
    for term in ("kinetic", "potential", "work of friction"):
        energy.plot([], [], color=style.ENERGY_COLOURS[term], label=term)
    spin.plot([], [], color=style.BLUE, label="about the vertical")
    spin.plot([], [], color=style.RED, label="about the top's axis")
    spin.axhline(0, color=style.GREY, linewidth=0.8, zorder=1)
    energy.set_title("Changes of the energies of the top, and work of friction")
    energy.set_ylabel(f"change [{unit}]")
    spin.set_title("Angular velocity")
    spin.set_ylabel("ω [rad/s]")
    spin.set_xlabel("time [s]")
    spin.set_xlim(0, runs[EXACT].time[-1])
    for axes in (energy, spin):
        axes.yaxis.set_label_coords(-0.092, 0.5)
        style.legend_beside(axes)
    style.headline(figure, "Figure 8: energies and angular velocity", SOURCE)
    style.save(figure, path)


def draw(folder: Path, wanted: list[str]) -> list[Path]:
    """Run what is needed and draw the wanted ones of the figures 6, 7 and 8 into the folder."""
    pictures = [folder / f"figure_{number}.png" for number in wanted]
    scenes = find_scenes()
    models = {**COMPARED, **OTHERS} if "6" in wanted else COMPARED
    with tempfile.TemporaryDirectory(prefix="contensou-") as place:
        runs, zooms = {}, {}
        for model, scene in scenes.items():
            if model in models:
                print(f"figures: running {scene.name}", file=sys.stderr)
                runs[model] = run(scene, Path(place, f"{model}.h5"), output__interval=INTERVAL)
        for model in COMPARED if "7" in wanted else ():
            hand_over = find_hand_over(runs[model])
            end = max(
                window(hand_over.start, hand_over.end, 0.1, 0.1)[1],
                window(*hand_over.attempts[-1])[1],
            )
            print(f"figures: running the zoom, {model}", file=sys.stderr)
            zooms[model] = run(
                scenes[model],
                Path(place, f"{model}-zoom.h5"),
                output__interval=ZOOM_INTERVAL,
                scene__t_end=float(end) + 2 * ZOOM_INTERVAL,
            )
        for number, picture in zip(wanted, pictures, strict=True):
            if number == "6":
                figure_6(runs, picture)
            elif number == "7":
                figure_7(runs, zooms, picture)
            else:
                figure_8(runs, picture)
    return pictures
