"""Compute the coefficients of the complete elliptic integrals B and D; write them as Fortran.

B and D of the complement c1 are analytic except at c1 = 0, where D grows like -log(c1)/2.

* 2^-60 < c1 <= 1: each binade is cut into 8 intervals, and in each B and D are polynomials of
  degree 10 in t = c1 - centre, which is exact. They interpolate (f(c1) - f(centre))/t at the
  Chebyshev points. The centre is moved a little from the middle to a number where B and D are both
  doubles to 1/100 of their last place (S. Gal, 1986), so that the largest coefficient carries no
  rounding error; for small c1, where B = 1 - c1 (log(4/sqrt(c1)) - 3/2)/2 hardly varies, only D. In
  the last interval the centre is 1, where B = D = pi/4.
* c1 <= 2^-60: B = 1 and D = log(4/sqrt(c1)) - 1 (DLMF 19.12.1 and 19.12.2). For c1 = 2^e m,
  D = -(e/2) log 2 + g(m); g is a polynomial of degree 6 in m - centre in each of 64 intervals, and
  the centre is such that g there is a multiple of 2^-42, as is the leading part of log 2, so that
  their sum is exact.

    generate_elliptic.py [--check] [FILE]

Writes FILE (src/special/elliptic_tables.f90 of the project if not given). With --check it compares
instead; exit status 1 if the file differs. Takes some seconds; the result is the same everywhere.
"""

import sys
import textwrap
from pathlib import Path

from mpmath import cos, ellipe, ellipk, exp, floor, ln, log, mp, mpf, nint, pi, sqrt

mp.dps = 60

# Intervals to a binade, binades, degree of the polynomials.
PARTS = 8
BINADES = 60
DEGREE = 10
# Intervals of m and degree of g.
LOG_PARTS = 64
LOG_DEGREE = 6
# Quantum of the leading parts of log 2 and g.
QUANTUM = mpf(2) ** -42
# Bits behind the last place in the search for centres.
FRACTION = 90

FILE = Path(__file__).resolve().parent.parent / "src" / "special" / "elliptic_tables.f90"


def integrals(c1: mpf) -> tuple[mpf, mpf]:
    """B and D by their definitions; 60 digits leave enough where they cancel."""
    if c1 == 1:
        return pi / 4, pi / 4
    c = 1 - c1
    k, e = ellipk(c), ellipe(c)
    return (e - c1 * k) / c, (k - e) / c


def chebyshev_points(low: mpf, high: mpf, n: int) -> list[mpf]:
    """Zeros of the Chebyshev polynomial of degree n on an interval."""
    middle, half = (low + high) / 2, (high - low) / 2
    return [middle + half * cos((2 * i + 1) * pi / (2 * n)) for i in range(n)]


def interpolate(x: list[mpf], y: list[mpf]) -> list[mpf]:
    """Coefficients, from the constant one on, of the polynomial through some points."""
    n = len(x)
    divided = list(y)
    for k in range(1, n):
        for i in range(n - 1, k - 1, -1):
            divided[i] = (divided[i] - divided[i - 1]) / (x[i] - x[i - k])
    coefficients = [divided[-1]] + [mpf(0)] * (n - 1)
    for i in range(n - 2, -1, -1):
        for k in range(n - 1, 0, -1):
            coefficients[k] = coefficients[k - 1] - x[i] * coefficients[k]
        coefficients[0] = divided[i] - x[i] * coefficients[0]
    return coefficients


def around(f, degree: int, centre: mpf, low: mpf, high: mpf) -> list[list[mpf]]:
    """Coefficients 1 to degree, in t = x - centre, of the components of f on an interval."""
    x = [point - centre for point in chebyshev_points(low, high, degree)]
    at_centre = f(centre)
    at_x = [f(centre + t) for t in x]
    return [
        interpolate(x, [(values[i] - start) / t for t, values in zip(x, at_x, strict=True)])
        for i, start in enumerate(at_centre)
    ]


def last_place(value: mpf) -> mpf:
    """Unit in the last place of the double next to a number."""
    return mpf(2) ** (floor(log(value, 2)) - 52)


def exact_centre(low: mpf, high: mpf) -> mpf:
    """Number near the middle of an interval where B (if it varies enough) and D are doubles."""
    middle = (low + high) / 2
    # Steps so small that three terms of the series give B and D to 20 digits. Integers for speed:
    # in units of the last place, the fraction of value + i (slope + i curvature) has FRACTION bits.
    step = last_place(middle) * 2**19
    series = []
    slopes = around(integrals, DEGREE, middle, low, high)
    for value, (slope, curvature, *_) in zip(integrals(middle), slopes, strict=True):
        unit = last_place(value) / mpf(2) ** FRACTION
        terms = (value / unit, slope * step / unit, curvature * step**2 / unit)
        series.append(tuple(int(nint(term)) for term in terms))
    (b, b_1, b_2), (d, d_1, d_2) = series
    one = 1 << FRACTION
    near = one // 100
    found = []
    for i in range(10000):
        if (d + i * (d_1 + i * d_2) + near) % one <= 2 * near:
            b_error = (b + i * (b_1 + i * b_2)) % one
            found.append((min(b_error, one - b_error), i))
            if found[-1][0] <= near:
                break
    centre = middle + min(found)[1] * step
    d_places = integrals(centre)[1] / last_place(integrals(centre)[1])
    assert abs(d_places - nint(d_places)) < 0.011
    return centre


def main_table() -> list[list[float]]:
    """A row for each interval, with c1 growing: centre twice, then (B, D) for each power of t."""
    rows = []
    for binade in range(-BINADES, 0):
        for part in range(PARTS):
            low = mpf(2) ** binade * (1 + mpf(part) / PARTS)
            high = mpf(2) ** binade * (1 + mpf(part + 1) / PARTS)
            centre = mpf(1) if high == 1 else exact_centre(low, high)
            b, d = integrals(centre)
            b_slopes, d_slopes = around(integrals, DEGREE, centre, low, high)
            row = [centre, centre, b, d]
            for pair in zip(b_slopes, d_slopes, strict=True):
                row += pair
            rows.append([float(value) for value in row])
    return rows


def logarithm(m: mpf) -> tuple[mpf]:
    """g = log(4/sqrt(m)) - 1."""
    return (ln(4 / sqrt(m)) - 1,)


def logarithm_table() -> list[list[float]]:
    """A row for each interval of m from 1 to 2: centre, then the coefficients of g."""
    rows = []
    for part in range(LOG_PARTS):
        low, high = 1 + mpf(part) / LOG_PARTS, 1 + mpf(part + 1) / LOG_PARTS
        # Not at the middle, where a step of one quantum moves m by nearly a whole number of places.
        value = nint(logarithm(low + mpf("0.487") * (high - low))[0] / QUANTUM)
        while True:
            centre = exp(2 * (ln(4) - 1 - value * QUANTUM))
            rounded = nint(centre * mpf(2) ** 52) / mpf(2) ** 52
            if abs(centre - rounded) < mpf(2) ** -60:
                break
            value += 1
        row = [rounded, value * QUANTUM, *around(logarithm, LOG_DEGREE, rounded, low, high)[0]]
        rows.append([float(value) for value in row])
    return rows


HEADER = f"""\
!> Coefficients of the complete elliptic integrals; made by scripts/generate_elliptic.py.
module contensou_special_elliptic_tables
   use contensou_base_kinds, only : wp
   implicit none(type, external)
   private

   public :: parts, binades, log_parts, intervals, logarithm, log_2_leading, log_2_rest

   !> Intervals to a binade.
   integer, parameter :: parts = {PARTS}

   !> Binades below 1 that are tabulated.
   integer, parameter :: binades = {BINADES}

   !> Intervals of m.
   integer, parameter :: log_parts = {LOG_PARTS}
"""


def text_of(value: float) -> str:
    """Shortest decimal number that is read back as the same double."""
    return repr(value) + "_wp"


def array_text(declared: str, shape: str, meaning: str, rows: list[list[float]]) -> str:
    """A named constant, column by column."""
    words = [text_of(value) + "," for row in rows for value in row]
    words[-1] = words[-1].rstrip(",")
    lines = textwrap.wrap(" ".join(words), 98, initial_indent="      ", subsequent_indent="      ")
    body = " &\n".join([*lines, f"      ], [{shape}])"])
    return f"\n   !> {meaning}\n   real(wp), parameter :: {declared} = reshape([ &\n{body}\n"


def module_text() -> str:
    """The Fortran module."""
    main_rows, log_rows = main_table(), logarithm_table()
    width = len(main_rows[0])
    text = HEADER
    names = []
    for binade in range(BINADES):
        power = BINADES - binade
        names.append(f"binade_{power}")
        text += array_text(
            f"{names[-1]}({width}, parts)",
            f"{width}, parts",
            f"Intervals from 2^-{power} to 2^-{power - 1}.",
            main_rows[binade * PARTS : (binade + 1) * PARTS],
        )
    listed = " &\n".join(
        textwrap.wrap(", ".join(names), 98, initial_indent="      ", subsequent_indent="      ")
    )
    text += f"""
   !> For each interval: centre twice, then the coefficients of B and D for each power of t.
   real(wp), parameter :: intervals(2, 0:{width // 2 - 1}, 0:parts*binades - 1) = reshape([ &
{listed}], [2, {width // 2}, parts*binades])
"""
    text += array_text(
        f"logarithm(0:{LOG_DEGREE + 1}, 0:log_parts - 1)",
        f"{LOG_DEGREE + 2}, log_parts",
        "For each interval of m from 1 to 2: centre, then the coefficients of g.",
        log_rows,
    )
    leading = nint(ln(2) / QUANTUM) * QUANTUM
    return f"""{text}
   !> Leading digits of log 2.
   real(wp), parameter :: log_2_leading = {text_of(float(leading))}

   !> log 2 less its leading digits.
   real(wp), parameter :: log_2_rest = {text_of(float(ln(2) - leading))}

end module contensou_special_elliptic_tables
"""


def main(arguments: list[str]) -> int:
    """Write or check the file."""
    check = "--check" in arguments
    names = [word for word in arguments if word != "--check"]
    file = Path(names[0]) if names else FILE
    text = module_text()
    if not check:
        file.write_text(text, encoding="utf-8")
        return 0
    if file.read_text(encoding="utf-8") == text:
        return 0
    print(f"{file}: differs from what scripts/generate_elliptic.py makes", file=sys.stderr)
    return 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
