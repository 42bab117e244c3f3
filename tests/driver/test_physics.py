"""Runs of the executable against mechanics: reference data, conservation laws, closed forms."""

from __future__ import annotations

import csv
import math
from itertools import pairwise

import numpy as np
import pytest

METHODS = ("cvode_bdf", "cvode_adams", "explicit8")

# A solid ball of beech on a floor of the same.
MASS, RADIUS, YOUNG, POISSON, GRAVITY = 0.05, 0.02, 9.1e9, 0.3, 9.81
INERTIA = 0.4 * MASS * RADIUS**2
MODULUS = YOUNG / (2.0 * (1.0 - POISSON**2))
STIFFNESS = 4.0 / 3.0 * MODULUS * math.sqrt(RADIUS)
OVERLAP = (MASS * GRAVITY / STIFFNESS) ** (2.0 / 3.0)  # of the ball at rest

BALL = """\
&scene gravity = 0, 0, {gravity}, t_end = {t_end} /
&material name = 'wood', young = 9.1e9, poisson = 0.3 /
&body name = 'ball', mass = {mass}, inertia = {inertia}, {inertia}, {inertia},
   position = 0, 0, {height}, velocity = {velocity}, spin = {spin} /
&surface name = 'skin', body = 'ball', shape = 'sphere', radius = {radius}, material = 'wood' /
&surface name = 'floor', body = 'ground', shape = 'plane', material = 'wood' /
&contact name = 'skin_floor', surfaces = 'skin', 'floor' {contact} /
&integrator method = '{method}', rtol = {rtol} /
&output file = 'ball.h5', interval = {interval} /
"""


def ball(**settings):
    """A scene with the ball at rest on the floor, but for what is said."""
    values = {
        "gravity": -GRAVITY,
        "mass": MASS,
        "radius": RADIUS,
        "inertia": INERTIA,
        "height": RADIUS - OVERLAP,
        "velocity": "0, 0, 0",
        "spin": "0, 0, 0",
        "contact": "",
        "method": "cvode_bdf",
        "rtol": 1e-9,
        "t_end": 1.0,
    } | settings
    values.setdefault("interval", values["t_end"] / 100)
    assert values.keys() >= settings.keys()
    return BALL.format(**{k: v if isinstance(v, str) else repr(v) for k, v in values.items()})


# ---- The Tippe-Top against independent data ----------------------------------------------------

SCENES = {"simplified": "tippe_top_simplified.nml", "exact": "tippe_top.nml"}
KINDS = {"touch1": "ball_floor", "lift1": "ball_floor", "touch2": "stem_floor"}
KINDS["lift2"] = "stem_floor"


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("model", SCENES)
def test_tippe_top_meets_the_reference(simulate, inputs, reference, model, method, build_kind):
    # The reference ends at 8 s; a slow build stops when the top stands on its stem.
    t_end = 2.3 if build_kind == "checked" else 8.0
    top = simulate(
        inputs / SCENES[model],
        f"integrator.method = '{method}'",
        "integrator.rtol = 1e-8",
        "output.interval = 0.01",
        f"scene.t_end = {t_end}",
    )
    with open(reference / f"tippe_top_{model}_events.csv", newline="") as file:
        expected = [(float(row["t"]), row["type"]) for row in csv.DictReader(file)]
    table = np.genfromtxt(reference / f"tippe_top_{model}.csv", delimiter=",", names=True)
    table = table[: len(top.time)]
    assert len(top.time) == round(t_end / 0.01) + 1
    np.testing.assert_allclose(top.time, table["t"], rtol=0, atol=1e-12)

    assert [(kind, contact) for _, kind, contact in top.events] == [
        (name[:-1], KINDS[name]) for _, name in expected
    ]
    first_touch = expected[0][0]
    left = max(t for t, name in expected if name == "lift1")
    for (t, name), event in zip(expected, top.events, strict=True):
        tolerance = 5e-6 if t < first_touch + 1e-4 else 2e-5
        assert event[0] == pytest.approx(t, abs=tolerance), name

    assert top.residual() <= 1e-8
    assert top.summary["energy_error_relative"] <= 1e-8
    columns = {
        "theta": top.theta(),
        "gap1": top.gap[:, 0],
        "gap2": top.gap[:, 1],
        "wz": top.angular_velocity[:, 0, 2],
        "w3": top.body_rates()[:, 2],
        "z": top.position[:, 0, 2],
        "E_kin": top.energy_kinetic,
        "E_pot": top.energy_potential,
        "E_el": top.energy_elastic,
        "W_fric": top.work_friction,
        "W_visc": top.work_damping,
    }
    # An error of theta takes everything else along, in proportion: its tolerance in radians is the
    # relative tolerance of the other columns, against the largest value that they have in the span.
    # For the gap of the closed contact that is 1e-5 of its overlap of 0.2 um.
    for span, tolerance in ((table["t"] < first_touch, 1e-5), (table["t"] >= left + 0.1, 1e-4)):
        assert span.any()
        for name, column in columns.items():
            scale = 1.0 if name == "theta" else np.abs(table[name][span]).max()
            error = np.abs(column - table[name])[span].max()
            assert error <= tolerance * scale, (name, error, tolerance * scale)


def test_first_touch_in_the_summary_line(run, inputs, reference):
    result = run("run", inputs / "tippe_top.nml", "--set", "scene.t_end = 1.745")
    assert result.status == 0
    line = next(line for line in result.out.splitlines() if "first touch" in line)
    assert float(line.split("first touch")[1].split()[0]) == pytest.approx(1.743582928, abs=5e-6)
    assert "stem_floor" in line


SHIPPED = (
    "tippe_top",
    "tippe_top_simplified",
    "tippe_top_pade11",
    "tippe_top_pade22",
    "tippe_top_rigid",
)


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_scenes_close_their_energy_balance(simulate, inputs, name, slow_build):
    assert {path.stem for path in inputs.glob("tippe_top*.nml")} == set(SHIPPED)
    t_end = 0.5 if slow_build and name != "tippe_top" else 8.0
    top = simulate(
        inputs / f"{name}.nml",
        "integrator.rtol = 1e-9",
        "output.interval = 0.01",
        f"scene.t_end = {t_end}",
    )
    assert top.time[-1] == t_end
    assert top.residual() <= 1e-8
    energy = top.energy()
    np.testing.assert_allclose(top.energy_error, energy - energy[0], rtol=0, atol=1e-17)
    assert np.abs(np.linalg.norm(top.quaternion, axis=2) - 1.0).max() <= 1e-12
    # What is lost never comes back.
    for work in (top.work_friction, top.work_damping):
        assert np.diff(work).min() >= -1e-9 * energy[0]
    assert top.normal_force.min() >= 0.0


# ---- Conservation laws -------------------------------------------------------------------------


@pytest.mark.parametrize("method", METHODS)
def test_without_losses_energy_and_angular_momenta_last(simulate, inputs, method, slow_build):
    # Without friction the force on the top is vertical and in the plane of its axis, so that the
    # angular momenta about the vertical through the centre and about the axis do not change.
    top = simulate(
        inputs / "tippe_top.nml",
        *(f"{contact}.friction = 'none'" for contact in ("ball_floor", "stem_floor")),
        *(f"{contact}.damping = 'none'" for contact in ("ball_floor", "stem_floor")),
        f"integrator.method = '{method}'",
        "integrator.rtol = 1e-9",
        f"scene.t_end = {0.2 if slow_build else 1.0}",
        "top.angle = 0.8",
        "top.position = 0, 0, 0.01301",  # 0.1 mm above the floor
    )
    assert not top.work_friction.any()
    assert not top.work_damping.any()
    assert not top.friction_force.any()
    assert len(top.events) > 10  # it bounces, and each impact adds a local error or two
    assert top.residual() <= 3e-7
    momentum = top.angular_momentum()
    for component in (momentum[:, 2], np.einsum("ti,ti->t", momentum, top.axis())):
        assert np.abs(component / component[0] - 1.0).max() <= 1e-7
    # The horizontal momentum stays zero.
    assert np.abs(top.velocity[:, 0, :2]).max() <= 1e-12


BODY = """\
&scene {scene} /
&body name = 'stone', mass = 0.3, inertia = 1.0e-4, 2.0e-4, 2.8e-4,
   position = 1, 2, 3, axis = 1, 2, 3, angle = 0.7, velocity = 3, -2, 5, spin = {spin} /
&integrator method = '{method}', rtol = {rtol} /
&output interval = 0.01 /
"""


@pytest.mark.parametrize("method", METHODS)
def test_free_flight_is_a_parabola(simulate, method):
    stone = simulate(
        BODY.format(
            scene="gravity = 0.4, 0, -9.81, t_end = 1", spin="0, 0, 0", method=method, rtol=1e-8
        )
    )
    t = stone.time[:, None]
    gravity = np.array([0.4, 0.0, -9.81])
    velocity = np.array([3.0, -2.0, 5.0])
    # A multistep method has no error on a parabola; what is left is rounding.
    position = np.array([1.0, 2.0, 3.0]) + velocity * t + gravity * t**2 / 2
    np.testing.assert_allclose(stone.position[:, 0], position, rtol=0, atol=1e-11)
    np.testing.assert_allclose(stone.velocity[:, 0], velocity + gravity * t, rtol=0, atol=1e-11)
    assert stone.residual() <= 1e-12
    assert stone.events == []
    assert np.abs(stone.quaternion - stone.quaternion[0]).max() <= 1e-15


@pytest.mark.parametrize("method", METHODS)
def test_free_rotation_keeps_energy_and_angular_momentum(simulate, method):
    # About the middle axis, which is unstable: the stone turns over several times.
    stone = simulate(
        BODY.format(scene="t_end = 3", spin="0.01, 20, 0.02", method=method, rtol=1e-10)
    )
    rates = stone.body_rates()
    assert rates[:, 1].min() < -19.0
    assert rates[:, 1].max() > 19.0
    assert stone.residual() <= 1e-8
    momentum = stone.angular_momentum()
    change = np.linalg.norm(momentum - momentum[0], axis=1) / np.linalg.norm(momentum[0])
    assert change.max() <= 1e-7
    np.testing.assert_allclose(stone.velocity[:, 0], [[3.0, -2.0, 5.0]] * len(stone.time))
    assert np.abs(np.linalg.norm(stone.quaternion, axis=2) - 1.0).max() <= 1e-12


@pytest.mark.parametrize("friction", ["none", "coulomb", "contensou_simplified", "contensou_exact"])
def test_colliding_bodies_keep_their_momenta(simulate, friction):
    slide = f"friction = '{friction}'"
    if friction != "none":
        slide += ", friction_coefficient = 0.4"
    if friction == "coulomb":
        slide += ", regularization_velocity = 1e-3"
    pair = simulate(f"""\
&scene t_end = 4e-3 /
&material name = 'wood', young = 9.1e9, poisson = 0.3 /
&material name = 'steel', young = 2.1e11, poisson = 0.29 /
&body name = 'ball', mass = 0.05, inertia = 3*8.0e-6, position = 0.01, -0.02, 0.0205,
   velocity = 0.3, 0.1, -1, spin = 10, -20, 150 /
&body name = 'slab', mass = 0.2, inertia = 1.0e-4, 2.0e-4, 2.5e-4, axis = 0, 1, 0, angle = 0.1,
   velocity = 0, 0.2, 0.1, spin = 1, 2, -3 /
&surface name = 'skin', body = 'ball', shape = 'sphere', radius = 0.02, material = 'steel' /
&surface name = 'top', body = 'slab', shape = 'plane', centre = 0, 0, -0.001, material = 'wood' /
&contact name = 'hit', surfaces = 'skin', 'top', damping = 'hunt_crossley',
   damping_coefficient = 0.2, {slide} /
&integrator rtol = 1e-10 /
&output interval = 1e-5 /
""")
    assert [kind for _, kind, _ in pair.events] == ["touch", "lift"]
    assert pair.normal_force.max() > 10.0
    assert (pair.work_friction[-1] > 1e-4) == (friction != "none")
    assert pair.work_damping[-1] > 1e-4
    linear = np.einsum("b,tbi->ti", pair.mass, pair.velocity)
    angular = sum(
        pair.mass[b] * np.cross(pair.position[:, b], pair.velocity[:, b]) + pair.angular_momentum(b)
        for b in range(2)
    )
    # The momenta that the impact exchanges are the measure.
    exchanged = pair.mass[0] * np.linalg.norm(pair.velocity[-1, 0] - pair.velocity[0, 0])
    assert exchanged > 0.01
    assert np.abs(linear - linear[0]).max() <= 1e-8 * exchanged
    assert np.abs(angular - angular[0]).max() <= 1e-8 * exchanged * 0.03
    assert pair.residual() <= 1e-8


def test_order_of_the_surfaces_changes_signs_only(simulate, inputs, tmp_path):
    text = (inputs / "tippe_top.nml").read_text()
    options = ("scene.t_end = 0.1", "output.interval = 1e-3", "integrator.rtol = 1e-10")
    one = simulate(text, *options)
    swapped = text.replace("'ball', 'floor'", "'floor', 'ball'")
    swapped = swapped.replace("'stem', 'floor'", "'floor', 'stem'")
    assert swapped.count("'floor', '") == 2
    other = simulate(swapped, *options)
    for name, column in one.columns.items():
        turns = ("contact_normal", "friction_force", "slip_velocity")
        sign = -1.0 if name in turns else 1.0
        # Rounding alone tells them apart; the motion is steady so early.
        tolerance = 1e-7 * max(np.abs(column).max(), 1e-12)
        np.testing.assert_allclose(
            sign * other.columns[name], column, rtol=0, atol=tolerance, err_msg=name
        )
    assert np.abs(one.friction_force).max() > 1e-3
    # Friction on body B is against the slip of B.
    along = np.einsum("tci,tci->tc", one.friction_force, one.slip_velocity)
    assert along.max() <= 0.0
    assert along.min() < 0.0


# ---- Impacts -----------------------------------------------------------------------------------


def drop(speed, contact="", rtol=1e-10, method="cvode_bdf"):
    """A ball that falls onto the floor with a speed, without gravity."""
    return ball(
        gravity=0.0,
        height=RADIUS + 1e-4,
        velocity=f"0, 0, {-speed}",
        contact=contact,
        rtol=rtol,
        t_end=2e-4 / speed + 2e-3,
        method=method,
    )


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("speed", [0.01, 0.3, 2.0])
def test_impact_lasts_as_hertz_says(simulate, speed, method):
    hit = simulate(drop(speed, method=method))
    (touch, lift) = hit.events
    assert (touch[1], lift[1]) == ("touch", "lift")
    assert touch[0] == pytest.approx(1e-4 / speed, rel=1e-9)
    duration = 3.218065 * (MASS**2 / (STIFFNESS**2 * speed)) ** 0.2
    assert lift[0] - touch[0] == pytest.approx(duration, rel=1e-6)
    assert hit.velocity[-1, 0, 2] == pytest.approx(speed, rel=1e-7)
    assert hit.residual() <= 1e-7


@pytest.mark.parametrize("speed", [0.05, 1.0])
@pytest.mark.parametrize("restitution", [0.2, 0.5, 0.9, 1.0])
def test_hunt_crossley_returns_the_restitution(simulate, speed, restitution):
    hit = simulate(drop(speed, f", damping = 'hunt_crossley', restitution = {restitution}"))
    assert [kind for _, kind, _ in hit.events] == ["touch", "lift"]
    assert hit.velocity[-1, 0, 2] / speed == pytest.approx(restitution, rel=1e-6)
    assert hit.residual() <= 1e-7
    lost = 0.5 * MASS * speed**2 * (1.0 - restitution**2)
    assert hit.work_damping[-1] == pytest.approx(lost, rel=1e-6, abs=1e-8 * MASS * speed**2)


@pytest.mark.parametrize("speed", [0.05, 1.0])
@pytest.mark.parametrize("restitution", [0.2, 0.5, 0.9])
def test_tsuji_returns_each_speed_alike(simulate, speed, restitution):
    # With d^(1/4) dt for dt Tsuji's impact is that of a linear spring and damper, in which the
    # restitution e belongs to a force that pulls at the end. Here no contact pulls: the ball flies
    # on from where the force comes to zero, which is earlier and so leaves it faster.
    hit = simulate(drop(speed, f", damping = 'tsuji', restitution = {restitution}"))
    decay = -math.log(restitution) / math.pi  # over the frequency
    early = math.atan2(2.0 * decay, 1.0 - decay**2)
    returned = math.exp(-decay * (math.pi - early))
    assert hit.velocity[-1, 0, 2] / speed == pytest.approx(returned, rel=1e-5)
    assert hit.normal_force.min() >= 0.0
    assert hit.residual() <= 1e-7


def test_bouncing_ball_keeps_its_heights(simulate):
    # Each bounce returns e of the speed: the times between bounces fall by e.
    bounce = simulate(
        ball(
            height=RADIUS + 0.05,
            contact=", damping = 'hunt_crossley', restitution = 0.8",
            t_end=0.8,
            rtol=1e-9,
        )
    )
    touches = bounce.times("touch")
    lifts = bounce.times("lift")
    assert touches[0] == pytest.approx(math.sqrt(2 * 0.05 / GRAVITY), rel=1e-8)
    flights = [touch - lift for lift, touch in zip(lifts, touches[1:], strict=False)]
    assert len(flights) >= 4
    # Gravity while in contact (a few 1e-4 s) is all that the closed form leaves out.
    for one, two in pairwise(flights):
        assert two / one == pytest.approx(0.8, abs=5e-3)


@pytest.mark.parametrize("overlap", [1e-4, 1e-6, 1e-7, 1e-8])
@pytest.mark.parametrize("gravity", [0.0, -GRAVITY])
def test_a_pressed_ball_springs_off(simulate, overlap, gravity):
    # The lift-off comes in the first millisecond, at any speed.
    free = simulate(ball(gravity=gravity, height=RADIUS - overlap, t_end=5e-3))
    stored = 0.4 * STIFFNESS * overlap**2.5
    assert free.energy_elastic[0] == pytest.approx(stored, rel=1e-6)
    if gravity == 0.0:
        assert [kind for _, kind, _ in free.events] == ["lift"]
        assert free.velocity[-1, 0, 2] == pytest.approx(math.sqrt(2 * stored / MASS), rel=1e-5)


# ---- Friction ----------------------------------------------------------------------------------

EXACT = ", friction = 'contensou_exact', friction_coefficient = 0.3"


def test_a_ball_spins_down_as_the_torque_says(simulate):
    # T = (3 pi/16) f N a on a circular spot that only spins.
    w0 = 40.0
    a = math.sqrt(RADIUS * OVERLAP)
    stop = 32.0 / (15.0 * math.pi) * RADIUS**2 * w0 / (0.3 * GRAVITY * a)
    spun = simulate(ball(spin=f"0, 0, {w0}", contact=EXACT, t_end=0.99 * stop))
    assert spun.semi_axes[:, 0, 0] == pytest.approx(np.full(101, a), rel=1e-6)
    a = spun.semi_axes[-1, 0, 0]
    stop = 32.0 / (15.0 * math.pi) * RADIUS**2 * w0 / (0.3 * GRAVITY * a)
    expected = w0 * (1.0 - spun.time / stop)
    np.testing.assert_allclose(spun.angular_velocity[:, 0, 2], expected, rtol=0, atol=1e-6 * w0)
    # The floor, body B, spins with -w about the normal, which points down into it.
    np.testing.assert_allclose(spun.spin[:, 0], expected, rtol=0, atol=1e-6 * w0)
    lost = 0.5 * INERTIA * (w0**2 - spun.angular_velocity[-1, 0, 2] ** 2)
    assert spun.work_friction[-1] == pytest.approx(lost, rel=1e-7)


def test_a_spun_ball_comes_to_rest(simulate):
    w0 = 10.0
    a = math.sqrt(RADIUS * OVERLAP)
    stop = 32.0 / (15.0 * math.pi) * RADIUS**2 * w0 / (0.3 * GRAVITY * a)
    contact = EXACT + ", regularization_velocity = 1e-7"
    spun = simulate(ball(spin=f"0, 0, {w0}", contact=contact, t_end=1.5 * stop))
    late = spun.time > 1.1 * stop
    assert np.abs(spun.angular_velocity[late, 0, 2]).max() <= 1e-3 * w0
    assert spun.work_friction[-1] == pytest.approx(0.5 * INERTIA * w0**2, rel=1e-6)


@pytest.mark.parametrize("method", METHODS)
def test_a_sliding_ball_comes_to_roll(simulate, method):
    f, v0, delta = 0.3, 0.5, 1e-4
    roll = 2.0 * v0 / (7.0 * f * GRAVITY)
    contact = (
        f", friction = 'coulomb', friction_coefficient = {f}, regularization_velocity = {delta}"
    )
    ball_run = simulate(
        ball(velocity=f"{v0}, 0, 0", contact=contact, t_end=1.5 * roll, method=method)
    )
    t = ball_run.time
    vx, wy = ball_run.velocity[:, 0, 0], ball_run.angular_velocity[:, 0, 1]
    sliding = t < roll * (1.0 - 2.0 * delta / v0)
    np.testing.assert_allclose(vx[sliding], v0 - f * GRAVITY * t[sliding], rtol=0, atol=1e-6 * v0)
    np.testing.assert_allclose(
        RADIUS * wy[sliding], 2.5 * f * GRAVITY * t[sliding], rtol=0, atol=1e-6 * v0
    )
    # Below delta the slip dies with exp(-(7/2) f g t/delta), a microsecond here.
    rolling = t > roll + 1e-3
    np.testing.assert_allclose(vx[rolling], 5.0 / 7.0 * v0, rtol=1e-6)
    np.testing.assert_allclose(RADIUS * wy[rolling], 5.0 / 7.0 * v0, rtol=1e-6)
    assert ball_run.work_friction[-1] == pytest.approx(MASS * v0**2 / 7.0, rel=1e-6)
    assert not ball_run.friction_torque.any()


@pytest.mark.parametrize("model", ["contensou_simplified", "pade11", "pade22", "contensou_exact"])
def test_without_drilling_the_spin_stays(simulate, model):
    contact = f", friction = '{model}', friction_coefficient = 0.3"
    spinning = {"velocity": "0.05, 0, 0", "spin": "0, 0, 30", "t_end": 0.01}
    with_torque = simulate(ball(contact=contact, **spinning))
    without = simulate(ball(contact=contact + ", drilling = .false.", **spinning))
    assert np.abs(with_torque.friction_torque).min() > 0.0
    assert with_torque.angular_velocity[-1, 0, 2] < 30.0 - 1e-6
    assert not without.friction_torque.any()
    np.testing.assert_allclose(without.angular_velocity[:, 0, 2], 30.0, rtol=1e-8)
    # The spin still lowers the force against sliding, with or without its torque.
    weight = 0.3 * MASS * GRAVITY
    force = np.linalg.norm(without.friction_force[:, 0], axis=1)
    assert force[0] <= weight * (1.0 + 1e-6)
    np.testing.assert_allclose(force[0], np.linalg.norm(with_torque.friction_force[0, 0]))


def test_coulomb_does_not_see_the_spin(simulate):
    contact = ", friction = 'coulomb', friction_coefficient = 0.3, regularization_velocity = 1e-4"
    spun = simulate(ball(contact=contact, velocity="0.05, 0, 0", spin="0, 0, 30", t_end=0.004))
    assert not spun.friction_torque.any()
    np.testing.assert_allclose(spun.angular_velocity[:, 0, 2], 30.0, rtol=1e-8)
    force = np.linalg.norm(spun.friction_force[:, 0], axis=1)
    np.testing.assert_allclose(force, 0.3 * spun.normal_force[:, 0], rtol=1e-12)


# ---- Numerics ----------------------------------------------------------------------------------


@pytest.mark.parametrize("method", METHODS)
def test_the_error_falls_with_the_tolerance(simulate, inputs, method, slow_build):
    # With order 8 the errors are at the rounding of positions from 1e-7 on; and nothing falls in
    # order above 1e-3, where the friction near rest is not resolved.
    decades = range(3, 7) if method == "explicit8" else range(5, 11)
    if slow_build:
        decades = decades[::2]
    options = (
        f"integrator.method = '{method}'",
        f"scene.t_end = {0.1 if slow_build else 0.3}",
        "output.interval = 1e-2",
    )
    tight = simulate(inputs / "tippe_top.nml", *options, "integrator.rtol = 1e-12")
    errors = []
    for decade in decades:
        top = simulate(inputs / "tippe_top.nml", *options, f"integrator.rtol = 1e-{decade}")
        change = np.abs(top.angular_velocity - tight.angular_velocity).max() / 180.0
        errors.append(max(change, np.abs(top.theta() - tight.theta()).max()))
    slope = np.polyfit([-float(d) for d in decades], np.log10(errors), 1)[0]
    # A method of order k whose local error is held to tol has an error of tol^(k/(k + 1)).
    assert slope >= 2.0 / 3.0, errors
    assert errors[-1] <= 1e-7
    # Positions are held no finer than their rounding, which is where the errors end.
    rounding = 1e-10
    for loose, strict in pairwise(errors):
        assert strict < max(loose, rounding), errors


@pytest.mark.parametrize("model", ["coulomb", "contensou_exact", "contensou_simplified"])
def test_a_tiny_regularization_runs(simulate, inputs, model, slow_build):
    top = simulate(
        inputs / "tippe_top.nml",
        *(f"{contact}.friction = '{model}'" for contact in ("ball_floor", "stem_floor")),
        "ball_floor.regularization_velocity = 1e-6",
        "stem_floor.regularization_velocity = 1e-6",
        f"scene.t_end = {0.05 if slow_build else 0.5}",
    )
    assert top.residual() <= 1e-7
    # The friction force is bounded by f N, and falls short of it only below delta.
    force = np.linalg.norm(top.friction_force[:, 0], axis=1)
    assert (force <= 0.3 * top.normal_force[:, 0] * (1.0 + 1e-12)).all()


BLOCK = """
&scene title = 'three-footed block', gravity = {slope}, 0, -9.81, t_end = {t_end} /
&material name = 'steel', young = 2.1e11, poisson = 0.3 /
&body name = 'block', mass = 1.0, inertia = 2e-3, 2e-3, 3e-3, position = 0, 0, 0.03,
      velocity = 0.05, 0, 0, spin = 0, 0, 1 /
&surface name = 'f1', body = 'block', shape = 'sphere', centre = 0.05, 0, -0.02, radius = 0.01,
         material = 'steel' /
&surface name = 'f2', body = 'block', shape = 'sphere', centre = -0.03, 0.04, -0.02, radius = 0.01,
         material = 'steel' /
&surface name = 'f3', body = 'block', shape = 'sphere', centre = -0.03, -0.04, -0.02, radius = 0.01,
         material = 'steel' /
&surface name = 'floor', body = 'ground', shape = 'plane', normal = 0, 0, 1, material = 'steel' /
&contact name = 'c1', surfaces = 'f1', 'floor', damping = 'hunt_crossley', damping_coefficient = 10,
         friction = '{friction}', friction_coefficient = 0.2, regularization_velocity = {delta} /
&contact name = 'c2', surfaces = 'f2', 'floor', damping = 'hunt_crossley', damping_coefficient = 10,
         friction = '{friction}', friction_coefficient = 0.2, regularization_velocity = {delta} /
&contact name = 'c3', surfaces = 'f3', 'floor', damping = 'hunt_crossley', damping_coefficient = 10,
         friction = '{friction}', friction_coefficient = 0.2, regularization_velocity = {delta} /
&output file = 'block.h5', interval = 0.05 /
"""


@pytest.mark.parametrize(
    "friction", ["contensou_exact", "contensou_simplified", "pade22", "coulomb"]
)
def test_what_stops_stays(simulate, tmp_path, friction, slow_build):
    """Below the friction angle a block slides, spins, stops and stays, without regularisation."""
    t_end = 0.8 if slow_build else 3.0
    delta = 1e-9 if friction == "coulomb" else 0.0
    scene = tmp_path / "block.nml"
    scene.write_text(BLOCK.format(slope=0.9, t_end=t_end, friction=friction, delta=delta))
    block = simulate(scene)
    late = block.time > 0.45
    assert np.abs(block.velocity[late]).max() <= 1e-7
    assert np.abs(block.angular_velocity[late]).max() <= 1e-5
    rest = block.position[late]
    # It creeps with the velocity that the tolerance resolves, 1e-8 m/s.
    assert np.abs(rest - rest[0]).max() <= 1e-8 * t_end
    assert block.residual() <= 1e-8
    # At rest friction holds the block against the slope; the force is the one on the floor.
    held = block.friction_force[late].sum(axis=1)
    assert held[:, 0] == pytest.approx(0.9, rel=1e-3)


def test_what_is_too_steep_slides(simulate, tmp_path, slow_build):
    t_end = 0.4 if slow_build else 1.0
    scene = tmp_path / "block.nml"
    scene.write_text(BLOCK.format(slope=2.5, t_end=t_end, friction="contensou_exact", delta=0.0))
    block = simulate(scene)
    # As soon as the three feet slide the same way friction is f m g.
    half = len(block.time) // 2
    gain = block.velocity[-1, 0, 0] - block.velocity[half, 0, 0]
    expected = (2.5 - 0.2 * 9.81) * (block.time[-1] - block.time[half])
    assert gain == pytest.approx(expected, rel=1e-3)
