"""Tangential elasticity of rigid contacts, whose spot is that of Hertz at their normal force."""

import csv
import io

import numpy as np
import pytest

# A ball of steel on a plane of steel.
YOUNG, POISSON, RADIUS, MASS, GRAVITY = 2.1e11, 0.3, 0.0025, 5.105088e-4, 9.81
MODULUS = YOUNG / 2 / (1 + POISSON)
LOAD = MASS * GRAVITY
SEMI_AXIS = (3 * LOAD * RADIUS * (1 - POISSON**2) / (2 * YOUNG)) ** (1 / 3)
STIFFNESS = 4 * MODULUS * SEMI_AXIS / (2 - POISSON)
FRICTION = 0.3

BALL = """
&scene title = 'a ball' gravity = 0, 0, -9.81 t_end = {t_end} /
&material name = 'steel' young = 2.1e11 poisson = 0.3 /
&body name = 'ball' mass = 5.105088e-4 inertia = 3*1.276272e-9 position = 0, 0, {height}
   {motion} /
&surface name = 'skin' body = 'ball' material = 'steel' shape = 'sphere' radius = 0.0025 /
&surface name = 'floor' body = 'ground' material = 'steel' shape = 'plane' normal = 0, 0, 1 /
&contact name = 'c' surfaces = 'floor', 'skin' normal = 'rigid' friction = 'contensou_exact'
   friction_coefficient = 0.3 tangential = '{tangential}' {more} /
&integrator method = '{method}' rtol = {rtol} {steps} /
&output file = 'o.h5' interval = {interval} /
"""
USUAL = {
    "t_end": 1e-3,
    "height": RADIUS,
    "motion": "",
    "tangential": "elastic",
    "more": "",
    "method": "explicit8",
    "rtol": 1e-9,
    "steps": "",
    "interval": 1e-6,
}

TABLE = """
&scene title = 'a table' gravity = {gravity} t_end = {t_end} /
&material name = 'steel' young = 2.1e11 poisson = 0.3 /
&body name = 'table' mass = 0.5 inertia = 3*1.0e-4 position = 0, 0, {height} /
&surface name = 'floor' body = 'ground' material = 'steel' shape = 'plane' normal = 0, 0, 1 /
&defaults normal = 'rigid' friction = 'contensou_exact' friction_coefficient = {coefficient}
   tangential = '{tangential}' /
&integrator method = '{method}' rtol = 1e-8 /
&output file = 'o.h5' interval = {interval} /
"""
for number, place in enumerate(["0.02, 0.02", "-0.02, 0.02", "0.02, -0.02", "-0.02, -0.02"], 1):
    TABLE += f"""
&surface name = 's{number}' body = 'table' material = 'steel' shape = 'sphere' radius = 0.005
   centre = {place}, {{foot}} /
&contact name = 'c{number}' surfaces = 'floor', 's{number}' /
"""

TWO = """
&scene title = 'two balls' gravity = 0, 0, -9.81 t_end = 0.025 /
&material name = 'm' young = 1e8 poisson = 0.3 /
&body name = 'a' mass = 0.01 inertia = 3*4e-7 position = 0, 0, 0.0105 /
&body name = 'b' mass = 0.01 inertia = 3*4e-7 position = 1, 0, 0.011 /
&surface name = 'floor' body = 'ground' shape = 'plane' material = 'm' /
&surface name = 'sa' body = 'a' shape = 'sphere' radius = 0.01 material = 'm' /
&surface name = 'sb' body = 'b' shape = 'sphere' radius = 0.01 material = 'm' /
&defaults normal = 'rigid' restitution = 0.5 friction = 'contensou_exact'
   friction_coefficient = 0.6 tangential = '{tangential}' /
&contact name = 'ca' surfaces = 'floor', 'sa' /
&contact name = 'cb' surfaces = 'floor', 'sb' /
&integrator method = '{method}' rtol = 1e-8 /
&output file = 'o.h5' interval = 1e-4 /
"""


@pytest.fixture
def ball(simulate):
    """The rows of a ball, in which some of the usual is otherwise."""

    def rows_of(**changes):
        return simulate(BALL.format(**{**USUAL, **changes})).columns

    return rows_of


@pytest.fixture
def table(simulate):
    """The rows of a table with four feet."""

    def rows_of(height=0.02, **changes):
        usual = {"gravity": "1.5, 0.3, -9.81", "coefficient": FRICTION, "tangential": "elastic"}
        text = TABLE.format(**{**usual, **changes}, height=height, foot=0.005 - height)
        return simulate(text).columns

    return rows_of


@pytest.mark.parametrize("tangential", ["elastic", "spring"])
@pytest.mark.parametrize("method", ["explicit8", "auto", "cvode_bdf", "cvode_adams"])
def test_a_ball_in_flight_stays_there_as_another_one_lands(simulate, method, tangential):
    """Two balls that have but the floor in common: one lands while the other one bounces."""
    rows = simulate(TWO.format(method=method, tangential=tangential)).columns
    gap, load = rows["gap"], rows["normal_force"]
    assert np.abs(gap[load > 0]).max(initial=0.0) < 1e-12
    # Each falls and bounces as if it were alone.
    for ball, height in enumerate([0.5e-3, 1e-3]):
        speed = np.sqrt(2 * GRAVITY * height)
        time = rows["time"] - speed / GRAVITY
        flight = (time > 0) & (time < speed / GRAVITY)
        expected = 0.5 * speed * time[flight] - GRAVITY / 2 * time[flight] ** 2
        assert gap[flight, ball] == pytest.approx(expected, abs=1e-10)
    assert np.abs(rows["energy_error"]).max() < 1e-8 * rows["energy_potential"][0]


@pytest.mark.parametrize("method", ["explicit8", "cvode_bdf", "cvode_adams"])
def test_a_ball_rings_on_the_tangential_stiffness(ball, method):
    rows = ball(motion="velocity = 1e-6, 0, 0", method=method, rtol=1e-10, interval=1e-5)
    force, time = rows["friction_force"][:, 0, 0], rows["time"]
    assert rows["normal_force"][:, 0] == pytest.approx(LOAD, rel=1e-12)
    assert rows["semi_axes"][:, 0, 0] == pytest.approx(SEMI_AXIS, rel=1e-6)
    at = np.flatnonzero(force[1:-1] * force[2:] < 0) + 1
    zeros = time[at] - force[at] * (time[at + 1] - time[at]) / (force[at + 1] - force[at])
    assert len(zeros) > 20
    rate = np.pi * (len(zeros) - 1) / (zeros[-1] - zeros[0])
    assert rate == pytest.approx(np.sqrt(3.5 * STIFFNESS / MASS), rel=3e-4)
    assert rows["stuck_share"][1:, 0].min() > 0.9
    assert np.abs(rows["energy_error"]).max() < 1e-13 * rows["energy_potential"][0]


@pytest.mark.parametrize("method", ["explicit8", "cvode_bdf"])
def test_it_slips_from_the_rim_as_the_shells_do(ball, run, method):
    rows = ball(
        motion="velocity = 1.8e-4, 0.5e-4, 0 angular_velocity = 0, 0, 2",
        method=method,
        # At 1e-9 the energies are resolved to 1e-14 J, about a hundredth of what slip loses here.
        rtol=1e-10,
        t_end=1e-4,
        interval=2e-7,
    )
    lines = ["N,a,b,f,G,nu,dx,dy,twist"]
    for row in range(1, len(rows["time"])):
        axis = rows["tangential_axis"][row, 0]
        assert axis[:2] == pytest.approx([1, 0], abs=1e-3)
        shift = [rows[name][row, 0] for name in ("shift_along", "shift_across", "twist")]
        numbers = [LOAD, SEMI_AXIS, SEMI_AXIS, FRICTION, MODULUS, POISSON, *shift]
        lines.append(",".join(f"{number:.17e}" for number in numbers))
    done = run("eval", "tangential", input="\n".join(lines) + "\n")
    assert done.status == 0, done.err
    shells = list(csv.DictReader(io.StringIO(done.out)))
    wrench = np.array([[float(row[name]) for name in ("Fx", "Fy", "Tz")] for row in shells])
    limit = FRICTION * LOAD
    assert np.hypot(wrench[:, 0], wrench[:, 1]).max() > 0.5 * limit
    assert rows["stuck_share"][1:, 0].min() < 0.5
    # The rolling of a micrometre carries a part in thousand out of the spot.
    got = np.column_stack([rows["friction_force"][1:, 0, :2], rows["friction_torque"][1:, 0]])
    assert np.abs(got - wrench)[:, :2].max() < 5e-3 * limit
    assert np.abs(got - wrench)[:, 2].max() < 5e-3 * limit * SEMI_AXIS
    assert rows["energy_tangential"][1:].max() > 0
    assert np.diff(rows["work_friction"]).min() > -1e-3 * rows["work_friction"][-1]


@pytest.mark.parametrize("method", ["explicit8", "cvode_bdf"])
def test_what_slides_has_the_force_that_it_has_without(table, method):
    rows = table(gravity="5, 1, -9.81", method=method, t_end=0.2, interval=0.02)
    bare = table(gravity="5, 1, -9.81", method=method, t_end=0.2, interval=0.02, tangential="none")
    assert rows["normal_force"][-1] == pytest.approx(bare["normal_force"][-1], rel=1e-6)
    for row in range(2, 11):
        force = np.linalg.norm(rows["friction_force"][row], axis=1)
        assert force == pytest.approx(FRICTION * rows["normal_force"][row], rel=1e-12)
    assert rows["velocity"][-1, 0, :2] == pytest.approx(bare["velocity"][-1, 0, :2], rel=2e-3)


def test_a_table_rings_about_where_its_feet_hold_it(table):
    rows = table(method="explicit8", t_end=4e-3, interval=4e-5)
    late = rows["time"] > 2e-3
    # The four feet bear the weight together, each with a shift that its stiffness answers.
    held = rows["friction_force"][late].sum(axis=1).mean(axis=0)
    assert held[:2] == pytest.approx([-0.75, -0.15], rel=0.05)
    assert np.abs(rows["position"][:, 0, :2]).max() < 1e-6
    assert rows["normal_force"].sum(axis=1) == pytest.approx(0.5 * 9.81, rel=1e-9)
    assert np.abs(rows["energy_error"]).max() < 1e-13 * rows["energy_potential"][0]


@pytest.mark.parametrize("method", ["explicit8", "cvode_bdf"])
def test_feet_that_open_while_they_stick_lose_what_they_held(table, method):
    rows = table(
        gravity="7, 1, -9.81",
        coefficient=0.9,
        height=0.04,
        method=method,
        t_end=2e-3,
        interval=2e-5,
    )
    closed = rows["normal_force"] > 0
    assert closed[1].all()
    assert list(closed[-1]) == [True, False, True, False]
    assert (rows["stuck_share"][-1][~closed[-1]] == 0).all()
    assert rows["stuck_share"][-1][closed[-1]].min() > 0
    assert np.diff(rows["work_friction"]).min() > -1e-3 * rows["work_friction"][-1]
    assert np.abs(rows["energy_error"]).max() < 1e-9 * rows["energy_potential"][0]


@pytest.mark.parametrize("method", ["explicit8", "cvode_bdf", "cvode_adams"])
def test_no_row_has_more_friction_than_the_limit(simulate, method):
    """The other end of a spring comes down on a ball that slides: the load grows by 2e4 N/s."""
    scene = f"""
&scene t_end = 0.004 /
&material name = 'm' young = 2.1e9 poisson = 0.3 /
&body name = 'ball' mass = 1 inertia = 3*1e-3 position = 0, 0, 0.01 velocity = 0.1, 0, 0 /
&body name = 'ceiling' motion = 'prescribed' position = 0, 0, 0.01 velocity = 0, 0, -2 /
&surface name = 'skin' body = 'ball' shape = 'sphere' radius = 0.01 material = 'm' /
&surface name = 'floor' body = 'ground' shape = 'plane' normal = 0, 0, 1 material = 'm' /
&contact name = 'c' surfaces = 'floor', 'skin' normal = 'rigid' friction = 'contensou_exact'
   friction_coefficient = 0.3 tangential = 'elastic' /
&spring name = 'press' bodies = 'ceiling', 'ball' stiffness = 0, 0, 1e4 preload = 0, 0, -20 /
&integrator method = '{method}' rtol = 1e-8 /
&output file = 'o.h5' interval = 2e-5 /
"""
    rows = simulate(scene).columns
    force = np.linalg.norm(rows["friction_force"][1:, 0], axis=1)
    assert (force / (0.3 * rows["normal_force"][1:, 0])).max() < 1 + 1e-9


@pytest.mark.parametrize("tangential", ["elastic", "spring"])
def test_impacts_are_those_without(ball, tangential):
    """In steps of the same lengths."""
    changes = {
        "steps": "max_step = 1e-4",
        "height": 0.003,
        "motion": "velocity = 0.05, 0.02, 0 angular_velocity = 0, 3, 20",
        "more": "restitution = 0.5",
        "t_end": 0.025,
        "interval": 5e-4,
    }
    rows, bare = ball(tangential=tangential, **changes), ball(tangential="none", **changes)
    assert np.abs(rows["normal_force"]).max() == 0
    for name in ("velocity", "angular_velocity"):
        assert rows[name] == pytest.approx(bare[name], rel=1e-12, abs=1e-15)


def test_a_load_that_drives_both_bodies(simulate):
    rows = simulate(
        """
&scene title = 'a ball on a plate' gravity = 0, 0, -9.81 t_end = 5e-4 /
&material name = 'steel' young = 2.1e11 poisson = 0.3 /
&material name = 'glass' young = 7.0e10 poisson = 0.22 /
&body name = 'plate' mass = 0.1 inertia = 3*1e-5 position = 0, 0, -0.005 /
&body name = 'ball' mass = 5.105088e-4 inertia = 3*1.276272e-9 position = 0, 0, 0.0025
   velocity = 1e-4, 0, 0 angular_velocity = 0, 0, 1 /
&surface name = 'floor' body = 'ground' shape = 'plane' normal = 0, 0, 1 material = 'steel'
   centre = 0, 0, -0.01 /
&surface name = 'foot_1' body = 'plate' shape = 'sphere' radius = 0.005 material = 'steel'
   centre = 0.02, 0, 0 /
&surface name = 'foot_2' body = 'plate' shape = 'sphere' radius = 0.005 material = 'steel'
   centre = -0.01, 0.017, 0 /
&surface name = 'foot_3' body = 'plate' shape = 'sphere' radius = 0.005 material = 'steel'
   centre = -0.01, -0.017, 0 /
&surface name = 'top' body = 'plate' shape = 'plane' normal = 0, 0, 1 material = 'glass'
   centre = 0, 0, 0.005 /
&surface name = 'skin' body = 'ball' shape = 'sphere' radius = 0.0025 material = 'steel' /
&defaults normal = 'rigid' friction = 'contensou_exact' friction_coefficient = 0.3
   tangential = 'elastic' /
&contact name = 'c1' surfaces = 'floor', 'foot_1' /
&contact name = 'c2' surfaces = 'floor', 'foot_2' /
&contact name = 'c3' surfaces = 'floor', 'foot_3' /
&contact name = 'c4' surfaces = 'top', 'skin' /
&integrator method = 'explicit8' rtol = 1e-9 /
&output file = 'o.h5' interval = 1e-5 /
"""
    ).columns
    # The feet move with what the ball does to the plate.
    forces = rows["friction_force"]
    assert np.abs(forces[:, 3, 0]).max() > 0.1 * FRICTION * LOAD
    assert np.abs(forces[:, :3, 0]).max() > 0.01 * FRICTION * LOAD
    moment = 0.1 * rows["velocity"][:, 0, 0] + MASS * rows["velocity"][:, 1, 0]
    impulse = np.sum(0.5 * (forces[1:, :3, 0].sum(axis=1) + forces[:-1, :3, 0].sum(axis=1)) * 1e-5)
    assert moment[-1] - moment[0] == pytest.approx(impulse, abs=2e-2 * moment[0])
    assert np.abs(rows["energy_error"]).max() < 1e-8 * rows["energy_kinetic"].max()
