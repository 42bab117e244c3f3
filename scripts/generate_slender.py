"""Generate the table of chords of a slender spot, src/contact/wrench_slender_values.f90.

Where a chord of a curved spot is flat the slip is a + b t on it, with complex a and b and t from -1
to 1. In units of |b|, with b along the real axis and a = xi + i eta, the means over the chord with
the weight w = (2/pi) sqrt(1 - t^2) are functions of xi and eta alone, r = |a + t|:

    P = int w (xi + t)/r dt,  H = int w eta/r dt,  Q = int w t (xi + t)/r dt,  R = int w t eta/r dt.

In elliptic coordinates xi = C N, eta = sqrt(C^2 - 1) S, C >= 1, N^2 + S^2 = 1, the functions

    P/N,  H/S,  C Q,  C R/(N S)

are smooth in S and, but for the chord itself, C = 1, in u = (1 - 1/C)^(1/4). They are fitted by
splines of degree 2 in both on uniform intervals of (0, 1).

    generate_slender.py                  write the table, in seconds
    generate_slender.py --check [--points N] [--seed S]
                                         compute the table and compare it with the file, and the
                                         functions from it with their definitions at N points

Needs numpy. Exit status 0, or 1 when the check finds more than its bounds.
"""

from __future__ import annotations

import argparse
import re
import sys
from pathlib import Path

import numpy as np

TARGET = Path(__file__).resolve().parent.parent / "src" / "contact" / "wrench_slender_values.f90"

# Intervals in u and in S, and points of an interval at which the splines are fitted.
INTERVALS = (24, 12)
POINTS = 3

# Decimals of the coefficients.
DECIMALS = 10

# Largest difference of a coefficient from the file, and of a mean from its definition; the latter
# is met next to the chord alone, elsewhere it is less by two orders of magnitude.
SAME = 3e-10
CLOSE, CLOSE_MEDIAN = 1e-3, 3e-6

# Rule of the chord's parts on both sides of t = -xi: tanh-sinh.
STEPS = 4.0 / 80 * np.arange(-80, 81)
NODES = np.tanh(np.pi / 2 * np.sinh(STEPS))
WEIGHTS = 4.0 / 80 * np.pi / 2 * np.cosh(STEPS) / np.cosh(np.pi / 2 * np.sinh(STEPS)) ** 2


def means(xi: np.ndarray, eta: np.ndarray) -> np.ndarray:
    """P, H, Q and R by their definitions."""
    total = np.zeros((4, *xi.shape))
    cut = np.clip(-xi, -1, 1)
    for low, high in ((-np.ones_like(cut), cut), (cut, np.ones_like(cut))):
        half = 0.5 * (high - low)[..., None]
        t = low[..., None] + half * (1 + NODES)
        weight = half * WEIGHTS * 2 / np.pi * np.sqrt(np.maximum((1 - t) * (1 + t), 0))
        along, across = t + xi[..., None], eta[..., None] + 0 * t
        weight = weight / np.maximum(np.hypot(along, across), 1e-300)
        for k, part in enumerate((along, across, t * along, t * across)):
            total[k] += (weight * part).sum(axis=-1)
    return total


def coordinates(u: np.ndarray, s: np.ndarray) -> tuple[np.ndarray, ...]:
    """C, N, xi and eta."""
    c = 1 / (1 - u**4)
    n = np.sqrt((1 - s) * (1 + s))
    return c, n, c * n, np.sqrt((c - 1) * (c + 1)) * s


def functions(u: np.ndarray, s: np.ndarray) -> np.ndarray:
    """What is tabulated."""
    c, n, xi, eta = coordinates(u, s)
    p, h, q, r = means(xi, eta)
    return np.array([p / n, h / s, c * q, c * r / (n * s)])


def basis(x: np.ndarray, n: int) -> np.ndarray:
    """Splines of degree 2 on n intervals of (0, 1): values by point and spline."""
    place = np.clip(x, 0, 1) * n
    first = np.minimum(place.astype(int), n - 1)
    t = place - first
    values = np.zeros((len(x), n + 2))
    rows = np.arange(len(x))
    values[rows, first] = (1 - t) ** 2 / 2
    values[rows, first + 1] = 0.5 + t * (1 - t)
    values[rows, first + 2] = t**2 / 2
    return values


def coefficients() -> np.ndarray:
    """Coefficients by function, spline in u and spline in S."""
    gauss = 0.5 * (1 + np.polynomial.legendre.leggauss(POINTS)[0])
    u, s = (((np.arange(n)[:, None] + gauss) / n).ravel() for n in INTERVALS)
    values = functions(*np.meshgrid(u, s, indexing="ij"))
    left, right = (np.linalg.pinv(basis(x, n)) for x, n in zip((u, s), INTERVALS, strict=True))
    return np.array([left @ part @ right.T for part in values])


def written(table: np.ndarray) -> str:
    """The module with the table."""
    lines = [
        "!> Table of the chords of a slender spot: coefficients of splines. Written by",
        "!> scripts/generate_slender.py, which explains them.",
        "module contensou_contact_wrench_slender_values",
        "   use contensou_base_kinds, only : wp",
        "   implicit none(type, external)",
        "   private",
        "",
        "   !> Intervals in u and in S.",
        f"   integer, parameter, public :: n_u = {INTERVALS[0]}, n_s = {INTERVALS[1]}",
        "",
        "   !> Coefficients by function (P/N, H/S, C Q, C R/(N S)), spline in S and in u.",
        "   real(wp), protected, public :: splines(4, n_s + 2, n_u + 2)",
    ]
    for i in range(table.shape[1]):
        numbers = [f"{x:.{DECIMALS}f}_wp" for x in table[:, i, :].T.ravel()]
        lines += ["", f"   data splines(:, :, {i + 1}) / &"]
        for j in range(0, len(numbers), 4):
            end = ", &" if j + 4 < len(numbers) else " /"
            lines.append("      " + ", ".join(numbers[j : j + 4]) + end)
    return "\n".join([*lines, "", "end module contensou_contact_wrench_slender_values", ""])


def read() -> np.ndarray:
    """The table of the file."""
    numbers = re.findall(r"-?\d+\.\d+(?=_wp)", TARGET.read_text(encoding="utf-8"))
    shape = (INTERVALS[0] + 2, INTERVALS[1] + 2, 4)
    if len(numbers) != np.prod(shape):
        sys.exit(f"{TARGET} has no table of {' x '.join(map(str, shape))} numbers")
    return np.array(numbers, dtype=float).reshape(shape).transpose(2, 0, 1)


def check(points: int, seed: int) -> int:
    """Compare the file with its definition."""
    table = read()
    apart = abs(table - coefficients()).max()
    random = np.random.default_rng(seed)
    u, s = random.uniform(1e-3, 0.999, (2, points))
    c, n, xi, eta = coordinates(u, s)
    rows, columns = (basis(x, m) for x, m in zip((u, s), INTERVALS, strict=True))
    found = np.einsum("pi,fij,pj->fp", rows, table, columns)
    found *= np.array([n, s, 1 / c, n * s / c])
    errors = abs(found - means(xi, eta))
    print(f"coefficients: {apart:.1e}; means: {np.median(errors):.1e}, largest {errors.max():.1e}")
    if apart > SAME or errors.max() > CLOSE or np.median(errors) > CLOSE_MEDIAN:
        print(f"{TARGET} differs from what it is to be")
        return 1
    return 0


def main() -> int:
    """Write the table or check it."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--check", action="store_true", help="compare with the file")
    parser.add_argument("--points", type=int, default=2000, help="random points of the check")
    parser.add_argument("--seed", type=int, default=1, help="their seed")
    words = parser.parse_args()
    if words.check:
        return check(words.points, words.seed)
    TARGET.write_text(written(coefficients()), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
