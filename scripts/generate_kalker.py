"""Generate the table of Kalker's coefficients, src/contact/kalker_values.f90.

The linear theory of rolling: all of an elliptic spot sticks. With X, Y the coordinates over the
semi-axes and r^2 = X^2 + Y^2, tractions P(X, Y)/sqrt(1 - r^2) with polynomials P make displacements
that are polynomials of the same degree (Galin). In terms of exp(i m t), of the disc, degree l has
the orders m = -l, -l + 2, ..., l, and the traction of a displacement of one such degree solves a
linear system whose entries are the Fourier coefficients over the directions t of

    (1 - nu + nu cos^2)/D,  nu sin cos/D,  (1 - nu + nu sin^2)/D,

D the length of (a cos t, b sin t) and cos, sin of its direction. The displacements in rolling are
minus the integral of the creep along the rolling direction, plus polynomials of the coordinate
across, chosen so that the factor of the infinite traction at the leading half of the rim vanishes,
in the sense of least squares. Forces are those of the lowest degrees.

Tabulated are C11, C12, C22, C13, C23, C33 in axes along and across the rolling direction, by

    ln(a/b), p = t/(1 + t) with t = sqrt(a/b) tan chi, and Poisson's ratio,

as coefficients of cubic splines in the first two and values at Chebyshev points of the third. With
the axes exchanged ln(a/b) changes its sign, p becomes 1 - p, and C12 and C13 change theirs: splines
through both halves are smooth at the circle as well.
Those of reciprocity, C12 = C21, C13 = -C31, C23 = -C32, are averaged.

    generate_kalker.py           write the table, in a minute
    generate_kalker.py --check N [--seed S]
                                 solve N random cases and compare with splines of the table

Needs numpy. Exit status 0, or 1 when the check finds an error beyond 2e-3.
"""

from __future__ import annotations

import argparse
import math
import random
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
TARGET = ROOT / "src" / "contact" / "kalker_values.f90"

# Degree of the polynomials.
DEGREE = 40

# Distance and number of ln(a/b) from zero on; number of p from 0 to 1; of nu.
STEP, RATIOS, DIRECTIONS, POISSONS = 0.25, 13, 25, 6


def poissons() -> np.ndarray:
    """Poisson's ratios: Chebyshev points with both ends."""
    return 0.25 - 0.25 * np.cos(np.pi * np.arange(POISSONS) / (POISSONS - 1))


def stiffness_blocks(a: float, b: float, nu: float) -> list[tuple[np.ndarray, np.ndarray]]:
    """Orders of every degree, and tractions over displacements of that degree."""
    orders = DEGREE + 2
    n = max(64, int(60 * max(a / b, b / a))) + 4 * orders
    t = np.arange(n) * np.pi / n
    length = np.hypot(a * np.cos(t), b * np.sin(t))
    c, s = a * np.cos(t) / length, b * np.sin(t) / length
    waves = np.exp(2j * np.arange(-orders, orders + 1)[:, None] * (t + np.pi / 2)) * np.pi / n
    xx, xy, yy = (
        waves @ (f / length) for f in (1 - nu + nu * c * c, nu * c * s, 1 - nu + nu * s * s)
    )
    found = []
    for degree in range(DEGREE + 1):
        m = np.arange(-degree, degree + 1, 2)
        at = (m[None, :] - m[:, None]) // 2 + orders
        matrix = np.block([[xx[at], xy[at]], [xy[at], yy[at]]]) * a * b
        found.append((m, np.linalg.inv(matrix)))
    return found


def coefficients(a: float, b: float, nu: float, angles: np.ndarray) -> np.ndarray:
    """C11, C12, C22, C13, C23, C33 of rolling directions chi."""
    blocks = stiffness_blocks(a, b, nu)
    points, weights = np.polynomial.legendre.leggauss(4 * (DEGREE + 1))
    found = []
    for chi in angles:
        e = np.array([math.cos(chi), math.sin(chi)])
        across = np.array([-e[1], e[0]])
        normal = e / (a, b)
        # The leading half of the rim.
        rim = math.atan2(normal[1], normal[0]) + np.pi / 2 * points

        def parts(degree, factor, angle, direction, rim=rim):
            """Traction factor at the rim, and force, of a displacement of one degree."""
            m, inverse = blocks[degree]
            wave = factor * np.exp(-1j * m * angle)
            solved = inverse @ np.concatenate([wave * direction[0], wave * direction[1]])
            x, y = solved[: degree + 1], solved[degree + 1 :]
            waves = np.exp(1j * np.outer(rim, m))
            at_rim = np.concatenate([(waves @ v).real * np.sqrt(weights) for v in (x, y)])
            force = np.zeros(3)
            if degree == 0:
                force[:2] = 2 * np.pi * x[0].real, 2 * np.pi * y[0].real
            elif degree == 1:
                force[2] = 2 * np.pi / 3 * (2 * a * y[1].real + 2 * b * x[1].imag)
            return np.concatenate([at_rim, force * a * b])

        def polar(vector):
            return math.hypot(*vector), math.atan2(vector[1], vector[0])

        # Coordinates along and across are p.(X, Y), r.(X, Y).
        p, r = np.array([a, b]) * e, np.array([a, b]) * across
        (long, beta), (_, gamma) = polar(p), polar(r)
        (total, plus), (rest, minus) = polar(p + r), polar(p - r)
        square = [(2, 2 * long**2 / 3, beta), (0, long**2 / 3, 0.0)]
        product = [
            (2, total**2 / 6, plus),
            (2, -(rest**2) / 6, minus),
            (0, (total**2 - rest**2) / 12, 0.0),
        ]
        loads = [
            parts(1, long, beta, e),
            parts(1, long, beta, across),
            sum(parts(n, -factor, angle, e) for n, factor, angle in product)
            + sum(parts(n, factor / 2, angle, across) for n, factor, angle in square),
        ]
        free = np.array(
            [
                parts(degree, 1.0, gamma, direction)
                for degree in range(DEGREE + 1)
                for direction in (e, across)
            ]
        ).T
        loads = np.array(loads).T
        chosen, *_ = np.linalg.lstsq(free[:-3], -loads[:-3], rcond=None)
        force = loads[-3:] + free[-3:] @ chosen
        turned = np.array(
            [e[0] * force[0] + e[1] * force[1], e[0] * force[1] - e[1] * force[0], force[2]]
        )
        c = -turned / (a * b)
        c[:, 2] /= math.sqrt(a * b)
        c[2, :] /= math.sqrt(a * b)
        found.append(
            [
                c[0, 0],
                (c[0, 1] + c[1, 0]) / 2,
                c[1, 1],
                (c[0, 2] - c[2, 0]) / 2,
                (c[1, 2] - c[2, 1]) / 2,
                c[2, 2],
            ]
        )
    return np.array(found)


def spline(values: np.ndarray) -> np.ndarray:
    """Coefficients of the cubic spline along the first axis, two more than values."""
    n = len(values)
    matrix = np.zeros((n + 2, n + 2))
    for i in range(n):
        matrix[i + 1, i : i + 3] = 1 / 6, 4 / 6, 1 / 6
    matrix[0, :5] = matrix[-1, -5:] = 1, -4, 6, -4, 1
    ends = np.zeros((1, *values.shape[1:]))
    return np.tensordot(np.linalg.inv(matrix), np.concatenate([ends, values, ends]), 1)


def spline_in_direction(values: np.ndarray, even: bool) -> np.ndarray:
    """The same in p; values are even or odd functions of the angle at both ends."""
    n = len(values)
    matrix = np.zeros((n + 2, n + 2))
    for i in range(n):
        matrix[i + 1, i : i + 3] = 1 / 6, 4 / 6, 1 / 6
    # The slope is zero, or the curvature by the angle, d2/dp2 - 2 d/dp.
    ends = (-1, 0, 1) if even else (1 + 1 / (n - 1), -2, 1 - 1 / (n - 1))
    matrix[0, :3] = ends
    matrix[-1, -3:] = ends[::-1]
    zero = np.zeros((1, *values.shape[1:]))
    return np.tensordot(np.linalg.inv(matrix), np.concatenate([zero, values, zero]), 1)


def table() -> np.ndarray:
    """Coefficients [ratio, direction, nu, component]."""
    p = np.arange(DIRECTIONS) / (DIRECTIONS - 1)
    values = np.zeros((DIRECTIONS, RATIOS, POISSONS, 6))
    for i in range(RATIOS):
        g = math.exp(STEP * i)
        chi = np.arctan2(p, math.sqrt(g) * (1 - p))
        for j, nu in enumerate(poissons()):
            values[:, i, j] = coefficients(math.sqrt(g), 1 / math.sqrt(g), nu, chi)
    even = np.array([True, False, True, False, True, True])
    values[[0, -1]] *= even
    directed = np.zeros((DIRECTIONS + 2, RATIOS, POISSONS, 6))
    for kind in (True, False):
        directed[..., even == kind] = spline_in_direction(values[..., even == kind], kind)
    directed = np.moveaxis(directed, 1, 0)
    mirrored = directed[:0:-1, ::-1] * np.where(even, 1.0, -1.0)
    return spline(np.concatenate([mirrored, directed]))[RATIOS - 1 :]


def written(values: np.ndarray) -> str:
    """The module."""
    lines = [
        f"""\
!> Table of Kalker's coefficients: of splines in ln(a/b) and in p, which is 0 where the spot rolls
!> along its major axis and 1 along the minor one, and of Chebyshev points in Poisson's
!> ratio. Written by scripts/generate_kalker.py, which explains them.
module contensou_contact_kalker_values
   use contensou_base_kinds, only : wp
   implicit none(type, external)
   private

   !> Number of ln(a/b), of p from 0 to 1, and of Poisson's ratios.
   integer, parameter, public :: n_ratios = {RATIOS}, n_directions = {DIRECTIONS}, &
      n_poissons = {POISSONS}

   !> Distance of ln(a/b), which begin at zero.
   real(wp), parameter, public :: ratio_step = {STEP}_wp

   !> C11, C12, C22, C13, C23, C33 by Poisson's ratio, p and ln(a/b).
   real(wp), protected, public :: coefficients(6, n_poissons, -1:n_directions, -1:n_ratios)
"""
    ]
    for i, by_direction in enumerate(values):
        for j, part in enumerate(by_direction):
            lines.append(f"   data coefficients(:, :, {j - 1}, {i - 1}) / &")
            words = [f"{x + 0.0:.10e}_wp" for x in part.reshape(-1)]
            lines += [
                "      " + ", ".join(words[at : at + 4]) + (", &" if at + 4 < len(words) else "/")
                for at in range(0, len(words), 4)
            ]
    lines.append("\nend module contensou_contact_kalker_values")
    return "\n".join(lines) + "\n"


def bases(x: float) -> np.ndarray:
    """Cubic B-splines over a cell."""
    return (
        np.array([(1 - x) ** 3, 4 + x * x * (3 * x - 6), 1 + 3 * x * (1 + x * (1 - x)), x**3]) / 6
    )


def check(number: int, seed: int) -> int:
    """Compare the splines with the solver in random cases."""
    values = table()
    draw = random.Random(seed)
    worst = 0.0
    for _ in range(number):
        g, nu = math.exp(draw.uniform(0, STEP * (RATIOS - 1))), draw.uniform(0, 0.5)
        chi = draw.uniform(0, math.pi / 2)
        exact = coefficients(math.sqrt(g), 1 / math.sqrt(g), nu, np.array([chi]))[0]
        across = math.sqrt(g) * math.sin(chi)
        place = across / (math.cos(chi) + across) * (DIRECTIONS - 1)
        s = math.log(g) / STEP
        i, j = min(int(s), RATIOS - 2), min(int(place), DIRECTIONS - 2)
        part = np.tensordot(bases(s - i), values[i : i + 4], 1)
        part = np.tensordot(bases(place - j), part[j : j + 4], 1)
        points = poissons()
        found = sum(
            part[k] * np.prod([(nu - q) / (p - q) for q in points if q != p])
            for k, p in enumerate(points)
        )
        scale = (
            np.array([1, 1, 1, 0, 0, 0]) * max(exact[0], exact[2])
            + np.array([0, 0, 0, 1, 1, 0]) * math.sqrt(exact[5] * exact[2])
            + np.array([0, 0, 0, 0, 0, 1]) * exact[5]
        )
        error = abs(found - exact) / scale
        worst = max(worst, error.max())
    print(f"worst {worst:.1e}")
    return int(worst > 2e-3)


def main() -> int:
    """Run the script."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--check", type=int, metavar="N", help="solve N random cases")
    parser.add_argument("--seed", type=int, default=1, help="seed of the random cases")
    words = parser.parse_args()
    if words.check:
        return check(words.check, words.seed)
    TARGET.write_text(written(table()))
    return 0


if __name__ == "__main__":
    sys.exit(main())
