"""Run the executable of the release build."""

from __future__ import annotations

import subprocess
from pathlib import Path

from lib.results import ResultError

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "build" / "drivers" / "contensou"


def call(*words: object, text: str = "") -> str:
    """What the program writes to the standard output for these words and this standard input."""
    command = [str(PROGRAM), *map(str, words)]
    done = subprocess.run(command, input=text, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise ResultError(f"{' '.join(command)} ended with {done.returncode}:\n{done.stderr}")
    return done.stdout
