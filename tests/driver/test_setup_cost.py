"""What it costs to read and check scenes of many bodies: linear in their number."""

from __future__ import annotations

import resource

import pytest
from programs import captured


def many_balls(number: int) -> list[str]:
    """Balls on a floor in a grid, each with contacts with the floor and two neighbours."""
    row = int(number**0.5)
    lines = [
        "&scene gravity = 0, 0, -9.81, t_end = 1e-3 /",
        "&material name = 'steel', young = 2.1e11, poisson = 0.3 /",
        "&surface name = 'floor', body = 'ground', shape = 'plane', material = 'steel' /",
    ]
    for i in range(number):
        place = f"{0.021 * (i % row)}, {0.021 * (i // row)}, 0.0101"
        lines += [
            f"&body name = 'b_{i}', mass = 0.0327, inertia = 3*1.31e-6, position = {place} /",
            f"&surface name = 's_{i}', body = 'b_{i}', shape = 'sphere', radius = 0.01, "
            "material = 'steel' /",
            f"&contact name = 'f_{i}', surfaces = 's_{i}', 'floor', "
            "friction = 'contensou_exact', friction_coefficient = 0.2 /",
        ]
        lines += [
            f"&contact name = 'c_{i}_{step}', surfaces = 's_{i}', 's_{(i + step) % number}', "
            "damping = 'hunt_crossley', restitution = 0.8 /"
            for step in (1, row)
        ]
    return lines


@pytest.fixture
def cost(executable, tmp_path, build_kind):
    """Status, output, CPU time [s] and largest memory [MB] of `contensou check`."""
    if build_kind != "release":
        pytest.skip("costs are those of a release build")

    def measure(lines, *words):
        path = tmp_path / "many.nml"
        path.write_text("\n".join(lines) + "\n")
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        done = captured(
            [str(executable), "check", path.name, *words],
            cwd=tmp_path,
            timeout=300,
        )
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        return done.returncode, done.stdout + done.stderr, seconds, after.ru_maxrss / 1024

    return measure


def test_many_bodies(cost):
    """The time is proportional to the number of groups, also with settings of many of them."""
    _, _, few, _ = cost(many_balls(1000), "--expand")
    status, text, many, memory = cost(many_balls(10000), "--expand")
    assert status == 0, text
    assert text.count("&contact") == 30000
    assert many < 15.0 * few + 0.5
    assert memory < 1000.0
    status, _, seconds, memory = cost(many_balls(10000))
    assert status == 0
    assert seconds < 6.0
    assert memory < 1000.0
    words = [word for i in range(3000) for word in ("--set", f"b_{i}.mass=0.04")]
    status, text, seconds, _ = cost(many_balls(10000), "--expand", *words)
    assert status == 0
    assert text.count("mass = 0.04") == 3000
    assert seconds < 2.0 * many + 0.5


@pytest.mark.parametrize(
    ("old", "new"),
    [("surfaces = 's_", "surfaces = 'sx_"), ("surfaces =", "fricton = 'coulomb', surfaces =")],
    ids=["names", "keys"],
)
def test_many_mistakes(cost, old, new):
    """The first hundred are shown, the others are counted."""
    lines = many_balls(10000)
    wrong = 0
    for i, line in enumerate(lines):
        if line.startswith("&contact") and wrong < 20000:
            lines[i] = line.replace(old, new)
            wrong += 1
    status, text, seconds, _ = cost(lines)
    assert status == 2
    assert text.count(": error: ") == 100
    assert "... and 19900 more errors" in text
    assert "20000 errors in many.nml" in text
    assert seconds < 4.0
