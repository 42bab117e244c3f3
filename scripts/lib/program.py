"""Run the executable of the release build."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

from .results import ResultError

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "build" / "drivers" / "contensou"


def find() -> Path:
    """The program that a user has: that of the variable CONTENSOU, of the build, or of the path."""
    given = os.environ.get("CONTENSOU")
    installed = shutil.which("contensou")
    for path in (given, PROGRAM if PROGRAM.is_file() else None, installed):
        if path:
            return Path(path)
    raise ResultError("there is no contensou: build it, or name it in the variable CONTENSOU")


def call(*words: object, text: str = "", executable: Path = PROGRAM) -> str:
    """What the program writes to the standard output for these words and this standard input."""
    command = [str(executable), *map(str, words)]
    done = subprocess.run(command, input=text, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        problem = ResultError(f"{' '.join(command)} ended with {done.returncode}:\n{done.stderr}")
        problem.status = done.returncode
        raise problem
    return done.stdout
