"""Shots through gaps and past edges: whatever a body meets on its way is seen.

    python tests/campaigns/shots.py [FIRST] [NUMBER] [FOLDER]

draws the shots FIRST (0) to FIRST + NUMBER (400), runs them in FOLDER (a temporary one) and prints
what came of them by kind. Up to the first touch all bodies move and turn uniformly, so that the
time of it follows from the shapes alone. A shot is wrong if a touch is missed or told of where
there is none, or later than the surfaces can overlap, if its energy does not close, or if it fails
without saying of which contact. Exit status 1 if one is wrong. CONTENSOU names the executable.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import h5py
import numpy as np

METHODS = ("explicit8", "cvode_bdf", "cvode_adams", "auto")

# Overlap over the smallest radius that may go unseen, with the rounding of an attitude; a touch is
# told of no later than at such a one.
UNSEEN = 1e-6
LATE = 1e-4

HEAD = """\
&scene t_end = {t_end} /
&material name = 'm', young = 1e11, poisson = 0.3 /
&integrator method = '{method}', rtol = {rtol} /
&output file = 'out.h5', interval = {interval} /
"""
BODY = """\
&body name = '{name}', mass = {mass}, inertia = 3*{inertia}, position = {position},
      velocity = {velocity}, spin = {spin} /
"""


def numbers(values) -> str:
    """One number or several as a scene has them."""
    return ", ".join(repr(float(x)) for x in np.ravel(values))


def turned(vector, spin, t):
    """A vector that turns with a body, after a time."""
    rate = np.linalg.norm(spin)
    if rate == 0:
        return np.array(vector, float)
    axis = spin / rate
    c, s = np.cos(rate * t), np.sin(rate * t)
    return c * vector + s * np.cross(axis, vector) + (1 - c) * (axis @ vector) * axis


@dataclass
class Flight:
    """A body that moves and turns uniformly."""

    position: np.ndarray
    velocity: np.ndarray
    spin: np.ndarray = field(default_factory=lambda: np.zeros(3))

    def at(self, t, centre=(0, 0, 0)):
        """Where a point of it is."""
        return self.position + t * self.velocity + turned(np.array(centre, float), self.spin, t)


@dataclass
class Shot:
    """A scene, and the gap of its first contact or contacts as long as nothing touches."""

    kind: str
    text: str
    gap: object
    # Bound of its rate.
    rate: float
    t_end: float
    # The smallest one.
    radius: float
    rigid: bool
    method: str
    rtol: float

    def first_touch(self):
        """Time at which the gap is zero, None if it never is; and the smallest gap before."""
        t, least = 0.0, np.inf
        while t < self.t_end:
            gap = self.gap(t)
            least = min(least, gap)
            if gap < 1e-9 * self.radius:
                return t, least
            t += max(gap, 1e-8 * self.radius) / self.rate
        return None, least

    def depth(self, t):
        """How deep the surfaces would overlap after a time if nothing held them."""
        step = 0.02 * self.radius / self.rate
        worst = 0.0
        for _ in range(20000):
            gap = self.gap(t)
            worst = min(worst, gap)
            if gap > 0.05 * self.radius or worst < -0.01 * self.radius or t > self.t_end:
                break
            t += min(step, max(abs(gap), 1e-7 * self.radius) / self.rate)
        return -worst


class Range:
    """Builds one shot."""

    def __init__(self, seed):
        self.draw = np.random.default_rng(seed)
        self.groups = []
        self.flights = []

    def log(self, low, high):
        return float(np.exp(self.draw.uniform(np.log(low), np.log(high))))

    def direction(self):
        x = self.draw.normal(size=3)
        return x / np.linalg.norm(x)

    def across(self, axis):
        x = np.cross(axis, self.direction())
        return x / np.linalg.norm(x)

    def body(self, name, flight, radius):
        mass = 2e3 * 4 / 3 * np.pi * radius**3
        self.flights.append(flight)
        self.groups.append(
            BODY.format(
                name=name,
                mass=numbers(mass),
                inertia=numbers(0.4 * mass * radius**2),
                position=numbers(flight.position),
                velocity=numbers(flight.velocity),
                spin=numbers(flight.spin),
            )
        )

    def surface(self, name, body, **keys):
        words = [
            f"{key} = '{value}'" if isinstance(value, str) else f"{key} = {numbers(value)}"
            for key, value in keys.items()
        ]
        self.groups.append(
            f"&surface name = '{name}', body = '{body}', {', '.join(words)}, material = 'm' /\n"
        )

    def contact(self, a, b):
        self.groups.append(f"&contact name = '{a}_{b}', surfaces = '{a}', '{b}'{{law}} /\n")

    def finish(self, kind, gap, rate, t_end, radius):
        """The shot with laws, method and tolerance drawn at random."""
        rigid = bool(self.draw.random() < 0.5)
        law = ", friction = 'none'"
        if self.draw.random() < 0.5:
            law = ", friction = 'contensou_exact', friction_coefficient = 0.2"
        restitution = float(self.draw.choice([0.0, 0.3, 0.9, 1.0]))
        if rigid:
            law += f", normal = 'rigid', restitution = {restitution}"
        elif restitution > 0:
            law += f", damping = 'hunt_crossley', restitution = {restitution}"
        method = METHODS[self.draw.integers(4)]
        rtol = float(10.0 ** -self.draw.integers(6, 11))
        text = HEAD.format(
            t_end=numbers(t_end),
            method=method,
            rtol=numbers(rtol),
            interval=numbers(t_end / self.draw.choice([1, 7, 100])),
        )
        text += "".join(self.groups).format(law=law)
        return Shot(kind, text, gap, rate, t_end, radius, rigid, method, rtol)


def two_balls(r):
    """Two small balls that meet from hundreds of radii away, or just miss each other."""
    a, b = r.log(1e-3, 1e-2), 0.0
    b = a * r.log(0.2, 5)
    axis = r.direction()
    aside = r.across(axis) * (a + b) * r.draw.choice([r.draw.uniform(0, 0.99), 1 + r.log(1e-6, 1)])
    far = (a + b) * r.log(10, 3000)
    va, vb = r.log(0.1, 50), r.log(0.1, 50)
    t = far / va
    meet = r.direction() * r.draw.choice([0, far])
    one = Flight(meet - t * va * axis, va * axis)
    other = Flight(meet + aside + t * vb * axis, -vb * axis, r.direction() * r.log(1, 1e3))
    r.body("a", one, a)
    r.body("b", other, b)
    r.surface("sa", "a", shape="sphere", radius=a)
    r.surface("sb", "b", shape="sphere", radius=b)
    r.contact("sa", "sb")

    def gap(t):
        return np.linalg.norm(one.at(t) - other.at(t)) - a - b

    return r.finish("two balls", gap, va + vb, 2 * t, min(a, b))


def thin_gap(r):
    """A ball through the gap of two posts, which it just passes or does not."""
    a = r.log(1e-3, 1e-2)
    post = a * r.log(0.05, 3)
    clear = a * r.log(1e-6, 0.3) * r.draw.choice([-1, 1])
    far, v = a * r.log(10, 3000), r.log(0.1, 50)
    y = post + a + clear
    ball = Flight(
        np.array([-far, clear * r.draw.uniform(-0.9, 0.9), a * r.draw.uniform(-1, 1)]),
        np.array([v, 0, 0]),
        r.direction() * r.log(1, 1e3),
    )
    r.body("a", ball, a)
    r.surface("s", "a", shape="sphere", radius=a)
    for name, side in (("p", 1), ("q", -1)):
        r.surface(name, "ground", shape="cylinder", radius=post, centre=(0, side * y, 0))
        r.contact("s", name)

    def gap(t):
        x = ball.at(t)
        return min(np.hypot(x[0], x[1] - y), np.hypot(x[0], x[1] + y)) - a - post

    return r.finish("thin gap", gap, v, 2 * far / v, min(a, post))


def thin_rod(r):
    """A ball past the edge of a thin rod, askew."""
    a = r.log(1e-3, 1e-2)
    rod = a * r.log(0.01, 1)
    miss = (a + rod) * r.draw.choice([r.draw.uniform(0, 0.99), 1 + r.log(1e-6, 1)])
    far, v = a * r.log(10, 3000), r.log(0.1, 50)
    axis = r.direction()
    course = r.direction()
    aside = np.cross(axis, course)
    aside *= miss / np.linalg.norm(aside)
    ball = Flight(aside - far * course, v * course, r.direction() * r.log(1, 1e3))
    r.body("a", ball, a)
    r.surface("s", "a", shape="sphere", radius=a)
    r.surface("p", "ground", shape="cylinder", radius=rod, direction=axis)
    r.contact("p", "s")

    def gap(t):
        return np.linalg.norm(np.cross(axis, ball.at(t))) - a - rod

    return r.finish("thin rod", gap, v, 2 * far / v, min(a, rod))


def ring(r):
    """A ball through a ring, which it just passes or does not."""
    a = r.log(1e-3, 1e-2)
    wire = a * r.log(0.05, 1)
    clear = a * r.log(1e-5, 1) * r.draw.choice([-1, 1])
    large = a + wire + clear
    far, v = a * r.log(10, 3000), r.log(0.1, 50)
    course = np.array([*r.draw.normal(scale=0.1, size=2), 1.0])
    course /= np.linalg.norm(course)
    aside = np.array([*(0.5 * abs(clear) * r.draw.uniform(-1, 1, size=2)), 0])
    ball = Flight(aside - far * course, v * course)
    r.body("a", ball, a)
    r.surface("s", "a", shape="sphere", radius=a)
    r.surface("p", "ground", shape="torus", major_radius=large, minor_radius=wire)
    r.contact("s", "p")

    def gap(t):
        x = ball.at(t)
        return np.hypot(np.hypot(x[0], x[1]) - large, x[2]) - a - wire

    return r.finish("ring", gap, v, 2 * far / v, min(a, wire))


def blade(r):
    """A turning dumb-bell whose small balls fly past a small ball, or hit it."""
    a = r.log(1e-3, 1e-2)
    arm = a * r.log(3, 50)
    target = a * r.log(0.1, 3)
    v, rate = r.log(0.05, 5), r.log(1, 30) / arm
    course, axis = r.direction(), r.direction()
    far = (arm + a + target) * r.log(1.05, 20)
    aside = r.across(course) * r.draw.uniform(0, 1.2) * arm
    bell = Flight(aside - far * course, v * course, rate * axis)
    centre = arm * r.across(axis)
    r.body("a", bell, arm)
    r.surface("g", "ground", shape="sphere", radius=target)
    for name, side in (("p", 1), ("q", -1)):
        r.surface(name, "a", shape="sphere", radius=a, centre=side * centre)
        r.contact("g", name)

    def gap(t):
        ends = (bell.at(t, side * centre) for side in (1, -1))
        return min(np.linalg.norm(x) for x in ends) - a - target

    return r.finish("blade", gap, v + rate * arm, 2 * far / v, min(a, target))


def tip(r):
    """A long ellipsoid that turns fast over a plane, or sinks towards it."""
    axes = np.sort(r.log(1e-3, 1e-2) * r.draw.uniform(0.3, 1, 3))
    axes[2] *= r.draw.uniform(1, 4)
    v, rate = r.log(0.05, 5), r.log(1, 30) / axes[2]
    far = axes[2] * r.draw.uniform(1.01, 3)
    height = r.draw.choice([axes[2] * (1 + r.log(1e-6, 1)), axes[2] * r.draw.uniform(0.8, 1)])
    down = r.draw.choice([0.0, r.log(1e-3, 1)])
    size = axes[2]
    start = max(height, 1.001 * size) + far * down
    body = Flight(
        np.array([0, 0, start]),
        v * np.array([1.0, 0, 0]) * (1 - down) - np.array([0, 0, v * down]),
        rate * r.direction(),
    )
    r.body("a", body, size)
    r.surface("s", "a", shape="ellipsoid", semi_axes=axes)
    r.surface("p", "ground", shape="plane")
    r.contact("p", "s")
    up = np.array([0, 0, 1.0])

    def gap(t):
        n = turned(up, -body.spin, t)
        return body.at(t)[2] - np.linalg.norm(axes * n)

    t_end = 2 * (start / (v * down) if down else r.log(2, 200) / rate)
    return r.finish(
        "tip", gap, v * down + rate * size, min(t_end, 500 / rate), min(axes) ** 2 / size
    )


def bore(r):
    """A long ellipsoid that flies and turns within a bore, where it has two spots."""
    axes = np.sort(r.log(1e-3, 1e-2) * r.draw.uniform(0.3, 1, 3))
    axes[2] *= r.draw.uniform(1, 4)
    size = axes[2]
    hole = size * r.draw.uniform(1.05, 30)
    v, rate = r.log(0.1, 20), r.log(0.1, 30) / size
    body = Flight(np.zeros(3), v * r.direction(), rate * r.direction())
    r.body("a", body, size)
    r.surface("s", "a", shape="ellipsoid", semi_axes=axes)
    r.surface("p", "ground", shape="cylinder", radius=hole, side="inside")
    r.contact("p", "s")
    angles = np.linspace(0, 2 * np.pi, 361)
    units = np.stack([np.cos(angles), np.sin(angles), 0 * angles])

    def gap(t):
        # The farthest point from the axis lies in one of the directions across it.
        position = body.at(t)
        turn = np.stack([turned(e, -body.spin, t) for e in np.eye(3)], axis=1)
        far = position @ units + np.linalg.norm(axes[:, None] * (turn @ units), axis=0)
        k = int(np.argmax(far))
        low, high = angles[max(k - 1, 0)], angles[min(k + 1, 360)]
        fine = np.linspace(low, high, 101)
        unit = np.stack([np.cos(fine), np.sin(fine), 0 * fine])
        far = position @ unit + np.linalg.norm(axes[:, None] * (turn @ unit), axis=0)
        return hole - far.max()

    reach = v * np.hypot(*(body.velocity / v)[:2])
    t_end = 1.5 * hole / max(reach, 0.05 * v)
    return r.finish("bore", gap, v + rate * size, min(t_end, 200 / rate), min(axes) ** 2 / size)


KINDS = (two_balls, thin_gap, thin_rod, ring, blade, tip, bore)


def shot(seed: int) -> Shot:
    """One of the shots."""
    return KINDS[seed % len(KINDS)](Range(seed))


def fly(executable: str, drawn: Shot, folder: Path, limit: float = 120) -> tuple[str, str]:
    """What came of a shot, in words, and what is wrong with that; empty for nothing."""
    (folder / "shot.nml").write_text(drawn.text)
    try:
        done = subprocess.run(
            [executable, "run", "shot.nml", "-q", "--force"],
            cwd=folder,
            capture_output=True,
            text=True,
            timeout=limit,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return "takes too long", ""
    t, least = drawn.first_touch()
    if done.returncode:
        said = done.stderr.strip()
        words = "ends: " + re.sub(r"[-+]?\d[\d.e+-]*", "#", said.splitlines()[0])[:60]
        wrong = "" if done.returncode == 1 and re.search("contact '|integrator\\.", said) else said
        if t is None and least > UNSEEN * drawn.radius:
            wrong = wrong or f"nothing touches, but: {said}"
        return words, wrong
    with h5py.File(folder / "out.h5") as file:
        times = file["events/time"][()]
        error = float(file["summary/energy_error_relative"][()])
        gaps = file["trajectory/gap"][()]
    wrong = []
    if t is None:
        words = "misses"
        if len(times) and least > UNSEEN * drawn.radius:
            wrong.append(f"a touch at {times[0]:.9g}, the smallest gap is {least:.3g}")
    elif len(times) == 0:
        words = "grazes"
        depth = drawn.depth(t)
        if depth > UNSEEN * drawn.radius:
            wrong.append(f"the touch at {t:.9g} is missed, {depth / drawn.radius:.2e} deep")
    else:
        words = "touches"
        off = drawn.gap(times[0]) / drawn.radius
        # The position has an error, too.
        if abs(off) > LATE + 10 * drawn.rtol * drawn.rate * times[0] / drawn.radius:
            wrong.append(f"a touch at {times[0]:.9g} with the gap {off:.2e} of the radius")
    if drawn.rigid and np.nanmin(gaps) < -UNSEEN * drawn.radius:
        wrong.append(f"overlap of {-np.nanmin(gaps) / drawn.radius:.2e} radii")
    if not abs(error) <= 1e-4:
        wrong.append(f"energy is off by {error:.1e}")
    return words, "; ".join(wrong)


def main() -> int:
    """Do the campaign."""
    first = int(sys.argv[1]) if len(sys.argv) > 1 else 0
    number = int(sys.argv[2]) if len(sys.argv) > 2 else 400
    folder = Path(tempfile.mkdtemp(dir=sys.argv[3] if len(sys.argv) > 3 else None))
    executable = os.path.abspath(os.environ["CONTENSOU"])
    counts, wrongs = Counter(), 0
    for seed in range(first, first + number):
        drawn = shot(seed)
        words, wrong = fly(executable, drawn, folder)
        law = "rigid" if drawn.rigid else "hertz"
        counts[drawn.kind, words] += 1
        if wrong:
            wrongs += 1
            print(f"{seed} ({drawn.kind}, {law}, {drawn.method}): {wrong}", flush=True)
    for (kind, words), count in sorted(counts.items()):
        print(f"{kind:10s} {words:20s} {count:5d}")
    print(f"{wrongs} of {number} went wrong")
    shutil.rmtree(folder)
    return bool(wrongs)


if __name__ == "__main__":
    sys.exit(main())
