"""Hard cases: what makes simulations of contacts fail, each with the condition that it must meet.

The first paragraph of a test's docstring says what is done, the second one when it passes;
docs/hard-cases.md shows both with a picture of the data that the test judged (scripts/hard_cases
draws them).
"""

from __future__ import annotations

import csv
import inspect
import io
import math
import os
import re
import sys
from pathlib import Path

import numpy as np
import pytest

HARD = Path(__file__).resolve().parents[1] / "hard"
PAGE = Path(__file__).resolve().parents[2] / "docs" / "hard-cases.md"
GRAVITY = 9.81

# The ball of ball.nml.
MASS, RADIUS, POISSON = 0.05, 0.02, 0.3
DAMPED = "contact.damping = 'hunt_crossley'"
RUBBED = ("contact.friction = 'contensou_exact'", "contact.friction_coefficient = 0.3")


def modulus(young):
    """E* of two bodies of one material."""
    return young / (2.0 * (1.0 - POISSON**2))


def stiffness(young, radius=RADIUS):
    """Hertz: force over overlap to the power 3/2."""
    return 4.0 / 3.0 * modulus(young) * math.sqrt(radius)


@pytest.fixture
def attempt(run, simulate):
    """Run a scene of tests/hard or a path with settings; what it wrote, or its refusal."""

    def attempt_it(scene, *sets, refused=False):
        path = scene if isinstance(scene, Path) else HARD / f"{scene}.nml"
        if not refused:
            return simulate(path, *sets)
        options = [word for text in sets for word in ("--set", text)]
        result = run("run", path, "-o", "out.h5", "--force", "-q", *options, timeout=600)
        assert result.status in (1, 2), result.out
        return result

    return attempt_it


@pytest.fixture
def evaluate(run):
    """Columns that `contensou eval` writes for rows of numbers."""

    def evaluate_it(kernel, header, rows, *options):
        text = "\n".join([header, *(",".join(map(repr, map(float, row))) for row in rows)])
        result = run("eval", kernel, *options, input=text + "\n")
        assert result.status == 0, result.err
        table = list(csv.DictReader(io.StringIO(result.out)))
        return {name: np.array([float(row[name]) for row in table]) for name in table[0]}

    return evaluate_it


@pytest.fixture
def picture(request):
    """Draw curves into the folder CONTENSOU_PICTURES, if set: picture(x, {label: y}, ...)."""
    folder = os.environ.get("CONTENSOU_PICTURES")

    def draw(x, curves, xlabel, ylabel, log="", style="-"):
        if not folder:
            return
        import matplotlib as mpl

        mpl.use("Agg")
        import matplotlib.pyplot as plt

        sys.path.insert(0, str(PAGE.parents[1] / "scripts"))
        from lib import style as looks

        looks.apply()
        figure, axes = plt.subplots(figsize=(6.9, 3.9))
        # Many lines are members of a family, in its order.
        family = plt.get_cmap("viridis")(np.linspace(0, 0.9, len(curves)))
        colours = looks.CYCLE if len(curves) <= 4 else family
        for i, (label, y) in enumerate(curves.items()):
            abscissa, y = (x[label], y) if isinstance(x, dict) else (x, y)
            # Of lines that lie on each other both are seen.
            width = 1.2 if i or len(curves) > 2 else 2.4
            axes.plot(abscissa, y, style, color=colours[i], label=label, ms=3.5, lw=width)
        axes.set(xlabel=xlabel, ylabel=ylabel)
        axes.set_title(name_of(request.function).replace("-", " ").capitalize())
        for letter, axis in (("x", axes.xaxis), ("y", axes.yaxis)):
            if letter in log:
                looks.log_scale(axis)
        if "y" not in log:
            looks.hold_scale(axes, max(np.abs(y).max() for y in curves.values()))
        if len(curves) > 1:
            looks.legend_beside(axes)
        picture_path = Path(folder) / f"{name_of(request.function)}.png"
        figure.savefig(picture_path, dpi=90, bbox_inches="tight")
        plt.close(figure)

    return draw


def name_of(function):
    """Name of a case: that of its test."""
    return function.__name__.removeprefix("test_").replace("_", "-")


# ---- Touching ----------------------------------------------------------------------------------


def test_grazing_touch(attempt, picture):
    """A ball is thrown up to a ceiling which it only just reaches, with an excess of height
    from a millimetre down to 1e-13 m.

    Passes if down to 1e-12 m there is one touch and one lift-off, within 1e-6 of the duration
    of the flight where a throw has them, if a ball that stays 1e-12 m below touches nothing,
    if the energy closes to 1e-8 and if no run takes more than 4000 steps.
    """
    reach = 1.962**2 / (2.0 * GRAVITY)
    excesses, errors, steps = 10.0 ** -np.arange(3.0, 14.0), [], []
    for excess in excesses.tolist():
        ball = attempt("ceiling", f"ceiling.centre = 0, 0, {reach + 0.02 - excess!r}")
        speed = math.sqrt(2.0 * GRAVITY * excess)
        energy = ball.energy()
        assert np.abs(energy - energy[0]).max() <= 1e-8 * energy[0]
        steps.append(ball.steps)
        errors.append(math.nan)
        if excess > 5e-13:
            assert [kind for _, kind, _ in ball.events] == ["touch", "lift"], excess
            errors[-1] = abs(ball.events[0][0] - (1.962 - speed) / GRAVITY)
    missed = attempt("ceiling", f"ceiling.centre = 0, 0, {reach + 0.02 + 1e-12!r}")
    assert not missed.events
    picture(
        excesses,
        {"error of the time of touch": errors, "steps": steps},
        "excess of height [m]",
        "error [s], number of steps",
        "xy",
        "o-",
    )
    assert np.nanmax(errors) <= 1e-6 * 0.4
    assert max(steps) <= 4000


def test_approach_from_rounding_to_the_limit(attempt, picture):
    """A ball starts with an overlap from 1e-15 m to a tenth of its radius, and with a little
    more.

    Passes if the force is that of Hertz to the rounding of the position (4 units of it), and
    if an overlap beyond a tenth of the radius is refused by a message that says so.
    """
    young = 9.1e9
    overlaps = np.append(10.0 ** np.arange(-15.0, -2.0), 0.1 * RADIUS * (1 - 1e-12))
    found = []
    for overlap in overlaps.tolist():
        z = RADIUS - overlap
        ball = attempt("ball", f"body.position = 0, 0, {z!r}", "scene.t_end = 1e-9")
        found.append(ball.normal_force[0, 0])
        rounding = 4.0 * np.spacing(RADIUS) / overlap
        expected = stiffness(young) * (RADIUS - z) ** 1.5
        assert found[-1] == pytest.approx(expected, rel=1e-14 + 1.5 * rounding)
    picture(overlaps, {"force": found}, "overlap [m]", "force [N]", "xy", "o-")
    result = attempt("ball", f"body.position = 0, 0, {0.899 * RADIUS!r}", refused=True)
    assert result.status == 2
    assert "tenth" in result.err or "at most" in result.err
    assert "touch" in result.err


def test_too_deep_on_the_way(attempt, picture):
    """A ball hits the floor so fast that it would sink in by more than a tenth of its radius.

    Passes if the run ends with a message that names the contact, its depth and the limit, at
    the time when the limit is reached, to 1e-6 of it, while slower balls stay inside.
    """
    result = attempt("ball", "body.velocity = 0, 0, -300", refused=True)
    assert result.status == 1
    assert "'touch'" in result.err
    assert "gap -0.002000 m" in result.err
    assert "deeper than 0.00200 m, a tenth of its radius" in result.err
    time = float(re.search(r"failed at t = (\S+) s", result.err)[1])
    # Time of fall through the limit, int dx / v(x) with (1/2) m v^2 + (2/5) k x^(5/2) constant.
    x = (np.arange(2000) + 0.5) / 2000 * 0.1 * RADIUS
    speed = np.sqrt(300.0**2 - 0.8 * stiffness(9.1e9) / MASS * x**2.5)
    assert time == pytest.approx(0.1 * RADIUS / 2000 * (1.0 / speed).sum(), rel=1e-6)
    speeds = np.array([10.0, 30.0, 60.0, 90.0, 130.0])
    depths = [
        -attempt(
            "ball",
            f"body.velocity = 0, 0, {-v!r}",
            "scene.t_end = 1.5e-4",
            "output.interval = 5e-7",
        ).gap.min()
        for v in speeds.tolist()
        if (1.25 * MASS * v**2 / stiffness(9.1e9)) ** 0.4 < 0.1 * RADIUS
    ]
    assert len(depths) >= 2
    picture(
        speeds[: len(depths)],
        {"largest overlap": depths, "limit": [0.1 * RADIUS] * len(depths)},
        "speed [m/s]",
        "overlap [m]",
        "",
        "o-",
    )


@pytest.mark.parametrize("method", ["cvode_bdf", "cvode_adams", "explicit8"])
def test_impacts_from_slow_to_fast(attempt, picture, method):
    """A steel ball hits the floor without gravity at speeds from 1e-6 to 100 m/s.

    Passes if it leaves with the speed it came with, to 1e-6, after the contact time of Hertz,
    2.9433 d/v with the largest overlap d, to 1e-6, and the energy closes to 1e-6.
    """
    speeds, contact_times, expected = 10.0 ** np.arange(-6.0, 3.0), [], []
    young, radius = 2.1e11, 0.01
    mass = 7800.0 * 4.0 / 3.0 * math.pi * radius**3
    k = stiffness(young, radius)
    beta = math.sqrt(math.pi) * math.gamma(0.4) / math.gamma(0.9) * 0.8
    for speed in speeds.tolist():
        depth = (1.25 * mass * speed**2 / k) ** 0.4
        assert depth < 0.1 * radius
        duration = beta * depth / speed
        gap = 0.1 * depth
        ball = attempt(
            "ball",
            "scene.gravity = 0, 0, 0",
            f"scene.t_end = {2.0 * duration!r}",
            f"body.mass = {mass!r}",
            f"body.position = 0, 0, {radius + gap!r}",
            f"body.velocity = 0, 0, {-speed!r}",
            f"skin.radius = {radius!r}",
            f"wood.young = {young!r}",
            f"integrator.method = '{method}'",
            f"integrator.velocity_scale = {speed!r}",
            f"integrator.length_scale = {depth!r}",
            "integrator.rtol = 1e-9",
        )
        assert [kind for _, kind, _ in ball.events] == ["touch", "lift"]
        contact_times.append(ball.events[1][0] - ball.events[0][0])
        expected.append(duration)
        assert ball.velocity[-1, 0, 2] == pytest.approx(speed, rel=1e-6)
        energy = ball.energy()
        assert np.abs(energy - energy[0]).max() <= 1e-6 * energy[0]
    picture(
        speeds,
        {"found": contact_times, "Hertz": expected},
        "speed [m/s]",
        "contact time [s]",
        "xy",
        "o-",
    )
    # A gap is a difference of lengths of 1e-2 m: at 1e-6 m/s its rounding is 1e-12 s of 1e-4 s.
    assert contact_times == pytest.approx(expected, rel=1e-6)


def test_soft_and_stiff_materials(attempt, picture):
    """A ball drops on the floor with effective moduli E* from 1e4 to 1e13 Pa.

    Passes if the contact time is that of Hertz without gravity, to 1e-6, and the energy
    closes to 1e-6.
    """
    moduli, found, expected = 10.0 ** np.arange(4.0, 14.0), [], []
    beta = math.sqrt(math.pi) * math.gamma(0.4) / math.gamma(0.9) * 0.8
    speed = 0.01
    for effective in moduli.tolist():
        young = effective * 2.0 * (1.0 - POISSON**2)
        depth = (1.25 * MASS * speed**2 / stiffness(young)) ** 0.4
        duration = beta * depth / speed
        if depth > 0.1 * RADIUS:
            continue
        ball = attempt(
            "ball",
            "scene.gravity = 0, 0, 0",
            f"scene.t_end = {2.0 * duration!r}",
            f"body.position = 0, 0, {RADIUS + 0.1 * depth!r}",
            f"body.velocity = 0, 0, {-speed!r}",
            f"wood.young = {young!r}",
            "integrator.rtol = 1e-9",
        )
        assert [kind for _, kind, _ in ball.events] == ["touch", "lift"]
        found.append(ball.events[1][0] - ball.events[0][0])
        expected.append(duration)
        energy = ball.energy()
        assert np.abs(energy - energy[0]).max() <= 1e-6 * energy[0]
    assert len(found) == len(moduli)
    picture(
        moduli,
        {"found": found, "Hertz": expected},
        "effective modulus E* [Pa]",
        "contact time [s]",
        "xy",
        "o-",
    )
    assert found == pytest.approx(expected, rel=1e-6)


def test_masses_from_dust_to_boulders(attempt, picture, slow_build):
    """Seven balls of one density, from 1e-12 kg to 1e6 kg, bounce on the floor of one scene.

    Passes if each touches when it must, to 1e-9 s, leaves with 0.8 of its speed, to 4 % (the
    weight of the large ones counts), and has in no flight more energy than before, to 1e-6 of
    what it fell with.
    """
    t_end = 0.02 if slow_build else 0.06
    balls = attempt("masses", f"scene.t_end = {t_end}", "output.interval = 1e-5")
    ratios, radii, seen = [], [], []
    for body, power in enumerate(range(-12, 7, 3)):
        radius = (3.0 * 10.0**power / (4.0 * math.pi * 2500.0)) ** (1.0 / 3.0)
        name = f"c_m{power:+d}".replace("+", "p").replace("-", "m")
        drop = balls.position[0, body, 2] - radius
        fall = math.sqrt(2.0 * drop / GRAVITY)
        touches = balls.times("touch", name)
        speed, height = balls.velocity[:, body, 2], balls.position[:, body, 2] - radius
        energy = (0.5 * speed**2 + GRAVITY * height)[balls.gap[:, body] > 0.0]
        assert np.diff(energy).max() <= 1e-6 * GRAVITY * drop, power
        if fall > t_end:
            assert len(touches) == 0
            continue
        assert touches[0] == pytest.approx(fall, abs=1e-9)
        lifts = balls.times("lift", name)
        if len(touches) > 1:
            flight = touches[1] - lifts[0]
            ratios.append(GRAVITY * flight / 2.0 / (GRAVITY * fall))
            radii.append(radius)
            seen.append(len(touches))
    assert len(ratios) >= (4 if slow_build else 5)
    picture(
        radii,
        {"restitution of the first bounce": ratios},
        "radius [m]",
        "speed after over speed before [-]",
        "x",
        "o-",
    )
    # Below 1e-3 m/s the coefficient is that of this speed.
    fast = np.sqrt(2.0 * GRAVITY * 0.01 * np.array(radii)) > 1e-3
    assert np.array(ratios)[fast] == pytest.approx(0.8, rel=0.04)
    assert np.diff(balls.mechanical()).max() <= 1e-8 * balls.mechanical()[0]
    assert balls.summary["energy_error_relative"] <= 1e-9


def test_lightly_damped_steel(attempt, picture):
    """A steel ball bounces with light damping some thousand times on its floor, by an
    explicit method whose step in flight is a hundred times that in contact.

    Passes if the energy closes to 1e-7 and never grows by more than 1e-9 of it; a step into
    the floor whose error estimate sees only the flight would break it.
    """
    ball = attempt(
        "ball",
        "scene.t_end = 3",
        "wood.young = 2.1e11",
        "body.position = 0, 0, 0.02001",
        DAMPED,
        "contact.damping_coefficient = 0.2",
        "integrator.method = 'explicit8'",
    )
    picture(ball.time, {"gap": ball.gap[:, 0] * 1e6}, "time [s]", "gap [µm]")
    assert len(ball.times("touch")) > 1000
    energy = ball.energy()
    assert np.abs(energy - energy[0]).max() <= 1e-7 * energy[0]
    assert np.diff(ball.mechanical()).max() <= 1e-9 * energy[0]


@pytest.mark.parametrize("method", ["cvode_bdf", "explicit8"])
def test_a_thousand_bounces(attempt, picture, method, slow_build, tmp_path):
    """Eighty balls with restitution 0.5 bounce ever faster until the elasticity of the floor
    ends it (Zeno): a thousand impacts between them.

    Passes if the first five bounces of each follow each other in the ratio 0.5, to 0.01, if
    all balls come to rest (1e-6 m/s), and if the whole takes less than 400 steps a bounce.
    """
    balls = 6 if slow_build or method == "cvode_bdf" else 80
    lines = [
        f"&scene gravity = 0, 0, {-GRAVITY}, t_end = 1.45 /",
        "&material name = 'hard', young = 1e13, poisson = 0.3 /",
        "&surface name = 'floor', body = 'ground', shape = 'plane', material = 'hard' /",
        f"&integrator method = '{method}', rtol = 1e-6 /",
        "&output interval = 1e-3 /",
    ]
    for i in range(balls):
        height = 0.01 + 0.5 + 0.5 * i / balls
        lines += [
            f"&body name = 'b{i}', mass = 0.0327, inertia = 3*1.31e-6,",
            f"   position = {i}, 0, {height} /",
            f"&surface name = 's{i}', body = 'b{i}', shape = 'sphere', radius = 0.01,",
            "   material = 'hard' /",
            f"&contact name = 'c{i}', surfaces = 'floor', 's{i}', damping = 'hunt_crossley',",
            "   restitution = 0.5 /",
        ]
    path = tmp_path / "zeno.nml"
    path.write_text("\n".join(lines) + "\n")
    found = attempt(path)
    counts = []
    for i in range(balls):
        touches = found.times("touch", f"c{i}")
        counts.append(len(touches))
        flights = np.diff(touches)
        ratios = flights[1:5] / flights[:4]
        assert ratios == pytest.approx(0.5, abs=0.01)
    picture(
        found.time,
        {f"ball {i}": found.gap[:, i] * 1e3 for i in range(0, balls, balls // 4)},
        "time [s]",
        "gap [mm]",
    )
    assert np.abs(found.velocity[-1]).max() <= 1e-6
    assert sum(counts) >= (1000 if balls == 80 else 12.5 * balls)
    assert found.steps <= 400 * sum(counts)


def test_heavy_damping_and_none(attempt, picture):
    """A ball sinks into its place with a damping of twenty times the critical one, and
    oscillates there with none.

    Passes if the damped one creeps in without overshoot at the rate k/c of the linear theory,
    to 3 %, and the undamped one keeps its energy to 1e-7 over five hundred periods at the
    period of the linear theory, to 1e-3.
    """
    young = 9.1e9
    k = stiffness(young)
    rest = (MASS * GRAVITY / k) ** (2.0 / 3.0)
    slope = 1.5 * k * math.sqrt(rest)
    zeta = 20.0
    damping = 2.0 * zeta * math.sqrt(slope * MASS)
    offset = 0.01 * rest
    omega = math.sqrt(slope / MASS)
    place = f"body.position = 0, 0, {RADIUS - rest + offset!r}"
    rate = omega * (zeta - math.sqrt(zeta**2 - 1.0))
    ball = attempt(
        "ball",
        place,
        "contact.damping = 'viscous'",
        f"contact.damping_coefficient = {damping / rest!r}",
        f"scene.t_end = {4.0 / rate!r}",
        "integrator.rtol = 1e-9",
    )
    height = (ball.position[:, 0, 2] - (RADIUS - rest)) / offset
    assert np.diff(height).max() <= 1e-5
    late = ball.time > 1.0 / rate
    assert np.polyfit(ball.time[late], np.log(height[late]), 1)[0] == pytest.approx(-rate, rel=0.03)
    period = 2.0 * math.pi / omega
    free = attempt(
        "ball",
        place,
        f"scene.t_end = {500.0 * period!r}",
        f"output.interval = {period / 20!r}",
        "integrator.method = 'explicit8'",
    )
    energy = free.energy()
    assert np.abs(energy - energy[0]).max() <= 1e-7 * energy[0]
    swing = free.position[:, 0, 2] - (RADIUS - rest)
    up = np.flatnonzero((swing[:-1] < 0) & (swing[1:] >= 0))
    crossing = free.time[up] - swing[up] * np.diff(free.time)[up] / (swing[up + 1] - swing[up])
    assert np.diff(crossing).mean() == pytest.approx(period, rel=1e-3)
    assert swing.max() == pytest.approx(offset, rel=0.01)
    picture(
        {"ζ = 20": ball.time * rate, "ζ = 0": free.time[:200] / free.time[199] * 4.0},
        {"ζ = 20": height, "ζ = 0": swing[:200] / offset},
        "time over that of the decay, or of two swings [-]",
        "height above rest over the first [-]",
    )


# ---- Friction ----------------------------------------------------------------------------------


def test_sliding_that_stops(attempt, picture):
    """A stool of three balls slides and turns, stops in both together, and rests for 100 s.

    Passes if sliding and turning stop within 2 ms of each other, if it then neither creeps
    (less than 1e-9 m) nor gains energy (1e-12 of the initial energy), and if the 100 s take
    at most a tenth more steps than the first 20 s (the most of five runs whose tolerances
    differ by a tenth, as the steps to the rest vary).
    """
    start = ("body.velocity = 0.3, 0.1, 0", "body.spin = 0, 0, 8")
    slide = attempt("stool", "scene.t_end = 0.3", *start)
    whole = attempt("stool", "scene.t_end = 100", "output.interval = 0.01", *start)
    speed = np.hypot(slide.velocity[:, 0, 0], slide.velocity[:, 0, 1])
    spin = np.abs(slide.angular_velocity[:, 0, 2])
    picture(
        slide.time,
        {"sliding": speed, "spin times 0.05 m": 0.05 * spin},
        "time [s]",
        "speed [m/s]",
        "y",
    )
    stops = [slide.time[np.flatnonzero(x > 1e-3 * x[0])[-1]] for x in (speed, spin)]
    assert abs(stops[0] - stops[1]) <= 2e-3
    resting = whole.time > 0.5
    place = whole.position[resting, 0]
    assert np.abs(place - place[0]).max() <= 1e-9
    assert np.abs(whole.quaternion[resting] - whole.quaternion[resting][0]).max() <= 1e-8
    assert np.diff(whole.mechanical()).max() <= 1e-12 * whole.mechanical()[0] + 1e-15
    steps = {
        t_end: max(
            attempt(
                "stool", f"scene.t_end = {t_end}", "output.interval = 0.01",
                f"integrator.rtol = {rtol:.1e}", *start,
            ).steps
            for rtol in (0.8e-8, 0.9e-8, 1.0e-8, 1.1e-8, 1.2e-8)
        )
        for t_end in (20, 100)
    }  # fmt: skip
    assert steps[100] <= 1.1 * steps[20]


@pytest.mark.sample(1)
@pytest.mark.parametrize("coefficient", [1.0, 10.0])
def test_long_rest_with_light_damping(attempt, picture, coefficient, slow_build):
    """A steel ball rings down on its floor with light damping and then rests for 100 s.

    Passes if it ends at the overlap of Hertz, to 1e-5 of it, and the last 90 s take fewer
    steps than the first 10 s: the orders of BDF that ring themselves are given up.
    """
    t_end = 20.0 if slow_build else 100.0
    sets = (
        "wood.young = 2.1e11",
        "body.position = 0, 0, 0.020001",
        DAMPED,
        f"contact.damping_coefficient = {coefficient}",
    )
    first = attempt("ball", "scene.t_end = 10", *sets)
    whole = attempt("ball", f"scene.t_end = {t_end}", *sets)
    rest = (MASS * GRAVITY / stiffness(2.1e11)) ** (2.0 / 3.0)
    picture(
        first.time[1:],
        {"gap": np.abs(first.gap[1:, 0] + rest)},
        "time [s]",
        "distance from rest [m]",
        "y",
    )
    assert -whole.gap[-1, 0] == pytest.approx(rest, rel=1e-5)
    assert whole.steps < 2 * first.steps


def test_incline_below_and_above_the_friction_angle(attempt, picture, slow_build):
    """A stool stands on inclines with tangents from 0.1 to 0.29 and slides on some from 0.31
    to 0.6; the friction coefficient is 0.3.

    Passes if below the angle of friction it creeps by less than 1e-6 m/s and above it the
    acceleration is that of Coulomb's law, to 0.5 %.
    """
    tangents = (0.1, 0.2, 0.29, 0.31, 0.4, 0.6)
    speeds, curves, times = [], {}, {}
    t_end = 0.5 if slow_build else 2.0
    for tangent in tangents:
        angle = math.atan(tangent)
        stool = attempt(
            "stool",
            f"scene.t_end = {t_end}",
            f"scene.gravity = {GRAVITY * math.sin(angle)!r}, 0, {-GRAVITY * math.cos(angle)!r}",
            "body.velocity = 0.01, 0, 0",
        )
        x, v, t = stool.position[:, 0, 0], stool.velocity[:, 0, 0], stool.time
        late = t > 0.5 * t_end
        times[f"tan α = {tangent}"], curves[f"tan α = {tangent}"] = t[1:], np.abs(x[1:])
        if tangent < 0.3:
            creep = np.polyfit(t[late], x[late], 1)[0]
            speeds.append(creep)
            assert abs(creep) <= 1e-6, tangent
        else:
            expected = GRAVITY * (math.sin(angle) - 0.3 * math.cos(angle))
            assert np.polyfit(t[late], v[late], 1)[0] == pytest.approx(expected, rel=5e-3)
    picture(times, curves, "time [s]", "distance slid [m]", "y")


def test_spin_without_sliding_and_sliding_without_spin(attempt, picture):
    """A ball spins about the normal without any sliding until friction has stopped it; it
    slides without any spin until it rolls.

    Passes if the first one's spin falls linearly with the torque 3 pi/16 f N a, to 1e-6, and
    it neither moves nor reverses, and if the second one slows down by f g, to 1e-9, until 2
    v/(7 f g), and then rolls with 5/7 of its speed, to 1e-4, and never spins.
    """
    young, coefficient = 9.1e9, 0.3
    rest = (MASS * GRAVITY / stiffness(young)) ** (2.0 / 3.0)
    place = f"body.position = 0, 0, {RADIUS - rest!r}"
    damped = (DAMPED, "contact.damping_coefficient = 100")
    torque = 3.0 * math.pi / 16.0 * coefficient * MASS * GRAVITY * math.sqrt(RADIUS * rest)
    stop = 1.0
    spin = torque / 8.0e-6 * stop
    top = attempt(
        "ball", place, f"body.spin = 0, 0, {spin!r}", "scene.t_end = 1.5", *damped, *RUBBED
    )
    falling = top.time < 0.999 * stop
    expected = spin * (1.0 - top.time[falling] / stop)
    assert np.abs(top.angular_velocity[falling, 0, 2] - expected).max() <= 1e-6 * spin
    assert np.abs(top.angular_velocity[top.time > 1.001 * stop, 0, 2]).max() <= 1e-6 * spin
    assert top.angular_velocity[:, 0, 2].min() >= -1e-6 * spin
    assert np.abs(top.position[:, 0, :2]).max() <= 1e-15
    speed = 0.5
    rolls = 2.0 * speed / (7.0 * coefficient * GRAVITY)
    ball = attempt(
        "ball", place, f"body.velocity = {speed}, 0, 0", "scene.t_end = 0.1", *damped, *RUBBED
    )
    early = ball.time < 0.98 * rolls
    slowed = speed - coefficient * GRAVITY * ball.time[early]
    assert ball.velocity[early, 0, 0] == pytest.approx(slowed, rel=1e-9)
    late = ball.time > 1.02 * rolls
    assert ball.velocity[late, 0, 0] == pytest.approx(5.0 / 7.0 * speed, rel=1e-4)
    assert np.abs(ball.angular_velocity[:, 0, 2]).max() <= 1e-12
    picture(
        {"spin": top.time / stop, "sliding": ball.time / rolls},
        {"spin": top.angular_velocity[:, 0, 2] / spin, "sliding": ball.velocity[:, 0, 0] / speed},
        "time over that of the stop [-]",
        "velocity over the first [-]",
    )


def test_passage_through_zero_sliding_and_zero_spin(attempt, picture):
    """A guided ball spins while its sliding passes through zero, and slides while its spin
    does.

    Passes if force and torque are odd or even about the passage, to 1e-8, and the force is
    monotone where it changes sign.
    """
    slide = attempt("guided", "integrator.rtol = 1e-12")
    spin = attempt(
        "guided",
        "ball.final_velocity = 0.1, 0, 0",
        "ball.final_angular_velocity = 0, 0, -100",
        "integrator.rtol = 1e-12",
    )
    force, torque = slide.friction_force[:, 0, 0], slide.friction_torque[:, 0]
    largest = 0.3 * slide.normal_force[0, 0]
    assert np.abs(force + force[::-1]).max() <= 1e-8 * largest
    assert np.abs(torque - torque[::-1]).max() <= 1e-8 * np.abs(torque).max()
    assert np.abs(force).max() == pytest.approx(largest, rel=2e-2)
    assert (np.diff(force) * np.sign(force[-1] - force[0]) >= -1e-12 * largest).all()
    spun = spin.friction_torque[:, 0]
    assert np.abs(spun + spun[::-1]).max() <= 1e-8 * np.abs(spun).max()
    assert np.abs(spun[len(spun) // 2]) <= 1e-8 * np.abs(spun).max()
    middle = spin.friction_force[len(spun) // 2, 0]
    assert np.linalg.norm(middle) == pytest.approx(0.3 * spin.normal_force[0, 0], rel=1e-9)
    picture(
        slide.time * 1e3,
        {"force, v through zero": force / largest, "torque, ω through zero": spun / spun.max()},
        "time [ms]",
        "load over the largest [-]",
    )


def test_rotation_centre_on_the_rim(attempt, evaluate, picture):
    """The rotation centre crosses the rim of the spot, and sits on it to the last digit.

    Passes if force and torque have no step there and no kink (the slopes on both sides agree to
    2e-3), nor, on spots down to b/a = 0.3, a step of the second derivative, and if a guided ball
    may stay there.
    """
    a = b = 1e-3
    for k in (1.0, 0.3, 0.01):
        ratio = np.concatenate(
            [1.0 + np.arange(-400, 401) * 2.5e-4, 1.0 + np.arange(-8, 9) * 2e-16]
        )
        b = k * a
        for column in (0, 1):
            rows = [
                [10.0, a, b, 0.3, *((u * b, 0.0) if column else (0.0, u * a)), 1.0] for u in ratio
            ]
            found = evaluate("wrench", "N,a,b,f,vx,vy,w", rows, "--model", "contensou_exact")
            force = np.hypot(found["Fx"], found["Fy"])
            for y, scale in ((force, 3.0), (found["Tz"], 3.0 * a)):
                assert np.isfinite(y).all()
                assert np.ptp(y[801:]) <= 1e-13 * scale
                assert np.abs(np.diff(y[:801], 2)).max() / 2.5e-4 <= 2e-3 * scale
                # What is left of a step of the second derivative would not shrink with the spacing.
                coarse, fine = (
                    np.abs(np.diff(z, 3)).max() / h**2
                    for z, h in ((y[:801:4], 1e-3), (y[:801], 2.5e-4))
                )
                if k >= 0.3:
                    assert fine <= 0.6 * coarse
    ball = attempt("guided", "scene.t_end = 1e-4", "output.interval = 1e-6")
    half_axis = float(ball.semi_axes[0, 0, 0])
    sitting = attempt(
        "guided",
        f"ball.velocity = {100.0 * half_axis!r}, 0, 0",
        f"ball.final_velocity = {100.0 * half_axis!r}, 0, 0",
    )
    # The slab gives way a little, and so the ball leaves the rim by and by.
    f = np.linalg.norm(sitting.friction_force[:, 0], axis=1) / (0.3 * sitting.normal_force[:, 0])
    # On the rim of a circle F = (3/4)(3/4)(pi/2), as both closed forms say.
    assert f == pytest.approx(9.0 * math.pi / 32.0, rel=1e-9)
    picture(
        ratio[:801],
        {"force, F/(f N)": force[:801] / 3, "torque, T/(f N a)": -found["Tz"][:801] / 3 / a},
        "sliding over that with the centre on the rim [-]",
        "load [-]",
    )


def test_spots_from_circle_to_needle(attempt, evaluate, picture):
    """Ellipsoids drop on a floor and rub, with spots from a circle to one a thousand times as
    long as wide.

    Passes if on a body that falls upright the semi-axes of the spot and the force are those
    of `contensou eval hertz`, to 1e-10, and if the energy of one that also slides and turns
    closes to 1e-7.
    """
    lengths = np.array([1.0, 2.0, 5.0, 20.0, 100.0, 400.0])
    ratios = []
    star = 2.1e11 / (2.0 * (1.0 - 0.3**2))
    for length in lengths.tolist():
        shape = (f"skin.semi_axes = {0.01 * length!r}, 0.01, 0.01", "scene.t_end = 3e-3")
        rubbing = attempt("egg", *shape)
        energy = rubbing.energy()
        assert np.abs(energy - energy[0]).max() <= 1e-7 * energy[0]
        assert (rubbing.gap[:, 0] < 0).any()
        egg = attempt(
            "egg",
            *shape,
            "body.velocity = 0, 0, 0",
            "body.spin = 0, 0, 0",
            "contact.restitution = 1.0",
        )
        closed = egg.gap[:, 0] < 0
        assert closed.any()
        depths = -egg.gap[closed, 0]
        table = evaluate(
            "hertz",
            "A,B,Estar,delta",
            [[0.5 / 0.01 / length**2, 0.5 / 0.01, star, depth] for depth in depths],
        )
        assert egg.normal_force[closed, 0] == pytest.approx(table["N"], rel=1e-10)
        assert egg.semi_axes[closed, 0, 0] == pytest.approx(table["a"], rel=1e-10)
        assert egg.semi_axes[closed, 0, 1] == pytest.approx(table["b"], rel=1e-10)
        ratios.append(table["b"][0] / table["a"][0])
    assert ratios[0] == pytest.approx(1.0, rel=1e-12)
    assert ratios[-1] < 1e-3
    picture(
        lengths,
        {"b/a": ratios},
        "ratio of the semi-axes of the body [-]",
        "b/a of the spot [-]",
        "xy",
        "o-",
    )


def test_curvature_ratio_sweeps_from_one_to_a_millionth(attempt, evaluate, picture):
    """Two rods lie across each other and one turns until the ratio of the curvatures has gone
    from 1 to 1e-6.

    Passes if force and semi-axes follow `contensou eval hertz` to 1e-9 all the way, the
    energy that is supplied is lost or stored, to 1e-6 of the initial one, and rods that get
    parallel end in a message.
    """
    rods = attempt("rods", "integrator.rtol = 1e-10")
    angle = 2.0 * np.arctan2(rods.quaternion[:, 0, 3], rods.quaternion[:, 0, 0])
    other = 2.0 * np.arctan2(rods.quaternion[:, 1, 3], rods.quaternion[:, 1, 0])
    angle = angle - other
    g = np.tan(angle / 2.0) ** 2
    # Of crossed rods of radius R: A + B = 1/R, B - A = cos(angle)/R.
    large, small = (1 + np.cos(angle)) / 2 / 0.01, (1 - np.cos(angle)) / 2 / 0.01
    delta = -rods.gap[:, 0]
    star = 2.1e11 / (2.0 * (1.0 - 0.3**2))
    table = evaluate(
        "hertz",
        "A,B,Estar,delta",
        [[x, y, star, d] for x, y, d in zip(small, large, delta, strict=True)],
    )
    assert g[0] == pytest.approx(1.0, rel=1e-9)
    assert g[-1] == pytest.approx(1e-6, rel=0.01)
    picture(
        g,
        {"a": rods.semi_axes[:, 0, 0], "b": rods.semi_axes[:, 0, 1]},
        "ratio of curvatures A/B [-]",
        "semi-axis of the spot [m]",
        "xy",
    )
    assert rods.normal_force[:, 0] == pytest.approx(table["N"], rel=1e-9)
    assert rods.semi_axes[:, 0, 0] == pytest.approx(table["a"], rel=1e-9)
    assert rods.semi_axes[:, 0, 1] == pytest.approx(table["b"], rel=1e-9)
    assert rods.summary["energy_error_relative"] <= 1e-6
    result = attempt("rods", "scene.t_end = 0.0102", refused=True)
    assert "'touch'" in result.err
    assert "conform" in result.err or "parallel" in result.err


def test_regularization_from_coarse_to_fine(attempt, picture, slow_build):
    """A ball slides until it rolls, with regularized Coulomb friction of delta from 1 to 1e-9
    m/s.

    Passes if for delta of 1e-2 m/s and below it rolls with 5/7 of its speed, to 1e-4, if with
    delta of 1 m/s the slip decays exponentially at the rate of the linear law, to 1e-3, and
    if no run gains energy (1e-12 J).
    """
    speed, coefficient = 0.5, 0.3
    rest = (MASS * GRAVITY / stiffness(9.1e9)) ** (2.0 / 3.0)
    curves, times = {}, {}
    for power in range(0, -10, -3 if slow_build else -1):
        delta = 10.0**power
        ball = attempt(
            "ball",
            f"body.position = 0, 0, {RADIUS - rest!r}",
            f"body.velocity = {speed}, 0, 0",
            DAMPED,
            "contact.damping_coefficient = 100",
            "contact.friction = 'coulomb'",
            f"contact.friction_coefficient = {coefficient}",
            f"contact.regularization_velocity = {delta!r}",
            "scene.t_end = 0.2",
        )
        slip = ball.slip_velocity[:, 0, 0]
        times[f"δ = {delta:g}"], curves[f"δ = {delta:g}"] = ball.time, np.abs(slip) + 1e-12
        assert np.diff(ball.mechanical()).max() <= 1e-12
        if power == 0:
            rate = 3.5 * coefficient * GRAVITY / delta
            assert slip == pytest.approx(speed * np.exp(-rate * ball.time), rel=1e-3)
        elif power <= -2:
            assert ball.velocity[-1, 0, 0] == pytest.approx(5.0 / 7.0 * speed, rel=1e-4)
    picture(times, curves, "time [s]", "slip [m/s]", "y")


# ---- Bodies ------------------------------------------------------------------------------------


def test_a_million_revolutions(attempt, picture, slow_build):
    """A body makes a million revolutions, nothing touching it.

    Passes if its attitude is right to 2e-3 of a turn after all of them and its energy to
    1e-9.
    """
    revolutions = 1e4 if slow_build else 1e6
    spin = 1000.0
    t_end = 2.0 * math.pi * revolutions / spin
    body = attempt(
        "free",
        f"body.spin = 0, 0, {spin}",
        "body.inertia = 1e-3, 1e-3, 1.5e-3",
        f"scene.t_end = {t_end!r}",
        "integrator.rtol = 1e-8",
    )
    w, z = body.quaternion[:, 0, 0], body.quaternion[:, 0, 3]
    turned = 2.0 * np.arctan2(z, w)
    off = np.angle(np.exp(1j * (turned - spin * body.time))) / (2.0 * math.pi)
    picture(
        body.time[1:] * spin / 2 / math.pi,
        {"error": np.abs(off[1:])},
        "revolutions [-]",
        "error [turns]",
        "xy",
    )
    assert np.abs(np.linalg.norm(body.quaternion[:, 0], axis=1) - 1.0).max() <= 1e-14
    assert np.abs(off).max() <= 2e-3
    energy = body.energy_kinetic
    assert np.abs(energy - energy[0]).max() <= 1e-9 * energy[0]


def test_middle_axis(attempt, picture):
    """A body spins about its middle axis and tumbles.

    Passes if energy and angular momentum stay to 1e-9 and it turns over at the intervals of
    Euler's equations (a complete elliptic integral), to 1e-7.
    """
    inertia = np.array([1.0e-3, 2.0e-3, 2.5e-3])
    start = np.array([0.01, 10.0, 0.01])
    body = attempt(
        "free", "body.spin = " + ", ".join(map(repr, start.tolist())), "scene.t_end = 20"
    )
    w, x, y, z = body.quaternion[:, 0].T
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    ).transpose(2, 0, 1)
    rates = np.einsum("tji,tj->ti", rotation, body.angular_velocity[:, 0])
    momentum = np.einsum("tij,tj->ti", rotation, inertia * rates)
    assert np.abs(momentum - momentum[0]).max() <= 1e-9 * np.linalg.norm(momentum[0])
    energy = body.energy_kinetic
    assert np.abs(energy - energy[0]).max() <= 1e-9 * energy[0]
    # Landau, Lifshitz, Mechanics, section 37: period 4 K sqrt(I1 I2 I3/((I3 - I2)(M^2 - 2 E I1))).
    first, middle, last = inertia
    twice = (inertia * start**2).sum()
    square = ((inertia * start) ** 2).sum()
    if square < twice * middle:
        first, last = last, first
    m = (middle - first) * (twice * last - square) / ((last - middle) * (square - twice * first))
    mean, other = 1.0, math.sqrt(1.0 - m)
    while abs(mean - other) > 1e-15:
        mean, other = 0.5 * (mean + other), math.sqrt(mean * other)
    quarter = math.pi / (2.0 * mean)
    half = (
        2.0 * quarter * math.sqrt(inertia.prod() / abs((last - middle) * (square - twice * first)))
    )
    picture(body.time, {"rate": rates[:, 1]}, "time [s]", "rate about the middle axis [rad/s]")
    sign = np.flatnonzero(rates[:-1, 1] * rates[1:, 1] < 0)
    flips = []
    for i in sign:
        j = slice(i - 3, i + 5)
        flips.append(
            np.interp(0, [0, 1], [0, 1])
            + np.polyval(np.polyfit(rates[j, 1] * np.sign(rates[i + 4, 1]), body.time[j], 7), 0.0)
        )
    assert len(flips) >= 4
    assert np.diff(flips) == pytest.approx(half, rel=1e-7)


def test_light_top_through_its_bounces(attempt, picture, inputs, slow_build):
    """The Tippe-Top with light damping (0.2 s/m), which bounces a thousand times a second
    when its stem touches.

    Passes if it turns over, the energy closes to 1e-6 and never grows by more than 1e-8 of
    it.
    """
    t_end = 0.3 if slow_build else 4.0
    top = attempt(
        inputs / "tippe_top.nml",
        "contact.damping_coefficient = 0.2",
        f"scene.t_end = {t_end}",
        "integrator.method = 'explicit8'",
    )
    _, x, y, _ = top.quaternion[:, 0].T
    upright = 1 - 2 * (x * x + y * y)
    theta = np.degrees(np.arccos(np.clip(upright, -1, 1)))
    picture(top.time, {"inclination": theta}, "time [s]", "inclination [°]")
    assert top.summary["energy_error_relative"] <= 1e-6
    assert np.diff(top.mechanical()).max() <= 1e-8 * top.mechanical()[0]
    if not slow_build:
        assert theta[-1] > 150.0
        assert len(top.times("touch", "stem_floor")) > 1


def test_bearing_from_rest_in_a_millisecond(attempt, picture):
    """The inner ring of a bearing of three balls goes from rest to 100 rad/s in a
    millisecond.

    Passes if the balls then roll with the speeds of a planetary gear, to 1 %, keep their
    place in the grooves, to 1e-6 m, and the energy closes to 1e-5 of the initial one.
    """
    bearing = attempt("bearing")
    # Contact circles of the grooves, ball of 4 mm on a pitch of 20 mm; the outer ring stands.
    place = bearing.position[:, 1]
    orbit = np.unwrap(np.arctan2(place[:, 1], place[:, 0]))
    late = bearing.time > 0.004
    picture(
        bearing.time * 1e3,
        {
            "inner ring": bearing.angular_velocity[:, 0, 2],
            "ball about the axis": np.gradient(orbit, bearing.time),
            "ball about itself": bearing.angular_velocity[:, 1, 2],
        },
        "time [ms]",
        "angular velocity [rad/s]",
    )
    assert np.polyfit(bearing.time[late], orbit[late], 1)[0] == pytest.approx(40.0, rel=0.01)
    assert bearing.angular_velocity[late, 1, 2] == pytest.approx(-200.0, rel=0.01)
    assert np.abs(np.hypot(place[:, 0], place[:, 1]) - 0.02).max() <= 1e-6
    assert np.abs(place[:, 2]).max() <= 1e-9
    assert bearing.summary["energy_error_relative"] <= 1e-5


# ---- Time and tolerance ------------------------------------------------------------------------


@pytest.mark.parametrize("method", ["cvode_bdf", "cvode_adams", "explicit8"])
def test_nothing_happens_for_a_day(attempt, picture, method):
    """A body drifts through space for 1e5 s.

    Passes if it is where it must be, to 1e-9 of its way, after fewer than 2000 steps.
    """
    body = attempt(
        "free", "scene.t_end = 1e5", "body.velocity = 1, 2, 3", f"integrator.method = '{method}'"
    )
    expected = body.time[:, None] * np.array([1.0, 2.0, 3.0])
    picture(body.time, {"x": body.position[:, 0, 0]}, "time [s]", "distance [m]")
    assert np.abs(body.position[:, 0] - expected).max() <= 1e-9 * 3e5
    assert body.steps < 2000


def test_nothing_happens_on_the_floor(attempt, picture):
    """A ball rests on the floor for 1e5 s.

    Passes if it stays at the overlap of Hertz, to 1e-6 of it, after fewer than 20000 steps.
    """
    rest = (MASS * GRAVITY / stiffness(9.1e9)) ** (2.0 / 3.0)
    ball = attempt(
        "ball",
        f"body.position = 0, 0, {RADIUS - rest!r}",
        "scene.t_end = 1e5",
        DAMPED,
        "contact.damping_coefficient = 100",
        *RUBBED,
    )
    picture(ball.time, {"": -ball.gap[:, 0] / rest}, "time [s]", "overlap over that of Hertz [-]")
    assert -ball.gap[:, 0] == pytest.approx(rest, rel=1e-6)
    assert ball.steps < 20000


@pytest.mark.sample(1)
@pytest.mark.parametrize("method", ["cvode_bdf", "cvode_adams", "explicit8"])
def test_tolerances_from_coarse_to_fine(attempt, picture, method):
    """A spinning ball hits the floor obliquely and bounces, with tolerances from 1e-3 to
    1e-13.

    Passes if at each tolerance the error of the final velocities stays below a multiple of
    it, 10 with explicit8, 1e3 with cvode_bdf and 1e4 with cvode_adams, and is less than 1e-8
    at the finest.
    """
    sets = (
        "body.position = 0, 0, 0.025",
        "body.velocity = 0.3, 0.1, 0",
        "body.spin = 5, 30, 20",
        DAMPED,
        "contact.restitution = 0.7",
        *RUBBED,
        "scene.t_end = 0.06",
        "output.interval = 1e-2",
    )

    def last(result):
        return np.concatenate([result.velocity[-1, 0], 0.02 * result.angular_velocity[-1, 0]])

    exact = last(
        attempt("ball", *sets, "integrator.method = 'explicit8'", "integrator.rtol = 3e-14")
    )
    tolerances, errors = 10.0 ** -np.arange(3.0, 14.0), []
    for tolerance in tolerances.tolist():
        found = attempt(
            "ball", *sets, f"integrator.method = '{method}'", f"integrator.rtol = {tolerance!r}"
        )
        errors.append(np.abs(last(found) - exact).max() / np.abs(exact).max())
    picture(
        tolerances,
        {"error": errors, "tolerance": tolerances},
        "tolerance [-]",
        "error [-]",
        "xy",
        "o-",
    )
    factor = {"explicit8": 10.0, "cvode_bdf": 1e3, "cvode_adams": 1e4}[method]
    assert (np.array(errors) <= factor * tolerances).all()
    assert errors[-1] <= 1e-8


# ---- The page ----------------------------------------------------------------------------------


def cases():
    """Name, what is done and when it passes, of each case in order."""
    tests = [value for name, value in globals().items() if name.startswith("test_")]
    found = []
    for function in tests:
        if function is not test_page:
            paragraphs = inspect.getdoc(function).split("\n\n")
            found.append((name_of(function), *(" ".join(text.split()) for text in paragraphs)))
    return found


def test_page():
    """The page of the hard cases says what the tests say, and shows a picture of each."""
    text = " ".join(PAGE.read_text().split())
    for name, done, passes in cases():
        assert done in text, name
        assert passes in text, name
        assert f"hard-cases/{name}.png" in text, name
        assert (PAGE.parent / "hard-cases" / f"{name}.png").is_file(), name
