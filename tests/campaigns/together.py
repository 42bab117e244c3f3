"""Two commands at once on one name, over and over: nothing is lost and nothing is left over.

    python tests/campaigns/together.py [REPETITIONS] [FOLDER]

takes all pairs of run, resume, sweep and merge, REPETITIONS (200) times each with random delays, in
FOLDER (a temporary one), and prints what came of each. Exit status 1 if something went wrong. The
tests do a few repetitions. CONTENSOU names the executable.
"""

from __future__ import annotations

import itertools
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import h5py

NAME = "x.h5"

SCENE = """\
&scene t_end = 0.01, gravity = 0, 0, -9.81 /
&material name = 'wood', young = 9e9, poisson = 0.3 /
&body name = 'ball', mass = 1e-2, inertia = 3*1e-6, position = 0, 0, 0.0101 /
&surface name = 'ball', body = 'ball', shape = 'sphere', radius = 0.01, material = 'wood' /
&surface name = 'floor', body = 'ground', shape = 'plane', normal = 0, 0, 1, material = 'wood' /
&contact
   name = 'ball_floor', surfaces = 'ball', 'floor', normal = 'hertz', damping = 'none'
   friction = 'none'
/
&output interval = 1e-4 /
"""

SWEEP = """\
&sweep scene = 'ball.nml' /
&parameter name = 'ball.mass', first = 1e-2, last = 2e-2, count = 4 /
"""

COMMANDS = {
    "run": ["run", "ball.nml", "-o", NAME, "-q"],
    "resume": ["run", "ball.nml", "-o", NAME, "-q", "--resume"],
    "sweep": ["sweep", "sweep.nml", "-o", NAME, "-q", "-j", "1"],
    "merge": ["merge", "shard_1.h5", "shard_2.h5", "-o", NAME, "-q"],
}
TYPES = {
    "run": "contensou-trajectory",
    "resume": "contensou-trajectory",
    "sweep": "contensou-sweep",
    "merge": "contensou-sweep",
}

# Both would write the same table: the later one finds it complete.
TABLES = {"sweep", "merge"}

# What the one that comes too late may say, with status 74.
REFUSALS = (
    "exists",
    "is not the output of a run",
    "another run is writing",
    "another process is writing",
)


def prepare(executable: str, folder: Path) -> None:
    """Scene, sweep and shards."""
    (folder / "ball.nml").write_text(SCENE)
    (folder / "sweep.nml").write_text(SWEEP)
    for k in (1, 2):
        command = [executable, "sweep", "sweep.nml", "-q", "--cases", f"{2 * k - 1}:{2 * k}"]
        subprocess.run(
            [*command, "-o", f"shard_{k}.h5"], cwd=folder, check=True, stdout=subprocess.DEVNULL
        )


def start(executable: str, kind: str, folder: Path) -> subprocess.Popen:
    """Begin a command."""
    return subprocess.Popen(
        [executable, *COMMANDS[kind]],
        cwd=folder,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def trial(executable: str, pair: tuple[str, str], folder: Path, delay: float) -> tuple[str, str]:
    """What came of two commands, in words, and what is wrong with that; empty for nothing."""
    before = {path.name for path in folder.iterdir()}
    processes = [start(executable, pair[0], folder)]
    time.sleep(delay)
    processes.append(start(executable, pair[1], folder))
    outcomes, wrong, winners = [], [], []
    for kind, process in zip(pair, processes, strict=True):
        out, err = process.communicate(timeout=120)
        code = process.returncode
        if code == 0:
            winners.append(kind)
            outcomes.append("complete" if "is complete" in out else "0")
        else:
            refused = next((words for words in REFUSALS if words in err), None)
            outcomes.append(f"{code} {refused}")
            if code != 74 or refused is None or {*pair} <= TABLES:
                wrong.append(f"{kind}: {code} {err.strip()}")
    if not winners:
        wrong.append("nobody won")
    path = folder / NAME
    if not path.exists():
        wrong.append("there is no file")
    else:
        with h5py.File(path, "r") as file:
            kind, status = file.attrs["filetype"], file.attrs["status"]
        if status != "complete":
            wrong.append(f"the file is {status}")
        if any(TYPES[winner] != kind for winner in winners):
            wrong.append(f"{winners} won and the file is of {kind}")
        path.unlink()
    left = {path.name for path in folder.iterdir()} - before
    if left:
        wrong.append(f"left over: {sorted(left)}")
    for name in left:
        (folder / name).unlink()
    return " | ".join(outcomes), "; ".join(wrong)


def campaign(executable: str, repetitions: int, folder: Path, seed: int = 1) -> tuple[dict, list]:
    """All pairs so many times: how often what came of each, and what went wrong."""
    prepare(executable, folder)
    chance = random.Random(seed)
    counts, mistakes = {}, []
    for pair in itertools.combinations_with_replacement(COMMANDS, 2):
        counts[pair] = Counter()
        for _ in range(repetitions):
            order = pair if chance.random() < 0.5 else pair[::-1]
            delay = chance.choice([0.0, chance.uniform(0, 0.03), chance.uniform(0, 0.2)])
            words, wrong = trial(executable, order, folder, delay)
            counts[pair][words if order == pair else " | ".join(words.split(" | ")[::-1])] += 1
            if wrong:
                mistakes.append(f"{order} after {delay:.4f} s: {wrong}")
    return counts, mistakes


def main() -> int:
    """Do the campaign."""
    repetitions = int(sys.argv[1]) if len(sys.argv) > 1 else 200
    folder = Path(tempfile.mkdtemp(dir=sys.argv[2] if len(sys.argv) > 2 else None))
    counts, mistakes = campaign(os.path.abspath(os.environ["CONTENSOU"]), repetitions, folder)
    for pair, outcomes in counts.items():
        print(f"{pair[0]} and {pair[1]}:")
        for words, count in outcomes.most_common():
            print(f"  {count:5d}  {words}")
    print("\n".join(mistakes))
    print(f"{len(mistakes)} of {repetitions * len(counts)} went wrong")
    shutil.rmtree(folder)
    return bool(mistakes)


if __name__ == "__main__":
    sys.exit(main())
