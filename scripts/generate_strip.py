"""Generate the table of the reduction by strips, src/contact/creep/strip_values.f90.

With s = 4 tau/(3 pi) and h = sqrt(1 - s^2) the force R of the theory of strips has

    R/tau = (2/pi) (acos s + s^3 (2 + h)/(3 (1 + h)^2)),   dR/dtau = (2/pi) (acos s - s h)

where s < 1, and 1/tau and 0 from there on. As acos s = pi/2 - asin s = asin h, they are

    1 - (2/pi) s (asin s/s - s^2 (2 + h)/(3 (1 + h)^2)),   1 - (2/pi) s (asin s/s + h)
    1/tau - (2/pi) h ((3 - h^2)/(3 s) - asin h/h),         (2/pi) h (asin h/h - s)

where what s or h multiplies is analytic in s^2, in the first line but for s = 1, in the second but
for s = 0. So the unit interval of s^2 is cut into parts, a power of two of them, rounded to which
s^2 has the same number; the first line serves where that is less than FIRST, the second from there
on. Each has polynomials about its middle through Chebyshev points.

    generate_strip.py            write the table, in seconds
    generate_strip.py --check    compute the table and compare it with the file

Needs mpmath. Exit status 0, or 1 when the check finds a difference.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import mpmath as mp

TARGET = Path(__file__).resolve().parent.parent / "src" / "contact" / "creep" / "strip_values.f90"

mp.mp.dps = 60

# Parts of the unit interval, degree of the polynomials, and the first part by h: 2.1e-17 of R/tau
# and 1.8e-17 of dR/dtau at worst.
PARTS = 64
DEGREE = 6
FIRST = 44

# Where the parts by h begin.
SPLIT = (mp.mpf(FIRST) - 0.5) / PARTS


def below(square: mp.mpf) -> tuple[mp.mpf, mp.mpf]:
    """What the root multiplies where that is s sqrt(1/SPLIT - 1), by s^2 != 0."""
    s = mp.sqrt(mp.mpc(square))
    h = mp.sqrt(1 - square)
    arc = mp.asin(s) / s
    factor = -1.5 / mp.sqrt(1 / SPLIT - 1)
    return (
        factor * mp.re(arc - square * (2 + h) / (3 * (1 + h) ** 2)),
        factor * mp.re(arc + h),
    )


def above(square: mp.mpf) -> tuple[mp.mpf, mp.mpf]:
    """The same where it is h, by s^2 != 1."""
    s = mp.sqrt(square)
    h = mp.sqrt(mp.mpc(1 - square))
    arc = mp.asin(h) / h
    return 1.5 * mp.re(arc - (3 - h * h) / (3 * s)), 1.5 * mp.re(arc - s)


def fitted(function, middle: mp.mpf) -> list[tuple[mp.mpf, mp.mpf]]:
    """Coefficients of the polynomials of a part, by powers."""
    number = DEGREE + 1
    half = mp.mpf(1) / (2 * PARTS)
    places = [mp.cos(mp.pi * (2 * k + 1) / (2 * number)) for k in range(number)]
    powers = mp.matrix([[x**j for j in range(number)] for x in places])
    # Not the middle of the first part and that of the last, where 0/0 is to be found.
    values = [function(middle + half * (x + mp.mpf("1e-50"))) for x in places]
    both = [mp.lu_solve(powers, mp.matrix([v[i] for v in values])) for i in range(2)]
    return [(both[0][j] / half**j, both[1][j] / half**j) for j in range(number)]


def table() -> list[list[tuple[mp.mpf, mp.mpf]]]:
    """What is added to the product and coefficients, of all parts."""
    one = 3 * mp.pi / 4
    rows = []
    for j in range(PARTS + 1):
        middle = mp.mpf(j) / PARTS
        if j < FIRST:
            rows.append([(one - 1 / mp.sqrt(SPLIT), one), *fitted(below, middle)])
        else:
            rows.append([(mp.mpf(0), mp.mpf(0)), *fitted(above, middle)])
    return rows


def written() -> str:
    """The module."""
    rows = table()
    lines = [
        f"""\
!> Table of the reduction by strips: polynomials by s^2. Written by scripts/generate_strip.py, which
!> explains them.
module contensou_contact_creep_strip_values
   use contensou_base_kinds, only : wp
   implicit none(type, external)
   private

   !> Parts of the unit interval and degree of the polynomials.
   integer, parameter, public :: parts = {PARTS}, degree = {DEGREE}

   !> s^2 from where h is the root.
   real(wp), parameter, public :: split = {float(SPLIT)!r}_wp

   !> Of R/s - 1/max(s, sqrt(split)) and (dR/dtau) tau/s: what has no root, then the coefficients of
   !> what the root multiplies.
   real(wp), protected, public :: reductions(2, -1:degree, 0:parts)
"""
    ]
    for j, row in enumerate(rows):
        words = [x for pair in row for x in pair]
        # Some coefficients vanish but for the rounding of 60 digits.
        texts = [f"{float(x) if abs(x) > 1e-25 else 0.0:.16e}_wp" for x in words]
        lines.append(f"   data reductions(:, :, {j}) / &")
        lines += [
            "      " + ", ".join(texts[at : at + 3]) + (", &" if at + 3 < len(texts) else "/")
            for at in range(0, len(texts), 3)
        ]
    lines.append("\nend module contensou_contact_creep_strip_values")
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
