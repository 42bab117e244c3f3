"""Measure times in pairs, and compare them with bars and with recorded ones; see docs/times.md.

What is compared runs by turns, so that it shares the moods of the machine, and the least CPU time
of each counts: it is the one that was disturbed least. Rounds are added while a bar is missed, up
to some: a bar that holds in a quiet moment holds.
"""

from __future__ import annotations

import argparse
import csv
import os
import re
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import h5py

from lib import explicit_libraries
from lib.many_balls import many_balls
from lib.program import PROGRAM, ROOT
from lib.results import ResultError

INPUTS = ROOT / "inputs"
COST = PROGRAM.parent.parent / "tests" / "cost"
RECORD = ROOT / "tests" / "times.csv"

# Change against the recorded value that is worth a word.
NOTABLE = 1.15


@dataclass(frozen=True)
class Bar:
    """What a measured value has to keep."""

    name: str
    what: str
    relation: str
    limit: float

    def met(self, value: float) -> bool:
        """Whether a value keeps it."""
        return value <= self.limit if self.relation == "<=" else value >= self.limit


@dataclass(frozen=True)
class Measurement:
    """Bars whose values are measured together."""

    bars: tuple[Bar, ...]
    measure: Callable[[Path, Callable[[dict[str, float]], bool]], dict[str, float]]


def execute(
    words: list[object], folder: Path, limit: float | None = None
) -> tuple[float, float, str]:
    """CPU time with children and wall time of a program [s], and its standard output."""
    before, begin = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    done = subprocess.run(
        [str(word) for word in words],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
        timeout=limit,
    )
    after, end = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    if done.returncode != 0:
        command = " ".join(map(str, words))
        raise ResultError(f"{command} ended with {done.returncode}:\n{done.stdout}{done.stderr}")
    used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return used, end - begin, done.stdout


def settings(**values: object) -> list[str]:
    """Words that set keys of a scene, a double underscore for the dot."""
    pairs = (f"{path.replace('__', '.')}={value}" for path, value in values.items())
    return [word for pair in pairs for word in ("--set", pair)]


def integrate(scene: Path, folder: Path, *more: str, limit: float | None = None) -> float:
    """CPU time of the integration of a scene [s], which may take a limit of wall time [s]."""
    words = [PROGRAM, "run", scene, "-q", "-o", folder / "x.h5", "--force", *more]
    execute(words, folder, limit)
    with h5py.File(folder / "x.h5") as file:
        return float(file["integrator/cpu_integration"][()])


def least(
    works: dict[str, Callable[[], float]],
    values: Callable[[dict[str, float]], dict[str, float]],
    good: Callable[[dict[str, float]], bool],
    rounds: tuple[int, int] = (5, 30),
) -> dict[str, float]:
    """Values of the least times of works that take turns."""
    seconds = dict.fromkeys(works, float("inf"))
    for done in range(1, rounds[1] + 1):
        for name, work in works.items():
            seconds[name] = min(seconds[name], work())
        if done >= rounds[0] and good(values(seconds)):
            break
    return values(seconds)


# ---- Runs ----------------------------------------------------------------------------------------


def run_over_bare(folder, good):
    """The whole command with its file against CVODE alone."""
    scene = INPUTS / "tippe_top.nml"
    command = [PROGRAM, "run", scene, "-o", "run.h5", "--force", "-q"]
    return least(
        {
            "run": lambda: execute(command, folder)[0],
            "bare": lambda: execute([COST / "bare_cvode", scene], folder)[0],
        },
        lambda t: {"run_over_bare_cvode": t["run"] / t["bare"]},
        good,
    )


def equal_error(folder, good):
    """Tippe-Top with light damping to the first touch of its stem, both with errors of 5e-7 s."""
    text = (INPUTS / "tippe_top.nml").read_text().replace("t_end = 8.0", "t_end = 1.706")
    text = text.replace("damping_coefficient = 100.0", "damping_coefficient = 0.2")
    scene = folder / "light.nml"
    scene.write_text(text)
    bare = folder / "bare.nml"
    bare.write_text(text.replace("'cvode_bdf', rtol = 1.0e-8", "'explicit8', rtol = 3.0e-7"))

    def method(name, rtol, *more):
        chosen = settings(integrator__method=name, integrator__rtol=rtol)
        return lambda: integrate(scene, folder, *chosen, *more)

    empty = settings(scene__t_end=1e-9, output__interval=1e-9)

    def values(t):
        # What a file costs that holds next to nothing is not the method's.
        own = t["explicit8"] - t["empty"]
        return {
            "explicit8_over_cvode": (t["cvode_bdf"] - t["empty"]) / own,
            "explicit8_over_bare": own / t["bare"],
        }

    return least(
        {
            "explicit8": method("explicit8", 3e-7),
            "cvode_bdf": method("cvode_bdf", 1e-10),
            "bare": lambda: float(execute([COST / "bare_explicit8", bare], folder)[2].split()[2]),
            "empty": method("explicit8", 3e-7, *empty),
        },
        values,
        good,
        rounds=(3, 12),
    )


def libraries(folder, good):
    """What an error of the touch of 1e-6 s costs with methods of libraries."""
    if not (COST / "library_explicit8").is_file():
        print("  no ERKStep of SUNDIALS: methods of libraries are not measured", file=sys.stderr)
        return {}
    study = explicit_libraries.Study(PROGRAM.parent.parent, INPUTS)
    names = [*explicit_libraries.METHODS, explicit_libraries.WHOLE_RUN]
    costs = {name: study.cheapest(name, [1e-6])[1e-6] for name in names}

    def values(t):
        return {
            "pair_over_bare": t["explicit8"] / t["bare"],
            "whole_run_over_bare": t[explicit_libraries.WHOLE_RUN] / t["bare"],
            "pair_over_gsl": t["explicit8"] / t["gsl_rk8pd"],
            "pair_over_erkstep": t["explicit8"] / min(t[name] for name in t if "erkstep" in name),
        }

    def work(name):
        return lambda: study.run(name, costs[name].rtol).cpu

    return least({name: work(name) for name in names}, values, good, rounds=(3, 12))


def profile(folder, good):
    """Two scenes with and without --profile; the worse of the two."""
    scenes = {
        "tippe_top": settings(integrator__method="explicit8", output__interval=0.1),
        "bearing_paper": settings(
            integrator__method="cvode_bdf", scene__t_end=0.1, output__interval=0.1
        ),
    }

    def work(name, *more):
        return lambda: integrate(INPUTS / f"{name}.nml", folder, *scenes[name], *more)

    works = {name: work(name) for name in scenes}
    works |= {f"{name} profiled": work(name, "--profile") for name in scenes}
    return least(
        works,
        lambda t: {"profile": max(t[f"{name} profiled"] / t[name] for name in scenes)},
        good,
        rounds=(4, 60),
    )


def choice(folder, good):
    """`auto` beside the best method, the worst of all shipped scenes."""

    def work(scene, method, limit):
        # A bearing takes seconds of CPU for hundredths of a second.
        t_end = {"bearing_6205.nml": 0.01, "bearing_paper.nml": 0.1}.get(scene.name, 3)
        words = settings(integrator__method=method, output__interval=0.1, scene__t_end=t_end)
        try:
            return integrate(scene, folder, *words, limit=limit)
        except subprocess.TimeoutExpired:
            return float("inf")
        except ResultError:
            # explicit8 gives up where friction sticks.
            if method == "auto":
                raise
            return float("inf")

    def values(t):
        # Choosing takes its time too, which tells in runs of hundredths of a second.
        others = min(seconds for name, seconds in t.items() if name != "auto")
        return {"auto_over_best": max(t["auto"] - 0.01, 0.0) / others}

    worst = 0.0
    for scene in sorted(INPUTS.glob("*.nml")):
        own = work(scene, "auto", 120.0)
        # What takes far longer than `auto` is not the best.
        limit = 1.0 + 5.0 * own
        others = ("cvode_bdf", "cvode_adams", "explicit8")
        seconds = {method: work(scene, method, limit) for method in others}
        near = [name for name in others if seconds[name] <= 2 * min(seconds.values())]
        works = {name: partial(work, scene, name, limit) for name in ("auto", *near)}
        worst = max(worst, least(works, values, good, rounds=(2, 8))["auto_over_best"])
    return {"auto_over_best": worst}


# ---- Sweeps --------------------------------------------------------------------------------------


def write_sweep(folder: Path, scene: str, changes: str, parameter: str) -> Path:
    """A sweep over one parameter of a scene."""
    (folder / "scene.nml").write_text(scene)
    path = folder / "sweep.nml"
    path.write_text(
        f"&sweep scene = 'scene.nml', output = 'table.h5'\n   {changes} /\n"
        f"&parameter {parameter} /\n"
    )
    return path


def sweep_of_tops(folder: Path, t_end: float) -> Path:
    """200 Tippe-Tops of other friction."""
    return write_sweep(
        folder,
        (INPUTS / "tippe_top.nml").read_text(),
        f"set = 'scene.t_end={t_end}'",
        "name = 'ball_floor.friction_coefficient', 'stem_floor.friction_coefficient', "
        "vary = 'linear', first = 0.15, last = 0.4, count = 200",
    )


def sweep_over_loop(folder, good):
    """A sweep on one thread, start-up and table included, against a loop over its cases."""
    path = sweep_of_tops(folder, 0.5)
    sweep = [PROGRAM, "sweep", path, "-j", 1, "--force"]
    return least(
        {
            "loop": lambda: execute([COST / "bare_sweep", path], folder)[0],
            "sweep": lambda: execute(sweep, folder)[0],
        },
        lambda t: {"sweep_over_loop": t["sweep"] / t["loop"]},
        good,
        rounds=(3, 20),
    )


def two_threads(folder, good):
    """Wall time on one thread over that on two, and the CPU time on two over that on one."""
    if len(os.sched_getaffinity(0)) < 2:
        print("  one core: two threads are not measured", file=sys.stderr)
        return {}
    path = sweep_of_tops(folder, 0.25)
    used = {}

    def work(threads):
        def run():
            cpu, wall, _ = execute([PROGRAM, "sweep", path, "-j", threads, "--force"], folder)
            used[threads] = min(cpu, used.get(threads, cpu))
            return wall

        return run

    return least(
        {"one": work(1), "two": work(2)},
        lambda t: {"two_threads": t["one"] / t["two"], "two_threads_cpu": used[2] / used[1]},
        good,
        rounds=(3, 20),
    )


BALL = """\
&scene title = 'Ball', gravity = 0, 0, -9.81, t_end = 1e-5 /
&material name = 'steel', young = 2.1e11, poisson = 0.3 /
&body name = 'ball', mass = 0.03, inertia = 3*1.2e-6, position = 0, 0, 0.0101,
   velocity = 0, 0, -1 /
&surface name = 'skin', body = 'ball', shape = 'sphere', radius = 1.0e-2, material = 'steel' /
&surface name = 'floor', body = 'ground', shape = 'plane', normal = 0, 0, 1, material = 'steel' /
&contact name = 'skin_floor', surfaces = 'skin', 'floor' /
&integrator method = 'explicit8', rtol = 1e-6 /
&output file = 'ball.h5', interval = 1 /
"""


def many_cases(folder, good):
    """CPU time per case of 40,000 trivial cases over that of 4,000."""
    counts = (4000, 40000)

    def work(count):
        def run():
            here = folder / str(count)
            here.mkdir(exist_ok=True)
            masses = (
                f"name = 'ball.mass', vary = 'linear', first = 0.02, last = 0.04, count = {count}"
            )
            path = write_sweep(here, BALL, "", masses)
            return execute([PROGRAM, "sweep", path, "-j", 1, "--force"], here)[0] / count

        return run

    return least(
        {str(count): work(count) for count in counts},
        lambda t: {"pace_of_many_cases": t["40000"] / t["4000"]},
        good,
        rounds=(2, 8),
    )


def forecast(folder, good):
    """What `check` says that a sweep takes, over what it takes."""
    path = write_sweep(
        folder,
        BALL.replace("t_end = 1e-5", "t_end = 0.05").replace("interval = 1", "interval = 1e-3"),
        "",
        "name = 'ball.velocity(1)', first = 0, last = 1, count = 1000",
    )
    hours = []

    def told():
        text = execute([PROGRAM, "check", path], folder)[2]
        hours.append(float(re.search(r"^ *cpu_hours +(\S+)", text, re.MULTILINE)[1]))
        return 3600 * min(hours)

    return least(
        {
            "told": told,
            "taken": lambda: execute([PROGRAM, "sweep", path, "-j", 1, "--force"], folder)[0],
        },
        lambda t: {"forecast": max(t["told"] / t["taken"], t["taken"] / t["told"])},
        good,
        rounds=(2, 8),
    )


# ---- Set-up and kernels --------------------------------------------------------------------------


def set_up(folder, good):
    """`check --expand` of 1,000 and 10,000 balls, and `check` of the latter."""
    for number in (1000, 10000):
        (folder / f"{number}.nml").write_text("\n".join(many_balls(number)) + "\n")

    def work(number, *more):
        return lambda: execute([PROGRAM, "check", f"{number}.nml", *more], folder)[0]

    return least(
        {"few": work(1000, "--expand"), "many": work(10000, "--expand"), "check": work(10000)},
        lambda t: {"set_up_of_many_bodies": t["many"] / t["few"] / 10, "check": t["check"]},
        good,
        rounds=(2, 8),
    )


def rows_of_kernels(folder, good):
    """Microseconds for a row of `eval`, text and all."""
    number = 100_000
    rows = {
        "elliptic": ("c1", lambda x: f"{x!r}"),
        "hertz": ("A,B,Estar,delta", lambda x: f"{50 * x!r},50,1e11,1e-6"),
        "wrench": ("N,a,b,f,vx,vy,w", lambda x: f"2,1e-3,{1e-3 * x!r},0.3,{2 * x!r},{x * x!r},1e3"),
    }
    for kernel, (names, row) in rows.items():
        lines = [names, *(row(i / number) for i in range(1, number))]
        (folder / f"{kernel}.csv").write_text("\n".join(lines) + "\n")

    def work(kernel):
        return lambda: execute([PROGRAM, "eval", kernel, f"{kernel}.csv"], folder)[0]

    return least(
        {kernel: work(kernel) for kernel in rows},
        lambda t: {f"eval_{kernel}": 1e6 * t[kernel] / number for kernel in rows},
        good,
        rounds=(3, 8),
    )


def kernels(folder, good):
    """The bars of `bench kernels` that are times; each counts in the best of some runs."""
    best: dict[str, float] = {}
    for _ in range(6):
        execute([PROGRAM, "bench", "kernels", "-o", "kernels", "--force"], folder)
        for bar, value in _kernel_bars(folder / "kernels.h5"):
            better = max if bar.relation == ">=" else min
            best[bar.name] = better(value, best.get(bar.name, value))
        if good(best):
            break
    return best


def _kernel_bars(path: Path) -> list[tuple[Bar, float]]:
    """The bars of times that the program itself has, and what it measured."""
    found = []
    with h5py.File(path) as file:
        bars = file["bar"]
        columns = (bars["name"].asstr()[()], bars["at_least"][()], bars["limit"][()])
        for name, at_least, limit, value in zip(*columns, bars["measured"][()], strict=True):
            if "error" not in name:
                short = "kernels " + name.replace(",", "").replace(":", "")
                relation = ">=" if at_least else "<="
                found.append((Bar(short, name, relation, float(limit)), float(value)))
    return found


# ---- All of them ---------------------------------------------------------------------------------

MEASUREMENTS = {
    "run": Measurement(
        (Bar("run_over_bare_cvode", "run with its file over CVODE alone", "<=", 1.5),),
        run_over_bare,
    ),
    "equal_error": Measurement(
        (
            Bar("explicit8_over_cvode", "cvode_bdf over explicit8 at equal error", ">=", 10.0),
            Bar("explicit8_over_bare", "explicit8 over a bare loop", "<=", 2.0),
        ),
        equal_error,
    ),
    "libraries": Measurement(
        (
            Bar("pair_over_bare", "explicit8 over a bare loop to the touch", "<=", 1.3),
            Bar("whole_run_over_bare", "the whole run over the bare loop", "<=", 1.5),
            Bar("pair_over_gsl", "explicit8 over GSL's control of its pair", "<=", 1.2),
            Bar("pair_over_erkstep", "explicit8 over the best of ERKStep", "<=", 1.0),
        ),
        libraries,
    ),
    "profile": Measurement((Bar("profile", "with --profile over without", "<=", 1.02),), profile),
    "auto": Measurement(
        (Bar("auto_over_best", "auto over the best method, worst scene", "<=", 1.5),), choice
    ),
    "sweep": Measurement(
        (Bar("sweep_over_loop", "sweep on one thread over a loop", "<=", 1.03),), sweep_over_loop
    ),
    "threads": Measurement(
        (
            Bar("two_threads", "one thread over two, wall time", ">=", 1.9),
            Bar("two_threads_cpu", "two threads over one, CPU time", "<=", 1.05),
        ),
        two_threads,
    ),
    "many_cases": Measurement(
        (Bar("pace_of_many_cases", "CPU per case, 40,000 over 4,000 cases", "<=", 1.2),),
        many_cases,
    ),
    "forecast": Measurement(
        (Bar("forecast", "forecast of check over the sweep, or inverse", "<=", 3.0),), forecast
    ),
    "set_up": Measurement(
        (
            Bar("set_up_of_many_bodies", "per group, 10,000 over 1,000 balls", "<=", 1.5),
            Bar("check", "check of 10,000 balls [s]", "<=", 3.0),
        ),
        set_up,
    ),
    "eval": Measurement(
        tuple(
            Bar(f"eval_{kernel}", f"a row of eval {kernel} [us]", "<=", 30.0)
            for kernel in ("elliptic", "hertz", "wrench")
        ),
        rows_of_kernels,
    ),
    "kernels": Measurement((), kernels),
}


def recorded() -> dict[str, float]:
    """The values of the table that measurements are compared with."""
    with RECORD.open(newline="") as file:
        return {row["name"]: float(row["value"]) for row in csv.DictReader(file)}


def take(name: str, measurement: Measurement) -> list[tuple[Bar, float]]:
    """Bars of a measurement, and what was measured."""
    bars = {bar.name: bar for bar in measurement.bars}
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)

        def good(values: dict[str, float]) -> bool:
            if name == "kernels":
                bars.update({bar.name: bar for bar, _ in _kernel_bars(folder / "kernels.h5")})
            return all(bars[key].met(value) for key, value in values.items())

        values = measurement.measure(folder, good)
    return [(bars[key], value) for key, value in values.items()]


def line(bar: Bar, value: float, known: float | None) -> str:
    """What a measurement has come to."""
    words = f"  {bar.what:<50} {value:9.3g}  {bar.relation} {bar.limit:<6.3g}"
    words += f" {known:9.3g}" if known is not None else " " * 10
    words += "  met" if bar.met(value) else "  MISSED"
    if known is not None:
        change = value / known if bar.relation == "<=" else known / value
        if change > NOTABLE:
            words += f", {change - 1:.0%} worse than recorded"
    return words


def main(arguments: list[str]) -> int:
    """Measure, print, compare; 1 when a bar is missed."""
    parser = argparse.ArgumentParser(prog="scripts/bench", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help="only these measurements")
    parser.add_argument("--list", action="store_true", help="names of the measurements")
    parser.add_argument("--record", action="store_true", help=f"renew {RECORD.relative_to(ROOT)}")
    options = parser.parse_args(arguments)
    if options.list:
        print("\n".join(MEASUREMENTS))
        return 0
    unknown = [name for name in options.names if name not in MEASUREMENTS]
    if unknown:
        parser.error(f"no measurement '{unknown[0]}'; there are {', '.join(MEASUREMENTS)}")
    known = recorded()
    missed = 0
    print(f"  {'':<50}  measured  bar       recorded")
    for name in options.names or MEASUREMENTS:
        for bar, value in take(name, MEASUREMENTS[name]):
            print(line(bar, value, known.get(bar.name)), flush=True)
            missed += not bar.met(value)
            if options.record:
                known[bar.name] = value
    if options.record:
        rows = [f"{name},{value:.3g}" for name, value in known.items()]
        RECORD.write_text("\n".join(["name,value", *rows]) + "\n")
    print(f"{missed} bars missed" if missed else "all bars met")
    return 1 if missed else 0


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except ResultError as error:
        sys.exit(f"error: {error}")
