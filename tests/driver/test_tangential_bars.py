"""Tangential elasticity in runs against closed forms, over methods, friction models and shapes."""

import csv
import shutil
import signal
from pathlib import Path

import h5py
import numpy as np
import pytest
from programs import stopped
from result import read

ROOT = Path(__file__).resolve().parents[2]
INPUTS = ROOT / "inputs"

# A ball of steel on a plane of steel.
YOUNG, POISSON, RADIUS, MASS = 2.1e11, 0.3, 0.0025, 5.105088e-4
MODULUS = YOUNG / 2 / (1 + POISSON)
LOAD = MASS * 9.81
SEMI_AXIS = (3 * LOAD * RADIUS * (1 - POISSON**2) / (2 * YOUNG)) ** (1 / 3)
APPROACH = SEMI_AXIS**2 / RADIUS
STIFFNESS = 4 * MODULUS * SEMI_AXIS / (2 - POISSON)

BALL = """
&scene title = 'a ball on a plane' t_end = {t_end} {gravity} /
&material name = 'steel' young = 2.1e11 poisson = {poisson} /
&body name = 'ball' mass = 5.105088e-4 inertia = {inertia} position = {position} {motion} /
&surface name = 'skin' body = 'ball' material = 'steel' {shape} /
&surface name = 'floor' body = 'ground' material = 'steel' shape = 'plane' normal = {normal} /
&contact name = 'c' surfaces = 'floor', 'skin' friction = '{friction}' {more}
   friction_coefficient = {coefficient} tangential = 'elastic' layers = {layers} /
&integrator method = '{method}' rtol = {rtol} {steps} /
&output file = 'o.h5' interval = {interval} /
"""
USUAL = {
    "t_end": 1e-4,
    "gravity": "",
    "poisson": POISSON,
    "inertia": "3*1.276272e-9",
    "position": f"0, 0, {RADIUS}",
    "motion": "velocity = 0.01, 0, -0.02",
    "shape": f"shape = 'sphere' radius = {RADIUS}",
    "normal": "0, 0, 1",
    "friction": "contensou_exact",
    "more": "",
    "coefficient": 0.3,
    "layers": 12,
    "method": "explicit8",
    "rtol": 1e-8,
    "steps": "",
    "interval": 1e-6,
}
METHODS = ["explicit8", "cvode_bdf", "cvode_adams"]
AT_REST = {"gravity": "gravity = 0, 0, -9.81", "position": f"0, 0, {RADIUS - APPROACH!r}"}


@pytest.fixture
def ball(simulate):
    """The rows of a ball on a plane, in which some of the usual is otherwise."""

    def rows_of(**changes):
        return simulate(BALL.format(**{**USUAL, **changes})).columns

    return rows_of


def closed_to(rows, bound):
    """Whether the energy balance is closed to a part of the largest energy."""
    scale = max(np.abs(rows["energy_kinetic"]).max(), np.abs(rows["energy_elastic"]).max())
    return np.abs(rows["energy_error"]).max() <= bound * scale


@pytest.mark.parametrize("method", METHODS)
def test_a_ball_rings_on_the_tangential_stiffness(ball, method):
    rows = ball(**AT_REST, motion="velocity = 1e-6, 0, 0", method=method, rtol=1e-10, t_end=1e-3)
    force, time = rows["friction_force"][:, 0, 0], rows["time"]
    assert np.abs(force).max() < 0.01 * 0.3 * LOAD
    at = np.flatnonzero(force[1:-1] * force[2:] < 0) + 1
    zeros = time[at] - force[at] * (time[at + 1] - time[at]) / (force[at + 1] - force[at])
    assert len(zeros) > 20
    found = np.pi * (len(zeros) - 1) / (zeros[-1] - zeros[0])
    assert found == pytest.approx(np.sqrt(3.5 * STIFFNESS / MASS), rel=1e-5)


@pytest.mark.parametrize("poisson", [0.0, 0.3, 0.5])
@pytest.mark.parametrize(
    ("method", "layers", "bound"),
    [("cvode_bdf", 12, 0.02), ("explicit8", 12, 0.02), ("cvode_bdf", 24, 0.01)],
)
def test_impacts_at_other_ratios_of_poisson(ball, poisson, method, layers, bound):
    with open(ROOT / "tests/reference/mbf.csv", encoding="utf-8") as file:
        table = [[float(x) for x in row] for row in list(csv.reader(file))[1:]]
    kappa = 2 * (1 - poisson) / (2 - poisson)
    chi = 7 * (1 - poisson) / (2 * (2 - poisson))
    for nu, before, after in table[:: 1 if method == "explicit8" else 2]:
        if nu != poisson:
            continue
        rows = ball(
            poisson=poisson,
            layers=layers,
            method=method,
            motion=f"velocity = {before * 0.3 * 0.02 / kappa!r}, 0, -0.02",
        )
        slip = rows["velocity"][-1, 0, 0] - RADIUS * rows["angular_velocity"][-1, 0, 1]
        # Where it slides throughout the impulse is that of friction.
        slides = before >= 4 * chi - 0.8
        if slides:
            after = before - 4 * chi
        assert abs(kappa * slip / (0.3 * 0.02) - after) < (2e-5 if slides else bound), before


def turned(matrix, vector):
    return ", ".join(repr(float(x)) for x in matrix @ np.array(vector))


def turns(number):
    """Rotations: none first, then some at random."""
    generator = np.random.default_rng(7)
    yield np.eye(3)
    for _ in range(number):
        turn = np.linalg.qr(generator.normal(size=(3, 3)))[0]
        yield turn * np.sign(np.linalg.det(turn))


def farthest_of_turned(run, number):
    """Largest difference of motions and forces of turned scenes from those of the first, over the
    largest of these, and the rows of the first."""
    plain, worst = None, 0.0
    for turn in turns(number):
        rows = run(turn)
        if plain is None:
            plain = rows
        for key in ("velocity", "angular_velocity", "friction_force"):
            error = rows[key][:, 0] - plain[key][:, 0] @ turn.T
            worst = max(worst, np.abs(error).max() / np.abs(plain[key]).max())
    return worst, plain


def test_the_law_knows_no_axes(ball):
    """Steps of the same lengths give the same motion, whichever way the scene is turned."""

    def run(turn):
        return ball(
            gravity=f"gravity = {turned(turn, [0, 0, -9.81])}",
            position=turned(turn, [0, 0, RADIUS - APPROACH]),
            motion=f"velocity = {turned(turn, [1.5e-4, 1e-4, 0])} spin = "
            + turned(turn, [0.02, 0, 0.2]),
            normal=turned(turn, [0, 0, 1]),
            t_end=5e-4,
            interval=1e-5,
            rtol=1e-3,
            steps="max_step = 5e-7",
            more="damping = 'hunt_crossley' damping_coefficient = 1000",
        )

    worst, plain = farthest_of_turned(run, 3)
    assert plain["stuck_share"].min() == 0
    assert plain["stuck_share"].max() > 0.5
    assert worst < 1e-9


@pytest.mark.parametrize(
    ("method", "rtol", "above", "spin"),
    [
        ("explicit8", 1e-6, 0, [10, 5, 10]),
        ("explicit8", 1e-8, 0, [0, 0, 0]),
        ("explicit8", 1e-8, 1e-6, [0, 0, 0]),
        ("explicit8", 1.01e-8, 1e-6, [10, 5, 10]),
        ("cvode_bdf", 1e-6, 1e-6, [0, 0, 0]),
        ("cvode_bdf", 1e-6, 0, [0, 0, 0]),
        ("cvode_bdf", 1e-8, 0, [0, 0, 0]),
        ("cvode_bdf", 1e-8, 1e-6, [0, 0, 0]),
        # The rate of the way rolled began with a step at the touch, which rounding placed.
        ("cvode_bdf", 1e-6, 0, [10, 5, 10]),
        # Rounding decided whether CVODE found a limit of stability.
        ("cvode_bdf", 1e-6, 1e-6, [10, 5, 10]),
        ("cvode_bdf", 1e-8, 0, [10, 5, 10]),
        # High differences are rounding where errors of gaps are to be small.
        ("cvode_adams", 1e-6, 0, [0, 0, 0]),
        ("cvode_adams", 1e-6, 1e-6, [10, 5, 10]),
        ("cvode_adams", 1e-8, 0, [10, 5, 10]),
    ],
)
def test_a_turned_scene_takes_the_same_steps(ball, method, rtol, above, spin):
    """Although its rounding errors are others: from the touch, with a flight before it, to the
    flight after it."""

    def run(turn):
        return ball(
            method=method,
            rtol=rtol,
            gravity=f"gravity = {turned(turn, [0, 0, -9.81])}",
            position=turned(turn, [0, 0, RADIUS + above]),
            motion=f"velocity = {turned(turn, [0.01, 0, -0.02])} spin = {turned(turn, spin)}",
            normal=turned(turn, [0, 0, 1]),
            t_end=1.5e-4,
        )

    worst, plain = farthest_of_turned(run, 6)
    assert plain["gap"][-1, 0] > 0
    assert plain["work_friction"][-1] > 0
    assert worst < 1e-9


def test_a_turned_slow_impact_takes_the_same_steps(ball):
    """Slower than what its errors tell apart: failed steps have graded lengths there as well."""

    def run(turn):
        return ball(
            method="cvode_bdf",
            rtol=1.3492643713253434e-7,
            gravity=f"gravity = {turned(turn, [0, 0, -9.81])}",
            position=turned(turn, [0, 0, RADIUS]),
            motion=f"velocity = {turned(turn, velocity)} spin = 0, 0, 0",
            normal=turned(turn, [0, 0, 1]),
            t_end=1.5e-4,
            interval=3e-6,
        )

    # A scene of which each turn was 5e-9 off or more.
    velocity = [-0.0012941499165997727, -0.0003021406010653926, -0.006052198656720825]
    worst, plain = farthest_of_turned(run, 6)
    assert plain["gap"][-1, 0] > 0
    assert worst < 2e-9


STOOL = """
&constants slope = {slope} /
&scene title = 'a stool whose weight is at its feet' t_end = {t_end}
   gravity = 9.81*slope/sqrt(1+slope**2), 0, -9.81/sqrt(1+slope**2) /
&material name = 'steel' young = 2.1e11 poisson = 0.3 /
&body name = 'stool' mass = 0.5 inertia = 3*1.0e-4 position = 0, 0, {low} /
{feet}
&surface name = 'floor' body = 'ground' material = 'steel' shape = 'plane' normal = 0, 0, 1 /
&spring name = 'drag' bodies = 'ground', 'stool' damping = {drag}, 0, 0 /
&integrator method = 'cvode_bdf' rtol = 1.0e-8 /
&output file = 'o.h5' interval = 0.1 /
"""
FEET = "".join(
    f"""
&surface name = 's{i}' body = 'stool' material = 'steel' shape = 'sphere' radius = 0.005
   centre = {place}, 0.005 /
&contact name = 'c{i}' surfaces = 'floor', 's{i}' damping = 'hunt_crossley'
   damping_coefficient = 100.0 friction = 'contensou_exact' friction_coefficient = 0.3
   tangential = 'elastic' /
"""
    for i, place in enumerate(["0.02, 0.0", "-0.01, 0.017320508", "-0.01, -0.017320508"], 1)
)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("rtol", [1e-8, 3e-8, 1e-6])
@pytest.mark.parametrize("gravity", ["", "gravity = 0, 0, -9.81"])
def test_a_ball_that_falls_onto_a_plane_keeps_its_energy(ball, method, rtol, gravity):
    # No step of the flight ends in the impact, whose force it would not have known.
    rows = ball(
        gravity=gravity,
        position=f"0, 0, {RADIUS + 1e-5!r}",
        motion="velocity = 0.0025, -0.0033, -0.01",
        coefficient=0.05,
        t_end=1.7e-3,
        interval=3e-6,
        method=method,
        rtol=rtol,
    )
    energy = rows["energy_kinetic"]
    assert rows["velocity"][-1, 0, 2] > 0.005
    assert np.abs(rows["energy_error"]).max() <= rtol * energy[0]


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("spin", ["100, 150, -80", "3, 200, 20"])
def test_what_tumbles_before_and_after_an_impact_keeps_its_energy(ball, method, spin):
    rows = ball(
        shape="shape = 'ellipsoid' semi_axes = 0.02, 0.01, 0.007",
        inertia="1.5e-8, 4.6e-8, 5.1e-8",
        position="0, 0, 0.021",
        motion=f"velocity = 0.05, -0.03, -0.4 spin = {spin}",
        more="damping = 'hunt_crossley' restitution = 0.6",
        t_end=0.03,
        interval=3e-5,
        method=method,
    )
    assert rows["work_friction"][-1] > 0
    assert closed_to(rows, 1e-8)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("restitution", [0.2, 0.5, 0.9])
@pytest.mark.parametrize("speed", [0, 0.4])
def test_a_force_that_ends_before_the_overlap_does(ball, method, restitution, speed):
    # Damping takes it to zero where it has a kink; the overlap that is left is lost.
    rows = ball(
        position=f"0, 0, {RADIUS + 1e-6!r}",
        motion=f"velocity = {speed}, 0, -0.5",
        more=f"damping = 'tsuji' restitution = {restitution}",
        t_end=1e-4,
        interval=1e-7,
        method=method,
    )
    free = (rows["gap"][:, 0] < 0) & (rows["normal_force"][:, 0] == 0)
    assert np.count_nonzero(free) > 3
    assert closed_to(rows, 1e-8)


def test_a_stool_is_displaced_by_the_force_over_the_stiffness(simulate):
    """In place, not by the output of the law: the dashpot takes the ringing, and nothing slips."""
    slope = 0.003
    load = 0.5 * 9.81 / np.sqrt(1 + slope**2) / 3
    a = (3 * load * 0.005 * (1 - POISSON**2) / (2 * YOUNG)) ** (1 / 3)
    stiffness = 4 * MODULUS * a / (2 - POISSON)
    drag = 1.2 * np.sqrt(3 * stiffness * 0.5)
    numbers = {"slope": slope, "low": repr(float(-(a**2) / 0.005)), "drag": repr(float(drag))}
    short = simulate(STOOL.format(**numbers, feet=FEET, t_end=10))
    whole = simulate(STOOL.format(**numbers, feet=FEET, t_end=100))
    place = whole.columns["position"][:, 0, 0]
    assert place[-1] == pytest.approx(load * slope / stiffness, rel=1e-6)
    late = whole.columns["time"] > 10
    assert np.ptp(whole.columns["position"][late, 0], axis=0).max() < 1e-12
    assert whole.steps - short.steps < short.steps
    assert whole.columns["stuck_share"][-1].min() > 0.999


def test_an_incline_that_slips_at_first_takes_few_steps_afterwards(simulate):
    scene = (INPUTS / "examples/incline.nml").read_text(encoding="utf-8")
    steps = {}
    for t_end in (10, 100):
        run = simulate(scene, f"scene.t_end={t_end}", "output.interval=0.1")
        steps[t_end] = run.steps
    late = run.columns["time"] > 10
    assert np.ptp(run.columns["position"][late, 0], axis=0).max() < 1e-12
    assert steps[100] < 2 * steps[10]


@pytest.mark.parametrize("t_end", [22.8, 31.9, 62.5, 141.1])
def test_an_incline_does_not_ring_on(simulate, t_end):
    # The order of the method stayed high there, and the steps followed 1e-10 m/s for ever.
    scene = (INPUTS / "examples/incline.nml").read_text(encoding="utf-8")
    run = simulate(scene, f"scene.t_end={t_end}", "output.interval=0.1")
    assert run.steps < 4500


@pytest.mark.parametrize("method", METHODS)
def test_a_load_that_vanishes_and_returns(ball, method):
    rows = ball(gravity="gravity = 0, 0, -9.81", method=method, t_end=0.03, interval=2e-5)
    closed = rows["gap"][:, 0] < 0
    assert np.count_nonzero(np.diff(closed.astype(int)) == 1) >= 5
    # In flight nothing is stored, and what was is booked.
    assert np.all(rows["energy_tangential"][~closed] == 0)
    assert rows["energy_tangential"].max() > 0
    assert np.diff(rows["work_friction"])[~closed[1:] & ~closed[:-1]].max(initial=0) == 0
    assert closed_to(rows, 1e-8)


def test_a_twist_without_shift_and_back(ball):
    torsion = 8 / 3 * MODULUS * SEMI_AXIS**3
    rate = np.sqrt(torsion / 1.276272e-9)
    period = 2 * np.pi / rate
    rows = ball(
        **AT_REST,
        motion="velocity = 0, 0, 0 spin = 0, 0, 3e-4",
        t_end=5 * period,
        interval=period / 400,
    )
    # The torque alone rings; no force comes of it.
    torque, time = rows["friction_torque"][:, 0], rows["time"]
    assert np.abs(rows["friction_force"]).max() < 1e-9 * 0.3 * LOAD
    at = np.flatnonzero(torque[1:-1] * torque[2:] < 0) + 1
    zeros = time[at] - torque[at] * (time[at + 1] - time[at]) / (torque[at + 1] - torque[at])
    assert np.pi * (len(zeros) - 1) / (zeros[-1] - zeros[0]) == pytest.approx(rate, rel=1e-3)
    assert closed_to(rows, 1e-8)


NEEDLE = {
    "shape": "shape = 'ellipsoid' semi_axes = 3.8, 0.01, 0.01",
    "inertia": "2e-8, 7e-3, 7e-3",
    "position": "0, 0, 0.01",
    "motion": "velocity = 0.01, 0.005, -0.02 spin = 0, 0, 0.1",
    "interval": 1e-7,
}


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    "changes",
    [
        {"coefficient": 0.0},
        {"coefficient": 5.0},
        {"poisson": 0.0},
        {"poisson": 0.5},
        {"layers": 1},
        {"layers": 128},
        NEEDLE,
    ],
    ids=["f 0", "f 5", "nu 0", "nu 0.5", "1 layer", "128 layers", "needle"],
)
def test_corners_of_the_law(ball, method, changes):
    rows = ball(method=method, **changes)
    touching = rows["normal_force"][:, 0] > 0
    assert np.count_nonzero(touching) > 10
    assert not touching[-1]
    assert rows["energy_tangential"][-1] == 0
    limit = changes.get("coefficient", 0.3) * rows["normal_force"][:, 0]
    force = np.linalg.norm(rows["friction_force"][:, 0], axis=1)
    assert np.all(force <= limit * (1 + 1e-9) + 1e-12)
    lost = np.diff(rows["work_friction"])
    energy = rows["energy_kinetic"][0]
    assert lost.min() >= -1e-6 * energy
    assert closed_to(rows, 1e-8)
    if changes is NEEDLE:
        axes = rows["semi_axes"][touching, 0]
        assert np.all(axes[:, 1] / axes[:, 0] < 1.1e-3)


@pytest.mark.sample(3)
@pytest.mark.parametrize(
    "friction", ["coulomb", "contensou_simplified", "pade11", "pade22", "contensou_exact"]
)
def test_full_sliding_is_that_of_each_friction_model(ball, run, friction):
    smooth = 1e-6 if friction == "coulomb" else 0.0
    rows = ball(
        **AT_REST,
        friction=friction,
        more=f"regularization_velocity = {smooth} damping = 'hunt_crossley' "
        "damping_coefficient = 100",
        motion="velocity = 0.2, 0, 0 spin = 0, 0, 1200",
        method="cvode_bdf",
        t_end=0.02,
        interval=1e-3,
    )
    slip = rows["slip_velocity"][:, 0]
    sliding = (rows["time"] > 0.001) & (np.linalg.norm(slip, axis=1) > 0.05)
    assert np.count_nonzero(sliding) >= 5
    table = "N,a,b,f,vx,vy,w\n"
    for i in np.flatnonzero(sliding):
        a, load, spin = rows["semi_axes"][i, 0, 0], rows["normal_force"][i, 0], rows["spin"][i, 0]
        numbers = (load, a, a, 0.3, slip[i, 0], slip[i, 1], spin)
        table += ",".join(repr(float(x)) for x in numbers) + "\n"
    words = ["--delta", repr(smooth)] if smooth else []
    done = run("eval", "wrench", "--model", friction, *words, input=table)
    assert done.status == 0, done.err
    expected = np.array([line.split(",")[-3:] for line in done.out.split()[1:]], dtype=float)
    load = 0.3 * rows["normal_force"][sliding, :1]
    found = rows["friction_force"][sliding, 0, :2]
    # Once it has slid by many times what its spot can be strained nothing else is left.
    error = np.abs((found - expected[:, :2]) / load).max(axis=1)
    assert error.max() < 1e-12
    torque = rows["friction_torque"][sliding, 0] - expected[:, 2]
    error = np.abs(torque / (load[:, 0] * rows["semi_axes"][sliding, 0, 0]))
    assert error.max() < 1e-12
    assert closed_to(rows, 1e-8)


@pytest.mark.parametrize("method", ["explicit8", "cvode_bdf"])
@pytest.mark.parametrize(("velocity", "spin"), [(0.2, 1200), (0.2, 100), (0.5, 3000)])
def test_full_sliding_needs_no_steps_of_the_size_of_a_strain(simulate, method, velocity, spin):
    # The spot is strained by 5e-9 m, 2e5 times less than it slides.
    scene = BALL.format(
        **{
            **USUAL,
            **AT_REST,
            "more": "damping = 'hunt_crossley' damping_coefficient = 100",
            "motion": f"velocity = {velocity}, 0, 0 spin = 0, 0, {spin}",
            "method": method,
            "rtol": 1e-10,
            "t_end": 0.005,
            "interval": 1e-3,
        }
    )
    assert simulate(scene).steps < 2500


def test_a_force_lags_behind_sliding_that_turns(simulate, run):
    # Rubber is strained by 2e-5 m; within that way the sliding turns by some 1e-3 rad, and by more
    # as it slows down while the drilling goes on.
    text = (INPUTS / "sliding_ball.nml").read_text().replace("t_end = 2.5", "t_end = 0.01")
    rows = simulate(text.replace("friction_co", "tangential = 'elastic', friction_co")).columns
    slides = rows["time"] > 0.002
    slip, spin = rows["slip_velocity"][slides, 0], rows["spin"][slides, 0]
    load, a = rows["normal_force"][slides, 0], rows["semi_axes"][slides, 0, 0]
    table = "N,a,b,f,vx,vy,w\n"
    for i in range(len(a)):
        numbers = (load[i], a[i], a[i], 0.3, slip[i, 0], slip[i, 1], spin[i])
        table += ",".join(repr(float(x)) for x in numbers) + "\n"
    done = run("eval", "wrench", input=table)
    assert done.status == 0, done.err
    expected = np.array([line.split(",")[-3:] for line in done.out.split()[1:]], dtype=float)
    lag = rows["friction_force"][slides, 0, :2] - expected[:, :2]
    lag = np.linalg.norm(lag, axis=1) / (0.3 * load)
    assert (lag > 3e-3).all()
    assert (lag[:3] < 1e-2).all()
    assert lag[-1] > 0.1


@pytest.mark.sample(2)
@pytest.mark.parametrize("method", ["explicit8", "cvode_bdf"])
@pytest.mark.parametrize("friction", ["contensou_simplified", "pade11", "pade22"])
def test_rungs_stick(ball, friction, method):
    """What slides and spins ends in rolling that hardly slips, and its energy is all told."""
    rows = ball(
        **AT_REST,
        friction=friction,
        more="damping = 'hunt_crossley' damping_coefficient = 100",
        motion="velocity = 0.01, 0, 0 spin = 0, 0, 0.1",
        method=method,
        t_end=0.05,
        interval=0.01,
    )
    assert np.linalg.norm(rows["slip_velocity"][-1, 0]) < 1e-8
    assert rows["stuck_share"][-1, 0] > 0.9
    assert closed_to(rows, 1e-8)


def springs(shifts, limit, stiffness, number=2000):
    """Force of springs side by side that slip one after the other, by Popov and Hess (2014)."""
    x = (np.arange(number) + 0.5) / number
    share = 1.5 * (1 - x**2) / number
    bound = limit * share / (stiffness / number)
    held = np.zeros(number)
    forces = []
    for step in np.diff(shifts, prepend=0.0):
        held = np.clip(held + step, -bound, bound)
        forces.append(held.sum() * stiffness / number)
    return np.array(forces)


def test_the_shipped_loop_is_that_of_cattaneo(simulate):
    run = simulate(INPUTS / "examples/cattaneo.nml", "output.interval=1e-5")
    rows = run.columns
    a = rows["semi_axes"][:, 0, 0]
    assert np.ptp(a) < 1e-9 * a[0]
    stiffness = 4 * MODULUS * a[0] / (2 - POISSON)
    limit = 0.3 * rows["normal_force"][0, 0]
    # The tangent along which the shift is measured may be any.
    axis = rows["tangential_axis"][0, 0]
    force = rows["friction_force"][:, 0] @ axis
    shift = rows["shift_along"][:, 0]
    expected = -springs(shift, limit, stiffness)
    assert np.abs(force).max() > 0.85 * limit
    assert np.abs(force - expected).max() < 2e-3 * limit
    # What the loops enclose is what was lost, but for what is stored.
    middle = 0.5 * (force[1:] + force[:-1])
    loops = -np.sum(middle * np.diff(shift))
    assert rows["work_friction"][-1] + rows["energy_tangential"][-1] == pytest.approx(
        loops, rel=1e-3
    )
    assert rows["stuck_share"].min() < 0.3


def test_the_shipped_ball_rocks_until_it_sticks(simulate):
    rows = simulate(INPUTS / "examples/dish.nml").columns
    place = rows["position"][:, 0, 0]
    turns = np.flatnonzero((place[1:-1] > place[:-2]) & (place[1:-1] > place[2:])) + 1
    swings = place[turns]
    assert np.all(np.diff(swings[:9]) < 0)
    late = rows["time"] > 5.5
    # It stays aside of the bottom, held by what its spot remembers.
    assert np.ptp(place[late]) < 1e-6
    assert abs(place[-1]) > 1e-5
    assert rows["stuck_share"][late].min() > 0.9
    assert closed_to(rows, 1e-8)


GROOVE = """
&scene title = 'an ellipsoid across a groove, which holds it in two spots' t_end = 0.01
   gravity = 1.0, 0, -9.7 /
&material name = 'steel' young = 2.1e11 poisson = 0.3 /
&body name = 'egg' density = 7800 position = 0, 0, -0.012 place = 'touch' /
&surface name = 'skin' body = 'egg' material = 'steel' shape = 'ellipsoid'
   semi_axes = 0.02, 0.02, 0.01 /
&surface name = 'groove' body = 'ground' material = 'steel' shape = 'cylinder' radius = 0.03
   direction = 1, 0, 0 side = 'inside' /
&contact name = 'c' surfaces = 'groove', 'skin' damping = 'hunt_crossley'
   damping_coefficient = 100 friction = 'contensou_exact' friction_coefficient = 0.3
   tangential = 'elastic' /
! Nothing is faster than 3e-3 m/s.
&integrator method = 'cvode_bdf' rtol = 1.0e-8 velocity_scale = 1.0e-3 /
&output file = 'o.h5' interval = 1e-4 /
"""


def test_several_spots_have_a_memory_each(simulate):
    rows = simulate(GROOVE).columns
    late = rows["time"] > 0.005
    # The scene is the same when y is reversed, and so are the two spots.
    force = rows["friction_force"]
    scale = np.abs(force).max()
    assert force[late][:, 0] == pytest.approx(
        force[late][:, 1] * np.array([1, -1, 1]), abs=1e-3 * scale
    )
    assert scale > 0
    assert rows["energy_tangential"][late].min() > 0
    assert closed_to(rows, 1e-8)


def test_the_shipped_sweep_has_the_angles_that_were_measured(run, tmp_path):
    words = ["-q", "-o", "few.h5", "--cases", "103,124"]
    done = run("sweep", INPUTS / "sweeps/impact_angle.nml", *words, timeout=300)
    assert done.status == 0, done.err
    with h5py.File(tmp_path / "few.h5") as file:
        angles = file["parameters/angle"][()]
        velocity = file["results/velocity"][()]
        assert set(file["parameters/skin_plate.tangential"].asstr()[:]) == {"elastic"}
    found = velocity / (3.9 * np.sin(angles))
    with open(ROOT / "tests/reference/impact_kharaz.csv", encoding="utf-8") as file:
        table = [row for row in csv.DictReader(file) if row["quantity"].startswith("tang")]
    measured = np.interp(
        np.degrees(angles),
        [float(row["angle_deg"]) for row in table],
        [float(row["measured"]) for row in table],
    )
    assert np.abs(found - measured).max() < 0.03


@pytest.mark.parametrize("method", ["explicit8", "cvode_bdf", "cvode_adams", "auto"])
def test_a_resumed_run_has_what_was_remembered_bit_for_bit(
    run, executable, tmp_path, slow_build, method
):
    """A cycle is cut somewhere; whoever goes on from there goes on in the same way."""
    t_end = 0.4 if slow_build else 2.0
    scene = (INPUTS / "examples/cattaneo.nml").read_text(encoding="utf-8")
    (tmp_path / "scene.nml").write_text(scene.replace("t_end = 0.1", f"t_end = {t_end}"))
    words = ["run", "scene.nml", "-o", "part.h5", "-q", "--set", f"integrator.method={method}"]
    stopped(executable, tmp_path, [*words, "--checkpoint", "0.01"], "part.h5", signal.SIGTERM)
    other = tmp_path / "other"
    other.mkdir()
    for path in [tmp_path / "scene.nml", *tmp_path.glob("part.h5*")]:
        shutil.copy(path, other)
    rows = []
    for folder in (tmp_path, other):
        done = run(*words, "--resume", cwd=folder, timeout=600)
        assert done.status == 0, done.err
        rows.append(read(folder / "part.h5").columns)
    for key in rows[0]:
        assert np.array_equal(rows[0][key], rows[1][key]), key
    # Where it was cut the spot has not forgotten: its loops go on as those before.
    force = np.abs(rows[0]["friction_force"][:, 0, 0])
    beats = force[: 250 * (len(force) // 250)].reshape(-1, 250).max(axis=1)
    assert beats.min() > 0.9 * beats.max()


@pytest.mark.sample(1)
@pytest.mark.parametrize("method", ["explicit8", "cvode_bdf"])
def test_a_bearing_at_rest_sticks(simulate, method):
    text = (INPUTS / "bearing_6205.nml").read_text()
    for old, new in (
        ("regularization_velocity = 1.0e-4", "tangential = 'elastic'"),
        ("inner_speed = 188.5", "inner_speed = 0.0"),
        ("initial_state = 'rolling'", "initial_state = 'rest'"),
        ("t_end = 0.05", "t_end = 2e-4"),
        ("interval = 1.0e-4", "interval = 2e-6"),
        ("method = 'cvode_bdf'", f"method = '{method}'"),
    ):
        assert old in text
        text = text.replace(old, new)
    rows = simulate(text).columns
    loaded = rows["normal_force"].min(axis=0) > 1
    assert loaded.sum() == 18
    force = np.linalg.norm(rows["friction_force"], axis=2)[:, loaded]
    assert (force < 0.5 * 0.05 * rows["normal_force"][:, loaded]).all()
    assert rows["stuck_share"][1:, loaded].min() > 0.85
    assert closed_to(rows, 1e-8)
