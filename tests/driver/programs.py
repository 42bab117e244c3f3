"""Programs that the tests start."""

from __future__ import annotations

import subprocess


def captured(command, **more):
    """What a program leaves: its status, and its output as text."""
    return subprocess.run(command, capture_output=True, text=True, check=False, **more)
