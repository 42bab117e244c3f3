"""Random scenes: shapes, places, speeds and materials over many decades.

Each scene is simulated for a millisecond. It must run to its end with finite numbers, or end with a
message. CONTENSOU_RANDOM_SCENES says how many scenes are tried, CONTENSOU_RANDOM_SEED with which
number they begin.
"""

from __future__ import annotations

import math
import os
import random
import re
import resource
import signal
import subprocess
from collections import Counter
from concurrent.futures import ThreadPoolExecutor

import h5py
import numpy as np
import pytest

METHODS = ("cvode_bdf", "cvode_bdf", "cvode_adams", "explicit8")
FRICTIONS = (
    "none",
    "coulomb",
    "contensou_simplified",
    "pade11",
    "pade22",
    "contensou_exact",
    "contensou_exact",
)
PAIRS = (
    ("sphere", "plane"),
    ("sphere", "sphere"),
    ("sphere", "cylinder"),
    ("sphere", "ellipsoid"),
    ("sphere", "torus"),
    ("ellipsoid", "plane"),
    ("torus", "plane"),
    ("cylinder", "cylinder"),
    ("ellipsoid", "ellipsoid"),
    ("ellipsoid", "cylinder"),
    ("ellipsoid", "torus"),
    ("torus", "cylinder"),
    ("torus", "torus"),
)
HOLLOW = ("sphere", "cylinder", "ellipsoid", "torus")

T_END = 1e-3
# An elastic impact that is shorter takes more than a thousand of them in a run.
SHORTEST_IMPACT = 1e-6


def decades(rng, low, high):
    """A number between two powers of ten, log-uniform."""
    return 10.0 ** rng.uniform(low, high)


def direction(rng):
    """A unit vector."""
    while True:
        v = np.array([rng.gauss(0, 1) for _ in range(3)])
        if (length := float(np.linalg.norm(v))) > 0.1:
            return v / length


def rotation(q):
    """Rotation matrix of a unit quaternion."""
    w, x, y, z = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def words(values):
    """Numbers of a namelist."""
    return ", ".join(repr(float(value)) for value in np.atleast_1d(values))


class Shape:
    """A surface with its sizes, and the point of it with a given outward normal."""

    def __init__(self, rng, kind, size, inside=False):
        self.kind, self.inside, self.rng = kind, inside, rng
        self.size = size
        ratios = [decades(rng, -0.7, 0) for _ in range(3)]
        self.keys = {}
        if kind in ("sphere", "cylinder"):
            self.keys["radius"] = size
        elif kind == "ellipsoid":
            self.axes = size * np.array(ratios)
            if rng.random() < 0.2:
                self.axes[1] = self.axes[0]
            self.keys["semi_axes"] = self.axes
        elif kind == "torus":
            self.minor = size * rng.uniform(0.05, 0.8)
            self.keys |= {"major_radius": size, "minor_radius": self.minor}

    def normal(self):
        """A possible outward normal, in the frame of the surface."""
        n = direction(self.rng)
        if self.kind == "plane":
            return np.array([0.0, 0.0, 1.0])
        if self.kind == "cylinder":
            n[2] = 0.0
            return n / np.linalg.norm(n)
        return n

    def point(self, n):
        """The point with that outward normal."""
        if self.kind == "plane":
            return np.zeros(3)
        if self.kind in ("sphere", "cylinder"):
            return self.size * n
        if self.kind == "ellipsoid":
            return self.axes**2 * n / np.linalg.norm(self.axes * n)
        ring = np.array([n[0], n[1], 0.0])
        return self.size * ring / max(np.linalg.norm(ring), 1e-300) + self.minor * n

    def text(self):
        """Keys of its group."""
        text = f"shape = '{self.kind}'"
        for key, values in self.keys.items():
            text += f", {key} = {words(values)}"
        return text + (", side = 'inside'" if self.inside else "")


def contact_text(rng, method):
    """Models of a contact."""
    text = ""
    if rng.random() < 0.3:
        text += ", normal = 'vilke'"
        text += rng.choice(
            ("", ", ellipse = 'chord'", ", ellipse = 'exact'", ", ellipse = 'power'")
        )
    damping = rng.choice(("none", "hunt_crossley", "viscous", "tsuji"))
    if damping != "none":
        text += f", damping = '{damping}'"
        low, high = {"hunt_crossley": (-3, 4), "viscous": (-2, 12), "tsuji": (-3, 1)}[damping]
        if damping != "viscous" and rng.random() < 0.4:
            text += f", restitution = {rng.uniform(0.01, 1.0)!r}"
        else:
            text += f", damping_coefficient = {decades(rng, low, high)!r}"
    friction = rng.choice(FRICTIONS)
    if friction != "none":
        mu = rng.choice((0.0, 0.3, decades(rng, -6, 2)))
        text += f", friction = '{friction}', friction_coefficient = {mu!r}"
        if friction == "coulomb" or rng.random() < 0.3:
            text += f", regularization_velocity = {decades(rng, -9, 1)!r}"
        if rng.random() < 0.2:
            text += ", drilling = .false."
    if rng.random() < 0.2:
        rolling = rng.choice(("constant", "hysteresis"))
        text += f", rolling = '{rolling}', rolling_coefficient = {decades(rng, -7, -1)!r}"
        text += f", rolling_regularization = {decades(rng, -6, 2)!r}"
    return text


def random_scene(seed):
    """The text of a scene; the same for the same seed."""
    rng = random.Random(seed)
    method = rng.choice(METHODS)
    kinds = list(rng.choice(PAIRS))
    hollow = kinds[1] in HOLLOW and kinds[0] != "cylinder" and rng.random() < 0.25
    size = decades(rng, -5, 1)
    ratio = decades(rng, -2, -0.3) if hollow else decades(rng, -1.5, 1.5)
    first = Shape(rng, kinds[0], size * ratio if hollow else size)
    second = Shape(rng, kinds[1], size if hollow else size * ratio, hollow)
    if not hollow and rng.random() < 0.5:
        first, second = second, first
    if first.kind == "plane":
        first, second = second, first
    smallest = min(first.size, second.size)
    # Where they touch: the second surface in the inertial frame, the first one put against it.
    while True:
        q = np.array([rng.gauss(0, 1) for _ in range(4)])
        if np.linalg.norm(q) > 0.1:
            q /= np.linalg.norm(q)
            break
    if rng.random() < 0.15:
        q = np.array([1.0, 0.0, 0.0, 0.0])
    turned = rotation(q)
    n = second.normal()
    touching = second.point(n)
    outward = n if not hollow else -n
    if first.kind == "cylinder":
        # The axis of a cylinder is across the common normal.
        axis = np.cross(outward, direction(rng))
        axis /= np.linalg.norm(axis)
        turned = np.column_stack([-outward, np.cross(axis, -outward), axis])
        w = math.sqrt(max(0.0, 1.0 + np.trace(turned))) / 2.0
        if w < 1e-3:
            w, turned = 1.0, np.eye(3)
            q = np.array([1.0, 0.0, 0.0, 0.0])
        else:
            q = np.array(
                [
                    w,
                    (turned[2, 1] - turned[1, 2]) / (4 * w),
                    (turned[0, 2] - turned[2, 0]) / (4 * w),
                    (turned[1, 0] - turned[0, 1]) / (4 * w),
                ]
            )
    reach = turned @ first.point(turned.T @ -outward)
    gap = rng.choice((0.0, -1.0, 1.0, -1.0)) * decades(rng, -12, -0.5) * smallest
    if rng.random() < 0.03:
        gap = -rng.uniform(0.0, 3.0) * smallest
    position = touching + gap * outward - reach
    # Bodies.
    mass = decades(rng, -9, 5)
    gyration = first.size * decades(rng, -1, 0.3)
    moments = mass * gyration**2 * np.array([1.0, rng.uniform(0.6, 1.0), rng.uniform(0.5, 1.0)])
    speed = rng.choice((0.0, decades(rng, -7, 3), decades(rng, -3, 1)))
    velocity = speed * direction(rng)
    if rng.random() < 0.5:
        velocity = -abs(speed) * outward
    young = [decades(rng, 3, 13) for _ in range(2)]
    # How short an impact may be.
    stiffness = 4.0 / 3.0 * min(young) * math.sqrt(smallest)
    fastest = max(speed, 1e-3)
    shortest = 3.2 * (mass**2 / (stiffness**2 * fastest)) ** 0.2
    if shortest < SHORTEST_IMPACT:
        mass *= (SHORTEST_IMPACT / shortest) ** 2.5
        moments = moments * (SHORTEST_IMPACT / shortest) ** 2.5
    spin = rng.choice((0.0, decades(rng, -6, 4), decades(rng, -1, 3))) * direction(rng)
    gravity = rng.choice((0.0, 9.81, decades(rng, -3, 4)))
    away = direction(rng) if rng.random() < 0.3 else -outward
    text = f"&scene gravity = {words(gravity * away)}, t_end = {T_END} /\n"
    for name, modulus in zip(("one", "two"), young, strict=True):
        poisson = rng.uniform(-0.5, 0.5)
        text += f"&material name = '{name}', young = {modulus!r}, poisson = {poisson!r} /\n"
    free = f"mass = {mass!r}, inertia = {words(moments)}"
    rates = f"velocity = {words(velocity)}, angular_velocity = {words(spin)}"
    pose = f"position = {words(position)}, quaternion = {words(q)}"
    motion = rng.choice(("free",) * 6 + ("prescribed",))
    if motion == "free":
        text += f"&body name = 'a', {free}, {pose}, {rates}"
        if rng.random() < 0.1:
            frame = rng.choice(("inertial", "body"))
            force = mass * decades(rng, -2, 4) * direction(rng)
            text += f", applied_force = {words(force)}, applied_frame = '{frame}'"
        text += " /\n"
    else:
        text += f"&body name = 'a', motion = 'prescribed', {pose}, {rates}"
        if rng.random() < 0.5:
            text += f", final_velocity = {words(0.5 * velocity)}, ramp_duration = 5e-4"
        text += " /\n"
    owner = "ground"
    if motion != "free" or rng.random() < 0.5:
        owner = "b"
        other = mass * decades(rng, -1, 3)
        moments = other * (second.size * decades(rng, -1, 0.3)) ** 2 * np.array([1.0, 0.8, 0.7])
        text += f"&body name = 'b', mass = {other!r}, inertia = {words(moments)} /\n"
    for name, body, shape, material in (
        ("first", "a", first, "one"),
        ("second", owner, second, "two"),
    ):
        text += f"&surface name = '{name}', body = '{body}', {shape.text()}, "
        text += f"material = '{material}' /\n"
    contact = contact_text(rng, method)
    text += f"&contact name = 'touch', surfaces = 'first', 'second'{contact} /\n"
    if owner == "ground" and rng.random() < 0.3:
        # A second contact of the same body: it may not be apart from the first.
        centre = position + first.size * direction(rng)
        foot = gap * outward - outward * decades(rng, -3, 0) * smallest + touching
        text += (
            f"&surface name = 'ball', body = 'a', shape = 'sphere', radius = {0.3 * first.size!r}, "
            f"centre = {words(turned.T @ (centre - position))}, material = 'two' /\n"
            f"&surface name = 'wall', body = 'ground', shape = 'plane', material = 'one', "
            f"normal = {words(outward)}, centre = {words(foot)} /\n"
            f"&contact name = 'other', surfaces = 'ball', 'wall'{contact_text(rng, method)} /\n"
        )
    rtol = rng.choice((1e-8, decades(rng, -12, -2)))
    text += f"&integrator method = '{method}', rtol = {rtol!r} /\n"
    return text + f"&output file = 'out.h5', interval = {T_END / 20!r} /\n"


FORBIDDEN = ("Backtrace", "HDF5-DIAG", "Fortran runtime", "SIG", "#0", "runtime error", "Sanitizer")


PLACES = ("gap", "contact_point", "contact_normal", "major_direction")


def finite_rows(path):
    """Whether all numbers of an output are finite, and the number of its rows."""
    with h5py.File(path) as file:
        # One of several spots may have no place, and then nothing tells it.
        spots = np.array(["[" in name for name in file["contact/name"].asstr()], dtype=bool)
        for group in ("trajectory", "events", "summary"):
            for name, item in file.get(group, {}).items():
                values = item[()]
                if group == "trajectory" and name in PLACES:
                    values = values[:, ~spots]
                if item.dtype.kind == "f" and not np.isfinite(values).all():
                    return f"{group}/{name} is not finite", 0
        return "", len(file["trajectory/time"])


def attempt(executable, folder, seed, limit):
    """Simulate one scene: how it ended, and what is wrong with that."""
    place = folder / str(seed)
    place.mkdir()
    (place / "scene.nml").write_text(random_scene(seed))
    try:
        done = subprocess.run(
            [executable, "run", "scene.nml", "-q"],
            cwd=place,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=60 * limit,
            check=False,
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 5)),
        )
    except subprocess.TimeoutExpired:
        return "hangs", f"it hangs for {60 * limit} s"
    out, err = (text.decode(errors="backslashreplace") for text in (done.stdout, done.stderr))
    status = done.returncode
    final, part = place / "out.h5", place / "out.h5.part"
    wrong = ""
    if status == 0:
        if not final.exists() or part.exists():
            wrong = "no complete file"
        else:
            wrong, rows = finite_rows(final)
            if not wrong and rows != 21:
                wrong = f"{rows} rows"
            if not wrong and ("nan" in out.lower() or "infinity" in out.lower()):
                wrong = "a summary without numbers"
    elif status in (1, 2):
        if final.exists():
            wrong = "a complete file of a failed run"
        elif "error: " not in err or len(err.split("error: ", 1)[1].strip()) < 10:
            wrong = "no message"
        elif part.exists():
            wrong = finite_rows(part)[0]
    elif status in (75, -signal.SIGXCPU, -signal.SIGKILL):
        wrong = f"it needs more than {limit} s of CPU"
    else:
        wrong = f"status {status}"
    if not wrong and any(word in err for word in FORBIDDEN):
        wrong = "not a message for a user"
    if wrong:
        return str(status), f"{wrong}\n{err[-500:]}"
    for file in place.iterdir():
        file.unlink()
    place.rmdir()
    line = err.split("error: ", 1)[-1].splitlines()[0] if err else ""
    return f"{status} {line}" if status else "0", ""


def test_random_scenes_run_or_end_with_a_message(executable, tmp_path, build_kind):
    usual = "400" if build_kind == "release" else "50"
    number = int(os.environ.get("CONTENSOU_RANDOM_SCENES", usual))
    start = int(os.environ.get("CONTENSOU_RANDOM_SEED", "1"))
    limit = 60 if build_kind == "release" else 600
    seeds = range(start, start + number)
    with ThreadPoolExecutor(2) as pool:
        ends = list(pool.map(lambda seed: attempt(executable, tmp_path, seed, limit), seeds))
    counts = Counter(end.split()[0] for end, _ in ends)
    messages = Counter(re.sub(r"\d\S*", "#", end) for end, _ in ends if end[0] in "12")
    print(counts, *messages.most_common(20), sep="\n")
    wrong = [f"scene {seed}: {text}" for seed, (_, text) in zip(seeds, ends, strict=True) if text]
    if wrong:
        pytest.fail(f"{len(wrong)} of {number}, in {tmp_path}\n" + "\n".join(wrong[:20]))
    # Most scenes are of the kind that a user would simulate.
    assert counts["0"] > 0.5 * number


STIFF = """\
&scene gravity = 0, 0, -9.81, t_end = 1e-3 /
&material name = 'gel', young = 1e3, poisson = 0.3 /
&body name = 'bead', mass = 1e-9, inertia = 3*2e-16, position = 0, 0, 0.999e-3, spin = 1e-3, 0, 0 /
&surface name = 'skin', body = 'bead', shape = 'sphere', radius = 1e-3, material = 'gel' /
&surface name = 'floor', body = 'ground', shape = 'plane', material = 'gel' /
&contact name = 'touch', surfaces = 'skin', 'floor', damping = 'hunt_crossley',
   damping_coefficient = 1, friction = 'contensou_exact', friction_coefficient = 0.3,
   rolling = 'constant', rolling_coefficient = 1e-3, rolling_regularization = 1e-6 /
&integrator rtol = 1e-8 /
&output file = 'out.h5', interval = 1e-4 /
"""
BY_RELEASE = pytest.param("explicit8", marks=pytest.mark.release_only("takes a minute"))


@pytest.mark.parametrize("method", ["cvode_adams", BY_RELEASE])
def test_a_bead_that_sticks_is_left_to_bdf(run, tmp_path, method):
    # Its rolling resistance at rest has a rate of 1e10 per second: tens of millions of steps.
    (tmp_path / "bead.nml").write_text(STIFF)
    result = run("run", "bead.nml", "--set", f"integrator.method={method}", timeout=600)
    assert result.status == 0, result.err
    assert f"friction that sticks is too stiff for {method}" in result.out
    with h5py.File(tmp_path / "out.h5") as file:
        assert [name.decode() for name in file["integrator/method"]] == [method, "cvode_bdf"]
        assert file["integrator/steps"][()] < 1e6
        assert file["trajectory/velocity"][-1, 0, 2] == pytest.approx(-0.00233805, rel=1e-5)
        assert abs(file["trajectory/angular_velocity"][-1, 0, 0]) < 1e-9


@pytest.mark.parametrize("method", ["cvode_adams", BY_RELEASE])
def test_a_stiff_bead_ends_with_a_message(run, tmp_path, method):
    # Without friction, with a damping of a million times the critical one.
    text = STIFF.replace("damping_coefficient = 1,", "damping_coefficient = 1e9,")
    text = text[: text.index(" friction = ")] + text[text.index("\n   rolling") :]
    text = text[: text.index(",\n   rolling")] + " /\n" + text[text.index("&integrator") :]
    (tmp_path / "bead.nml").write_text(text)
    result = run("run", "bead.nml", "-q", "--set", f"integrator.method={method}", timeout=600)
    assert result.status == 1
    assert "the steps have shrunk to" in result.err
    assert "'cvode_bdf' takes them in large steps" in result.err
    assert not (tmp_path / "out.h5").exists()
    result = run("run", "bead.nml", "-q", "--force", "--set", "integrator.method=cvode_bdf")
    assert result.status == 0, result.err
