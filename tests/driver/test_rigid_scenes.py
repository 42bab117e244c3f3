"""Random scenes of rigid contacts that act together, and what must hold in each row of each.

Tables, stools, dumb-bells, blocks of eight balls and stacks of three plates fall, slide, rock and
come to rest, with and without friction and restitution, by every method; some begin with all their
feet within 1e-17 to 1e-10 m of the floor. A scene must end well or with a message, and few may end
with one. CONTENSOU_RIGID_SCENES says how many are tried, CONTENSOU_RIGID_SEED with which number
they begin; `python test_rigid_scenes.py EXECUTABLE FIRST NUMBER` tries them and prints what it
found.
"""

from __future__ import annotations

import math
import os
import random
import re
import resource
import signal
import subprocess
import sys
import tempfile
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import h5py
import numpy as np
import pytest

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


def judge(path):
    """What is wrong with an output: each quantity against what it must not exceed."""
    with h5py.File(path) as file:
        rows = {name: item[()] for name, item in file["trajectory"].items() if item.ndim}
    weight = GRAVITY
    wrong = []
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
    limits = (1e-6, 1e-6, 1e-6, 1e-6, 1e-4)
    for (name, value), limit in zip(found.items(), limits, strict=True):
        if value > limit:
            wrong.append(f"{name} {value:.2g}")
    return wrong, found


def attempt(executable, folder, seed):
    """Simulate one scene: how it ended, what is wrong with that, and its figures."""
    place = Path(folder) / str(seed)
    place.mkdir()
    (place / "scene.nml").write_text(random_scene(seed))
    limit = (PATIENCE, PATIENCE + 5)
    done = subprocess.run(
        [executable, "run", "scene.nml", "-q"],
        cwd=place,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=False,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, limit),
    )
    figures = {}
    if done.returncode == 0:
        wrong, figures = judge(place / "out.h5")
        end = "0"
    elif done.returncode == 1 and "error: " in done.stderr:
        lines = [line.strip() for line in done.stderr.splitlines()]
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
        for file in place.iterdir():
            file.unlink()
        place.rmdir()
    return end, wrong, figures


def campaign(executable, folder, seeds):
    """Try all; the ends, and what is wrong."""
    with ThreadPoolExecutor(2) as pool:
        all_ends = list(pool.map(lambda seed: attempt(executable, folder, seed), seeds))
    ends = Counter(end for end, _, _ in all_ends)
    wrong = [
        f"scene {seed} ({random_scene(seed).splitlines()[0][2:]}): {', '.join(text)}"
        for seed, (_, text, _) in zip(seeds, all_ends, strict=True)
        if text
    ]
    worst = {}
    for seed, (_, _, figures) in zip(seeds, all_ends, strict=True):
        for name, value in figures.items():
            if value > worst.get(name, (-math.inf, 0))[0]:
                worst[name] = (value, seed)
    messages = []
    for seed, (end, _, _) in zip(seeds, all_ends, strict=True):
        title = random_scene(seed).splitlines()[0][2:]
        stiff = any(name in title for name in STIFF_WITH) and "friction 0," not in title
        if end != "0" and not (stiff and (end == "slow" or "steps have shrunk" in end)):
            messages.append(f"scene {seed} ({title}): {end}")
    return ends, messages, wrong, worst


def test_rigid_contacts_that_act_together_hold(executable, tmp_path, build_kind):
    usual = "112" if build_kind == "release" else "28"
    number = int(os.environ.get("CONTENSOU_RIGID_SCENES", usual))
    first = int(os.environ.get("CONTENSOU_RIGID_SEED", "0"))
    ends, messages, wrong, worst = campaign(executable, tmp_path, range(first, first + number))
    print(ends, *messages, worst, sep="\n")
    if wrong:
        pytest.fail(f"{len(wrong)} of {number}, in {tmp_path}\n" + "\n".join(wrong[:20]))
    assert len(messages) <= max(1, 0.01 * number), ends


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        folder = os.environ.get("CONTENSOU_RIGID_FOLDER", folder)
        first, number = int(sys.argv[2]), int(sys.argv[3])
        ends, messages, wrong, worst = campaign(
            os.path.abspath(sys.argv[1]), folder, range(first, first + number)
        )
        for end, times in ends.most_common():
            print(f"{times:6d}  {end}")
        print("\n".join(messages[:100] + wrong[:100]))
        for name, (value, seed) in worst.items():
            print(f"largest {name}: {value:.2g} (scene {seed})")
