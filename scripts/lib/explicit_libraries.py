"""Explicit methods of libraries beside explicit8, at equal error of a touch.

`tests/cost/library_explicit8` integrates the lightly damped Tippe-Top, whose contact rings all the
time, to the first touch of its stem, by a method of GSL or SUNDIALS, by explicit8 or by a bare loop
with the same pair. Each method is taken at the loosest tolerance from which on the error of
the touch stays below a bound, and its CPU time there is the smallest of some runs.
"""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import h5py

from .results import ResultError

SCENE = ("tippe_top.nml", "stem_floor")
SETTINGS = (
    "ball_floor.damping_coefficient=0.2",
    "stem_floor.damping_coefficient=0.2",
    "scene.t_end=1.706",
)

# Methods of the program, and their names in the table.
METHODS = {
    "bare": "bare loop, the same pair",
    "explicit8": "explicit8: GSL rk8pd, control of our own",
    "gsl_rk8pd": "GSL rk8pd, GSL's control",
    "erkstep": "SUNDIALS ERKStep, Fehlberg 7(8)",
    "erkstep_mended": "the same, mended",
    "erkstep_pair": "ERKStep, pair of rk8pd, mended",
}

# The executable, which writes a row each millisecond, too.
WHOLE_RUN = "run"
WHOLE_RUN_NAME = "explicit8, whole run with output"

BOUNDS = (1e-6, 1e-7)

# Five tolerances a decade, the tightest first. Below 2e-9 positions are held to their rounding.
TOLERANCES = tuple(10.0 ** (-i / 5) for i in range(43, 22, -1))

REFERENCE_RTOL = 1e-10


@dataclass(frozen=True)
class Run:
    """One integration: time of the touch, work, and CPU seconds."""

    touch: float
    steps: int
    right_hand_sides: int
    cpu: float


@dataclass(frozen=True)
class Cost:
    """What a method needs for an error."""

    rtol: float
    error: float
    run: Run


class Study:
    """Runs of the methods with the programs of a build folder."""

    def __init__(self, build: Path, inputs: Path) -> None:
        self.program = build / "tests" / "cost" / "library_explicit8"
        self.executable = build / "drivers" / "contensou"
        self.scene = inputs / SCENE[0]
        self.reference = self.run("explicit8", REFERENCE_RTOL).touch

    def run(self, method: str, rtol: float) -> Run:
        """One run of a method."""
        if method == WHOLE_RUN:
            return self._whole_run(rtol)
        words = (self.program, self.scene, method, f"{rtol:.8e}", SCENE[1], *SETTINGS)
        time, kind, *numbers = _output(words).split()
        if kind != "touch":
            raise ResultError(f"{method} at rtol {rtol:.0e} finds no touch until {time} s")
        return Run(float(time), int(numbers[0]), int(numbers[1]), float(numbers[2]))

    def _whole_run(self, rtol: float) -> Run:
        """One run of the executable, without the time that a file takes which holds nothing."""
        settings = [*SETTINGS, "integrator.method=explicit8", f"integrator.rtol={rtol:.8e}"]
        with tempfile.TemporaryDirectory() as place:
            path = Path(place) / "run.h5"
            words = [self.executable, "run", self.scene, "-o", path, "--force", "-q"]
            words += [word for text in settings for word in ("--set", text)]
            _output([*words, "--set", "scene.t_end=1e-9", "--set", "output.interval=1e-9"])
            with h5py.File(path) as file:
                empty = float(file["integrator/cpu_integration"][()])
            _output(words)
            with h5py.File(path) as file:
                events = zip(
                    file["events/time"][()],
                    file["events/kind"].asstr()[()],
                    file["events/contact"].asstr()[()],
                    strict=True,
                )
                touch = next(t for t, kind, name in events if (kind, name) == ("touch", SCENE[1]))
                group = file["integrator"]
                return Run(
                    float(touch),
                    int(group["steps"][()]),
                    int(group["right_hand_sides"][()]),
                    float(group["cpu_integration"][()]) - empty,
                )

    def error(self, run: Run) -> float:
        """Error of the time of the touch."""
        return abs(run.touch - self.reference)

    def cheapest(self, method: str, bounds: Iterable[float]) -> dict[float, Cost]:
        """The loosest tolerance from which on the error stays below each bound."""
        found: dict[float, Cost] = {}
        open_bounds = set(bounds)
        for rtol in TOLERANCES:
            run = self.run(method, rtol)
            error = self.error(run)
            open_bounds = {bound for bound in open_bounds if error <= bound}
            found |= {bound: Cost(rtol, error, run) for bound in open_bounds}
            if not open_bounds:
                break
        return found

    def repeat(self, costs: dict[str, Cost], times: int) -> dict[str, float]:
        """Smallest CPU time of each method; alternating runs share the moods of the machine."""
        cpu = {method: cost.run.cpu for method, cost in costs.items()}
        for _ in range(times):
            for method, cost in costs.items():
                cpu[method] = min(cpu[method], self.run(method, cost.rtol).cpu)
        return cpu


def table(build: Path, inputs: Path, repeats: int = 6) -> list[str]:
    """What each method needs for each bound of the error, over the bare loop."""
    study = Study(build, inputs)
    names = METHODS | {WHOLE_RUN: WHOLE_RUN_NAME}
    found = {method: study.cheapest(method, BOUNDS) for method in names}
    lines = [
        "| error at most [s] | method | rtol | touch error [s] | steps | right-hand sides "
        "| CPU [s] | CPU over bare loop |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for bound in BOUNDS:
        costs = {method: found[method][bound] for method in names if bound in found[method]}
        cpu = study.repeat(costs, repeats)
        for method, name in names.items():
            if method not in costs:
                lines.append(f"| {bound:.0e} | {name} | - | - | - | - | - | - |")
                continue
            cost = costs[method]
            lines.append(
                f"| {bound:.0e} | {name} | {cost.rtol:.1e} | {cost.error:.1e} | {cost.run.steps} "
                f"| {cost.run.right_hand_sides} | {cpu[method]:.4f} "
                f"| {cpu[method] / cpu['bare']:.2f} |"
            )
    return lines


def _output(words: Iterable[object]) -> str:
    """What a program writes to the standard output."""
    command = [str(word) for word in words]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise ResultError(f"{' '.join(command)} ended with {done.returncode}:\n{done.stderr}")
    return done.stdout
