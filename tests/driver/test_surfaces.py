"""Shapes in scenes: where keys put them, that resolved settings are a scene again, and motions."""

from __future__ import annotations

import math

import h5py
import numpy as np
import pytest

SCENE = """\
&scene gravity = 0, 0, -9.81, t_end = {t_end} /
&material name = 'steel', young = 2.1e11, poisson = 0.3 /
&body name = 'body', mass = 1.0e-2, inertia = 1.0e-6, 1.0e-6, 1.0e-6, {pose} /
&surface name = 'first', body = 'body', {first}, material = 'steel' /
&surface name = 'second', body = 'ground', {second}, material = 'steel' /
&contact name = 'touch', surfaces = 'first', 'second'{contact} /
&output file = 'surfaces.h5', interval = {interval} /
"""

BALL = "shape = 'sphere', radius = 0.01"
EGG = "shape = 'ellipsoid', semi_axes = 0.01, 0.02, 0.03"
RING = "shape = 'torus', major_radius = 0.1, minor_radius = 0.02"
ROD = "shape = 'cylinder', radius = 0.01"
BOWL = "shape = 'paraboloid', vertex_radius = 0.02"
CONE = "shape = 'cone', half_angle = 0.5235987755982989"
FLOOR = "shape = 'plane'"
INSIDE = ", side = 'inside'"
ABOUT_X = ", axis = 2, 0, 0, angle = 1.5707963267948966"

# Position, surfaces, gap.
PLACED = {
    "egg upright": ("0, 0, 1", EGG, FLOOR, 0.97),
    "egg lying": ("0, 0, 1", EGG + ABOUT_X, FLOOR, 0.98),
    "egg turned by a quaternion": ("0, 0, 1", EGG + ", quaternion = 3, 0, 3, 0", FLOOR, 0.99),
    "egg off its body": ("0, 0, 1", EGG + ", centre = 0, 0, 0.5", FLOOR, 1.47),
    "two eggs": ("0, 0, 1", EGG, EGG + ABOUT_X, 0.95),
    "egg in an egg": (
        "0, 0, 0.1",
        EGG,
        "shape = 'ellipsoid', semi_axes = 1, 1, 0.5" + INSIDE,
        0.37,
    ),
    "ring lying": ("0, 0, 1", RING, FLOOR, 0.98),
    "ring standing": ("0, 0, 1", RING + ", direction = 1, 0, 0", FLOOR, 0.88),
    "ball beside a ring": ("0.2, 0, 0", BALL, RING, 0.07),
    "ball over a standing ring": ("0, 0, 0.2", BALL, RING + ", direction = 0, 3, 0", 0.07),
    "ball in a groove": ("0.105, 0, 0", BALL, RING + INSIDE, 0.005),
    "ball in a bore": (
        "0.5, 0.002, 0",
        BALL,
        "shape = 'cylinder', radius = 0.02, direction = 1, 0, 0" + INSIDE,
        0.008,
    ),
    "ball in a socket": ("0, 0.03, 0.04", BALL, "shape = 'sphere', radius = 0.1" + INSIDE, 0.04),
    "ball on a rod": ("0.3, 7, 0.4", BALL, ROD + ", direction = 0, -1, 0", 0.48),
    "crossed rods": ("0, 0, 1", ROD + ", direction = 1, 0, 0", ROD + ", direction = 1, 1, 0", 0.98),
    "parallel rods": (
        "0, 0, 1",
        ROD + ", direction = 1, 0, 0",
        ROD + ", direction = 1, 0, 0",
        0.98,
    ),
    "ring over a rod": (
        "0, 0, 1",
        RING + ", direction = 1, 0, 0",
        ROD + ", direction = 1, 1, 0",
        0.87,
    ),
    "ring in a bore": (
        "0, 0, 0",
        RING,
        "shape = 'cylinder', radius = 0.5, centre = 0.1, 0, 0" + INSIDE,
        0.28,
    ),
    "egg over a ring": ("0, 0, 1", EGG, RING + ", direction = 1, 0, 0", 0.85),
    "paraboloid on its vertex": ("0, 0, 1", BOWL, FLOOR, 1.0),
    "paraboloid askew": (
        "0, 0, 1",
        BOWL + ", direction = 1, 0, 1",
        FLOOR,
        1.0 - 0.01 * math.sqrt(0.5),
    ),
    "ball under a paraboloid": ("0, 0, -1", BALL, BOWL, 0.99),
    "ball in a dish": ("0, 0, 0.015", BALL, BOWL + INSIDE, 0.005),
    "ball beside a cone": ("1, 0, 0", BALL, CONE, 0.75**0.5 - 0.01),
    "ball under an apex": ("0.3, 0, -0.4", BALL, CONE + ", direction = 0, 0, 2", 0.49),
    "ball in a funnel": ("0.1, 0, 1", BALL, CONE + INSIDE, 0.5 - 0.1 * 0.75**0.5 - 0.01),
    "egg over an apex": ("0, 0, 1", EGG, CONE + ", direction = 0, 0, -1", 0.97),
    "cone over an egg": ("0, 0, 1", CONE, EGG, 0.97),
    "rod on a paraboloid": (
        "0, 0, 1",
        ROD + ", direction = 1, 2, 0",
        BOWL + ", direction = 0, 0, -1",
        0.99,
    ),
    "paraboloid beside a cone": (
        "-1, 0, 0",
        BOWL + ", direction = -3, 0, 0",
        CONE,
        0.75**0.5 - 0.0025 / 0.75**0.5,
    ),
    "two rings": ("0, 0, 1", RING + ", direction = 1, 0, 0", RING + ", direction = 0, 1, 0", 0.76),
}


@pytest.mark.parametrize("name", PLACED)
def test_place_of_a_surface(name, run, tmp_path, settings):
    position, first, second, gap = PLACED[name]
    text = SCENE.format(
        t_end=1e-6,
        interval=1e-6,
        pose=f"position = {position}",
        first=first,
        second=second,
        contact="",
    )
    (tmp_path / "scene.nml").write_text(text)
    result = run("run", "scene.nml", "-q")
    assert result.status == 0, result.err
    with h5py.File(tmp_path / "surfaces.h5") as file:
        assert file["trajectory/gap"][0, 0] == pytest.approx(gap, abs=1e-12)
        resolved = file["input/resolved"][()].decode()
    # What was resolved is a scene again, and the same one.
    (tmp_path / "again.nml").write_text(resolved)
    first_settings, second_settings = (
        settings(run("check", path).out) for path in ("scene.nml", "again.nml")
    )
    assert first_settings == second_settings


@pytest.mark.parametrize(
    ("hollow", "position", "length"),
    [
        ("shape = 'sphere', radius = 0.1" + INSIDE, "{x}, 0, {z}", 0.09),
        ("shape = 'cylinder', radius = 0.1, direction = 0, 1, 0" + INSIDE, "{x}, 0.3, {z}", 0.09),
        (
            "shape = 'torus', major_radius = 0.2, minor_radius = 0.1, centre = -0.2, 0, 0" + INSIDE,
            "{x}, 0, {z}",
            0.09,
        ),
        # The centre of the ball moves on a parallel surface: 0.1 m less the radius at the bottom.
        (
            "shape = 'paraboloid', vertex_radius = 0.1, centre = 0, 0, -0.1" + INSIDE,
            "{x}, 0, {z}",
            0.09,
        ),
    ],
    ids=["socket", "bore", "groove", "dish"],
)
def test_ball_that_slides_in_a_hollow_is_a_pendulum(hollow, position, length, run, tmp_path):
    angle, periods = 0.02, 1.5
    omega = math.sqrt(9.81 / length)
    t_end = periods * 2.0 * math.pi / omega
    x, z = length * math.sin(angle), -length * math.cos(angle)
    text = SCENE.format(
        t_end=t_end,
        interval=t_end / 60,
        pose="position = " + position.format(x=x, z=z),
        first=BALL,
        second=hollow,
        contact=", damping = 'hunt_crossley', damping_coefficient = 100.0",
    )
    (tmp_path / "scene.nml").write_text(text)
    result = run("run", "scene.nml", "-q")
    assert result.status == 0, result.err
    with h5py.File(tmp_path / "surfaces.h5") as file:
        time = file["trajectory/time"][:]
        found = file["trajectory/position"][:, 0, 0]
    assert np.abs(found - x * np.cos(omega * time)).max() < 2e-3 * x


@pytest.mark.parametrize("height", [1.0, 0.019999])
def test_a_spot_that_cannot_be_is_refused_before_the_surfaces_touch(height, run, tmp_path):
    # A thin rod on a large ball: A/B = 0.025 is below 0.0936. Far from each other, and closed.
    text = SCENE.format(
        t_end=1e-3,
        interval=1e-4,
        pose=f"position = 0, 0, {height}",
        first="shape = 'cylinder', radius = 0.0005, direction = 1, 0, 0",
        second="shape = 'sphere', radius = 0.0195",
        contact=", normal = 'vilke', ellipse = 'chord'",
    )
    (tmp_path / "scene.nml").write_text(text)
    result = run("run", "scene.nml")
    assert result.status == 2
    assert "scene.nml:6:26: error: surfaces 'first' and 'second'" in result.err
    assert "gives no spot for these curvatures; 'power' or 'exact' does" in result.err
    (tmp_path / "scene.nml").write_text(text.replace("'chord'", "'power'"))
    assert run("run", "scene.nml").status == 0


def test_ball_that_circles_in_a_funnel(run, tmp_path):
    """A ball that slides around in a funnel: N sin(alpha) = m g, N cos(alpha) = m v^2/r."""
    alpha, r, radius = math.pi / 6.0, 0.1, 0.01
    speed = math.sqrt(9.81 * r / math.tan(alpha))
    t_end = 2.0 * 2.0 * math.pi * r / speed
    z = (r + radius * math.cos(alpha)) / math.tan(alpha) + radius * math.sin(alpha)
    text = SCENE.format(
        t_end=t_end,
        interval=t_end / 80,
        pose=f"position = {r}, 0, {z}, velocity = 0, {speed}, 0",
        first=BALL,
        second=CONE + INSIDE,
        contact=", damping = 'hunt_crossley', damping_coefficient = 10.0",
    )
    (tmp_path / "scene.nml").write_text(text)
    result = run("run", "scene.nml", "-q")
    assert result.status == 0, result.err
    with h5py.File(tmp_path / "surfaces.h5") as file:
        time = file["trajectory/time"][:]
        found = file["trajectory/position"][:, 0]
    expected = r * np.stack([np.cos(speed / r * time), np.sin(speed / r * time)], axis=1)
    assert np.abs(found[:, :2] - expected).max() < 1e-3 * r
    assert np.abs(found[:, 2] - z).max() < 1e-3 * r


def test_ball_that_rolls_over_an_apex_ends_the_run(run, tmp_path):
    text = SCENE.format(
        t_end=0.1,
        interval=1e-3,
        pose="position = 0, 0, 0.02, velocity = 0, 0, -1",
        first=BALL,
        second=CONE + ", direction = 0, 0, -1",
        contact="",
    )
    (tmp_path / "scene.nml").write_text(text)
    result = run("run", "scene.nml", "-q")
    assert result.status == 1
    assert "the apex of the cone touches, where its surface has no curvature" in result.err


DRIVEN = """\
&scene gravity = 3*0, t_end = 0.005 /
&material name = 'rubber', young = 1.0e6, poisson = 0.4 /
&body name = 'egg', mass = 1, inertia = 3*1, position = 0.01, 0.003, 0.0287,
       spin = 30, 20, 7, motion = 'prescribed' /
&surface name = 'egg', body = 'egg', shape = 'ellipsoid', semi_axes = 0.02, 0.025, 0.03,
         material = 'rubber' /
&body name = 'plate', mass = 1e9, inertia = 3*1e9 /
&surface name = 'floor', body = 'plate', shape = 'ellipsoid', semi_axes = 0.1, 0.05, 0.03,
         centre = 0, 0, -0.03, material = 'rubber' /
&contact name = 'touch', surfaces = {surfaces}, friction = 'contensou_exact',
         friction_coefficient = 0.3, rolling = 'constant', rolling_coefficient = 1e-4,
         rolling_regularization = 1e-6 /
&output file = 'driven.h5', interval = 1.0e-4 /
"""


CONE_ON_ROD = """\
&scene gravity = 0, 0, -9.81, t_end = 0.1 /
&material name = 'gel', young = 1e8, poisson = 0.5 /
&material name = 'steel', young = 2.1e11, poisson = 0.3 /
&body name = 'rod', motion = 'prescribed', mass = 0.3, inertia = 3*1, spin = {rod} /
&body name = 'top', mass = 0.2, inertia = 3e-5, 3.5e-5, 4e-5, position = 0, 0, 0.1, place = 'touch'
   velocity = {velocity}, spin = {spin} /
&surface name = 'cone', body = 'top', shape = 'cone', half_angle = '30 deg', direction = 0, 1, 0
   centre = 0, -0.06, 0, material = 'gel' /
&surface name = 'bar', body = 'rod', shape = 'cylinder', radius = 0.02, direction = 1, 0, 0
   material = 'steel' /
&contact name = 'c', surfaces = 'bar', 'cone', damping = 'hunt_crossley', restitution = 0.7 /
&integrator method = '{method}' /
&output file = 'surfaces.h5', interval = 5e-4 /
"""
RODS = [
    {"rod": "-13.2488, -43.4800, 17.7380", "velocity": "-0.11855, -0.46858, -0.21548",
     "spin": "-6.0695, -18.9927, 6.1282"},
    {"rod": "-20.9542, -43.3504, 3.1609", "velocity": "0.158341, -0.221637, -0.415694",
     "spin": "16.4385, 12.5275, 8.0341"},
]  # fmt: skip


@pytest.mark.parametrize("case", RODS)
def test_a_cone_on_a_rod_is_not_sought_through_the_rod(case, run, tmp_path):
    # What trials of a method are far from led to the far side of the rod, 0.17 m deep.
    ends = []
    for method in ("explicit8", "cvode_bdf"):
        scene = tmp_path / "surfaces.nml"
        scene.write_text(CONE_ON_ROD.format(method=method, **case))
        result = run("run", scene, "--force")
        with h5py.File(
            tmp_path / ("surfaces.h5" if result.status == 0 else "surfaces.h5.part")
        ) as f:
            time, gap = f["trajectory/time"][:], f["trajectory/gap"][:, 0]
            ends.append(f["trajectory/position"][:, 0])
        assert gap.min() > -1e-3, result.err
        if result.status:
            assert "conform" in result.err
    rows = min(map(len, ends))
    assert time[rows - 1] > 0.02
    assert ends[0][:rows] == pytest.approx(ends[1][:rows], abs=1e-5)


@pytest.mark.parametrize("first", ["floor", "egg"])
def test_forces_of_varying_curvatures_are_told(first, simulate, tmp_path):
    """What a drive must hold is the sum of the forces and torques in the file, to rounding."""
    surfaces = "'floor', 'egg'" if first == "floor" else "'egg', 'floor'"
    simulate(DRIVEN.replace("{surfaces}", surfaces))
    with h5py.File(tmp_path / "out.h5") as file:
        rows = {name: values[:] for name, values in file["trajectory"].items()}
    sign = 1.0 if first == "floor" else -1.0
    normal = rows["contact_normal"][:, 0]
    force = rows["normal_force"][:, 0, None] * normal + rows["friction_force"][:, 0]
    total = force + rows["curvature_force"][:, 0]
    held = rows["drive_force"][:, 0]
    scale = np.abs(held).max()
    assert np.abs(held + sign * total).max() < 1e-12 * scale
    assert np.all(rows["normal_force"] > 0)
    # They are small beside the rest, but not to rounding.
    assert np.abs(held + sign * force).max() > 1e-5 * scale
    assert np.abs(rows["curvature_torque"]).max() > 1e-6 * scale
    arm = rows["contact_point"][:, 0] - rows["position"][:, 0]
    torque = rows["friction_torque"][:, 0, None] * normal + rows["curvature_torque"][:, 0]
    rolling = -rows["drive_torque"][:, 0] * sign - np.cross(arm, total) - torque
    # What is left is the rolling resistance, in the tangent plane and of known size.
    size = 1e-4 * rows["normal_force"][:, 0]
    assert np.abs(np.linalg.norm(rolling, axis=1) - size).max() < 1e-9 * size.max()


def test_no_forces_of_curvatures_where_these_are_constant(simulate, tmp_path):
    scene = SCENE.format(
        t_end=0.01,
        pose="position = 0, 0, 0.01",
        first=BALL,
        second=FLOOR,
        contact="",
        interval=1e-3,
    )
    simulate(scene)
    with h5py.File(tmp_path / "out.h5") as file:
        assert "curvature_force" not in file["trajectory"]


NEEDLE = """\
&scene gravity = 0, 0, -9.81, t_end = 1.0e-4 /
&material name = 'steel', young = 2.1e11, poisson = 0.3 /
&body name = 'needle', mass = 1.0e-2, inertia = 1e-3, 1e-3, 1e-8, position = 0, 0, {height}{turn} /
&surface name = 'needle', body = 'needle', shape = 'ellipsoid', semi_axes = 1e-3, 1e-3, 1,
         material = 'steel' /
&surface name = 'floor', body = 'ground', shape = 'plane', material = 'steel' /
&contact name = 'touch', surfaces = 'needle', 'floor' /
&output file = 'needle.h5', interval = 1.0e-5 /
"""


def test_the_limit_of_the_approach_goes_by_the_curvature_where_it_touches(run, tmp_path):
    """A needle of 1 mm has radii of 1 mm at its waist and of 1 um at its tip."""
    lies = ", axis = 0, 1, 0, angle = 1.5707963267948966"
    for height, turn, status, text in [
        ("0.99e-3", lies, 0, ""),
        ("0.89e-3", lies, 2, "at most 1.000E-04 m"),
        ("0.99999", "", 2, "at most 1.000E-07 m"),
    ]:
        (tmp_path / "needle.nml").write_text(NEEDLE.format(height=height, turn=turn))
        result = run("run", "needle.nml", "--force")
        assert result.status == status, result.err
        assert text in result.err
