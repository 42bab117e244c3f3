"""Figure 10 of Kosenko and Aleksandrov (2009), from fresh runs of their ball bearing.

The scene is inputs/bearing_paper.nml: the friction force on one ball at the inner raceway, with
Hertz's normal force and with Vil'ke's and the spot of the paper. The steps of a run scatter by 5 %,
whichever the force, so that the CPU times of the two are summed over some tolerances; their runs
take turns, so that what else the machine does strikes both.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np

from . import program, style
from .results import Result, ResultError, open_file

SCENE = program.ROOT / "inputs" / "bearing_paper.nml"
CONTACT, BALL = "bearing_inner_1", "bearing_ball_1"
SOURCE = (
    "Own runs of inputs/bearing_paper.nml after Kosenko and Aleksandrov (2009), "
    "doi 10.3384/ecp09430006. No copy: loads, speeds and scales are ours."
)

# Settings, colour and name of each normal force.
MODELS = {
    "hertz": (["bearing.normal='hertz'"], style.OTHER_MODELS["hertz"], "Hertz"),
    "vilke": (
        ["bearing.normal='vilke'", "bearing.ellipse='chord'"],
        style.OTHER_MODELS["vilke"],
        "Vil'ke, chord",
    ),
}

# Tolerances of the runs whose CPU times are summed.
TOLERANCES = [1.0e-8 * (1.0 + 0.03 * i) for i in range(12)]
INTERVAL = 2.0e-5  # of the rows of the picture [s]
ZOOM = 0.06  # share of the time that the final stage takes


def run(output: Path, settings: list[str]) -> tuple[float, int]:
    """Run the scene; its CPU time [s] and its steps."""
    words = ["run", SCENE, "-o", output, "--force", "-q"]
    for setting in settings:
        words += ["--set", setting]
    program.call(*words)
    with open_file(output) as file:
        return float(file["summary/cpu_s"][()]), int(file["summary/steps"][()])


def measure(folder: Path) -> tuple[dict[str, float], dict[str, float]]:
    """Mean CPU times [s] and steps of both models over the tolerances."""
    seconds = dict.fromkeys(MODELS, 0.0)
    steps = dict.fromkeys(MODELS, 0.0)
    for number, rtol in enumerate(TOLERANCES, 1):
        print(f"figures: running {SCENE.name}, {number} of {len(TOLERANCES)}", file=sys.stderr)
        for model, (settings, _, _) in MODELS.items():
            once = [
                run(folder / "measured.h5", [*settings, f"integrator.rtol={rtol!r}"])
                for _ in range(2)
            ]
            seconds[model] += min(cpu for cpu, _ in once) / len(TOLERANCES)
            steps[model] += once[0][1] / len(TOLERANCES)
    return seconds, steps


def force_along(result: Result) -> np.ndarray:
    """Friction force of the inner ring on the ball along the path of the ball [N]."""
    if CONTACT not in result.contacts or BALL not in result.bodies:
        raise ResultError(f"{result.path} has no contact {CONTACT} of a body {BALL}")
    place = result.column("position")[:, result.bodies.index(BALL), :2]
    along = np.stack([-place[:, 1], place[:, 0]], axis=1)
    along /= np.linalg.norm(along, axis=1)[:, None]
    force = result.column("friction_force")[:, result.contacts.index(CONTACT), :2]
    return np.sum(force * along, axis=1)


def shape_of_spot(result: Result) -> float:
    """The parameter c = 1 - (b/a)^2 of the spot at the end."""
    axes = result.column("semi_axes")[-1, result.contacts.index(CONTACT)]
    return 1.0 - (axes[1] / axes[0]) ** 2


def figure_10(results: dict[str, Result], ratio: float, path: Path) -> None:
    """The friction force over the whole run, in its final stage, and what the models differ by."""
    figure, grid = style.panels([1.8, 1.8, 1.2], columns=2, width=12.0, legend=2.0)
    for axes in grid[:, 1]:
        axes.remove()
    whole, zoom, apart = grid[:, 0]
    for axes in (whole, zoom, apart):
        box = axes.get_position()
        axes.set_position([box.x0, box.y0, 0.83 - box.x0, box.height])
    end = max(result.time[-1] for result in results.values())
    spans = {whole: (0.0, end), zoom: ((1.0 - ZOOM) * end, end)}
    for axes, (start, stop) in spans.items():
        for model, (_, colour, name) in MODELS.items():
            result = results[model]
            inside = (result.time >= start) & (result.time <= stop)
            axes.plot(
                1e3 * result.time[inside],
                1e3 * force_along(result)[inside],
                color=colour,
                linewidth=2.4 if model == "hertz" else 1.2,
                label=f"{name}, c = {shape_of_spot(result):.3f}",
            )
        axes.set_xlim(1e3 * start, 1e3 * stop)
        axes.set_ylabel("force [mN]")
    hertz, vilke = (results[model] for model in MODELS)
    apart.plot(
        1e3 * hertz.time,
        1e6 * (force_along(vilke) - force_along(hertz)),
        color=style.DARK,
        linewidth=1.2,
    )
    # Where the ramp begins and ends the force jumps, and a row may fall between the two jumps.
    apart.set_ylim(-80, 40)
    apart.set_xlim(0.0, 1e3 * end)
    apart.set_ylabel("difference [µN]")
    for axes in (whole, zoom, apart):
        axes.set_xlabel("time [ms]")
        axes.yaxis.set_label_coords(-0.075, 0.5)
    whole.set_title("Friction force of the inner raceway on ball 1 along its path")
    zoom.set_title("Final stage")
    apart.set_title("Vil'ke less Hertz, whole run")
    whole.axvspan(*(1e3 * time for time in spans[zoom]), color=style.LIGHT, zorder=0)
    style.legend_beside(whole)
    style.headline(figure, f"Figure 10: Hertz against Vil'ke, CPU time {ratio:.2f} to 1", SOURCE)
    style.save(figure, path)


def draw(folder: Path, _: list[str]) -> list[Path]:
    """Draw the figure into the folder, and print what the models cost."""
    with tempfile.TemporaryDirectory(prefix="contensou-") as place:
        seconds, steps = measure(Path(place))
        results = {}
        for model, (settings, _, _) in MODELS.items():
            output = Path(place, f"{model}.h5")
            run(output, [*settings, f"output.interval={INTERVAL!r}"])
            results[model] = Result(output)
        for model, (_, _, name) in MODELS.items():
            print(
                f"{name}: c = {shape_of_spot(results[model]):.4f}, {steps[model]:.0f} steps, "
                f"{seconds[model]:.3f} s of CPU"
            )
        ratio = seconds["hertz"] / seconds["vilke"]
        print(
            f"CPU time of Hertz over that of Vil'ke: {ratio:.3f}, mean of {len(TOLERANCES)} "
            "tolerances, runs taking turns; in the paper Vil'ke is 20 % faster"
        )
        figure_10(results, ratio, folder / "figure_10.png")
    return [folder / "figure_10.png"]
