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
from lib import bristles  # noqa: E402

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


def test_zone_that_sticks_while_it_rolls(executable, tmp_path):
    """It is where the material comes in, and shrinks with the creepage."""
    shares, middles = [], []
    for slip in (2e-3, 5e-3):
        words = f"a=1e-3,f=0.3,N=100,vx={slip},cx=-1,G=8e9,nu=0.3"
        done = draw(executable, words, tmp_path)
        assert (done.returncode, done.stderr) == (0, "")
        columns = green(tmp_path / "spot.png").nonzero()[1]
        shares.append(np.ptp(columns) if len(columns) else 0)
        middles.append(columns.mean() if len(columns) else 0)
    assert shares[0] > shares[1] > 0
    # It comes in on the right, as it passes towards -x.
    assert middles[1] > middles[0]


@pytest.mark.parametrize("slip", [(1e-3, 0, 0), (5e-4, 8e-4, 2.0), (0, 0, 3.0)])
def test_bristles_make_the_force(slip):
    """Tractions of rolling sum to the wrench they are told, to that of large spin as well, which
    is less than that of a smaller one."""
    vx, vy, w = slip
    spot = dict(a=2e-3, b=1e-3, f=0.3, N=10.0, vx=vx, vy=vy, w=w, cx=1.0, cy=0.5)
    n = 200
    axis = (np.arange(n) + 0.5) * 2 / n - 1
    x, y = np.meshgrid(axis, axis)
    within = x**2 + y**2 < 1
    root = np.sqrt(spot["a"] * spot["b"])
    passing, rigid = np.array([1 / 2, 0.5]), np.array([vx, vy, w * root])
    lines = bristles.Lines(
        passing / np.linalg.norm(passing),
        rigid / np.linalg.norm(rigid),
        spot["a"] / root,
        spot["b"] / root,
    )
    for flexibility in (4.0, 1.0, 0.3, 0.1):
        wrench = lines.wrench(flexibility)
        force = wrench * spot["f"] * spot["N"] * np.array([1, 1, root])
        tx, ty, sticks = bristles.field(spot, force)(x, y)
        made = [
            np.sum(part[within]) / within.sum() * 1.5
            for part in (tx, ty, (x * spot["a"] * ty - y * spot["b"] * tx) / root)
        ]
        assert np.linalg.norm(made - wrench) < 0.02
        # Nothing is beyond its bound, and what slips is at it.
        bound = np.sqrt(np.maximum(1 - x**2 - y**2, 0))
        size = np.hypot(tx, ty)
        assert (size[within] <= bound[within] + 1e-12).all()
        assert np.abs(size - bound)[within & ~sticks].max() < 1e-12


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("a=1e-3,f=0.3", "N="),
        ("a=1e-3,f=0.3,N=-1,w=1", "'N=-1'"),
        ("a=1e-3,f=0.3,N=1,q=1", "'q=1'"),
        ("a=1e-3,f=0.3,N=1", "does not move"),
        ("a=1e-3,f=0.3,N=1,dx=1e-9", "G="),
        ("a=1e-3,f=0.3,N=1,dx=1e-9,G=1e9,nu=0.3,w=1", "not both"),
        ("a=1e-3,f=0.3,N=1,vx=1e-3,cx=1", "G="),
        ("a=1e-3,f=0.3,N=1,vx=1e-3,G=1e9,nu=0.3", "rolling spot"),
        ("a=1e-3,f=0.3,N=1,vx=1e-3,cx=0,G=1e9,nu=0.3", "nothing passes"),
    ],
)
def test_bad_input(words, said, executable, tmp_path):
    """A message, and no picture."""
    done = draw(executable, words, tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert said in done.stderr
    assert not list(tmp_path.iterdir())
