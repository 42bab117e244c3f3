"""The regression cases hold, each shipped scene has one, and results are the same bit for bit."""

from __future__ import annotations

import re
import shutil
import sys
from pathlib import Path

import h5py
import pytest
from programs import captured

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))

from lib import regression  # noqa: E402

CASES = {case.name: case for case in regression.cases()}
METHODS = ("cvode_bdf", "cvode_adams", "explicit8")
SCRIPT = ROOT / "scripts" / "regress.py"


def regress(*words):
    """Call scripts/regress.py."""
    return captured(
        [sys.executable, str(SCRIPT), *map(str, words)],
        timeout=600,
    )


def test_each_shipped_scene_has_a_case():
    assert regression.scenes_without_case() == []
    assert CASES


@pytest.mark.parametrize("name", CASES)
def test_a_case_holds(executable, tmp_path, name):
    good, words = regression.check(CASES[name], executable, tmp_path)
    assert good, words


@pytest.mark.parametrize("name", CASES)
def test_a_reference_is_small_and_its_rules_are_no_wider_than_was_measured(name):
    case = CASES[name]
    assert case.reference.stat().st_size < 100_000
    values = regression.results(case.reference)
    ruled = set()
    for line in case.rules.read_text().splitlines():
        path, word, *rest = line.split()
        if path == "#" or path not in values:
            continue
        ruled.add(path)
        size = spread = 0.0
        if "," in line:
            spread, size = (float(text) for text in line.rpartition("#")[2].split(","))
        if word != "ignore":
            # One digit, rounded up.
            widest = max(regression.MARGIN * spread, regression.FLOOR * size)
            assert float(word) <= 2.2 * widest, line
            assert rest[0] == "0"
        elif not regression.COUNTS.search(path):
            assert regression.MARGIN * 1.1 * spread > 0.5 * regression.VAGUE * size, line
    assert ruled | regression.EXACT >= set(values)


@pytest.mark.parametrize("name", CASES)
def test_a_case_sees_a_small_change(executable, tmp_path, build_kind, name):
    if build_kind == "checked":
        pytest.skip("this is about the rules, and the checked build is slow")
    # A change of a mass or of gravity by 1e-6 is far beyond rounding.
    case = CASES[name]
    found = regression.call(executable, "check", case.scene, *case.words(), folder=tmp_path)
    gravity = re.search(r"^ *gravity = (.*)$", found.stdout, re.MULTILINE)
    numbers = [float(text) * (1 + 1e-6) for text in gravity[1].split(",")] if gravity else [0.0]
    if not any(numbers):
        pytest.skip("no gravity in this scene")
    changed = regression.Case(
        case.name, case.scene, [*case.overrides, f"scene.gravity={','.join(map(repr, numbers))}"]
    )
    good, words = regression.check(changed, executable, tmp_path)
    assert not good
    assert "/trajectory/" in words


def test_the_script(executable, tmp_path):
    names = list(CASES)[:2]
    result = regress("--program", executable, *names)
    assert result.returncode == 0, result.stdout + result.stderr
    assert result.stdout.splitlines()[-1] == f"{len(names)} passed, 0 failed"
    result = regress("--program", executable, "no_such_case")
    assert result.returncode == 2
    assert "no case 'no_such_case'" in result.stderr
    result = regress("--program", tmp_path / "nothing")
    assert result.returncode == 2
    assert "there is no executable" in result.stderr


def test_a_case_can_be_added_and_renewed(executable, tmp_path, scene_text, build_kind):
    if build_kind != "release":
        pytest.skip("one build is enough")
    # A copy of the scripts, so that the project stays as it is.
    root = tmp_path / "project"
    shutil.copytree(ROOT / "scripts", root / "scripts")
    (root / "inputs").mkdir()
    scene = root / "inputs" / "top.nml"
    scene.write_text(scene_text.replace("0.0120149875041659", "0.0120149"))
    script = root / "scripts" / "regress.py"

    def call(*words):
        command = [sys.executable, str(script), "--program", str(executable), *map(str, words)]
        return captured(command, timeout=600)

    result = call()
    assert result.returncode == 1
    assert "inputs/top.nml has no case: scripts/regress --add inputs/top.nml" in result.stdout
    assert result.stdout.splitlines()[-1] == "0 passed, 1 failed"
    result = call("--add", scene)
    assert result.returncode == 0, result.stderr
    folder = root / "tests" / "regression" / "top"
    assert {path.name for path in folder.iterdir()} == {"case.toml", "reference.h5", "rules"}
    result = call()
    assert result.returncode == 0, result.stdout
    before = (folder / "reference.h5").read_bytes()
    assert "top                            holds" in call("--update").stdout
    assert (folder / "reference.h5").read_bytes() == before
    # Another scene: told, renewed with a word on what changed, good again.
    scene.write_text(scene.read_text().replace("180.0", "181.0"))
    result = call()
    assert result.returncode == 1
    assert "/trajectory/angular_velocity" in result.stdout
    result = call("--update")
    assert result.returncode == 0, result.stderr
    assert "old reference A, new one B" in result.stdout
    assert "/trajectory/angular_velocity" in result.stdout
    assert (folder / "reference.h5").read_bytes() != before
    assert call().returncode == 0
    rules = (folder / "rules").read_text()
    result = call("--measure", "top")
    assert result.returncode == 0, result.stderr
    assert "largest value" in result.stdout
    assert (folder / "rules").read_text() == rules


# By how much the scenes that are stiff are cut short with methods for those that are not.
STIFF = {"bearing": 60, "rattleback": 5, "sliding_disc": 5}


@pytest.mark.sample(14)
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", CASES)
def test_the_same_bits(run, executable, tmp_path, name, method, build_kind):
    case = CASES[name]
    words = [*case.words(), "--set", f"integrator.method={method}"]
    # Rolling contacts all but stick: the methods for problems that are not stiff take minutes.
    shorter = 1
    if method in {"explicit8", "cvode_adams"}:
        shorter = next((times for start, times in STIFF.items() if name.startswith(start)), 1)
    if build_kind != "release":
        shorter *= 20
    if shorter > 1:
        end = next(item for item in case.overrides if item.startswith("scene.t_end="))
        end = float(end.partition("=")[2]) / shorter
        words += ["--set", f"scene.t_end={end}", "--set", f"output.interval={end / 20}"]
    files = []
    statuses = set()
    # Other lengths of names and of the environment move what is on the stack.
    for i in range(2):
        folder = tmp_path / ("x" * (1 + 57 * i))
        folder.mkdir()
        filler = {"FILLER": "y" * 999 * i}
        result = run("run", case.scene, "-q", "-o", "run.h5", *words, cwd=folder, env=filler)
        # A method may be the wrong one for a scene; then that, too, is the same twice.
        assert result.status in {0, 1}, result.err
        statuses.add(result.status)
        files.append(folder / ("run.h5" if result.status == 0 else "run.h5.part"))
    assert len(statuses) == 1
    result = run("diff", *files)
    assert result.status == 0, result.out + result.err
    assert result.out.startswith("same: ")
    # Not by way of the program: each number, bit for bit.
    ignored = re.compile(r"/provenance/|cpu_|command_line|resolved")
    compared = 0
    with h5py.File(files[0]) as a, h5py.File(files[1]) as b:
        names = []
        a.visit(names.append)
        for path in names:
            if isinstance(a[path], h5py.Dataset) and not ignored.search(f"/{path}"):
                same = a[path][()], b[path][()]
                if a[path].dtype.kind == "O":
                    assert str(same[0]) == str(same[1]), path
                else:
                    assert same[0].tobytes() == same[1].tobytes(), path
                compared += 1
    assert compared > 40
