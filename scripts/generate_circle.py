"""Generate the table of sliding of circular spots, src/contact/tangential/circle_values.f90.

What slides and spins with tau = W/v < 1 has, with the hypergeometric function
G(y) = F(1/2, 3/2; 7/2; y), y = tau^2, and its derivative G', the force and the torque

    f = (1 - 2 y/5) G + (2/5) y (1 - y) G'        in units of f N
    t = tau [(1 - y/4) G + y (1 - y) G'/2]/5      in units of f N a

and dt/dtau = G/5. Both are analytic in c = sqrt(1 - y) down to c = 0. The interval from 0 to 1 is
cut into parts, a power of two of them, which have polynomials about their middle through Chebyshev
points.

    generate_circle.py            write the table, in seconds
    generate_circle.py --check    compute the table and compare it with the file

Needs mpmath. Exit status 0, or 1 when the check finds a difference.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import mpmath as mp

TARGET = Path(__file__).resolve().parent.parent / "src" / "contact" / "tangential"
TARGET /= "circle_values.f90"

# Parts of the unit interval, and degree of the polynomials: 2e-17 at worst.
PARTS = 64
DEGREE = 7

mp.mp.dps = 40


def functions(c: mp.mpf) -> tuple[mp.mpf, mp.mpf]:
    """G and G' for y from 0 to 1, and what they go on with beyond."""
    y = 1 - c * c
    if abs(y) < mp.mpf("1e-3"):
        return (
            mp.hyp2f1(0.5, 1.5, 3.5, y),
            mp.mpf(3) / 14 * mp.hyp2f1(1.5, 2.5, 4.5, y),
        )
    # Integrals of even powers of the sine up to theta, sin theta = tau.
    theta = mp.acos(c)
    tau = mp.sqrt(y) if y > 0 else mp.mpc(0, mp.sqrt(-y))
    m1 = (theta - tau * c) / 2
    i1 = theta - m1
    i2 = m1 - (3 * m1 - tau**3 * c) / 4
    g = 7.5 * (i1 * y - 3 * i2) / (y**2 * tau)
    slope = 3.75 * (15 * i2 / y - 3 * i1 - 2 * tau * c) / (y**2 * tau)
    return mp.re(g), mp.re(slope)


def fitted(middle: mp.mpf) -> list[tuple[mp.mpf, mp.mpf]]:
    """Coefficients of the polynomials of a part, by powers."""
    number = DEGREE + 1
    half = mp.mpf(1) / (2 * PARTS)
    places = [mp.cos(mp.pi * (2 * k + 1) / (2 * number)) for k in range(number)]
    powers = mp.matrix([[x**j for j in range(number)] for x in places])
    values = [functions(middle + half * x) for x in places]
    both = [mp.lu_solve(powers, mp.matrix([v[i] for v in values])) for i in range(2)]
    return [(both[0][j] / half**j, both[1][j] / half**j) for j in range(number)]


def written() -> str:
    """The module."""
    lines = [
        f"""\
!> Table of sliding of circular spots: polynomials by c. Written by
!> scripts/generate_circle.py, which explains them.
module contensou_contact_tangential_circle_values
   use contensou_base_kinds, only : wp
   implicit none(type, external)
   private

   !> Parts of the unit interval, and degree of the polynomials.
   integer, parameter, public :: parts = {PARTS}, degree = {DEGREE}

   !> Of G and G', by powers of the distance to the middle j/parts.
   real(wp), protected, public :: values(2, 0:degree, 0:parts)
"""
    ]
    for j in range(PARTS + 1):
        words = [x for pair in fitted(mp.mpf(j) / PARTS) for x in pair]
        texts = [f"{float(x):.16e}_wp" for x in words]
        lines.append(f"   data values(:, :, {j}) / &")
        lines += [
            "      " + ", ".join(texts[at : at + 3]) + (", &" if at + 3 < len(texts) else "/")
            for at in range(0, len(texts), 3)
        ]
    lines.append("\nend module contensou_contact_tangential_circle_values")
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
