"""Where the program and the library of this package are."""

from __future__ import annotations

from pathlib import Path

PREFIX = Path(__file__).resolve().parent
PROGRAM = PREFIX / "bin" / "contensou"
LIBRARY = PREFIX / "lib" / "libcontensou_python.so"
TOOLS = PREFIX / "share" / "contensou" / "plot"
