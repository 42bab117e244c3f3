"""`scripts/bearing`: what an engineer reads of the run of a ball bearing."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from result import read

ROOT = Path(__file__).resolve().parents[2]


def table(*words):
    """What the script prints, and its status."""
    return subprocess.run(
        [sys.executable, ROOT / "scripts" / "bearing.py", *map(str, words)],
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.fixture(scope="module")
def result(executable, tmp_path_factory):
    """A short run with curved spots."""
    path = tmp_path_factory.mktemp("bearing") / "b.h5"
    sets = ("bearing.spot=curved", "bearing.spot_error=1e-5", "scene.t_end=1e-3")
    words = [word for text in sets for word in ("--set", text)]
    scene = ROOT / "inputs" / "bearing_6205.nml"
    subprocess.run([executable, "run", scene, "-q", "-o", path, *words], check=True, timeout=200)
    return path


def test_table(result, tmp_path):
    done = table(result, "--part", 0.5, "--rating", 14800, "-o", tmp_path / "loads.png")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "loads.png").stat().st_size > 5000
    rows = read(result).columns
    half = slice(len(rows["time"]) // 2, None)
    inner = rows["normal_force"][half, :9].mean(axis=0)
    printed = re.findall(r"^ +(\d+) +([\d.]+) ", done.stdout, re.MULTILINE)
    assert [float(load) for _, load in printed] == pytest.approx(inner, abs=0.06)
    # The causes are the whole torque of the drive, but for the energy of the motion that changes.
    parts = dict(re.findall(r"^  (\w[\w, ]*?) +(-?[\d.]+)$", done.stdout, re.MULTILINE))
    whole = float(parts.pop("whole"))
    assert sum(map(float, parts.values())) == pytest.approx(whole, abs=1e-3)
    drive = 1e3 * rows["drive_torque"][half, 0, 2].mean()
    assert whole == pytest.approx(drive, rel=0.1)
    assert float(parts["curvature, inner race"]) > 0.5
    life = float(re.search(r"reference life +(\S+)", done.stdout)[1])
    assert 5e3 < life < 3e4
    cage, epicyclic = map(float, re.findall(r"([\d.]+) rad/s", done.stdout))
    assert cage == pytest.approx(epicyclic, rel=5e-3)
    assert np.isfinite(cage)


def test_what_is_no_bearing(tmp_path, result):
    assert table(tmp_path / "none.h5").returncode == 2
    done = table(result, "--part", 2)
    assert done.returncode == 2
    assert "--part" in done.stderr
