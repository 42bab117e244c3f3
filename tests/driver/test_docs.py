"""The documentation keeps its word: examples are compiled and run, commands are run.

A block is fenced by ``` or indented by four. The first block after a mention of a file
docs/examples/NAME.f90 is its text, if that block is marked as Fortran, and the next one, or the
first itself, is its output. In a block, what follows a line `$ COMMAND` is the output of that
command.
"""

from __future__ import annotations

import math
import os
import re
import subprocess
from dataclasses import dataclass
from pathlib import Path

import pytest
from programs import captured

ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
GUIDES = [ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md", *sorted(ROOT.glob("tests/*/README.md"))]
EXAMPLES = sorted((ROOT / "docs" / "examples").glob("*.f90"))
SUNDIALS = (
    "fcvode_mod",
    "cvode",
    "fnvecserial_mod",
    "nvecserial",
    "fsunmatrixdense_mod",
    "fsunlinsoldense_mod",
    "fsunmatrixsparse_mod",
    "sunmatrixsparse",
    "fsunlinsolklu_mod",
    "sunlinsolklu",
    "fsunnonlinsolfixedpoint_mod",
    "generic",
)
NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|[-+]?Infinity|NaN")


@dataclass(frozen=True)
class Block:
    """A block of code or output on a page."""

    line: int  # where it begins, from 0
    language: str  # what is said after the fence
    text: str  # with a newline at the end


def blocks_of(page: Path) -> list[Block]:
    """All blocks of a page, in order."""
    lines = page.read_text(encoding="utf-8").splitlines()
    blocks = []
    i = 0
    while i < len(lines):
        start, fence = i, re.fullmatch(r"```(.*)", lines[i])
        if fence:
            i = next((j for j in range(i + 1, len(lines)) if lines[j] == "```"), len(lines))
            blocks.append(Block(start, fence[1].strip(), "\n".join(lines[start + 1 : i]) + "\n"))
        elif lines[i].startswith("    ") and (i == 0 or not lines[i - 1].strip()):
            while i + 1 < len(lines) and (lines[i + 1].startswith("    ") or not lines[i + 1]):
                i += 1
            body = [line[4:] for line in lines[start : i + 1]]
            blocks.append(Block(start, "", "\n".join(body).rstrip("\n") + "\n"))
        i += 1
    return blocks


def shown_of(example: Path) -> list[tuple[str, str | None, str]]:
    """Where an example is mentioned with a block after it: page, text if shown, output."""
    found = []
    for page in PAGES:
        blocks = blocks_of(page)
        for i, line in enumerate(page.read_text(encoding="utf-8").splitlines()):
            if not re.search(rf"\bexamples/{re.escape(example.name)}", line):
                continue
            following = [block for block in blocks if block.line > i]
            text = None
            if following and following[0].language.lower() == "fortran":
                text = following.pop(0).text
            if following:
                found.append((page.name, text, following[0].text))
    return found


def commands() -> list:
    """The commands of all pages that evaluate a kernel: (command, output or None)."""
    found = []
    for page in PAGES:
        for block in blocks_of(page):
            shown: list[tuple[str, list[str] | None]] = []
            for line in block.text.splitlines():
                if line.startswith("$ "):
                    shown.append((line[2:], []))
                elif shown and shown[-1][1] is not None:
                    shown[-1][1].append(line)
                elif re.match(r"(printf|echo|contensou|cat)\b", line):
                    shown.append((line, None))
            for command, output in shown:
                if re.search(r"\bcontensou eval\b", command):
                    text = None if output is None else "\n".join(output).rstrip("\n") + "\n"
                    found.append(pytest.param(command, text, id=f"{page.stem}-{len(found) + 1}"))
    return found


def same(found: str, expected: str) -> bool:
    """Whether two texts are the same but for the last digits of numbers."""
    if NUMBER.sub("0", found) != NUMBER.sub("0", expected):
        return False
    pairs = zip(NUMBER.findall(found), NUMBER.findall(expected), strict=True)
    return all(
        a == b or math.isclose(float(a), float(b), rel_tol=1e-14, abs_tol=1e-17) for a, b in pairs
    )


@pytest.fixture
def build_example(executable, build_kind, sanitized, tmp_path):
    """Compile an example against the library of the build under test; return its executable."""
    archive = executable.parents[1] / "src" / "libcontensou.a"

    def build_it(example: Path) -> Path:
        found = subprocess.run(
            ["pkg-config", "--libs", "hdf5-serial", "gsl"],
            capture_output=True,
            text=True,
            check=True,
        ).stdout.split()
        libraries = [
            *found,
            "-lhdf5_serial_hl",
            *(f"-lsundials_{name}" for name in SUNDIALS),
            "-lm",
        ]
        options = {
            "release": ["-O2"],
            "checked": ["-O0", "-g", "-fcheck=all", "-ffpe-trap=invalid,zero,overflow"],
        }[build_kind]
        if sanitized:
            options.append("-fsanitize=address,undefined")
        program = tmp_path / example.stem
        done = captured(
            [
                *("gfortran", "-std=f2018", "-Wall", "-Wextra", "-Wimplicit-interface", "-Werror"),
                *(*options, f"-I{archive}.p", f"-J{tmp_path}"),
                *(str(example), str(archive), *libraries, "-o", str(program)),
            ],
            cwd=tmp_path,
            timeout=120,
        )
        assert done.returncode == 0, done.stderr
        return program

    return build_it


def test_there_are_examples_and_commands():
    assert EXAMPLES
    assert any(command.values[1] for command in commands())


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda example: example.stem)
def test_example_prints_what_the_page_shows(example, build_example, tmp_path):
    done = captured(
        [build_example(example)],
        cwd=tmp_path,
        timeout=60,
    )
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    shown = shown_of(example)
    assert shown, f"no page shows what {example.name} prints:\n{done.stdout}"
    if len(shown) == 1:
        assert shown[0][2] == done.stdout, f"on {shown[0][0]}"
    else:
        assert done.stdout in [output for _, _, output in shown]


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda example: example.stem)
def test_example_is_as_the_page_shows_it(example):
    for page, text, _ in shown_of(example):
        if text is not None:
            assert text == example.read_text(encoding="utf-8"), f"on {page}"


@pytest.mark.parametrize(("command", "output"), commands())
def test_command_prints_what_the_page_shows(command, output, executable, tmp_path):
    path = f"{executable.parent}{os.pathsep}{os.environ['PATH']}"
    done = captured(
        ["bash", "-o", "pipefail", "-c", command],
        cwd=tmp_path,
        env={**os.environ, "PATH": path},
        stdin=subprocess.DEVNULL,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    assert done.stdout.count("\n") >= 2
    if output is not None:
        assert same(done.stdout, output), f"\n{done.stdout}is not\n{output}"


def scenes() -> list:
    """The scenes of all pages that are whole: they end with what to write."""
    return [
        pytest.param(block.text, id=f"{page.stem}-{block.line}")
        for page in PAGES
        for block in blocks_of(page)
        if block.text.startswith("&scene") and "&output" in block.text
    ]


@pytest.mark.parametrize("method", ["cvode_bdf", "cvode_adams"])
@pytest.mark.parametrize("scene", scenes())
def test_scene_of_a_page_runs(scene, method, executable, tmp_path):
    """A scene that a page shows passes the check and runs to its end.

    Its ball sticks to the floor in each impact: with cvode_adams that may end in a message, but it
    must end.
    """
    (tmp_path / "scene.nml").write_text(scene, encoding="utf-8")
    run = {"cwd": tmp_path, "capture_output": True, "text": True, "timeout": 120, "check": False}
    assert subprocess.run([executable, "check", "scene.nml"], **run).returncode == 0
    done = subprocess.run(
        [
            executable,
            "run",
            "scene.nml",
            "-q",
            "-o",
            "out.h5",
            "--set",
            f"integrator.method={method}",
        ],
        **run,
    )
    if method == "cvode_adams" and done.returncode == 1:
        assert "the steps have shrunk to" in done.stderr
        assert "'cvode_bdf'" in done.stderr
    else:
        assert done.returncode == 0, done.stderr
        assert (tmp_path / "out.h5").exists()


def test_the_mistake_that_the_readme_shows(executable, tmp_path):
    readme = ROOT / "README.md"
    blocks = blocks_of(readme)
    scene = next(block.text for block in blocks if block.text.startswith("&scene"))
    shown = next(block.text for block in blocks if "error: unknown key" in block.text)
    (tmp_path / "ball.nml").write_text(scene.replace("mass =", "mas ="), encoding="utf-8")
    done = captured(
        [executable, "check", "ball.nml"],
        cwd=tmp_path,
        timeout=60,
    )
    assert done.returncode == 2
    assert done.stderr == shown


def prose_of(page: Path) -> list[str]:
    """The lines of a page that are neither code nor table nor picture."""
    lines = page.read_text(encoding="utf-8").splitlines()
    for block in blocks_of(page):
        length = block.text.count("\n") + 2 * lines[block.line].startswith("```")
        lines[block.line : block.line + length] = [""] * length
    return [line for line in lines if not re.match(r" *\||!\[", line)]


@pytest.mark.parametrize("page", PAGES + GUIDES, ids=lambda page: page.stem)
def test_prose_is_wrapped(page):
    assert [line for line in prose_of(page) if len(line) > 100] == []


def test_the_index_lists_every_page():
    index = (ROOT / "docs" / "index.md").read_text(encoding="utf-8")
    listed = re.findall(r"^\| \[[^]]+\]\(([\w-]+\.md)\) \|", index, re.MULTILINE)
    there = {page.name for page in (ROOT / "docs").glob("*.md")} - {"index.md"}
    assert set(listed) == there
    assert len(listed) == len(there)


@pytest.mark.parametrize("page", PAGES + GUIDES, ids=lambda page: page.stem)
def test_links_lead_somewhere(page):
    """Links to files of the tree, and to headings of pages."""
    for link in re.findall(r"\]\(([^)\s]+)\)", "\n".join(prose_of(page))):
        if link.startswith("http"):
            continue
        name, _, heading = link.partition("#")
        target = page.parent / name if name else page
        assert target.exists(), link
        if heading:
            titles = re.findall(r"^#+ (.+)$", target.read_text(encoding="utf-8"), re.MULTILINE)
            anchors = [re.sub(r"[^\w -]", "", title.lower()).replace(" ", "-") for title in titles]
            assert heading in anchors, link
