"""The C interface: the programs that the build makes of tests/capi."""

from __future__ import annotations

import os
import re
import subprocess
from pathlib import Path

import h5py
import numpy as np
import pytest
from programs import captured

ROOT = Path(__file__).resolve().parents[2]
SCENES = sorted(path for path in (ROOT / "inputs").rglob("*.nml") if "sweeps" not in path.parts)

# What costs more than a second by time of the scene [s].
SLOW = {"bearing_pair": 2e-3, "bearing_6205_rolling": 0.02, "break_shot": 0.05}


@pytest.mark.parametrize("name", ["kernels", "simulation", "threads"])
def test_c_interface(executable, inputs, name):
    program = executable.parents[1] / "tests" / "capi" / f"test_{name}"
    done = captured(
        [program, inputs][: 1 + (name != "kernels")],
        timeout=300,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.count("\n") == 1, done.stdout
    assert done.stdout.endswith(" passed, 0 failed\n")
    assert done.stderr == ""


@pytest.mark.parametrize("seed", range(4))
def test_random_calls(executable, tmp_path, seed):
    """Right and wrong calls in any order: nothing crashes, is printed or written.

    CONTENSOU_FUZZ in the environment asks for another number of sequences.
    """
    program = executable.parents[1] / "tests" / "capi" / "fuzz"
    count = int(os.environ.get("CONTENSOU_FUZZ", "1000"))
    done = captured([program, str(seed), str(count)], cwd=tmp_path, timeout=max(300, count // 5))
    assert (done.returncode, done.stderr) == (0, "")
    calls, refused = map(int, re.findall(r"(\d+) (?:calls|refused)", done.stdout))
    assert calls > 4000
    assert 1000 < refused < calls
    assert not list(tmp_path.iterdir())


def rows_and_events(executable, scene, steps, *settings):
    """What tests/capi/rows.c writes: the quantities of the rows, and the events."""
    program = executable.parents[1] / "tests" / "capi" / "rows"
    done = subprocess.run(
        [program, scene, str(steps), *settings], capture_output=True, check=False, timeout=300
    )
    assert (done.returncode, done.stderr) == (0, b"")
    heading, _, data = done.stdout.partition(b"\n\n")
    widths = {line.split()[0]: int(line.split()[1]) for line in heading.decode().splitlines()}
    size = sum(widths.values())
    rows, events, place = [], [], 0
    while place < len(data):
        count = size if data[place : place + 1] == b"r" else 3
        numbers = np.frombuffer(data, "f8", count, place + 1)
        (rows if count == size else events).append(numbers)
        place += 1 + 8 * count
    columns = np.split(np.array(rows), np.cumsum(list(widths.values()))[:-1], axis=1)
    return dict(zip(widths, columns, strict=True)), events


@pytest.mark.sample(13)
@pytest.mark.parametrize("steps", [1, 53])
@pytest.mark.parametrize("scene", SCENES, ids=lambda path: path.stem)
def test_scenes_have_the_bits_of_a_run(executable, run, tmp_path, scene, steps, build_kind):
    """However often one asks on the way."""
    longest = 0.2 if build_kind == "release" else 0.02
    longest = min(longest, SLOW.get(scene.stem, longest))
    end = float(re.search(r"t_end *= *([0-9.e-]+)", scene.read_text())[1])
    setting = f"scene.t_end = {min(end, longest)}"
    result = run("run", scene, "-q", "-o", "run.h5", "--set", setting)
    assert result.status == 0, result.err
    columns, events = rows_and_events(executable, scene, steps, setting)
    with h5py.File(tmp_path / "run.h5") as file:
        trajectory = file["trajectory"]
        assert len(columns["time"]) == len(trajectory["time"]) > 2
        for name, values in columns.items():
            written = trajectory[name][()].reshape(len(values), -1)
            assert values.tobytes() == written.tobytes(), name
        names = [name.decode() for name in file["contact/name"][()]]
        times, kinds, contacts = (file[f"events/{key}"][()] for key in ("time", "kind", "contact"))
        assert len(events) == len(times)
        for (time, kind, contact), *written in zip(events, times, kinds, contacts, strict=True):
            touch = {1: b"touch", 2: b"lift"}[int(kind)]
            assert [time, touch, names[int(contact)].encode()] == written
