"""Generate the tables of the Hertz contact, src/contact/hertz_tables.f90.

The shape of a Hertz spot depends on the ratio g = A/B of the curvatures alone. Tabulated are
t(g) = B/K and 1/K(g), where B = (E - c1 K)/c and D = (K - E)/c are complete elliptic integrals of
the parameter c = 1 - c1, and c1 solves g = c1 D/B.

Two tables: the variable of the first is g itself, from 2^-10 to 1, that of the second, for slender
spots, y = -log(g). A binary order of magnitude of the variable is cut into 16 segments, so its
upper bits are the number of the segment. On a segment each function is a polynomial of a low degree
in the distance from the centre, from an interpolation at Chebyshev points.

The last addition shall be the only rounding that counts, so the constant term must be exact. In
the first table the centre is a number near the middle at which both functions happen to be within
1/32 unit in the last place of a double (S. Gal and B. Bachelis, ACM Trans. Math. Software 17 (1991)
26); in the second, where the two functions are nearly the same, the constant term is the sum of two
numbers. The circle g = 1 is a segment of one point.

    generate_hertz.py                     write the tables
    generate_hertz.py --check [--segments N] [--seed S]
                                          regenerate N random segments of each table, or all, and
                                          compare with the file
    generate_hertz.py --points N [--seed S] [--low G]
                                          print contacts with exact results as CSV

Needs mpmath. Exit status 0, or 1 when the file differs.
"""

from __future__ import annotations

import argparse
import random
import re
import struct
import sys
from fractions import Fraction
from pathlib import Path
from typing import NamedTuple

from mpmath import mp, mpf

SOURCE = Path(__file__).resolve().parent.parent / "src" / "contact" / "hertz_tables.f90"

mp.dps = 45  # digits; the worst cancellation, next to the circle, takes eleven
NODES = 26  # of the interpolation
PARTS = 16  # of a binary order of magnitude
BITS = 48  # below the number of the segment in a double
ROWS = 8  # in one declaration
CLOSE = mpf(1) / 32  # of a unit in the last place, at the centres


class Table(NamedTuple):
    """A table, and how it is cut."""

    name: str
    variable: str
    degree: int
    low: Fraction
    high: Fraction
    direct: bool  # whether the variable is g itself; then g = 1 is a segment of its own


TABLES = (
    Table("full", "g = A/B", 8, Fraction(1, 1024), Fraction(1), True),
    # From below -log(2^-10) = 6.93 to above 256 log(2) = 177.4.
    Table("slender", "y = -log(g)", 9, Fraction(27, 4), Fraction(184), False),
)

Bounds = tuple[Fraction, Fraction]


def b_and_d(c1: mpf) -> tuple[mpf, mpf, mpf]:
    """Complete elliptic integrals B, D, K of the complementary parameter c1, by AGM."""
    if c1 == 1:
        return mp.pi / 4, mp.pi / 4, mp.pi / 2
    a, b, c = mpf(1), mp.sqrt(c1), 1 - c1
    total, weight = c / 2, mpf(1)
    while abs(a - b) > mpf(10) ** (-mp.dps + 2) * a:
        difference = (a - b) / 2
        a, b = (a + b) / 2, mp.sqrt(a * b)
        total += weight * difference**2
        weight *= 2
    # One more step of the sum: its terms fall quadratically.
    total += weight * ((a - b) / 2) ** 2
    k = mp.pi / (2 * a)
    e = k * (1 - total)
    return (e - c1 * k) / c, (k - e) / c, k


def solve(g: mpf) -> mpf:
    """Complementary parameter c1 of the spot, g = c1 D/B."""
    if g == 1:
        return mpf(1)

    def excess(log_c1: mpf) -> mpf:
        b, d, _ = b_and_d(mp.exp(log_c1))
        return log_c1 + mp.log(d / b) - mp.log(g)

    # c1 = g^(4/3) near the circle, and 2 g/log(16/g) for slender spots.
    log_g = mp.log(g)
    x0 = log_g * 4 / 3 if log_g > -2 else log_g + mp.log(2 / (mp.log(16) - log_g))
    x1 = x0 * (1 + mpf(1) / 1000)
    f0, f1 = excess(x0), excess(x1)
    for _ in range(60):
        x0, x1 = x1, x1 - f1 * (x1 - x0) / (f1 - f0)
        if abs(x1 - x0) <= mpf(10) ** (-mp.dps * 3 // 5) * abs(x1):
            break
        f0, f1 = f1, excess(x1)
        if f1 == 0 or f1 == f0:
            break
    return mp.exp(x1)


def shape(g: mpf) -> tuple[mpf, mpf]:
    """The two tabulated functions t = B/K and 1/K."""
    b, _, k = b_and_d(solve(g))
    return b / k, 1 / k


def number(x: float) -> int:
    """Number of the segment in which a value of the variable is: its upper bits."""
    return struct.unpack(">q", struct.pack(">d", x))[0] >> BITS


def segments(table: Table) -> list[Bounds]:
    """Bounds of the segments in the order of the table."""
    found = []
    low = table.low
    while low < table.high:
        order = Fraction(1)
        while order * 2 <= low:
            order *= 2
        while order > low:
            order /= 2
        found.append((low, low + order / PARTS))
        low += order / PARTS
    if table.direct:
        found.append((table.high, table.high))
    return found


def powers(values: list[mpf], half: mpf) -> list[mpf]:
    """Coefficients in powers of the distance from the middle, from values at the nodes."""
    n = len(values)
    previous, current = [mpf(1)], [mpf(0), mpf(1)]
    total = [mpf(0)] * n
    for j in range(n):
        terms = (values[i] * mp.cos(mp.pi * j * (i + mpf(1) / 2) / n) for i in range(n))
        weight = mp.fsum(terms) * (1 if j == 0 else 2) / n
        for k, x in enumerate(previous):
            total[k] += weight * x
        following = [mpf(0)] + [2 * x for x in current]
        for k, x in enumerate(previous):
            following[k] -= x
        previous, current = current, following
    return [x / half**k for k, x in enumerate(total)]


def distance_from_double(x: mpf) -> mpf:
    """Distance from the nearest double, in units in the last place."""
    scaled = mp.ldexp(x, 53 - mp.frexp(x)[1])
    return abs(scaled - mp.nint(scaled))


def centre_of(low: mpf, high: mpf, functions: list[list[mpf]]) -> float:
    """A double near the middle at which both functions are close to doubles."""
    middle, step = (low + high) / 2, (high - low) / 2**30
    for i in range(1000000):
        shift = step * ((i + 1) // 2) * (1 if i % 2 else -1)
        if all(
            distance_from_double(f[0] + shift * (f[1] + shift * (f[2] + shift * f[3]))) < CLOSE
            for f in functions
        ):
            return float(middle + shift)
    raise ArithmeticError("no centre found")


def row(table: Table, bounds: Bounds) -> list[float]:
    """Numbers of a segment: its centre and zero, then pairs of coefficients of t and 1/K."""
    low, high = (mpf(x.numerator) / x.denominator for x in bounds)
    if low == high:
        functions = [[x] + [mpf(0)] * table.degree for x in shape(low)]
        centre = float(low)
    else:
        # Cut the series in Chebyshev polynomials of this segment, not that in powers.
        middle, half = (low + high) / 2, (high - low) / 2
        x = [middle + half * mp.cos(mp.pi * (i + mpf(1) / 2) / NODES) for i in range(NODES)]
        values = [shape(node if table.direct else mp.exp(-node)) for node in x]
        whole = [powers([value[f] for value in values], half) for f in range(2)]
        centre = centre_of(low, high, whole) if table.direct else float(middle)
        shift = mpf(centre) - middle
        functions = []
        for f in whole:
            # An interpolant at the fewest nodes that keeps the value at the centre.
            n = table.degree + 1
            nodes = [half * mp.cos(mp.pi * (i + mpf(1) / 2) / n) for i in range(n)]
            at = [mp.polyval(f[::-1], node) for node in nodes]
            short = powers(at, half)
            moved = [
                mp.fsum(
                    mp.binomial(m, k) * short[m] * shift ** (m - k) for m in range(k, len(short))
                )
                for k in range(len(short))
            ]
            moved[0] = mp.polyval(f[::-1], shift)
            functions.append(moved)
    numbers = [centre, 0.0]
    for k in range(table.degree + 1):
        numbers += [float(f[k]) for f in functions]
        if k == 0 and not table.direct:
            numbers += [float(f[0] - mpf(float(f[0]))) for f in functions]
    return numbers


def pairs(table: Table) -> int:
    """Number of pairs of numbers of a segment."""
    return table.degree + (2 if table.direct else 3)


def constant(x: float) -> str:
    """A Fortran constant that is read back as the same number."""
    return f"{x:.16e}_wp"


def joined(items: list[str], per_line: int) -> str:
    """Items of a list over lines that are continued."""
    lines = [", ".join(items[i : i + per_line]) for i in range(0, len(items), per_line)]
    return ", &\n      ".join(lines)


def declarations(table: Table) -> str:
    """Declarations of a table."""
    bounds = segments(table)
    rows = [row(table, pair) for pair in bounds]
    first = number(float(table.low))
    last = first + len(rows) - 1
    text, names = "", []
    order = f"the coefficients of powers 0 to {table.degree} of the distance from it"
    if not table.direct:
        order = f"the constant term, its rest, the coefficients of powers 1 to {table.degree}"
    for start in range(0, len(rows), ROWS):
        numbers = [constant(x) for part in rows[start : start + ROWS] for x in part]
        names.append(f"{table.name}_{start // ROWS + 1:02d}")
        text += f"""\
   !> Segments from {table.variable[0]} = {float(bounds[start][0])!r}.
   real(wp), parameter :: {names[-1]}({len(numbers)}) = [ &
      {joined(numbers, 3)}]

"""
    return f"""\
   !> Number of the first segment over {table.variable}.
   integer, parameter :: {table.name}_first = {first}

   !> Number of the last segment over {table.variable}.
   integer, parameter :: {table.name}_last = {last}

{text}   !> Table over {table.variable}: the centre and zero; then for t and 1/K
   !> {order}.
   real(wp), parameter :: {table.name}_table(2, 0:{pairs(table) - 1}, &
      {table.name}_first:{table.name}_last) = reshape([ &
      {joined(names, 6)}], &
      [2, {pairs(table)}, {table.name}_last - {table.name}_first + 1])
"""


def source() -> str:
    """The module."""
    public = [f"{table.name}_{what}" for table in TABLES for what in ("table", "first", "last")]
    return f"""\
!> Tables of the Hertz contact: t = B/K and 1/K over g = A/B and, for slender spots, over
!> y = -log(g). Written by scripts/generate_hertz.py, which explains them.
!>
!> The number of a segment is what its values have in common, the bits above the lower {BITS}.
module contensou_contact_hertz_tables
   use contensou_base_kinds, only : wp
   implicit none(type, external)
   private

   public :: {", ".join(public)}
   public :: segment_bits, full_low

   !> Bits of a variable below the number of its segment.
   integer, parameter :: segment_bits = {BITS}

   !> Lowest g of its table [-].
   real(wp), parameter :: full_low = {constant(float(TABLES[0].low))}

{chr(10).join(declarations(table) for table in TABLES)}
end module contensou_contact_hertz_tables
"""


def check(count: int | None, seed: int) -> int:
    """Compare regenerated segments with the file; print what differs."""
    text = SOURCE.read_text(encoding="utf-8")
    if count is None:
        if text == source():
            return 0
        print(f"{SOURCE}: differs from what is generated")
        return 1
    status = 0
    draw = random.Random(seed)
    for table in TABLES:
        stored: list[str] = []
        for found in re.finditer(rf":: {table.name}_\d+\(\d+\) = \[ &\n(.*?)\]", text, re.DOTALL):
            stored += [x.strip(" &\n") for x in found[1].split(",")]
        bounds = segments(table)
        width = 2 * pairs(table)
        if len(stored) != width * len(bounds):
            print(f"{SOURCE}: {len(stored)} numbers instead of {width * len(bounds)}")
            return 1
        for i in sorted(draw.sample(range(len(bounds)), min(count, len(bounds)))):
            if stored[width * i : width * (i + 1)] != [constant(x) for x in row(table, bounds[i])]:
                print(
                    f"{SOURCE}: segment {i + 1} of {table.variable} differs from what is generated"
                )
                status = 1
    return status


def points(count: int, seed: int, low: float) -> None:
    """Print random contacts with exact results."""
    draw = random.Random(seed)
    print("A,B,Estar,delta,g,c,c1,a,b,N,p0,t,inverse_k")
    for i in range(count):
        upper = 10.0 ** draw.uniform(-2, 5)
        kind = i % 4
        if kind == 0:  # any decade
            ratio = low ** draw.random()
        elif kind == 1:  # the usual range
            ratio = 1e-3 ** draw.random()
        elif kind == 2:  # uniform
            ratio = draw.random()
        else:  # next to the circle
            ratio = 1 - 10.0 ** draw.uniform(-16, -0.5)
        lower = max(min(ratio * upper, upper), low * upper * (1 + 1e-15))
        modulus = 10.0 ** draw.uniform(5, 12)
        approach = 10.0 ** draw.uniform(-10, -3)
        # Next to the circle two extra digits for each that cancels.
        with mp.workdps(mp.dps + 30):
            g = mpf(lower) / mpf(upper)
            c1 = solve(g)
            b, _, k = b_and_d(c1)
            t = b / k
            a_axis = mp.sqrt((1 - t) * mpf(approach) / mpf(lower))
            b_axis = mp.sqrt(t * mpf(approach) / mpf(upper))
            force = 2 * mp.pi / 3 * mpf(modulus) * a_axis * mpf(approach) / k
            pressure = 3 * force / (2 * mp.pi * a_axis * b_axis)
            exact = [g, 1 - c1, c1, a_axis, b_axis, force, pressure, t, 1 / k]
            row = [repr(x) for x in (lower, upper, modulus, approach)]
            row += [mp.nstr(x, 24, strip_zeros=False) for x in exact]
        print(",".join(row))


def main() -> int:
    """Do what the command line says."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--check", action="store_true", help="compare with the file")
    parser.add_argument("--segments", type=int, help="number of segments to compare")
    parser.add_argument("--points", type=int, help="number of contacts to print")
    parser.add_argument("--seed", type=int, default=1, help="of the choice")
    parser.add_argument("--low", type=float, default=1e-20, help="lowest g of the contacts")
    arguments = parser.parse_args()
    if arguments.points:
        points(arguments.points, arguments.seed, arguments.low)
        return 0
    if arguments.check:
        return check(arguments.segments, arguments.seed)
    SOURCE.write_text(source(), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
