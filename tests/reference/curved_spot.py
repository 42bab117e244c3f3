"""Reference values of the friction wrench of a curved spot, from its definition.

In units of f N, a and a/s: the pressure (3/(2 pi k)) sqrt(1 - x^2 - y^2/k^2), the slip
v + W n x r + z(r) q with z = h11 x^2 + 2 h12 x y + h22 y^2. Chords y = const of the spot, cut where
a zero of the slip, whose components are one quadratic polynomial with complex coefficients, is
closest, with tanh-sinh rules on the parts; across the chords Gauss rules with 30 nodes on intervals
that are halved until both halves agree with the whole.
"""

import csv
import itertools
import sys

import numpy as np

STEPS = 3.6 / 60 * np.arange(-60, 61)
NODES = np.tanh(np.pi / 2 * np.sinh(STEPS))
WEIGHTS = 3.6 / 60 * np.pi / 2 * np.cosh(STEPS) / np.cosh(np.pi / 2 * np.sinh(STEPS)) ** 2
X30, W30 = np.polynomial.legendre.leggauss(30)


def chord(k, v, spin, h, q, disc_y):
    """Integral over a chord."""
    half = np.sqrt((1 - disc_y) * (1 + disc_y))
    y = k * disc_y
    rise = np.array([h[0], 2 * h[1] * y, h[2] * y * y])
    slip = rise * (q[0] + 1j * q[1]) + [0, 1j * spin, v[0] - spin * y + 1j * v[1]]
    cuts = []
    if np.any(slip[:2] != 0):
        cuts = sorted(x for x in np.roots(slip).real if -half < x < half)
    ends = [-half, *cuts, half]
    total = np.zeros(5)
    for low, high in itertools.pairwise(ends):
        width = 0.5 * (high - low)
        x = low + width * (1 + NODES)
        below = half - x
        weight = width * WEIGHTS * 1.5 / np.pi * np.sqrt(np.maximum(below * (half + x), 0))
        along = np.polyval(slip, x)
        unit = along / np.maximum(abs(along), 1e-300)
        z = np.polyval(rise, x)
        torque = x * unit.imag - y * unit.real
        total -= [
            (weight * c).sum() for c in (unit.real, unit.imag, torque, z * unit.real, z * unit.imag)
        ]
    return total


def panel(low, high, integrand):
    """Integral over an interval with one rule."""
    width = 0.5 * (high - low)
    return sum(width * w * integrand(low + width * (1 + x)) for x, w in zip(X30, W30, strict=True))


def refine(low, high, whole, integrand, depth=0):
    """Integral over an interval."""
    middle = 0.5 * (low + high)
    parts = [panel(low, middle, integrand), panel(middle, high, integrand)]
    if abs(sum(parts) - whole).max() < 2e-13 or depth > 30:
        return sum(parts)
    return refine(low, middle, parts[0], integrand, depth + 1) + refine(
        middle, high, parts[1], integrand, depth + 1
    )


def wrench(k, v, spin, h, q):
    """F_x, F_y, T, G_x, G_y."""

    def integrand(y):
        return chord(k, v, spin, h, q, y)

    return refine(-1.0, 1.0, panel(-1.0, 1.0, integrand), integrand)


def draw(i, random):
    """A spot and its motion."""
    k = 10 ** random.uniform(-2, 0)
    v = random.normal(size=2) * 10 ** random.uniform(-3, 0.5)
    spin = random.normal() * 10 ** random.uniform(-3, 0.5)
    h = random.normal(size=3)
    angle = random.uniform(0, 2 * np.pi)
    q = np.array([np.cos(angle), np.sin(angle)])
    if i % 3 == 0:
        # One curvature dominates, as of a ball in a groove.
        h = np.array([1, 0, random.uniform(-1, 1)])
    if i % 6 == 0:
        q = np.array([0.0, 1.0])
    if i % 10 == 0:
        spin = 0.0
    if i % 20 == 0:
        v = np.array([0, v[1]]) if q[0] == 0 else 0 * v
    if i % 25 == 7:
        h = h * 1e-6
    return k, v, spin, h, q


def draw_in_groove(i, random):
    """A ball in a groove that rolls, spins, slides along it and, with even numbers, across it."""
    k = random.uniform(0.08, 0.15)
    spin = random.uniform(-0.6, 0.6) if i % 4 else random.normal() * 10 ** random.uniform(-5, -1)
    v = np.array([0.0, -random.uniform(0.0, 0.4)])
    if i % 2 == 0:
        v[0] = random.normal() * 10 ** random.uniform(-4, -1)
    return k, v, spin, np.array([1, 0, 0.45]), np.array([0.0, 1.0])


if __name__ == "__main__":
    random = np.random.default_rng(1)
    out = csv.writer(sys.stdout)
    print("k,vx,vy,W,h11,h12,h22,qx,qy,Fx,Fy,T,Gx,Gy")
    for i in range(200):
        k, v, spin, h, q = draw(i, random)
        row = [k, *v, spin, *h, *q, *wrench(k, v, spin, h, q)]
        out.writerow([f"{x:.17g}" for x in row])
        sys.stdout.flush()
