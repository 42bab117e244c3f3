"""Folders of a scene and a sweep, and what commands leave in them."""

from __future__ import annotations

SWEEP = """\
&sweep scene = 'scene.nml', keep = 'steps' /
&parameter name = 'top.angle', first = 0.1, last = 0.2, count = 2 /
"""


def content(folder):
    """What a folder holds."""
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


def good(result):
    """The result of a command that must have done its work."""
    assert result.status == 0, result.err
    return result
