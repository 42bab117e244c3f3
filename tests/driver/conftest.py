"""Fixtures of the driver tests: the executable, a way to run it, and a short scene.

CONTENSOU names the executable (build/drivers/contensou of the project if not set),
CONTENSOU_BUILD the kind of build it is: release, or checked, which is slow. CONTENSOU_RELEASE may
name an executable of the release build of the same sources, for what need not be run with a slow
one.
"""

from __future__ import annotations

import functools
import math
import os
import re
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

import pytest
from folders import SWEEP
from order import place, pytest_xdist_make_scheduler  # noqa: F401
from python_package import contensou, unpacked, wheel  # noqa: F401
from result import read

ROOT = Path(__file__).resolve().parents[2]
BUILD_KINDS = ("release", "checked")

SCENE = """\
&scene title = 'Tippe-Top', gravity = 0, 0, -9.81, t_end = 0.02 /
&material name = 'wood', young = 9.1e9, poisson = 0.3 /
&body
   name = 'top'
   mass = 6.0e-3
   inertia = 8.0e-7, 8.0e-7, 7.0e-7
   position = 0, 0, 0.0120149875041659
   axis = 0, 1, 0
   angle = 0.1
   spin = 0, 0, 180.0
/
&surface
   name = 'ball', body = 'top', shape = 'sphere'
   centre = 0, 0, 3.0e-3, radius = 1.5e-2, material = 'wood'
/
&surface
   name = 'stem', body = 'top', shape = 'sphere'
   centre = 0, 0, 16.0e-3, radius = 5.0e-3, material = 'wood'
/
&surface name = 'floor', body = 'ground', shape = 'plane', normal = 0, 0, 1, material = 'wood' /
&contact
   name = 'ball_floor', surfaces = 'ball', 'floor', normal = 'hertz'
   damping = 'hunt_crossley', damping_coefficient = 100.0
   friction = 'contensou_exact', friction_coefficient = 0.3
/
&contact
   name = 'stem_floor', surfaces = 'stem', 'floor', normal = 'hertz'
   damping = 'hunt_crossley', damping_coefficient = 100.0
   friction = 'contensou_exact', friction_coefficient = 0.3
/
&integrator method = 'cvode_bdf', rtol = 1e-8 /
&output file = 'top.h5', interval = 1.0e-3 /
"""


@dataclass(frozen=True)
class Result:
    """What a command left: exit status, standard output, standard error."""

    status: int
    out: str
    err: str


@dataclass(frozen=True)
class Mistake:
    """A mistake as the program shows it; line and column are 0 for a source as a whole."""

    source: str
    line: int
    column: int
    message: str
    excerpt: str
    carets: str
    expected: str


HEADING = re.compile(r"(?P<source>.+?)(?::(?P<line>\d+):(?P<column>\d+))?: error: (?P<message>.+)")


def parse_mistakes(text: str) -> list[Mistake]:
    """Mistakes in what the program wrote to standard error."""
    lines = text.split("\n")
    found = []
    for i, line in enumerate(lines):
        heading = HEADING.fullmatch(line)
        if not heading:
            continue
        excerpt = carets = expected = ""
        rest = lines[i + 1 :]
        number, bar, shown = (rest[0] if rest else "").partition(" | ")
        if heading["line"]:
            assert bar, f"no source line after {line!r}"
            assert int(number) == int(heading["line"])
            gutter, bar, carets = rest[1].partition(" | ")
            assert bar, f"no caret after {line!r}"
            assert gutter == " " * len(number)
            assert re.fullmatch(r"[ \t]*\^~*", carets)
            excerpt = shown
            rest = rest[2:]
        if rest and rest[0].startswith("  expected: "):
            expected = rest[0].removeprefix("  expected: ")
        found.append(
            Mistake(
                heading["source"],
                int(heading["line"] or 0),
                int(heading["column"] or 0),
                heading["message"],
                excerpt,
                carets,
                expected,
            )
        )
    return found


def parse_settings(text: str) -> list[tuple[str, dict[str, list]]]:
    """The resolved settings that `check` prints: groups in order, each with its keys and values."""

    def value(word: str):
        if word[0] == "'":
            return word[1:-1].replace("''", "'")
        if word in (".true.", ".false."):
            return word == ".true."
        return float(word)

    groups = []
    body = text.partition("\nsettings\n")[2]
    assert body, "no settings in this output"
    for line in body.splitlines():
        line = line.strip()
        if line.startswith("&"):
            groups.append((line[1:], {}))
        elif line != "/":
            key, equals, values = line.partition(" = ")
            assert equals
            words = re.findall(r"'(?:[^']|'')*'|[^,\s]+", values)
            groups[-1][1][key] = [value(word) for word in words]
    return groups


def pytest_configure(config):
    """Tell the marks by which tests say what the checked build need not repeat."""
    config.addinivalue_line("markers", "release_only(reason): with the release build only")
    config.addinivalue_line("markers", "sample(n): with the checked build n of its cases only")


def spread(things, number):
    """So many of some things, evenly spread over them, the first among them."""
    things = list(things)
    return things[:: max(1, math.ceil(len(things) / number))]


def pytest_collection_modifyitems(config, items):
    """Bring the tests into order, and leave out of the checked build what it need not do.

    A test that does not touch the executable (of a page, a script, a reference) is the same with
    each build. What the release build proves of figures need not be proved again by one that is
    there to find wrong memory and wrong operations: it does all that can be done, but less often.
    """
    items.sort(key=place)
    if os.environ.get("CONTENSOU_BUILD", "release") == "release":
        return
    left = [item for item in items if "executable" not in getattr(item, "fixturenames", ())]
    cases = {}
    for item in items:
        if item.get_closest_marker("release_only"):
            left.append(item)
        elif mark := item.get_closest_marker("sample"):
            cases.setdefault((item.path, item.originalname, mark.args[0]), []).append(item)
    for (*_, number), those in cases.items():
        left += [item for item in those if item not in spread(those, number)]
    if left:
        left = set(left)
        config.hook.pytest_deselected(items=[item for item in items if item in left])
        items[:] = [item for item in items if item not in left]


@pytest.fixture(scope="session")
def mistakes():
    """Function from standard error to a list of mistakes."""
    return parse_mistakes


@pytest.fixture(scope="session")
def settings():
    """Function from the output of `check` to a list of (group, {key: values})."""
    return parse_settings


@pytest.fixture(scope="session")
def root() -> Path:
    """Folder of the project."""
    return ROOT


@pytest.fixture(scope="session")
def inputs() -> Path:
    """Folder of the shipped scenes."""
    return ROOT / "inputs"


@pytest.fixture(scope="session")
def reference() -> Path:
    """Folder of the reference data."""
    return ROOT / "tests" / "reference"


@pytest.fixture(scope="session")
def executable() -> Path:
    """The executable under test, as an absolute path."""
    named = os.environ.get("CONTENSOU")
    path = Path(named) if named else ROOT / "build" / "drivers" / "contensou"
    if not path.is_file():
        pytest.exit(f"there is no executable {path}; build it or set CONTENSOU", returncode=2)
    return path.absolute()


@pytest.fixture(scope="session")
def quick_executable(executable) -> Path:
    """For runs that only say how far results scatter: CONTENSOU_RELEASE, or the one under test."""
    named = os.environ.get("CONTENSOU_RELEASE")
    return Path(named).absolute() if named else executable


@pytest.fixture(scope="session")
def build_kind() -> str:
    """Kind of the build under test: release or checked."""
    kind = os.environ.get("CONTENSOU_BUILD", "release")
    if kind not in BUILD_KINDS:
        pytest.exit(f"CONTENSOU_BUILD is '{kind}', not one of {BUILD_KINDS}", returncode=2)
    return kind


@pytest.fixture(scope="session")
def sanitized(executable) -> bool:
    """Whether the address sanitizer watches the executable."""
    return b"__asan_init" in executable.read_bytes()


@pytest.fixture(scope="session")
def preload(root, tmp_path_factory, sanitized):
    """Build a library of tests/driver/preload; `preload(name)` is the environment that loads it."""
    if sanitized:
        pytest.skip("a sanitizer must be the first library")

    @functools.cache
    def make(name: str) -> dict[str, str]:
        path = tmp_path_factory.mktemp("preload") / f"{name}.so"
        source = root / "tests" / "driver" / "preload" / f"{name}.c"
        compiler = os.environ.get("CC", "cc")
        subprocess.run([compiler, "-shared", "-fPIC", "-o", path, source, "-ldl"], check=True)
        return {"LD_PRELOAD": str(path)}

    return make


@pytest.fixture
def run(executable, tmp_path):
    """Run the executable; `run(*args, cwd, input, timeout, env) -> Result(status, out, err)`.

    The folder is tmp_path unless `cwd` says otherwise. `input` is text or bytes for standard input,
    empty if not given; `env` is added to the environment. A signal gives a negative status.
    """
    return runner(executable, tmp_path)


@pytest.fixture
def simulate(run, tmp_path):
    """Run a scene (text or path) with `--set` options, and read what it wrote."""

    def simulate_it(scene, *sets, name="out.h5"):
        path = scene
        if isinstance(scene, str):
            path = tmp_path / "scene.nml"
            path.write_text(scene)
        options = [word for text in sets for word in ("--set", text)]
        done = run("run", path, "-o", name, "--force", "-q", *options, timeout=600)
        assert done.status == 0, done.err
        return read(tmp_path / name, done.err)

    return simulate_it


@pytest.fixture
def slow_build(build_kind) -> bool:
    """Whether the build is far slower than a release."""
    return build_kind != "release"


@pytest.fixture
def sample(slow_build):
    """Function from a sequence and a number: all of it, with a slow build so many of it."""
    return lambda things, number: spread(things, number) if slow_build else list(things)


@pytest.fixture
def quick_run(quick_executable, tmp_path):
    """Run the quick executable, as `run` does the one under test."""
    return runner(quick_executable, tmp_path)


def runner(program, folder):
    """What runs a program in a folder."""

    def run_it(*args, cwd=None, input=None, timeout=120, env=None) -> Result:
        data = input.encode() if isinstance(input, str) else input or b""
        done = subprocess.run(
            [str(program), *map(str, args)],
            cwd=folder if cwd is None else cwd,
            input=data,
            capture_output=True,
            timeout=timeout,
            env={**os.environ, **env} if env else None,
            check=False,
        )
        return Result(
            done.returncode,
            done.stdout.decode("utf-8", errors="backslashreplace"),
            done.stderr.decode("utf-8", errors="backslashreplace"),
        )

    return run_it


@pytest.fixture
def fails(run, tmp_path):
    """Run the text of a scene that ends with a status, 1 if not given: what the program says."""

    def fails_it(text, status=1):
        path = tmp_path / "scene.nml"
        path.write_text(text)
        done = run("run", path, "-o", "out.h5", "--force", "-q", timeout=600)
        assert done.status == status, done.err
        return done.err

    return fails_it


@pytest.fixture(scope="session")
def scene_text() -> str:
    """A Tippe-Top of 20 ms, whose output file is top.h5."""
    return SCENE


@pytest.fixture
def scene(tmp_path, scene_text) -> Path:
    """The short Tippe-Top as a file of its own, tmp_path/top.nml."""
    path = tmp_path / "top.nml"
    path.write_text(scene_text)
    return path


@pytest.fixture
def files(scene, tmp_path):
    """That scene as scene.nml and a sweep of it, sweep.nml; the folder."""
    shutil.copy(scene, tmp_path / "scene.nml")
    (tmp_path / "sweep.nml").write_text(SWEEP)
    return tmp_path
