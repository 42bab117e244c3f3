"""What it costs to read and check scenes of many bodies: linear in their number."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from programs import instructions

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts"))

from lib.many_balls import many_balls


def check(executable, folder, lines, *words):
    """Status and output of `contensou check`, and its largest memory [MB]."""
    path = folder / "many.nml"
    path.write_text("\n".join(lines) + "\n")
    out = folder / "out"
    with out.open("w") as file:
        process = subprocess.Popen(
            [str(executable), "check", path.name, *words],
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=file,
            stderr=subprocess.STDOUT,
        )
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    return process.returncode, out.read_text(), usage.ru_maxrss / 1024


def work(executable, folder, kind, lines, *words):
    """Instructions of `contensou check --expand`."""
    path = folder / "counted.nml"
    path.write_text("\n".join(lines) + "\n")
    return instructions([executable, "check", path, "--expand", *words], folder, kind)


def masses(number):
    """Settings of some balls."""
    return [word for i in range(number) for word in ("--set", f"b_{i}.mass=0.04")]


def test_work_is_proportional_to_the_number_of_bodies(executable, tmp_path, build_kind):
    """Also with settings of many of them."""
    few, many = (work(executable, tmp_path, build_kind, many_balls(n)) for n in (50, 400))
    assert many < 8 * 1.2 * few
    chosen = work(executable, tmp_path, build_kind, many_balls(400), *masses(100))
    assert chosen < 1.3 * many


def test_many_bodies(executable, tmp_path, build_kind):
    if build_kind != "release":
        pytest.skip("memory is that of a release build")
    status, text, memory = check(executable, tmp_path, many_balls(10000), "--expand", *masses(3000))
    assert status == 0, text
    assert text.count("&contact") == 30000
    assert text.count("mass = 0.04") == 3000
    assert memory < 1000.0
    status, _, memory = check(executable, tmp_path, many_balls(10000))
    assert status == 0
    assert memory < 1000.0


@pytest.mark.parametrize(
    ("old", "new"),
    [("surfaces = 's_", "surfaces = 'sx_"), ("surfaces =", "fricton = 'coulomb', surfaces =")],
    ids=["names", "keys"],
)
def test_many_mistakes(executable, tmp_path, build_kind, old, new):
    """The first hundred are shown, the others are counted."""

    def mistaken(balls, number):
        lines = many_balls(balls)
        wrong = [i for i, line in enumerate(lines) if line.startswith("&contact")][:number]
        for i in wrong:
            lines[i] = lines[i].replace(old, new)
        return lines

    if build_kind != "release":
        pytest.skip("many bodies want a release build")
    status, text, _ = check(executable, tmp_path, mistaken(10000, 20000))
    assert status == 2
    assert text.count(": error: ") == 100
    assert "... and 19900 more errors" in text
    assert "20000 errors in many.nml" in text
    counts = []
    for wrong in (200, 1000):
        (tmp_path / "counted.nml").write_text("\n".join(mistaken(400, wrong)) + "\n")
        command = [executable, "check", "counted.nml"]
        counts.append(instructions(command, tmp_path, build_kind, status=2))
    assert counts[1] < 2 * counts[0]
