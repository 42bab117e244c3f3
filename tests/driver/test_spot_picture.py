"""`scripts/spot`: pictures of spots."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))

import spot as drawing  # noqa: E402

GREEN = np.array([0x1F, 0x8F, 0x4D])


def draw(executable, words, folder, name="spot.png"):
    """Run the script with the program under test."""
    return subprocess.run(
        [sys.executable, ROOT / "scripts/spot.py", words, "-o", name],
        cwd=folder,
        env=os.environ | {"CONTENSOU": str(executable), "MPLBACKEND": "Agg"},
        capture_output=True,
        text=True,
        check=False,
    )


def green(path):
    """Whether the pixels are those of the centre or the zone that sticks."""
    pixels = np.asarray(Image.open(path).convert("RGB")).astype(int)
    return np.abs(pixels - GREEN).sum(axis=2) < 30


def test_centre_of_rotation(executable, tmp_path):
    """It is drawn where the slip is zero: further to the right if vy is more negative."""
    places = []
    for vy in (0.0, -0.03):
        done = draw(executable, f"a=1e-3,f=0.3,N=10,vx=0,vy={vy},w=100", tmp_path)
        assert (done.returncode, done.stdout, done.stderr) == (0, "spot.png\n", "")
        rows, columns = green(tmp_path / "spot.png").nonzero()
        assert 20 < len(rows) < 2000
        places.append((columns.mean(), rows.mean()))
    assert places[1][0] > places[0][0] + 50
    assert places[1][1] == pytest.approx(places[0][1], abs=2)


def test_zone_that_sticks(executable, tmp_path):
    """It shrinks with the shift, and is gone when all slips."""
    zones = []
    for shift in (1e-8, 2e-8, 1e-6):
        done = draw(executable, f"a=1e-3,f=0.3,N=10,dx={shift},G=8e10,nu=0.3", tmp_path)
        assert done.returncode == 0, done.stderr
        rows, _ = green(tmp_path / "spot.png").nonzero()
        zones.append(np.ptp(rows) if len(rows) else 0)
    assert zones[0] > zones[1] > zones[2] == 0
    spot = {"dx": 1.0, "f": 0.5, "N": 2.0}
    assert drawing.sticking(spot, np.array([0.0, -0.875, 0.0])) == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("a=1e-3,f=0.3", "N="),
        ("a=1e-3,f=0.3,N=-1,w=1", "'N=-1'"),
        ("a=1e-3,f=0.3,N=1,q=1", "'q=1'"),
        ("a=1e-3,f=0.3,N=1", "does not move"),
        ("a=1e-3,f=0.3,N=1,dx=1e-9", "G="),
        ("a=1e-3,f=0.3,N=1,dx=1e-9,G=1e9,nu=0.3,w=1", "not both"),
    ],
)
def test_bad_input(words, said, executable, tmp_path):
    """A message, and no picture."""
    done = draw(executable, words, tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert said in done.stderr
    assert not list(tmp_path.iterdir())
