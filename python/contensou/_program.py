"""The commands of the package: the program, and its tools for drawing and exporting."""

from __future__ import annotations

import os
import runpy
import sys
from pathlib import Path

from contensou._prefix import PREFIX, PROGRAM


def main() -> None:
    """Become the program."""
    # `contensou export` starts a tool, which has to find the packages of this Python.
    folder = str(Path(sys.executable).parent)
    os.environ["PATH"] = os.pathsep.join([folder, os.environ.get("PATH", os.defpath)])
    os.execv(PROGRAM, ["contensou", *sys.argv[1:]])


def tool() -> None:
    """Run the tool of the name under which this was started: contensou-plot and the like."""
    script = PREFIX / "bin" / Path(sys.argv[0]).name
    sys.argv[0] = str(script)
    runpy.run_path(str(script), run_name="__main__")
