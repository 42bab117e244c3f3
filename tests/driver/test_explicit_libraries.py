"""Explicit methods of GSL and SUNDIALS beside explicit8: the same touch, and its price."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import pytest
from programs import captured

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))

from lib import explicit_libraries  # noqa: E402

FALL = """\
&scene {gravity} t_end = {t_end} /
&material name = 'wood', young = 9.1e9, poisson = 0.3 /
&body name = 'ball', mass = 6.0e-3, inertia = 8.0e-7, 8.0e-7, 7.0e-7,
   position = 0, 0, 0.515, velocity = 0, 0, {velocity} /
&surface name = 'ball', body = 'ball', shape = 'sphere', radius = 1.5e-2, material = 'wood' /
&surface name = 'floor', body = 'ground', shape = 'plane', normal = 0, 0, 1, material = 'wood' /
&contact name = 'ball_floor', surfaces = 'ball', 'floor' /
"""


@pytest.fixture(scope="module")
def build(executable) -> Path:
    """The build folder; its program needs ERKStep of SUNDIALS, which set-up brings."""
    folder = executable.parent.parent
    if not (folder / "tests" / "cost" / "library_explicit8").is_file():
        if Path("/usr/include/sundials/fortran/farkode_erkstep_mod.mod").is_file():
            pytest.fail(f"{folder} lacks tests/cost/library_explicit8, though there is ERKStep")
        pytest.skip("there is no ERKStep")
    return folder


@pytest.fixture
def fall(build, tmp_path):
    """Drop a ball by 0.5 m; the words that the program prints."""

    def run_it(method, t_end=10.0, contact="ball_floor", g=9.81, velocity=0.0):
        path = tmp_path / "fall.nml"
        gravity = f"gravity = 0, 0, {-g}," if g else ""
        path.write_text(FALL.format(t_end=t_end, gravity=gravity, velocity=velocity))
        words = [build / "tests" / "cost" / "library_explicit8", path, method, "1e-8", contact]
        return captured(list(map(str, words)))

    return run_it


# Not with Fehlberg's pair, whose estimate sees the ends of a step alone: it admits steps from free
# flight through the floor.
@pytest.mark.parametrize("method", ["bare", "explicit8", "gsl_rk8pd", "erkstep_pair"])
@pytest.mark.parametrize(
    ("g", "velocity", "time"), [(9.81, 0.0, math.sqrt(2 * 0.5 / 9.81)), (0.0, -1.0, 0.5)]
)
def test_free_flight_ends_at_the_floor(fall, method, g, velocity, time):
    # Without gravity a step has no error, and the next is as long as may be: to where the contact
    # law ends, from where it must be taken again.
    done = fall(method, g=g, velocity=velocity)
    assert done.returncode == 0, done.stderr
    found, kind, steps, right_hand_sides, _ = done.stdout.split()
    assert kind == "touch"
    assert float(found) == pytest.approx(time, abs=1e-9)
    assert 12 * int(steps) < int(right_hand_sides) < 10_000


@pytest.mark.parametrize("method", explicit_libraries.METHODS)
def test_without_a_touch_it_is_the_end(fall, method):
    time, kind, *_ = fall(method, t_end=0.25).stdout.split()
    assert kind == "end"
    assert float(time) == pytest.approx(0.25, rel=1e-15)


def test_what_there_is_not_is_refused(fall):
    for done, word in (
        (fall("euler"), "no method euler"),
        (fall("bare", contact="wall"), "no contact wall"),
    ):
        assert done.returncode == 2
        assert word in done.stderr


def test_all_find_the_touch_of_the_stem(build, inputs, record_property):
    study = explicit_libraries.Study(build, inputs)
    for method in explicit_libraries.METHODS:
        error = study.error(study.run(method, 1e-6))
        print(f"   {method:16s} {error:.2g} s")
        record_property(f"error of {method} [s]", error)
        assert error <= 5e-6, method


@pytest.mark.release_only("right-hand sides are the same in each build")
def test_what_an_error_of_a_microsecond_costs(build, inputs, record_property):
    """Right-hand sides; `scripts/bench libraries` takes times."""
    study = explicit_libraries.Study(build, inputs)
    bound = 1e-6
    work = {}
    for method in [*explicit_libraries.METHODS, explicit_libraries.WHOLE_RUN]:
        found = study.cheapest(method, [bound])
        assert found, f"{method} does not find the touch within {bound} s"
        assert found[bound].error <= bound
        work[method] = found[bound].run.right_hand_sides
        print(f"   {method:16s} {work[method]} right-hand sides")
        record_property(f"right-hand sides of {method}", work[method])
    own = work["explicit8"]
    assert own <= 1.3 * work["bare"]
    assert work[explicit_libraries.WHOLE_RUN] <= 1.5 * work["bare"]
    assert own <= 1.2 * work["gsl_rk8pd"]
    assert all(own <= 1.2 * work[name] for name in work if name.startswith("erkstep"))
