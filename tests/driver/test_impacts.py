"""Impacts at several rigid contacts at one instant: in turn, or all at once.

What they must give is worked out here anew: in turn by Newton's ratio at one contact after the
other, at once by Poisson's in two phases, whose complementarity problems are solved by trying all
sets of contacts. Nothing rubs unless said.
"""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

GRAVITY = 9.81
STEEL = "&material name = 'steel', young = 2.1e11, poisson = 0.3 /\n"
KINDS = ("sequential", "simultaneous")
METHODS = ("explicit8", "cvode_bdf", "cvode_adams", "auto")


def in_turn(response, rate, e):
    """Impulses of impacts one after the other, the fastest approach first, until none is left."""
    impulse = np.zeros(len(rate))
    for _ in range(100000):
        now = rate + response @ impulse
        i = int(np.argmin(now))
        if now[i] > -1e-9:
            return impulse
        impulse[i] -= (1 + e[i]) * now[i] / response[i, i]
    raise AssertionError("impacts in turn do not come to an end")


def complementary(response, rate):
    """Impulses z >= 0 with rate + response z >= 0 and no impulse where a gap grows."""
    n = len(rate)
    for size in range(n + 1):
        for active in itertools.combinations(range(n), size):
            rows = list(active)
            z = np.zeros(n)
            if rows:
                z[rows] = np.linalg.lstsq(response[np.ix_(rows, rows)], -rate[rows], rcond=None)[0]
            if (z >= -1e-12).all() and (rate + response @ z >= -1e-12).all():
                return z
    raise AssertionError("no impulses")


def at_once(response, rate, e):
    """Impulses by Poisson's ratio; all contacts have the same."""
    compression = complementary(response, rate)
    least = e * compression
    rate = rate + response @ compression
    return compression + least + complementary(response, rate + response @ least)


HOW = {"sequential": in_turn, "simultaneous": at_once}


def scene(text, impacts, t_end, method="explicit8", gravity=0.0, rtol=1e-9, rows=20):
    """A scene around its bodies and contacts."""
    return (
        f"&scene gravity = 0, 0, {-gravity!r}, t_end = {t_end!r}, impacts = '{impacts}' /\n{STEEL}"
        f"{text}&integrator method = '{method}', rtol = {rtol!r} /\n"
        f"&output file = 'out.h5', interval = {t_end / rows!r} /\n"
    )


def ball(name, x, velocity=0.0, mass=0.05, radius=0.02, motion=""):
    """A ball on the axis x."""
    heavy = f"mass = {mass!r}, inertia = 3*{0.4 * mass * radius**2!r}, " if not motion else ""
    return (
        f"&body name = '{name}', {heavy}position = {x!r}, 0, 0, velocity = {velocity!r}, 0, 0"
        f"{motion} /\n&surface name = '{name}_skin', body = '{name}', shape = 'sphere',"
        f" radius = {radius!r}, material = 'steel' /\n"
    )


def contact(first, second, keys=""):
    """A rigid contact of two bodies or surfaces."""
    return (
        f"&contact name = '{first}_{second}', surfaces = '{first}', '{second}', normal = 'rigid'"
        f"{keys} /\n"
    )


def row_of_balls(masses, first, e, gap=0.0):
    """Balls that touch, and one that comes from the left, 5 mm away."""
    text, x = "", 0.0
    for k, mass in enumerate(masses):
        text += ball(f"b{k}", x if k else -0.005, first if k == 0 else 0.0, mass)
        x += 0.04 + gap
    for k in range(1, len(masses)):
        text += contact(f"b{k - 1}_skin", f"b{k}_skin", f", restitution = {e!r}")
    return text


def response_of_row(masses):
    """Rates of the gaps of a row by unit impulses."""
    n = len(masses) - 1
    response = np.zeros((n, n))
    for i in range(n):
        response[i, i] = 1 / masses[i] + 1 / masses[i + 1]
        if i:
            response[i, i - 1] = response[i - 1, i] = -1 / masses[i]
    return response


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("e", [1.0, 0.6, 0.0])
@pytest.mark.parametrize("impacts", KINDS)
def test_newtons_cradle(simulate, impacts, e, method):
    run = simulate(scene(row_of_balls([0.05] * 5, 1.0, e), impacts, 0.01, method))
    after = run.velocity[-1, :, 0]
    if impacts == "simultaneous":
        # All go on with a fifth of the velocity; then each impulse comes again, e times.
        assert after == pytest.approx([(1 - 4 * e) / 5] + [(1 + e) / 5] * 4, abs=1e-12)
    elif e == 1.0:
        assert after == pytest.approx([0, 0, 0, 0, 1], abs=1e-12)
    impulse = HOW[impacts](response_of_row([0.05] * 5), np.array([-1.0, 0, 0, 0]), np.full(4, e))
    expected = [1, 0, 0, 0, 0] - np.diff(impulse, prepend=0, append=0) * 20.0
    assert after == pytest.approx(expected, abs=3e-8)
    assert after.sum() == pytest.approx(1.0, abs=1e-13)
    assert run.residual() < 1e-13
    lost = run.energy_kinetic[0] - run.energy_kinetic[-1]
    assert run.work_damping[-1] == pytest.approx(lost, abs=1e-15)
    assert lost >= -1e-16


@pytest.mark.parametrize("impacts", KINDS)
def test_row_of_unequal_balls(simulate, impacts):
    masses, e = [0.05, 0.02, 0.11, 0.04], 0.7
    run = simulate(scene(row_of_balls(masses, 0.8, e), impacts, 0.015))
    impulse = HOW[impacts](response_of_row(masses), np.array([-0.8, 0, 0]), np.full(3, e))
    jump = -np.diff(impulse, prepend=0, append=0) / masses
    assert run.velocity[-1, :, 0] == pytest.approx(np.array([0.8, 0, 0, 0]) + jump, abs=3e-8)
    kinetic = 0.5 * np.sum(masses * (np.array([0.8, 0, 0, 0]) + jump) ** 2)
    assert run.energy_kinetic[-1] == pytest.approx(kinetic, rel=1e-6)


def test_unequal_restitutions_gain_no_energy(simulate):
    # By Poisson's ratio alone this row would have 5 % more energy than allowed.
    text = row_of_balls([0.05] * 4, 1.0, 0.2)
    text = text.replace(
        "'b2_skin', normal = 'rigid', restitution = 0.2",
        "'b2_skin', normal = 'rigid', restitution = 1.0",
    )
    run = simulate(scene(text, "simultaneous", 0.01))
    e = np.array([0.2, 1.0, 0.2])
    response = response_of_row([0.05] * 4)
    rate = np.array([-1.0, 0, 0])
    compression = complementary(response, rate)
    # All work is that of the first contact; a share of the impulses gives e^2 of it back.
    allowed = 0.2**2 * 0.5 * compression[0]
    start = response @ compression + rate

    def work(share):
        least = share * e * compression
        impulse = least + complementary(response, start + response @ least)
        return impulse @ (start + 0.5 * response @ impulse)

    assert work(1.0) > 1.05 * allowed
    impulse = None
    low, high = 0.0, 1.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if work(middle) <= allowed else (low, middle)
    least = low * e * compression
    impulse = compression + least + complementary(response, start + response @ least)
    expected = [1, 0, 0, 0] - np.diff(impulse, prepend=0, append=0) * 20.0
    assert run.velocity[-1, :, 0] == pytest.approx(expected, abs=1e-9)
    before = 0.025
    assert run.energy_kinetic[-1] == pytest.approx(
        before - 0.5 * compression[0] + allowed, rel=1e-9
    )


def block(half, inertia, tilt):
    """A block on two feet, which turns about the right one onto the left one."""
    # The right foot is on the floor; the centre of mass is above the middle of both.
    mass, height, radius = 2.0, 0.1, 0.01
    spin = -0.8
    x, z = -half * math.cos(tilt), half * math.sin(tilt)
    text = (
        "&surface name = 'floor', body = 'ground', shape = 'plane', material = 'steel' /\n"
        f"&body name = 'block', mass = {mass}, inertia = 3*{inertia!r},"
        f" position = {x + height * math.sin(tilt)!r}, 0,"
        f" {z + height * math.cos(tilt) + radius!r}, axis = 0, 1, 0, angle = {tilt!r},"
    )
    # The right foot rests: the velocity of the centre of mass is that of a turn about it.
    arm = np.array([x + height * math.sin(tilt), 0, z + height * math.cos(tilt)])
    velocity = np.cross([0, spin, 0], arm)
    text += (
        f" velocity = {float(velocity[0])!r}, 0, {float(velocity[2])!r}, spin = 0, {spin!r}, 0 /\n"
    )
    for name, side in (("left", -1), ("right", 1)):
        text += (
            f"&surface name = '{name}', body = 'block', shape = 'sphere', radius = {radius},"
            f" centre = {side * half!r}, 0, {-height!r}, material = 'steel' /\n"
        )
    return text, mass


@pytest.mark.parametrize("e", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("slender", [True, False])
@pytest.mark.parametrize("impacts", KINDS)
def test_rocking_block(simulate, impacts, slender, e):
    # A slender block goes over to the other foot, a flat one is pressed onto both.
    half, inertia = 0.08, 0.03 if slender else 0.004
    text, mass = block(half, inertia, 1e-3)
    keys = f", restitution = {e!r}"
    text += contact("floor", "left", keys) + contact("floor", "right", keys)
    run = simulate(scene(text, impacts, 0.003, rtol=1e-10, gravity=GRAVITY, rows=3000))
    same, other = 1 / mass + half**2 / inertia, 1 / mass - half**2 / inertia
    assert (other > 0) == slender
    t, kind, name = run.events[0]
    assert (kind, name) == ("touch", "floor_left")
    before = np.searchsorted(run.time, t) - 1
    # Rates of the gaps before and after, from the motion of the centre of mass.
    rates = [
        run.velocity[k, 0, 2] + np.array([1, -1]) * half * run.angular_velocity[k, 0, 1]
        for k in (before, before + 1)
    ]
    # The right foot stays where it is.
    assert len([event for event in run.events if event[0] < t]) == 0
    assert rates[0][0] < -0.12
    assert rates[0][1] == pytest.approx(0.0, abs=2e-5)
    response = np.array([[same, other], [other, same]])
    impulse = HOW[impacts](response, rates[0] * [1, 0], np.full(2, e))
    expected = rates[0] * [1, 0] + response @ impulse
    assert rates[1] == pytest.approx(expected, abs=4e-5)
    if impacts == "simultaneous":
        # By hand: one foot alone if it lifts the other, else both.
        by_hand = [e, (1 + e) * other / same] if slender else [e, 0.0]
        assert expected == pytest.approx(-rates[0][0] * np.array(by_hand), abs=1e-12)
    lost = -np.diff(run.energy_kinetic + run.energy_potential)
    assert lost.min() > -1e-12
    assert run.residual() < 1e-9


@pytest.mark.parametrize("e", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("impacts", KINDS)
def test_ball_between_two_walls_that_close(simulate, impacts, e):
    # Free walls, 20 times as heavy: at once the ball stays where it is and the walls rebound.
    masses, speed = [1.0, 0.05, 1.0], 0.3
    text = ball("left", -0.043, speed, 1.0) + ball("ball", 0.0) + ball("right", 0.043, -speed, 1.0)
    keys = f", restitution = {e!r}"
    text += contact("left_skin", "ball_skin", keys) + contact("ball_skin", "right_skin", keys)
    run = simulate(scene(text, impacts, 0.0101))
    after = run.velocity[-1, :, 0]
    start = np.array([speed, 0, -speed])
    rate = np.array([-speed, -speed])
    impulse = HOW[impacts](response_of_row(masses), rate, np.full(2, e))
    if impacts == "simultaneous":
        assert after == pytest.approx([-e * speed, 0, e * speed], abs=1e-12)
    jump = np.array([-impulse[0], impulse[0] - impulse[1], impulse[1]]) / masses
    if impacts == "simultaneous" or e == 1.0:
        # In turn the order of equal approaches is that of the contacts.
        assert after == pytest.approx(start + jump, abs=1e-6)
    assert np.dot(masses, after) == pytest.approx(0.0, abs=1e-12)
    assert run.energy_kinetic[-1] <= run.energy_kinetic[0] * (1 + 1e-12)
    assert run.residual() < 1e-12


@pytest.mark.parametrize("impacts", KINDS)
def test_walls_that_do_not_yield_end_with_a_message(run, tmp_path, impacts):
    drive = ", motion = 'prescribed'"
    text = (
        ball("left", -0.041, 0.3, motion=drive)
        + ball("ball", 0.0)
        + ball("right", 0.041, -0.3, motion=drive)
        + contact("left_skin", "ball_skin")
        + contact("ball_skin", "right_skin")
    )
    (tmp_path / "s.nml").write_text(scene(text, impacts, 0.01))
    done = run("run", "s.nml", "-q", cwd=tmp_path)
    assert done.status == 1
    said = " ".join(done.err.split())
    assert "'left_skin' and 'ball_skin'" in said or "'ball_skin' and 'right_skin'" in said
    expected = {
        "simultaneous": "press together what lies between them",
        "sequential": "do not come to an end",
    }
    assert expected[impacts] in said
    assert "normal = 'hertz'" in said
    assert "t = 0.0033" in said


@pytest.mark.parametrize("f", [0.1, 0.4])
@pytest.mark.parametrize("e", [0.0, 0.5, 1.0])
def test_table_that_falls_flat_slides_by_coulomb(simulate, e, f):
    # Front legs push more, all push: the impulse of friction is f times (1 + e) m v.
    mass, fall, slide = 1.0, 0.4, 0.9
    text = (
        "&surface name = 'floor', body = 'ground', shape = 'plane', material = 'steel' /\n"
        f"&body name = 'table', mass = {mass}, inertia = 0.01, 0.01, 0.015,"
        f" position = 0, 0, 0.061, velocity = {slide}, 0, {-fall} /\n"
    )
    keys = f", restitution = {e!r}, friction = 'contensou_exact', friction_coefficient = {f!r}"
    for k, (x, y) in enumerate(itertools.product((-0.1, 0.1), repeat=2)):
        text += (
            f"&surface name = 'foot{k}', body = 'table', shape = 'sphere', radius = 0.01,"
            f" centre = {x}, {y}, -0.05, material = 'steel' /\n"
        )
        text += contact("floor", f"foot{k}", keys)
    run = simulate(scene(text, "simultaneous", 0.004 if e > 0 else 0.0025001))
    expected = slide - f * (1 + e) * fall
    assert run.velocity[-1, 0] == pytest.approx([expected, 0, e * fall], abs=1e-7)
    assert np.abs(run.angular_velocity[-1]).max() < 1e-7
    assert run.work_damping[-1] == pytest.approx(0.5 * mass * fall**2 * (1 - e**2), abs=1e-7)
    assert run.work_friction[-1] == pytest.approx(0.5 * mass * (slide**2 - expected**2), abs=1e-7)
    assert run.residual() < 1e-12


def test_one_contact_alone_does_not_care(simulate):
    def ball_that_spins(impacts):
        text = (
            "&surface name = 'floor', body = 'ground', shape = 'plane', material = 'steel' /\n"
            "&body name = 'b', mass = 0.05, inertia = 3*8e-6, position = 0, 0, 0.03,"
            " velocity = 1, 0, -1, spin = 0, 30, 100 /\n"
            "&surface name = 's', body = 'b', shape = 'sphere', radius = 0.02,"
            " material = 'steel' /\n"
            + contact(
                "floor",
                "s",
                ", restitution = 0.7, friction = 'contensou_exact', friction_coefficient = 0.3",
            )
            # Another body that touches elsewhere has no part in it.
            + "&body name = 'other', mass = 0.1, inertia = 3*1e-5, position = 1, 0, 0.02 /\n"
            "&surface name = 'o', body = 'other', shape = 'sphere', radius = 0.02,"
            " material = 'steel' /\n" + contact("floor", "o")
        )
        return simulate(scene(text, impacts, 0.3, gravity=GRAVITY))

    one, other = (ball_that_spins(impacts) for impacts in KINDS)
    assert len(one.events) > 2
    assert (one.velocity == other.velocity).all()
    assert (one.angular_velocity == other.angular_velocity).all()


def test_impacts_that_mean_nothing_are_refused(run, tmp_path):
    text = scene(row_of_balls([0.05, 0.05], 1.0, 0.5), "at_once", 0.01)
    (tmp_path / "s.nml").write_text(text)
    done = run("check", "s.nml", cwd=tmp_path)
    assert done.status == 2
    assert "unknown impacts 'at_once'" in done.err
    assert "one of sequential, simultaneous" in done.err
    soft = text.replace("at_once", "simultaneous").replace("'rigid', restitution = 0.5", "'hertz'")
    (tmp_path / "s.nml").write_text(soft)
    done = run("check", "s.nml", cwd=tmp_path)
    assert done.status == 2
    assert "s.nml:1:" in done.err
    assert "no contact is rigid" in done.err
    done = run("check", "s.nml", "--set", "scene.impacts='sequential'", cwd=tmp_path)
    assert done.status == 0
