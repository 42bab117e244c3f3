"""The page of the limit surface of a spot: what is packed, messages, and what a click tells."""

from __future__ import annotations

import csv
import io
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from test_view import contents, needs_browser

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))

from lib import browser  # noqa: E402


@pytest.fixture
def view(executable, tmp_path):
    """Run scripts/view with the executable that is tested."""

    def run(*words):
        return subprocess.run(
            [ROOT / "scripts" / "view", *words],
            cwd=tmp_path,
            env={**os.environ, "CONTENSOU": str(executable)},
            capture_output=True,
            text=True,
            check=False,
        )

    return run


def packed(path):
    """The slips, wrenches, points and triangles of a page."""
    head, array = contents(path.read_text(encoding="utf-8"))
    mesh = head["surfaces"][0]["mesh"]
    places = (head["asked"]["slip"], head["asked"]["wrench"], mesh["points"], mesh["triangles"])
    slip, wrench, points, triangles = (array(place).reshape(-1, 3) for place in places)
    return slip.astype(float), wrench.astype(float), points.astype(float), triangles


def test_the_surface_is_that_of_the_kernel(view, run, tmp_path):
    done = view("--limit-surface", "a=2e-3,b=1e-3,f=0.3,N=10")
    assert (done.returncode, done.stdout, done.stderr) == (0, "limit_surface.html\n", "")
    slip, wrench, points, triangles = packed(tmp_path / "limit_surface.html")
    text = io.StringIO()
    csv.writer(text).writerows(
        [["N", "a", "b", "f", "vx", "vy", "w"], *([10, 2e-3, 1e-3, 0.3, *v] for v in slip.tolist())]
    )
    answer = run("eval", "wrench", input=text.getvalue())
    assert answer.status == 0, answer.err
    true = np.loadtxt(io.StringIO(answer.out), delimiter=",", skiprows=1)[:, -3:]
    assert np.abs(true + wrench).max() < 1e-5 * np.abs(true).max()
    assert np.hypot(*wrench[:, :2].T).max() == pytest.approx(3.0, rel=1e-3)
    # The surface is closed, its triangles face outward, and it is convex: no wrench of it does more
    # work against a slip than that of this slip.
    edges = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()
    a, b, c = (points[triangles[:, k]] for k in range(3))
    assert (np.sum(np.cross(b - a, c - a) * (a + b + c), axis=1) > 0).mean() > 0.99
    power = np.einsum("ik,jk->ij", slip[::17], wrench)
    own = np.sum(slip[::17] * wrench[::17], axis=1)
    assert (power.max(axis=1) <= own * (1 + 1e-4)).all()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("b=1e-3", "the semi-axis a="),
        ("a=x", "'a=x': expected a positive number"),
        ("a=1,b=-1", "'b=-1': expected a positive number"),
        ("a=1,c=2", "'c=2': expected a=, b="),
        ("a=1,model=guess", "model 'guess': expected one of contensou_exact"),
    ],
)
def test_spots_that_are_none(view, tmp_path, words, said):
    done = view("--limit-surface", words)
    assert done.returncode == 2
    assert done.stderr.startswith("error: ")
    assert said in done.stderr
    assert not list(tmp_path.iterdir())


@needs_browser
def test_a_click_tells_the_slip(view, tmp_path):
    assert view("--limit-surface", "a=1e-3", "-o", "round.html").returncode == 0
    page = tmp_path / "round.html"
    program = browser.Browser()
    try:
        program.open(page)
        before = program.picture()
        assert before[100:600, 200:900].std() > 20
        program.drag((600, 330), (600, 330))
        program.draw()
        said = program.value("document.getElementById('figures').textContent")
        assert said.startswith("force ")
        assert "slip towards" in said
        assert (program.picture() != before).any()
        program.drag((500, 300), (700, 330))
        program.key("d")
        assert program.picture()[5, 5].sum() < before[5, 5].sum() - 300
        assert program.complaints == []
        assert program.asked == [page.as_uri()]
    finally:
        program.close()
