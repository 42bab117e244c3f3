"""Contacts that remember or roll, drawn at random: what friction must not do, it does not do.

    python tests/campaigns/memory.py [FIRST] [NUMBER] [FOLDER]

draws the scenes FIRST (0) to FIRST + NUMBER (200) of tests/campaigns/spots.py, and of the same
bodies on a plane, with `tangential`, any friction, materials and number of layers, compliant or
rigid. Beside what is wrong there a scene is wrong if friction bears more than its limit, if it is
not told what sticks, or if work is taken back from friction. With a law of creep some is: what is
carried out of the spot is no energy that is known. Exit status 1 if one is wrong. CONTENSOU names
the executable.
"""

from __future__ import annotations

import sys

import numpy as np
from spots import KINDS, METHODS, Drop, main

# Friction beyond its limit that is admitted, over the largest force, as rigid forces are known; and
# what laws of creep round, over the limit.
BEYOND = 1e-8
ROUNDED = 2e-3

# Work that friction gives back, over the energy that moved.
RETURNED = {"elastic": 1e-6, "spring": 1e-6, "rolling": 1e-6, "creep": 1e-4}

LAWS = ("linear", "strip", "polach", "fastsim", "brush", "table")
FRICTION = ("contensou_exact", "contensou_simplified", "pade11", "pade22", "coulomb")


def on_plane(self):
    """It falls onto a plane."""
    self.position = np.array([0, 0, 1.1 * self.size])
    self.ground = "shape = 'plane'"
    self.distance = lambda points: points[..., 2]


ON_PLANE = [
    (f"{body} on_plane", lambda self, body=body: (getattr(self, body)(), on_plane(self)))
    for body in ("ball", "ellipsoid", "ring")
]


class Memory(Drop):
    """One of the scenes."""

    def __init__(self, seed: int):
        self.build(seed, KINDS + 3 * ON_PLANE)
        draw = self.draw
        self.method = METHODS[draw.integers(4)]
        self.memory = draw.choice(list(RETURNED), p=[0.5, 0.1, 0.15, 0.25])
        self.rigid = bool(self.memory != "rolling" and draw.random() < 0.15)
        self.coefficient = draw.choice([0.0, 0.05, 0.3, 0.8, 1.5], p=[0.05, 0.2, 0.35, 0.25, 0.15])
        # What slides begins to roll in no time.
        self.unseen = self.coefficient * (self.memory == "rolling")
        friction = FRICTION[0]
        if self.memory in ("elastic", "spring"):
            friction = draw.choice(FRICTION, p=[0.7, 0.1, 0.05, 0.1, 0.05])
        law = f"friction = '{friction}', friction_coefficient = {self.coefficient}"
        if friction == "coulomb":
            law += ", regularization_velocity = 1e-4"
        law += f", tangential = '{'elastic' if self.memory == 'creep' else self.memory}'"
        self.creep = draw.choice(LAWS) if self.memory in ("rolling", "creep") else ""
        if self.creep:
            law += f", creep = '{self.creep}'"
        if self.memory in ("elastic", "creep") and draw.random() < 0.5:
            law += f", layers = {draw.integers(1, 40)}"
        if self.rigid:
            law += f", normal = 'rigid', restitution = {draw.choice([0.3, 0.8])}"
        elif draw.random() < 0.6:
            law += f", damping = 'hunt_crossley', restitution = {draw.choice([0.3, 0.8])}"
        else:
            law += ", damping = 'none'"
        self.turn()
        self.write(
            0.05,
            law,
            quaternion=draw.normal(size=4),
            velocity=draw.uniform(-0.2, 0.2, 3),
            spin=draw.normal(scale=draw.choice([0.1, 5.0, 100.0]), size=3),
            rtol=10.0 ** -draw.integers(7, 11),
            young=10.0 ** draw.uniform(8, 10.5, 2),
            poisson=draw.choice([0.0, 0.3, 0.5], 2),
        )

    def judge(self, row: dict) -> list[str]:
        """What is wrong with the rows of a scene."""
        wrong = super().judge(row)
        moved = max(row["energy_kinetic"].max(), np.ptp(row["energy_potential"]))
        lost = row["work_friction"]
        if (back := (np.maximum.accumulate(lost) - lost).max() / moved) > RETURNED[self.memory]:
            wrong.append(f"friction gives back {back:.1e}")
        normal = np.nan_to_num(row["normal_force"])
        force = np.nan_to_num(np.linalg.norm(row["friction_force"], axis=-1))
        limit = self.coefficient * normal
        beyond = (force - limit * (1 + ROUNDED * bool(self.creep))).max()
        # The linear law has no limit where nothing remembers.
        if not (self.memory == "rolling" and self.creep == "linear") and beyond > (
            BEYOND * normal.max()
        ):
            wrong.append(f"friction is {beyond:.1e} N beyond its limit")
        if self.memory != "rolling":
            share = row["stuck_share"][np.isfinite(row["gap"])]
            if not ((share >= 0) & (share <= 1 + 1e-12)).all():
                wrong.append("what sticks is not from 0 to 1")
        return wrong


if __name__ == "__main__":
    sys.exit(main(Memory))
