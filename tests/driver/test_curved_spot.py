"""The friction wrench of a curved spot by way of `contensou eval curved_wrench`.

`tests/reference/curved_spot.py` wrote its table, from the definition of the wrench.
"""

from __future__ import annotations

import csv
import importlib.util
import io

import numpy as np
import pytest

INPUTS = ["N", "a", "b", "f", "Lxx", "Lxy", "Lyy", "vx", "vy", "w", "wx", "wy"]
RULES = [("--model", "mapped"), ("--model", "slender"), ("--model", "product")]
OUTPUTS = ["Fx", "Fy", "Tz", "Mx", "My"]


@pytest.fixture
def evaluate(run):
    """Wrenches, and derivatives if they are asked for, of rows of numbers."""

    def evaluate_it(rows, *words, kernel="curved_wrench", inputs=INPUTS):
        text = "\n".join([",".join(inputs), *(",".join(map(repr, map(float, r))) for r in rows)])
        result = run("eval", kernel, *words, input=text + "\n")
        assert result.status == 0, result.err
        table = list(csv.reader(io.StringIO(result.out)))
        return np.array([[float(x) for x in row[len(inputs) :]] for row in table[1:]])

    return evaluate_it


@pytest.fixture(scope="module")
def cases(reference):
    """Rows of the table, as inputs for N = f = a = 1, and the wrenches of the definition."""
    with (reference / "curved_spot.csv").open(encoding="utf-8") as file:
        rows = [{name: float(x) for name, x in row.items()} for row in csv.DictReader(file)]
    assert len(rows) == 200
    inputs = np.array(
        [
            # q = w_t x n, and z = r.L r/2.
            [
                *(1, 1, r["k"], 1, 2 * r["h11"], 2 * r["h12"], 2 * r["h22"]),
                *(r["vx"], r["vy"], r["W"], -r["qy"], r["qx"]),
            ]
            for r in rows
        ]
    )
    results = np.array([[r["Fx"], r["Fy"], r["T"], -r["Gy"], r["Gx"]] for r in rows])
    return inputs, results


def power(rows, wrenches):
    """Power that is lost."""
    return -(wrenches[:, :5] * rows[:, 7:12]).sum(axis=1)


def test_definition(cases, evaluate):
    inputs, results = cases
    assert abs(evaluate(inputs) - results).max() <= 1e-10


@pytest.mark.parametrize("error", [1e-4, 1e-6, 1e-8])
def test_error_bound(cases, evaluate, error):
    inputs, results = cases
    deviations = abs(evaluate(inputs, "--error", str(error)) - results).max(axis=1)
    assert np.median(deviations) <= 0.01 * error
    assert deviations.max() <= error


@pytest.fixture(scope="module")
def spots(reference):
    """Rows as `cases` has them, of another 400 random spots and of 200 balls in grooves."""
    place = importlib.util.spec_from_file_location("spots", reference / "curved_spot.py")
    source = importlib.util.module_from_spec(place)
    place.loader.exec_module(source)
    random = np.random.default_rng(2)
    drawn = [source.draw(i, random) for i in range(400)]
    drawn += [source.draw_in_groove(i, random) for i in range(200)]
    return np.array(
        [[1, 1, k, 1, *(2 * h), *v, spin, -q[1], q[0]] for k, v, spin, h, q in drawn], dtype=float
    )


@pytest.mark.parametrize("error", [1e-10, 1e-8, 1e-6, 1e-4])
def test_error_bound_of_other_spots(spots, evaluate, error):
    # Among them spots that roll without sliding or spin, where lines without slip leave the spot.
    deviations = abs(evaluate(spots, "--error", str(error)) - evaluate(spots, "--error", "1e-13"))
    assert deviations.max() <= error


def test_mapped_rule(spots, evaluate):
    deviations = abs(evaluate(spots, "--model", "mapped") - evaluate(spots)).max(axis=1)
    assert np.median(deviations[:400]) <= 5e-4
    assert np.median(deviations[400:]) <= 2e-5
    assert np.quantile(deviations[400:], 0.9) <= 5e-3
    assert deviations.max() <= 0.25


def test_slender_rule(spots, evaluate):
    grooves = spots[400:]
    deviations = abs(evaluate(grooves, "--model", "slender") - evaluate(grooves)).max(axis=1)
    assert np.median(deviations) <= 6e-5
    assert np.quantile(deviations, 0.9) <= 5e-4
    # Nearly no sliding but where the ball stands on the ends of its spot.
    assert deviations.max() <= 5e-2
    # What is left is the rise along the chords.
    grooves[:, 6] = 0
    deviations = abs(evaluate(grooves, "--model", "slender") - evaluate(grooves)).max(axis=1)
    assert np.median(deviations) <= 4e-5
    assert deviations.max() <= 3e-3


def test_slender_rule_without_curvature_is_flat(cases, evaluate):
    names = ["N", "a", "b", "f", "vx", "vy", "w"]
    rows = cases[0][np.linalg.norm(cases[0][:, 7:10], axis=1) > 0].copy()
    flat = evaluate(rows[:, [0, 1, 2, 3, 7, 8, 9]], kernel="wrench", inputs=names)
    rows[:, 10:] *= 1e-9 * np.linalg.norm(rows[:, 7:10], axis=1)[:, None]
    deviations = abs(evaluate(rows, "--model", "slender")[:, :3] - flat).max(axis=1)
    assert np.median(deviations) <= 1e-4
    assert deviations.max() <= 1e-2


def test_slender_rule_has_the_derivatives_of_its_wrench(spots, evaluate):
    rows = spots[400:][abs(spots[400:, 9]) > 0.02]
    found = evaluate(rows, "--model", "slender", "--jacobian")
    assert (found[:, :5] == evaluate(rows, "--model", "slender")).all()
    found = found[:, 5:].reshape(-1, 5, 5)
    exact = evaluate(rows, "--jacobian")[:, 5:].reshape(-1, 5, 5)
    scale = abs(exact).max(axis=(1, 2))
    assert np.median(abs(found - exact).max(axis=(1, 2)) / scale) <= 1e-3
    for j in range(5):
        step = 0.02 * abs(rows[:, 9])
        ends = []
        for sign in (1, -1):
            moved = rows.copy()
            moved[:, 7 + j] += sign * step
            ends.append(evaluate(moved, "--model", "slender"))
        slopes = (ends[0] - ends[1]) / (2 * step)[:, None]
        assert np.median(abs(slopes - found[:, :, j]).max(axis=1) / scale) <= 5e-3
    assert abs(found - found.transpose(0, 2, 1)).max() <= 1e-12 * abs(found).max()


def test_product_rule(cases, evaluate):
    inputs, results = cases
    deviations = abs(evaluate(inputs, "--model", "product") - results).max(axis=1)
    assert np.median(deviations) <= 1e-3
    assert deviations.max() <= 0.15


def test_axes_may_be_exchanged(cases, evaluate):
    inputs, _ = cases
    turned = inputs[:, [0, 2, 1, 3, 6, 5, 4, 8, 7, 9, 11, 10]] * (
        1,
        *(1, 1, 1, 1, -1, 1, 1, -1, 1, 1, -1),
    )
    wrenches = evaluate(turned)
    expected = evaluate(inputs)[:, [1, 0, 2, 4, 3]] * (1, -1, 1, 1, -1)
    assert abs(wrenches - expected).max() <= 1e-15


def test_units(cases, evaluate):
    inputs, results = cases
    load, size, friction = 350.0, 7e-4, 0.07
    scaled = inputs * np.array([load, size, size, friction, *3 * [1 / size], 1, 1, *3 * [1 / size]])
    found = evaluate(scaled) / (load * friction) / [1, 1, size, size, size]
    assert abs(found - results).max() <= 1e-10


def test_derivatives(cases, evaluate):
    # Where nothing but a line is without slip there are none.
    inputs = cases[0][abs(cases[0][:, 9]) > 0.02]
    found = evaluate(inputs, "--jacobian")[:, 5:].reshape(-1, 5, 5)
    for j in range(5):
        speed = np.linalg.norm(inputs[:, 7:12], axis=1)
        step = 1e-4 * np.minimum(speed, abs(inputs[:, 9]))
        ends = []
        for sign in (1, -1):
            moved = inputs.copy()
            moved[:, 7 + j] += sign * step
            ends.append(evaluate(moved, "--error", "1e-13"))
        slopes = (ends[0] - ends[1]) / (2 * step)[:, None]
        scale = abs(found).max(axis=(1, 2))
        assert np.median(abs(slopes - found[:, :, j]).max(axis=1) / scale) <= 1e-6
        assert (abs(slopes - found[:, :, j]).max(axis=1) / scale).max() <= 3e-3
    # A potential has symmetric second derivatives, and is homogeneous.
    assert abs(found - found.transpose(0, 2, 1)).max() <= 1e-12 * abs(found).max()
    change = np.einsum("nij,nj->ni", found, inputs[:, 7:12])
    assert abs(change).max() <= 1e-12 * abs(found).max()


def test_flat_limit(cases, evaluate):
    inputs, _ = cases
    names = ["N", "a", "b", "f", "vx", "vy", "w"]
    moving = inputs[np.linalg.norm(inputs[:, 7:10], axis=1) > 0]
    flat = evaluate(moving[:, [0, 1, 2, 3, 7, 8, 9]], kernel="wrench", inputs=names)
    for small in (1e-13, 1e-17, 1e-30, 0):
        curved = moving.copy()
        curved[:, 10:] *= small * np.linalg.norm(moving[:, 7:10], axis=1)[:, None]
        curved[:, 4:7] /= abs(curved[:, 4:7]).max(axis=1)[:, None]
        deviations = abs(evaluate(curved)[:, :3] - flat).max(axis=1)
        if small > 1e-14:
            # Not the limit yet: it is the quadrature.
            assert deviations.max() <= 1e-10
        else:
            assert deviations.max() <= 1e-13
    # Without curvature there is no moment.
    moving[:, 4:7] = 0
    found = evaluate(moving)
    assert abs(found[:, :3] - flat).max() <= 1e-13
    assert (found[:, 3:] == 0).all()


def test_slender_spot_that_rolls(evaluate):
    # K. L. Johnson, Contact Mechanics, section 8.5: a ball rolls freely in a groove, with slip
    # z(x) q + v_y. With the bands of opposite slip in balance there is none at 0.3473 a, and the
    # loss is 0.1611 f N kappa a^2 per unit of angle, kappa a^2 the height of the edge.
    for k, bar in ((0.3, 2e-1), (0.1, 2e-2), (0.01, 1e-3)):
        low, high = -1.0, 0.0
        for _ in range(30):
            slip = 0.5 * (low + high)
            force = evaluate([[1, 1, k, 1, 2, 0, 0.7, 0, slip, 0, -1, 0]])[0, 1]
            low, high = (slip, high) if force > 0 else (low, slip)
        assert np.sqrt(-slip) == pytest.approx(0.3473, abs=bar)
        rows = np.array([[1, 1, k, 1, 2, 0, 0.7, 0, slip, 0, -1, 0]])
        assert power(rows, evaluate(rows))[0] == pytest.approx(0.1611, abs=bar)


def test_nothing_is_gained(evaluate, slow_build):
    random = np.random.default_rng(5)
    n = 400 if slow_build else 4000
    rows = np.ones((n, 12))
    rows[:, 2] = 10 ** random.uniform(-3, 0, n)
    rows[:, 4:] = random.normal(size=(n, 8)) * 10 ** random.uniform(-6, 3, (n, 8))
    rows[::7, 9] = 0
    rows[::11, 7] = 0
    for words in ((), ("--error", "1e-4"), *RULES, ("--delta", "0.1")):
        lost = power(rows, evaluate(rows, *words))
        assert np.isfinite(lost).all()
        assert (lost >= 0).all(), words


def test_rest_and_nonsense(evaluate):
    assert (evaluate([[1, 1, 0.5, 1, 1, 0, 1, 0, 0, 0, 0, 0]]) == 0).all()
    found = evaluate([[1, 1, 0.5, 1, 1, 0, 1, 0, 0, 0, 0, 0]], "--delta", "1e-3")
    assert abs(found).max() <= 1e-15
    for row in (
        [1, 1, 0, 1, 1, 0, 1, 1, 0, 0, 0, 0],
        [1, 1, 0.5, 1, 1, 0, 1, 1, 0, 0, np.nan, 0],
    ):
        assert np.isnan(evaluate([row])).all()


def test_regularisation_of_the_flat_spot_holds(evaluate, cases):
    names = ["N", "a", "b", "f", "vx", "vy", "w"]
    rows = cases[0].copy()
    rows[:, 4:7] = 0
    flat = evaluate(rows[:, [0, 1, 2, 3, 7, 8, 9]], "--delta", "0.3", kernel="wrench", inputs=names)
    assert abs(evaluate(rows, "--delta", "0.3")[:, :3] - flat).max() <= 1e-13
    rows[:, 4:7] = cases[0][:, 4:7]
    slow = rows.copy()
    slow[:, 7:12] *= 1e-6
    found = evaluate(slow, "--delta", "0.3")
    # Near rest the wrench is linear in all velocities.
    slow[:, 7:12] *= 0.5
    assert abs(2 * evaluate(slow, "--delta", "0.3") - found).max() <= 1e-9


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("curved_wrench", "--model", "adaptiv"), "did you mean 'adaptive'"),
        (("curved_wrench", "--error", "0.5"), "--error needs a number below 1e-3"),
        (
            ("curved_wrench", "--model", "product", "--error", "1e-5"),
            "goes with the model adaptive",
        ),
        (("wrench", "--error", "1e-5"), "--error goes with the kernel curved_wrench"),
    ],
)
def test_words_wrong(words, message, run):
    result = run("eval", *words, input="")
    assert result.status == 2
    assert message in result.err


GROOVE = """
&scene title = "a ball in a groove" t_end = 0.004 gravity = 0.0, 0.0, -9.81 /
&material name = 'steel' young = 2.1e11 poisson = 0.3 /
&body name = 'ball' mass = 0.02 inertia = 3*1.0e-7 position = 0.0, 1.0e-5, -6.0e-4
   velocity = 0.5, 0.0, 0.0 angular_velocity = 0.0, 100.0, 20.0 applied_force = 0.0, 0.0, -20.0 /
&surface name = 'sphere' body = 'ball' material = 'steel' shape = 'sphere' radius = 0.005 /
&surface name = 'groove' body = 'ground' material = 'steel' shape = 'cylinder' radius = 0.0056
   direction = 1, 0, 0 side = 'inside' /
&contact name = 'c' surfaces = 'groove', 'sphere' damping = 'hunt_crossley'
   damping_coefficient = 50.0 friction = 'contensou_exact' friction_coefficient = 0.1
   spot = 'curved' spot_error = 1.0e-7 /
&integrator method = 'cvode_bdf' rtol = 1.0e-8 /
&output file = 'o.h5' interval = 1.0e-4 /
"""


@pytest.mark.parametrize("order", ["'groove', 'sphere'", "'sphere', 'groove'"])
def test_ball_in_a_groove_has_the_kernel_of_its_spot(simulate, evaluate, order):
    scene = GROOVE.replace("'groove', 'sphere' damping", f"{order} damping")
    rows = simulate(scene).columns
    energy = rows["energy_kinetic"][0]
    assert abs(rows["energy_error"]).max() <= 1e-8 * energy
    assert (np.diff(rows["work_friction"]) > 0).all()
    closed = np.flatnonzero(rows["normal_force"][:, 0] > 1)
    assert len(closed) > 20
    normal, major = rows["contact_normal"][closed, 0], rows["major_direction"][closed, 0]
    minor = np.cross(normal, major)
    turning = rows["angular_velocity"][closed, 0]
    # B is the sphere, or the groove. Half of what both curve: across the groove and along it.
    sign = 1
    if order == "'sphere', 'groove'":
        sign = -1
        turning = -turning
    forms = (1 / 0.005 + 1 / 0.0056, 1 / 0.005)
    table = np.zeros((len(closed), 12))
    table[:, 0] = rows["normal_force"][closed, 0]
    table[:, 1:3] = rows["semi_axes"][closed, 0]
    table[:, 3] = 0.1
    table[:, 4], table[:, 6] = 0.5 * sign * forms[0], 0.5 * sign * forms[1]
    table[:, 7] = (rows["slip_velocity"][closed, 0] * major).sum(axis=1)
    table[:, 8] = (rows["slip_velocity"][closed, 0] * minor).sum(axis=1)
    table[:, 9] = rows["spin"][closed, 0]
    table[:, 10] = (turning * major).sum(axis=1)
    table[:, 11] = (turning * minor).sum(axis=1)
    # Across the groove the spot is long.
    assert abs(abs(major[:, 1]) - 1).max() <= 1e-2
    expected = evaluate(table)
    limit = table[:, 0] * 0.1
    force = rows["friction_force"][closed, 0]
    assert abs((force * major).sum(axis=1) - expected[:, 0]).max() <= 1e-6 * limit.max()
    assert abs((force * minor).sum(axis=1) - expected[:, 1]).max() <= 1e-6 * limit.max()
    moment = rows["spot_moment"][closed, 0]
    scale = abs(expected[:, 3:]).max()
    assert scale > 1e-9
    assert abs((moment * major).sum(axis=1) - expected[:, 3]).max() <= 1e-5 * scale
    assert abs((moment * minor).sum(axis=1) - expected[:, 4]).max() <= 1e-5 * scale
    assert abs((moment * normal).sum(axis=1)).max() <= 1e-9 * scale


@pytest.mark.parametrize(
    ("scene", "word"),
    [
        (GROOVE.replace("spot_error = 1.0e-7", ""), "c.spot=slender"),
        (GROOVE.replace("spot = 'curved' spot_error = 1.0e-7", ""), "c.tangential=spring"),
    ],
    ids=["slender", "spring"],
)
def test_the_resolved_scene_has_no_keys_of_other_models(run, tmp_path, scene, word):
    (tmp_path / "scene.nml").write_text(scene, encoding="utf-8")
    done = run("check", "scene.nml", "--expand", "--set", word)
    assert done.status == 0, done.err
    key, _, name = word.partition(".")[2].partition("=")
    assert f"{key} = '{name}'" in done.out
    (tmp_path / "expanded.nml").write_text(done.out, encoding="utf-8")
    again = run("check", "expanded.nml", "--expand")
    assert again.status == 0, again.err
    assert again.out == done.out


def test_slender_spots_in_a_scene(simulate):
    scene = GROOVE.replace("spot_error = 1.0e-7", "")
    rows = simulate(scene, "c.spot=slender").columns
    assert abs(rows["energy_error"]).max() <= 1e-8 * rows["energy_kinetic"][0]
    assert (np.diff(rows["work_friction"]) > 0).all()
    other = simulate(GROOVE).columns
    lost, wanted = rows["work_friction"][-1], other["work_friction"][-1]
    assert lost == pytest.approx(wanted, rel=2e-3)
    assert lost != wanted


def test_rolling_in_a_groove_goes_on_but_loses(simulate):
    # A ball without spin that rolls: on a flat spot it loses nothing, on a curved one what Johnson
    # has, here of a spot that is not very slender.
    roll = (
        "ball.angular_velocity=0,100.1,0",
        "ball.position=0,0,-6.02e-4",
        "c.damping_coefficient=500",
    )
    curved = simulate(GROOVE, *roll).columns
    flat = simulate(GROOVE.replace("spot_error = 1.0e-7", ""), *roll, "c.spot=flat").columns
    assert "spot_moment" not in flat
    part = slice(20, None)

    def rate(rows):
        lost = rows["work_friction"][part]
        way = np.linalg.norm(rows["position"][part, 0] - rows["position"][20, 0], axis=1)
        return (lost[-1] - lost[0]) / way[-1]

    load = 20 + 0.02 * 9.81
    a = curved["semi_axes"][part, 0, 0].mean()
    height = 0.5 * 0.5 * (1 / 0.005 + 1 / 0.0056) * a**2
    assert rate(curved) == pytest.approx(0.1611 * 0.1 * load * height / 0.005, rel=0.25)
    assert abs(rate(flat)) < 0.02 * rate(curved)


@pytest.mark.parametrize("method", ["cvode_adams", "explicit8"])
def test_methods_agree(simulate, method):
    sets = ("scene.t_end=0.001",)
    rows = simulate(GROOVE, *sets).columns
    other = simulate(GROOVE, *sets, f"integrator.method={method}").columns
    assert abs(rows["position"] - other["position"]).max() <= 1e-9
    assert abs(rows["angular_velocity"] - other["angular_velocity"]).max() <= 1e-3


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("friction", "pade22", "a curved spot is not available with friction = 'pade22'"),
        ("tangential", "elastic", "a curved spot is not available with tangential = 'elastic'"),
        ("drilling", ".false.", "a curved spot is not available without the drilling torque"),
        ("normal", "rigid", "a curved spot is not available for a rigid contact"),
        ("tangential", "spring", "a curved spot is not available with tangential = 'spring'"),
        ("tangential", "rolling", "a curved spot is not available with tangential = 'rolling'"),
        ("spot", "bent", "curved"),
        ("spot", "slender", "spot_error"),
        ("spot_error", "0.1", "spot_error"),
    ],
)
def test_what_a_curved_spot_does_not_go_with(run, tmp_path, key, value, message):
    (tmp_path / "scene.nml").write_text(GROOVE, encoding="utf-8")
    result = run("check", "scene.nml", "--set", f"c.{key}={value}")
    assert result.status == 2
    assert message in result.err


def test_cost_compares_curved_spots_with_flat_ones(run, tmp_path):
    (tmp_path / "c.nml").write_text(
        GROOVE
        + "&cost methods = 'cvode_bdf', 'cvode_adams', rtol = 1e-6, samples = 10, repeats = 1,"
        " reference_rtol = 1e-8 /\n"
    )
    done = run("cost", "c.nml", "-q", "--csv", "c.csv", timeout=300)
    assert done.status == 0, done.err
    rows = list(csv.DictReader((tmp_path / "c.csv").open()))
    models = {row["model"] for row in rows}
    curved = {"contensou_exact", "contensou_exact+slender"}
    assert curved | {"contensou_exact+flat", "contensou_simplified+flat"} <= models
    assert all(model.endswith("+flat") for model in models - curved)
