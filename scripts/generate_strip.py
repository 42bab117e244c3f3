"""Generate the table of the reduction by strips, src/contact/creep/strip_values.f90.

With s = 4 tau/(3 pi) and h = sqrt(1 - s^2) the force R of the theory of strips has

    R/tau = (2/pi) (acos s + s^3 (2 + h)/(3 (1 + h)^2)),   dR/dtau = (2/pi) (acos s - s h)

where s < 1. These functions are analytic in s where s^2 < 1/2, in h above. The unit interval of the
one whose square is at most 1/2 is cut into parts, a power of two of them, which have polynomials
about their middle through Chebyshev points.

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

# Parts of the unit interval, and degree of the polynomials: 2.5e-17 at worst.
PARTS = 64
DEGREE = 7

mp.mp.dps = 40


def reductions(s: mp.mpf, h: mp.mpf, angle: mp.mpf) -> tuple[mp.mpf, mp.mpf]:
    """R/tau and dR/dtau."""
    return (
        2 / mp.pi * (angle + s**3 * (2 + h) / (3 * (1 + h) ** 2)),
        2 / mp.pi * (angle - s * h),
    )


def below(s: mp.mpf) -> tuple[mp.mpf, mp.mpf]:
    """The same by s."""
    return reductions(s, mp.sqrt(1 - s * s), mp.acos(s))


def above(h: mp.mpf) -> tuple[mp.mpf, mp.mpf]:
    """The same by h."""
    return reductions(mp.sqrt(1 - h * h), h, mp.asin(h))


def fitted(function, middle: mp.mpf) -> list[tuple[mp.mpf, mp.mpf]]:
    """Coefficients of the polynomials of a part, by powers."""
    number = DEGREE + 1
    half = mp.mpf(1) / (2 * PARTS)
    places = [mp.cos(mp.pi * (2 * k + 1) / (2 * number)) for k in range(number)]
    powers = mp.matrix([[x**j for j in range(number)] for x in places])
    values = [function(middle + half * x) for x in places]
    both = [mp.lu_solve(powers, mp.matrix([v[i] for v in values])) for i in range(2)]
    return [(both[0][j] / half**j, both[1][j] / half**j) for j in range(number)]


def table() -> list[tuple[mp.mpf, list[tuple[mp.mpf, mp.mpf]]]]:
    """Middles and coefficients of all parts: those by s, then those by h."""
    last = int(mp.nint(mp.sqrt(0.5) * PARTS))
    rows = []
    for function in (below, above):
        for j in range(last + 1):
            middle = mp.mpf(j) / PARTS
            rows.append((middle, fitted(function, middle)))
    return rows


def written() -> str:
    """The module."""
    rows = table()
    lines = [
        f"""\
!> Table of the reduction by strips: polynomials by s and by h. Written by
!> scripts/generate_strip.py, which explains them.
module contensou_contact_creep_strip_values
   use contensou_base_kinds, only : wp
   implicit none(type, external)
   private

   !> Parts of the unit interval, degree of the polynomials, and where those by h begin.
   integer, parameter, public :: parts = {PARTS}, degree = {DEGREE}, by_h = {len(rows) // 2}

   !> Of R/tau and dR/dtau: twice the middle of the part, then the coefficients by powers.
   real(wp), protected, public :: reductions(2, -1:degree, 0:2*by_h - 1)
"""
    ]
    for j, (middle, coefficients) in enumerate(rows):
        words = [x for pair in [(middle, middle), *coefficients] for x in pair]
        # Some coefficients vanish but for the rounding of 40 digits.
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
