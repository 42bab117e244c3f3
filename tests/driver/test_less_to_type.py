"""What a scene need not say by itself: expressions and constants."""

from __future__ import annotations

import re
from pathlib import Path

import h5py
import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]

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
    "mass = tild": ("text 'tild' needs quotes", "'tild', or the constant tilt"),
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


STEEL = """\
&scene t_end = 1e-3, gravity = 0, 0, -9.81 /
&material name = 'steel', young = 2.1e11, poisson = 0.3 /
&body name = 'top', density = 7850, position = 0.1, 0.2, 3 {body} /
&surface name = 'skin', body = 'top', material = 'steel', {skin} /
&surface name = 'floor', body = 'ground', shape = 'sphere', radius = 1, centre = 9, 0, 0,
   material = 'steel' /
&contact name = 'c', surfaces = 'skin', 'floor' /
"""

# Shape, what the body says more, cross sections: half axes along x and y, holes and heights.
SOLIDS = {
    "sphere": (
        "shape = 'sphere', radius = 0.02, centre = 0, 0, 0.01",
        "",
        lambda z: (0.02**2 - z**2, 0.02**2 - z**2, 0 * z, -0.02, 0.02),
    ),
    "ellipsoid": (
        "shape = 'ellipsoid', semi_axes = 0.02, 0.03, 0.05",
        "",
        lambda z: (
            0.02**2 * (1 - z**2 / 0.05**2),
            0.03**2 * (1 - z**2 / 0.05**2),
            0 * z,
            -0.05,
            0.05,
        ),
    ),
    "torus": (
        "shape = 'torus', major_radius = 0.05, minor_radius = 0.02",
        "",
        lambda z: (
            (0.05 + np.sqrt(0.02**2 - z**2)) ** 2,
            (0.05 + np.sqrt(0.02**2 - z**2)) ** 2,
            (0.05 - np.sqrt(0.02**2 - z**2)) ** 2,
            -0.02,
            0.02,
        ),
    ),
    "cylinder": (
        "shape = 'cylinder', radius = 0.02",
        ", solid_length = 0.1",
        lambda z: (0.02**2 + 0 * z, 0.02**2 + 0 * z, 0 * z, -0.05, 0.05),
    ),
    "cone": (
        "shape = 'cone', half_angle = 30 deg, direction = 0, 0, 1",
        ", solid_length = 0.1",
        lambda z: (z**2 / 3, z**2 / 3, 0 * z, 0.0, 0.1),
    ),
    "paraboloid": (
        "shape = 'paraboloid', vertex_radius = 0.03, direction = 0, 0, 1",
        ", solid_length = 0.1",
        lambda z: (0.06 * z, 0.06 * z, 0 * z, 0.0, 0.1),
    ),
    "lower half": (
        "shape = 'ellipsoid', semi_axes = 0.02, 0.03, 0.05",
        ", solid_part = 'lower_half'",
        lambda z: (
            0.02**2 * (1 - z**2 / 0.05**2),
            0.03**2 * (1 - z**2 / 0.05**2),
            0 * z,
            -0.05,
            0.0,
        ),
    ),
    "upper half": (
        "shape = 'sphere', radius = 0.05",
        ", solid_part = 'upper_half'",
        lambda z: (0.05**2 - z**2, 0.05**2 - z**2, 0 * z, 0.0, 0.05),
    ),
}


@pytest.mark.parametrize("solid", SOLIDS)
def test_density_gives_what_sections_add_up_to(expand, solid):
    skin, body, sections = SOLIDS[solid]
    found = expand(STEEL.format(skin=skin, body=body))
    *_, low, high = sections(np.array(0.0))
    # Gauss-Legendre in an angle: the ends of the sections are round.
    nodes, weights = np.polynomial.legendre.leggauss(60)
    angle = (nodes + 1) * np.pi / 2
    z = low + (high - low) * (1 - np.cos(angle)) / 2
    weights = weights * np.pi / 2 * (high - low) / 2 * np.sin(angle)
    a2, b2, hole2, *_ = sections(z)
    area = np.pi * (np.sqrt(a2 * b2) - hole2)
    volume = weights @ area
    centre = weights @ (area * z) / volume
    # Second moments of an ellipse and of its round hole.
    xx = weights @ (np.pi / 4 * (np.sqrt(a2 * b2) * a2 - hole2**2))
    yy = weights @ (np.pi / 4 * (np.sqrt(a2 * b2) * b2 - hole2**2))
    zz = weights @ (area * (z - centre) ** 2)
    top = group(found, "body")
    assert top["mass"] == [pytest.approx(7850 * volume, rel=1e-9)]
    inertia = 7850 * np.array([yy + zz, xx + zz, xx + yy])
    assert top["inertia"] == pytest.approx(inertia, rel=1e-9)
    assert top["position"] == [0.1, 0.2, 3]
    # The centre of mass is the origin of what the surfaces are given in.
    assert group(found, "surface", "skin")["centre"] == pytest.approx([0, 0, -centre], abs=1e-16)
    assert "density" not in top


def test_a_solid_carries_the_other_surfaces_along(expand):
    text = STEEL.format(
        skin="shape = 'sphere', radius = 0.05, centre = 0, 0, 1", body=", solid = 'skin'"
    )
    text = text.replace(
        "&contact",
        "&surface name = 'peg', body = 'top', shape = 'sphere', "
        "material = 'steel', radius = 0.01, centre = 0, 0.02, 1.1 /\n&contact",
    )
    found = expand(text)
    assert group(found, "surface", "skin")["centre"] == [0, 0, 0]
    assert group(found, "surface", "peg")["centre"] == pytest.approx([0, 0.02, 0.1], rel=1e-14)


def test_a_solid_on_its_side_has_its_inertia_there(expand):
    skin = "shape = 'cylinder', radius = 0.02, direction = 1, 0, 0"
    lying = group(expand(STEEL.format(skin=skin, body=", solid_length = 0.1")), "body")["inertia"]
    mass = 7850 * np.pi * 0.02**2 * 0.1
    assert lying[0] == pytest.approx(mass * 0.02**2 / 2, rel=1e-14)
    assert lying[1:] == pytest.approx([mass * (0.02**2 / 4 + 0.1**2 / 12)] * 2, rel=1e-14)


def test_radii_of_gyration(expand):
    body = ", mass = 2, radius_of_gyration = {}"
    text = STEEL.format(skin="shape = 'sphere', radius = 0.02", body="").replace(
        " density = 7850,", ""
    )
    for given, inertia in (("0.1", [0.02] * 3), ("0.1, 0.1, 0.2", [0.02, 0.02, 0.08])):
        found = expand(text.replace("0.2, 3 ", "0.2, 3" + body.format(given)))
        assert group(found, "body")["inertia"] == pytest.approx(inertia, rel=1e-15)
    solid = expand(text.replace("0.2, 3 ", "0.2, 3, mass = 2, solid = 'skin'"))
    assert group(solid, "body")["inertia"] == pytest.approx([2 * 0.4 * 0.02**2] * 3, rel=1e-15)


def test_what_a_solid_leaves_out_gives_the_same_run(simulate, tmp_path):
    """A run from the settings of a result is the same run, bit for bit."""
    text = (
        STEEL.replace("'sphere', radius = 1, centre = 9, 0, 0", "'plane'")
        .format(
            skin="shape = 'sphere', radius = 0.05, centre = 0, 0, 0.01",
            body=", solid_part = 'lower_half'",
        )
        .replace("0.2, 3", "0.2, 0.031, spin = 3, 2, 1")
    )
    simulate(text)
    (tmp_path / "out.h5").rename(tmp_path / "first.h5")
    with h5py.File(tmp_path / "first.h5") as file:
        simulate(file["/input/resolved"].asstr()[()])
    with h5py.File(tmp_path / "first.h5") as one, h5py.File(tmp_path / "out.h5") as other:
        assert one["/input/resolved"][()] == other["/input/resolved"][()]
        assert len(one["/trajectory/time"]) > 100
        for name, values in one["/trajectory"].items():
            if values.dtype == object:
                continue
            assert values[()].tobytes() == other["/trajectory"][name][()].tobytes(), name


WRONG_SOLIDS = {
    "mass = 1": "the mass is given twice",
    "inertia = 3*1": "the inertia is given twice",
    "radius_of_gyration = 1": "'density' beside 'radius_of_gyration'",
    "solid = 'floor'": "surface 'floor' is not on body 'top'",
    "solid = 'skim'": "there is no surface 'skim'",
    "solid_length = 1": "has a length of its own",
    "solid_part = 'half'": "expected",
}


@pytest.mark.parametrize("words", WRONG_SOLIDS)
def test_mistakes_in_solids(run, tmp_path, mistakes, words):
    path = tmp_path / "scene.nml"
    path.write_text(STEEL.format(skin="shape = 'sphere', radius = 0.02", body=", " + words))
    result = run("run", path)
    assert result.status == 2
    assert not (tmp_path / "scene.h5").exists()
    assert [m.line for m in mistakes(result.err)] == [3]
    assert WRONG_SOLIDS[words] in result.err


BOUNDLESS = {
    "shape = 'plane'": "a plane bounds no solid",
    "shape = 'cylinder', radius = 0.1": "has no ends",
    "shape = 'sphere', radius = 0.1, side = 'inside'": "the inside of a sphere bounds no solid",
    "shape = 'sphere', radius = 1e-30": "follow",
    "shape = 'cylinder', radius = 0.1, direction = 1, 0, 1": "has no ends",
}


@pytest.mark.parametrize("skin", BOUNDLESS)
def test_surfaces_that_bound_no_solid(run, tmp_path, mistakes, skin):
    path = tmp_path / "scene.nml"
    path.write_text(STEEL.format(skin=skin, body=""))
    result = run("check", path)
    assert result.status == 2
    assert [m.line for m in mistakes(result.err)] == [3]
    assert BOUNDLESS[skin] in result.err


def test_axes_of_a_solid_are_those_of_its_body(run, tmp_path):
    path = tmp_path / "scene.nml"
    skin = "shape = 'cylinder', radius = 0.1, direction = 1, 0, 1"
    path.write_text(STEEL.format(skin=skin, body=", solid_length = 1"))
    result = run("check", path)
    assert result.status == 2
    assert "products of inertia are not zero" in result.err


PAIR = """\
&defaults shape = 'sphere', radius = 0.02, material = 'steel', damping = 'tsuji',
   restitution = 0.9, friction = 'pade22', friction_coefficient = 0.3, normal = 'hertz' {more} /
&scene t_end = 0.01 /
&material name = 'steel', young = 2.1e11, poisson = 0.3 /
&body name = 'a', mass = 1, inertia = 3*1 /
&body name = 'b', mass = 1, inertia = 3*1, position = 1, 0, 0 /
&surface name = 'a', body = 'a' /
&surface name = 'b', body = 'b', radius = 0.01 /
&surface name = 'floor', body = 'ground', shape = 'plane', centre = 0, 0, -2 /
&contact name = 'ab', surfaces = 'a', 'b' /
&contact name = 'af', surfaces = 'a', 'floor', friction_coefficient = 0.1, damping = 'none' /
"""


def test_defaults_go_where_they_have_a_use(expand):
    found = expand(PAIR.format(more=""))
    assert [group(found, "surface", name).get("radius") for name in ("a", "b", "floor")] == [
        [0.02],
        [0.01],
        None,
    ]
    assert all(group(found, "surface", name)["material"] == ["steel"] for name in ("a", "floor"))
    assert "defaults" not in [name for name, _ in found]
    ab, af = (group(found, "contact", name) for name in ("ab", "af"))
    assert (ab["friction"], ab["friction_coefficient"]) == (["pade22"], [0.3])
    assert (ab["damping"], ab["restitution"]) == (["tsuji"], [0.9])
    assert (af["friction"], af["friction_coefficient"]) == (["pade22"], [0.1])
    assert af["damping"] == ["none"]
    assert "restitution" not in af


def test_defaults_and_what_is_set(expand):
    # Constants before all else leave the groups in their places.
    constants = "&constants q = 1 /\n"
    found = expand(constants + PAIR.format(more=""), "scene.t_end=0.5")
    assert group(found, "scene")["t_end"] == [0.5]
    found = expand(
        PAIR.format(more=""),
        "defaults.friction_coefficient=0.2",
        "ab.friction=none",
        "af.damping=tsuji",
    )
    ab, af = (group(found, "contact", name) for name in ("ab", "af"))
    assert ab["friction"] == ["none"]
    assert "friction_coefficient" not in ab
    assert (af["friction_coefficient"], af["restitution"]) == ([0.1], [0.9])
    assert group(
        expand(
            PAIR.format(more=""), "contact.friction=coulomb", "contact.regularization_velocity=1e-3"
        ),
        "contact",
        "ab",
    )["friction"] == ["coulomb"]


def test_defaults_that_are_set_only(expand, run, tmp_path):
    text = (ROOT / "inputs" / "sliding_ball.nml").read_text()
    assert "&defaults" not in text
    found = expand(text, "defaults.tangential=elastic", "defaults.layers=7")
    contact = group(found, "contact")
    assert (contact["tangential"], contact["layers"]) == (["elastic"], [7])
    said = run("check", tmp_path / "scene.nml", "--set", "defaults.half_angle=1")
    assert said.status == 2
    assert "no surface or contact takes 'half_angle'" in said.err
    (tmp_path / "sweep.nml").write_text(
        "&sweep scene = 'scene.nml', set = 'scene.t_end=0.001', keep = 'steps' /\n"
        "&parameter name = 'defaults.tangential', values = 'none', 'elastic' /\n"
    )
    result = run("sweep", tmp_path / "sweep.nml", "-j", "1")
    assert result.status == 0, result.err
    with h5py.File(tmp_path / "sweep.h5") as file:
        none, elastic = file["results/steps"]
    assert elastic > none


def test_defaults_of_what_is_turned_off(expand, run, tmp_path):
    text = PAIR.format(more=", tangential = 'elastic', layers = 8")
    ab = group(expand(text, "defaults.tangential=none"), "contact", "ab")
    assert ab["tangential"] == ["none"]
    # Not where nothing is named, as in a contact.
    (tmp_path / "scene.nml").write_text(PAIR.format(more=", layers = 8"))
    said = run("check", tmp_path / "scene.nml")
    assert said.status == 2
    assert "no surface or contact takes 'layers'" in said.err


def test_a_key_takes_the_place_of_a_default(expand):
    text = PAIR.format(more="").replace("'a', 'b' /", "'a', 'b', damping_coefficient = 0.1 /")
    ab = group(expand(text), "contact", "ab")
    assert ab["damping_coefficient"] == [0.1]
    assert "restitution" not in ab


def test_a_sweep_varies_a_default(run, tmp_path):
    (tmp_path / "scene.nml").write_text(PAIR.format(more=""))
    (tmp_path / "sweep.nml").write_text(
        "&sweep scene = 'scene.nml', keep = 'steps', trajectories = 1, 2 /\n"
        "&parameter name = 'defaults.radius', values = 0.01, 0.03 /\n"
    )
    result = run("sweep", tmp_path / "sweep.nml", "-j", "1")
    assert result.status == 0, result.err
    with h5py.File(tmp_path / "sweep.h5") as file:
        assert list(file["status"]) == [0, 0]
    for case, radius in (("1", "0.01"), ("2", "0.03")):
        (name,) = tmp_path.glob(f"sweep*{case}.h5")
        with h5py.File(name) as file:
            assert f"radius = {radius}" in file["/input/resolved"].asstr()[()]


WRONG_DEFAULTS = {
    ", rolling_coefficient = 1e-3": "no surface or contact takes 'rolling_coefficient'",
    ", half_angle = 0.1": "no surface or contact takes 'half_angle'",
    ", fricton = 'none'": "unknown key 'fricton' in group &defaults",
    ", rolling = 'sticky'": "'sticky'",
    ", centre = 0, 0, 1": "unknown key 'centre' in group &defaults",
}


@pytest.mark.parametrize("more", WRONG_DEFAULTS)
def test_mistakes_in_defaults(run, tmp_path, mistakes, more):
    path = tmp_path / "scene.nml"
    path.write_text(PAIR.format(more=more))
    result = run("check", path)
    assert result.status == 2
    (only,) = mistakes(result.err)
    assert only.line == 2
    assert WRONG_DEFAULTS[more] in only.message


MANY = """\
&constants r = 0.01 /
&scene t_end = 1e-4 /
&material name = 'steel', young = 2.1e11, poisson = 0.3 /
&body name = 'ball', mass = 1, inertia = 3*1, position = 1, 2, 3, {count} /
&surface name = 'skin', body = 'ball', shape = 'sphere', radius = r, material = 'steel' /
&surface name = 'floor', body = 'ground', shape = 'plane', centre = 0, 0, -9, material = 'steel' /
&contacts surfaces = 'skin*', 'floor' /
"""

PLACES = {
    "count = 3, spacing = 0.1": [[0, 0, 0], [0.1, 0, 0], [0.2, 0, 0]],
    "count = 2, spacing = 0, 0.1, 0.2": [[0, 0, 0], [0, 0.1, 0.2]],
    "count = 2, 2, spacing = 0.1, 0.2": [[0, 0, 0], [0.1, 0, 0], [0, 0.2, 0], [0.1, 0.2, 0]],
    "count = 1, 1, 2, spacing = 3*0.1": [[0, 0, 0], [0, 0, 0.1]],
    "count = 4, ring_radius = 10*r": [[0.1, 0, 0], [0, 0.1, 0], [-0.1, 0, 0], [0, -0.1, 0]],
    "count = 2, arrangement = 'ring', spacing = 0.2": [[0.1, 0, 0], [-0.1, 0, 0]],
    "count = 2, arrangement = 'triangle', spacing = 0.2": [
        [0, 0, 0],
        [0.1 * 3**0.5, -0.1, 0],
        [0.1 * 3**0.5, 0.1, 0],
    ],
    "count = 1": [[0, 0, 0]],
}


@pytest.mark.parametrize("count", PLACES)
def test_rows_grids_rings_and_triangles(expand, count):
    found = expand(MANY.format(count=count))
    bodies = [keys for kind, keys in found if kind == "body"]
    assert [body["name"] for body in bodies] == [[f"ball_{i + 1}"] for i in range(len(bodies))]
    places = [body["position"] for body in bodies]
    assert np.array(places) == pytest.approx(np.array([1, 2, 3]) + PLACES[count], abs=1e-15)
    skins = [keys for kind, keys in found if kind == "surface"][:-1]
    assert [(skin["name"], skin["body"]) for skin in skins] == [
        ([f"skin_{i + 1}"], [f"ball_{i + 1}"]) for i in range(len(bodies))
    ]
    contacts = [keys for kind, keys in found if kind == "contact"]
    assert [contact["name"] for contact in contacts] == [
        [f"skin_{i + 1}_floor"] for i in range(len(bodies))
    ]


def test_what_is_set_for_bodies_with_a_count(expand):
    found = expand(
        MANY.format(count="count = 3, spacing = 0.1"),
        "ball.count=2",
        "ball.mass=5",
        "ball_2.mass=7",
        "skin.radius=0.02",
        "skin_1.radius=0.03",
        "contacts.damping=tsuji",
        "contact.restitution=0.5",
        "skin_1_floor.restitution=0.6",
    )
    assert [keys["mass"] for kind, keys in found if kind == "body"] == [[5], [7]]
    assert group(found, "surface", "skin_1")["radius"] == [0.03]
    assert group(found, "surface", "skin_2")["radius"] == [0.02]
    assert [keys["restitution"] for kind, keys in found if kind == "contact"] == [[0.6], [0.5]]


def test_a_count_may_be_set_where_none_is_written(expand):
    text = MANY.format(count="angle = 0, axis = 0, 0, 1")
    found = expand(text, "ball.count=2", "ball.spacing=0.5")
    assert len([1 for kind, _ in found if kind == "body"]) == 2


PAIRS = {
    "surfaces = 'skin*', '*'": "1_2 1_3 1_floor 2_3 2_floor 3_floor",
    "surfaces = 'skin_?', 'skin_2'": "1_2 3_2",
    "surfaces = 'floor', 'SKIN_1'": "floor_1",
    "first = 'skin_1', 'skin_2', second = 'floor', 'skin_3'": "1_3 1_floor 2_3 2_floor",
    "name = 'c', first = 'skin_1', second = 'floor', friction = 'none'": "c_1_floor",
}


@pytest.mark.parametrize("words", PAIRS)
def test_contacts_of_pairs(expand, words):
    text = MANY.format(count="count = 3, spacing = 0.1").replace(
        "surfaces = 'skin*', 'floor'", words
    )
    names = [keys["name"][0] for kind, keys in expand(text) if kind == "contact"]
    assert [name.replace("skin_", "") for name in names] == PAIRS[words].split()


def test_a_pair_with_a_contact_of_its_own(expand):
    text = MANY.format(count="count = 2, spacing = 0.1").replace("'floor' /\n", "'*' /\n")
    text += "&contact name = 'own', surfaces = 'floor', 'skin_2', friction = 'none' /\n"
    names = [keys["name"][0] for kind, keys in expand(text) if kind == "contact"]
    assert names == ["skin_1_skin_2", "skin_1_floor", "own"]


def test_a_sweep_varies_what_many_bodies_share(run, tmp_path):
    (tmp_path / "scene.nml").write_text(MANY.format(count="count = 2, spacing = 10*r"))
    (tmp_path / "sweep.nml").write_text(
        "&sweep scene = 'scene.nml', keep = 'position' /\n"
        "&parameter name = 'constants.r', values = 0.01, 0.02 /\n"
    )
    result = run("sweep", tmp_path / "sweep.nml", "-j", "1")
    assert result.status == 0, result.err
    with h5py.File(tmp_path / "sweep.h5") as file:
        assert file["results/position_ball_2_x"][:] == pytest.approx([1.1, 1.2])
    (tmp_path / "sweep.nml").write_text(
        "&sweep scene = 'scene.nml' /\n&parameter name = 'ball.count', values = 2, 3 /\n"
    )
    result = run("sweep", tmp_path / "sweep.nml")
    assert result.status == 2
    assert "'ball.count' cannot vary: it changes which bodies there are" in result.err


WRONG_MANY = {
    "count = 3": "'count' needs 'spacing'",
    "count = 0, spacing = 1": "'count'",
    "count = 2.5, spacing = 1": "'count'",
    "count = 3, spacing = 0": "'spacing' is not what 'row' needs",
    "count = 2, 2, spacing = 1": "'spacing' is not what 'grid' needs",
    "count = 3, arrangement = 'ring'": "a ring needs its radius",
    "count = 3, arrangement = 'ring', spacing = 1, ring_radius = 1": "given twice",
    "count = 3, spacing = 1, arrangement = 'heap'": "'heap'",
    "count = 2, 2, arrangement = 'ring', spacing = 1": "'count' has one value",
    "count = 3, spacing = 1, ring_radius = 1, arrangement = 'row'": "'ring_radius' has no meaning",
    "count = 100000, 100000, spacing = 1, 1": "bodies",
    "spacing = 1": "'spacing' without 'count'",
    "arrangement = 'ring'": "'arrangement' without 'count'",
}


@pytest.mark.parametrize("count", WRONG_MANY)
def test_mistakes_in_counts(run, tmp_path, mistakes, count):
    path = tmp_path / "scene.nml"
    path.write_text(MANY.format(count=count))
    result = run("check", path)
    assert result.status == 2
    (only,) = mistakes(result.err)
    assert only.line == 4
    assert WRONG_MANY[count] in only.message


WRONG_PAIRS = {
    "surfaces = 'skin*', 'flor'": "there is no surface 'flor'",
    "surfaces = 'skin*', 'wall*'": "no surface matches 'wall*'",
    "surfaces = 'floor', 'floor'": "stands for no contact",
    "name = 'x'": "'surfaces' is missing",
    "first = 'skin*'": "'second' is missing",
    "surfaces = 'skin*', 'floor', first = 'skin*'": "the surfaces are given twice",
    "surfaces = 'skin*', 'floor', normal = 'hart'": "unknown normal 'hart'",
    "surfaces = 'skin*', 'floor', fricton = 'none'": "unknown key 'fricton'",
}


@pytest.mark.parametrize("words", WRONG_PAIRS)
def test_mistakes_in_pairs(run, tmp_path, mistakes, words):
    text = MANY.format(count="count = 3, spacing = 0.1").replace(
        "surfaces = 'skin*', 'floor'", words
    )
    path = tmp_path / "scene.nml"
    path.write_text(text)
    result = run("check", path)
    assert result.status == 2
    (only,) = mistakes(result.err)
    assert only.line == 7
    assert WRONG_PAIRS[words] in only.message


PUT_DOWN = """\
&constants r = 0.01 /
&scene t_end = 2e-3, gravity = {gravity} /
&material name = 'steel', young = 2.1e11, poisson = 0.3 /
&defaults material = 'steel' /
&body name = 'egg', density = 7850, position = 0.3, 0, 0.2, axis = 1, 0, 0, angle = 20 deg {egg} /
&body name = 'low', density = 7850, position = 0.003, 0, 0.05 {low} /
&body name = 'high', density = 7850, position = 0.003, 0, 0.2 {high} /
&surface name = 'low', body = 'low', shape = 'sphere', radius = r /
&surface name = 'high', body = 'high', shape = 'sphere', radius = r /
&surface name = 'egg', body = 'egg', shape = 'ellipsoid', semi_axes = 0.01, 0.02, 0.03 /
&surface name = 'floor', body = 'ground', shape = 'plane' /
&contacts surfaces = '*', '*' /
"""
DOWN = "0, 0, -9.81"


def test_bodies_are_put_down_until_they_touch(expand):
    touch = ", place = 'touch'"
    found = expand(PUT_DOWN.format(gravity=DOWN, egg=touch, low=touch, high=touch))
    tilt = np.radians(20)
    height = np.hypot(0.02 * np.sin(tilt), 0.03 * np.cos(tilt))
    assert group(found, "body", "egg")["position"] == [0.3, 0, pytest.approx(height, abs=1e-17)]
    assert group(found, "body", "low")["position"][2] == pytest.approx(0.01, abs=4e-18)
    # Rounded where it came from.
    assert group(found, "body", "high")["position"][2] == pytest.approx(0.03, abs=np.spacing(0.2))
    assert "place" not in group(found, "body", "low")


def test_a_body_is_put_down_between_two_others(expand):
    """In the gap of two balls, and along a gravity that is not that of z."""
    text = (
        PUT_DOWN.format(
            gravity="-9.81, 0, 0", egg="", low=", motion = 'fixed'", high=", place = 'touch'"
        )
        .replace("0.003, 0, 0.05", "0, 0.008, 0")
        .replace("0.003, 0, 0.2", "0.2, 0, 0")
    )
    text = text.replace("'plane' /", "'sphere', radius = r, centre = 0, -0.008, 0 /")
    found = expand(text)
    height = np.sqrt(0.02**2 - 0.008**2)
    assert group(found, "body", "high")["position"] == [pytest.approx(height, abs=1e-17), 0, 0]


def test_a_body_at_rest_is_carried_by_hertz(simulate, tmp_path):
    rest = ", place = 'rest'"
    simulate(PUT_DOWN.format(gravity=DOWN, egg="", low=rest, high=rest))
    mass = 7850 * 4 / 3 * np.pi * 0.01**3
    modulus = 2.1e11 / 2 / (1 - 0.3**2)
    floor = (2 * mass * 9.81 / (4 / 3 * modulus * np.sqrt(0.01))) ** (2 / 3)
    balls = (mass * 9.81 / (4 / 3 * modulus * np.sqrt(0.005))) ** (2 / 3)
    with h5py.File(tmp_path / "out.h5") as file:
        z = file["/trajectory/position"][:, :, 2]
        v = file["/trajectory/velocity"][:, :, 2]
        names = list(file["/body/name"].asstr())
    low, high = names.index("low"), names.index("high")
    assert z[0, low] == pytest.approx(0.01 - floor, abs=1e-17)
    assert z[0, high] == pytest.approx(0.03 - floor - balls, abs=1e-16)
    # They stay: a free fall would have 0.02 m/s by now.
    assert np.abs(v[:, [low, high]]).max() < 1e-8


@pytest.mark.parametrize(
    ("load", "newtons"), [("torque = 1e-3, 2e-3, 3e-3", 0.0), ("force = 0, 0, -1.0", 1.0)]
)
def test_what_normal_forces_carry_at_rest(expand, load, newtons):
    """A force along gravity beside the weight; a torque is none of theirs."""
    low = f", place = 'rest', applied_{load}"
    found = expand(PUT_DOWN.format(gravity=DOWN, egg="", low=low, high=""))
    force = 7850 * 4 / 3 * np.pi * 0.01**3 * 9.81 + newtons
    modulus = 2.1e11 / 2 / (1 - 0.3**2)
    depth = (force / (4 / 3 * modulus * np.sqrt(0.01))) ** (2 / 3)
    assert group(found, "body", "low")["position"][2] == pytest.approx(0.01 - depth, abs=1e-17)


WRONG_PLACES = {
    ("0, 0, 0", ", place = 'rest'"): "'place' has no meaning without gravity",
    (DOWN, ", place = 'rest', motion = 'fixed'"): "is not carried",
    (DOWN, ", place = 'lie'"): "'lie'",
    ("9.81, 0, 0", ", place = 'touch'"): "cannot be put down",
}


@pytest.mark.parametrize("case", WRONG_PLACES)
def test_mistakes_in_places(run, tmp_path, mistakes, case):
    path = tmp_path / "scene.nml"
    path.write_text(PUT_DOWN.format(gravity=case[0], egg="", low=case[1], high=""))
    result = run("check", path)
    assert result.status == 2
    (only,) = mistakes(result.err)
    assert only.line == 6
    assert WRONG_PLACES[case] in only.message


def test_what_pushes_aside_carries_nothing(run, tmp_path):
    rest = ", place = 'rest'"
    text = PUT_DOWN.format(gravity=DOWN, egg="", low=rest, high=rest)
    path = tmp_path / "scene.nml"
    path.write_text(text.replace("0.003, 0, 0.2", "0.004, 0, 0.2"))
    result = run("check", path)
    assert result.status == 2
    assert "the forces on it push it aside with" in result.err


def test_the_break_shot(simulate, tmp_path):
    scene = ROOT / "inputs" / "examples" / "break_shot.nml"
    text = scene.read_text()
    assert len([line for line in text.splitlines() if line and line[0] != "!"]) <= 24
    simulate(text, "scene.t_end=0.155", "output.interval=0.005")
    with h5py.File(tmp_path / "out.h5") as file:
        assert len(file["/body/name"]) == 16
        assert file["/contact/name"].shape == (16 * 15 // 2 + 16 * 5,)
        velocity = file["/trajectory/velocity"][-1]
        position = file["/trajectory/position"][:]
        assert abs(file["/summary/energy_error_relative"][()]) < 1e-5
    assert np.abs(position[:, :, 2] - 0.028575).max() < 2e-3
    # The cue ball has given most of its speed to the others, the pack begins to open.
    speeds = np.linalg.norm(velocity, axis=1)
    assert speeds[-1] < 3
    assert (speeds[:-1] > 0.05).sum() >= 8


def test_the_rack_of_the_readme(run, tmp_path):
    """What README shows of many bodies is in order, and stays where it was put."""
    page = (ROOT / "README.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```fortran\n(.*?)```", page, re.DOTALL)
    (tmp_path / "rack.nml").write_text(next(block for block in blocks if "&contacts" in block))
    result = run("run", "rack.nml", "--strict", "-q", "-o", "rack.h5")
    assert (result.status, result.err) == (0, "")
    with h5py.File(tmp_path / "rack.h5") as file:
        position = file["trajectory/position"][:]
        assert position.shape[1] == 15
        assert len(file["contact/name"]) == 15 * 14 // 2 + 15 * 2
    assert abs(position - position[0]).max() < 1e-9
