"""The wheel of the Python package, for tests: built once, and as it lies unpacked in a folder.

It is built by scripts/wheel without optimization across files, unless CONTENSOU_WHEEL names one.
"""

from __future__ import annotations

import fcntl
import importlib
import os
import sys
import zipfile
from pathlib import Path

import pytest
from programs import captured

ROOT = Path(__file__).resolve().parents[2]
CANNOT_BE_HAD = 3


@pytest.fixture(scope="session")
def wheel(build_kind, tmp_path_factory):
    """The wheel."""
    if build_kind != "release":
        pytest.skip("with the release build only")
    if named := os.environ.get("CONTENSOU_WHEEL"):
        return Path(named)
    folder = tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        folder = folder.parent  # which all workers share
    with (folder / "wheel.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        built = sorted(folder.glob("*.whl"))
        if not built:
            built = [build_wheel(folder)]
    return built[0]


def build_wheel(folder):
    """Build the wheel, or skip where what it needs cannot be had."""
    command = [ROOT / "scripts/wheel", "-o", folder, "-Dlink_time_optimization=false"]
    done = captured(command, timeout=1200)
    if done.returncode == CANNOT_BE_HAD:
        pytest.skip(f"no wheel can be built here: {done.stderr.splitlines()[-1]}")
    assert done.returncode == 0, done.stderr[-3000:]
    return Path(done.stdout.strip())


@pytest.fixture(scope="session")
def unpacked(wheel, tmp_path_factory):
    """The folder of the package, as pip would put it."""
    folder = tmp_path_factory.mktemp("unpacked")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder)
    for path in (folder / "contensou/bin").iterdir():
        path.chmod(0o755)
    return folder / "contensou"


@pytest.fixture(scope="session")
def contensou(unpacked):
    """The package."""
    sys.path.insert(0, str(unpacked.parent))
    yield importlib.import_module("contensou")
    sys.path.remove(str(unpacked.parent))
    for name in [name for name in sys.modules if name.split(".")[0] == "contensou"]:
        del sys.modules[name]
