"""Run the regression cases, renew them, measure their tolerances, add one."""

from __future__ import annotations

import argparse
import shutil
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from lib import program as executable
from lib import regression
from lib.regression import Case
from lib.results import ResultError

# A case takes about so many seconds of CPU, and has about so many rows.
SECONDS = 0.5
ROWS = 20


def chosen(names: list[str]) -> list[Case]:
    """The cases of these names, all if there are none."""
    known = {case.name: case for case in regression.cases()}
    for name in names:
        if name not in known:
            raise ResultError(f"no case '{name}'; there are {', '.join(known)}")
    return [known[name] for name in names] if names else list(known.values())


def run_all(cases: list[Case], program: Path) -> list[tuple[Case, bool, str]]:
    """Run the cases, some at a time, and print a line for each."""
    found = []
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor() as pool:
        begin = time.monotonic()
        tasks = [
            (case, pool.submit(regression.check, case, program, Path(folder))) for case in cases
        ]
        for case, task in tasks:
            good, words = task.result()
            print(f"{case.name:<30} {'holds' if good else 'DIFFERS'}", flush=True)
            found.append((case, good, words))
    print(f"{len(cases)} cases in {time.monotonic() - begin:.1f} s", file=sys.stderr)
    return found


def test(cases: list[Case], program: Path) -> int:
    """Compare all cases with their references."""
    found = run_all(cases, program)
    for case, good, words in found:
        if not good:
            print(f"\n{case.name}: reference A, this program B\n{words}")
    missing = regression.scenes_without_case()
    for name in missing:
        print(f"inputs/{name} has no case: scripts/regress --add inputs/{name}")
    bad = sum(not good for _, good, _ in found) + len(missing)
    print(f"{len(found) + len(missing) - bad} passed, {bad} failed")
    return 1 if bad else 0


def update(cases: list[Case], program: Path) -> int:
    """Renew the references that no longer hold, and print what changed."""
    for case, good, words in run_all(cases, program):
        if good:
            continue
        print(f"\n{case.name}: old reference A, new one B\n{words}", flush=True)
        show(case, regression.renew(case, program))
    return 0


def show(case: Case, spread: regression.Spread) -> None:
    """Print how far each result moved, and what is tolerated."""
    print(f"{case.name}: {spread.runs} runs with an input changed in its last digits")
    for key in spread.refused:
        print(f"   {key} admits no change upwards or downwards")
    print(f"   {'data set':<32} {'spread':>8} {'tolerance':>10} {'largest value':>14}")
    for path, far in sorted(spread.largest.items()):
        size = abs(spread.values[path]).max(initial=0.0)
        words = "exact" if path in regression.EXACT else f"{regression.tolerance(spread, path):.0e}"
        if regression.COUNTS.search(path):
            words = "ignored"
        elif regression.is_vague(spread, path):
            words = f"{words}: too vague, ignored"
        print(f"   {path:<32} {far:8.1e} {words:>10} {size:14.1e}")


def measure(cases: list[Case], program: Path) -> int:
    """Print the measurement; references and rules stay as they are."""
    for case in cases:
        show(case, regression.measure(case, program))
    return 0


def shortened(case: Case, program: Path) -> None:
    """Choose an end of time and an interval of rows where the overrides name none."""
    keys = {item.partition("=")[0] for item in case.overrides}
    with tempfile.TemporaryDirectory() as name:
        output = Path(name) / "run.h5"
        done = regression.call(program, "check", case.scene, *case.words(), folder=Path(name))
        if done.returncode != 0:
            raise ResultError(done.stderr)
        text = done.stdout.partition("\nsettings\n")[2]
        line = next(word for word in text.splitlines() if word.strip().startswith("t_end = "))
        t_end = float(line.partition("=")[2])
        while "scene.t_end" not in keys:
            words = [*case.words(), "--set", f"scene.t_end={t_end:g}"]
            words += ["--set", f"output.interval={t_end / ROWS:g}"]
            begin = time.monotonic()
            regression.simulate(program, case.scene, output, words)
            if time.monotonic() - begin < 2.0 * SECONDS:
                break
            t_end = float(f"{t_end / 2.0:.2g}")
    if "scene.t_end" not in keys:
        case.overrides.append(f"scene.t_end={t_end:g}")
    if "output.interval" not in keys:
        case.overrides.append(f"output.interval={t_end / ROWS:g}")


def add(scene: Path, overrides: list[str], program: Path) -> int:
    """Make a new case, or an old one anew."""
    if not scene.is_file():
        raise ResultError(f"{scene} is no file")
    case = Case(scene.stem, scene.resolve(), list(overrides))
    is_new = not case.folder.exists()
    try:
        shortened(case, program)
        regression.write_case(case)
        show(case, regression.renew(case, program))
    except ResultError:
        if is_new:
            shutil.rmtree(case.folder, ignore_errors=True)
        raise
    size = case.reference.stat().st_size
    print(f"{case.folder.relative_to(regression.ROOT)}: {' '.join(case.overrides)}, {size} bytes")
    return 0


def main() -> int:
    """Read the command line and do what it says."""
    parser = argparse.ArgumentParser(prog="scripts/regress", description=__doc__)
    parser.add_argument("cases", nargs="*", metavar="CASE")
    parser.add_argument("--update", action="store_true", help="renew what no longer holds")
    parser.add_argument("--measure", action="store_true", help="measure, and change nothing")
    parser.add_argument("--add", type=Path, metavar="SCENE", help="add a case")
    parser.add_argument("--set", action="append", default=[], metavar="PATH=VALUE")
    parser.add_argument("--program", type=Path, default=executable.PROGRAM, metavar="FILE")
    arguments = parser.parse_args()
    program = arguments.program.resolve()
    try:
        if not program.is_file():
            raise ResultError(f"there is no executable {program}")
        if arguments.add:
            return add(arguments.add, arguments.set, program)
        cases = chosen(arguments.cases)
        if arguments.update:
            return update(cases, program)
        if arguments.measure:
            return measure(cases, program)
        return test(cases, program)
    except ResultError as problem:
        print(f"error: {problem}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
