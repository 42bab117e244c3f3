"""Tables of tangential forces that other programs computed.

They stay in a folder of references (CONTENSOU_TANGENTIAL, by default shared/reference/tangential
beside the tree); where it is not there their tests are skipped.
"""

from __future__ import annotations

import csv
import os
from pathlib import Path

import pytest

BESIDE = Path(__file__).resolve().parents[3] / "shared/reference/tangential"


def table(name: str) -> list[dict[str, float]]:
    """The rows of a table."""
    path = Path(os.environ.get("CONTENSOU_TANGENTIAL", BESIDE)) / name
    if not path.is_file():
        pytest.skip(f"the references {path} are not here")
    with path.open(encoding="utf-8") as file:
        return [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]
