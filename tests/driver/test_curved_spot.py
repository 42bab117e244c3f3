"""The friction wrench of a curved spot by way of `contensou eval curved_wrench`.

`tests/reference/curved_spot.py` wrote its table, from the definition of the wrench.
"""

from __future__ import annotations

import csv
import io

import numpy as np
import pytest

INPUTS = ["N", "a", "b", "f", "Lxx", "Lxy", "Lyy", "vx", "vy", "w", "wx", "wy"]
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
    assert np.median(deviations) <= error
    assert deviations.max() <= 100 * error


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
        for _ in range(60):
            slip = 0.5 * (low + high)
            force = evaluate([[1, 1, k, 1, 2, 0, 0.7, 0, slip, 0, -1, 0]])[0, 1]
            low, high = (slip, high) if force > 0 else (low, slip)
        assert np.sqrt(-slip) == pytest.approx(0.3473, abs=bar)
        rows = np.array([[1, 1, k, 1, 2, 0, 0.7, 0, slip, 0, -1, 0]])
        assert power(rows, evaluate(rows))[0] == pytest.approx(0.1611, abs=bar)


def test_nothing_is_gained(evaluate):
    random = np.random.default_rng(5)
    n = 4000
    rows = np.ones((n, 12))
    rows[:, 2] = 10 ** random.uniform(-3, 0, n)
    rows[:, 4:] = random.normal(size=(n, 8)) * 10 ** random.uniform(-6, 3, (n, 8))
    rows[::7, 9] = 0
    rows[::11, 7] = 0
    for words in ((), ("--error", "1e-4"), ("--model", "product"), ("--delta", "0.1")):
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
