"""What a scene need not say by itself: expressions and constants."""

from __future__ import annotations

import h5py
import numpy as np
import pytest

CONSTANTS = "&constants r = 0.01, m = 4/3*pi*r**3*7850, tilt = 30*deg /\n"
BALL = """\
&scene t_end = 0.01, gravity = 0, 0, -9.81 /
&material name = 'steel', young = 2.1e11, poisson = 0.3 /
&body name = 'ball', mass = 2*m, inertia = 3*1e-5, position = 0, 0, r + 0.001,
   axis = 0, 1, 0, angle = '30 deg', velocity = r/2 -r (r + 1)*2 /
&surface name = 'skin', body = 'ball', shape = 'sphere', radius = r, material = 'steel' /
&surface name = 'floor', body = 'ground', shape = 'plane', material = 'steel' /
&contact name = 'c', surfaces = 'skin', 'floor' /
"""
MASS = 4 / 3 * np.pi * 0.01**3 * 7850


@pytest.fixture
def expand(run, tmp_path, settings):
    """Settings of a scene as `check --expand` prints them, with `--set` options."""

    def expand_it(text, *sets):
        path = tmp_path / "scene.nml"
        path.write_text(text)
        options = [word for value in sets for word in ("--set", value)]
        result = run("check", "--expand", path, *options)
        assert result.status == 0, result.err
        return settings("\nsettings\n" + result.out)

    return expand_it


def group(found, name, label=None):
    """Settings of one group."""
    (one,) = [
        keys for kind, keys in found if kind == name and label in (None, keys.get("name", [0])[0])
    ]
    return one


def test_values_are_computed_from_constants(expand):
    ball = group(expand(CONSTANTS + BALL), "body")
    assert ball["mass"] == [pytest.approx(2 * MASS, rel=1e-15)]
    assert ball["inertia"] == [1e-5] * 3, "a repeat count stays one"
    assert ball["position"] == [0, 0, 0.011]
    assert ball["angle"] == [pytest.approx(np.pi / 6, rel=1e-15)]
    assert ball["velocity"] == [0.005, -0.01, 2.02]


def test_constants_may_follow_and_be_set(expand):
    found = expand(BALL + CONSTANTS, "constants.r=0.02", "ball.mass=3*m", "ball.angle=-90 deg")
    ball = group(found, "body")
    assert ball["mass"] == [pytest.approx(24 * MASS, rel=1e-14)]
    assert ball["angle"] == [pytest.approx(-np.pi / 2, rel=1e-15)]
    assert group(found, "surface", "skin")["radius"] == [0.02]
    assert group(found, "constants")["r"] == [0.02]


def test_the_result_keeps_the_text_and_the_values(simulate, tmp_path):
    simulate(CONSTANTS + BALL)
    with h5py.File(tmp_path / "out.h5") as file:
        assert file["/input/namelist"].asstr()[()] == CONSTANTS + BALL
        resolved = file["/input/resolved"].asstr()[()]
    assert "mass = 0.0657" in resolved
    assert "m = 0.0328" in resolved


def test_degrees_need_no_quotes(expand):
    text = CONSTANTS + BALL.replace("'30 deg'", "-30 deg").replace("r/2 -r", "180 DEG - 90 deg, 1")
    found = expand(text, "ball.spin=1, 0, 30 deg")
    assert group(found, "body")["angle"] == [pytest.approx(-np.pi / 6, rel=1e-15)]
    assert group(found, "body")["velocity"] == [pytest.approx(np.pi / 2), 1, 2.02]
    assert group(found, "body")["spin"] == pytest.approx([1, 0, np.pi / 6])


def test_texts_that_look_like_differences_stay_texts(expand):
    found = expand(CONSTANTS + BALL, "scene.title=run-2", "output.file=m")
    assert group(found, "scene")["title"] == ["run-2"]
    assert group(found, "output")["file"] == ["m"]
    assert group(expand(BALL + CONSTANTS, "scene.title=a - 2 b"), "scene")["title"] == ["a - 2 b"]


def test_numbers_keep_their_bits(expand):
    plain = BALL.replace("2*m", "0.1").replace("'30 deg'", "0.5").replace("r + 0.001", "0.011")
    plain = plain.replace("r/2 -r (r + 1)*2", "1.5-3, 2*0.1").replace("= r,", "= 1.0d-2,")
    assert group(expand(plain), "body")["velocity"] == [1.5e-3, 0.1, 0.1]


WRONG = {
    "mass = 2*q": ("there is no constant 'q'", "one of r, m, tilt, pi, deg"),
    "mass = 2*tild": ("there is no constant 'tild'", "tilt"),
    "mass = m/(r-r)": ("division by zero", "a divisor other than zero"),
    "mass = 1e300*1e300": ("too large for double precision", "1.8e308"),
    "mass = sqrt(-r)": ("'sqrt' is not defined for -0.01", "an argument >= 0"),
    "mass = 2*(m": ("')' is missing", "as many ')' as '('"),
    "mass = '2*(m'": ("')' is missing", "as many ')' as '('"),
    "mass = -m": ("'mass' is out of range", "> 0.0"),
    "mass = 'heavy'": ("needs a number, this is a text", "> 0.0"),
    "mass = '1.0'": ("needs a number, this is a text", "> 0.0"),
    "mass = heavy": ("text 'heavy' needs quotes", "'heavy'"),
    "mass = m, motion = 2*m": ("needs a text in quotes, this is a number", "free"),
}


@pytest.mark.parametrize("words", WRONG)
def test_mistakes_in_expressions(run, tmp_path, mistakes, words):
    path = tmp_path / "scene.nml"
    path.write_text(CONSTANTS + BALL.replace("mass = 2*m", words))
    result = run("run", path)
    assert result.status == 2
    assert not (tmp_path / "scene.h5").exists()
    first = mistakes(result.err)[0]
    assert first.line == 4
    assert WRONG[words][0] in first.message
    assert WRONG[words][1] in first.expected


BAD_CONSTANTS = {
    "a = b, b = 2*c, c = a": "constant 'a' depends on itself: a -> b -> c -> a",
    "a = a": "constant 'a' depends on itself: a -> a",
    "pi = 3": "'pi' cannot be the name of a constant",
    "sqrt = 3": "'sqrt' cannot be the name of a constant",
    "a = 2*3": "constant 'a' has 2 values",
    "a = 2-1": "2-1 is a number with an exponent in a namelist: 0.2",
    "a = .true.": "constant 'a' needs a number, this is a logical",
    "a = inf": "constant 'a' must be finite",
    "a(2) = 1": "constant 'a' has a subscript",
    "a =": "constant 'a' has no value",
    "a = 1, a = 2": "constant 'a' given twice",
    "a = x": "there is no constant 'x'",
}


@pytest.mark.parametrize("words", BAD_CONSTANTS)
def test_mistakes_in_constants(run, tmp_path, mistakes, words):
    path = tmp_path / "scene.nml"
    path.write_text(CONSTANTS + BALL + f"&constants {words} /\n")
    result = run("check", path)
    assert result.status == 2
    (only,) = mistakes(result.err)
    assert only.line == 9
    assert BAD_CONSTANTS[words] in only.message


def test_a_constant_that_is_not_there_is_not_set(run, tmp_path):
    path = tmp_path / "scene.nml"
    path.write_text(CONSTANTS + BALL)
    result = run("check", path, "--set", "constants.tilts=1")
    assert result.status == 2
    assert "expected: constants.tilt" in result.err


def test_a_sweep_varies_a_constant(run, tmp_path):
    (tmp_path / "scene.nml").write_text(CONSTANTS + BALL)
    (tmp_path / "sweep.nml").write_text(
        "&constants a = 10*deg /\n&sweep scene = 'scene.nml', keep = 'final_state' /\n"
        "&parameter name = 'constants.r', values = 0.01, '1/50' /\n"
        "&parameter name = 'ball.angle', first = a, last = '30 deg', count = 2 /\n"
    )
    result = run("sweep", tmp_path / "sweep.nml", "-j", "1")
    assert result.status == 0, result.err
    with h5py.File(tmp_path / "sweep.h5") as file:
        assert list(file["parameters/constants.r"]) == [0.01, 0.01, 0.02, 0.02]
        assert file["parameters/ball.angle"][:2] == pytest.approx([np.pi / 18, np.pi / 6])
        # They start at r + 1 mm, upwards, with 2 (r + 1) m/s.
        z = file["results/position_ball_z"][:]
    assert z[0] == pytest.approx(0.011 + 0.0202 - 4.905e-4, rel=1e-6)
    assert z[2] == pytest.approx(0.021 + 0.0204 - 4.905e-4, rel=1e-6)


def test_a_table_of_cases_has_expressions(run, tmp_path, mistakes):
    (tmp_path / "scene.nml").write_text(CONSTANTS + BALL)
    (tmp_path / "sweep.nml").write_text(
        "&constants small = 1/100 /\n"
        "&sweep scene = 'scene.nml', keep = 'steps', sampling = 'file', table = 'cases.csv' /\n"
    )
    table = tmp_path / "cases.csv"
    table.write_text("constants.r,ball.angle\nsmall,30 deg\n'2*small',90*deg\n0.03,\"-10 deg\"\n")
    result = run("sweep", tmp_path / "sweep.nml", "-j", "1")
    assert result.status == 0, result.err
    with h5py.File(tmp_path / "sweep.h5") as file:
        assert list(file["parameters/constants.r"]) == [0.01, 0.02, 0.03]
        angles = file["parameters/ball.angle"][:]
    assert angles == pytest.approx(np.radians([30, 90, -10]), rel=1e-15)
    table.write_text("constants.r,ball.angle\nsmal,30 deg\n0.02,1/0\n0.03,'2*x'\n0.03,abc\n")
    result = run("sweep", tmp_path / "sweep.nml", "--force")
    assert result.status == 2
    found = [(m.line, m.message) for m in mistakes(result.err)]
    assert [line for line, _ in found] == [2, 3, 4, 5]
    assert "division by zero" in found[1][1]
    assert "there is no constant 'x'" in found[2][1]
