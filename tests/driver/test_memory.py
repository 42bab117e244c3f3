"""Contacts that remember or roll, at random; tests/campaigns/memory.py draws any number."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "campaigns"))
from memory import Memory  # noqa: E402
from spots import drop  # noqa: E402

# A second place in a bore and in a hollow that comes close after the beginning.
FOUND = (634, 963)


@pytest.mark.sample(6)
@pytest.mark.parametrize("seed", [*FOUND, *range(24)])
def test_friction_does_what_it_may(executable, tmp_path, seed):
    """Beside energy, momentum and gaps: limits, work that is given back, what sticks."""
    words, wrong = drop(executable, Memory(seed), tmp_path)
    assert not wrong
    assert words == "ends well" or "pressed deeper" in words
