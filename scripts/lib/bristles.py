"""Tractions in a spot that rolls, by the simplified theory (J. Kalker, Vehicle System Dynamics 11
(1982) 1): bristles of one flexibility on lines along which the material passes, the flexibility
with which they come nearest to a given force and torque.

Places are in parts of the semi-axes, tractions in parts of f p0.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

STEPS = 100
SPACING = 0.5  # of the logarithms of the flexibility
HALVINGS = 40
GOLDEN = 0.6180339887498949
AROUND = 24

Field = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray, np.ndarray]]


@dataclass(frozen=True)
class Lines:
    """How the material of a spot moves."""

    passing: np.ndarray  # its direction in the unit circle
    slip: np.ndarray  # vx, vy, w sqrt(a b), of any length
    wide: float  # a / sqrt(a b)
    low: float  # b / sqrt(a b)

    def tractions(
        self, flexibility: float, x: np.ndarray, y: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Tractions at places, and whether it sticks there."""
        kx, ky = self.passing
        along = x * kx + y * ky
        way = along + np.sqrt(np.maximum(along**2 + 1 - x**2 - y**2, 0))
        step = way / STEPS
        tx, ty = np.zeros_like(way), np.zeros_like(way)
        sticks = np.ones(way.shape, dtype=bool)
        for i in range(STEPS):
            back = way - (i + 0.5) * step
            mx, my = x - back * kx, y - back * ky
            tx = tx - step / flexibility * (self.slip[0] - self.slip[2] * my * self.low)
            ty = ty - step / flexibility * (self.slip[1] + self.slip[2] * mx * self.wide)
            ends = (mx + 0.5 * step * kx) ** 2 + (my + 0.5 * step * ky) ** 2
            bound, size = np.sqrt(np.maximum(1 - ends, 0)), np.hypot(tx, ty)
            sticks = size <= bound
            share = np.where(sticks, 1.0, bound / np.where(size > 0, size, 1))
            tx, ty = tx * share, ty * share
        return tx, ty, sticks

    def wrench(self, flexibility: float) -> np.ndarray:
        """Force and torque that they make, in parts of f N and f N sqrt(a b)."""
        nodes, weights = np.polynomial.legendre.leggauss(12)
        r, weights = np.sqrt(0.5 * (nodes + 1))[:, None], 0.5 * weights[:, None] / AROUND
        turn = 2 * np.pi * (np.arange(AROUND) + 0.5) / AROUND
        x, y = r * np.cos(turn), r * np.sin(turn)
        tx, ty, _ = self.tractions(flexibility, x, y)
        torque = x * self.wide * ty - y * self.low * tx
        return 1.5 * np.array([np.sum(weights * part) for part in (tx, ty, torque)])


def field(spot: dict[str, float], force: np.ndarray) -> Field:
    """The tractions of a spot a, b [m], f, N [N] with slip vx, vy [m/s], w [rad/s] through which
    material passes with cx, cy [m/s], and on which friction exerts Fx, Fy [N], T [N m]."""
    a, b = spot["a"], spot["b"]
    root = np.sqrt(a * b)
    passing = np.array([spot["cx"] / a, spot["cy"] / b])
    slip = np.array([spot["vx"], spot["vy"], spot["w"] * root])
    lines = Lines(
        passing / np.linalg.norm(passing), slip / np.linalg.norm(slip), a / root, b / root
    )
    wanted = force / [1, 1, root] / (spot["f"] * spot["N"])

    def off(logarithm: float) -> float:
        return float(np.linalg.norm(lines.wrench(float(np.exp(logarithm))) - wanted))

    # The size of the wrench has no bound to be found by: with spin it falls again as all slips.
    middle = min(np.arange(-12.0, 14.0, SPACING), key=off)
    low, high = middle - SPACING, middle + SPACING
    for _ in range(HALVINGS):
        left, right = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
        if off(left) < off(right):
            high = right
        else:
            low = left
    flexibility = float(np.exp(high))
    return lambda x, y: lines.tractions(flexibility, x, y)
