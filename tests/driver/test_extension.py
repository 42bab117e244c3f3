"""The patches of tests/extension: how few places a new part takes, and that it works.

All patches are applied to one copy of the sources, which is built without optimization. Each of
them adds one file, one row to a table and one line to a meson.build. With the release build only:
what is built does not depend on the build under test.
"""

from __future__ import annotations

import math
import re
import shutil
import signal
import subprocess
import time
from dataclasses import dataclass, field
from pathlib import Path

import h5py
import numpy as np
import pytest
from programs import captured

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "tests" / "extension"
PROGRAM = "drivers/contensou"
METHODS = ("cvode_bdf", "cvode_adams", "explicit8", "auto")
NAMES = ("law", "law_with_state", "shape", "quantity", "command")
# What a build needs of the tree.
SOURCES = ("meson.build", "meson_options.txt", "src", "drivers", "fmu", "include", "scripts")
OPTIONS = (
    *("--buildtype=debug", "-Doptimization=0", "-Ddebug=false"),
    *("-Dtests=false", "-Dlink_time_optimization=false"),
)


@dataclass
class Hunk:
    """Lines added, each after so many of the old lines, and the old lines around, by number."""

    added: list[tuple[int, str]] = field(default_factory=list)
    around: list[tuple[int, str]] = field(default_factory=list)

    def moved(self, lines: list[str]) -> list[tuple[int, str]]:
        """What is added, where the lines around stand now."""
        for shift in sorted(range(-len(lines), len(lines) + 1), key=abs):
            there = [shift + number for number, _ in self.around]
            if any(not 0 < number <= len(lines) for number in there):
                continue
            if all(lines[n - 1] == text for n, (_, text) in zip(there, self.around, strict=True)):
                return [(shift + place, line) for place, line in self.added]
        raise AssertionError(f"nowhere: {self.around}")


@dataclass
class Change:
    """What a patch does to a file."""

    path: str
    new: bool
    hunks: list[Hunk] = field(default_factory=list)

    @property
    def lines(self) -> list[str]:
        return [line for hunk in self.hunks for _, line in hunk.added]

    @property
    def uses(self) -> list[str]:
        """The added lines that make names of a module known."""
        return [line for line in self.lines if re.match(r"\s*use \w+, only : ", line)]


def changes_of(patch: str) -> list[Change]:
    """What a patch does; it must add lines and nothing else."""
    changes: list[Change] = []
    old = 0
    for line in patch.splitlines():
        if line.startswith("diff --git "):
            changes.append(Change(line.rpartition(" b/")[2], new=False))
        elif line.startswith("new file mode "):
            changes[-1].new = True
        elif line.startswith("@@ "):
            start, count = re.match(r"@@ -(\d+)(?:,(\d+))? ", line).groups()
            # A hunk without old lines names the line before it.
            old = int(start) - (count != "0")
            changes[-1].hunks.append(Hunk())
        elif line.startswith(("index ", "--- ", "+++ ")):
            continue
        elif line.startswith("+"):
            changes[-1].hunks[-1].added.append((old, line[1:]))
        elif line.startswith(" ") or line == "":
            old += 1
            changes[-1].hunks[-1].around.append((old, line[1:]))
        else:
            raise AssertionError(f"a patch only adds lines: {line!r}")
    return changes


def too_many_places(changes: list[Change]) -> str:
    """What a patch touches beyond one new file, one row and one line; empty if nothing."""
    new = [change for change in changes if change.new]
    builds = [change for change in changes if Path(change.path).name == "meson.build"]
    tables = [change for change in changes if change not in new and change not in builds]
    if [len(new), len(tables), len(builds)] != [1, 1, 1]:
        return f"{len(new)} new files, {len(tables)} tables, {len(builds)} meson.build"
    if len(builds[0].lines) != 1 or Path(new[0].path).name not in builds[0].lines[0]:
        return f"not the one line of {new[0].path} in {builds[0].path}: {builds[0].lines}"
    if len(tables[0].lines) - len(tables[0].uses) != 1 or len(tables[0].uses) > 1:
        return f"not one row in {tables[0].path}: {tables[0].lines}"
    return ""


def patch_of(name: str) -> str:
    path = FOLDER / f"{name}.patch"
    return path.read_text(encoding="utf-8")


def apply(patches: list[str], folder: Path) -> None:
    """Add what patches add, each as if it were alone, to the sources in a folder."""
    hunks: dict[str, list[Hunk]] = {}
    for patch in patches:
        for change in changes_of(patch):
            assert (folder / change.path).exists() != change.new, change.path
            hunks.setdefault(change.path, []).extend(change.hunks)
    for path, those in hunks.items():
        file = folder / path
        lines = file.read_text(encoding="utf-8").splitlines() if file.exists() else []
        insertions = [one for hunk in those for one in hunk.moved(lines)]
        for place, line in reversed(sorted(insertions, key=lambda one: one[0])):
            lines.insert(place, line)
        file.parent.mkdir(exist_ok=True)
        file.write_text("\n".join(lines) + "\n", encoding="utf-8")


def copy_sources(folder: Path) -> None:
    for name in SOURCES:
        if (ROOT / name).is_dir():
            shutil.copytree(ROOT / name, folder / name)
        else:
            shutil.copy(ROOT / name, folder / name)


@pytest.fixture(scope="module")
def extended_program(build_kind, tmp_path_factory) -> Path:
    """The program with all patches."""
    if build_kind != "release":
        pytest.skip("with the release build only")
    tree = tmp_path_factory.mktemp("extended")
    copy_sources(tree)
    patches = [path.read_text(encoding="utf-8") for path in sorted(FOLDER.glob("*.patch"))]
    apply(patches, tree)
    for words in (["meson", "setup", *OPTIONS, "build"], ["ninja", "-C", "build", PROGRAM]):
        done = captured(words, cwd=tree, timeout=600)
        assert done.returncode == 0, done.stdout[-5000:] + done.stderr[-2000:]
    return tree / "build" / PROGRAM


def final_state(path: Path) -> np.ndarray:
    """Position and velocities at the end."""
    with h5py.File(path) as file:
        names = ("position", "velocity", "angular_velocity")
        return np.concatenate([file[f"trajectory/{name}"][-1, 0] for name in names])


@pytest.fixture
def extended(extended_program, tmp_path):
    """Run the extended program in tmp_path: its standard output; it must succeed."""

    def run_it(*words) -> str:
        done = captured(
            [extended_program, *map(str, words)],
            cwd=tmp_path,
            timeout=120,
        )
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    return run_it


def test_there_is_no_patch_without_a_test():
    assert {path.stem for path in FOLDER.glob("*.patch")} == set(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_patch_adds_one_file_one_row_and_one_line(name):
    assert too_many_places(changes_of(patch_of(name))) == ""


@pytest.mark.parametrize("name", NAMES)
def test_patch_applies_to_the_sources_as_they_are(name, tmp_path):
    """By the program that a user would take, in a folder that is no repository."""
    patch = patch_of(name)
    copy_sources(tmp_path)
    done = captured(
        ["git", "apply", "--check", "--whitespace=error", "-"],
        input=patch,
        cwd=tmp_path,
        env={"PATH": "/usr/bin:/bin", "GIT_CEILING_DIRECTORIES": str(tmp_path.parent)},
        timeout=60,
    )
    assert done.returncode == 0, done.stderr


EXAMPLE = """\
diff --git a/src/a.f90 b/src/a.f90
new file mode 100644
--- /dev/null
+++ b/src/a.f90
@@ -0,0 +1,2 @@
+module contensou_a
+end module contensou_a
diff --git a/src/table.f90 b/src/table.f90
--- a/src/table.f90
+++ b/src/table.f90
@@ -1,2 +1,3 @@
 module contensou_table
+   use contensou_a, only : a
    use contensou_b, only : b
@@ -8,2 +9,3 @@
    row(b)
+   row(a)
 end
diff --git a/src/meson.build b/src/meson.build
--- a/src/meson.build
+++ b/src/meson.build
@@ -3,2 +3,3 @@
   'z.f90',
+  'a.f90',
   'b.f90',
"""


def test_places_are_counted():
    assert too_many_places(changes_of(EXAMPLE)) == ""
    twice = EXAMPLE.replace("+   row(a)\n", "+   row(a)\n+   row(c)\n")
    assert "not one row in src/table.f90" in too_many_places(changes_of(twice))
    other = EXAMPLE + EXAMPLE[: EXAMPLE.index("diff --git a/src/table")].replace("a.f90", "c.f90")
    assert "2 new files" in too_many_places(changes_of(other))
    with pytest.raises(AssertionError, match="only adds"):
        changes_of(EXAMPLE.replace("    row(b)\n", "-   row(b)\n"))


def test_lines_are_added_where_a_patch_says(tmp_path):
    (tmp_path / "src").mkdir()
    # Lines that have moved since are found where they are now.
    table = ["module contensou_table", "   use contensou_b, only : b", *"34567", "   row(b)", "end"]
    (tmp_path / "src" / "table.f90").write_text("\n".join(["! Moved.", *table]) + "\n")
    (tmp_path / "src" / "meson.build").write_text("1\n2\n  'z.f90',\n  'b.f90',\n")
    apply([EXAMPLE, EXAMPLE.replace("a.f90", "c.f90").replace("table.c", "table.f")], tmp_path)
    assert (tmp_path / "src" / "meson.build").read_text().splitlines()[2:] == [
        *("  'z.f90',", "  'a.f90',", "  'c.f90',", "  'b.f90',")
    ]
    table = (tmp_path / "src" / "table.f90").read_text().splitlines()
    assert table[2:4] == ["   use contensou_a, only : a"] * 2
    assert table[-3:] == ["   row(a)", "   row(a)", "end"]


def test_law(extended, tmp_path):
    """A law of friction with keys of its own: Stribeck's."""
    assert "static_coefficient f_0 [-], stribeck_velocity v_s [m/s]" in extended(
        "models", "stribeck"
    )
    text = extended("help", "contact.static_coefficient")
    assert "mandatory with friction = 'stribeck'" in text
    assert "bearing.stribeck_velocity" in extended("help", "bearing")
    scene = FOLDER / "law.nml"
    resolved = extended("check", scene, "--expand")
    assert "static_coefficient = 0.3" in resolved
    assert "stribeck_velocity = 0.01" in resolved or "stribeck_velocity = 1.0e-2" in resolved
    (tmp_path / "rows.csv").write_text(
        "N,a,b,f,vx,vy,w,static_coefficient,stribeck_velocity\n2,1e-3,1e-3,0.1,0.03,0,5,0.3,0.05\n"
    )
    line = extended("eval", "wrench", "--model", "stribeck", "--delta", "1e-3", "rows.csv")
    force = -2 * (0.1 + 0.2 * math.exp(-((0.03 / 0.05) ** 2)))
    assert [float(x) for x in line.splitlines()[1].split(",")[-3:]] == pytest.approx([force, 0, 0])
    speeds = []
    for name, static in (("rough", "0.6"), ("smooth", "0.1")):
        change = f"contact.static_coefficient={static}"
        slow = "contact.stribeck_velocity=0.2"
        extended("run", scene, "--set", change, "--set", slow, "-o", f"{name}.h5", "-q")
        with h5py.File(tmp_path / f"{name}.h5") as file:
            speeds.append(file["trajectory/velocity"][-1, 0, 0])
    # The one rolls at the end, the other one still slides.
    assert speeds[0] < 0.07 < speeds[1] < 0.1


def test_law_with_state(extended, tmp_path):
    """A friction coefficient that falls with slip: a state that a part owns."""
    scene = FOLDER / "law_with_state.nml"
    assert "states: friction_coefficient [-]" in extended("models", "weakening")
    assert "weakening, regularised, integrating friction_coefficient [-]" in extended(
        "check", scene
    )
    # From its equilibrium the ball has a constant normal force, and slides with
    # v dv/dx = -7/2 g mu, mu = f + (f_0 - f) exp(-x/L).
    f, f_0, length, g = 0.1, 0.4, 1e-3, 9.81
    stiffness = 4 / 3 * 9.1e9 / (2 * (1 - 0.3**2)) * math.sqrt(0.015)
    depth = (6e-3 * g / stiffness) ** (2 / 3)
    rest = ("--set", f"body.position=0,0,{0.015 - depth!r}")
    ways = {method: [f"integrator.method='{method}'"] for method in METHODS}
    ways["differences"] = ["integrator.jacobian='differences'"]
    ways["rigid"] = ["contact.normal='rigid'", "body.position=0,0,0.015"]
    for name, changes in ways.items():
        options = [word for change in changes for word in ("--set", change)]
        extended("run", scene, *rest, *options, "-o", f"{name}.h5", "-q")
        with h5py.File(tmp_path / f"{name}.h5") as file:
            rows = file["trajectory"]
            column = rows["friction_coefficient"]
            assert column.attrs["units"] == "1"
            assert column.attrs["long_name"] == "friction coefficient that slip has left"
            names = [column.dims[k][0].name for k in range(column.ndim)]
            assert names == ["/trajectory/time", "/trajectory/contact"]
            mu = column[:, 0]
            slip = rows["slip_velocity"][:, 0, 0]
            force = -rows["friction_force"][:, 0, 0] / rows["normal_force"][:, 0]
            error = np.abs(rows["energy_error"][:]).max() / rows["energy_kinetic"][0]
        assert mu[0] == f_0, name
        slides = slip > 0.02
        assert slides.sum() > 40, name
        x = -length * np.log((mu - f) / (f_0 - f))
        fall = f * x + (mu[0] - f) * length * (1 - np.exp(-x / length))
        assert np.allclose(slip[slides] ** 2, (0.3**2 - 7 * g * fall)[slides], rtol=0, atol=1e-8)
        assert np.allclose(force[slides], mu[slides], rtol=1e-12, atol=0), name
        assert error < 1e-8, name
    reference = final_state(tmp_path / "cvode_bdf.h5")
    for name in (*METHODS, "differences"):
        assert np.allclose(final_state(tmp_path / f"{name}.h5"), reference, rtol=0, atol=1e-8), name


def test_law_with_state_bounces(extended, tmp_path):
    """Values at touch and after lift-off; a scene without the law has no such column."""
    scene = FOLDER / "law_with_state.nml"
    changes = ("body.position=0,0,0.016", "contact.damping_coefficient=0.1", "scene.t_end=0.1")
    options = [word for change in changes for word in ("--set", change)]
    for method in METHODS:
        text = f"integrator.method='{method}'"
        extended("run", scene, *options, "--set", text, "-o", f"{method}.h5", "-q")
        with h5py.File(tmp_path / f"{method}.h5") as file:
            rows = file["trajectory"]
            mu, gap = rows["friction_coefficient"][:, 0], rows["gap"][:, 0]
            kinds = list(file["events/kind"].asstr()[:])
        assert kinds.count("touch") > 2
        assert np.allclose(mu[gap > 1e-9], 0.4, rtol=0, atol=1e-12), method
        assert (mu[gap < -1e-8] < 0.4).any(), method
    top = ROOT / "inputs" / "tippe_top.nml"
    extended("run", top, "--set", "scene.t_end=0.01", "-o", "without.h5", "-q")
    with h5py.File(tmp_path / "without.h5") as file:
        assert "friction_coefficient" not in file["trajectory"]


def test_law_with_state_goes_on(extended, extended_program, tmp_path):
    """A run that is interrupted keeps its states; a sweep takes them at a time."""
    scene = FOLDER / "law_with_state.nml"
    many = ("--set", "output.interval=1e-7")
    command = [extended_program, "run", scene, *many, "-q", "-o"]
    process = subprocess.Popen([*command, "stopped.h5"], cwd=tmp_path)
    part = tmp_path / "stopped.h5.part"
    deadline = time.monotonic() + 60
    while not part.exists() and time.monotonic() < deadline:
        time.sleep(0.01)
    time.sleep(0.2)
    process.send_signal(signal.SIGINT)
    assert process.wait(timeout=60) == 75
    extended("run", scene, *many, "-q", "-o", "stopped.h5", "--resume")
    extended("run", scene, *many, "-q", "-o", "whole.h5")
    with h5py.File(tmp_path / "stopped.h5") as one, h5py.File(tmp_path / "whole.h5") as other:
        assert one["provenance/lives"][()] == 2
        a, b = (file["trajectory/friction_coefficient"][:, 0] for file in (one, other))
    assert a.shape == b.shape == (200001,)
    assert np.allclose(a, b, rtol=0, atol=1e-9)
    assert np.diff(a).max() < 1e-12
    (tmp_path / "sweep.nml").write_text(
        f"&sweep scene = '{scene}', output = 'table.h5', keep = 'nothing' /\n"
        "&parameter name = 'contact.weakening_length', values = 1e-3, 2e-3 /\n"
        "&value name = 'mu', dataset = 'friction_coefficient', time = 0.01 /\n"
    )
    extended("sweep", "sweep.nml", "-q")
    with h5py.File(tmp_path / "table.h5") as file:
        mu = file["results/mu"][:]
    assert mu[0] == pytest.approx(a[100000], abs=1e-9)
    assert 0.1 < mu[0] < mu[1] < 0.4


def test_quantity(extended, tmp_path):
    """A column of the output file that the sources do not have."""
    scene = ROOT / "inputs" / "tippe_top.nml"
    extended("run", scene, "-o", "top.h5", "-q", "--set", "scene.t_end=0.01")
    with h5py.File(tmp_path / "top.h5") as file:
        rows = file["trajectory"]
        energy = rows["energy_rotation"]
        assert energy.attrs["units"] == "J"
        assert energy.attrs["long_name"] == "energy of rotation"
        names = [energy.dims[k][0].name for k in range(energy.ndim)]
        assert names == ["/trajectory/time", "/trajectory/body"]
        moment = file["body/mass"][0] / 2.0
        speed = np.linalg.norm(rows["velocity"][:, 0], axis=1)
        kinetic = rows["energy_kinetic"][:]
        assert np.allclose(energy[:, 0] + moment * speed**2, kinetic, rtol=1e-12, atol=0.0)


def test_shape(extended, tmp_path):
    """A spheroid, which the sources do not have."""
    assert "half_height" in extended("help", "surface")
    assert "spheroid, plane" in extended("models")
    extended("run", FOLDER / "shape.nml", "-o", "shape.h5", "-q")
    with h5py.File(tmp_path / "shape.h5") as file:
        rows = file["trajectory"]
        # The ball falls 5 mm onto the top of the spheroid.
        falling = rows["time"][:] < 0.03
        fall = 0.005 - 0.5 * 9.81 * rows["time"][falling] ** 2
        assert np.allclose(rows["gap"][falling, 1], fall, rtol=0.0, atol=1e-5)
        touching = rows["normal_force"][:, 1] > 0.0
        assert touching.any()
        # At its poles it is round.
        axes = rows["semi_axes"][touching, 1]
        assert np.allclose(axes[:, 0], axes[:, 1], rtol=1e-3, atol=0.0)


def test_command(extended):
    """A command that prints the masses of the bodies of a scene."""
    assert extended("masses", ROOT / "inputs" / "tippe_top.nml").split()[0] == "top"
    assert "masses SCENE" in extended("--help")
    usage = extended("masses", "--help")
    assert usage.startswith("usage: contensou masses SCENE [--set PATH=VALUE]...")
    assert extended("help", "masses") == usage
