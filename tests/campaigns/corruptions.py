"""Files that are damaged at random, read by every command that reads them.

    python tests/campaigns/corruptions.py [REPETITIONS] [COMMAND...]

damages files REPETITIONS (2000) times for each of diff, merge, sweep, resume, going-on, plot: bits
flipped, bytes replaced, blocks zeroed, files cut, files swapped. Each must end with a message that
says so, or with the right result; never by a signal, with a backtrace, late, or with another
result. Exit status 1 if one did. The tests do a few. CONTENSOU names the executable.
"""

from __future__ import annotations

import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
from together import SCENE, SWEEP

ROOT = Path(__file__).resolve().parents[2]

# Words of a message that does not mislead about a file that is not as it was.
HONEST = re.compile(
    r"damaged|not an HDF5 file|no HDF5 file|cannot be resumed|beginning from the start|"
    r"of another|another sweep|is not the table of a sweep|is not the output|was not left by|"
    r"exists and has other cases|rows for the cases|cannot be joined|is no table|holds no|"
    r"holds \d+ rows|is a scene: merge joins"
)
# Time after which a command hangs [s], however busy the machine is.
PATIENCE = 600
# A run that does not end by itself.
LONG = "--set scene.t_end=1e4 --set output.interval=1e-2"

BACKTRACE = re.compile(
    r"Backtrace|Traceback|SIGSEGV|SIGABRT|AddressSanitizer|runtime error|free\(\)"
)


def damage(path: Path, chance: random.Random, others: list[Path]) -> str:
    """Change a file; what was done to it."""
    data = bytearray(path.read_bytes())
    kind = chance.choice(["bit", "bits", "bytes", "zeros", "cut", "swap", "noise"])
    at = chance.randrange(len(data))
    if kind == "bit":
        data[at] ^= 1 << chance.randrange(8)
    elif kind == "bits":
        for _ in range(chance.randrange(2, 40)):
            data[chance.randrange(len(data))] ^= 1 << chance.randrange(8)
    elif kind == "bytes":
        size = chance.randrange(1, 16)
        data[at : at + size] = bytes(chance.randrange(256) for _ in range(size))[: len(data) - at]
    elif kind == "zeros":
        size = chance.choice([16, 512, 4096])
        at -= at % size
        end = min(at + size, len(data))
        data[at:end] = bytes(end - at)
    elif kind == "noise":
        at -= at % 512
        end = min(at + 512, len(data))
        data[at:end] = chance.randbytes(end - at)
    elif kind == "cut":
        del data[chance.choice([at, len(data) - chance.randrange(1, 65)]) :]
    else:
        data = bytearray(chance.choice(others).read_bytes())
    path.write_bytes(data)
    return f"{kind} at {at} of {path.name}"


class Campaign:
    """Good files, and what each command makes of damaged copies."""

    def __init__(self, executable: str, folder: Path) -> None:
        self.executable, self.good = executable, folder / "good"
        self.good.mkdir(parents=True)
        (self.good / "ball.nml").write_text(SCENE)
        (self.good / "sweep.nml").write_text(SWEEP)
        self.call("run ball.nml -o a.h5 -q")
        self.call("run ball.nml -o other.h5 -q --set ball.mass=2e-2")
        for k in (1, 2):
            self.call(f"sweep sweep.nml -q --cases {2 * k - 1}:{2 * k} -o shard_{k}.h5")
        self.call("sweep sweep.nml -q -o table.h5")
        # A run and a sweep that were killed on the way.
        self.interrupt(f"run ball.nml -o killed.h5 -q --checkpoint 0 {LONG}", ".part.checkpoint")
        self.interrupt("sweep sweep.nml -o killed_sweep.h5 -q -j 1 --set scene.t_end=2", ".part")
        self.call("sweep sweep.nml -o long.h5 -q --set scene.t_end=2")
        self.folder = folder

    def call(self, words: str, where: Path | None = None) -> subprocess.CompletedProcess:
        """Run the program."""
        return subprocess.run(
            [self.executable, *words.split()],
            cwd=where or self.good,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=PATIENCE,
            check=False,
        )

    def interrupt(self, words: str, there: str) -> None:
        """Kill the program on the way."""
        name = words.split()[words.split().index("-o") + 1]
        process = subprocess.Popen(
            [self.executable, *words.split()], cwd=self.good, stdout=subprocess.DEVNULL
        )
        while not (self.good / (name + there)).exists():
            time.sleep(0.01)
        time.sleep(0.3)
        process.kill()
        process.wait()
        (self.good / f"{name}.part.lock").unlink()

    def trial(self, command: str, seed: int) -> tuple[str, str]:
        """Damage a file and read it: what came of that, and what is wrong with it."""
        chance = random.Random(f"{command} {seed}")
        place = self.folder / f"{command}_{seed}"
        place.mkdir()
        try:
            return getattr(self, command)(place, chance)
        except subprocess.TimeoutExpired:
            return "late", f"{command} {seed}: no end"
        finally:
            shutil.rmtree(place)

    def copy(self, place: Path, *names: str) -> None:
        """Take copies of good files."""
        for name in names:
            shutil.copy(self.good / name, place / name)

    def judge(self, done: str, result: subprocess.CompletedProcess, right: bool) -> tuple[str, str]:
        """What is to be said of the end of a command."""
        text = result.stdout + result.stderr
        if result.returncode < 0 or BACKTRACE.search(text):
            return "crash", f"{done}: {result.returncode} {text[-300:]}"
        if result.returncode == 0:
            return ("right", "") if right else ("wrong", f"{done}: wrong result: {text[-300:]}")
        return ("told", "") if HONEST.search(text) else ("other", f"{done}: {text[-300:]}")

    def same(self, place: Path, a: str, b: str) -> bool:
        """Whether two files hold the same."""
        return self.call(f"diff {a} {self.good / b} -q", place).returncode == 0

    def diff(self, place: Path, chance: random.Random) -> tuple[str, str]:
        """`diff` with a damaged file."""
        self.copy(place, "a.h5")
        others = [self.good / name for name in ("shard_1.h5", "ball.nml")]
        done = damage(place / "a.h5", chance, others)
        result = self.call(f"diff a.h5 {self.good / 'a.h5'}", place)
        swapped = done.startswith("swap")
        if result.returncode == 1 and swapped:
            return "right", ""
        return self.judge(f"diff, {done}", result, True)

    def merge(self, place: Path, chance: random.Random) -> tuple[str, str]:
        """`merge` of a damaged shard and a good one."""
        self.copy(place, "shard_1.h5", "shard_2.h5")
        others = [self.good / name for name in ("a.h5", "ball.nml", "table.h5")]
        done = damage(place / f"shard_{chance.choice([1, 2])}.h5", chance, others)
        result = self.call("merge shard_1.h5 shard_2.h5 -o joined.h5 -q", place)
        right = result.returncode == 0 and self.same(place, "joined.h5", "table.h5")
        return self.judge(f"merge, {done}", result, right)

    def sweep(self, place: Path, chance: random.Random) -> tuple[str, str]:
        """`sweep` with a damaged table under its name, or a damaged journal."""
        self.copy(place, "ball.nml", "sweep.nml")
        options = "-q -j 1"
        if chance.random() < 0.5:
            self.copy(place, "table.h5")
            done = damage(place / "table.h5", chance, [self.good / "a.h5"])
        else:
            shutil.copy(self.good / "killed_sweep.h5.part", place / "table.h5.part")
            done = damage(place / "table.h5.part", chance, [self.good / "a.h5"])
            options += " --set scene.t_end=2"
        result = self.call(f"sweep sweep.nml -o table.h5 {options}", place)
        if result.returncode == 0 and "t_end" in options:
            return self.judge(f"sweep, {done}", result, self.same(place, "table.h5", "long.h5"))
        right = result.returncode == 0 and self.same(place, "table.h5", "table.h5")
        return self.judge(f"sweep, {done}", result, right)

    def resume(self, place: Path, chance: random.Random) -> tuple[str, str]:
        """`run --resume` with a damaged complete file."""
        self.copy(place, "ball.nml", "a.h5")
        done = damage(place / "a.h5", chance, [self.good / "other.h5", self.good / "table.h5"])
        result = self.call("run ball.nml -o a.h5 --resume", place)
        right = result.returncode == 0 and self.same(place, "a.h5", "a.h5")
        return self.judge(f"resume, {done}", result, right)

    def going_on(self, place: Path, chance: random.Random) -> tuple[str, str]:
        """`run --resume` of a killed run whose rows or checkpoint are damaged."""
        self.copy(place, "ball.nml", "killed.h5.part", "killed.h5.part.checkpoint")
        name = "killed.h5.part" + chance.choice(["", "", ".checkpoint"])
        done = damage(place / name, chance, [self.good / "a.h5", self.good / "ball.nml"])
        # The end is not waited for: as far as a run that was begun anew or gone on with.
        process = subprocess.Popen(
            [self.executable, *f"run ball.nml -o killed.h5 --resume {LONG}".split()],
            cwd=place,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            errors="replace",
        )
        try:
            out, err = process.communicate(timeout=0.4)
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGTERM)
            out, err = process.communicate(timeout=PATIENCE)
        text = out + err
        if process.returncode < 0 or BACKTRACE.search(text):
            return "crash", f"going on, {done}: {process.returncode} {text[-300:]}"
        if process.returncode == 75:
            return ("begun anew" if "beginning from the start" in text else "gone on"), ""
        return (
            ("told", "") if HONEST.search(text) else ("other", f"going on, {done}: {text[-300:]}")
        )

    def plot(self, place: Path, chance: random.Random) -> tuple[str, str]:
        """`scripts/plot` of a damaged file."""
        name = chance.choice(["a.h5", "table.h5"])
        self.copy(place, name)
        done = damage(place / name, chance, [self.good / "shard_1.h5", self.good / "ball.nml"])
        result = subprocess.run(
            [sys.executable, "-W", "ignore", ROOT / "scripts/plot.py", name],
            cwd=place,
            capture_output=True,
            text=True,
            errors="replace",
            timeout=PATIENCE,
            check=False,
        )
        return self.judge(f"plot, {done}", result, (place / name).with_suffix(".png").exists())


COMMANDS = ("diff", "merge", "sweep", "resume", "going_on", "plot")


def main() -> int:
    """Do the campaign."""
    repetitions = int(sys.argv[1]) if len(sys.argv) > 1 else 2000
    commands = sys.argv[2:] or COMMANDS
    folder = Path(tempfile.mkdtemp())
    campaign = Campaign(os.path.abspath(os.environ["CONTENSOU"]), folder)
    bad = 0
    with ThreadPoolExecutor(2) as pool:
        for command in commands:
            begun = time.monotonic()
            found = list(pool.map(lambda k, c=command: campaign.trial(c, k), range(repetitions)))
            counts = Counter(words for words, _ in found)
            mistakes = [wrong for _, wrong in found if wrong]
            print(f"{command}: {dict(counts)} in {time.monotonic() - begun:.0f} s", flush=True)
            print("\n".join(mistakes[:20]), flush=True)
            bad += len(mistakes)
    shutil.rmtree(folder)
    return bool(bad)


if __name__ == "__main__":
    sys.exit(main())
