"""`contensou equilibrium`: rest positions against published deflections and independent Newton."""

from __future__ import annotations

import csv
import math
import re
from functools import cache

import h5py
import numpy as np
import pytest
from conftest import ROOT

STATICS = ROOT / "tests" / "reference" / "bearing" / "statics.csv"
EXAMPLES = list(csv.DictReader(STATICS.open()))

PUBLISHED = """\
&scene t_end = 0.01 /
&material name = 'steel', young = 2.1e11, poisson = 0.3 /
&bearing name = 'b', ball_count = 7, ball_diameter = 11.5e-3, pitch_diameter = 43.5e-3,
   inner_groove_ratio = 0.52, outer_groove_ratio = 0.53, material = 'steel', ball_density = 7850,
   ring_mass = 1.0, ring_motion = 'rotor', ring_inertia = 1e-4, 2e-4,
   clearance = {clearance}, radial_load = {radial}, axial_load = {axial}{moment} /
"""
SHAFT = """\
&scene t_end = 0.01 /
&material name = 'steel', young = 2.1e11, poisson = 0.3 /
&body name = 'shaft', motion = 'rotor', mass = 2.0, inertia = 0.01, 0.01, 0.001,
   position = 0, 0, 0.012, applied_force = 400, 100, 250 /
&bearing name = 'left', ball_count = 7, ball_diameter = 8.0e-3, pitch_diameter = 40.0e-3,
   inner_groove_ratio = 0.52, outer_groove_ratio = 0.53, material = 'steel', ball_density = 7850,
   inner_body = 'shaft', contact_angle = 0.4, centre = 0, 0, -0.03 /
&bearing name = 'right', ball_count = 6, ball_diameter = 9.0e-3, pitch_diameter = 42.0e-3,
   inner_groove_ratio = 0.515, outer_groove_ratio = 0.525, material = 'steel',
   ball_density = 7850, inner_body = 'shaft', contact_angle = -0.35, centre = 0, 0, 0.04 /
"""


def settle(run, tmp_path, text, *words):
    """Groups of the file that `equilibrium` writes."""
    (tmp_path / "e.nml").write_text(text)
    result = run("equilibrium", "e.nml", "-q", "-o", "e.h5", "--force", *words)
    assert result.status == 0, result.err
    with h5py.File(tmp_path / "e.h5") as file:
        return {
            f"{group}/{name}": data[()]
            for group in ("body", "contact", "ring")
            if group in file
            for name, data in file[group].items()
        }


def loads_of(found):
    names = [name.decode() for name in found["contact/name"]]
    return dict(zip(names, found["contact/normal_force"], strict=True))


# --- Hertz and the geometry of balls in grooves, independent of the program --------------------


def elliptic(m):
    """Complete elliptic integrals K and E of the parameter m, by the arithmetic-geometric mean."""
    a, b, c, total, power = 1.0, math.sqrt(1.0 - m), math.sqrt(m), 0.0, 0.5
    while True:
        total += power * c * c
        if c < 1e-12:
            break
        a, b, c, power = 0.5 * (a + b), math.sqrt(a * b), 0.5 * (a - b), 2 * power
    k = math.pi / (2 * a)
    return k, k * (1 - total)


def stiffness(along, across, modulus):
    """K of Q = K d^1.5 from half curvatures (K. L. Johnson, Contact Mechanics, 4.2)."""
    small, large = sorted((along, across))
    low, high = 1e-12, 1 - 1e-12
    for _ in range(60):
        m = 0.5 * (low + high)
        k, e = elliptic(m)
        if (e / (1 - m) - k) / (k - e) < large / small:
            low = m
        else:
            high = m
    k, e = elliptic(m)
    size = (3 * (k - e) / (2 * math.pi * modulus * small * m)) ** (1 / 3)
    return (3 * k / (2 * math.pi * modulus * size)) ** -1.5


MODULUS = 2.1e11 / (1 - 0.09) / 2


@cache
def table(ball, groove):
    """Coefficients of ln K over the rolling curvature, to interpolate by."""
    nodes = np.cos(math.pi * (np.arange(14) + 0.5) / 14)
    curvature = 60.0 * nodes
    values = [
        math.log(stiffness(0.5 * (1 / ball + x), 0.5 * (1 / ball - 1 / groove), MODULUS))
        for x in curvature
    ]
    fit = np.polynomial.chebyshev.chebfit(nodes, values, 13)
    return [float(c) for c in np.polynomial.chebyshev.cheb2poly(fit)[::-1]]


class Groove:
    """A ring: a circle of centres of radius `circle`, along the third column of `rotation`."""

    def __init__(self, circle, radius, ball):
        self.circle, self.radius, self.ball = circle, radius, ball

    def approach_and_stiffness(self, place, centre, rotation):
        x, y, z = (float(a) - float(b) for a, b in zip(place, centre, strict=True))
        if rotation is not None:
            x, y, z = ((r[0] * x + r[1] * y + r[2] * z) for r in rotation)
        across, along = math.hypot(x, y) - self.circle, z
        distance = math.hypot(across, along)
        # The contact lies beyond the ball, seen from the centre circle.
        approach = distance - (self.radius - self.ball)
        cosine = across / distance
        at = self.circle + cosine * self.radius
        rolling = -cosine / at
        logarithm = 0.0
        for c in table(self.ball, self.radius):
            logarithm = logarithm * (rolling / 60.0) + c
        return approach, math.exp(logarithm)

    def energy(self, place, centre, rotation):
        approach, k = self.approach_and_stiffness(place, centre, rotation)
        return 0.4 * k * approach**2.5 if approach > 0 else 0.0

    def load(self, place, centre, rotation):
        approach, k = self.approach_and_stiffness(place, centre, rotation)
        return k * approach**1.5 if approach > 0 else 0.0


class Bearing:
    # Where its balls are sought first, if not at the start.
    first = None

    def __init__(self, z, ball, pitch, ratios, centre, angle=0.0, clearance=0.0):
        self.z, self.r = z, ball / 2
        groove = [ratio * ball for ratio in ratios]
        play = sum(groove) - ball
        if angle:
            clearance = 2 * play * (1 - math.cos(angle))
        self.shift = (play - clearance / 2) * math.tan(angle)
        self.inner = Groove(pitch / 2 + groove[0] - self.r - clearance / 4, groove[0], self.r)
        self.outer = Groove(pitch / 2 - groove[1] + self.r + clearance / 4, groove[1], self.r)
        self.centre = np.array([0.0, 0.0, centre])
        reach = groove[1] - self.r
        self.start = (self.outer.circle + reach * math.cos(angle), reach * math.sin(angle))

    def place(self, i, across, along):
        turn = 2 * math.pi * i / self.z
        x, y, z = self.centre
        return x + across * math.cos(turn), y + across * math.sin(turn), z + along

    def settle_ball(self, i, ring, rotation, guess):
        """Ball i in its plane, by Newton's method on central differences of the energy."""
        x = np.array(guess)

        def energy(x):
            place = self.place(i, *x)
            return self.inner.energy(place, ring, rotation) + self.outer.energy(
                place, self.centre, None
            )

        h = 2e-9
        for _ in range(30):
            e = energy(x)
            up = [energy(x + h * d) for d in np.eye(2)]
            down = [energy(x - h * d) for d in np.eye(2)]
            slope = np.array([(u - d) / (2 * h) for u, d in zip(up, down, strict=True)])
            w = 20 * h
            up = [energy(x + w * d) for d in np.eye(2)]
            down = [energy(x - w * d) for d in np.eye(2)]
            both = energy(x + w) - up[0] - up[1] + e
            bend = np.array(
                [
                    [(up[0] + down[0] - 2 * e) / w**2, both / w**2],
                    [both / w**2, (up[1] + down[1] - 2 * e) / w**2],
                ]
            )
            if np.linalg.det(bend) <= 0:
                return x
            step = -np.linalg.solve(bend, slope)
            x = x + step * min(1.0, 2e-6 / np.abs(step).max())
            if np.abs(step).max() < 1e-13:
                break
        return x


def turned(vector):
    """Rotation matrix of a rotation vector."""
    angle = np.linalg.norm(vector)
    if angle == 0:
        return np.eye(3)
    x, y, z = vector / angle
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross


def balance(bearings, arms, force, torque, guess):
    """Five coordinates of a shaft with bearings whose inner rings lie at `arms` on it."""

    def ring(x, arm):
        rotation = turned(np.array([x[3], x[4], 0.0]))
        return x[:3] + rotation @ arm, rotation.T.tolist()

    places = [[np.array(place) for place in b.first or [b.start] * b.z] for b in bearings]

    def energy_at_balls(x):
        total = -force @ x[:3]
        for bearing, arm, balls in zip(bearings, arms, places, strict=True):
            centre, rotation = ring(x, arm)
            for i in range(bearing.z):
                place = bearing.place(i, *balls[i])
                total += bearing.inner.energy(place, centre, rotation)
        return total

    def slopes(x):
        for bearing, arm, balls in zip(bearings, arms, places, strict=True):
            centre, rotation = ring(x, arm)
            for i in range(bearing.z):
                balls[i] = bearing.settle_ball(i, centre, rotation, balls[i])
        result = np.zeros(5)
        for k, h in enumerate([2e-9] * 3 + [1e-7] * 2):
            e = np.zeros(5)
            e[k] = h
            result[k] = (energy_at_balls(x + e) - energy_at_balls(x - e)) / (2 * h)
        return result - np.concatenate([np.zeros(3), torque])

    x = np.array(guess, dtype=float)
    matrix = np.zeros((5, 5))
    for iteration in range(60):
        g = slopes(x)
        if iteration in (0, 4):
            for k, h in enumerate([2e-8] * 3 + [1e-6] * 2):
                e = np.zeros(5)
                e[k] = h
                matrix[:, k] = (slopes(x + e) - g) / h
        step = -np.linalg.solve(matrix, g)
        x = x + step
        if np.abs(step[:3]).max() < 1e-12:
            break
    else:
        raise AssertionError("Newton's method does not converge")
    slopes(x)
    loads = []
    for bearing, arm, balls in zip(bearings, arms, places, strict=True):
        centre, rotation = ring(x, arm)
        loads.append(
            [
                bearing.inner.load(bearing.place(i, *balls[i]), centre, rotation)
                for i in range(bearing.z)
            ]
        )
    return x, loads


# --- published deflections ---------------------------------------------------------------------


def published(example):
    clearance, radial, axial, moment = (
        float(example[key]) for key in ("clearance_um", "radial_N", "axial_N", "moment_Nmm")
    )
    text = PUBLISHED.format(
        clearance=clearance * 1e-6,
        radial=radial,
        axial=axial,
        moment=f", moment_load = 0, {moment * 1e-3}, 0" if moment else "",
    )
    bearing = Bearing(7, 11.5e-3, 43.5e-3, (0.52, 0.53), 0.0, clearance=clearance * 1e-6)
    return text, bearing, radial, axial, moment


def deflection(found, run, tmp_path):
    """Of the ring against where it is without load: radial, axial [um], tilt [mrad]."""
    shown = run("check", "e.nml", "--expand").out
    groove = shown.partition("name = 'b_inner_groove'")[2].partition("/\n")[0]
    offset = 0.0
    if "centre = " in groove:
        offset = float(groove.partition("centre = ")[2].split("\n")[0].split(",")[2])
    x, _, z = found["body/position"][0]
    return x * 1e6, (z + offset) * 1e6, found["body/rotation"][0][1] * 1e3


@pytest.mark.parametrize("example", EXAMPLES, ids=[e["example"] for e in EXAMPLES])
def test_published_deflections(example, run, tmp_path):
    text, _, radial, axial, _ = published(example)
    found = settle(run, tmp_path, text)
    got = deflection(found, run, tmp_path)
    # With both loads the tables linearise the tilt, see below.
    bound = 1e-3 if radial == 0 or axial == 0 else 2.5e-3
    for value, key in zip(got, ("radial_um", "axial_um", "tilt_mrad"), strict=True):
        if example[key]:
            assert value == pytest.approx(float(example[key]), rel=bound), key


def linearised(bearing, radial, axial, moment, pitch, guess=(20e-6, 146e-6, -2.7e-3)):
    """Deflections by the kinematics of the tables: a tilt moves the groove along the axis alone,
    at the radius of the balls, at which the moment acts, too."""
    free = bearing.inner.circle - bearing.outer.circle
    length = bearing.inner.radius + bearing.outer.radius - 2 * bearing.r
    turns = 2 * np.pi * np.arange(bearing.z) / bearing.z

    def rest(x):
        total = -np.array([radial, axial, moment * 1e-3])
        for turn in turns:
            across = free + x[0] * math.cos(turn)
            along = x[1] + x[2] * pitch * math.cos(turn)
            angle = math.atan2(along, across)
            soft = 0.0
            for sign, groove in ((1, bearing.inner), (-1, bearing.outer)):
                at = pitch - sign * bearing.r * math.cos(angle)
                rolling = sign * math.cos(angle) / at
                k = stiffness(
                    0.5 * (1 / bearing.r + rolling),
                    0.5 * (1 / bearing.r - 1 / groove.radius),
                    MODULUS,
                )
                soft += k ** (-2 / 3)
            load = (max(math.hypot(across, along) - length, 0.0) / soft) ** 1.5
            total[0] += load * math.cos(angle) * math.cos(turn)
            total[1] += load * math.sin(angle)
            total[2] += load * math.sin(angle) * math.cos(turn) * pitch
        return total

    x = np.array(guess)
    for _ in range(30):
        g = rest(x)
        matrix = np.array(
            [(rest(x + h) - rest(x - h)) / 2 for h in np.diag([1e-9, 1e-9, 1e-7])]
        ).T / np.array([1e-9, 1e-9, 1e-7])
        step = -np.linalg.solve(matrix, g)
        x = x + step
        if np.abs(step).max() < 1e-12:
            break
    return x[0] * 1e6, x[1] * 1e6, -x[2] * 1e3


def test_the_published_combined_load_linearises_the_tilt():
    example = EXAMPLES[4]
    _, bearing, radial, axial, moment = published(example)
    got = linearised(bearing, radial, axial, moment, 43.5e-3 / 2)
    wanted = [float(example[key]) for key in ("radial_um", "axial_um", "tilt_mrad")]
    assert got == pytest.approx(wanted, rel=2e-4)


def test_the_tilt_depends_on_where_the_load_acts_to_micrometres(run, tmp_path):
    """7 um along the axis, of load and deflection, are what differs from linear formulas."""
    away = 7e-3
    example = {**EXAMPLES[4], "moment_Nmm": -1000 * away}
    found = settle(run, tmp_path, published(example)[0])
    got = np.array(deflection(found, run, tmp_path))
    got[0] -= away * got[2]
    wanted = [float(example[key]) for key in ("radial_um", "axial_um", "tilt_mrad")]
    assert got[:2] == pytest.approx(wanted[:2], rel=2e-4)
    assert got[2] == pytest.approx(wanted[2], rel=1.2e-3)


@pytest.mark.parametrize(("radial", "moment"), [(1000, 5000), (1000, -5000), (0, 5000)])
def test_moments_against_the_linear_formulas(radial, moment, run, tmp_path):
    """They differ by the square of the tilt, and by what it turns the groove."""
    text, bearing, *loads = published(
        {"clearance_um": 10, "radial_N": radial, "axial_N": 1000, "moment_Nmm": moment}
    )
    found = settle(run, tmp_path, text)
    got = deflection(found, run, tmp_path)
    guess = (got[0] * 1e-6, got[1] * 1e-6, -got[2] * 1e-3)
    wanted = linearised(bearing, *loads[:2], -moment, 43.5e-3 / 2, guess)
    assert got == pytest.approx(wanted, rel=3e-3)
    assert abs(got[2]) > 0.3


# --- independent Newton ------------------------------------------------------------------------


class Arcs:
    """A ring with two arcs, the centre circle of the one for the upper side `offset` below."""

    def __init__(self, circle, radius, ball, offset):
        self.arc = Groove(circle, radius, ball)
        self.radius, self.circle = radius, circle
        self.offsets = (-offset, offset)

    def at(self, centre, rotation, offset):
        axis = np.array([0.0, 0.0, 1.0]) if rotation is None else np.array(rotation)[2]
        return np.asarray(centre) + offset * axis

    def energy(self, place, centre, rotation):
        return sum(
            self.arc.energy(place, self.at(centre, rotation, o), rotation) for o in self.offsets
        )

    def load(self, place, centre, rotation):
        return [self.arc.load(place, self.at(centre, rotation, o), rotation) for o in self.offsets]


class FourPoint(Bearing):
    def __init__(self, z, ball, pitch, ratios, angle, clearance):
        super().__init__(z, ball, pitch, ratios, 0.0)
        play = [ratio * ball - self.r for ratio in ratios]
        for name, k, sign in (("inner", 0, 1), ("outer", 1, -1)):
            circle = pitch / 2 + sign * (play[k] * math.cos(angle) - clearance / 4)
            arcs = Arcs(circle, ratios[k] * ball, self.r, play[k] * math.sin(angle))
            setattr(self, name, arcs)
        self.start = (pitch / 2, 0.0)


@pytest.mark.parametrize("clearance", [-8e-6, 1e-5])
def test_four_points(clearance, run, tmp_path):
    text = f"""\
&scene t_end = 0.01 /
&material name = 'steel', young = 2.1e11, poisson = 0.3 /
&bearing name = 'b', ball_count = 9, ball_diameter = 10e-3, pitch_diameter = 50e-3,
   inner_groove_ratio = 0.52, outer_groove_ratio = 0.53, material = 'steel', ball_density = 7850,
   ring_mass = 1.0, ring_motion = 'rotor', ring_inertia = 1e-4, 2e-4, four_point = .true.,
   contact_angle = 0.6, clearance = {clearance}, radial_load = 900, axial_load = 700,
   moment_load = 0, 4, 0 /
"""
    found = settle(run, tmp_path, text)
    names = [name.decode() for name in found["body/name"]]
    shown = run("check", "e.nml", "--expand").out
    body = shown.partition("name = 'b_inner'")[2].partition("/\n")[0]
    start = float(re.search(r"position = \S+ \S+ (\S+)", body)[1])
    groove = shown.partition("name = 'b_inner_upper_groove'")[2].partition("/\n")[0]
    offset = float(re.search(r"centre = \S+ \S+ (\S+)", groove)[1])
    bearing = FourPoint(9, 10e-3, 50e-3, (0.52, 0.53), 0.6, clearance)
    # From the centre of mass to the plane between both arcs.
    arm = offset + (0.52 * 10e-3 - 5e-3) * math.sin(0.6)
    shift, turn = found["body/position"][names.index("b_inner")], found["body/rotation"][0]
    balls = np.array([found["body/position"][names.index(f"b_ball_{i + 1}")] for i in range(9)])
    bearing.first = [(np.hypot(x, y), z) for x, y, z in balls + 2e-8]
    assert abs(start) < 1e-3
    got, loads = balance(
        [bearing],
        [np.array([0, 0, arm])],
        np.array([900.0, 0, 700.0]),
        np.array([0.0, 4.0]),
        1.001 * np.array([*shift, turn[0], turn[1]]),
    )
    named = loads_of(found)
    largest = max(max(pair) for pair in loads[0])
    for i, pair in enumerate(loads[0]):
        for arc, load in zip(("upper", "lower"), pair, strict=True):
            got = named[f"b_inner_{arc}_{i + 1}"]
            assert got == pytest.approx(load, abs=1e-6 * largest), (i, arc)
    carrying = sum(load > 0 for pair in loads[0] for load in pair)
    assert carrying > 9 if clearance < 0 else carrying >= 5


def test_two_bearings_on_one_shaft(run, tmp_path):
    found = settle(run, tmp_path, SHAFT)
    left = Bearing(7, 8e-3, 40e-3, (0.52, 0.53), -0.03, angle=0.4)
    right = Bearing(6, 9e-3, 42e-3, (0.515, 0.525), 0.04, angle=-0.35)
    # All from the centre of mass of the shaft.
    arms = [
        np.array([0, 0, -0.03 - 0.012 + left.shift]),
        np.array([0, 0, 0.04 - 0.012 + right.shift]),
    ]
    for bearing in (left, right):
        bearing.centre[2] -= 0.012
    shift, turn = found["body/displacement"][0], found["body/rotation"][0]
    guess = 1.03 * np.array([*shift, turn[0], turn[1]])

    got, loads = balance(
        [left, right],
        arms,
        np.array([400.0, 100.0, 250.0]),
        np.zeros(2),
        guess,
    )
    named = loads_of(found)
    largest = max(map(max, loads))
    assert largest > 50
    for name, values in (("left", loads[0]), ("right", loads[1])):
        for i, load in enumerate(values):
            assert named[f"{name}_inner_{i + 1}"] == pytest.approx(load, abs=1e-6 * largest)
    assert shift == pytest.approx(got[:3], abs=2e-11)


@pytest.mark.parametrize("moment", [19.9, 20.004, 20.005, 20.5, 21.0, 22.0])
def test_balls_that_carry_nothing(moment, run, tmp_path):
    """Balls that a tilted ring leaves have a rest position too: where they touch nothing."""
    text = PUBLISHED.format(
        clearance=1e-5, radial=1000, axial=1000, moment=f", moment_load = 0, {moment}, 0"
    ).replace("clearance = 1e-05", "contact_angle = 0.6")
    found = settle(run, tmp_path, text)
    loads = loads_of(found)
    carrying = [load for load in loads.values() if load > 1e-6]
    assert 4 <= len(carrying) <= 8
    assert sum(loads.values()) == pytest.approx(sum(carrying), abs=1e-9)
    # A ball is pushed by both rings alike.
    for i in range(1, 8):
        assert loads[f"b_inner_{i}"] == pytest.approx(loads[f"b_outer_{i}"], rel=1e-2, abs=1e-9)


# --- stiffness -----------------------------------------------------------------------------------


def product(p, q):
    """Product of two quaternions (w, x, y, z)."""
    return np.array(
        [p[0] * q[0] - p[1:] @ q[1:], *(p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:]))]
    )


def yielding(run, tmp_path, text, frame, loads, steps):
    """Compliance (coordinate, load) of the ring b_inner by differences of rest positions."""
    moved, changed = [], []
    for k in range(5):
        ends = []
        change = np.zeros((2, 3))
        change[k // 3] = frame[k % 3] * steps[k // 3]
        for sign in (1, -1):
            words = [
                f"b_inner.applied_{name}=" + ",".join(repr(float(v)) for v in vector + sign * d)
                for name, vector, d in zip(("force", "torque"), loads, change, strict=True)
            ]
            at = settle(run, tmp_path, text, "--set", words[0], "--set", words[1])
            ends.append((at["body/position"][0], at["body/quaternion"][0]))
        (x, q), (y, p) = ends
        turn = 2 * product(q, p * [1, -1, -1, -1])[1:]
        moved.append(np.concatenate([frame @ (x - y), (frame @ turn)[:2]]))
        changed.append(2 * np.concatenate([frame @ change[0], (frame @ change[1])[:2]]))
    return np.linalg.solve(np.array(changed), np.array(moved)).T


@pytest.mark.sample(2)
@pytest.mark.parametrize("angle", [0.0, 0.35, 0.6])
@pytest.mark.parametrize("moment", [0.0, 20.0])
def test_the_stiffness_of_a_ring(angle, moment, run, tmp_path):
    load = f", moment_load = 0, {moment}, 0" if moment else ""
    text = PUBLISHED.format(clearance=1e-5, radial=1000, axial=1000, moment=load)
    if angle:
        text = text.replace("clearance = 1e-05", f"contact_angle = {angle}")
    found = settle(run, tmp_path, text)
    assert [n.decode() for n in found["ring/name"]] == ["b_inner"]
    matrix, frame = found["ring/stiffness"][0], found["ring/frame"][0]
    scale = np.sqrt(np.outer(np.diag(matrix), np.diag(matrix)))
    assert np.abs((matrix - matrix.T) / scale).max() < 1e-10
    assert np.linalg.eigvalsh(matrix / scale).min() > 0
    # The third axis of the ring, tilted.
    assert math.acos(frame[2, 2]) == pytest.approx(
        np.linalg.norm(found["body/rotation"][0]), rel=1e-6
    )
    loads = np.array([1000.0, 0, 1000.0]), np.array([0, moment, 0])
    # What is left of the third derivative is out of these.
    near, far = (
        yielding(run, tmp_path, text, frame, loads, (size, 0.01 * size)) for size in (0.5, 1.0)
    )
    by_differences = np.linalg.inv((4 * near - far) / 3)
    assert np.abs((by_differences - matrix) / scale).max() < 2e-8


def test_a_ring_that_turns_freely_has_the_stiffness_of_one_that_does_not(run, tmp_path):
    # Its own axis is tilted against the axis of the bearing, and it may turn about that alone.
    text = PUBLISHED.format(clearance=1e-5, radial=600, axial=1000, moment="")
    rotor = settle(run, tmp_path, text)["ring/stiffness"][0]
    free = settle(run, tmp_path, text, "--set", "b.ring_motion=free")["ring/stiffness"][0]
    scale = np.sqrt(np.outer(np.diag(rotor), np.diag(rotor)))
    assert np.abs((free - free.T) / scale).max() < 1e-10
    assert np.abs((free - rotor) / scale).max() < 1e-8


def test_a_ball_on_a_plane_and_on_a_spring(run, tmp_path):
    text = """\
&scene gravity = 0, 0, -9.81, t_end = 1 /
&material name = 'steel', young = 2.1e11, poisson = 0.3 /
&body name = 'ball', mass = 0.5, inertia = 3*1e-5, position = 0, 0, 0.0101 /
&surface name = 'ball', body = 'ball', shape = 'sphere', radius = 0.01, material = 'steel' /
&surface name = 'floor', body = 'ground', shape = 'plane', material = 'steel' /
&contact name = 'c', surfaces = 'ball', 'floor', friction = 'coulomb', friction_coefficient = 0.3,
   regularization_velocity = 1e-3, damping = 'viscous', damping_coefficient = 10 /
&body name = 'weight', mass = 2.0, inertia = 0.1, 0.2, 0.3, position = 1, 0, 1 /
&spring name = 's', bodies = 'ground', 'weight', first_point = 1.1, 0, 1, stiffness = 1e4,
   rotational_stiffness = 1e3 /
"""
    found = settle(run, tmp_path, text)
    k = 4 / 3 * MODULUS * math.sqrt(0.01)
    depth = (0.5 * 9.81 / k) ** (2 / 3)
    assert found["contact/approach"][0] == pytest.approx(depth, rel=1e-9)
    assert found["contact/normal_force"][0] == pytest.approx(0.5 * 9.81, rel=1e-9)
    assert math.isnan(found["contact/contact_angle"][0])
    a = math.sqrt(0.01 * depth)
    assert found["contact/pressure"][0] == pytest.approx(1.5 * 0.5 * 9.81 / (math.pi * a * a))
    assert found["body/position"][0] == pytest.approx([0, 0, 0.01 - depth], abs=1e-15)
    # The weight hangs 0.1 m from where it is held: it sinks, and turns about y.
    sink, turn = found["body/displacement"][1], found["body/rotation"][1]
    angle = turn[1]
    assert 1e3 * angle == pytest.approx(-2 * 9.81 * 0.1 * math.cos(angle), rel=1e-9)
    at = np.array([0.1 * math.cos(angle), -0.1 * math.sin(angle)])
    point = np.array([1, 1]) + sink[[0, 2]] + at
    assert point == pytest.approx([1.1, 1 - 2 * 9.81 / 1e4], abs=1e-9)


def test_the_scene_that_is_written_begins_at_rest(run, tmp_path):
    (tmp_path / "e.nml").write_text(SHAFT)
    result = run("equilibrium", "e.nml", "--scene", "rest.nml")
    assert result.status == 0, result.err
    assert "stiffness of shaft" in result.out
    assert "left_outer_1" in result.out
    first = settle(run, tmp_path, SHAFT)
    again = settle(run, tmp_path, (tmp_path / "rest.nml").read_text())
    assert np.abs(again["body/displacement"]).max() < 1e-13
    assert np.abs(again["body/rotation"]).max() < 1e-12
    assert again["contact/normal_force"] == pytest.approx(
        first["contact/normal_force"], rel=1e-7, abs=1e-6
    )
    # A run that begins there stays there.
    assert run("run", "rest.nml", "-q", "-o", "run.h5", "--set", "scene.t_end=1e-4").status == 0
    with h5py.File(tmp_path / "run.h5") as file:
        force = file["trajectory/normal_force"][()]
    inner = [i for i, n in enumerate(first["contact/name"]) if b"inner" in n]
    assert force[-1][inner] == pytest.approx(force[0][inner], rel=1e-3, abs=1e-2)
    result = run("equilibrium", "e.nml", "--scene", "rest.nml")
    assert result.status == 74
    assert "exists" in result.err


def test_the_scene_of_a_bearing_that_turns_begins_at_rest(run, tmp_path):
    # The cage has an angular velocity in the inertial frame, which stays while the cage is moved.
    text = PUBLISHED.format(clearance=0.0, radial=300, axial=500, moment=", moment_load = 1, 0, 0")
    keys = "inner_speed = 300, initial_state = 'rolling', cage = .true., cage_mass = 0.02,"
    text = text.replace("   ring_mass", f"   {keys} pocket_clearance = 2e-4,\n   ring_mass")
    text = text.replace("t_end = 0.01", "t_end = 0.01, gravity = 0, 0, -9.81")
    first = settle(run, tmp_path, text)
    result = run("equilibrium", "e.nml", "--scene", "rest.nml", "-q")
    assert result.status == 0, result.err
    again = settle(run, tmp_path, (tmp_path / "rest.nml").read_text())
    assert np.abs(again["body/displacement"]).max() < 1e-12
    assert again["body/position"] == pytest.approx(first["body/position"], abs=1e-12)
    assert run("run", "rest.nml", "-q", "-o", "run.h5", "--set", "scene.t_end=1e-6").status == 0
    with h5py.File(tmp_path / "run.h5") as file:
        spin = file["trajectory/angular_velocity"][0]
        cage = [name.decode() for name in file["body/name"]].index("b_cage")
    assert np.linalg.norm(spin[cage]) > 10
    assert np.abs(first["body/rotation"][cage]).max() > 1e-6


def test_what_has_no_rest_position(run, tmp_path):
    ball = "&body name = 'a', mass = 1, inertia = 3*1.0, position = 0, 0, 0.02 /"
    scene = "&scene gravity = 0, 0, -9.81, t_end = 1 /\n"
    (tmp_path / "e.nml").write_text(scene + ball)
    result = run("equilibrium", "e.nml", "-o", "e.h5")
    assert result.status == 1
    assert "'a'" in result.err
    assert not (tmp_path / "e.h5").exists()
    (tmp_path / "e.nml").write_text(scene + ball.replace("mass", "motion = 'fixed', mass"))
    result = run("equilibrium", "e.nml")
    assert result.status == 2
    assert "free to move" in result.err
    surfaces = """
&material name = 'steel', young = 2.1e11, poisson = 0.3 /
&surface name = 'ball', body = 'a', shape = 'sphere', radius = 0.01, material = 'steel' /
&surface name = 'floor', body = 'ground', shape = 'plane', material = 'steel' /
&contact name = 'c', surfaces = 'ball', 'floor', normal = 'rigid', restitution = 0.5 /
"""
    (tmp_path / "e.nml").write_text(scene + ball + surfaces)
    result = run("equilibrium", "e.nml")
    assert result.status == 2
    assert "contact.normal=hertz" in result.err


def test_a_torque_turns_a_ring_that_turns_freely(run, tmp_path):
    # A moment across a ring that tilts has a share about its axis, where nothing holds it.
    text = PUBLISHED.format(clearance=0.0, radial=200, axial=500, moment=", moment_load = 1, 0, 0")
    (tmp_path / "e.nml").write_text(text.replace("'rotor'", "'free'"))
    result = run("equilibrium", "e.nml")
    assert result.status == 1
    assert "'b_inner'" in result.err
    assert "ring_motion" in result.err
    result = run("equilibrium", "e.nml", "-q", "--set", "bearing.ring_motion=rotor")
    assert result.status == 0, result.err


# --- rotors ------------------------------------------------------------------------------------

FREELY = """\
&scene t_end = 0.5 /
&body name = 'a', motion = '{motion}', mass = 2, inertia = 0.02, 0.02, 0.03, axis = 1, 2, 0,
   angle = 0.3, spin = 1, 0.5, 20, velocity = 0, 0, 1 /
&integrator method = 'explicit8', rtol = 1e-12 /
"""


def trajectory(run, tmp_path, text, *words):
    (tmp_path / "r.nml").write_text(text)
    result = run("run", "r.nml", "-q", "--force", "-o", "r.h5", *words)
    assert result.status == 0, result.err
    with h5py.File(tmp_path / "r.h5") as file:
        return {name: data[()] for name, data in file["trajectory"].items()}


def test_a_rotor_without_torque_is_a_round_free_body(run, tmp_path):
    rotor = trajectory(run, tmp_path, FREELY.format(motion="rotor"))
    free = trajectory(run, tmp_path, FREELY.format(motion="free"))
    assert rotor["quaternion"] == pytest.approx(free["quaternion"], abs=1e-10)
    assert rotor["angular_velocity"] == pytest.approx(free["angular_velocity"], abs=1e-9)


@pytest.mark.parametrize("frame", ["inertial", "body"])
def test_a_rotor_under_torque_keeps_its_speed_and_the_balance(frame, run, tmp_path):
    text = FREELY.format(motion="rotor").replace(
        "velocity", f"applied_torque = 0.3, 0.2, 0.5, applied_frame = '{frame}', velocity"
    )
    found = trajectory(run, tmp_path, text)
    w, x, y, z = (
        found["quaternion"][:, 0] / np.linalg.norm(found["quaternion"][:, 0], axis=1)[:, None]
    ).T
    axis = np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)]).T
    speed = np.einsum("ti,ti->t", axis, found["angular_velocity"][:, 0])
    assert speed == pytest.approx(np.full(len(speed), 20.0), abs=1e-9)
    assert np.ptp(found["energy_kinetic"]) > 1e-3
    assert np.abs(found["energy_error"]).max() < 1e-10
    drive = found["drive_torque"][:, 0]
    assert np.cross(drive, axis) == pytest.approx(np.zeros_like(axis), abs=1e-12)
    implicit = trajectory(
        run,
        tmp_path,
        text,
        "--set",
        "integrator.method=cvode_bdf",
        "--set",
        "integrator.rtol=1e-10",
    )
    assert implicit["quaternion"] == pytest.approx(found["quaternion"], abs=1e-6)
    # The ramp of its drive.
    ramp = text.replace("velocity", "final_angular_velocity = {}, ramp_duration = 0.25, velocity")
    final = 30 * axis[0]
    found = trajectory(run, tmp_path, ramp.format(", ".join(map(repr, map(float, final)))))
    w, x, y, z = (found["quaternion"][-1, 0] / np.linalg.norm(found["quaternion"][-1, 0])).T
    axis = np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])
    assert axis @ found["angular_velocity"][-1, 0] == pytest.approx(30.0, abs=1e-8)


def test_a_bearing_whose_ring_tilts_runs_and_closes_its_balance(run, tmp_path):
    text = PUBLISHED.format(
        clearance=1e-5,
        radial=300,
        axial=500,
        moment=", moment_load = 0, 3, 0, inner_speed = 100, friction = 'contensou_exact',"
        " friction_coefficient = 0.05, damping = 'hunt_crossley', damping_coefficient = 20,"
        " initial_state = 'rolling', regularization_velocity = 1e-4",
    ).replace("0.01 /", "2e-3 /")
    found = trajectory(run, tmp_path, text)
    energy = np.abs(found["energy_kinetic"]).max() + found["work_applied"][-1]
    assert np.abs(found["energy_error"]).max() < 1e-6 * energy
    assert np.abs(found["angular_velocity"][-1, 0, :2]).max() > 1e-6
    other = trajectory(run, tmp_path, text, "--set", "integrator.jacobian=differences")
    assert other["position"] == pytest.approx(found["position"], abs=1e-8)


def test_a_ring_that_turns_freely_against_a_drag(run, tmp_path):
    text = PUBLISHED.format(clearance=0.0, radial=0, axial=500, moment=", moment_load = 0, 0, 0.2")
    text = text.replace("'rotor'", "'free'").replace("0.01 /", "0.02 /") + (
        "&spring name = 'drag', bodies = 'ground', 'b_inner', rotational_damping = 0, 0, 0.1 /\n"
    )
    found = trajectory(run, tmp_path, text)
    spin = found["angular_velocity"][:, 0, 2]
    # Without friction the balls stay, and the torque meets inertia and drag only.
    wanted = 2.0 * (1 - np.exp(-0.1 / 2e-4 * found["time"]))
    assert spin == pytest.approx(wanted, abs=1e-5)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ("ring_motion = 'rotor'", "needs 'ring_inertia'"),
        ("ring_inertia = 1e-4, 1e-4", "does not tilt"),
        ("moment_load = 1, 0, 0", "does not tilt"),
        ("contact_angle = 0.3, clearance = 1e-5", "beside 'contact_angle'"),
        ("contact_angle = -0.3, axial_load = 100", "pulls the rings apart"),
        ("inner_body = 'ground'", "'ring_mass' has no meaning"),
        ("four_point = .true.", "needs the contact angle"),
        ("four_point = .true., contact_angle = -0.6", "needs the contact angle"),
        ("preload = 100", "'preload' without 'contact_angle'"),
        ("preload = 100, contact_angle = 0.4", "'preload' beside 'ring_mass'"),
    ],
)
def test_mistakes_of_rings(keys, message, run, mistakes, tmp_path):
    text = PUBLISHED.split("   ring_mass")[0].replace("7850,", f"7850, ring_mass = 1.0, {keys} /\n")
    (tmp_path / "e.nml").write_text(text)
    result = run("check", "e.nml")
    assert result.status == 2
    assert any(message in m.message for m in mistakes(result.err)), result.err
