"""Scenes that once were wrong without a word, or refused for nothing, drawn with other numbers.

    python tests/campaigns/cases.py [CASE [NUMBER [FIRST]]]

runs NUMBER (200) scenes of a CASE from the number FIRST (0) on, or of each case (`all`), and prints
how they ended, what is wrong, and the largest of what must be small. Exit status 1 if something is
wrong. CONTENSOU names the executable.

- `axes`: spots with and without friction have the axes of Hertz's ellipse.
- `hysteresis`: rolling in any direction loses (3/16) N sqrt((a w_y)^2 + (b w_x)^2) and no other.
- `legs`: three and four legs with friction, one of which touches while others slide.
- `table`: four legs without friction that land within rounding, with explicit8 and auto above all.
- `bore`: ellipsoids across and along a bore, of any length; the places by dense sampling.
- `impact`: impacts with friction against Routh's equations.
- `far`: balls 1e6 to 1e12 m from the origin: right, or refused for the rounding of a position.
"""

from __future__ import annotations

import math
import os
import random
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

import h5py
import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.special import beta, ellipe, ellipk

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "driver"))
sys.path.insert(0, str(Path(__file__).resolve().parent))
from places import Ellipsoid, frame, to_cylinder
from rigid_scenes import METHODS, RADIUS, attempt, ball_surface, body, words
from spots import Drop, drop

POISSON = 0.3
# Spot of an impact over its largest.
MEAN_SPOT = beta(6 / 5, 1 / 2) / 2


def simulated(executable, folder, text):
    """Status, what was said, rows and events of a scene; None where there is no output."""
    (folder / "scene.nml").write_text(text)
    done = subprocess.run(
        [executable, "run", "scene.nml", "-q", "--force"],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        return done.returncode, done.stderr, None, None
    with h5py.File(folder / "out.h5") as file:
        rows = {name: item[()] for name, item in file["trajectory"].items() if item.ndim}
        return 0, done.stderr, rows, file["events/time"][()]


def modulus(young):
    """Effective modulus of two bodies of one material."""
    return young / (2 * (1 - POISSON**2))


# ---- Axes of spots ------------------------------------------------------------------------------


def ellipse(load, young, small, large):
    """Semi-axes of Hertz's ellipse, major first, by the relative curvatures A and B."""
    if large - small < 1e-9 * large:
        radius = (3 * load / (8 * modulus(young) * large)) ** (1 / 3)
        return radius, radius

    def excess(log_ratio):
        k = math.exp(log_ratio)
        m = 1 - 1 / k**2
        return (k**2 * ellipe(m) - ellipk(m)) / (ellipk(m) - ellipe(m)) - large / small

    k = math.exp(brentq(excess, 1e-5, 12))
    m = 1 - 1 / k**2
    cube = 3 * load / (2 * math.pi * modulus(young) * m * large) * (k**2 * ellipe(m) - ellipk(m))
    return cube ** (1 / 3), cube ** (1 / 3) / k


def axes(seed, executable, folder):
    """A surface is pressed on another one that is at rest."""
    rng = random.Random(f"axes {seed}")
    kind = rng.choice(("ellipsoid on plane", "ellipsoid on ball", "ring", "rods", "bore"))
    young = 10 ** rng.uniform(8, 11)
    size = [rng.uniform(0.01, 0.05) * 10 ** rng.uniform(-0.5, 0.5) for _ in range(3)]
    ground = "shape = 'plane'"
    height, under = size[2], 0.0
    shape = f"shape = 'ellipsoid', semi_axes = {words(size)}"
    curved = [size[2] / size[0] ** 2, size[2] / size[1] ** 2]
    if kind == "ellipsoid on ball":
        under = rng.uniform(0.01, 0.1)
        ground = f"shape = 'sphere', radius = {under!r}, centre = 0, 0, {-under!r}"
        curved = [one + 1 / under for one in curved]
    elif kind == "ring":
        wire = min(size) / 2
        shape = (
            f"shape = 'torus', major_radius = {size[0]!r}, minor_radius = {wire!r},"
            " direction = 1, 0, 0"
        )
        height, curved = size[0] + wire, [1 / wire, 1 / (size[0] + wire)]
    elif kind == "rods":
        turn = rng.uniform(0.1, math.pi / 2)
        shape = f"shape = 'cylinder', radius = {size[0]!r}, direction = 1, 0, 0"
        ground = (
            f"shape = 'cylinder', radius = {size[1]!r}, centre = 0, 0, {-size[1]!r},"
            f" direction = {math.cos(turn)!r}, {math.sin(turn)!r}, 0"
        )
        # Eigenvalues of the sum of both forms.
        mean = (1 / size[0] + 1 / size[1]) / 2
        apart = math.hypot(
            (1 / size[0] + math.cos(2 * turn) / size[1]) / 2, math.sin(2 * turn) / size[1] / 2
        )
        height, curved = size[0], [mean - apart, mean + apart]
    elif kind == "bore":
        hollow = size[0] * rng.uniform(1.1, 5)
        shape = f"shape = 'sphere', radius = {size[0]!r}"
        ground = (
            f"shape = 'cylinder', radius = {hollow!r}, centre = 0, 0, {hollow!r},"
            " direction = 0, 1, 0, side = 'inside'"
        )
        height, curved = size[0], [1 / size[0], 1 / size[0] - 1 / hollow]
    rigid = rng.random() < 0.5
    rubs = rng.random() < 0.3
    smallest = 1 / max(curved)
    overlap = 0.0 if rigid else smallest * 10 ** rng.uniform(-5, -2)
    push = modulus(young) * smallest**2 * 10 ** rng.uniform(-6, -4)
    keys = ", normal = 'rigid'" if rigid else ""
    if rubs:
        keys += ", friction = 'contensou_exact', friction_coefficient = 0.3"
    method = METHODS[seed % 4]
    text = (
        f"&scene t_end = 1e-6 /\n&material name = 'm', young = {young!r}, poisson = 0.3 /\n"
        f"&body name = 'b', mass = 1e3, inertia = 3*1e3, position = 0, 0, {height - overlap!r},"
        f" applied_force = 0, 0, {-push!r} /\n"
        f"&surface name = 's', body = 'b', {shape}, material = 'm' /\n"
        f"&surface name = 'f', body = 'ground', {ground}, material = 'm' /\n"
        f"&contact name = 'k', surfaces = 'f', 's'{keys} /\n"
        f"&integrator method = '{method}' /\n&output file = 'out.h5', interval = 1e-7 /\n"
    )
    status, said, rows, _ = simulated(executable, folder, text)
    title = f"{kind}, {'rigid' if rigid else 'hertz'}, {method}"
    if status:
        return title, f"status {status}", [said], {}
    off = 0.0
    for load, found in zip(rows["normal_force"][:, 0], rows["semi_axes"][:, 0], strict=True):
        expected = ellipse(load, young, min(curved) / 2, max(curved) / 2)
        off = max(off, np.abs(found / expected - 1).max())
    wrong = [] if off < 1e-6 else [f"the axes are off by {off:.1e}"]
    return title, "right" if not wrong else "wrong", wrong, {"axes": off}


# ---- Hysteresis ---------------------------------------------------------------------------------


def hysteresis(seed, executable, folder):
    """An ellipsoid rolls on a plane, in any direction."""
    rng = random.Random(f"hysteresis {seed}")
    size = [rng.uniform(0.01, 0.05) * 10 ** rng.uniform(-0.7, 0.7) for _ in range(2)]
    tall = rng.uniform(0.005, 0.03)
    overlap = min(size) ** 2 / max(tall, *size) * 10 ** rng.uniform(-4, -2)
    height = tall - overlap
    loss, speed = rng.uniform(0.05, 1), 10 ** rng.uniform(-1, 1)
    angle = rng.choice((rng.uniform(0, 2 * math.pi), rng.randrange(8) * math.pi / 4))
    turn = rng.choice((0.0, rng.uniform(0, math.pi)))
    # In the frame of the body; about the vertical it is turned.
    w = (speed * math.cos(angle), speed * math.sin(angle))
    c, s = math.cos(turn), math.sin(turn)
    world = (c * w[0] - s * w[1], s * w[0] + c * w[1])
    method = METHODS[seed % 4]
    text = (
        "&scene t_end = 1e-6 /\n&material name = 'm', young = 1e8, poisson = 0.3 /\n"
        f"&body name = 'b', mass = 1e3, inertia = 3*1e3, position = 0, 0, {height!r},"
        f" axis = 0, 0, 1, angle = {turn!r}, spin = {words((*w, 0))},"
        f" velocity = {words((height * world[1], -height * world[0], 0))} /\n"
        f"&surface name = 's', body = 'b', shape = 'ellipsoid', semi_axes = {words((*size, tall))},"
        " material = 'm' /\n"
        "&surface name = 'f', body = 'ground', shape = 'plane', material = 'm' /\n"
        f"&contact name = 'k', surfaces = 'f', 's', rolling = 'hysteresis',"
        f" rolling_coefficient = {loss!r}, rolling_regularization = {1e-6 * speed!r} /\n"
        f"&integrator method = '{method}', rtol = 1e-10 /\n"
        "&output file = 'out.h5', interval = 1e-7 /\n"
    )
    status, said, rows, _ = simulated(executable, folder, text)
    title = f"angle {math.degrees(angle):.0f}, {method}"
    if status:
        return title, f"status {status}", [said], {}
    a, b = rows["semi_axes"][0, 0]
    along, across = w if size[0] > size[1] else w[::-1]
    expected = loss * 3 / 16 * rows["normal_force"][0, 0] * math.hypot(a * across, b * along)
    off = abs(rows["work_friction"][-1] / rows["time"][-1] / expected - 1)
    wrong = [] if off < 1e-3 else [f"the power is off by {off:.1e}"]
    return title, "right" if not wrong else "wrong", wrong, {"power": off}


# ---- Legs ---------------------------------------------------------------------------------------


def on_legs(rng, centres, keys, method, state, t_end, inertia):
    """A body on legs over the floor; the state is position, axis, angle, velocity and spin."""
    position, axis, angle, velocity, spin = state
    mass = rng.choice((1.0, rng.uniform(1, 3)))
    more = (
        f"axis = {words(axis)}, angle = {angle!r}",
        f"velocity = {words(velocity)}",
        f"spin = {words(spin)}",
    )
    text = "&material name = 'w', young = 1e9, poisson = 0.3 /\n"
    text += "&surface name = 'floor', body = 'ground', shape = 'plane', material = 'w' /\n"
    text += body("body", mass, [mass * one for one in inertia], position, *more)
    for k, centre in enumerate(centres):
        text += ball_surface(f"foot{k}", "body", centre)
        text += f"&contact name = 'c{k}', surfaces = 'floor', 'foot{k}', {keys} /\n"
    return (
        text
        + f"&scene gravity = 0, 0, -9.81, t_end = {t_end!r} /\n"
        + f"&integrator method = '{method}', rtol = {rng.choice((1e-6, 1e-8, 1e-10))} /\n"
        + "&output file = 'out.h5', interval = 5e-4 /\n"
    )


# Legs, height, tilt, velocity, spin, friction, restitution and inertia of the three scenes.
SLIDING = {
    "three, touched": (
        ((0.07695044678899735, 0.012665688645247234), (-0.04443472466819861, 0.07811025452910378),
         (-0.05090937088818238, -0.08721029605997138)),
        0.08515695956601138, 1e-3, 0.0, (-0.4357512542885165, 0.427944847082082),
        -3.027292427008738, 0.6, 0.3, (0.01, 0.01, 0.01),
    ),
    "four": (
        ((0.1, 0.1), (-0.1, 0.1), (0.1, -0.1), (-0.1, -0.1)),
        0.08, 2e-3, 0.01, (1.0, 0.3), 3.0, 0.3, 0.0, (0.01, 0.01, 0.02),
    ),
    "three, slow": (
        ((0.08831654541242649, 0.004411744587186371), (-0.03668176703027544, 0.08900517307151345),
         (-0.048665963832524466, -0.09491449520166968)),
        0.08394921610113117, 1e-4, 0.0, (-1.41159504859569, 1.708270253605734),
        6.407238298009461, 0.1, 0.0, (0.01, 0.01, 0.01),
    ),
}  # fmt: skip


def judged(executable, folder, text, title, stiff):
    """A scene of legs by what must hold for rigid contacts."""
    end, wrong, figures = attempt(executable, folder, text, patience=20)
    if end not in ("0", "slow") and "steps have shrunk" not in end:
        wrong = [*wrong, end]
    if end == "slow" and not stiff:
        wrong = [*wrong, end]
    return title, "ends well" if end == "0" else end, wrong, figures


def legs(seed, executable, folder):
    """Three or four legs with friction."""
    rng = random.Random(f"legs {seed}")
    name = list(SLIDING)[seed % 3]
    ends, low, gap, tilt, velocity, spin, mu, e, inertia = SLIDING[name]
    method = METHODS[seed // 3 % 4]
    near = 10 ** rng.uniform(-6, -1)
    centres = [(x * rng.uniform(1 - near, 1 + near), y, -low) for x, y in ends]
    mu = min(0.9, mu * rng.choice((1.0, rng.uniform(0.3, 1.5))))
    e = rng.choice((e, e, rng.uniform(0, 0.9)))
    tilt = rng.choice((tilt, 10 ** rng.uniform(-5, -1.5)))
    height = low + RADIUS + gap * rng.uniform(0.2, 3) + 0.15 * tilt
    share = rng.choice((1.0, rng.uniform(0.3, 1.5)))
    state = (
        (0.0, 0.0, height),
        (rng.gauss(0, 1), rng.gauss(0, 1), 0.0),
        tilt,
        (share * velocity[0], share * velocity[1], 0.0),
        (0.0, 0.0, spin * rng.choice((1.0, rng.uniform(-1.5, 1.5)))),
    )
    keys = f"normal = 'rigid', restitution = {e!r}, friction = 'contensou_exact'"
    keys += f", friction_coefficient = {mu!r}"
    text = on_legs(rng, centres, keys, method, state, 0.3, inertia)
    title = f"{name}, {method}, friction {mu:.2f}, restitution {e:.2f}"
    return judged(executable, folder, text, title, method in ("explicit8", "cvode_adams"))


def table(seed, executable, folder):
    """Four legs without friction, two of which land as good as together."""
    rng = random.Random(f"table {seed}")
    method = ("explicit8", "auto", "explicit8", "auto", "cvode_bdf", "cvode_adams")[seed % 6]
    x, y = (0.1, 0.06) if rng.random() < 0.5 else (rng.uniform(0.05, 0.15), rng.uniform(0.04, 0.1))
    centres = [(i * x, j * y, -0.05) for j in (1, -1) for i in (1, -1)]
    tilt = rng.choice((0.01, 10 ** rng.uniform(-4, -1)))
    axis = rng.choice(((1.0, 0.3, 0.0), (1.0, 0.0, 0.0), (rng.gauss(0, 1), rng.gauss(0, 1), 0.0)))
    height = 0.06 + rng.uniform(0.1, 1.5) * 2e-3 + math.hypot(x, y) * math.sin(tilt)
    e = rng.choice((0.5, 0.5, 0.0, 1.0, rng.uniform(0, 1)))
    velocity = rng.choice(((0.5, 0.2, 0.0), (0.0, 0.0, 0.0), (0.5, 0.2, -rng.uniform(0, 0.5))))
    spin = rng.choice(((0.0, 0.0, 0.0), (0.0, 0.0, rng.uniform(-5, 5))))
    state = ((0.0, 0.0, height), axis, tilt, velocity, spin)
    keys = f"normal = 'rigid', restitution = {e!r}"
    text = on_legs(rng, centres, keys, method, state, 0.5, (0.01, 0.013, 0.02))
    title = f"{method}, restitution {e:.2f}, tilt {tilt:.1e}"
    return judged(executable, folder, text, title, False)


# ---- Ellipsoids in a bore -----------------------------------------------------------------------


class Bore(Drop):
    """A scene that is written here."""

    def __init__(self, **known):
        vars(self).update(known)


def bore(seed, executable, folder):
    """An ellipsoid of any length across a bore."""
    rng = random.Random(f"bore {seed}")
    method = METHODS[seed % 4]
    length, radius = rng.uniform(0.012, 0.036), 0.04
    low = -0.75 * (math.sqrt(radius**2 - length**2) - 0.01 * (1 - (length / radius) ** 2))
    turn = rng.choice((0.0, rng.uniform(-0.1, 0.1)))
    rigid = rng.random() < 0.4
    keys = f", restitution = {rng.choice((0.3, 0.8))}"
    keys += ", normal = 'rigid'" if rigid else ", damping = 'hunt_crossley'"
    if rng.random() < 0.6:
        keys += f", friction = 'contensou_exact', friction_coefficient = {rng.uniform(0.05, 0.5)!r}"
        if rng.random() < 0.6:
            keys += ", regularization_velocity = 1e-3"
    place = (rng.uniform(-2e-3, 2e-3), rng.choice((0.0, rng.uniform(-1e-3, 1e-3))), low)
    text = (
        "&scene gravity = 0, 0, -9.81, t_end = 0.1 /\n"
        "&material name = 'm', young = 1e10, poisson = 0.3 /\n"
        "&body name = 'b', mass = 0.05, inertia = 5e-6, 6e-6, 7e-6,"
        f" position = {words(place)}, axis = 0, 0, 1, angle = {turn!r},"
        f" spin = 0, 0, {rng.choice((0.2, rng.uniform(-2, 2)))!r} /\n"
        f"&surface name = 's', body = 'b', shape = 'ellipsoid', semi_axes = {length!r}, 0.01, 0.01,"
        " material = 'm' /\n"
        f"&surface name = 'f', body = 'ground', shape = 'cylinder', radius = {radius!r},"
        " direction = 0, -1, 0, side = 'inside', material = 'm' /\n"
        f"&contact name = 'k', surfaces = 'f', 's'{keys} /\n"
        f"&integrator method = '{method}', rtol = 1e-8 /\n"
        "&output file = 'out.h5', interval = 2e-5 /\n"
    )
    size = (length, 0.01, 0.01)
    drawn = Bore(
        text=text,
        rigid=rigid,
        surface=Ellipsoid(size),
        distance=to_cylinder(radius, True),
        frame=frame((0, -1, 0)),
        size=max(size),
        smallest=min(size) ** 2 / max(size),
        mass=0.05,
    )
    title = f"{'rigid' if rigid else 'hertz'}, {method}, length {length:.4f}"
    end, wrong = drop(executable, drawn, folder)
    return title, end, [wrong] if wrong else [], {}


# ---- Impacts ------------------------------------------------------------------------------------


# Series in 1/u^2 from those of the arc sine and of sqrt(1 - x^2): the closed forms cancel there.
ORDER = np.arange(42)
ARC = np.array([math.comb(2 * k, k) / (4.0**k * (2 * k + 1)) for k in ORDER])
ROOT = np.array([-math.comb(2 * k, k) / (4.0**k * (2 * k - 1)) for k in ORDER])
FORCE = 0.75 * (ARC[:-2] - ARC[1:-1] / 4 + ROOT[:-2] / 2 + ROOT[1:-1] / 4)
TORQUE = 0.375 * (ARC[:-2] - ARC[1:-1] + 0.375 * (ARC[2:] + 2 * ROOT[1:-1] - ROOT[2:]))


def wrench(u):
    """Force and torque of friction on a circle over f N and f N a, at u = slip/(a spin)."""
    if u > 2:
        power = u ** (-2.0 * np.arange(len(FORCE)))
        return float(FORCE @ power), float(TORQUE @ power) / u
    if u < 1:
        moment = math.pi / 2 * (1 - u**2) ** 2 + math.pi / 2 * (1 - u**2) * u**2
        force = math.pi * 3 / 8 * (u - u**3 / 4)
        return force, 3 / 8 * (moment + 3 * math.pi / 16 * u**4)
    s, q = math.asin(1 / u), math.sqrt(u**2 - 1)
    force = 0.75 * ((u - u**3 / 4) * s + q * (2 + u**2) / (4 * u))
    return force, 3 / 8 * ((1 - u**2 + 3 * u**4 / 8) * s + 3 / 8 * q * (2 - u**2))


def routh(mass, inertia, radius, young, friction, e, velocity, spin):
    """Velocity and angular velocity of a ball after its impact on a plane, by Routh's equations."""
    stiffness = 4 / 3 * modulus(young) * math.sqrt(radius)
    approach = -velocity[2]
    deepest = (1.25 * mass * approach**2 / stiffness) ** 0.4
    spot = MEAN_SPOT * math.sqrt(radius * deepest)

    def slip(y):
        return np.array([y[0] - radius * y[3], y[1] + radius * y[2]])

    def rates(_, y):
        s = slip(y)
        fast = np.linalg.norm(s)
        force, torque = wrench(fast / max(spot * abs(y[4]), 1e-300))
        push = -friction * force * s / max(fast, 1e-300)
        twist = -friction * spot * torque * np.sign(y[4])
        return np.array([
            *(push / mass), radius * push[1] / inertia, -radius * push[0] / inertia,
            twist / inertia,
        ])  # fmt: skip

    size = np.linalg.norm(velocity) + radius * np.linalg.norm(spin)

    def rest(_, y):
        return np.linalg.norm(slip(y)) + spot * abs(y[4]) - 1e-11 * size

    rest.terminal = True
    y = np.array([velocity[0], velocity[1], *spin])
    total = (1 + e) * mass * approach
    if friction > 0 and rest(0, y) > 0:
        y = solve_ivp(rates, (0, total), y, "DOP853", rtol=1e-13, atol=1e-15, events=rest).y[:, -1]
    return np.array([y[0], y[1], e * approach]), y[2:]


def impact(seed, executable, folder):
    """A ball that slides and turns meets a plane."""
    rng = random.Random(f"impact {seed}")
    method = METHODS[seed % 4]
    rtol = 10 ** rng.uniform(-10, -4)
    mass, radius = 10 ** rng.uniform(-2, 0), rng.uniform(0.01, 0.05)
    inertia = rng.uniform(0.2, 0.66) * mass * radius**2
    young, friction, e = 10 ** rng.uniform(8, 11), rng.uniform(0.05, 0.9), rng.uniform(0, 1)
    angle, fast = rng.uniform(0, 2 * math.pi), 10 ** rng.uniform(-2, 1)
    velocity = (fast * math.cos(angle), fast * math.sin(angle), -(10 ** rng.uniform(-1, 1)))
    spin = [rng.choice((0.0, rng.uniform(-1, 1))) * fast / radius for _ in range(2)]
    spin.append(rng.choice((-1, 1)) * 10 ** rng.uniform(0, 3))
    text = (
        "&scene gravity = 0, 0, 0, t_end = 1e-3 /\n"
        f"&material name = 'm', young = {young!r}, poisson = 0.3 /\n"
        f"&body name = 'b', mass = {mass!r}, inertia = {words(3 * [inertia])},"
        f" position = 0, 0, {radius + 1e-6!r}, velocity = {words(velocity)},"
        f" spin = {words(spin)} /\n"
        f"&surface name = 's', body = 'b', shape = 'sphere', radius = {radius!r},"
        " material = 'm' /\n"
        "&surface name = 'f', body = 'ground', shape = 'plane', material = 'm' /\n"
        f"&contact name = 'k', surfaces = 'f', 's', normal = 'rigid', restitution = {e!r},"
        f" friction = 'contensou_exact', friction_coefficient = {friction!r} /\n"
        f"&integrator method = '{method}', rtol = {rtol!r} /\n"
        "&output file = 'out.h5', interval = 1e-3 /\n"
    )
    status, said, rows, _ = simulated(executable, folder, text)
    title = f"{method}, rtol {rtol:.1e}, friction {friction:.2f}"
    if status:
        return title, f"status {status}", [said], {}
    v, w = routh(mass, inertia, radius, young, friction, e, velocity, spin)
    size = np.linalg.norm(velocity) + radius * np.linalg.norm(spin[:2])
    off = np.abs(rows["velocity"][-1, 0] - v).max() / size
    turned = np.abs(rows["angular_velocity"][-1, 0] - w)
    # Friction is smoothed below the tolerance of the velocity, whatever drills.
    rolls = size / radius
    turned = max(turned[:2].max() / rolls, turned[2] / (np.linalg.norm(spin) + rolls))
    limit = rtol + 1e-10
    wrong = [] if max(off, turned) < limit else [f"off by {off:.1e} and {turned:.1e}"]
    figures = {"velocities over the tolerance": off / limit, "spin over it": turned / limit}
    return title, "right" if not wrong else "wrong", wrong, figures


# ---- Far from the origin ------------------------------------------------------------------------


def far(seed, executable, folder):
    """Two balls meet far from the origin."""
    rng = random.Random(f"far {seed}")
    method = METHODS[seed % 4]
    distance = 10 ** rng.choice((rng.uniform(6, 7), rng.uniform(6, 12)))
    way = np.array([rng.gauss(0, 1) for _ in range(3)])
    centre = distance * way / np.linalg.norm(way)
    line = np.array([rng.gauss(0, 1) for _ in range(3)])
    line /= np.linalg.norm(line)
    gap, speed = 10 ** rng.uniform(-4, -2), 10 ** rng.uniform(-2, 1)
    other = centre + line * (2 * RADIUS + gap)
    # What rounding leaves of the gap, and which way it is.
    between = other - centre
    gap = np.linalg.norm(between) - 2 * RADIUS
    if gap <= 0:
        return f"{distance:.0e} m", "begins closed", [], {}
    rigid, e = rng.random() < 0.5, rng.uniform(0.2, 1)
    keys = f", normal = 'rigid', restitution = {e!r}" if rigid else ""
    line = between / np.linalg.norm(between)
    t_end = 1.5 * gap / speed + 2e-3
    text = (
        f"&scene t_end = {float(t_end)!r} /\n"
        "&material name = 'm', young = 1e10, poisson = 0.3 /\n"
        f"&body name = 'a', mass = 0.03, inertia = 3*1e-6, position = {words(centre)} /\n"
        f"&body name = 'b', mass = 0.03, inertia = 3*1e-6, position = {words(other)},"
        f" velocity = {words(-speed * line)} /\n"
        + ball_surface("sa", "a", (0, 0, 0)).replace("'w'", "'m'")
        + ball_surface("sb", "b", (0, 0, 0)).replace("'w'", "'m'")
        + f"&contact name = 'k', surfaces = 'sa', 'sb'{keys} /\n"
        f"&integrator method = '{method}' /\n"
        f"&output file = 'out.h5', interval = {float(t_end)!r} /\n"
    )
    status, said, rows, events = simulated(executable, folder, text)
    title = f"{distance:.0e} m, {'rigid' if rigid else 'hertz'}, {method}"
    if status:
        known = (status == 2 and "a position is rounded by" in said) or (
            status == 1 and "rounding of their positions" in said
        )
        if status == 1 and "energy has" in said:
            # So much does the rounding of an overlap take or give.
            return title, "ends as the energy is off", [], {}
        return title, "refused", [] if known else [said], {}
    rounding = np.spacing(distance)
    figures, wrong = {}, []
    if len(events) < 1:
        return title, "misses", ["nothing touches"], {}
    late = abs(events[0] - gap / speed) * speed / rounding
    apart = (rows["velocity"][-1, 1] - rows["velocity"][-1, 0]) @ line / speed
    figures["touch over the rounding of a position"] = late
    figures["speed apart"] = abs(apart - (e if rigid else 1.0))
    figures["balance"] = np.abs(rows["energy_error"]).max() / rows["energy_kinetic"].max()
    for name, limit in zip(figures, (10, 1e-3, 1e-3), strict=True):
        if figures[name] > limit:
            wrong.append(f"{name} {figures[name]:.1e}")
    return title, "right" if not wrong else "wrong", wrong, figures


CASES = (axes, hysteresis, legs, table, bore, impact, far)


def main() -> int:
    """Do the campaign."""
    words = [*sys.argv[1:], *("all", "200", "0")[len(sys.argv) - 1 :]]
    executable = os.path.abspath(os.environ["CONTENSOU"])
    wrongs = 0
    for case in CASES:
        if words[0] not in ("all", case.__name__):
            continue
        ends, largest, number = Counter(), {}, int(words[1])
        bad = 0
        for seed in range(int(words[2]), int(words[2]) + number):
            with tempfile.TemporaryDirectory() as folder:
                title, end, wrong, figures = case(seed, executable, Path(folder))
            ends[end] += 1
            if wrong:
                bad += 1
                print(f"{case.__name__} {seed} ({title}): {'; '.join(wrong)}", flush=True)
            for name, value in figures.items():
                if value > largest.get(name, (-math.inf, 0))[0]:
                    largest[name] = (value, seed)
        print(f"{case.__name__}: {bad} of {number} are wrong")
        for end, count in ends.most_common():
            print(f"  {count:5d} {end}")
        for name, (value, seed) in largest.items():
            print(f"  largest {name}: {value:.2g} ({seed})")
        wrongs += bad
    return bool(wrongs)


if __name__ == "__main__":
    sys.exit(main())
