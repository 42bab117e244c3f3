"""Rolling with memory in scenes: `tangential = 'elastic'` with a law of creep."""

from __future__ import annotations

import csv
import io
import shutil
import signal

import h5py
import numpy as np
import pytest
from programs import stopped

# A rubber ball that slides, rolls and spins on a table.
BALL = """
&scene gravity = 0, 0, -9.81, t_end = 0.2 /
&material name = 'rubber', young = 5e6, poisson = 0.45 /
&body name = 'ball', mass = 0.05, inertia = 3*7.2e-6, position = 0, 0, 0.0189, place = 'rest',
   velocity = 0.8, 0, 0, spin = 0, 42.3, 10 /
&surface name = 'skin', body = 'ball', shape = 'sphere', radius = 0.019, material = 'rubber' /
&surface name = 'table', body = 'ground', shape = 'plane', material = 'rubber' /
&contact name = 'spot', surfaces = 'table', 'skin', damping = 'hunt_crossley',
   damping_coefficient = 5, friction = 'contensou_exact', friction_coefficient = 0.5,
   tangential = 'elastic', creep = 'table' /
&integrator method = 'cvode_bdf', rtol = 1e-7 /
"""

# The same ball drawn along by a plane that pulls at it: it rolls under a force that goes on.
DRAWN = (
    BALL.replace("gravity = 0, 0, -9.81", "gravity = 1.5, 0.6, -9.81")
    .replace("t_end = 0.2", "t_end = 1.5")
    .replace("place = 'rest'", "place = 'touch'")
)

MATERIAL = 5e6 / (2 * 1.45)


def rows_of(path):
    with h5py.File(path) as file:
        return {name: data[()] for name, data in file["trajectory"].items()}


@pytest.fixture
def roll(run, tmp_path):
    """Run a scene with `--set` values: its rows."""

    def roll_it(scene, *values, name="rolls"):
        (tmp_path / f"{name}.nml").write_text(scene)
        words = [word for value in values for word in ("--set", value)]
        done = run("run", f"{name}.nml", "-q", "--force", "-o", f"{name}.h5", *words, timeout=600)
        assert done.status == 0, done.err
        return rows_of(tmp_path / f"{name}.h5")

    return roll_it


@pytest.mark.parametrize("law", ["table", "brush", "strip"])
def test_the_steady_state_is_the_law_of_creep(roll, run, law):
    """Under a force that goes on the creepage changes slowly: force and torque are the law's."""
    rows = roll(DRAWN.replace("'table'", f"'{law}'"), "ball.spin=0,42.3,0")
    at = -1
    load, axes = rows["normal_force"][at, 0], rows["semi_axes"][at, 0]
    slip, spin = rows["slip_velocity"][at, 0], rows["spin"][at, 0]
    rolling = rows["rolling_velocity"][at, 0]
    numbers = [load, *axes, 0.5, MATERIAL, 0.45, *slip[:2], spin, *rolling[:2]]
    text = "N,a,b,f,G,nu,vx,vy,w,cx,cy\n" + ",".join(repr(float(x)) for x in numbers) + "\n"
    done = run("eval", "creep", "--model", law, input=text)
    assert done.status == 0, done.err
    found = next(csv.DictReader(io.StringIO(done.out)))
    force = rows["friction_force"][at, 0]
    # The ball accelerates at 5/7 of the pull; the rest is friction.
    assert np.hypot(*force[:2]) == pytest.approx(2 / 7 * 0.05 * np.hypot(1.5, 0.6), rel=1e-2)
    for x, name in zip(force[:2], ("Fx", "Fy"), strict=True):
        assert float(found[name]) == pytest.approx(x, abs=2e-3 * 0.5 * load)


def test_with_and_without_steady_rolling(roll):
    """What is steady after some lengths of the spot goes on like steady rolling."""
    rows = roll(BALL)
    steady = roll(BALL.replace("'elastic'", "'rolling'"), name="steady")
    np.testing.assert_allclose(rows["position"], steady["position"], atol=2e-4)
    # The rolling takes the strain out: what is not yet borne is not yet borne.
    assert np.abs(rows["friction_force"][0]).max() == 0
    assert np.abs(steady["friction_force"][0]).max() > 0


def test_energy_is_closed(roll):
    rows = roll(BALL)
    assert abs(rows["energy_error"]).max() < 1e-6 * rows["energy_kinetic"][0]
    assert rows["work_friction"][-1] > 0


HOPPING = """
&scene gravity = 2, 0, -9.81, t_end = 0.15 /
&material name = 'rubber', young = 5e6, poisson = 0.49 /
&body name = 'ball', density = 1200, position = 0, 0, 0.05, place = 'touch', axis = 0, 1, 0,
   angle = 0.4, velocity = 0.05, 0, -0.3, spin = 3, -2, 5 /
&surface name = 'skin', body = 'ball', shape = 'sphere', radius = 0.015, material = 'rubber' /
&surface name = 'floor', body = 'ground', shape = 'plane', material = 'rubber' /
&contact name = 'spot', surfaces = 'skin', 'floor', damping = 'hunt_crossley',
   damping_coefficient = 0.3, friction = 'contensou_exact', friction_coefficient = 0.5,
   tangential = 'elastic', creep = 'table' /
"""


@pytest.mark.parametrize("law", ["table", "strip", "brush"])
def test_a_ball_that_hops_with_spin(roll, law):
    """Spots that shrink to nothing keep a creepage that is bounded, and cost few steps."""
    # What BDF loses depends on each of its steps: tolerances that differ by a per cent have three
    # times as much, or a third. The law has no part in it: without friction BDF loses 1e-6.
    tolerances = [f"integrator.rtol={1e-8 * (1 + 0.01 * i)}" for i in range(-3, 4)]
    by_bdf = [
        roll(HOPPING, "integrator.method=cvode_bdf", f"spot.creep={law}", tolerance)
        for tolerance in tolerances
    ]
    found = [by_bdf[3], roll(HOPPING, "integrator.method=explicit8", f"spot.creep={law}")]
    for runs, bound in ((by_bdf, 1e-7), (found[1:], 1e-11)):
        lost = [np.abs(rows["energy_error"]).max() / rows["energy_kinetic"][0] for rows in runs]
        assert np.median(lost) <= bound
    for rows in found:
        assert np.abs(rows["carried_creepage"]).max() <= 1
        assert (np.diff(rows["gap"][:, 0] > 0) != 0).sum() >= 4
    for name in ("velocity", "angular_velocity"):
        scale = np.abs(found[0][name]).max()
        assert np.abs(found[0][name][-1] - found[1][name][-1]).max() <= 2e-3 * scale


def test_an_ellipsoid_that_hops_with_spin(roll, build_kind):
    scene = HOPPING.replace(
        "'sphere', radius = 0.015", "'ellipsoid', semi_axes = 0.02, 0.015, 0.012"
    )
    end = 0.15 if build_kind == "release" else 0.01
    rows = roll(scene, "integrator.method=explicit8", "ball.spin=3,-2,0", f"scene.t_end={end}")
    assert np.abs(rows["energy_error"]).max() <= 1e-9 * rows["energy_kinetic"][0]


def test_steps_that_lift_offs_cut_short(roll):
    """What is left of a step may be less than time resolves: it does not bound the next one."""
    scene = HOPPING.replace(
        "'sphere', radius = 0.015", "'ellipsoid', semi_axes = 0.02, 0.015, 0.012"
    )
    for tolerance in ("3e-7", "1e-7", "3e-8", "1e-8"):
        words = ("integrator.method=explicit8", f"integrator.rtol={tolerance}")
        rows = roll(scene.replace(", creep = 'table'", ""), *words, "spot.friction_coefficient=5")
        assert np.abs(rows["energy_error"]).max() <= float(tolerance) * rows["energy_kinetic"][0]


@pytest.mark.parametrize("method", ["cvode_adams", "explicit8", "auto"])
def test_methods_agree(roll, method):
    ends = [
        roll(BALL, f"integrator.method='{name}'", "scene.t_end=0.05", name=name)["position"][-1]
        for name in ("cvode_bdf", method)
    ]
    np.testing.assert_allclose(*ends, atol=1e-6)


def test_the_jacobian_saves_work(roll, tmp_path):
    """The analytic Jacobian leads to the same motion as differences."""
    ends = [
        roll(BALL, f"integrator.jacobian='{kind}'", name=kind)["position"][-1]
        for kind in ("analytic", "differences")
    ]
    np.testing.assert_allclose(*ends, atol=1e-6)


@pytest.mark.parametrize("method", ["cvode_bdf", "explicit8"])
def test_a_law_without_a_limit_does_not_ring_on_that_of_friction(run, root, tmp_path, method):
    """The linear torque of the spin of the ball is beyond the limit: 280,000 steps if not cut."""
    words = ("foot.tangential=elastic", "foot.creep=linear", "scene.t_end=0.5")
    scene = root / "inputs" / "examples" / "rolling_bend.nml"
    sets = [w for word in (*words, f"integrator.method={method}") for w in ("--set", word)]
    done = run("run", scene, "-q", "--force", "-o", "bend.h5", *sets, timeout=600)
    assert done.status == 0, done.err
    with h5py.File(tmp_path / "bend.h5") as file:
        assert file["integrator/steps"][()] < 25000


def test_at_rest_the_law_changes_nothing(roll):
    """What only shears the spot is borne as without a law of creep."""
    still = ("ball.velocity=0,0,0", "ball.spin=0,0,3", "scene.t_end=0.05")
    one = roll(BALL, *still)
    other = roll(BALL.replace(", creep = 'table'", ""), *still, name="without")
    np.testing.assert_allclose(one["friction_torque"], other["friction_torque"], atol=1e-9)
    assert np.abs(one["friction_torque"]).max() > 1e-5


def test_rigid_contacts(roll):
    """The normal force of a rigid contact, the rest as of a compliant one."""
    rigid = BALL.replace("damping = 'hunt_crossley',\n   damping_coefficient = 5,", "").replace(
        "tangential = 'elastic'", "normal = 'rigid', tangential = 'elastic'"
    )
    rigid = rigid.replace("position = 0, 0, 0.0189, place = 'rest'", "position = 0, 0, 0.019")
    rows = roll(rigid, "integrator.method='explicit8'", "scene.t_end=0.1")
    soft = roll(BALL, "scene.t_end=0.1", name="soft")
    np.testing.assert_allclose(rows["velocity"][-1], soft["velocity"][-1], atol=5e-3)
    np.testing.assert_allclose(
        rows["friction_force"][-1, 0], soft["friction_force"][-1, 0], atol=2e-3
    )


def test_a_run_that_goes_on(executable, roll, run, tmp_path, build_kind):
    """Two runs that go on from one checkpoint are alike to the bit."""
    end = 3 if build_kind == "release" else 0.6
    values = (f"scene.t_end={end}", "output.interval=1e-3")
    words = ["-q"] + [word for value in values for word in ("--set", value)]
    whole = roll(DRAWN, *values)
    stopped(
        executable,
        tmp_path,
        ["run", "rolls.nml", "-o", "part.h5", *words, "--checkpoint", "0.01"],
        "part.h5",
        signal.SIGTERM,
    )
    other = tmp_path / "other"
    other.mkdir()
    for path in [tmp_path / "rolls.nml", *tmp_path.glob("part.h5*")]:
        shutil.copy(path, other)
    rows = []
    for folder in (tmp_path, other):
        done = run("run", "rolls.nml", "-o", "part.h5", *words, "--resume", cwd=folder, timeout=600)
        assert done.status == 0, done.err
        rows.append(rows_of(folder / "part.h5"))
    for name in ("position", "velocity", "carried_creepage", "friction_force"):
        np.testing.assert_array_equal(rows[0][name], rows[1][name])
    np.testing.assert_allclose(rows[0]["position"][-1], whole["position"][-1], rtol=1e-4)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("creep = 'table'", "creep = 'sliding'"), "nothing sticks with creep = 'sliding'"),
        (("'contensou_exact'", "'pade22'"), "friction = 'pade22'"),
        (("'elastic'", "'spring'"), "'creep' has no meaning here"),
        (("tangential = 'elastic', ", ""), "'creep' without 'tangential'"),
        (("'table'", "'wood'"), "creep"),
    ],
)
def test_what_it_does_not_go_with_is_said(run, tmp_path, change, message):
    text = BALL.replace(*change)
    assert text != BALL
    (tmp_path / "no.nml").write_text(text)
    done = run("check", "no.nml")
    assert done.status == 2
    assert "no.nml:" in done.err
    assert message in done.err
    assert "expected" in done.err


def test_check_tells_the_law_and_its_states(run, tmp_path):
    for text, there in ((BALL, True), (BALL.replace(", creep = 'table'", ""), False)):
        (tmp_path / "ball.nml").write_text(text)
        done = run("check", "ball.nml")
        assert done.status == 0, done.err
        assert ("with the table creep" in done.out) == there
        assert ("carried_creepage" in done.out) == there


def test_sweeps_have_the_states(run, tmp_path):
    (tmp_path / "ball.nml").write_text(BALL)
    sweep = """
&sweep scene = 'ball.nml' /
&parameter name = 'ball.spin(2)', first = 20, last = 60, count = 3 /
&value name = 'creep', dataset = 'carried_creepage', component = 1, of = 'spot', time = 0.05 /
"""
    (tmp_path / "sweep.nml").write_text(sweep)
    done = run("sweep", "sweep.nml", timeout=600)
    assert done.status == 0, done.err
    with h5py.File(tmp_path / "sweep.h5") as file:
        found = file["results/creep"][()]
    assert np.isfinite(found).all()
    assert len(set(found.tolist())) == 3
    (tmp_path / "ball.nml").write_text(BALL.replace(", creep = 'table'", ""))
    done = run("sweep", "sweep.nml", "--force")
    assert done.status == 2
    assert "no contact of the scene has such a state" in done.err


def test_cost_of_laws_of_creep(run, tmp_path):
    cost = """
&cost methods = 'cvode_bdf', rtol = 1e-5, reference_rtol = 1e-8, samples = 20, repeats = 1,
   creep = 'strip', 'brush', 'table', quantities = 'velocity' /
"""
    (tmp_path / "ball.nml").write_text(BALL.replace("t_end = 0.2", "t_end = 0.02") + cost)
    done = run("cost", "ball.nml", "--csv", "cost.csv", timeout=600)
    assert done.status == 0, done.err
    models = {row["model"] for row in csv.DictReader((tmp_path / "cost.csv").open())}
    assert models == {f"contensou_exact+{law}" for law in ("strip", "brush", "table")}
    for setting, message in (
        ("cost.creep='strip','strip'", "'strip' stands twice in 'creep'"),
        ("cost.creep='sliding'", "nothing is left to remember"),
        ("cost.layers=5", "laws of creep are compared"),
    ):
        done = run("cost", "ball.nml", "--set", setting)
        assert done.status == 2
        assert message in done.err
    (tmp_path / "ball.nml").write_text(BALL.replace(", creep = 'table'", "") + cost)
    done = run("cost", "ball.nml")
    assert done.status == 2
    assert "cost.creep: no contact of the scene has a law of creep" in done.err


@pytest.mark.parametrize(
    "keys", ["tangential = 'elastic', creep = 'table'", "tangential='rolling'"]
)
def test_materials_that_laws_of_creep_are_not_for(run, tmp_path, keys):
    scene = BALL.replace("tangential = 'elastic', creep = 'table'", keys)
    scene = scene.replace("poisson = 0.45", "poisson = -0.1")
    (tmp_path / "ball.nml").write_text(scene)
    done = run("run", "ball.nml", "-o", "ball.h5")
    assert done.status == 2
    line = next(i for i, text in enumerate(scene.splitlines(), 1) if "surfaces =" in text)
    assert f"ball.nml:{line}:" in done.err
    assert "together is -0.1, and laws of creep are for 0 to 0.5" in done.err
    assert not list(tmp_path.glob("ball.h5*"))
