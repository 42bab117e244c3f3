"""Rigid scenes and compliant ones, from the last impact on.

Bodies on three to five feet (`feet`), dumb-bells (`dumb-bell`), blocks of eight balls (`block`) and
stacks of three plates (`stack`) fall, slide, turn, roll and tumble. The state of the rigid scene
after its last impact, lowered by the overlaps that its forces have, is the beginning of the same
with Hertz's force, and both go on for a tenth of a second.

After impacts in turn a compliant scene is another one: which impact comes first, and what it gives
back, follows from the compliance. So nothing before the last impact is compared.
"""

from __future__ import annotations

import math
import random
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import h5py
import numpy as np
from rigid_scenes import GRAVITY, RADIUS, ball_surface, feet, turned, words

KINDS = ("feet", "dumb-bell", "block", "stack")
# Rows, and milliseconds, of what is compared.
ROWS = 100


class State(NamedTuple):
    """A body: its pose, its velocity, its angular velocity in its own frame."""

    position: np.ndarray
    quaternion: np.ndarray
    velocity: np.ndarray
    spin: np.ndarray


@dataclass
class Scene:
    """Bodies on feet that are balls, each foot on the floor (None) or on the top of a body."""

    kind: str
    masses: list
    inertias: list
    states: list
    feet: list
    tops: list
    keys: str
    t_end: float

    def text(self, young, states, keys, t_end):
        """The scene at some states, with a modulus of elasticity and the keys of its contacts."""
        text = f"&material name = 'w', young = {young!r}, poisson = 0.3 /\n"
        text += "&surface name = 'floor', body = 'ground', shape = 'plane', material = 'w' /\n"
        for i, (mass, inertia, state) in enumerate(
            zip(self.masses, self.inertias, states, strict=True)
        ):
            text += (
                f"&body name = 'body{i}', mass = {mass!r}, inertia = {words(inertia)},"
                f" position = {words(state.position)}, quaternion = {words(state.quaternion)},"
                f" velocity = {words(state.velocity)}, spin = {words(state.spin)} /\n"
            )
        for i, height in enumerate(self.tops):
            text += (
                f"&surface name = 'top{i}', body = 'body{i}', shape = 'plane',"
                f" centre = 0, 0, {height!r}, material = 'w' /\n"
            )
        for k, (owner, centre, under) in enumerate(self.feet):
            text += ball_surface(f"foot{k}", f"body{owner}", centre)
            below = "floor" if under is None else f"top{under}"
            text += f"&contact name = 'c{k}', surfaces = '{below}', 'foot{k}'{keys} /\n"
        return (
            text
            + f"&scene gravity = 0, 0, {-GRAVITY}, t_end = {t_end!r} /\n"
            + "&integrator method = 'cvode_bdf', rtol = 1e-9 /\n"
            + "&output file = 'out.h5', interval = 1e-3 /\n"
        )


def settled_scene(seed, kind="feet"):
    """A body or a stack that comes to stand on all its feet, slides and turns."""
    rng = random.Random(f"settled {seed}" if kind == "feet" else f"settled {kind} {seed}")
    if kind == "stack":
        return stack(rng)
    centres = feet(rng, rng.choice(("table", "table", "stool", "pentagon")))
    if kind != "feet":
        centres = feet(rng, kind)
    mu = rng.choice((0.0, rng.uniform(0.05, 0.5)))
    keys = f", restitution = {rng.uniform(0.0, 0.4)!r}"
    if mu > 0:
        keys += f", friction = 'contensou_exact', friction_coefficient = {mu!r}"
    slide = (rng.uniform(-1.5, 1.5), rng.uniform(-1.5, 1.5), 0.0)
    inertia = [rng.uniform(0.005, 0.02) for _ in range(2)]
    inertia.append(0.9 * sum(inertia))
    height = RADIUS - min(centre[2] for centre in centres) + 1e-4
    spin = [0.0, 0.0, rng.uniform(-8, 8)]
    turn, t_end = (1.0, 0.0, 0.0, 0.0), 0.6
    if kind == "dumb-bell":
        # It rolls about its axis, too, and drops with one foot first.
        spin[0] = rng.choice((0.0, rng.uniform(-6, 6)))
        half = rng.choice((0.0, rng.uniform(-0.02, 0.02)))
        turn = (math.cos(half), 0.0, math.sin(half), 0.0)
        height += 0.3 * math.sin(abs(half))
    if kind == "block" and rng.random() < 0.5:
        # It tumbles onto any of its sides.
        axis = np.array([rng.gauss(0, 1) for _ in range(3)])
        half = rng.uniform(0, 1.5)
        turn = (math.cos(half), *(math.sin(half) * axis / np.linalg.norm(axis)))
        height, t_end = max(math.hypot(*centre) for centre in centres) + 2 * RADIUS, 3.0
        slide = tuple(0.3 * part for part in slide)
    state = State((0.0, 0.0, height), turn, slide, spin)
    return Scene(kind, [1.0], [inertia], [state], [(0, c, None) for c in centres], [], keys, t_end)


def stack(rng):
    """Three plates on three or four feet each, of which some slide, but not off the others."""
    mu = rng.choice((0.0, rng.uniform(0.05, 0.5)))
    keys = f", restitution = {rng.uniform(0.0, 0.4)!r}"
    if mu > 0:
        keys += f", friction = 'contensou_exact', friction_coefficient = {mu!r}"
    # The way that a plate slides is 20 mm at most.
    fastest = math.sqrt(2 * mu * GRAVITY * 0.02) if mu > 0 else 0.05
    scene = Scene("stack", [], [], [], [], [], keys, 0.6)
    number, under, z = rng.choice((3, 4)), None, 0.0
    for i in range(3):
        reach, low = rng.uniform(0.06, 0.09) * 0.85**i, 0.02
        z += low + RADIUS + rng.choice((0.0, rng.uniform(0, 0.003)))
        mass = rng.uniform(0.3, 1.5)
        way = rng.uniform(0, 2 * math.pi)
        speed = rng.choice((0.0, rng.uniform(0, fastest)))
        slide = (speed * math.cos(way), speed * math.sin(way), 0.0)
        spin = (0.0, 0.0, rng.choice((0.0, rng.uniform(-1, 1))))
        scene.masses.append(mass)
        scene.inertias.append((2e-3 * mass, 2e-3 * mass, 4e-3 * mass))
        scene.states.append(State((0.0, 0.0, z), (1.0, 0.0, 0.0, 0.0), slide, spin))
        for k in range(number):
            angle = 2 * math.pi * k / number + 0.4
            centre = (reach * math.cos(angle), reach * math.sin(angle), -low)
            scene.feet.append((i, centre, under))
        scene.tops.append(rng.uniform(0.005, 0.02))
        z, under = z + scene.tops[-1], i
    return scene


def simulated(executable, folder, text):
    """The rows of a scene and the times of its events."""
    (Path(folder) / "scene.nml").write_text(text)
    command = [executable, "run", "scene.nml", "-q", "--force"]
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
    with h5py.File(Path(folder) / "out.h5") as file:
        rows = {name: item[()] for name, item in file["trajectory"].items() if item.ndim}
        return rows, file["events/time"][()]


def rotated(quaternion, vector):
    """A vector of a body in the inertial frame, at one time."""
    return turned(np.array(quaternion)[None], np.array(vector, float)[None])[0]


def lowered(scene, states, overlap, loaded):
    """The states, displaced and turned as little as the feet sink in by their overlaps."""
    n = len(states)
    rows, size = np.zeros((len(scene.feet), 6 * n)), 0.1
    for k, (owner, centre, under) in enumerate(scene.feet):
        normal = np.array([0.0, 0.0, 1.0])
        if under is not None:
            normal = rotated(states[under].quaternion, normal)
        arm = rotated(states[owner].quaternion, centre) - RADIUS * normal
        point = states[owner].position + arm
        rows[k, 6 * owner : 6 * owner + 6] = *normal, *(np.cross(arm, normal) / size)
        if under is not None:
            arm = point - states[under].position
            rows[k, 6 * under : 6 * under + 6] = *(-normal), *(-np.cross(arm, normal) / size)
    change = np.linalg.lstsq(rows[loaded], -overlap[loaded], rcond=None)[0].reshape(n, 2, 3)
    found = []
    for state, (shift, turn) in zip(states, change, strict=True):
        half = turn / (2 * size)
        w, u = state.quaternion[0], state.quaternion[1:]
        quaternion = state.quaternion + np.array([-half @ u, *(w * half + np.cross(half, u))])
        quaternion /= np.linalg.norm(quaternion)
        found.append(state._replace(position=state.position + shift, quaternion=quaternion))
    return found


def stands(scene, forces):
    """Whether all bodies stand, at all times, on three feet each, a dumb-bell on two."""
    owners = np.array([owner for owner, _, _ in scene.feet])
    least = 2 if scene.kind == "dumb-bell" else 3
    loaded = [(forces[:, owners == i] > 0).sum(axis=1) for i in range(len(scene.masses))]
    return min(one.min() for one in loaded) >= least


def places(scene, rows):
    """Where the centres of the feet are, and how fast they move."""
    where, speed = [], []
    for owner, centre, _ in scene.feet:
        quaternion = rows["quaternion"][:, owner]
        arm = turned(quaternion, np.broadcast_to(centre, (len(quaternion), 3)))
        where.append(rows["position"][:, owner] + arm)
        speed.append(rows["velocity"][:, owner] + np.cross(rows["angular_velocity"][:, owner], arm))
    return np.stack(where, axis=1), np.stack(speed, axis=1)


class Apart(NamedTuple):
    """How far a rigid scene and a compliant one are apart.

    The overlap is the largest one, of a stack the sum of those of its plates [m]; the centres are
    those of mass, at the end [m], the feet their centres, at all times [m]; velocities [m/s] and
    forces over the weight at the end. The turning is the largest angular velocity [rad/s].
    """

    overlap: float
    turning: float
    centres: float
    feet: float
    velocities: float
    feet_velocities: float
    forces: float


def against_hertz(executable, folder, seed, kind="feet", youngs=(1e9, 8e9), damping=100.0):
    """How far a rigid scene and compliant ones, for each modulus, are apart 0.1 s after the last
    impact; None if there is no time for that or bodies stand on too few feet."""
    scene = settled_scene(seed, kind)
    rigid = scene.text(1e9, scene.states, ", normal = 'rigid'" + scene.keys, scene.t_end)
    rows, events = simulated(executable, folder, rigid)
    first = int(np.searchsorted(rows["time"], events.max(initial=0.0))) + 1
    if first + ROWS >= len(rows["time"]):
        return None
    force = np.maximum(rows["normal_force"][first], 0)
    states = []
    for i in range(len(scene.masses)):
        quaternion = rows["quaternion"][first, i]
        spin = rotated(quaternion * [1, -1, -1, -1], rows["angular_velocity"][first, i])
        states.append(
            State(rows["position"][first, i], quaternion, rows["velocity"][first, i], spin)
        )
    # Gaps of closed contacts are zero to errors of the integration, at a beginning to rounding.
    gap = rows["gap"][first]
    if kind != "feet":
        states = lowered(scene, states, gap, np.abs(gap) < 1e-6 * RADIUS)
    soft = scene.keys[scene.keys.find(", friction") :] if "friction" in scene.keys else ""
    soft += f", damping = 'hunt_crossley', damping_coefficient = {damping!r}"
    weight = sum(scene.masses) * GRAVITY
    owners = np.array([owner for owner, _, _ in scene.feet])
    rows = {name: item[first : first + ROWS + 1] for name, item in rows.items()}
    found = []
    for young in youngs:
        if kind != "feet":
            # What rolls and pivots feels the size of the spots, and with it the material: the rigid
            # scene goes on with the same. What slides does not.
            text = scene.text(young, states, ", normal = 'rigid'" + scene.keys, ROWS * 1e-3)
            rows, _ = simulated(executable, folder, text)
        if not stands(scene, rows["normal_force"]):
            return None
        stiffness = 4 / 3 * young / (2 * (1 - 0.3**2)) * math.sqrt(RADIUS)
        overlap = (force / stiffness) ** (2 / 3)
        begin = lowered(scene, states, overlap, force > 1e-3 * force.max())
        other, _ = simulated(executable, folder, scene.text(young, begin, soft, ROWS * 1e-3))
        where, speed = places(scene, rows)
        place, rate = places(scene, other)
        found.append(
            Apart(
                sum(overlap[owners == i].max() for i in range(len(states))),
                np.linalg.norm(rows["angular_velocity"], axis=2).max(),
                np.linalg.norm(other["position"][-1] - rows["position"][-1], axis=1).max(),
                np.linalg.norm(place - where, axis=2).max(),
                np.linalg.norm(other["velocity"][-1] - rows["velocity"][-1], axis=1).max(),
                np.linalg.norm(rate[-1] - speed[-1], axis=1).max(),
                np.abs(other["normal_force"][-1] - rows["normal_force"][-1]).max() / weight,
            )
        )
    return found


def beyond_compliance(found):
    """What the overlaps do not account for in a comparison with compliant scenes, softer first."""
    wrong = []
    for one in found:
        # Centres and feet lie lower by the overlaps; turning and sliding differ by their share of
        # the radius. Velocities follow within the tenth of a second, those of feet also from the
        # other place at which they turn.
        slow, turned_away = 5 * one.overlap + 1e-8, 2 * one.turning * one.overlap
        for name, value, limit, unit in (
            ("centres", one.centres, 3 * one.overlap, "m"),
            ("feet", one.feet, 3 * one.overlap, "m"),
            ("velocities", one.velocities, slow, "m/s"),
            ("velocities of feet", one.feet_velocities, slow + turned_away, "m/s"),
            ("forces", one.forces, 4 * one.overlap / RADIUS + 1e-6, "of the weight"),
        ):
            if value > limit:
                wrong.append(f"{name} {value:.2g} {unit}, overlap {one.overlap:.2g} m")
    # Eight times as stiff: a quarter of the overlap.
    return wrong + not_less(found, ("centres", "feet"), 1e-9)


def not_less(found, names, least):
    """What is not half as much, or less than a least amount, where the material is stiffer."""
    soft, stiff = found
    return [
        f"{name} {getattr(soft, name):.2g} and stiffer {getattr(stiff, name):.2g}"
        for name in names
        if getattr(stiff, name) > getattr(soft, name) / 2 + least
    ]
