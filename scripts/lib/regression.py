"""Regression cases: shortened scenes with a small reference and rules that a measurement gives.

A case is a folder of tests/regression with three files: `case.toml` (scene, overrides),
`reference.h5`, and `rules` in the form of `contensou diff`. The measurement changes each number
of the resolved scene in its last digits, one at a time, and notes how far each result moves. No
program can be expected to reproduce a result better than that: compilers and processors round
differently.
"""

from __future__ import annotations

import math
import os
import random
import re
import subprocess
import tempfile
import tomllib
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

import h5py
import numpy as np

from .results import ResultError

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "tests" / "regression"

# Relative changes of an input: some units of the last of its 16 digits, and some hundreds.
SMALLEST, LARGEST = 1e-15, 1e-13
# A tolerance is so many times the spread that was measured: a whole run rounds more often than
# the few numbers that are changed.
MARGIN = 20.0
# No tolerance is smaller than this share of the largest value of a data set: the rounding of
# reading and of sums alone.
FLOOR = 1e-13
# A data set whose tolerance would be more than this share of its largest value says nothing. Slip
# and spin are such where a row falls on the moment of a touch: they are zero while open.
VAGUE = 0.02
# Groups that a reference holds.
GROUPS = ("events", "integrator", "summary", "trajectory")
# What is known exactly, whatever the rounding.
EXACT = {
    "/trajectory/time",
    "/summary/time",
    "/summary/rows",
    "/summary/touches",
    "/summary/lifts",
}
# Times differ from run to run.
TIMES = re.compile(r"/(cpu|wall)_|/provenance/")
# What the program chooses by itself: steps depend on rounding, and no result is the worse for it.
COUNTS = re.compile(r"/integrator/|/summary/(steps|right_hand_sides)$")
# Settings that say which rows there are.
FRAME = {"t_end", "interval"}
# A number in a resolved scene, no part of a name.
NUMBER = re.compile(r"(?<![\w.'])[-+]?\d+\.\d*(?:[eE][-+]?\d+)?(?![\w.'])")
TIMEOUT = 600


@dataclass
class Case:
    """A scene with overrides."""

    name: str
    scene: Path
    overrides: list[str] = field(default_factory=list)

    @property
    def folder(self) -> Path:
        """Where its files are."""
        return FOLDER / self.name

    @property
    def reference(self) -> Path:
        """The file to compare with."""
        return self.folder / "reference.h5"

    @property
    def rules(self) -> Path:
        """The tolerances."""
        return self.folder / "rules"

    def words(self) -> list[str]:
        """The overrides as words of a command line."""
        return [word for item in self.overrides for word in ("--set", item)]


def cases() -> list[Case]:
    """All cases by name."""
    found = []
    for path in sorted(FOLDER.glob("*/case.toml")):
        content = tomllib.loads(path.read_text())
        found.append(Case(path.parent.name, ROOT / content["scene"], content.get("set", [])))
    return found


def scenes_without_case() -> list[str]:
    """Shipped scenes that no case runs."""
    have = {case.scene.resolve() for case in cases()}
    return sorted(p.name for p in (ROOT / "inputs").glob("*.nml") if p.resolve() not in have)


def call(program: Path, *words: object, folder: Path) -> subprocess.CompletedProcess:
    """Run the program in a folder."""
    command = [str(program), *map(str, words)]
    try:
        return subprocess.run(
            command, cwd=folder, capture_output=True, text=True, timeout=TIMEOUT, check=False
        )
    except subprocess.TimeoutExpired:
        raise ResultError(f"{' '.join(command)} took more than {TIMEOUT} s") from None


def simulate(program: Path, scene: Path, output: Path, words: list[str]) -> None:
    """Run a scene."""
    done = call(program, "run", scene, "-q", "--force", "-o", output, *words, folder=output.parent)
    if done.returncode != 0:
        raise ResultError(f"the run of {scene.name} ended with {done.returncode}:\n{done.stderr}")


def compare(program: Path, a: Path, b: Path, rules: Path) -> tuple[bool, str]:
    """Whether b is like a, and what `contensou diff` says."""
    done = call(program, "diff", a, b, "--rules", rules, folder=b.parent)
    return done.returncode == 0, done.stdout + done.stderr


def check(case: Case, program: Path, folder: Path) -> tuple[bool, str]:
    """Run a case and compare it with its reference; whether it holds, and what there is to say."""
    output = folder / f"{case.name}.h5"
    if not case.reference.is_file() or not case.rules.is_file():
        return False, f"{case.name} has no reference; scripts/regress --update makes it\n"
    try:
        simulate(program, case.scene, output, case.words())
        return compare(program, case.reference, output, case.rules)
    except ResultError as problem:
        return False, f"{problem}\n"


def results(path: Path) -> dict[str, np.ndarray]:
    """All numbers of a file that depend on the motion."""
    with h5py.File(path) as file:
        return {
            f"/{group}/{name}": item[()]
            for group in GROUPS
            for name, item in file[group].items()
            if item.dtype.kind in "fi" and not TIMES.search(f"/{group}/{name}")
        }


def kinds(path: Path) -> list[tuple[str, str]]:
    """The events of a file."""
    with h5py.File(path) as file:
        events = file["events"]
        return list(zip(events["kind"].asstr()[:], events["contact"].asstr()[:], strict=True))


def write_reference(source: Path, target: Path) -> None:
    """Copy the results of a run, with scales and units, to a file as small as can be."""
    with h5py.File(source) as a, h5py.File(target, "w", libver=("earliest", "v110")) as b:
        for group in GROUPS:
            b.create_group(group)
            for name, item in a[group].items():
                if TIMES.search(f"/{group}/{name}"):
                    continue
                b[group].create_dataset(name, data=item[()], dtype=item.dtype)
                if "units" in item.attrs:
                    b[group][name].attrs["units"] = item.attrs["units"]
            for name, item in a[group].items():
                if name in b[group] and item.is_scale:
                    b[group][name].make_scale(name)
            for name, item in a[group].items():
                if name not in b[group] or item.is_scale:
                    continue
                for i, dimension in enumerate(item.dims):
                    for scale in dimension.values():
                        label = scale.name.rpartition("/")[2]
                        b[group][name].dims[i].attach_scale(b[group][label])


def perturbed(text: str, dice: random.Random):
    """The resolved scene with one of its numbers changed in the last digits, each in turn."""
    lines = text.split("\n")
    group = ""
    for i, line in enumerate(lines):
        if line.startswith("&"):
            group = line[1:]
        key, equals, values = line.partition(" = ")
        if not equals or key.strip() in FRAME or "'" in values:
            continue
        for match in NUMBER.finditer(values):
            value = float(match[0])
            if value == 0.0:
                continue
            share = math.exp(dice.uniform(math.log(SMALLEST), math.log(LARGEST)))
            changed = value * (1.0 + share * dice.choice([-1, 1]))
            if changed == value:
                changed = math.nextafter(value, math.inf)
            new = values[: match.start()] + repr(changed) + values[match.end() :]
            yield (
                f"{group}.{key.strip()}",
                "\n".join([*lines[:i], f"{key} = {new}", *lines[i + 1 :]]),
            )


@dataclass
class Spread:
    """How far results move when inputs change in their last digits."""

    values: dict[str, np.ndarray]
    largest: dict[str, float]
    runs: int = 0
    refused: list[str] = field(default_factory=list)


def measure(case: Case, program: Path, jobs: int = 0) -> Spread:
    """Change each input of a case in its last digits and see how far each result moves."""
    dice = random.Random(case.name)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        base = folder / "base.h5"
        simulate(program, case.scene, base, case.words())
        with h5py.File(base) as file:
            resolved = file["input/resolved"].asstr()[()]
        whole = results(base)
        (folder / "resolved.nml").write_text(resolved)
        simulate(program, folder / "resolved.nml", folder / "resolved.h5", [])
        spread = Spread(whole, dict.fromkeys(whole, 0.0))

        def one(task) -> tuple[str, dict[str, np.ndarray] | None]:
            i, (key, text) = task
            scene, output = folder / f"{i}.nml", folder / f"{i}.h5"
            scene.write_text(text)
            done = call(program, "run", scene, "-q", "-o", output, folder=folder)
            if done.returncode == 2:
                # The last digit can leave what is admissible, as in the moments of a disc.
                return key, None
            if done.returncode != 0:
                raise ResultError(f"{case.name} with {key} changed:\n{done.stderr}")
            if kinds(output) != kinds(base):
                raise ResultError(
                    f"{case.name} is too sensitive: the last digits of {key} change its events;"
                    " an earlier scene.t_end may help"
                )
            moved = results(output)
            output.unlink()
            return key, moved

        with ThreadPoolExecutor(jobs or os.cpu_count()) as pool:
            for key, moved in pool.map(one, enumerate(perturbed(resolved, dice))):
                if moved is None:
                    spread.refused.append(key)
                    continue
                spread.runs += 1
                for path, values in moved.items():
                    if values.size:
                        far = float(np.abs(values - whole[path]).max())
                        spread.largest[path] = max(spread.largest[path], far)
    if spread.runs == 0:
        raise ResultError(f"{case.name}: no number of the scene can be changed")
    # The summary's last state is a row like others, and its work or energy a value of such a row.
    for path in spread.largest:
        like = path.replace("/summary/", "/trajectory/")
        if path != like and like in spread.largest:
            spread.largest[path] = max(spread.largest[path], spread.largest[like])
    return spread


def tolerance(spread: Spread, path: str) -> float:
    """The absolute tolerance of a data set."""
    size = float(np.abs(spread.values[path]).max(initial=0.0))
    value = max(MARGIN * spread.largest[path], FLOOR * size)
    if value == 0.0:
        return 0.0
    # One digit, rounded up.
    unit = 10.0 ** math.floor(math.log10(value))
    return float(f"{math.ceil(value / unit * (1 - 1e-12)) * unit:.0e}")


def is_vague(spread: Spread, path: str) -> bool:
    """Whether the tolerance would let everything pass; a residual is nothing but rounding."""
    size = float(np.abs(spread.values[path]).max(initial=0.0))
    return "energy_error" not in path and tolerance(spread, path) > VAGUE * size > 0.0


def rules_text(case: Case, spread: Spread) -> str:
    """The rules of a case, with the spread that justifies each."""
    lines = [
        f"# {case.name}: {spread.runs} runs, each with one number of the scene changed by 1e-15 to",
        f"# 1e-13 of itself. A tolerance is {MARGIN:g} times the largest difference, at least",
        f"# {FLOOR:g} of the largest value. Made by scripts/regress --update. Not compared: what",
        "# only the run has (its input, what is constant, attributes), counts of steps, and",
        f"# data sets whose tolerance would be more than {VAGUE:g} of their largest value.",
        "/input                          ignore",
        "/input/*                        ignore",
        "/body                           ignore",
        "/body/*                         ignore",
        "/contact                        ignore",
        "/contact/*                      ignore",
        "/material                       ignore",
        "/material/*                     ignore",
        "/surface                        ignore",
        "/surface/*                      ignore",
        "# data set                      tolerance  0   # spread, largest value",
    ]
    for path, values in sorted(spread.values.items()):
        if path in EXACT:
            continue
        if COUNTS.search(path):
            lines.append(f"{path:<31} ignore")
            continue
        size = float(np.abs(values).max(initial=0.0))
        rule = f"{tolerance(spread, path):<9.0e}  0"
        if is_vague(spread, path):
            rule = f"{'ignore':<12}"
        lines.append(f"{path:<31} {rule}   # {spread.largest[path]:.1e}, {size:.1e}")
    # Last, since a rule for a data set holds for its attributes as well.
    lines.append("*@*                             ignore")
    return "\n".join(lines) + "\n"


def write_case(case: Case) -> None:
    """Write case.toml."""
    case.folder.mkdir(parents=True, exist_ok=True)
    items = "".join(f'   "{item}",\n' for item in case.overrides)
    path = case.scene.resolve().relative_to(ROOT).as_posix()
    (case.folder / "case.toml").write_text(f'scene = "{path}"\nset = [\n{items}]\n')


def renew(case: Case, program: Path) -> Spread:
    """Make reference and rules anew."""
    spread = measure(case, program)
    with tempfile.TemporaryDirectory() as name:
        output = Path(name) / "run.h5"
        simulate(program, case.scene, output, case.words())
        write_reference(output, case.reference)
    case.rules.write_text(rules_text(case, spread))
    return spread
