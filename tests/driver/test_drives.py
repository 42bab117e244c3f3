"""Prescribed motions, fixed bodies, applied loads and rolling resistance against their formulas."""

from __future__ import annotations

import numpy as np
import pytest

#: What rolls sticks, which is stiff: those tests are for cvode_bdf alone.
METHODS = ("cvode_bdf", "explicit8")

LONE = """
&scene gravity = 0, 0, 0, t_end = 2 /
&body name = 'stone', mass = 0.5, inertia = 2e-3, 3e-3, 4e-3{stone} /
&output file = 'out.h5', interval = 0.1 /
"""

BALL = """
&scene gravity = 0, 0, -9.81, t_end = {t_end} /
&material name = 'steel', young = 2.1e11, poisson = 0.3 /
&body name = 'ball', mass = 0.0327, inertia = 3*1.308e-6, position = 0, 0, {height}{ball} /
&body name = 'table', {table} /
&surface name = 'ball', body = 'ball', shape = 'sphere', radius = 0.01, material = 'steel' /
&surface name = 'top', body = 'table', shape = 'plane', material = 'steel' /
&contact name = 'c', surfaces = 'top', 'ball', damping = 'hunt_crossley', damping_coefficient = 10,
         friction = 'contensou_exact', friction_coefficient = {friction}{rolling} /
&output file = 'out.h5', interval = 0.01 /
"""

#: Centre of the ball at rest: m g = k_n d^(3/2).
STIFFNESS = 4 / 3 * (2.1e11 / (2 * (1 - 0.3**2))) * np.sqrt(0.01)
HEIGHT = 0.01 - (0.0327 * 9.81 / STIFFNESS) ** (2 / 3)


def ball_on_table(table="motion = 'fixed'", ball="", rolling="", t_end=1.0, friction=0.3):
    return BALL.format(
        t_end=t_end,
        height=repr(float(HEIGHT)),
        ball=ball,
        table=table,
        rolling=rolling,
        friction=friction,
    )


@pytest.mark.parametrize("method", METHODS)
def test_a_constant_force(simulate, method):
    rows = simulate(
        LONE.format(stone=", applied_force = 1, -2, 0.5"), f"integrator.method = {method}"
    )
    force = np.array([1, -2, 0.5])
    t = rows.time[:, None]
    np.testing.assert_allclose(rows.velocity[:, 0], force / 0.5 * t, atol=1e-8)
    np.testing.assert_allclose(rows.position[:, 0], force * t**2, atol=1e-8)
    work = (force * rows.position[:, 0]).sum(axis=1)
    np.testing.assert_allclose(rows.work_applied, work, atol=1e-7)
    assert rows.summary["energy_error_relative"] <= 1e-8


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("frame", ["inertial", "body"])
def test_a_constant_torque(simulate, method, frame):
    """A torque about a principal axis spins the body up; the frame makes no difference there."""
    load = f", applied_torque = 0, 0, 0.02, applied_frame = '{frame}', spin = 0, 0, 1"
    rows = simulate(LONE.format(stone=load), f"integrator.method = {method}")
    expected = 1 + 0.02 / 4e-3 * rows.time
    np.testing.assert_allclose(rows.angular_velocity[:, 0, 2], expected, atol=1e-8)
    np.testing.assert_allclose(
        rows.work_applied, 0.5 * 4e-3 * (expected**2 - 1), rtol=1e-7, atol=1e-9
    )


@pytest.mark.parametrize("method", METHODS)
def test_a_force_that_turns_with_the_body(simulate, method):
    """A spinning body pushed in its own x direction goes in circles of radius F/(m w^2)."""
    w, force = 3.0, 0.6
    load = f", spin = 0, 0, {w}, applied_force = {force}, 0, 0, applied_frame = 'body'"
    rows = simulate(LONE.format(stone=load), f"integrator.method = {method}")
    t, a = rows.time, force / 0.5
    expected = np.stack([a / w * np.sin(w * t), a / w * (1 - np.cos(w * t)), 0 * t], axis=1)
    np.testing.assert_allclose(rows.velocity[:, 0], expected, atol=1e-7)
    assert rows.summary["energy_error_relative"] <= 1e-7


@pytest.mark.parametrize("method", METHODS)
def test_a_ramp(simulate, method):
    """The table follows its ramp; the ball, without friction, does not."""
    table = (
        "motion = 'prescribed', velocity = 0.1, 0, 0, angular_velocity = 0, 0, 1, "
        "final_velocity = 0.5, 0.2, 0, final_angular_velocity = 0, 0, -4, ramp_duration = 0.4"
    )
    rows = simulate(ball_on_table(table, friction=0.0), f"integrator.method = {method}")
    t = rows.time
    share = np.minimum(t / 0.4, 1)
    np.testing.assert_allclose(rows.velocity[:, 1, 0], 0.1 + 0.4 * share, atol=1e-9)
    np.testing.assert_allclose(rows.velocity[:, 1, 1], 0.2 * share, atol=1e-9)
    np.testing.assert_allclose(rows.angular_velocity[:, 1, 2], 1 - 5 * share, atol=1e-8)
    turned = np.where(t < 0.4, t - 2.5 / 0.4 * t**2, 0.4 - 1.0 - 4 * (t - 0.4))
    w, _, _, z = rows.quaternion[:, 1].T
    np.testing.assert_allclose(np.exp(1j * turned), (w + 1j * z) ** 2, atol=3e-6)
    assert np.abs(rows.velocity[:, 0, :2]).max() <= 1e-12
    assert np.abs(rows.work_applied).max() <= 1e-9


def test_a_belt_supplies_the_energy(simulate):
    """A ball set on a moving belt slips for 2 v/(7 f g) and rolls on at 2/7 of its speed."""
    v, f = 0.2, 0.3
    rows = simulate(ball_on_table(f"motion = 'prescribed', velocity = {v}, 0, 0", t_end=0.1))
    t = rows.time
    slips = t < 2 * v / (7 * f * 9.81) - 1e-3
    np.testing.assert_allclose(rows.velocity[slips, 0, 0], f * 9.81 * t[slips], atol=1e-6)
    rolls = t > 2 * v / (7 * f * 9.81) + 5e-3
    np.testing.assert_allclose(rows.velocity[rolls, 0, 0], 2 / 7 * v, rtol=1e-5)
    # The belt works against the friction force over the way that the belt goes meanwhile.
    supplied = f * 0.0327 * 9.81 * v * (2 * v / (7 * f * 9.81))
    assert rows.work_applied[-1] == pytest.approx(supplied, rel=1e-5)
    assert rows.summary["energy_error_relative"] <= 1e-7


def test_rolling_resistance_of_constant_arm(simulate):
    """A rolling ball slows down by (5/7) e g/R."""
    arm = 1e-4
    rows = simulate(
        ball_on_table(
            ball=", velocity = 0.2, 0, 0, spin = 0, 20, 0",
            rolling=f", rolling = 'constant', rolling_coefficient = {arm}, "
            "rolling_regularization = 1e-3",
        )
    )
    slowing = 5 / 7 * arm * 9.81 / 0.01
    expected = 0.2 - slowing * rows.time
    np.testing.assert_allclose(rows.velocity[:, 0, 0], expected, atol=2e-6)
    lost = 0.7 * 0.0327 * (0.2**2 - expected[-1] ** 2)
    assert rows.work_friction[-1] == pytest.approx(lost, rel=1e-4)
    assert rows.summary["energy_error_relative"] <= 1e-8


def test_rolling_resistance_by_hysteresis(simulate):
    """On a circular spot the arm is (3/16) loss a."""
    loss = 0.5
    rows = simulate(
        ball_on_table(
            ball=", velocity = 0.2, 0, 0, spin = 0, 20, 0",
            rolling=f", rolling = 'hysteresis', rolling_coefficient = {loss}, "
            "rolling_regularization = 1e-3",
        )
    )
    a = np.sqrt(0.01 * (0.01 - HEIGHT))
    slowing = 5 / 7 * (3 / 16 * loss * a) * 9.81 / 0.01
    gain = rows.velocity[-1, 0, 0] - rows.velocity[0, 0, 0]
    assert gain == pytest.approx(-slowing * rows.time[-1], rel=2e-3)


def test_rolling_resistance_is_off_unless_named(simulate):
    rows = simulate(ball_on_table(ball=", velocity = 0.2, 0, 0, spin = 0, 20, 0"))
    np.testing.assert_allclose(rows.velocity[:, 0, 0], 0.2, atol=1e-7)
