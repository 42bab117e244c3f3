"""Random scenes of rigid contacts that act together, and what must hold in each row of each.

- `random`: tables, stools, dumb-bells, blocks of eight balls and stacks of three plates fall,
  slide, rock and come to rest, with and without friction and restitution, by every method.
- `hostile`: all feet begin within 1e-17 to 1e-10 m of the floor, each at a height of its own, or in
  exact symmetry, or they touch within one step.
- `impacts`: balls that touch each other are hit, in turn or at once.

A scene must end well or with a message, and few may end with one.
"""

from __future__ import annotations

import math
import random
import re
import resource
import shutil
import signal
import subprocess
import tempfile
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import h5py
import numpy as np

METHODS = ("cvode_bdf", "cvode_adams", "explicit8", "auto")
KINDS = ("table", "stool", "pentagon", "dumb-bell", "block", "stack", "hostile")
# Methods whose steps friction that sticks makes too short.
STIFF_WITH = ("cvode_adams", "explicit8")
GRAVITY = 9.81
RADIUS = 0.01
# Seconds of CPU.
PATIENCE = 5


def words(values):
    """Numbers as a namelist has them."""
    return ", ".join(repr(float(value)) for value in values)


def feet(rng, kind):
    """Centres of the balls under a body, in its frame."""
    height = rng.uniform(0.02, 0.1)
    if kind == "dumb-bell":
        return [(-rng.uniform(0.03, 0.15), 0.0, 0.0), (rng.uniform(0.03, 0.15), 0.0, 0.0)]
    if kind in ("table", "block"):
        x, y = rng.uniform(0.04, 0.15), rng.uniform(0.04, 0.15)
        # The centre of mass is not always in the middle.
        dx, dy = 0.0, 0.0
        if rng.random() < 0.5:
            dx, dy = rng.uniform(-0.5, 0.5) * x, rng.uniform(-0.5, 0.5) * y
        low = [(i * x + dx, j * y + dy, -height) for i in (-1, 1) for j in (-1, 1)]
        return low if kind == "table" else low + [(a, b, height) for a, b, _ in low]
    n = {"stool": 3, "pentagon": 5}[kind]
    turn = rng.uniform(0, 2 * math.pi)
    reach = rng.uniform(0.04, 0.15)
    return [
        (
            reach * math.cos(turn + 2 * math.pi * i / n) + 0.0,
            reach * math.sin(turn + 2 * math.pi * i / n),
            -height,
        )
        for i in range(n)
    ]


def body(name, mass, inertia, position, *more):
    """A free body."""
    return (
        f"&body name = '{name}', mass = {mass!r}, inertia = {words(inertia)},"
        f" position = {words(position)}{''.join(', ' + text for text in more)} /\n"
    )


def ball_surface(name, owner, centre):
    """A ball of a body."""
    return (
        f"&surface name = '{name}', body = '{owner}', shape = 'sphere', radius = {RADIUS},"
        f" centre = {words(centre)}, material = 'w' /\n"
    )


def must_rest(kind, method, mu, e):
    """Whether a scene is to come to rest, and is given the time to: what rolls or falls off does
    not, and methods for which sticking is too stiff need not."""
    return (
        kind in ("table", "stool", "pentagon", "block")
        and mu > 0.15
        and e < 0.7
        and method not in STIFF_WITH
    )


def random_scene(seed):
    """The text of a scene; the same for the same seed."""
    rng = random.Random(seed)
    method = METHODS[seed % len(METHODS)]
    kind = KINDS[seed // len(METHODS) % len(KINDS)]
    t_end = 0.3
    mu = rng.choice((0.0, 0.0, rng.uniform(0.05, 0.4), rng.uniform(0.05, 0.9)))
    if mu > 0 and method in STIFF_WITH:
        # Friction that sticks is stiff.
        method = rng.choice(("cvode_bdf", "auto", method))
    e = rng.choice((0.0, 0.5, 1.0, rng.uniform(0.0, 1.0), rng.uniform(0.0, 0.9)))
    if e > 0.95:
        # What bounces without a loss does so until the end.
        t_end = 0.15
    keys = f"normal = 'rigid', restitution = {e!r}"
    if mu > 0:
        keys += f", friction = 'contensou_exact', friction_coefficient = {mu!r}"
    if must_rest(kind, method, mu, e):
        t_end = 4.0
    text = f"! {kind}, {method}, friction {mu:.3g}, restitution {e:.3g}\n"
    text += "&material name = 'w', young = 1e9, poisson = 0.3 /\n"
    text += "&surface name = 'floor', body = 'ground', shape = 'plane', material = 'w' /\n"
    contacts = ""
    slide = (rng.uniform(-1.5, 1.5), rng.uniform(-1.5, 1.5), 0.0)
    if rng.random() < 0.3:
        slide = (0.0, 0.0, 0.0)
    spin = (0.0, 0.0, rng.choice((0.0, rng.uniform(-8, 8))))
    if kind == "stack":
        n = rng.choice((3, 4))
        under, z = "floor", 0.0
        for i in range(3):
            x, h = rng.uniform(0.06, 0.09) * 0.85**i, 0.02
            angles = [2 * math.pi * k / n + 0.4 for k in range(n)]
            centres = [(x * math.cos(a), x * math.sin(a), -h) for a in angles]
            z += h + RADIUS
            mass = rng.uniform(0.3, 1.5)
            drop = rng.choice((0.0, 0.0, rng.uniform(0, 0.01)))
            z += drop
            move = f"velocity = {words(slide if rng.random() < 0.3 else (0, 0, 0))}"
            text += body(
                f"plate{i}", mass, (2e-3 * mass, 2e-3 * mass, 4e-3 * mass), (0, 0, z), move
            )
            for k, centre in enumerate(centres):
                name = f"foot{i}{k}"
                text += ball_surface(name, f"plate{i}", centre)
                contacts += f"&contact name = 'c{i}{k}', surfaces = '{under}', '{name}', {keys} /\n"
            top = rng.uniform(0.005, 0.02)
            under, z = f"top{i}", z + top
            text += (
                f"&surface name = 'top{i}', body = 'plate{i}', shape = 'plane',"
                f" centre = {words((0, 0, top))}, material = 'w' /\n"
            )
    else:
        shape = rng.choice(("table", "stool", "pentagon")) if kind == "hostile" else kind
        centres = feet(rng, shape)
        low = min(c[2] for c in centres)
        inertia = [rng.uniform(0.005, 0.02) for _ in range(2)]
        inertia.append(rng.uniform(0.8, 1.0) * sum(inertia))
        axis = (rng.gauss(0, 1), rng.gauss(0, 1), 0.3 * rng.gauss(0, 1))
        angle = rng.choice((0.0, 10 ** rng.uniform(-6, -0.7)))
        if kind == "block":
            angle = rng.uniform(0, 3)
        if kind == "hostile":
            # All feet within so little of the floor, flat or as good as flat.
            angle = rng.choice((0.0, 10 ** rng.uniform(-16, -10.5)))
            z = -low + RADIUS + rng.choice((-1, 1, 1)) * 10 ** rng.uniform(-17, -11.5)
            if rng.random() < 0.5:
                z += 10 ** rng.uniform(-17, -10)
            slide = (slide[0], slide[1], rng.choice((0.0, -rng.uniform(0, 0.5))))
        else:
            reach = max(math.hypot(*c) for c in centres)
            lift = reach * math.sin(min(angle, 1.5)) if angle < 1.5 else 2 * reach
            z = -low + RADIUS + lift + rng.choice((1e-3, rng.uniform(1e-4, 0.02)))
        more = (
            f"axis = {words(axis)}, angle = {angle!r}",
            f"velocity = {words(slide)}",
            f"spin = {words(spin)}",
        )
        text += body("body", 1.0, inertia, (0, 0, z), *more)
        for k, centre in enumerate(centres):
            text += ball_surface(f"foot{k}", "body", centre)
            contacts += f"&contact name = 'c{k}', surfaces = 'floor', 'foot{k}', {keys} /\n"
    return (
        text
        + contacts
        + f"&scene gravity = 0, 0, {-GRAVITY}, t_end = {t_end} /\n"
        + f"&integrator method = '{method}', rtol = {rng.choice((1e-6, 1e-8, 1e-10))} /\n"
        + "&output file = 'out.h5', interval = 1e-3 /\n"
    )


def groups(text, name):
    """The groups of this name in a scene, each a dictionary of its keys; numbers as lists."""
    found = []
    for line in text.splitlines():
        if not line.startswith(f"&{name} "):
            continue
        keys = {}
        for key, value in re.findall(
            r"(\w+) = ((?:'[^']*'|[-+.\de]+)(?:, (?!\w+ =)[^,/]+)*)", line
        ):
            if "'" in value:
                keys[key] = re.findall(r"'([^']*)'", value)
            else:
                keys[key] = [float(number) for number in value.split(",")]
        found.append(keys)
    return found


def turned(quaternion, vector):
    """A vector of a body in the inertial frame, at all times; quaternions are (rows, wxyz)."""
    w, u = quaternion[:, :1], quaternion[:, 1:]
    twice = 2 * np.cross(u, vector)
    return vector + w * twice + np.cross(u, twice)


def loads(text, rows):
    """Force and torque about the centre of mass on each body at each row, by what was written."""
    bodies = groups(text, "body")
    number = {body["name"][0]: i for i, body in enumerate(bodies)}
    surfaces = {surface["name"][0]: surface for surface in groups(text, "surface")}
    shape = rows["position"].shape
    force, torque = np.zeros(shape), np.zeros(shape)
    for i, body in enumerate(bodies):
        force[:, i] = body["mass"][0] * np.array(groups(text, "scene")[0]["gravity"])
    for k, contact in enumerate(groups(text, "contact")):
        first, foot = (surfaces[name] for name in contact["surfaces"])
        b = number[foot["body"][0]]
        a = number.get(first["body"][0])
        normal = np.broadcast_to([0.0, 0.0, 1.0], (*shape[:1], 3))
        if first["shape"] == ["sphere"]:
            # Both are balls about the centres of mass.
            normal = rows["position"][:, b] - rows["position"][:, a]
            normal /= np.linalg.norm(normal, axis=1)[:, None]
        elif a is not None:
            normal = turned(rows["quaternion"][:, a], normal)
        arm = turned(rows["quaternion"][:, b], np.broadcast_to(foot["centre"], normal.shape))
        arm = arm - RADIUS * normal
        push = rows["normal_force"][:, k, None] * normal + rows["friction_force"][:, k]
        twist = rows["friction_torque"][:, k, None] * normal
        force[:, b] += push
        torque[:, b] += np.cross(arm, push) + twist
        if a is not None:
            arm = arm + rows["position"][:, b] - rows["position"][:, a]
            force[:, a] -= push
            torque[:, a] -= np.cross(arm, push) + twist
    return force, torque


# Formula of Newton and Cotes with nine places, that with five, twice, and Simpson's, four times:
# over the interval.
NINE = np.array([989, 5888, -928, 10496, -4540, 10496, -928, 5888, 989]) / 28350
FIVE_TWICE = np.array([7, 32, 12, 32, 14, 32, 12, 32, 7]) / 180
SIMPSON = np.array([1, 4, 2, 4, 2, 4, 2, 4, 1]) / 24
TRAPEZOIDS = np.array([1, 2, 2, 2, 2, 2, 2, 2, 1]) / 16
# By one jump of a load between two rows the first errs at most 8.4 times what it differs by from
# the other two together; where several contacts stop one after the other by three times that.
FORMULAE = 25
# Where a load changes ever faster towards an end, as friction does where a foot that slides is
# about to turn, these formulae, which weigh the ends little, differ by less: there the trapezoids
# tell.
AT_ENDS = 4


def imbalances(text, rows, events):
    """Changes of the momenta that the loads in the rows do not account for, over eight intervals.

    Of linear momentum over the weight and the time, of angular momentum about the centre of mass
    over the weight, the largest arm and the time, less what the tolerance of the velocities
    explains; where all that touches slides, and where something sticks: there friction follows from
    velocities far below the tolerance. Only where nothing happens and the integral of the loads is
    known: two formulae differ by less than the hundredth of what is admitted, or nothing stops and
    the imbalance is more than what four formulae leave open.
    """
    rtol = float(re.search(r"rtol = ([-\d.e]+)", text)[1])
    slip = np.linalg.norm(rows["slip_velocity"], axis=2) + RADIUS * np.abs(rows["spin"])
    stuck = (rows["normal_force"] > 0) & (slip < 1e-5)
    if "friction_coefficient" not in text:
        stuck[:] = False
    force, torque = loads(text, rows)
    time = rows["time"]
    steps = np.arange(0, len(time) - 8, 4)
    span = time[steps + 8] - time[steps]
    quiet = np.ones(len(steps), bool)
    for moment in events:
        quiet &= (moment < time[steps]) | (moment > time[steps + 8])
    index = steps[:, None] + np.arange(9)
    # Friction may peak within an interval in which sliding ends, or all but ends.
    steady = quiet & (stuck[index] == stuck[steps, None]).all(axis=(1, 2))
    slow, fast = (f(slip[index[:, :-1]], slip[index[:, 1:]]) for f in (np.minimum, np.maximum))
    steady &= ((fast < 1e-4) | (fast < 10 * slow)).all(axis=(1, 2))
    sticks = stuck[index].any(axis=(1, 2))
    worst = np.zeros((2, 2))
    arm = max(math.hypot(*s["centre"]) for s in groups(text, "surface") if "centre" in s) + RADIUS
    for i, body in enumerate(groups(text, "body")):
        weight = GRAVITY * body["mass"][0]
        turn = np.stack(
            [
                turned(rows["quaternion"][:, i], np.broadcast_to(axis, force[:, i].shape))
                for axis in np.eye(3)
            ],
            axis=1,
        )
        local = np.einsum("tij,tj->ti", turn, rows["angular_velocity"][:, i])
        spin = np.einsum("tij,ti->tj", turn, local * body["inertia"])
        balances = (
            (force[:, i], body["mass"][0] * rows["velocity"][:, i], weight),
            (torque[:, i], spin, weight * arm),
        )
        # Where two formulas agree for all loads of a body, its mean loads are known; elsewhere they
        # are to what the formulas differ by, unless something stops.
        known = quiet.copy()
        for load, _, scale in balances:
            mean = np.einsum("k,wkx->wx", NINE, load[index])
            other = np.einsum("k,wkx->wx", FIVE_TWICE, load[index])
            known &= np.abs(mean - other).max(axis=1) < 1e-8 * scale
        for k, (load, momentum, scale) in enumerate(balances):
            explained = 10 * rtol * max(np.abs(momentum).max(), scale / GRAVITY) / span
            mean = np.einsum("k,wkx->wx", NINE, load[index])
            unknown = sum(
                factor * np.linalg.norm(mean - np.einsum("k,wkx->wx", formula, load[index]), axis=1)
                for formula, factor in (
                    (FIVE_TWICE, FORMULAE),
                    (SIMPSON, FORMULAE),
                    (TRAPEZOIDS, AT_ENDS),
                )
            )
            off = (momentum[steps + 8] - momentum[steps]) / span[:, None] - mean
            for judged, gap in (
                (known, np.abs(off).max(axis=1) - explained),
                (steady, np.linalg.norm(off, axis=1) - explained - unknown),
            ):
                worst[k, 0] = max(worst[k, 0], (gap / scale)[judged & ~sticks].max(initial=0.0))
                worst[k, 1] = max(worst[k, 1], (gap / scale)[judged & sticks].max(initial=0.0))
    return worst


LIMITS = {
    "overlap over radius": 1e-6,
    "pull over weight": 1e-6,
    "friction power over weight [m/s]": 1e-6,
    "growth of energy": 1e-6,
    "balance": 1e-4,
    "momentum over weight": 1e-6,
    "angular momentum over weight and arm": 1e-6,
    "momentum over weight where friction sticks": 1e-6,
    "angular momentum over weight and arm where friction sticks": 1e-6,
    "speed at the end [m/s]": 1e-3,
    "spin at the end [rad/s]": 1e-2,
    "momentum of all [kg m/s]": 1e-9,
    "angular momentum of all [kg m2/s]": 1e-9,
}


def judge(path, text=""):
    """What is wrong with an output, and each quantity that must not exceed a limit; the text of the
    scene, if it is one of those made here, tells how the momenta must change."""
    with h5py.File(path) as file:
        rows = {name: item[()] for name, item in file["trajectory"].items() if item.ndim}
        events = file["events/time"][()]
    weight = GRAVITY
    if not all(np.isfinite(item).all() for item in rows.values() if item.dtype == np.float64):
        return ["numbers that are not finite"], {}
    kinetic, potential = rows["energy_kinetic"], rows["energy_potential"]
    energy = kinetic + potential
    size = max(kinetic.max(), np.ptp(potential), 1e-3 * weight * RADIUS)
    power = np.zeros(1)
    if "friction_force" in rows:
        power = np.einsum("tcx,tcx->tc", rows["friction_force"], rows["slip_velocity"])
        power = power + rows["friction_torque"] * rows["spin"]
    found = {
        "overlap over radius": -rows["gap"].min() / RADIUS,
        "pull over weight": -rows["normal_force"].min() / weight,
        "friction power over weight [m/s]": power.max() / weight,
        "growth of energy": np.diff(energy).max() / size,
        "balance": np.abs(rows["energy_error"]).max() / size,
    }
    if text:
        linear, angular = imbalances(text, rows, events)
        for moved, where in enumerate(("", " where friction sticks")):
            found["momentum over weight" + where] = linear[moved]
            found["angular momentum over weight and arm" + where] = angular[moved]
    # What still rocks or bounces loses its energy there.
    if rows["time"][-1] > 1 and (events < rows["time"][-1] - 0.5).all():
        found["speed at the end [m/s]"] = np.abs(rows["velocity"][-1]).max()
        found["spin at the end [rad/s]"] = np.abs(rows["angular_velocity"][-1]).max()
    if text and "'ground'" not in text:
        mass = np.array([body["mass"][0] for body in groups(text, "body")])
        inertia = np.array([body["inertia"][0] for body in groups(text, "body")])
        momentum = np.einsum("b,tbx->tx", mass, rows["velocity"])
        turning = np.einsum("b,tbx->tx", inertia, rows["angular_velocity"])
        turning += np.einsum("b,tbx->tx", mass, np.cross(rows["position"], rows["velocity"]))
        found["momentum of all [kg m/s]"] = np.abs(momentum - momentum[0]).max()
        found["angular momentum of all [kg m2/s]"] = np.abs(turning - turning[0]).max()
    wrong = [f"{name} {value:.2g}" for name, value in found.items() if value > LIMITS[name]]
    return wrong, found


def simulate(executable, place, text, patience):
    """Run a scene in a folder, with so many seconds of CPU."""
    (place / "scene.nml").write_text(text)
    limit = (patience, patience + 5)
    return subprocess.run(
        [executable, "run", "scene.nml", "-q", "--force"],
        cwd=place,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=False,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, limit),
    )


def sampled_otherwise(text):
    """A scene with rows at other moments, if rows may follow a rhythm of its steps, else nothing.

    Steps at the limit of stability let what sticks chatter, below the tolerance, at the pace of the
    steps. Rows that keep pace with that show the same phase again and again, and the mean of the
    loads is not theirs; what the loads do not account for shows in any rows.
    """
    if not any(name in text.splitlines()[0] for name in STIFF_WITH):
        return ""
    return re.sub(r"interval = ([-\d.e]+)", lambda m: f"interval = {0.93 * float(m[1])!r}", text)


def attempt(executable, folder, text, patience=PATIENCE):
    """Simulate one scene: how it ended, what is wrong with that, and its figures.

    What needs more seconds of CPU than the patience is slow.
    """
    place = Path(tempfile.mkdtemp(dir=folder))
    done = simulate(executable, place, text, patience)
    figures = {}
    if done.returncode == 0:
        wrong, figures = judge(place / "out.h5", text)
        other = sampled_otherwise(text)
        if other and wrong and all("where friction sticks" in name for name in wrong):
            again = simulate(executable, place, other, patience)
            if again.returncode == 0:
                wrong, figures = judge(place / "out.h5", other)
        end = "0"
    elif done.returncode == 1 and "error: " in done.stderr:
        lines = [line.strip() for line in done.stderr[done.stderr.index("error: ") :].splitlines()]
        end = next(
            (line for line in lines if re.search(r"surfaces '.*' and '.*':", line)), lines[0]
        )
        end = "1 " + re.sub(r"\d[-+.\deE]*", "#", end.split(": ", 2)[-1])
        wrong = []
    else:
        end, wrong = f"status {done.returncode}", [done.stderr[-300:] or "no message"]
        # The limit of CPU time interrupts a run as other signals do.
        if done.returncode in (75, -signal.SIGKILL):
            end, wrong = "slow", []
    if end == "0" and not wrong:
        shutil.rmtree(place)
    return end, wrong, figures


def campaign(executable, folder, scene, seeds, jobs=2):
    """Try the scenes of all seeds: the ends, messages, what is wrong, and the worst figures."""
    texts = [scene(seed) for seed in seeds]
    with ThreadPoolExecutor(jobs) as pool:
        all_ends = list(pool.map(lambda text: attempt(executable, folder, text), texts))
    ends, messages, wrong, worst = Counter(), [], [], {}
    for seed, text, (end, faults, figures) in zip(seeds, texts, all_ends, strict=True):
        title = text.splitlines()[0][2:]
        ends[end] += 1
        if faults:
            wrong.append(f"scene {seed} ({title}): {', '.join(faults)}")
        for name, value in figures.items():
            if value > worst.get(name, (-math.inf, 0))[0]:
                worst[name] = (value, seed)
        stiff = any(name in title for name in STIFF_WITH) and "friction 0," not in title
        if end != "0" and not (stiff and (end == "slow" or "steps have shrunk" in end)):
            messages.append(f"scene {seed} ({title}): {end}")
    return ends, messages, wrong, worst


def hostile_scene(seed):
    """Feet that touch at once within rounding, all at the beginning or all in one step."""
    rng = random.Random(f"hostile {seed}")
    method = METHODS[seed % len(METHODS)]
    kind = ("within rounding", "symmetric", "in one step")[seed // len(METHODS) % 3]
    mu = rng.choice((0.0, 0.0, rng.uniform(0.05, 0.6)))
    e = rng.choice((0.0, 0.5, 1.0, rng.uniform(0.0, 0.9)))
    shape = rng.choice(("table", "table", "stool", "pentagon", "dumb-bell", "block"))
    centres = feet(rng, shape)
    if kind == "symmetric":
        centres = [(i * 0.125, j * 0.125, -0.0625) for i in (-1, 1) for j in (-1, 1)]
        if rng.random() < 0.5:
            centres += [(a, b, -c) for a, b, c in centres]
    low = min(c[2] for c in centres)
    height = RADIUS - low
    velocity = [rng.choice((0.0, rng.uniform(-1, 1))) for _ in range(2)] + [0.0]
    velocity[2] = rng.choice((0.0, 0.0, -rng.uniform(0, 1), 10 ** rng.uniform(-17, -6)))
    if kind == "within rounding":
        centres = [
            (a, b, c + rng.choice((-1, 1)) * 10 ** rng.uniform(-17, -11.3)) for a, b, c in centres
        ]
        height += rng.choice((0.0, 10 ** rng.uniform(-17, -10)))
    elif kind == "in one step":
        spread = 10 ** rng.uniform(-15, -6)
        centres = [(a, b, c + rng.uniform(-1, 1) * spread) for a, b, c in centres]
        height += spread + 10 ** rng.uniform(-9, -3)
        velocity[2] = -(10 ** rng.uniform(-3, 0.5))
    spin = (0.0, 0.0, rng.choice((0.0, rng.uniform(-8, 8))))
    keys = f"normal = 'rigid', restitution = {e!r}"
    if mu > 0:
        keys += f", friction = 'contensou_exact', friction_coefficient = {mu!r}"
    text = f"! {kind}, {shape}, {method}, friction {mu:.3g}, restitution {e:.3g}\n"
    text += "&material name = 'w', young = 1e9, poisson = 0.3 /\n"
    text += "&surface name = 'floor', body = 'ground', shape = 'plane', material = 'w' /\n"
    more = (f"velocity = {words(velocity)}", f"spin = {words(spin)}")
    text += body("body", 1.0, (0.01, rng.choice((0.01, 0.012)), 0.015), (0, 0, height), *more)
    for k, centre in enumerate(centres):
        text += ball_surface(f"foot{k}", "body", centre)
        text += f"&contact name = 'c{k}', surfaces = 'floor', 'foot{k}', {keys} /\n"
    impacts = rng.choice(("sequential", "sequential", "simultaneous"))
    return (
        text
        + f"&scene gravity = 0, 0, {-GRAVITY}, t_end = 0.05, impacts = '{impacts}' /\n"
        + f"&integrator method = '{method}', rtol = {rng.choice((1e-6, 1e-8, 1e-10))} /\n"
        + "&output file = 'out.h5', interval = 5e-4 /\n"
    )


def impacts_scene(seed):
    """Balls in a packing that touch each other, hit by others, in free space."""
    rng = random.Random(f"impacts {seed}")
    method = METHODS[seed % len(METHODS)]
    mu = rng.choice((0.0, rng.uniform(0.05, 0.8)))
    e = rng.choice((0.0, 0.5, 1.0, rng.uniform(0.0, 1.0)))
    impacts = ("sequential", "simultaneous")[seed // len(METHODS) % 2]
    kind = rng.choice(("row", "triangle", "square", "tetrahedron"))
    step, root = 2 * RADIUS, math.sqrt(3)
    places = {
        "row": [(k * step, 0, 0) for k in range(rng.randint(3, 6))],
        "triangle": [(0, 0, 0), (step, 0, 0), (step / 2, step * root / 2, 0)],
        "square": [(i * step, j * step, 0) for i in (0, 1) for j in (0, 1)],
        "tetrahedron": [
            (0, 0, 0),
            (step, 0, 0),
            (step / 2, step * root / 2, 0),
            (step / 2, step * root / 6, step * math.sqrt(2 / 3)),
        ],
    }[kind]
    centre = np.mean(places, axis=0)
    balls = [(place, (0.0, 0.0, 0.0)) for place in places]
    for _ in range(rng.randint(1, 2)):
        # From a side, at one of the balls, with and without an offset.
        way = np.array([rng.gauss(0, 1) for _ in range(3)])
        if rng.random() < 0.5:
            way = np.array([1.0, 0.0, 0.0])
        way /= np.linalg.norm(way)
        start = centre - way * (len(places) * step + rng.uniform(1, 2) * step)
        start += np.array([rng.choice((0.0, rng.uniform(-0.3, 0.3))) * step for _ in range(3)])
        if all(math.dist(start, place) > 1.01 * step for place, _ in balls):
            balls.append((tuple(start), tuple(way * rng.uniform(0.5, 2))))
    text = f"! balls in a {kind}, {method}, {impacts}, friction {mu:.3g}, restitution {e:.3g}\n"
    text += "&material name = 'w', young = 1e9, poisson = 0.3 /\n"
    keys = f"normal = 'rigid', restitution = {e!r}"
    if mu > 0:
        keys += f", friction = 'contensou_exact', friction_coefficient = {mu!r}"
    contacts = ""
    for k, (place, velocity) in enumerate(balls):
        mass = rng.choice((0.03, rng.uniform(0.01, 0.1)))
        spin = (rng.uniform(-20, 20), rng.uniform(-20, 20), rng.uniform(-20, 20))
        move = (f"velocity = {words(velocity)}", f"spin = {words(spin if mu > 0 else (0, 0, 0))}")
        text += body(f"ball{k}", mass, [0.4 * mass * RADIUS**2] * 3, place, *move)
        text += ball_surface(f"skin{k}", f"ball{k}", (0, 0, 0))
        for i in range(k):
            contacts += f"&contact name = 'c{i}{k}', surfaces = 'skin{i}', 'skin{k}', {keys} /\n"
    return (
        text
        + contacts
        + f"&scene gravity = 0, 0, 0, t_end = 0.3, impacts = '{impacts}' /\n"
        + f"&integrator method = '{method}', rtol = {rng.choice((1e-6, 1e-8, 1e-10))} /\n"
        + "&output file = 'out.h5', interval = 1e-3 /\n"
    )


SCENES = {"random": random_scene, "hostile": hostile_scene, "impacts": impacts_scene}
