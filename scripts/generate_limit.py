"""Generate src/contact/tangential/limit_values.f90: limits of shells of elliptic spots, about.

With x, y and z the squares of the components of a force over those of pure sliding along the axes
and of pure spinning, and s their sum, the limit of a shell is about

    F = s [1 + (z/s) B(x/s, y/s)] = 1

and slip is along its gradient. B is a cubic polynomial without a constant, so that pure sliding and
pure spinning are met; it depends on the axis ratio, by polynomials of degree two, and not on the
shell. It is fitted to the directions in which shells that are not innermost slide, and with less
weight to F = 1; large errors, those of needles, count as their size, small ones as its square.

    generate_limit.py            write the file, in seconds, and print the errors
    generate_limit.py --check    compute it and compare it with the file

Exit status 0, or 1 when the check finds a difference: the last digit, which is that of the linear
algebra at hand, may be another one.
"""

from __future__ import annotations

import argparse
import re
import sys
from pathlib import Path

import numpy as np

TARGET = Path(__file__).resolve().parent.parent / "src" / "contact" / "tangential"
TARGET /= "limit_values.f90"

# Axis ratios, and places of the edges of shells.
RATIOS = (0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0)
SHELLS = ((0.125, 0.25), (0.3, 0.33), (0.5, 0.625), (0.6, 0.63), (0.875, 1.0), (0.97, 1.0))

# Directions of sliding, and of sliding against spinning.
WAYS = 9
SPINS = 17

# Powers of x/s and y/s in B, and degree in the axis ratio.
POWERS = ((1, 0), (0, 1), (2, 0), (1, 1), (0, 2), (3, 0), (2, 1), (1, 2), (0, 3))
DEGREE = 2

# Weight of F, and the error from which on it is its size that counts.
WEIGHT = 0.3
LARGE = 0.01

PLACES = 3

NODES, WEIGHTS = np.polynomial.legendre.leggauss(80)


def within(ratio: float, place: float, u: np.ndarray) -> np.ndarray:
    """Forces of sliding along u of what is within a place of an ellipse, in f N and f N a.

    The formulas of src/contact/tangential/ellipse_pass.f90, with integrals by Gauss' rule.
    """
    load = 1.5 * place - 0.5 * place**3
    size = load ** (2 / 3)
    if load <= 0:
        return np.zeros_like(u)
    k2 = ratio**2
    vx, vy, w = u[:, 0], u[:, 1], size * u[:, 2]
    # The s of the centre of rotation: vy^2/(w^2 + s) + vx^2/(k^2 w^2 + s) = 1.
    half = 0.5 * (vx**2 + vy**2 - (1 + k2) * w**2)
    rest = k2 * w**4 - vy**2 * k2 * w**2 - vx**2 * w**2
    s = np.maximum(half + np.sqrt(np.maximum(half**2 - rest, 0)), 0)
    root = np.sqrt(s)
    scale = np.sqrt(ratio) * w + root
    y = 0.5 * (NODES + 1)
    t = root[:, None] + scale[:, None] * y / (1 - y)
    step = 0.5 * WEIGHTS * scale[:, None] / (1 - y) ** 2
    a, b = w[:, None] ** 2 + t**2, k2 * w[:, None] ** 2 + t**2
    kernel = 2 * t**2 / np.sqrt(a * b) * step
    j_aa, j_ab, j_bb = ((kernel / c).sum(axis=1) for c in (a * a, a * b, b * b))
    a, b = w**2 + s, k2 * w**2 + s
    end = root / np.sqrt(a * b) * s
    r_aa, r_ab, r_bb = (
        j - end * (2 / 3) / c for j, c in ((j_aa, a * a), (j_ab, a * b), (j_bb, b * b))
    )
    e_a, e_b = 3 * j_aa + k2 * j_ab, j_ab + 3 * k2 * j_bb
    r_a = (vy**2 * r_aa + vx**2 * r_ab) / w**2
    r_b = (vx**2 * r_bb + vy**2 * r_ab) / w**2
    force_x = 0.75 * vx * (w**2 * (e_b - r_b) + 4 / 3 * end / b)
    force_y = 0.75 * vy * (w**2 * (e_a - r_a) + 4 / 3 * end / a)
    torque = (
        (-3 / 16)
        * w
        * (
            2 * (vy**2 * e_a + vx**2 * e_b)
            - 3 * (vy**2 * r_a + vx**2 * r_b)
            - w**2 * (e_a + k2 * e_b)
            - 2 * end * (1 / a + k2 / b)
        )
    )
    return load * np.column_stack((force_x, force_y, size * torque))


def of_shell(ratio: float, shell: tuple[float, float], u: np.ndarray) -> np.ndarray:
    """Forces of a shell that slides along u."""
    return within(ratio, shell[1], u) - within(ratio, shell[0], u)


def samples() -> tuple[np.ndarray, ...]:
    """Axis ratios, forces over those of pure sliding and spinning, directions, and these forces."""
    way = np.pi / 2 * (np.arange(WAYS) + 0.5) / WAYS
    # More of spinning, near which the limit bends most.
    spin = np.pi / 2 * np.sqrt((np.arange(SPINS) + 0.5) / SPINS)
    way, spin = (x.ravel() for x in np.meshgrid(way, spin))
    scaled = np.column_stack((np.cos(spin) * np.cos(way), np.cos(spin) * np.sin(way), np.sin(spin)))
    tiny = 1e-6
    found = []
    for ratio in RATIOS:
        for shell in SHELLS:
            slide = of_shell(ratio, shell, np.array([[1.0, 0.0, tiny]]))[0, 0]
            turn = of_shell(ratio, shell, np.array([[tiny, 0.0, 1.0]]))[0, 2]
            pure = np.array([slide, slide, turn])
            # Those of all shapes of the limit, and those that motions have.
            u = scaled / pure
            u /= np.linalg.norm(u, axis=1)[:, None]
            force = of_shell(ratio, shell, u) / pure
            found.append((np.full(len(u), ratio), force, u, np.tile(pure, (len(u), 1))))
    return tuple(np.concatenate(part) for part in zip(*found, strict=True))


def model(bulge: np.ndarray, force: np.ndarray, pure: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """F and the direction of its gradient."""
    square = force**2
    s = square.sum(axis=1)
    x, y, z = (square / s[:, None]).T
    b, by_x, by_y = np.zeros_like(x), np.zeros_like(x), np.zeros_like(x)
    for c, (i, j) in zip(bulge, POWERS, strict=True):
        b += c * x**i * y**j
        if i:
            by_x += c * i * x ** (i - 1) * y**j
        if j:
            by_y += c * j * x**i * y ** (j - 1)
    along = x * by_x + y * by_y
    slope = np.column_stack((1 + z * (by_x - along), 1 + z * (by_y - along), 1 + b - z * along))
    u = force * slope / pure
    return s * (1 + z * b), u / np.linalg.norm(u, axis=1)[:, None]


def fitted() -> np.ndarray:
    """Coefficients: one row for each power of POWERS, by powers of the axis ratio."""
    ratio, force, u, pure = samples()
    powers = np.stack([ratio**i for i in range(DEGREE + 1)])

    def residuals(numbers: np.ndarray) -> np.ndarray:
        limit, along = model(numbers.reshape(len(POWERS), -1) @ powers, force, pure)
        return np.concatenate(((along - u).ravel(), WEIGHT * (limit - 1)))

    numbers = np.zeros((len(POWERS), DEGREE + 1))
    numbers[:2, 0] = 0.5, 1.5
    numbers = numbers.ravel()
    step = 1e-6
    for _ in range(100):
        rest = residuals(numbers)
        slopes = np.column_stack(
            [(residuals(numbers + step * e) - rest) / step for e in np.eye(len(numbers))]
        )
        weight = (rest**2 + LARGE**2) ** -0.25
        change = np.linalg.lstsq(slopes * weight[:, None], -rest * weight, rcond=None)[0]
        numbers = numbers + change
        if np.abs(change).max() < 1e-6:
            break
    else:
        raise SystemExit("the fit does not come to an end")
    limit, along = model(numbers.reshape(len(POWERS), -1) @ powers, force, pure)
    error = np.linalg.norm(along - u, axis=1)
    for one in RATIOS:
        here = ratio == one
        print(
            f"k = {one}: directions off by {np.median(error[here]):.4f} in the median and "
            f"{np.quantile(error[here], 0.9):.3f} of nine in ten, F from {limit[here].min():.3f} "
            f"to {limit[here].max():.3f}"
        )
    return numbers.reshape(len(POWERS), -1)


def written() -> str:
    """The module."""
    rows = [", ".join(f"{x:.{PLACES}f}_wp" for x in row) for row in fitted()]
    return (
        """\
!> Limits of shells of elliptic spots, about. Written by scripts/generate_limit.py, which explains
!> them.
module contensou_contact_tangential_limit_values
   use contensou_base_kinds, only : wp
   implicit none(type, external)
   private

   !> Coefficients of B, of x, y, x^2, x y, y^2, x^3, x^2 y, x y^2 and y^3, by powers of the axis
   !> ratio.
   real(wp), parameter, public :: bulges(0:"""
        + f"{DEGREE}, {len(POWERS)}) = reshape([ &\n      "
        + ", &\n      ".join(rows)
        + f"], [{DEGREE + 1}, {len(POWERS)}])\n"
        + """
end module contensou_contact_tangential_limit_values
"""
    )


def main() -> int:
    """Write the file or check it."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--check", action="store_true", help="compare with the file")
    chosen = parser.parse_args()
    text = written()
    if chosen.check:
        there = TARGET.read_text(encoding="utf-8")
        number = re.compile(r"-?\d+\.\d+(?=_wp)")
        both = [np.array(number.findall(one), dtype=float) for one in (there, text)]
        same = number.sub("", there) == number.sub("", text) and bool(
            np.all(np.abs(both[0] - both[1]) < 1.5 * 10.0**-PLACES)
        )
        print("the file is what is generated" if same else f"{TARGET} differs")
        return int(not same)
    TARGET.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
