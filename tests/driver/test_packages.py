"""Packages: what they say of the project is so, and, where asked, they are built and tried.

CONTENSOU_PACKAGES=1 in the environment asks to build the Debian packages and the wheel and to try
them in fresh Debian systems, which takes root, debootstrap and some minutes.
"""

from __future__ import annotations

import ast
import os
import re
import shutil
from pathlib import Path

import pytest
from programs import captured

ROOT = Path(__file__).resolve().parents[2]
DEBIAN = ROOT / "debian"
VERSION = re.search(r"version: '([\d.]+)'", (ROOT / "meson.build").read_text())[1]
CANNOT_BE_HAD = 3

asked = pytest.mark.skipif(
    not os.environ.get("CONTENSOU_PACKAGES"), reason="CONTENSOU_PACKAGES does not ask for it"
)


def paragraphs(path):
    """The paragraphs of a file of Debian's form, as dictionaries of their fields."""
    found = []
    for text in path.read_text().strip().split("\n\n"):
        fields = re.findall(r"^([\w-]+):[ \t]*((?:.*\n?)(?:[ \t].*\n?)*)", text, re.MULTILINE)
        found.append({name: " ".join(value.split()) for name, value in fields})
    return found


def test_versions_agree():
    head = (DEBIAN / "changelog").read_text().splitlines()[0]
    assert re.match(r"contensou \((.*)-\d+\) ", head)[1] == VERSION
    for name in ("packaging/spack/package.py", "packaging/conda/meta.yaml"):
        assert f'"{VERSION}"' in (ROOT / name).read_text()


def test_symbols_are_the_functions_of_the_header():
    """What leaves the interface, or enters it, must be told to those who link with the library."""
    listed = re.findall(
        r"^ (contensou_\w+)@Base ", (DEBIAN / "libcontensou0.symbols").read_text(), re.M
    )
    text = re.sub(r"/\*.*?\*/", "", (ROOT / "include/contensou.h").read_text(), flags=re.S)
    names = set(re.findall(r"\b(contensou_\w+)\(", re.sub(r"\btypedef\b[^;{]*;", "", text)))
    # What the header defines itself calls these, and may be there for older programs.
    needed = set(
        re.findall(r"\b(contensou_\w+)\(", re.sub(r"\b(typedef|static)\b[^;{]*[;{]", "", text))
    )
    assert listed == sorted(listed)
    assert needed <= set(listed) <= names


def test_tests_of_the_package_are_there():
    names = {package["Package"] for package in paragraphs(DEBIAN / "control")[1:]}
    assert names == {"contensou", "libcontensou0", "libcontensou-dev"}
    tests = paragraphs(DEBIAN / "tests/control")
    assert {test["Tests"] for test in tests} == {"program", "tools", "library"}
    for test in tests:
        assert os.access(DEBIAN / "tests" / test["Tests"], os.X_OK)
        assert names & set(test["Depends"].split(", "))
        done = captured(["sh", "-n", DEBIAN / "tests" / test["Tests"]])
        assert (done.returncode, done.stderr) == (0, "")


def test_every_tool_has_a_manual_page():
    page = DEBIAN / "contensou-tools.1"
    links = (DEBIAN / "contensou.links").read_text()
    tools = {"plot", "view", "export", "spot", "video", "submit"}
    assert set(re.findall(r"man1/contensou-(\w+)\.1\.gz$", links, re.M)) == tools
    assert all(f".B contensou-{tool}\n" in page.read_text() for tool in tools)
    if shutil.which("groff"):
        done = captured(["groff", "-man", "-ww", "-Tutf8", page])
        assert (done.returncode, done.stderr) == (0, "")


def test_recipes_not_built_here_say_so():
    ast.parse((ROOT / "packaging/spack/package.py").read_text())
    for name in ("packaging/spack/package.py", "packaging/conda/meta.yaml"):
        assert "Not built where it was written" in (ROOT / name).read_text()
    for name in ("Dockerfile", "contensou.def"):
        assert "scripts/container/install" in (ROOT / "scripts/container" / name).read_text()
    for script in ("scripts/container/install", "packaging/conda/build.sh", "scripts/debian"):
        assert os.access(ROOT / script, os.X_OK)
        assert captured(["bash", "-n", ROOT / script]).returncode == 0
    options = (ROOT / "meson_options.txt").read_text()
    for name in (
        "packaging/spack/package.py",
        "packaging/conda/build.sh",
        "scripts/container/install",
    ):
        for option in re.findall(r"-D([a-z]\w*)=", (ROOT / name).read_text()):
            assert option == "default_library" or f"option('{option}'" in options


def test_how_to_get_it_in_ten_lines():
    text = (ROOT / "README.md").read_text().partition("\n## How to get it\n\n")[2]
    assert 0 < len(text.partition("\n\n")[0].splitlines()) <= 10


@asked
@pytest.mark.parametrize(
    "command",
    [
        ["scripts/debian", "--quick", "-o", "{folder}"],
        ["scripts/wheel", "--fresh", "-o", "{folder}", "-Dlink_time_optimization=false"],
    ],
    ids=["debian", "wheel"],
)
def test_in_a_fresh_debian(command, tmp_path):
    script, *words = [word.format(folder=tmp_path) for word in command]
    done = captured([ROOT / script, *words], timeout=3000)
    if done.returncode == CANNOT_BE_HAD:
        pytest.skip(done.stderr.splitlines()[-1])
    assert done.returncode == 0, done.stderr[-4000:]
    if script == "scripts/wheel":
        seconds = re.search(r"installed and run in a fresh Debian in (\d+) s", done.stderr)
        assert int(seconds[1]) < 30
