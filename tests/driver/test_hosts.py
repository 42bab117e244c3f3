"""The contacts inside other programs, and the notebook: examples of docs/hosts.md and python.md.

Each example runs in a process of its own, with the package as it lies unpacked. What it needs of
others is installed by scripts/test where it can be had; else the example is skipped.
"""

from __future__ import annotations

import importlib.util
import os
import re
import shutil
import sys
import time
from pathlib import Path

import pytest
from programs import captured

ROOT = Path(__file__).resolve().parents[2]
HOSTS = ROOT / "docs/examples/hosts"
NOTEBOOK = ROOT / "docs/examples/tippe_top.ipynb"
SCENE = ROOT / "inputs/tippe_top.nml"

sys.path.insert(0, str(ROOT / "scripts"))

from lib import browser  # noqa: E402

# How far the first touch of the stem may be from that of our own run [s]. SciPy has an adaptive
# method of order 8; the others have one of order 4 with steps of 1e-4 s, of which 14 make a period
# of the contact: 3.5e-6 s were found, and 1.6e-7 s with half the step, as the order says.
NEAR = {"scipy": 1e-7, "mujoco": 5e-6, "exudyn": 5e-6}


def need(module):
    """Skip the test where a module is not installed."""
    if importlib.util.find_spec(module) is None:
        pytest.skip(f"{module} is not installed")


def environment(unpacked, folder):
    """What finds the package as it is unpacked, and puts what it keeps into a folder."""
    # A backend that is set would keep the pictures of a notebook out of it.
    kept = {name: value for name, value in os.environ.items() if name != "MPLBACKEND"}
    return kept | {"PYTHONPATH": str(unpacked.parent), "IPYTHONDIR": str(folder)}


@pytest.mark.parametrize("host", sorted(NEAR))
def test_first_touch_in_a_host(host, unpacked, tmp_path):
    need(host)
    script = HOSTS / f"{host}_top.py"
    assert len(script.read_text().splitlines()) <= 100
    command = [sys.executable, script, SCENE]
    done = captured(command, env=environment(unpacked, tmp_path), cwd=tmp_path, timeout=300)
    assert done.returncode == 0, done.stderr
    found = re.search(r"^first touch (\S+) s, our own run (\S+) s$", done.stdout, re.MULTILINE)
    touch, expected = map(float, found.groups())
    assert expected == pytest.approx(1.743583, abs=1e-5)
    assert touch == pytest.approx(expected, abs=NEAR[host], rel=0)
    times = re.search(r"^CPU ([\d.]+) .*, .*? ([\d.]+) u?s$", done.stdout, re.MULTILINE)
    assert all(float(time) > 0 for time in times.groups())


def test_notebook(unpacked, tmp_path):
    """Every cell runs; the page is drawn by a browser in the frame in which a notebook shows it."""
    need("nbclient")
    need("ipykernel")
    need("matplotlib")
    shutil.copy(SCENE, tmp_path)
    shutil.copy(NOTEBOOK, tmp_path)
    program = (
        "import nbformat, nbclient; book = nbformat.read('tippe_top.ipynb', 4);"
        " nbclient.NotebookClient(book, timeout=120, kernel_name='python3').execute();"
        " nbformat.write(book, 'done.ipynb')"
    )
    command = [sys.executable, "-c", program]
    done = captured(command, env=environment(unpacked, tmp_path), cwd=tmp_path, timeout=300)
    assert done.returncode == 0, done.stderr
    import nbformat

    cells = nbformat.read(tmp_path / "done.ipynb", 4).cells
    outputs = [output for cell in cells for output in cell.get("outputs", [])]
    printed = "".join(output.get("text", "") for output in outputs)
    assert "3001 rows; the top rises by" in printed
    assert "stem_floor touch at 1.7436 s" in printed
    shown = [output["data"] for output in outputs if "data" in output]
    frames = [data["text/html"] for data in shown if "<iframe" in data.get("text/html", "")]
    assert any("image/png" in data for data in shown)
    assert any("first_touch_stem_floor" in data.get("text/plain", "") for data in shown)
    assert len(frames) == 1
    if browser.PROGRAM is None:
        return
    page = tmp_path / "page.html"
    page.write_text(f"<!doctype html><body style='margin: 0'>{frames[0]}</body>", encoding="utf-8")
    chromium = browser.Browser()
    try:
        chromium.open(page, "document.readyState == 'complete'")
        # A frame that stays empty has one colour.
        end = time.monotonic() + 60
        while colours_of(chromium.picture()[:480]) < 100:
            assert time.monotonic() < end, chromium.complaints
    finally:
        chromium.close()
    assert chromium.complaints == []


def colours_of(picture):
    """How many colours there are."""
    return len({tuple(colour) for colour in picture.reshape(-1, 3)[::7].tolist()})
