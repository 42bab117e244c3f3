"""Mutated scenes for the scene reader: it reads them or refuses them, and does nothing else.

tests/fuzz/fuzz_reader.f90 says what is checked. The whole of it, by hand: 1e6 scenes with the
release build and 5e4 with the sanitizers, as `fuzz_reader SEED COUNT SCRATCH SCENE...`.
"""

from __future__ import annotations

import resource

import pytest
from programs import captured


@pytest.fixture
def fuzz_reader(executable):
    """The program that feeds the reader."""
    path = executable.parents[1] / "tests" / "fuzz" / "fuzz_reader"
    if not path.is_file():
        pytest.skip("the tests are not built beside this executable")
    return path


def test_mutated_scenes(fuzz_reader, root, tmp_path, build_kind, sanitized):
    valid = sorted(root.glob("inputs/*.nml")) + sorted(root.glob("tests/hard/*.nml"))
    broken = sorted(root.glob("tests/driver/broken/*.nml"))
    count = 20000 if build_kind == "release" else 2000

    def limit():
        # The sanitizers reserve more than any machine has.
        if not sanitized:
            resource.setrlimit(resource.RLIMIT_AS, (2 << 30, 2 << 30))

    scratch = tmp_path / "scene.nml"
    done = captured(
        [fuzz_reader, "20091", str(count), scratch, *(8 * valid), *broken],
        preexec_fn=limit,
        timeout=600,
    )
    assert done.returncode == 0, f"{done.stdout}{done.stderr}\n{scratch.read_bytes()!r}"
    assert done.stdout.startswith(f"{count} scenes: ")
    assert int(done.stdout.split()[2]) >= count // 100


@pytest.mark.parametrize("key", ["inertia = 3*1e300", "mass = 1e-300", "position = 0, 0, 1e160"])
def test_numbers_beyond_computing(run, scene, mistakes, key):
    name, _, value = key.partition(" = ")
    result = run("check", scene, "--set", f"top.{name} = {value}")
    assert result.status == 2
    assert any("beyond what can be computed with" in m.message for m in mistakes(result.err))


def test_resolved_angular_velocity_is_a_scene_again(run, scene, tmp_path):
    scene.write_text(
        scene.read_text().replace("spin = 0, 0, 180.0", "angular_velocity = 0, 0, 180.0")
    )
    result = run("check", scene)
    assert result.status == 0, result.err
    (tmp_path / "again.nml").write_text(result.out.partition("\nsettings\n")[2])
    again = run("check", "again.nml")
    assert again.status == 0, again.err
    assert again.out.partition("\nsettings\n")[2] == result.out.partition("\nsettings\n")[2]


def test_radius_without_a_stiffness(run, scene, mistakes):
    result = run("check", scene, "--set", "stem.radius = 1e-40")
    assert result.status == 2
    assert any("stiffness of contact 'stem_floor'" in m.message for m in mistakes(result.err))
