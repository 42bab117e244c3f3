"""docs/gallery.md: every shipped scene is in it, with a still that shows something."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

ROOT = Path(__file__).resolve().parents[2]
INPUTS = [*(ROOT / "inputs").glob("*.nml"), *(ROOT / "inputs/examples").glob("*.nml")]
SCENES = sorted(path.stem for path in INPUTS)


def test_every_scene_is_in_it():
    """Each scene once, and no other."""
    text = (ROOT / "docs/gallery.md").read_text(encoding="utf-8")
    assert sorted(re.findall(r"^## (\w+)$", text, re.MULTILINE)) == SCENES
    for path in INPUTS:
        assert f"]({Path('..') / path.relative_to(ROOT)})" in text
    for name in SCENES:
        assert f"](gallery/{name}.jpg)" in text
    assert "](gallery/poster.jpg)" in text
    found = {path.name for path in (ROOT / "docs/gallery").iterdir()}
    assert found == {f"{name}.jpg" for name in [*SCENES, "poster"]}


@pytest.mark.parametrize("name", [*SCENES, "poster"])
def test_stills_show_something(name):
    """A body in its colours before a plain or chequered ground."""
    pixels = np.asarray(Image.open(ROOT / "docs/gallery" / f"{name}.jpg").convert("HSV"))
    assert pixels.shape[0] >= 300
    assert np.mean(pixels[..., 1] > 120) > 0.003
