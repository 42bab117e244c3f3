"""Contacts of scenes that roll by a law of creep."""

from __future__ import annotations

import csv
import io
import signal
from dataclasses import replace

import h5py
import numpy as np
import pytest
from programs import stopped
from wheelset import Wheelset, oscillation

LINEAR = "table"

# As good as no spring [N/m].
FREE = 1e-6

BALL = """
&scene gravity = 0, 0, -9.81, t_end = 0.5 /
&material name = 'resin', young = 3e9, poisson = 0.35 /
&body name = 'ball', mass = 7, inertia = 3*3.26592e-2, position = 0, 0, 0.108, place = 'rest',
   velocity = 8, 0, 0, spin = -15, 60, 25 /
&surface name = 'skin', body = 'ball', shape = 'sphere', radius = 0.108, material = 'resin' /
&surface name = 'lane', body = 'ground', shape = 'plane', material = 'resin' /
&contact name = 'spot', surfaces = 'lane', 'skin', damping = 'hunt_crossley',
   damping_coefficient = 1, friction = 'contensou_exact', friction_coefficient = 0.1,
   tangential = 'rolling' /
&integrator method = 'cvode_bdf', rtol = 1e-8 /
"""


def rows_of(path):
    with h5py.File(path) as file:
        return {name: data[()] for name, data in file["trajectory"].items()}


@pytest.fixture
def roll(run, tmp_path):
    """Run a scene (text or path) with `--set` values: its rows."""

    def roll_it(scene, *values, name="rolls"):
        if isinstance(scene, str):
            path = tmp_path / f"{name}.nml"
            path.write_text(scene)
            scene = path
        words = [word for value in values for word in ("--set", value)]
        done = run("run", str(scene), "-q", "--force", "-o", f"{name}.h5", *words)
        assert done.status == 0, done.err
        return rows_of(tmp_path / f"{name}.h5")

    return roll_it


@pytest.fixture
def creep_of(run):
    """Linear coefficients of a spot, as `Wheelset.creep`."""

    def creep_of_it(load, axes, modulus, poisson):
        spot = ",".join(repr(float(x)) for x in (load, *axes, 30.0, modulus, poisson))
        small = ("1e-9,0,0,-1,0", "0,1e-9,0,-1,0", "0,0,1e-9,-1,0", "0,0,1e-9,-1,-1e-4")
        lines = ["N,a,b,f,G,nu,vx,vy,w,cx,cy", *(f"{spot},{motion}" for motion in small)]
        done = run("eval", "creep", "--model", LINEAR, input="\n".join(lines) + "\n")
        assert done.status == 0, done.err
        rows = list(csv.DictReader(io.StringIO(done.out)))
        wrench = [[-float(row[key]) * 1e9 for key in ("Fx", "Fy", "Tz")] for row in rows]
        return wrench[0][0], wrench[1][1], wrench[2][1], wrench[2][2], -1e4 * wrench[3][0]

    return creep_of_it


@pytest.fixture
def hunt(roll, inputs, creep_of):
    """Run the wheelset of the examples: its rows, and the linear theory."""

    def hunt_it(speed, stiffness, amplitude, time, *values):
        scene = inputs / "examples" / "wheelset.nml"
        boxes = [f"{side}_box.stiffness={stiffness},{stiffness},0" for side in ("left", "right")]
        rows = roll(
            scene,
            f"constants.speed={speed}",
            f"scene.t_end={time}",
            f"output.interval={time / 400}",
            f"wheelset.position=0,{amplitude},-7.19e-5",
            *boxes,
            *(f"{side}.creep='{LINEAR}'" for side in ("left", "right")),
            *(f"{side}.friction_coefficient=30.0" for side in ("left", "right")),
            "integrator.rtol=1e-10",
            "integrator.length_scale=1e-7",
            "integrator.velocity_scale=1e-6",
            "integrator.angular_velocity_scale=1e-6",
            *values,
        )
        load, overlap = rows["normal_force"].mean(), -rows["gap"].mean()
        axes = rows["semi_axes"].mean(axis=(0, 1))
        # The spot where the wheel is larger by 1e-3: area and axes go with the curvatures to 2/3.
        curvatures = np.array([1 / 0.46, 1 / 0.3])
        less = curvatures / [1.001, 1]
        area = (less.sum() / curvatures.sum()) ** (-2 / 3)
        wider = axes * np.sqrt(area * 1.001 ** np.array([2 / 3, -2 / 3]))
        spin_force = creep_of(load, axes, 2.1e11 / 2.6, 0.3)[2]
        theory = Wheelset(
            slope=1 / 40,
            gauge=0.75,
            radius=0.46,
            head=0.3,
            mass=1500.0,
            inertia=800.0,
            axle_inertia=100.0,
            box=1.0,
            stiffness=stiffness,
            load=load,
            overlap=overlap,
            creep=creep_of(load, axes, 2.1e11 / 2.6, 0.3),
            larger=(creep_of(load, wider, 2.1e11 / 2.6, 0.3)[2] / spin_force - 1) / 1e-3,
        )
        return rows, theory

    return hunt_it


@pytest.mark.release_only("a figure of many revolutions")
def test_wavelength_of_klingel(hunt):
    """In the limit of small creep, at 2 m/s, over a wave and a half."""
    rows, theory = hunt(2.0, FREE, 1e-3, 24.0)
    x, y = rows["position"][:, 0, 0], rows["position"][:, 0, 1]
    cross = np.flatnonzero(np.sign(y[1:]) != np.sign(y[:-1]))
    zeros = x[cross] - y[cross] * (x[cross + 1] - x[cross]) / (y[cross + 1] - y[cross])
    assert len(zeros) == 4
    wavelength = 2 * (zeros[-1] - zeros[0]) / 3
    assert wavelength == pytest.approx(theory.klingel(), rel=1e-3)
    # The rails yield by 72 um: with that it is the linear theory, and nearer.
    assert wavelength == pytest.approx(4 * np.pi / theory.hunting(2.0).imag, rel=1e-4)
    # Without the heads of the rails it is that of the textbook.
    sharp = replace(theory, head=0.0).klingel()
    assert sharp == pytest.approx(2 * np.pi * np.sqrt(0.46 * 0.75 * 40), rel=1e-12)


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    ("speed", "stiffness"), [(40.0, FREE), (30.0, 1e5), (45.0, 1e5), (60.0, 1e5)]
)
def test_growth_of_hunting(speed, stiffness, hunt):
    """Without springs hunting grows at any speed, with them above a critical one."""
    rows, theory = hunt(speed, stiffness, 1e-5, 140.0 / speed)
    expected = theory.hunting(speed)
    late = rows["time"] > 20.0 / speed
    found, left = oscillation(rows["time"][late], rows["position"][late, 0, 1], expected)
    assert left < 1e-4
    assert (expected.real > 0) == (stiffness == FREE or speed > 50)
    assert found.real == pytest.approx(expected.real, rel=1e-3)
    assert found.imag == pytest.approx(expected.imag, rel=1e-4)


@pytest.mark.parametrize(
    ("scene", "t_end", "most", "within"),
    [
        pytest.param(
            *("wheelset", 1.0, 40000, 2e-6), marks=pytest.mark.release_only("takes a minute")
        ),
        ("bowling_hook", 4.0, 40000, 2e-4),
    ],
)
def test_memory_changes_little_where_all_rolls(root, roll, tmp_path, scene, t_end, most, within):
    """The transient law stays in steady rolling: a spot crosses itself in few steps, as it were."""
    path = root / "inputs" / "examples" / f"{scene}.nml"
    end = f"scene.t_end={t_end}"
    steady = roll(path, end, name="steady")
    memory = path.read_text().replace("'rolling'", "'elastic', creep = 'table'")
    assert memory.count("'elastic'") == 1
    transient = roll(memory, end, name="memory")
    assert np.abs(transient["position"][-1, 0] - steady["position"][-1, 0]).max() < within
    with h5py.File(tmp_path / "memory.h5") as file:
        assert file["summary/steps"][()] < most
    stuck = transient["stuck_share"][-20:]
    assert stuck.min() > 0.2


def test_energy_is_closed_and_friction_takes(roll):
    rows = roll(BALL)
    assert abs(rows["energy_error"]).max() < 1e-8 * rows["energy_kinetic"][0]
    assert (np.diff(rows["work_friction"]) >= 0).all()
    assert rows["work_friction"][-1] > 0
    # Power of friction is what slip and spin lose.
    force, slip = rows["friction_force"][:, 0], rows["slip_velocity"][:, 0]
    power = -(force * slip).sum(axis=1) - rows["friction_torque"][:, 0] * rows["spin"][:, 0]
    lost = np.concatenate([[0], np.cumsum(0.5 * (power[1:] + power[:-1]) * np.diff(rows["time"]))])
    assert rows["work_friction"][-1] == pytest.approx(lost[-1], rel=1e-3)


def test_methods_agree(roll):
    ends = [
        roll(BALL, f"integrator.method='{method}'", "scene.t_end=0.1", name=method)["position"][-1]
        for method in ("cvode_bdf", "cvode_adams", "explicit8", "auto")
    ]
    for end in ends[1:]:
        np.testing.assert_allclose(end, ends[0], atol=1e-6)


def test_analytic_jacobian_and_differences(roll):
    rows = [roll(BALL, f"integrator.jacobian='{kind}'") for kind in ("analytic", "differences")]
    np.testing.assert_allclose(rows[0]["position"], rows[1]["position"], atol=1e-6)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("damping = 'hunt_crossley',\n   damping_coefficient = 1,", "normal = 'rigid',"), "rigid"),
        (("contensou_exact", "pade22"), "friction = 'pade22'"),
        (("= 0.1,", "= 0.1, drilling = .false.,"), "drilling"),
        (("= 0.1,", "= 0.1, regularization_velocity = 1e-3,"), "regularization_velocity"),
        (("'rolling' /", "'rolling', creep = 'wood' /"), "creep"),
        (("tangential = 'rolling' /", "creep = 'sliding' /"), "'creep' without 'tangential'"),
    ],
)
def test_refused(change, message, run, tmp_path):
    text = BALL.replace(*change)
    assert text != BALL
    (tmp_path / "no.nml").write_text(text)
    done = run("check", "no.nml")
    assert done.status != 0
    assert message in done.err
    assert "expected" in done.err


def test_check_tells_the_law(run, tmp_path):
    (tmp_path / "ball.nml").write_text(BALL)
    done = run("check", "ball.nml")
    assert done.status == 0, done.err
    assert ", rolling with the " in done.out
    assert " creep" in done.out


def test_a_run_that_goes_on(executable, roll, run, tmp_path):
    """It goes on as it was, as nothing is remembered but the state; its steps are others."""
    values = ("scene.t_end=20", "output.interval=0.01", "integrator.method=explicit8")
    words = ["run", "rolls.nml", "-o", "part.h5", "-q"]
    words += [word for value in values for word in ("--set", value)]
    whole = roll(BALL, *values)
    stopped(executable, tmp_path, [*words, "--checkpoint", "0.01"], "part.h5", signal.SIGTERM)
    done = run(*words, "--resume", timeout=600)
    assert done.status == 0, done.err
    rows = rows_of(tmp_path / "part.h5")
    np.testing.assert_array_equal(rows["time"], whole["time"])
    np.testing.assert_allclose(rows["position"], whole["position"], atol=1e-6)


def test_sweeps_have_creepages(run, tmp_path):
    (tmp_path / "ball.nml").write_text(BALL.replace("-15, 60, 25", "0, 60, 0"))
    (tmp_path / "sweep.nml").write_text("""
&sweep scene = 'ball.nml' /
&parameter name = 'ball.spin(2)', first = 20, last = 60, count = 3 /
&value name = 'slip', dataset = 'longitudinal_creepage', of = 'spot', time = 0 /
""")
    done = run("sweep", "sweep.nml")
    assert done.status == 0, done.err
    with h5py.File(tmp_path / "sweep.h5") as file:
        found = file["results/slip"][()]
    slip = 8.0 - 0.108 * np.array([20.0, 40.0, 60.0])
    np.testing.assert_allclose(found, slip / (8.0 - 0.5 * slip), rtol=1e-3)
