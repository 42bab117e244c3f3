"""Surfaces that can touch in several places, drawn at random: every place is felt.

    python tests/campaigns/spots.py [FIRST] [NUMBER] [FOLDER]

draws the scenes FIRST (0) to FIRST + NUMBER (200), runs them in FOLDER (a temporary one) and prints
what came of them by kind. A body drops onto or into a surface at rest. Dense sampling of its
surface, which knows nothing of the program (tests/driver/places.py), tells where the two are
closest. A scene is wrong if a place that overlaps has no spot or a spot is elsewhere, if touches
and lift-offs do not tell what overlaps, if the energy does not close or grows, if the momentum does
not change as weight and forces say, or if it fails without saying of which contact and why. Exit
status 1 if one is wrong. CONTENSOU names the executable.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

import h5py
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "driver"))
from places import (
    Ellipsoid,
    Torus,
    frame,
    places,
    to_cone,
    to_cylinder,
    to_ellipsoid,
    to_paraboloid,
    to_sphere,
    to_torus,
)

METHODS = ("explicit8", "cvode_bdf", "cvode_adams", "auto")

# What may be missing of a gap, over the smallest radius; of the energy that moved; and of the
# largest force, from differences of the velocity.
APART = 1e-6
LOST = 1e-4
FORCE = 0.05

SCENE = """\
&scene gravity = 0, 0, -9.81, t_end = {t_end} /
&material name = 'm', young = {young[0]}, poisson = {poisson[0]} /
&material name = 'g', young = {young[1]}, poisson = {poisson[1]} /
&body name = 'b', mass = {mass}, inertia = {inertia}, position = {position},
      quaternion = {quaternion}, velocity = {velocity}, spin = {spin} /
&surface name = 's', body = 'b', {body}, material = 'm' /
&surface name = 'f', body = 'ground', {ground}, material = 'g' /
&contact name = 'k', surfaces = 'f', 's', {law} /
&integrator method = '{method}', rtol = {rtol} /
&output file = 'out.h5', interval = {interval} /
"""


def numbers(values) -> str:
    """One number or several as a scene has them."""
    return ", ".join(repr(float(x)) for x in np.ravel(values))


class Drop:
    """One of the scenes."""

    # Share of the normal force by which friction may change and come back between two rows.
    unseen = 0.0

    def __init__(self, seed: int):
        self.build(seed, KINDS)
        self.method = METHODS[self.draw.integers(4)]
        self.rigid = bool(self.draw.random() < 0.5)
        law = "friction = 'none'"
        if self.draw.random() < 0.5:
            law = "friction = 'contensou_exact', friction_coefficient = 0.3"
            law += ", regularization_velocity = 1e-3"
        law += f", restitution = {self.draw.choice([0.3, 0.8])}"
        law += ", normal = 'rigid'" if self.rigid else ", damping = 'hunt_crossley'"
        self.turn()
        self.write(
            0.1,
            law,
            quaternion=self.draw.normal(size=4),
            velocity=self.draw.uniform(-0.2, 0.2, 3),
            spin=self.draw.normal(scale=self.draw.choice([0.1, 5.0]), size=3),
            rtol=10.0 ** -self.draw.integers(7, 11),
        )

    def write(
        self, t_end, law, quaternion, velocity, spin, rtol, young=(1e9, 1e9), poisson=(0.3, 0.3)
    ):
        """Make the text of the scene."""
        self.text = SCENE.format(
            t_end=t_end,
            young=young,
            poisson=poisson,
            mass=self.mass,
            inertia=numbers(self.inertia),
            position=numbers(self.position),
            quaternion=numbers(quaternion),
            velocity=numbers(velocity),
            spin=numbers(spin),
            body=self.body,
            ground=self.ground,
            law=law,
            method=self.method,
            rtol=rtol,
            interval=2e-5,
        )

    def build(self, seed: int, kinds: list):
        """Draw the body and what it drops onto."""
        self.draw = np.random.default_rng(seed)
        self.kind, build = kinds[seed % len(kinds)]
        # Direction of the axis of what is at rest, where the body begins.
        self.axis, self.position = np.array([0, 0, 1.0]), np.zeros(3)
        self.tilt = self.draw.normal(scale=self.draw.choice([0.0, 0.1]), size=3)
        build(self)

    def turn(self):
        """Turn what is at rest so that it has its axis."""
        tilted = self.axis + self.tilt
        self.frame = np.eye(3)
        if not re.search("sphere|ellipsoid", self.ground):
            self.frame = frame(tilted)
            key = "normal" if "plane" in self.ground else "direction"
            self.ground += f", {key} = {numbers(tilted)}"

    def judge(self, row: dict) -> list[str]:
        """What is wrong with the rows of a scene."""
        wrong = []
        n = len(row["time"])
        energy = sum(row[f"energy_{part}"] for part in ("kinetic", "potential", "elastic"))
        moved = max(row["energy_kinetic"].max(), np.ptp(row["energy_potential"]))
        if (off := abs(row["energy_error"]).max() / moved) > LOST:
            wrong.append(f"energy is off by {off:.1e}")
        if (off := (energy - np.minimum.accumulate(energy)).max() / moved) > LOST:
            wrong.append(f"energy grows by {off:.1e}")
        if not self.rigid and (i := self.untold(row)) >= 0:
            wrong.append(f"at {row['time'][i]:.6g} {row['gap'][i]} is not what events tell")
        forces = np.nansum(row["normal_force"], axis=1)
        largest = max(forces.max(), 10 * self.mass)
        near = 0.05 * self.smallest
        # Rows in between, and those where the most acts.
        for i in sorted({*range(1, n - 1, 331), *(np.argsort(forces)[-3:])}):
            at = row["position"][i, 0], row["quaternion"][i, 0]
            gaps = row["gap"][i]
            points = row["contact_point"][i, np.isfinite(gaps)]
            found = places(self.surface, self.distance, *at, self.frame, near, points)
            told = np.sort(gaps[np.isfinite(gaps)])
            told = told[told < near]
            close = [gap for gap, _ in found]
            # Open ones may be out of reach, and two that are one are told once.
            apart = APART * self.smallest
            if sum(told < -apart) != sum(np.array(close) < -apart) or any(
                min(abs(np.array(close) - x), default=1) > apart for x in told
            ):
                wrong.append(f"at {row['time'][i]:.6g} the gaps are {told}, not {np.array(close)}")
            if not 0 < i < n - 1:
                continue
            begin, end = row["time"][i - 1], row["time"][i + 1]
            if np.any((row["events"] >= begin) & (row["events"] <= end)):
                continue
            pairs = row["normal_force"][i - 1 : i + 2] > 0
            # The mean over the rows beside it, by Simpson's rule.
            part = slice(i - 1, i + 2)
            mean = np.array([1, 4, 1]) / 6
            force = np.array([0, 0, -9.81 * self.mass])
            force += mean @ np.nansum(row["friction_force"][part], axis=1)
            for k in np.flatnonzero(pairs[1]):
                point = row["contact_point"][i, k]
                if found:
                    away = [np.linalg.norm(x - point) for _, x in found]
                    point = found[int(np.argmin(away))][1]
                force += mean @ row["normal_force"][part, k] * normal(self, point)
            change = (row["velocity"][i + 1, 0] - row["velocity"][i - 1, 0]) * self.mass
            off = np.linalg.norm(change / (end - begin) - force)
            # What changes faster than the rows follow each other is not known better.
            second = np.array([1, -2, 1])
            known = 0.1 * abs(second @ forces[part])
            # Nor what acts while the normal turns by a radian, as of a ball that passes the axis of
            # a funnel.
            turned = row["contact_normal"][i + 1] - row["contact_normal"][i - 1]
            if np.linalg.norm(np.nan_to_num(turned), axis=-1).max() > 1:
                continue
            known += np.linalg.norm(second @ np.nansum(row["friction_force"][part], axis=1))
            known += self.unseen * forces[part].max()
            if off > FORCE * largest + known:
                wrong.append(f"at {row['time'][i]:.6g} a force of {off:.1e} N is not told")
        return wrong[:3]

    def untold(self, row: dict) -> int:
        """A row in which other places overlap than touches and lift-offs say; -1 for none."""
        gap = np.nan_to_num(row["gap"], nan=np.inf)
        change = np.where(row["kinds"] == "touch", 1, -1)
        closed = np.sum(gap[0] < 0) + np.array(
            [change[row["events"] <= time].sum() for time in row["time"]], int
        )
        # Where one of them is zero, about, either is right.
        apart = 1e-9 * self.smallest
        wrong = (closed < np.sum(gap < -apart, axis=1)) | (closed > np.sum(gap < apart, axis=1))
        return int(np.argmax(wrong)) if wrong.any() else -1

    def ellipsoid(self, longer=(2, 5)):
        """The body is an ellipsoid, longer than wide."""
        axes = np.sort(self.draw.uniform(0.004, 0.012, 3))
        axes[2] = self.draw.uniform(*longer) * axes[1]
        axes = self.draw.permutation(axes)
        self.surface, self.size = Ellipsoid(axes), axes.max()
        self.body = f"shape = 'ellipsoid', semi_axes = {numbers(axes)}"
        self.mass = 2e3 * 4 / 3 * np.pi * axes.prod()
        self.inertia = self.mass / 5 * (sum(axes**2) - axes**2)
        self.smallest = axes.min() ** 2 / axes.max()

    def ball(self):
        """The body is a ball."""
        self.ellipsoid()
        radius = self.draw.uniform(0.004, 0.012)
        self.surface, self.size, self.smallest = Ellipsoid(3 * [radius]), radius, radius
        self.body = f"shape = 'sphere', radius = {radius}"
        self.mass = 2e3 * 4 / 3 * np.pi * radius**3
        self.inertia = 3 * [0.4 * self.mass * radius**2]

    def ring(self):
        """The body is a ring."""
        minor = self.draw.uniform(0.003, 0.008)
        major = minor * self.draw.uniform(1.5, 6)
        self.surface, self.size = Torus(major, minor), major + minor
        self.body = f"shape = 'torus', major_radius = {major}, minor_radius = {minor}"
        self.mass = 2e3 * 2 * np.pi**2 * major * minor**2
        across = self.mass * (major**2 / 2 + 5 * minor**2 / 8)
        self.inertia = [across, across, self.mass * (major**2 + 0.75 * minor**2)]
        self.smallest = min(minor, major - minor)

    def in_bore(self):
        """It falls in a bore that lies."""
        radius = self.size * self.draw.uniform(1.1, 1.6)
        self.axis = np.array([self.draw.normal(scale=0.1), 1, self.draw.normal(scale=0.1)])
        self.ground = f"shape = 'cylinder', radius = {radius}, side = 'inside'"
        self.distance = to_cylinder(radius, True)

    def in_groove(self):
        """It falls in the tube of a groove."""
        tube = self.size * self.draw.uniform(1.1, 1.6)
        large = tube * self.draw.uniform(1.5, 5)
        self.axis = np.array([self.draw.normal(scale=0.1), 1, self.draw.normal(scale=0.1)])
        # In the middle of the tube, where that is lowest.
        axis = (self.axis + self.tilt) / np.linalg.norm(self.axis + self.tilt)
        low = axis * axis[2] - np.array([0, 0, 1])
        self.position = large * low / np.linalg.norm(low)
        self.ground = f"shape = 'torus', major_radius = {large}, minor_radius = {tube}"
        self.ground += ", side = 'inside'"
        self.distance = to_torus(large, tube, True)

    def on_ring(self):
        """It falls onto a ring."""
        large = self.size * self.draw.uniform(0.5, 1.2)
        wire = large * self.draw.uniform(0.2, 0.4)
        self.position = np.array([*self.draw.uniform(-0.3, 0.3, 2) * large, 1.4 * self.size + wire])
        self.ground = f"shape = 'torus', major_radius = {large}, minor_radius = {wire}"
        self.distance = to_torus(large, wire)

    def in_socket(self):
        """It falls in a hollow sphere."""
        radius = self.size * self.draw.uniform(1.1, 1.6)
        self.ground = f"shape = 'sphere', radius = {radius}, side = 'inside'"
        self.distance = to_sphere(radius, True)

    def in_hollow(self):
        """It falls in a hollow ellipsoid."""
        axes = self.size * self.draw.uniform(1.15, 2.0, 3)
        self.ground = f"shape = 'ellipsoid', semi_axes = {numbers(axes)}, side = 'inside'"
        self.distance = to_ellipsoid(axes)

    def in_dish(self):
        """It falls into a paraboloid."""
        radius = self.size * self.draw.uniform(0.5, 2)
        self.position = np.array([0, 0, 2.5 * self.size + radius])
        self.ground = f"shape = 'paraboloid', vertex_radius = {radius}, side = 'inside'"
        self.distance = to_paraboloid(radius)

    def in_funnel(self):
        """It falls into a cone."""
        half = self.draw.uniform(0.6, 1.2)
        self.position = np.array([0, 0, 1.1 / np.sin(half - 0.25)]) * self.size
        self.ground = f"shape = 'cone', half_angle = {half}, side = 'inside'"
        self.distance = to_cone(half)

    def on_rod(self):
        """It falls onto a rod that lies."""
        radius = self.size * self.draw.uniform(0.1, 0.5)
        self.axis = np.array([self.draw.normal(scale=0.1), 1, self.draw.normal(scale=0.1)])
        self.position = np.array([0.1 * self.size, 0, radius + 1.05 * self.size])
        self.ground = f"shape = 'cylinder', radius = {radius}"
        self.distance = to_cylinder(radius)


KINDS = [
    (f"{body} {ground}", lambda self, body=body, ground=ground: (
        getattr(self, body)(), getattr(self, ground)()))
    for body, ground in (
        ("ellipsoid", "in_bore"),
        ("ellipsoid", "in_groove"),
        ("ellipsoid", "on_ring"),
        ("ring", "in_bore"),
        ("ring", "on_ring"),
        ("ring", "in_groove"),
        ("ring", "on_rod"),
        ("ring", "in_socket"),
        ("ellipsoid", "in_socket"),
        ("ellipsoid", "in_hollow"),
        ("ball", "in_hollow"),
        ("ellipsoid", "in_dish"),
        ("ellipsoid", "in_funnel"),
        ("ring", "in_funnel"),
        ("ball", "in_funnel"),
    )
]  # fmt: skip


def drop(executable: str, drawn: Drop, folder: Path, limit: float = 120) -> tuple[str, str]:
    """What came of a scene, in words, and what is wrong with that; empty for nothing. The scene
    judges its rows."""
    (folder / "drop.nml").write_text(drawn.text)
    try:
        done = subprocess.run(
            [executable, "run", "drop.nml", "-q", "--force"],
            cwd=folder,
            capture_output=True,
            text=True,
            timeout=limit,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return "takes too long", ""
    words, wrong = "ends well", []
    if done.returncode:
        said = done.stderr.strip()
        # What it says of a contact last is why.
        why = [line for line in said.splitlines() if "contact 'k" in line] or [said]
        last = why[-1].partition("'s': ")[2] or why[-1].strip()
        words = "ends: " + re.sub(r"[-+]?\d[\d.e+-]*", "#", last)[:60]
        unsaid = ("leaves the domain" in said and ": gap " in why[-1]) or "to 0.0E+00 s" in said
        if unsaid or done.returncode != 1 or not re.search(r"contact 'k|integrator\.", said):
            wrong.append(said)
    name = folder / ("out.h5" if done.returncode == 0 else "out.h5.part")
    if not name.exists():
        return words, "; ".join(wrong)
    with h5py.File(name) as file:
        row = {key: file["trajectory"][key][()] for key in file["trajectory"]}
        row["events"] = file["events/time"][()]
        row["kinds"] = file["events/kind"].asstr()[()]
    name.unlink()
    wrong += drawn.judge(row)
    return words, "; ".join(wrong)


def normal(drawn: Drop, point: np.ndarray) -> np.ndarray:
    """Normal of what is at rest at a point near it."""
    h = 1e-6 * drawn.size
    steps = h * np.concatenate([np.eye(3), -np.eye(3)])
    x = drawn.distance((point + steps) @ drawn.frame)
    slope = (x[:3] - x[3:]) / (2 * h)
    return slope / np.linalg.norm(slope)


def main(draw=Drop) -> int:
    """Do the campaign."""
    first = int(sys.argv[1]) if len(sys.argv) > 1 else 0
    number = int(sys.argv[2]) if len(sys.argv) > 2 else 200
    folder = Path(tempfile.mkdtemp(dir=sys.argv[3] if len(sys.argv) > 3 else None))
    executable = os.path.abspath(os.environ["CONTENSOU"])
    counts, wrongs = Counter(), 0
    for seed in range(first, first + number):
        drawn = draw(seed)
        words, wrong = drop(executable, drawn, folder)
        law = "rigid" if drawn.rigid else "hertz"
        counts[drawn.kind, words] += 1
        if wrong:
            wrongs += 1
            print(f"{seed} ({drawn.kind}, {law}, {drawn.method}): {words}: {wrong}", flush=True)
    for (kind, words), count in sorted(counts.items()):
        print(f"{kind:20s} {count:5d} {words}")
    print(f"{wrongs} of {number} went wrong")
    shutil.rmtree(folder)
    return bool(wrongs)


if __name__ == "__main__":
    sys.exit(main())
