"""The modules that the tools of the program share, as part of this package."""

from __future__ import annotations

import importlib
import importlib.util
import sys
from types import ModuleType

from contensou._prefix import TOOLS

PACKAGE = "contensou._lib"


def tool(name: str) -> ModuleType:
    """A module of the tools, such as `viewing`."""
    if PACKAGE not in sys.modules:
        folder = TOOLS / "lib"
        found = importlib.util.spec_from_file_location(
            PACKAGE, folder / "__init__.py", submodule_search_locations=[str(folder)]
        )
        assert found is not None
        sys.modules[PACKAGE] = importlib.util.module_from_spec(found)
    return importlib.import_module(f"{PACKAGE}.{name}")
