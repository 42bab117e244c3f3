"""Rigid contacts: constraints, lift-off and impacts against mechanics and against Hertz."""

from __future__ import annotations

import math
from pathlib import Path

import h5py
import numpy as np
import pytest
from rigid_scenes import judge

GRAVITY = 9.81
HEAD = "&material name = 'steel', young = 2.1e11, poisson = 0.3 /\n"
FLOOR = "&surface name = 'floor', body = 'ground', shape = 'plane', material = 'steel' /\n"


def scene(text, t_end, gravity=(0, 0, -GRAVITY), method="explicit8", rtol=1e-9, interval=None):
    """A scene around the groups that differ."""
    g = ", ".join(map(repr, gravity))
    return (
        f"&scene gravity = {g}, t_end = {t_end!r} /\n{HEAD}{text}\n"
        f"&integrator method = '{method}', rtol = {rtol!r} /\n"
        f"&output file = 'rigid.h5', interval = {interval or t_end / 100!r} /\n"
    )


def ball(name="ball", radius=0.02, mass=0.05, position=(0, 0, 0.02), inertia=None, **more):
    """A ball, solid unless its inertia is given."""
    i = 0.4 * mass * radius**2 if inertia is None else inertia
    keys = "".join(f", {key} = {', '.join(map(repr, value))}" for key, value in more.items())
    where = ", ".join(map(repr, position))
    return (
        f"&body name = '{name}', mass = {mass!r}, inertia = {i!r}, {i!r}, {i!r},"
        f" position = {where}{keys} /\n"
        f"&surface name = '{name}_skin', body = '{name}', shape = 'sphere', radius = {radius!r},"
        " material = 'steel' /\n"
    )


def contact(first="ball_skin", second="floor", keys=""):
    """A rigid contact."""
    return (
        f"&contact name = '{first}_{second}', surfaces = '{first}', '{second}',"
        f" normal = 'rigid'{keys} /\n"
    )


# ---- The Tippe-Top ------------------------------------------------------------------------------

MODELS = ("contensou_exact", "contensou_simplified")
TOUCH = {"contensou_exact": 1.743583, "contensou_simplified": 1.847301}
LEFT = {"contensou_exact": 1.795675, "contensou_simplified": 1.896881}


@pytest.mark.parametrize("model", MODELS)
def test_tippe_top_touches_as_with_hertz(simulate, inputs, tmp_path, model, build_kind):
    t_end = 8.0 if build_kind == "release" else 2.0
    both = {}
    for normal, file in (("hertz", "tippe_top.nml"), ("rigid", "tippe_top_rigid.nml")):
        both[normal] = simulate(
            inputs / file,
            f"ball_floor.friction = '{model}'",
            f"stem_floor.friction = '{model}'",
            "integrator.method = 'explicit8'",
            "integrator.rtol = 1e-9",
            "output.interval = 0.01",
            f"scene.t_end = {t_end}",
        )
    for top in both.values():
        touch = next(t for t, kind, name in top.events if (kind, name) == ("touch", "stem_floor"))
        left = [t for t, kind, name in top.events if (kind, name) == ("lift", "ball_floor")][-1]
        assert touch == pytest.approx(TOUCH[model], abs=1e-4)
        assert left == pytest.approx(LEFT[model], abs=1e-4)
        # The stem carries the top from then on.
        assert top.events[-1][1:] == ("touch", "stem_floor")
        assert top.residual() <= 1e-8
    rigid, hertz = both["rigid"], both["hertz"]
    closed = rigid.normal_force > 0.0
    # A gap of a closed contact stays within the tolerance of a position.
    assert np.abs(rigid.gap[closed]).max() <= 1e-9 * 0.005
    assert rigid.energy_elastic.max() == 0.0
    weight = 6e-3 * GRAVITY
    steady = (rigid.time > 0.05) & (rigid.time < 1.7)
    ratio = rigid.normal_force[steady, 0] / hertz.normal_force[steady, 0]
    assert np.abs(ratio - 1.0).max() < 1e-2
    assert np.abs(rigid.semi_axes[steady, 0] / hertz.semi_axes[steady, 0] - 1.0).max() < 1e-2
    if t_end > 7.0:
        assert abs(rigid.normal_force[-1, 1] / weight - 1.0) < 1e-2
    assert rigid.theta()[-1] == pytest.approx(hertz.theta()[-1], abs=1e-3)


@pytest.mark.parametrize("model", MODELS)
def test_tippe_top_costs_far_fewer_right_hand_sides(simulate, inputs, tmp_path, capsys, model):
    cost = {}
    for normal, file in (("hertz", "tippe_top.nml"), ("rigid", "tippe_top_rigid.nml")):
        top = simulate(
            inputs / file,
            f"ball_floor.friction = '{model}'",
            f"stem_floor.friction = '{model}'",
            "integrator.method = 'explicit8'",
            "integrator.rtol = 1e-8",
            "output.interval = 0.1",
            "scene.t_end = 1.9",
        )
        with h5py.File(tmp_path / "out.h5") as file:
            cpu = file["integrator/cpu_integration"][()]
        cost[normal] = (int(top.summary["right_hand_sides"]), float(cpu))
    with capsys.disabled():
        (many, long), (few, short) = cost["hertz"], cost["rigid"]
        print(
            f"\n{model}: right-hand sides {many} (hertz), {few} (rigid), ratio {many / few:.1f};"
            f" CPU {long:.4f} s, {short:.4f} s, ratio {long / short:.1f}"
        )
    assert many >= 10 * few


@pytest.mark.parametrize(("friction", "left"), [(0.05, 7.05942), (0.1, None), (0.8, None)])
def test_top_rocks_between_ball_and_stem_for_a_finite_time(simulate, inputs, friction, left):
    # Impacts in turn would come to rest only after 10^5 of them, 10 s of CPU.
    top = simulate(
        inputs / "tippe_top_rigid.nml",
        f"ball_floor.friction_coefficient = {friction}",
        f"stem_floor.friction_coefficient = {friction}",
        "integrator.rtol = 1e-8",
        "output.interval = 0.1",
        "scene.t_end = 7.3",
    )
    assert 2 * 10 < len(top.events) < 2 * 60
    assert top.residual() <= 1e-8
    if left is not None:
        # There the Hertz contact of the ball opens for good (rtol 1e-10).
        assert top.events[-1][1:] == ("lift", "ball_floor")
        assert top.events[-1][0] == pytest.approx(left, abs=3e-4)


# ---- Impacts ------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", ["explicit8", "cvode_bdf", "cvode_adams"])
@pytest.mark.parametrize("e", [0.0, 0.3, 0.8])
def test_bouncing_ball_flies_and_comes_to_rest(simulate, method, e):
    height = 0.1
    fall = math.sqrt(2 * height / GRAVITY)
    run = simulate(
        scene(
            ball(position=(0, 0, 0.02 + height)) + FLOOR + contact(keys=f", restitution = {e}"),
            t_end=3.0,
            method=method,
        )
    )
    touches = run.times("touch")
    lifts = run.times("lift")
    # Flights of 2 v e^k/g, until one would be lower than the overlap at rest.
    speed = GRAVITY * fall
    expected, v = [fall], speed * e
    overlap = run.semi_axes[-1, 0, 0] ** 2 / 0.02
    least = max(1e-5, math.sqrt(2 * GRAVITY * overlap))
    while v >= least:
        expected.append(expected[-1] + 2 * v / GRAVITY)
        v *= e
    assert len(touches) == len(expected) == len(lifts) + 1
    tolerance = 1e-8 if method == "explicit8" else 1e-6
    assert touches == pytest.approx(expected, abs=tolerance)
    assert lifts == pytest.approx(expected[:-1], abs=tolerance)
    assert run.normal_force[-1, 0] == pytest.approx(0.05 * GRAVITY, rel=1e-9)
    assert abs(run.gap[-1, 0]) < 1e-11
    lost = 0.05 * GRAVITY * height
    assert run.work_damping[-1] == pytest.approx(lost, rel=1e-9 if tolerance < 1e-7 else 1e-7)
    assert run.residual() < 1e-9


def test_without_restitution_the_rebound_is_elastic(simulate):
    text = ball(position=(0, 0, 0.12)) + FLOOR + contact()
    run = simulate(scene(text, t_end=2.0))
    assert run.work_damping[-1] < 1e-15
    flight = 2 * math.sqrt(2 * 0.1 / GRAVITY)
    touches = run.times("touch")
    assert np.diff(touches) == pytest.approx(flight, abs=1e-9)


def test_hunt_crossley_gives_the_restitution_of_its_speed(simulate):
    alpha, speed = 2.0, 1.5
    height = speed**2 / (2 * GRAVITY)
    keys = f", damping = 'hunt_crossley', damping_coefficient = {alpha}"
    text = ball(position=(0, 0, 0.02 + height)) + FLOOR + contact(keys=keys)
    run = simulate(scene(text, t_end=speed / GRAVITY * 1.2))
    t = run.events[0][0]
    e = float((run.velocity[-1, 0, 2] + GRAVITY * (run.time[-1] - t)) / speed)
    d = 1.5 * alpha * speed
    assert (1 + e) * d == pytest.approx(math.log((1 + d) / (1 - e * d)), rel=1e-8)
    # With the velocity at which it holds, the restitution defines the coefficient.
    keys = f", damping = 'hunt_crossley', restitution = {e!r}, impact_velocity = {speed}"
    text = ball(position=(0, 0, 0.02 + height)) + FLOOR + contact(keys=keys)
    again = simulate(scene(text, t_end=speed / GRAVITY * 1.2))
    assert again.velocity[-1, 0, 2] == pytest.approx(run.velocity[-1, 0, 2], rel=1e-9)


@pytest.mark.parametrize("f", [0.05, 5.0])
def test_oblique_impact_slides_or_rolls(simulate, f):
    # Without gravity; backspin about y. Sliding all along: the impulse of friction is f times the
    # normal one. Sticking: the solid ball keeps 5/7 of v and 2/7 of r w.
    e, normal, v, spin = 0.6, 2.0, 0.8, -30.0
    keys = f", restitution = {e}, friction = 'contensou_exact', friction_coefficient = {f}"
    text = (
        ball(position=(0, 0, 0.03), velocity=(v, 0, -normal), spin=(0, spin, 0))
        + FLOOR
        + contact(keys=keys)
    )
    run = simulate(scene(text, t_end=0.02, gravity=(0, 0, 0)))
    slip = v - 0.02 * spin
    change = -f * (1 + e) * normal if f < 1 else -slip * 2 / 7
    assert run.velocity[-1, 0, 2] == pytest.approx(e * normal, rel=1e-12)
    assert run.velocity[-1, 0, 0] == pytest.approx(v + change, rel=1e-3 if f > 1 else 1e-9)
    assert run.angular_velocity[-1, 0, 1] == pytest.approx(
        spin - 2.5 * change / 0.02, rel=1e-3 if f > 1 else 1e-9
    )
    assert run.work_damping[-1] == pytest.approx(0.5 * 0.05 * normal**2 * (1 - e**2), rel=1e-9)
    assert run.work_friction[-1] > 0
    assert run.residual() < 1e-13


def test_two_free_balls_keep_their_momentum(simulate):
    e = 0.7
    text = (
        ball("one", position=(0, 0, 0), velocity=(1.0, 0, 0))
        + ball("two", mass=0.08, radius=0.03, position=(0.06, 0.01, 0), velocity=(-0.5, 0, 0))
        + contact(
            "one_skin",
            "two_skin",
            f", restitution = {e}, friction = 'contensou_exact', friction_coefficient = 0.2",
        )
    )
    run = simulate(scene(text, t_end=0.05, gravity=(0, 0, 0)))
    assert [kind for _, kind, _ in run.events] == ["touch", "lift"]
    t = run.events[0][0]
    momentum = np.einsum("b,tbi->ti", run.mass, run.velocity)
    assert np.abs(momentum - momentum[0]).max() < 1e-15
    angular = sum(
        run.mass[b] * np.cross(run.position[:, b], run.velocity[:, b]) + run.angular_momentum(b)
        for b in range(2)
    )
    assert np.abs(angular - angular[0]).max() < 1e-16
    normal = np.array([0.06 - 1.5 * t, 0.01, 0]) / 0.05
    approach = normal @ (run.velocity[0, 1] - run.velocity[0, 0])
    apart = normal @ (run.velocity[-1, 1] - run.velocity[-1, 0])
    assert apart / approach == pytest.approx(-e, rel=1e-9)
    assert run.residual() < 1e-13


@pytest.mark.parametrize("friction", [0.0, 0.3, 1.0])
def test_eccentric_impacts_gain_no_energy(simulate, friction):
    # A rod of two points falls askew with speed and spin, again and again.
    keys = f", restitution = 0.9, friction = 'contensou_exact', friction_coefficient = {friction}"
    ends = "".join(
        f"&surface name = '{name}', body = 'rod', shape = 'sphere', centre = {x}, 0, 0,"
        " radius = 0.01, material = 'steel' /\n"
        for name, x in (("left", -0.1), ("right", 0.1))
    )
    text = (
        "&body name = 'rod', mass = 0.2, inertia = 1e-5, 7e-4, 7e-4, position = 0, 0, 0.15,"
        " axis = 0, 1, 0.2, angle = 0.4, velocity = 1.5, 0.3, -0.5, spin = 3, 8, -5 /\n"
        + ends
        + FLOOR
        + contact("left", keys=keys)
        + contact("right", keys=keys)
    )
    run = simulate(scene(text, t_end=0.8, interval=1e-3, method="cvode_bdf"))
    assert len(run.events) > 4
    assert (np.diff(run.work_friction) >= -1e-13).all()
    assert (np.diff(run.work_damping) >= -1e-13).all()
    if friction == 0.0:
        assert run.work_friction[-1] == pytest.approx(0.0, abs=1e-13)
    assert run.residual() < 1e-7


# ---- Constraints --------------------------------------------------------------------------------


def test_ball_slides_and_rolls_on_an_incline(simulate):
    slope, f = 0.5, 0.1
    g = (GRAVITY * math.sin(slope), 0, -GRAVITY * math.cos(slope))
    keys = f", friction = 'coulomb', friction_coefficient = {f}, regularization_velocity = 1e-6"
    text = ball(velocity=(0.5, 0, 0)) + FLOOR + contact(keys=keys)
    run = simulate(scene(text, t_end=1.0, gravity=g))
    normal = 0.05 * GRAVITY * math.cos(slope)
    assert run.normal_force[:, 0] == pytest.approx(normal, rel=1e-10)
    acceleration = GRAVITY * (math.sin(slope) - f * math.cos(slope))
    assert run.velocity[-1, 0, 0] == pytest.approx(0.5 + acceleration, rel=1e-9)
    assert run.angular_velocity[-1, 0, 1] == pytest.approx(f * normal / (0.4 * 0.05 * 0.02))
    assert run.work_friction[-1] > 0
    assert run.residual() < 1e-9
    assert run.events == []
    # Hertz's circle at this force.
    modulus = 2.1e11 / (2 * (1 - 0.09))
    a = (3 * normal * 0.02 / (4 * modulus)) ** (1 / 3)
    assert run.semi_axes[:, 0] == pytest.approx(np.array([[a, a]]).repeat(101, 0), rel=1e-9)
    # A slope that a solid ball rolls down: 5/7 of the acceleration.
    keys = ", friction = 'coulomb', friction_coefficient = 0.9, regularization_velocity = 1e-4"
    text = ball() + FLOOR + contact(keys=keys)
    run = simulate(scene(text, t_end=1.0, gravity=g, method="cvode_bdf"))
    rolling = 5 / 7 * GRAVITY * math.sin(slope)
    assert run.velocity[-1, 0, 0] == pytest.approx(rolling, abs=2e-4)


SUPPORT = (
    "&surface name = 'dome', body = 'ground', shape = 'sphere', radius = 0.5,"
    " material = 'steel' /\n"
)


def on_dome(angle, **more):
    """A ball on the dome, off its top by an angle."""
    reach = 0.52
    return ball(position=(reach * math.sin(angle), 0, reach * math.cos(angle)), **more) + SUPPORT


@pytest.mark.parametrize("rolls", [False, True])
@pytest.mark.parametrize("method", ["explicit8", "cvode_bdf"])
def test_ball_leaves_a_dome_where_it_must(simulate, rolls, method):
    if rolls and method == "explicit8":
        pytest.skip("friction that sticks is stiff")
    start = 0.2
    keys = (
        ", friction = 'coulomb', friction_coefficient = 1000, regularization_velocity = 1e-3"
        if rolls
        else ""
    )
    text = on_dome(start) + contact("ball_skin", "dome", keys)
    run = simulate(scene(text, t_end=1.0, method=method, interval=1e-4))
    assert run.events[0][1] == "lift"
    # m v^2/(R + r) = m g cos: cos = (2/3) cos0 sliding, (10/17) cos0 rolling.
    t = run.events[0][0]
    x = np.interp(t, run.time, run.position[:, 0, 0])
    z = np.interp(t, run.time, run.position[:, 0, 2])
    share = 10 / 17 if rolls else 2 / 3
    assert z / math.hypot(x, z) == pytest.approx(
        share * math.cos(start), rel=2e-4 if rolls else 1e-6
    )
    before = run.time < t
    assert (run.normal_force[before, 0] > 0).all()
    assert run.normal_force[~before, 0].max() == 0.0
    assert np.abs(run.gap[before, 0]).max() < 1e-10
    assert run.residual() < 1e-7


def test_ball_swings_in_a_bowl(simulate):
    # A frictionless ball in a bowl is a pendulum of length R - r; large swing: K(sin^2(x/2)).
    length, swing = 0.48, 1.0
    place = (length * math.sin(swing), 0, -length * math.cos(swing))
    text = (
        ball(position=place)
        + "&surface name = 'bowl', body = 'ground', shape = 'sphere', side = 'inside',"
        " radius = 0.5, material = 'steel' /\n" + contact("ball_skin", "bowl")
    )
    m = math.sin(swing / 2) ** 2
    a, b = 1.0, math.sqrt(1 - m)
    for _ in range(8):
        a, b = (a + b) / 2, math.sqrt(a * b)
    period = 4 * math.sqrt(length / GRAVITY) * math.pi / (2 * a)
    run = simulate(scene(text, t_end=10 * period, interval=period / 50))
    assert run.events == []
    assert run.position[-1, 0] == pytest.approx(place, abs=1e-6)
    cosine = -run.position[:, 0, 2] / length
    normal = 0.05 * GRAVITY * (3 * cosine - 2 * math.cos(swing))
    assert run.normal_force[:, 0] == pytest.approx(normal, rel=1e-7)
    assert np.abs(run.gap[:, 0]).max() < 1e-10
    assert run.residual() < 1e-8


def test_frictionless_top_keeps_its_integrals(simulate):
    # Lagrange's top on a smooth floor: energy, both angular momenta, and the normal force
    # m (g + z''), with z'' from the potential of the nutation.
    text = (
        "&body name = 'top', mass = 0.1, inertia = 4e-5, 4e-5, 3e-5, position = 0, 0,"
        f" {0.005 + 0.03 * math.cos(0.4)!r}, axis = 1, 0, 0, angle = 0.4, spin = 0, 0, 150 /\n"
        "&surface name = 'tip', body = 'top', shape = 'sphere', centre = 0, 0, -0.03,"
        " radius = 0.005, material = 'steel' /\n" + FLOOR + contact("tip")
    )
    run = simulate(scene(text, t_end=4.0, interval=2e-3))
    assert run.events == []
    spin = run.body_rates()[:, 2]
    vertical = run.angular_momentum()[:, 2]
    assert np.abs(spin / spin[0] - 1).max() < 1e-10
    assert np.abs(vertical / vertical[0] - 1).max() < 1e-8
    assert run.residual() < 1e-8
    assert np.abs(run.gap[:, 0]).max() < 1e-11
    theta, rates = run.theta(), run.angular_velocity[:, 0]
    side = np.cross([0, 0, 1.0], run.axis())
    rate = np.einsum("ti,ti->t", rates, side) / np.sin(theta)
    precession = (vertical - 3e-5 * spin * np.cos(theta)) / (4e-5 * np.sin(theta) ** 2)
    turn = 4e-5 * precession**2 * np.cos(theta) - 3e-5 * spin * precession
    c, s = 0.03 * np.cos(theta), 0.03 * np.sin(theta)
    # A theta'' = turn sin + N l sin, z = r + l cos.
    normal = 0.1 * (GRAVITY - c * rate**2 - s * turn * np.sin(theta) / 4e-5)
    normal /= 1 + 0.1 * s**2 / 4e-5
    assert run.normal_force[:, 0] == pytest.approx(normal, rel=1e-6)


def test_ellipsoid_rocks_and_spins_on_the_floor(simulate):
    # Curvatures change: no friction, so that both horizontal momenta and L_z stay.
    text = (
        "&body name = 'egg', mass = 0.3, inertia = 2e-4, 3e-4, 4e-4, position = 0, 0, 0.02,"
        " velocity = 0.1, -0.2, 0, spin = 2, 3, 20 /\n"
        "&surface name = 'shell', body = 'egg', shape = 'ellipsoid', semi_axes = 0.05, 0.03,"
        " 0.02, material = 'steel' /\n" + FLOOR + contact("shell")
    )
    run = simulate(scene(text, t_end=1.0))
    closed = run.normal_force[:, 0] > 0
    assert closed.sum() > 50
    vertical = run.angular_momentum()[:, 2]
    assert np.abs(vertical / vertical[0] - 1).max() < 1e-8
    assert np.abs(run.velocity[:, 0, :2] - run.velocity[0, 0, :2]).max() < 1e-12
    assert np.abs(run.gap[closed, 0]).max() < 1e-10
    assert run.residual() < 1e-8


def test_prescribed_floor_lifts_a_ball(simulate):
    # A floor that accelerates up by 2 m/s2 for 1 s, then moves on evenly.
    text = (
        ball() + "&body name = 'lift', motion = 'prescribed', velocity = 0, 0, 0, final_velocity ="
        " 0, 0, 2.0, ramp_duration = 1.0 /\n"
        "&surface name = 'plate', body = 'lift', shape = 'plane', material = 'steel' /\n"
        + contact("ball_skin", "plate")
    )
    run = simulate(scene(text, t_end=2.0))
    early = run.time < 0.99
    assert run.normal_force[early, 0] == pytest.approx(0.05 * (GRAVITY + 2.0), rel=1e-9)
    assert run.normal_force[-1, 0] == pytest.approx(0.05 * GRAVITY, rel=1e-9)
    # No event marks the end of the ramp, so that the floor itself has an error of its step.
    assert run.velocity[-1, 0, 2] == pytest.approx(run.velocity[-1, 1, 2], rel=1e-10)
    assert run.velocity[-1, 0, 2] == pytest.approx(2.0, rel=1e-7)
    assert abs(run.energy_error).max() < 1e-9


def rod(keys="", points=(-0.1, 0.1)):
    """A rod that lies on small spheres."""
    ends = "".join(
        f"&surface name = 'foot{i}', body = 'rod', shape = 'sphere', centre = {x!r}, 0, 0,"
        " radius = 0.01, material = 'steel' /\n"
        for i, x in enumerate(points)
    )
    return (
        "&body name = 'rod', mass = 0.2, inertia = 1e-5, 7e-4, 7e-4, position = 0, 0, 0.01 /\n"
        + ends
        + FLOOR
        + "".join(contact(f"foot{i}", keys=keys) for i in range(len(points)))
    )


def test_two_supports_share_the_weight(simulate):
    run = simulate(scene(rod(points=(-0.05, 0.15)), t_end=0.5))
    weight = 0.2 * GRAVITY
    assert run.normal_force[:, 0] == pytest.approx(weight * 0.75, rel=1e-9)
    assert run.normal_force[:, 1] == pytest.approx(weight * 0.25, rel=1e-9)
    assert run.events == []


def test_one_of_two_supports_lets_go(simulate):
    # Both feet on one side of the centre of mass: the far one opens at once.
    run = simulate(scene(rod(points=(0.05, 0.15)), t_end=0.02))
    assert run.normal_force[0, 0] == pytest.approx(0.2 * GRAVITY / (1 + 0.2 * 0.05**2 / 7e-4))
    assert run.normal_force[0, 1] == 0.0
    assert run.gap[-1, 1] > 1e-5


def test_rod_falls_flat_and_comes_to_rest(simulate):
    text = rod(keys=", restitution = 0.5").replace(
        "0, 0, 0.01 /", "0, 0, 0.03, axis = 0, 1, 0, angle = 0.05 /"
    )
    run = simulate(scene(text, t_end=2.0))
    assert run.normal_force[-1] == pytest.approx(0.1 * GRAVITY, rel=1e-6)
    assert np.abs(run.gap[-1]).max() < 1e-10
    assert run.residual() < 1e-8
    assert len(run.events) < 200


def test_rigid_and_compliant_contacts_mix(simulate):
    # One foot rigid, one of Hertz: the second settles a little, the first carries its share.
    text = rod(keys=", restitution = 0")
    text = text.replace(
        "'foot1', 'floor', normal = 'rigid', restitution = 0",
        "'foot1', 'floor', damping = 'hunt_crossley', damping_coefficient = 100",
    )
    assert "hunt_crossley" in text
    run = simulate(scene(text, t_end=0.5, method="cvode_bdf"))
    assert run.normal_force[-1] == pytest.approx(0.1 * GRAVITY, rel=1e-3)
    assert abs(run.gap[-1, 0]) < 1e-11
    assert -1e-6 < run.gap[-1, 1] < 0
    assert run.residual() < 1e-8


# ---- Contacts that act together -----------------------------------------------------------------

HARD = Path(__file__).resolve().parents[1] / "hard"


@pytest.mark.sample(4)
@pytest.mark.parametrize("name", ["three_legs", "stool", "table", "slow_legs"])
@pytest.mark.parametrize("method", ["cvode_bdf", "auto"])
def test_legs_neither_pull_nor_sink(simulate, tmp_path, name, method):
    # Scenes in which one contact at a time was decided on: legs pulled by up to 15 % of the weight,
    # with friction that drove, one sank by 81 mm, and one scene was refused as a paradox.
    simulate(HARD / f"rigid_{name}.nml", f"integrator.method = '{method}'")
    wrong, _ = judge(tmp_path / "out.h5")
    assert wrong == []


def test_a_table_whose_legs_land_within_rounding(simulate, tmp_path):
    for method in ("explicit8", "cvode_adams"):
        for e in (0.0, 0.3, 0.5, 0.9):
            sets = [f"integrator.method = '{method}'", f"contact.restitution = {e}"]
            simulate(HARD / "rigid_table.nml", *sets)
            wrong, _ = judge(tmp_path / "out.h5")
            assert wrong == [], (method, e)


def shares(points, weight):
    """Normal forces k (c + t x)^(3/2) of supports at x that balance a weight at 0."""
    x = np.array(points)
    c, t = 1.0, 0.0
    for _ in range(50):
        d = c + t * x
        n, slope = d**1.5, 1.5 * np.sqrt(d)
        matrix = [[slope.sum(), (slope * x).sum()], [(slope * x).sum(), (slope * x**2).sum()]]
        change = np.linalg.solve(matrix, [1.0 - n.sum(), -(n * x).sum()])
        c, t = c + change[0], t + change[1]
    return weight * n


@pytest.mark.parametrize("method", ["explicit8", "cvode_bdf"])
def test_supports_more_than_needed_share_as_their_compliance_does(simulate, method):
    points = (-0.1, -0.03, 0.05, 0.1)
    run = simulate(scene(rod(points=points), t_end=0.5, method=method))
    expected = shares(points, 0.2 * GRAVITY)
    assert run.normal_force[-1] == pytest.approx(expected, rel=1e-6)
    assert np.abs(run.gap).max() < 1e-11
    assert run.events == []


def test_rigid_supports_are_the_limit_of_compliant_ones(simulate):
    # A table on four legs, its mass off the middle: without the compliance nothing says how they
    # share its weight.
    legs = [(-0.12, -0.05), (-0.12, 0.06), (0.08, -0.05), (0.08, 0.06)]
    text = (
        "&body name = 'table', mass = 2.0, inertia = 0.01, 0.015, 0.02, position = 0, 0, 0.05 /\n"
    )
    for i, (x, y) in enumerate(legs):
        text += (
            f"&surface name = 'leg{i}', body = 'table', shape = 'sphere', centre = {x}, {y}, -0.04,"
            " radius = 0.01, material = 'steel' /\n"
        )
    text += FLOOR
    rigid = "".join(contact(f"leg{i}") for i in range(4))
    soft = rigid.replace("'rigid'", "'hertz', damping = 'hunt_crossley', damping_coefficient = 300")
    settled = simulate(scene(text + soft, t_end=2.0, method="cvode_bdf")).normal_force[-1]
    run = simulate(scene(text + rigid, t_end=0.1))
    assert run.normal_force[-1] == pytest.approx(settled, rel=1e-4)
    assert run.normal_force.sum(axis=1) == pytest.approx(2.0 * GRAVITY, rel=1e-9)
    # The middle two of these are not equal, as they would be on rigid ground by any symmetry.
    assert np.ptp(settled) > 1.0


def test_a_stack_of_tables_slides_apart(simulate, tmp_path):
    # Twelve contacts of three bodies, the uppermost one sliding.
    text = ""
    under = "floor"
    for i in range(3):
        slide = ", velocity = 0.5, 0.2, 0" if i == 2 else ""
        text += (
            f"&body name = 'plate{i}', mass = 1, inertia = 2e-3, 2e-3, 4e-3,"
            f" position = 0, 0, {0.03 + 0.04 * i!r}{slide} /\n"
            f"&surface name = 'top{i}', body = 'plate{i}', shape = 'plane', centre = 0, 0, 0.01,"
            " material = 'steel' /\n"
        )
        for k, (x, y) in enumerate(((-1, -1), (-1, 1), (1, -1), (1, 1))):
            text += (
                f"&surface name = 'foot{i}{k}', body = 'plate{i}', shape = 'sphere',"
                f" centre = {0.08 * x}, {0.06 * y}, -0.02, radius = 0.01, material = 'steel' /\n"
            )
            keys = ", friction = 'contensou_exact', friction_coefficient = 0.2"
            text += contact(f"foot{i}{k}", under, keys)
        under = f"top{i}"
    run = simulate(scene(FLOOR + text, t_end=0.4, method="cvode_bdf", rtol=1e-8, interval=1e-3))
    wrong, _ = judge(tmp_path / "out.h5")
    assert wrong == []
    for i in range(3):
        load = run.normal_force[:, 4 * i : 4 * i + 4].sum(axis=1)
        assert load == pytest.approx((3 - i) * GRAVITY, rel=1e-6)


@pytest.mark.parametrize("method", ["explicit8", "cvode_adams"])
def test_a_method_that_friction_stops_hands_over(run, tmp_path, method):
    # A stool slides to rest, where explicit8 and the method of Adams would need 1e9 steps.
    text = (
        "&body name = 'stool', mass = 1, inertia = 3*0.01, position = 0, 0, 0.04,"
        " velocity = 0.2, 0.1, 0 /\n"
    )
    for k, (x, y) in enumerate(((-0.05, -0.03), (0.05, -0.03), (0.0, 0.06))):
        text += (
            f"&surface name = 'foot{k}', body = 'stool', shape = 'sphere', radius = 0.01,"
            f" centre = {x}, {y}, -0.03, material = 'steel' /\n"
        )
        text += contact(
            f"foot{k}", "floor", ", friction = 'contensou_exact', friction_coefficient = 0.3"
        )
    text = scene(FLOOR + text, t_end=1.0, method=method, rtol=1e-8, interval=1e-2)
    (tmp_path / "scene.nml").write_text(text)
    done = run("run", "scene.nml")
    assert done.status == 0, done.err
    assert f"is too stiff for {method}" in done.out
    with h5py.File(tmp_path / "rigid.h5") as file:
        assert [name.decode() for name in file["integrator/method"]] == [method, "cvode_bdf"]
        since = file["integrator/method_since"][1]
        assert np.abs(file["trajectory/velocity"][-1]).max() < 1e-8
    # It slides for 0.223607/(0.3 g) s, and only then is it too stiff.
    assert 0.0759 < since < 0.09


# ---- What is refused ----------------------------------------------------------------------------


def test_friction_that_jams_is_named(fails):
    # Painleve: a slender rod pushed over the floor at a steep angle.
    angle = 0.9
    text = (
        "&body name = 'rod', mass = 0.2, inertia = 1e-5, 7e-4, 7e-4,"
        f" position = 0, 0, {0.01 + 0.1 * math.sin(angle)!r}, axis = 0, 1, 0, angle = {angle},"
        " velocity = 1.0, 0, 0 /\n"
        "&surface name = 'end', body = 'rod', shape = 'sphere', centre = 0.1, 0, 0,"
        " radius = 0.01, material = 'steel' /\n"
        + FLOOR
        + contact("end", keys=", friction = 'contensou_exact', friction_coefficient = 4.0")
    )
    err = fails(scene(text, t_end=0.5))
    assert "Painleve" in err
    assert "'end_floor'" in err


@pytest.mark.parametrize(
    ("keys", "position", "expected"),
    [
        ("", (0, 0, 0.0199), "overlap by 1.000E-04 m"),
        (", damping = 'tsuji', restitution = 0.5", (0, 0, 0.02), "'tsuji' has no meaning"),
        (", damping = 'viscous', damping_coefficient = 1", (0, 0, 0.02), "'viscous' has no"),
        (", ellipse = 'power'", (0, 0, 0.02), "'ellipse' has no meaning"),
        (", damping_coefficient = 1", (0, 0, 0.02), "without 'damping'"),
        (", restitution = 1.5", (0, 0, 0.02), "'restitution' is out of range"),
        (", damping = 'hunt_crossley', restitution = 0", (0, 0, 0.02), "must be positive"),
    ],
)
def test_keys_without_meaning_are_mistakes(fails, keys, position, expected):
    text = ball(position=position) + FLOOR + contact(keys=keys)
    assert expected in fails(scene(text, t_end=0.1), status=2)


def test_restitution_of_nothing_needs_a_rigid_contact(fails):
    text = ball() + FLOOR + contact(keys=", damping = 'tsuji', restitution = 0")
    text = text.replace("'rigid'", "'hertz'")
    assert "must be positive" in fails(scene(text, t_end=0.1), status=2)


def test_check_and_models_speak_of_it(run, inputs):
    done = run("check", inputs / "tippe_top_rigid.nml")
    assert done.status == 0
    assert "ball_floor: sphere on plane, rigid, hunt_crossley" in done.out
    assert "right-hand sides to t = " in done.out
    assert "N from the equations of motion" in run("models", "rigid").out
