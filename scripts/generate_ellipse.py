"""Generate the table of sliding of elliptic spots, src/contact/tangential/ellipse_values.f90.

With the axis ratio k, W = 1, A = 1 + s, B = k^2 + s, S = sqrt(s)/sqrt(A B), rho^2 the s at which
integrals begin, and A, B and S there as well, the two functions

    f_b = (sqrt(k) + rho) [B^2 J_bb - (2/3) s S],   J_bb = int S/B^2 ds
    f_a = (sqrt(k) + rho) [A B J_ab - (2/3) s S],   J_ab = int S/(A B) ds

give the wrench and its derivatives, see src/contact/tangential/ellipse_pass.f90. Both are analytic
in x = rho/(sqrt(k) + rho) from 0 to 1, that is for all rho, and in ln k. Each interval is cut into
parts, which have polynomials through Chebyshev points. The integrals are those of Carlson.

    generate_ellipse.py            write the table, in half a minute
    generate_ellipse.py --check    compute the table and compare it with the file

Needs mpmath. Exit status 0, or 1 when the check finds a difference.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import mpmath as mp

TARGET = Path(__file__).resolve().parent.parent / "src" / "contact" / "tangential"
TARGET /= "ellipse_values.f90"

# Parts of the interval of x and degree there.
PARTS = 8
DEGREE = 15

# Least axis ratio, parts of the interval of ln k, and of points there.
LEAST = "0.1"
BANDS = 2
NUMBER = 21

# Powers of x that are held side by side.
GROUP = 4

# Terms below this are left out, and the places of digits.
ZERO = mp.mpf(0)
SMALLEST = mp.mpf("4e-18")
PLACES = 20

COLUMNS = 98

mp.mp.dps = 40


def functions(x: mp.mpf, k: mp.mpf) -> tuple[mp.mpf, mp.mpf]:
    """f_b and f_a for x and k from 0 to 1, both open."""
    scale = mp.sqrt(k) / (1 - x)
    s = (scale * x) ** 2
    a = 1 + s
    b = k * k + s
    end = mp.sqrt(s / (a * b)) * s
    # Of 1/A, 1/B and 1 over sqrt(s A B).
    by_a = mp.elliprd(s, b, a) * 2 / 3
    by_b = mp.elliprd(s, a, b) * 2 / 3
    j_ab = (by_a - k * k * by_b) / (1 - k * k)
    j_b = 2 * mp.elliprf(s, a, b) - k * k * by_b
    j_bb = (j_b - j_ab - 2 * end / b) / (3 * k * k)
    return scale * (b * b * j_bb - 2 * end / 3), scale * (a * b * j_ab - 2 * end / 3)


def chebyshev_points(number: int) -> list[mp.mpf]:
    """Chebyshev points between -1 and 1."""
    return [mp.cos(mp.pi * (2 * i + 1) / (2 * number)) for i in range(number)]


def to_powers(number: int) -> mp.matrix:
    """What gives the coefficients by powers of a polynomial with given values at these points."""
    return mp.inverse(mp.matrix([[x**j for j in range(number)] for x in chebyshev_points(number)]))


def fitted(band: int, part: int) -> list[mp.matrix]:
    """Coefficients of both functions by powers of x, at Chebyshev points of ln k, each from -1 to 1
    in its part."""
    half = -mp.log(mp.mpf(LEAST)) / (2 * BANDS)
    values = [
        [
            functions((part + (1 + x) / 2) / PARTS, mp.exp(half * (y - 2 * band - 1)))
            for y in chebyshev_points(NUMBER)
        ]
        for x in chebyshev_points(DEGREE + 1)
    ]
    powers = to_powers(DEGREE + 1)
    return [powers * mp.matrix([[v[i] for v in row] for row in values]) for i in range(2)]


def chebyshev_polynomials() -> list[list[int]]:
    """Coefficients of the Chebyshev polynomials by powers."""
    found = [[1, *[0] * NUMBER], [0, 1, *[0] * (NUMBER - 1)]]
    for _ in range(2, NUMBER):
        found.append([2 * x - y for x, y in zip([0, *found[-1]], found[-2], strict=False)])
    return found


POLYNOMIALS = chebyshev_polynomials()


def by_ratio(values: list[list[mp.mpf]]) -> list[list[mp.mpf]]:
    """Coefficients by powers of ln k of what has some values at the Chebyshev points, a polynomial
    of as low a degree as does for all."""
    waves = [
        [mp.cos(mp.pi * j * (2 * i + 1) / (2 * NUMBER)) for i in range(NUMBER)]
        for j in range(NUMBER)
    ]
    terms = [
        [mp.fdot(row, waves[j]) * (2 - (j == 0)) / NUMBER for j in range(NUMBER)] for row in values
    ]
    degree = max(j for row in terms for j in range(NUMBER) if j == 0 or abs(row[j]) > SMALLEST)
    return [
        [sum(row[j] * POLYNOMIALS[j][i] for j in range(i, degree + 1)) for i in range(degree + 1)]
        for row in terms
    ]


def text_of(x: mp.mpf) -> str:
    """A number with no more digits than count."""
    if not x:
        return "0.0_wp"
    size = int(mp.floor(mp.log10(abs(x))))
    return f"{float(x):.{min(max(PLACES + size, 0), 16)}e}_wp"


def wrapped(words: list[str], start: str, end: str) -> list[str]:
    """Lines of words with commas."""
    lines, line = [], start
    for i, word in enumerate(words):
        piece = word + (end if i == len(words) - 1 else ", ")
        if len(line) + len(piece) > COLUMNS:
            lines.append(line.rstrip() + " &")
            line = " " * 6
        line += piece
    return [*lines, line]


def written() -> str:
    """The module."""
    counts, blocks = [], []
    for band in range(BANDS):
        for part in range(PARTS):
            both = fitted(band, part)
            rows = [by_ratio([list(one[i, :]) for one in both]) for i in range(DEGREE + 1)]
            # As many powers of ln k as any power of x in the group has, in pairs.
            lengths = [
                2 * ((max(len(rows[i][0]) for i in range(g, g + GROUP)) + 1) // 2)
                for g in range(0, DEGREE + 1, GROUP)
            ]
            blocks.append(
                [
                    text_of(rows[GROUP * g + i][f][j] if j < len(rows[GROUP * g + i][0]) else ZERO)
                    for g, length in enumerate(lengths)
                    for j in range(length - 1, -1, -1)
                    for i in range(GROUP)
                    for f in range(2)
                ]
            )
            counts.append(lengths)
    lines = [
        f"""\
!> Table of sliding of elliptic spots: polynomials by x, with polynomials by ln k as coefficients.
!> Written by scripts/generate_ellipse.py, which explains them.
module contensou_contact_tangential_ellipse_values
   use contensou_base_kinds, only : wp
   implicit none(type, external)
   private

   !> Least axis ratio.
   real(wp), parameter, public :: least_ratio = {LEAST}_wp

   !> Parts of the interval of x, from 0 to 1, and degree of the polynomials.
   integer, parameter, public :: parts = {PARTS}, degree = {DEGREE}

   !> Parts of the interval of ln k, from zero to that of the least ratio.
   integer, parameter, public :: bands = {BANDS}
"""
    ]
    width = 2 * GROUP
    total = sum(len(block) for block in blocks) // width
    lines.append(f"""\
   !> Numbers side by side: some powers of x of f_b and f_a.
   integer, parameter, public :: width = {width}

   !> Number of powers of ln k, even, of each group of powers of x.
   integer, protected, public :: lengths(0:{(DEGREE + 1) // GROUP - 1}, 0:parts - 1, 0:bands - 1)

   !> Where the values of a part begin.
   integer, protected, public :: first(0:parts - 1, 0:bands - 1)

   !> For each part the groups of powers of x, from the lowest on, each by powers of ln k from the
   !> highest one down, each with those of x, each of f_b and f_a. Variables go from -1 to 1 in
   !> their part.
   real(wp), protected, public :: values(width, {total})
""")
    at = 1
    for i, block in enumerate(blocks):
        place = f"{i % PARTS}, {i // PARTS}"
        words = [str(d) for d in counts[i]]
        lines += wrapped(words, f"   data lengths(:, {place}) / ", "/")
        lines.append(f"   data first({place}) / {at}/")
        end = at + len(block) // width
        lines += wrapped(block, f"   data values(:, {at}:{end - 1}) / ", "/")
        at = end
    lines.append("\nend module contensou_contact_tangential_ellipse_values")
    return "\n".join(lines) + "\n"


def main() -> int:
    """Write the table or check it."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--check", action="store_true", help="compare with the file")
    chosen = parser.parse_args()
    text = written()
    if chosen.check:
        same = TARGET.read_text(encoding="utf-8") == text
        print("the table is what is generated" if same else f"{TARGET} differs")
        return int(not same)
    TARGET.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
