"""Shots through gaps and past edges; tests/campaigns/shots.py does hundreds."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "campaigns"))
from shots import Range, fly, shot, two_balls  # noqa: E402

# All kinds, but one in which a rigid ball rattles between two posts for half a minute; and two that
# only the interpolant of explicit8 met; and two balls that rattle in a ring which is too small.
SEEDS = [seed for seed in range(28) if seed != 22] + [1081, 1281, 1221, 1242]


@pytest.mark.parametrize("seed", SEEDS)
def test_what_a_body_meets_is_seen(executable, tmp_path, seed):
    """A touch is told of when it is, none where there is none, or the run says why it ends."""
    _, wrong = fly(executable, shot(seed), tmp_path)
    assert not wrong


@pytest.mark.parametrize("method", ["explicit8", "cvode_bdf", "cvode_adams", "auto"])
def test_two_small_balls_are_seen(executable, tmp_path, method):
    """Balls that meet head on from a thousand radii away and more."""
    drawn = next(
        one
        for one in (two_balls(Range(seed)) for seed in range(100))
        if one.first_touch()[0] and one.gap(0.0) > 1000 * one.radius
    )
    drawn.text = drawn.text.replace(f"'{drawn.method}'", f"'{method}'")
    words, wrong = fly(executable, drawn, tmp_path)
    assert not wrong
    assert words == "touches"
