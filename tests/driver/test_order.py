"""Which process takes which tests, and in which order."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import order
import pytest
from programs import captured

FOLDER = Path(__file__).parent
SIX = """\
import time

import pytest


@pytest.mark.parametrize("i", range(6))
def test_it(i):
    time.sleep(0.1)
"""


def test_what_shares_a_build_stays_in_one_process(tmp_path):
    grouped = ("test_kernel_arrays", "test_extension", "test_hosts")
    for name in (*grouped, "test_words"):
        (tmp_path / f"{name}.py").write_text(SIX)
    (tmp_path / "conftest.py").write_text("from order import pytest_xdist_make_scheduler  # noqa\n")
    words = ["-m", "pytest", "-v", "-n", "2", "--dist", "loadgroup", "-p", "no:cacheprovider"]
    done = captured(
        [sys.executable, *words, tmp_path], cwd=tmp_path, env={"PYTHONPATH": str(FOLDER)}
    )
    assert done.returncode == 0, done.stdout + done.stderr
    ran = re.findall(r"^\[(gw\d)\].* (test_\w+)\.py::", done.stdout, re.MULTILINE)
    assert len(ran) == 24
    workers = {name: {worker for worker, other in ran if other == name} for _, name in ran}
    assert len(workers["test_extension"]) == 1
    assert len(workers["test_hosts"] | workers["test_kernel_arrays"]) == 1
    assert len(set.union(*workers.values())) == 2


@pytest.mark.parametrize("name", [*order.GROUPS, *order.LONG])
def test_what_comes_first_is_there(name):
    texts = (path.read_text(encoding="utf-8") for path in FOLDER.glob("test_*.py"))
    assert (FOLDER / f"{name}.py").is_file() or any(f"def {name}(" in text for text in texts)
