"""Laws of creep by way of `contensou eval creep`."""

from __future__ import annotations

import csv
import io
import math
import random
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest
from reference_tables import table

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "campaigns"))
import creep

INPUTS = "N,a,b,f,G,nu,vx,vy,w,cx,cy"


@pytest.fixture
def evaluate(run):
    """Function from a kernel, names and rows to the rows of numbers."""

    def evaluate_it(kernel, header, rows, *words):
        text = "".join(",".join(map(str, row)) + "\n" for row in [header.split(","), *rows])
        result = run("eval", kernel, *words, input=text)
        assert result.status == 0, result.err
        return [
            {name: float(value) for name, value in row.items()}
            for row in csv.DictReader(io.StringIO(result.out))
        ]

    return evaluate_it


def states(seed: int, number: int) -> list[tuple]:
    """Random states of random spots, creepages over six decades about the scale of creepage."""
    draw = random.Random(seed)
    found = []
    for _ in range(number):
        a, b = (1e-3 * 10 ** draw.uniform(-0.7, 0.7) for _ in range(2))
        load, f, g = 10 ** draw.uniform(0, 5), draw.uniform(0.05, 1), 10 ** draw.uniform(7, 11)
        scale = 1.5 * f * load / (3.14159 * a * b * g)
        cx, cy, vx, vy, w = (draw.gauss(0, 1) for _ in range(5))
        by = scale * 10 ** draw.uniform(-3, 3)
        vx, vy, w = vx * by, vy * by, w * by / (a * b) ** 0.5 * 10 ** draw.uniform(-1, 1)
        found.append((load, a, b, f, g, draw.uniform(0, 0.5), vx, vy, w, cx, cy))
    return found


def test_full_sliding_is_the_exact_wrench(evaluate):
    rows = states(1, 100)
    found = evaluate("creep", INPUTS, rows, "--model", "sliding")
    wrench = evaluate("wrench", "N,a,b,f,vx,vy,w", [(*row[:4], *row[6:9]) for row in rows])
    for row, one, other in zip(rows, found, wrench, strict=True):
        for name, unit in (("Fx", 1), ("Fy", 1), ("Tz", max(row[1:3]))):
            assert one[name] == pytest.approx(other[name], abs=1e-14 * row[0] * row[3] * unit)


LAWS = ["strip", "polach", "fastsim", "brush"]


def off(row, one, other):
    """Largest difference of two wrenches in f N and f N a."""
    unit = row[0] * row[3]
    scale = {"Fx": unit, "Fy": unit, "Tz": unit * max(row[1:3])}
    return max(abs(one[name] - other[name]) / scale[name] for name in scale)


@pytest.mark.parametrize("law", ["fastsim", "brush"])
def test_without_rolling_it_is_the_exact_wrench(evaluate, law):
    rows = [(*row[:9], 0, 0) for row in states(2, 100)]
    found = evaluate("creep", INPUTS, rows, "--model", law)
    exact = evaluate("creep", INPUTS, rows, "--model", "sliding")
    assert max(map(off, rows, found, exact)) <= 1e-12


def test_fastsim_as_published(evaluate):
    """Its own steps, with the parabolic bound in the middles of elements, for rolling along x."""
    load, a, b, f, g, nu, n = 1000.0, 2e-3, 1e-3, 0.3, 8e10, 0.3, 20
    e0 = 1.5 * f * load / (math.pi * a * b * g)
    c = evaluate("kalker", "a_over_b,nu,chi", [(a / b, nu, 0)])[0]
    l1, l2 = (8 * a / (3 * g * c[name]) for name in ("C11", "C22"))
    l3 = math.pi * a * a / (4 * g * c["C23"] * (a * b) ** 0.5)
    creepages = [(0.5, 0.2, 0.4), (-1, 0, 2), (0, 0.8, -1.2), (3, -4, 0.1)]
    rows = []
    for xi, eta, phi in creepages:
        slip = (xi * e0, eta * e0, phi * e0 / (a * b) ** 0.5)
        rows.append((load, a, b, f, g, nu, *slip, -1, 0))
    found = evaluate("creep", INPUTS, rows, "--model", "fastsim")
    places = [(2 * i + 1) / n - 1 for i in range(n)]
    for row, one in zip(rows, found, strict=True):
        xi, eta, phi = row[6:9]
        sums, whole = [0.0] * 3, 0.0
        for across in places:
            y = b * across
            half = a * (1 - across**2) ** 0.5
            area = (2 * half / n) * (2 * b / n)
            px = py = 0.0
            for i in range(n):
                x = half * (1 - (2 * i + 1) / n)
                step = 2 * half / n * (0.5 if i == 0 else 1)
                px -= step * (xi / l1 - phi * y / l3)
                py -= step * (eta / l2 + phi * x / l3)
                bound = 2 * f * load / (math.pi * a * b) * (1 - (x / a) ** 2 - across**2)
                cut = min(1, bound / math.hypot(px, py))
                px, py = cut * px, cut * py
                sums = [s + area * t for s, t in zip(sums, (px, py, x * py - y * px), strict=True)]
                whole += area * bound
        # The sum of the bound over the elements differs from f N by less than their size.
        assert whole == pytest.approx(f * load, rel=5e-3)
        for name, unit, total in zip(("Fx", "Fy", "Tz"), (1, 1, a), sums, strict=True):
            assert one[name] == pytest.approx(total, abs=5e-3 * f * load * unit)


@pytest.mark.parametrize("law", ["fastsim", "brush"])
def test_rolling_that_stops_has_no_jump(evaluate, law):
    rows = [(*row[:9], *(1e-12 * c for c in row[9:])) for row in states(8, 100)]
    found = evaluate("creep", INPUTS, rows, "--model", law)
    exact = evaluate("creep", INPUTS, rows, "--model", "sliding")
    for row, one, other in zip(rows, found, exact, strict=True):
        size = (row[1] * row[2]) ** 0.5
        creep = math.hypot(row[6], row[7], row[8] * size) / math.hypot(row[9], row[10])
        if creep > 1e7 * 1.5 * row[3] * row[0] / (math.pi * size**2 * row[4]):
            assert off(row, one, other) <= 1e-5


@pytest.mark.parametrize(("spin", "along"), [(3.8, 0.1), (-3.0, 0.1), (-2.0, 0.1)])
def test_brush_has_no_steps_with_spin(evaluate, spin, along):
    """Where strips stick again, on a line of lateral creepages: nearer, each change is less."""
    load, a, b, f, g = 1.0, 0.64, 1.56, 0.3, 1.0
    e0 = 1.5 * f * load / (math.pi * a * b * g)

    def line(first, last, number):
        lateral = [first + (last - first) * i / number for i in range(number + 1)]
        rows = [
            (load, a, b, f, g, 0.3, along * e0, y * e0, spin * e0, -0.68, -0.73) for y in lateral
        ]
        found = evaluate("creep", INPUTS, rows, "--model", "brush")
        changes = [off(rows[0], one, two) for one, two in zip(found[1:], found, strict=False)]
        return lateral, changes

    lateral, changes = line(-2, 2, 400)
    bends = [abs(one - two) for one, two in zip(changes[1:], changes, strict=False)]
    i = bends.index(max(bends))
    assert max(line(lateral[i], lateral[i + 2], 1000)[1]) < 3e-4


@pytest.mark.parametrize(
    ("law", "most", "largest", "nearer"),
    [
        ("strip", 1e-4, 0.03, 1e-3),
        ("polach", 1e-4, 1e-3, 1e-5),
        ("table", 2e-4, 1e-3, 1e-5),
        ("fastsim", 1e-3, 0.1, 1e-4),
        ("brush", 1e-3, 0.2, 2e-4),
    ],
)
def test_derivatives_have_no_jumps(evaluate, slow_build, law, most, largest, nearer):
    """Along lines of creepages, a ten thousandth of them from one to the next: changes of the
    difference quotient beyond the mean one, over the largest quotient; with spin, where what slips
    sticks again, some are steep. In steps of 1/2500 of that about the largest change it is at most
    `nearer`: it is no jump. That of `strip` falls to zero as a root where all slips."""
    draw = random.Random(11)
    step, number, lines = 1e-4, 2001, 4 if slow_build else 60
    jumps, zooms = [], []
    for _ in range(lines):
        a, b = (1e-3 * 5 ** draw.uniform(-0.5, 0.5) for _ in range(2))
        load, f, g = 1000, 0.3, 8e10
        e0 = 1.5 * f * load / (math.pi * a * b * g)
        turn, rolls = (draw.uniform(-math.pi, math.pi) for _ in range(2))
        slides = e0 * 10 ** draw.uniform(-0.7, 0.7)
        spin = draw.choice((-1, 1)) * e0 * 10 ** draw.uniform(-0.7, 0.9) / (a * b) ** 0.5
        motion = np.array([slides * math.cos(turn), slides * math.sin(turn), spin])
        rates = motion * [draw.uniform(-1, 1) for _ in motion]
        spot, flow = (load, a, b, f, g, 0.3), (math.cos(rolls), math.sin(rolls))
        unit = load * f
        units = {"Fx": unit, "Fy": unit, "Tz": unit * (a * b) ** 0.5}

        def slopes_along(
            ways, motion=motion, rates=rates, spot=spot, flow=flow, units=units
        ) -> np.ndarray:
            rows = [(*spot, *(motion + way * rates).tolist(), *flow) for way in ways]
            found = evaluate("creep", INPUTS, rows, "--model", law)
            wrench = np.array([[one[name] / units[name] for name in units] for one in found])
            return np.diff(wrench, axis=0) / np.diff(ways)[:, None]

        ways = step * np.arange(number)
        slopes = slopes_along(ways)
        changes = np.abs(np.diff(slopes, axis=0))
        top = np.abs(slopes).max()
        jumps.append((changes.max(axis=0) - changes.mean(axis=0)).max() / top)
        for _ in range(2):
            at = changes.max(axis=1).argmax()
            ways = np.linspace(ways[at], ways[at + 2], 101)
            changes = np.abs(np.diff(slopes_along(ways), axis=0))
        zooms.append(changes.max() / top)
    jumps.sort()
    assert jumps[int(0.9 * lines)] <= most
    assert jumps[-1] <= largest
    assert max(zooms) <= nearer


@pytest.mark.parametrize("law", ["linear", "strip", "polach", "fastsim", "brush", "table"])
def test_axes_that_change_their_places_make_no_kink(evaluate, law):
    """Where a spot becomes a circle and then longer across, rolling askew: the derivatives by its
    size before and after, of the second order, over the force."""
    draw = random.Random(17)
    load, f, g, step = 1, 0.3, 8e4, 1e-4
    e0 = 1.5 * f * load / (math.pi * g)
    rows = []
    for _ in range(40):
        rolls, nu = draw.uniform(0.1, 1.47), draw.uniform(0, 0.5)
        creeps = [0.3 * e0 * draw.gauss(0, 1) for _ in range(3)]
        flow = (-math.cos(rolls), -math.sin(rolls))
        rows += [(load, 1 + i * step, 1, f, g, nu, *creeps, *flow) for i in range(-2, 3)]
    found = evaluate("creep", INPUTS, rows, "--model", law)
    wrench = np.array([[row[name] for name in ("Fx", "Fy", "Tz")] for row in found])
    one, two, three, four, five = wrench.reshape(-1, 5, 3).transpose(1, 0, 2)
    before = 1.5 * three - 2 * two + 0.5 * one
    after = -1.5 * three + 2 * four - 0.5 * five
    unit = step * np.linalg.norm(three[:, :2], axis=1)[:, None]
    assert (np.abs(after - before) / unit).max() < 1e-4


@pytest.mark.parametrize("law", [*LAWS, "table"])
@pytest.mark.parametrize("turns", [(1, 1, 0), (0, 0, 1)])
def test_no_kink_where_there_is_no_spin_and_nothing_else(evaluate, law, turns):
    """Derivatives by creepages from both sides, where spin or all sliding but it is zero."""
    at, step = states(15, 60), 1e-5
    one_sided = []
    for index in (8, 6, 7):
        if turns[index - 6]:
            continue
        for side in (-1, 1):
            rows = []
            for way in (0, 1, 2):
                for row in at:
                    e0 = 1.5 * row[3] * row[0] / (math.pi * row[1] * row[2] * row[4])
                    unit = e0 * math.hypot(*row[9:11])
                    unit /= (row[1] * row[2]) ** 0.5 if index == 8 else 1
                    slip = [0.6 * e0 * math.hypot(*row[9:11]) * x for x in turns]
                    slip[2] /= (row[1] * row[2]) ** 0.5
                    slip[index - 6] += side * way * step * unit
                    rows.append((*row[:6], *slip, *row[9:11]))
            found = evaluate("creep", INPUTS, rows, "--model", law)
            scales = [(1, 1, (row[1] * row[2]) ** 0.5) for row in at]
            wrench = np.array([[one[key] for key in ("Fx", "Fy", "Tz")] for one in found])
            wrench = wrench.reshape(3, len(at), 3) / [
                [row[0] * row[3] * x for x in scale] for row, scale in zip(at, scales, strict=True)
            ]
            first = side * (4 * wrench[1] - wrench[2] - 3 * wrench[0]) / (2 * step)
            one_sided.append(first)
        before, after = one_sided[-2:]
        size = np.maximum(abs(before).max(axis=1), abs(after).max(axis=1))
        assert (abs(before - after).max(axis=1) <= 1e-3 * size).all()


def test_small_creep_of_the_brush_is_linear(evaluate):
    rows = [(*row[:6], *(1e-9 * x for x in row[6:9]), *row[9:]) for row in states(3, 200)]
    found = evaluate("creep", INPUTS, rows, "--model", "brush")
    linear = evaluate("creep", INPUTS, rows, "--model", "linear")
    for row, one, other in zip(rows, found, linear, strict=True):
        nothing = dict.fromkeys(one, 0)
        assert off(row, one, other) <= 1e-5 * off(row, other, nothing)


@pytest.mark.parametrize("ratio", [0.2, 1, 5])
def test_small_creep_of_fastsim(evaluate, ratio):
    """Parts of the linear force along an axis: of creepages one, of spin what steps of first order
    leave, (n - 1)(n - 2)/n^2, n = 20; and 0.13 % for 20 strips."""
    spot = (1, ratio, 1, 0.3, 1, 0.3)
    rows = [(*spot, *(1e-9 * x for x in one), -1, 0) for one in np.eye(3).tolist()]
    found = evaluate("creep", INPUTS, rows, "--model", "fastsim")
    linear = evaluate("creep", INPUTS, rows, "--model", "linear")
    parts = [
        one[name] / other[name]
        for name, one, other in zip(("Fx", "Fy", "Fy"), found, linear, strict=True)
    ]
    assert parts == pytest.approx([1, 1, 0.855], rel=2e-3)


@pytest.mark.parametrize("law", ["sliding", "linear", *LAWS, "table", "boundary_elements:8"])
def test_dissipation(executable, slow_build, law):
    """Of all ratios and directions; tests/campaigns/creep.py draws a million."""
    wrong, power, _ = creep.faults(executable, law, 4, 400 if slow_build else 4000)
    assert wrong == 0
    assert power <= 0


def test_table_of_needles_does_not_drive(evaluate):
    """States in which its splines alone would."""
    lines = (
        "110,5.41e-4,3.5386e-5,0.088,3.21e10,0.3425,-8.44e-5,1.677e-4,5.74,1.847,0",
        "17.72,7.6385e-4,1.0616e-4,0.09596,2.4525e10,0.0301,-5.3843e-5,-3.2429e-4,0.56511,"
        "1.1079,-0.20485",
        "18.63,4.141e-5,4.0544e-4,0.73635,1.66876e10,0.48381,-5.4094e-4,2.3726e-4,-43.9455,"
        "-0.0023184,-2.55566",
    )
    rows = [tuple(map(float, line.split(","))) for line in lines]
    for row, one in zip(rows, evaluate("creep", INPUTS, rows, "--model", "table"), strict=True):
        assert one["Fx"] * row[6] + one["Fy"] * row[7] + one["Tz"] * row[8] <= 0


@pytest.mark.parametrize("law", LAWS)
def test_no_friction_no_force(evaluate, law):
    rows = [(*row[:3], 0, *row[4:]) for row in states(5, 10)]
    for one in evaluate("creep", INPUTS, rows, "--model", law):
        assert all(one[name] == 0 for name in ("Fx", "Fy", "Tz"))


def test_brush_against_boundary_elements(evaluate):
    references = table("creep.csv")
    rows = []
    for row in references:
        a, b = row["a_over_b"] ** 0.5, row["a_over_b"] ** -0.5
        load, scale = 2000 * math.pi / 3, 0.3 * 1000 / 80000
        slip = (row["cx"] * scale, row["cy"] * scale, row["cphi"] * scale)
        rows.append((load, a, b, 0.3, 80000, row["nu"], *slip, -1, 0))
    found = evaluate("creep", INPUTS, rows, "--model", "brush")
    errors = [
        max(abs(one[name] / (0.3 * input_[0]) - row[name]) for name in ("Fx", "Fy", "Tz"))
        for input_, one, row in zip(rows, found, references, strict=True)
    ]
    assert sum(errors) / len(errors) <= 0.03
    assert max(errors) <= 0.09


@pytest.mark.parametrize(("ratio", "bounds"), [(30, (0.03, 0.06)), (50, (0.04, 0.06))])
@pytest.mark.parametrize("rolling", [(-1, 0), (0, -1)])
def test_needles_beyond_the_coefficients(evaluate, ratio, bounds, rolling):
    """Spin, creepage, and both, along and across, against boundary elements with 20 elements."""
    a, b = 1e-3 * ratio**0.5, 1e-3 * ratio**-0.5
    scale = 1.5 * 0.3 * 1000 / (math.pi * a * b * 8e10)
    rows = [
        (1000, a, b, 0.3, 8e10, 0.3, scale * x, scale * y, scale * spin / 1e-3, *rolling)
        for x, y, spin in [(0, 0, 0.3), (0.2, 0, 0), (0, 0.2, 0), (0.3, 0.4, 0.2)]
    ]
    (sliding,) = evaluate("creep", INPUTS, [(*rows[0][:6], 0, 0, 1, 0, 0)], "--model", "sliding")
    exact = evaluate("creep", INPUTS, rows, "--model", "boundary_elements", "--elements", "20")
    for one, other in zip(evaluate("creep", INPUTS, rows), exact, strict=True):
        off = math.hypot(one["Fx"] - other["Fx"], one["Fy"] - other["Fy"]) / 300
        assert off <= bounds[0]
        assert abs(one["Tz"] - other["Tz"]) <= bounds[1] * abs(sliding["Tz"])


@pytest.mark.parametrize("law", LAWS)
def test_force_is_within_its_limit(evaluate, law):
    rows = states(6, 1000)
    for row, one in zip(rows, evaluate("creep", INPUTS, rows, "--model", law), strict=True):
        assert math.hypot(one["Fx"], one["Fy"]) <= 1.001 * row[0] * row[3]


@pytest.mark.parametrize("law", [*LAWS, "linear"])
def test_axes_exchanged(evaluate, law):
    rows = states(7, 30)
    turned = [
        (load, b, a, f, g, nu, -vy, vx, w, -cy, cx)
        for load, a, b, f, g, nu, vx, vy, w, cx, cy in rows
    ]
    one = evaluate("creep", INPUTS, rows, "--model", law)
    other = evaluate("creep", INPUTS, turned, "--model", law)
    back = [{**wrench, "Fx": wrench["Fy"], "Fy": -wrench["Fx"]} for wrench in other]
    for row, first, second in zip(rows, one, back, strict=True):
        assert off(row, first, second) <= 1e-9 * max(1, off(row, first, dict.fromkeys(first, 0)))


def test_strips_of_carter(evaluate):
    # Without spin, along the axis: (3/2)(s acos s + 2/3 - h + h^3/3).
    load, a, b, f, g, nu = 1000, 1e-3, 5e-4, 0.3, 8e10, 0.3
    rows = [(load, a, b, f, g, nu, vx * 1e-3, 0, 0, -1, 0) for vx in (0.01, 0.5, 1, 2, 5, 20)]
    strips = evaluate("creep", INPUTS, rows, "--model", "strip")
    lines = evaluate("creep", INPUTS, rows, "--model", "linear")
    for one, linear in zip(strips, lines, strict=True):
        s = min(1, -linear["Fx"] / (f * load) * 4 / (3 * math.pi))
        h = math.sqrt(1 - s * s)
        force = 1.5 * (s * math.acos(s) + 2 / 3 - h + h**3 / 3)
        assert -one["Fx"] == pytest.approx(force * f * load, rel=1e-9)
        assert one["Fy"] == one["Tz"] == 0


@pytest.mark.parametrize("law", [*LAWS, "table"])
def test_rolling_that_reverses(evaluate, law):
    """Through rest: the wrench is that of full sliding there, from both sides."""
    load, a, b, f, g, nu = 500, 2e-3, 1e-3, 0.2, 1e9, 0.3
    spun = (0.02, 0.01, 5.0)
    speeds = [-1e-7, -1e-10, 0, 1e-10, 1e-7]
    rows = [(load, a, b, f, g, nu, *spun, -c, 0.3 * c) for c in speeds]
    found = evaluate("creep", INPUTS, rows, "--model", law)
    if law in ("strip", "polach"):
        # Against the linear force at any speed, against the velocities at rest.
        found = [found[0], found[1], found[3], found[4]]
        assert off(rows[0], found[0], found[1]) <= 1e-6
        assert off(rows[0], found[2], found[3]) <= 1e-6
    else:
        exact = evaluate("creep", INPUTS, rows[2:3], "--model", "sliding")[0]
        assert max(off(rows[0], one, exact) for one in found) <= 1e-4


@pytest.mark.parametrize("law", [*LAWS, "table"])
@pytest.mark.parametrize("ratio", [1e-3, 1e-2, 1, 1e2, 1e3])
def test_pure_spin_with_slow_rolling(evaluate, law, ratio):
    """Needles too: finite, opposed to the spin, and no more than full sliding bears."""
    a, b = 1e-3 * ratio**0.5, 1e-3 / ratio**0.5
    rows = [(100, a, b, 0.3, 8e10, 0.3, 0, 0, 50, c, 0.5 * c) for c in (0, 1e-9, 1e-3, 1, 1e3)]
    found = evaluate("creep", INPUTS, rows, "--model", law)
    most = -evaluate("creep", INPUTS, rows[:1], "--model", "sliding")[0]["Tz"]
    if law in ("strip", "polach"):
        # Half f N sqrt(a b), whatever the ratio.
        most = max(most, 0.5 * 100 * 0.3 * 1e-3)
    for row, one in zip(rows, found, strict=True):
        assert all(math.isfinite(value) for value in one.values())
        assert -1.01 * most <= one["Tz"] <= 0
        assert math.hypot(one["Fx"], one["Fy"]) <= 1.001 * row[0] * row[3]


def test_no_creep_and_slow_rolling_give_nothing(evaluate):
    rows = [(100, 1e-3, 2e-3, 0.3, 8e10, 0.3, 0, 0, 0, c, 0) for c in (0, 1e-300, 1)]
    for law in (*LAWS, "table"):
        for one in evaluate("creep", INPUTS, rows, "--model", law):
            assert all(one[name] == 0 for name in ("Fx", "Fy", "Tz"))


@pytest.mark.parametrize("law", [*LAWS, "table", "boundary_elements"])
def test_velocities_far_below_the_others(evaluate, law, build_kind):
    """They are none: neither is their square taken for zero, nor divided by."""
    if (law, build_kind) == ("boundary_elements", "checked"):
        pytest.skip("takes minutes there")
    spot = (100, 1e-3, 5e-4, 0.3, 8e10, 0.3)
    small = [10.0**-n for n in (3, 5, 8, 90, 110, 170, 300)]
    nothing = dict.fromkeys(("Fx", "Fy", "Tz"), 0)
    for x in small:
        rows = [(*spot, 1e-3 * x, 0, 0, -1, 0), (*spot, 0, 0, x, -1, 0)]
        for row, one in zip(rows, evaluate("creep", INPUTS, rows, "--model", law), strict=True):
            assert off(row, one, nothing) <= 3000 * x
    rows = [(*spot, 1, 0, 0, 0, -x) for x in small[1:]]
    rows += [(*spot, 0, 0, 1000, 0.3 * x, -x) for x in small[1:]]
    found = evaluate("creep", INPUTS, rows, "--model", law)
    exact = evaluate("creep", INPUTS, rows, "--model", "sliding")
    for row, one, other in zip(rows, found, exact, strict=True):
        if row[6] or law not in ("strip", "polach"):
            assert off(row, one, other) <= 6e-4


@pytest.mark.parametrize(
    ("kernel", "header", "row", "names"),
    [
        ("creep", INPUTS, "1,1e-3,1e-3,0.3,1e9,-0.1,1e-3,0,0,-1,0", "N, a, b, f, G and nu"),
        (
            *("tangential", "N,a,b,f,G,nu,dx,dy,twist", "1,1e-3,1e-3,0.3,-1e9,0.3,1e-6,0,0"),
            "N, a, b, f and G",
        ),
        ("kalker", "a_over_b,nu,chi", "1,-0.1,0", "a_over_b and nu"),
    ],
)
def test_moduli_that_are_negative(run, kernel, header, row, names):
    done = run("eval", kernel, input=f"{header}\n{row}\n")
    assert (done.status, done.out) == (2, "")
    assert f"{names} must not be negative" in done.err


def test_linear_where_nothing_rolls(run, tmp_path):
    (tmp_path / "spin.nml").write_text("""
&scene gravity = 0, 0, -9.81, t_end = 1 /
&material name = 'rubber', young = 5e6, poisson = 0.47 /
&body name = 'ball', density = 550, position = 0, 0, 0.0299, spin = 0, 0, 40 /
&surface name = 'skin', body = 'ball', shape = 'sphere', radius = 0.03, material = 'rubber' /
&surface name = 'floor', body = 'ground', shape = 'plane', material = 'rubber' /
&contact name = 'foot', surfaces = 'floor', 'skin', damping = 'none', friction_coefficient = 0.5,
   friction = 'contensou_exact', tangential = 'rolling', creep = 'linear' /
&output file = 'o.h5', interval = 0.1 /
""")
    done = run("run", "spin.nml")
    assert done.status == 1
    assert "contact 'foot', surfaces 'floor' and 'skin': where nothing rolls its law" in done.err
    assert "larger" not in done.err


BOUNCE = """
&scene gravity = 0, 0, -9.81, t_end = 0.1 /
&material name = 'rubber', young = 1e8, poisson = 0.3 /
&body name = 'ball', density = 1000, position = 0, 0, 0.055, velocity = 2, 0, -2, spin = 0, 50, 0 /
&surface name = 'skin', body = 'ball', shape = 'sphere', radius = 0.05, material = 'rubber' /
&surface name = 'floor', body = 'ground', shape = 'plane', material = 'rubber' /
&contact name = 'foot', surfaces = 'floor', 'skin', damping = 'tsuji', restitution = 0.5,
   friction = 'contensou_exact', friction_coefficient = 0.3, tangential = 'rolling',
   creep = 'linear' /
"""


@pytest.mark.parametrize("restitution", [0.31, 0.37, 0.4, 0.45, 0.5, 0.52, 0.55, 0.59, 0.7])
def test_linear_where_damping_takes_the_load(run, tmp_path, restitution):
    """Before the ball lifts off nothing presses it; friction then ends at once."""
    (tmp_path / "bounce.nml").write_text(BOUNCE)

    def bounce(method, rtol):
        sets = (f"foot.restitution={restitution}", f"integrator.method={method}")
        words = [word for text in (*sets, f"integrator.rtol={rtol}") for word in ("--set", text)]
        done = run("run", "bounce.nml", "-q", "--force", "-o", "bounce.h5", *words)
        assert done.status == 0, done.err
        with h5py.File(tmp_path / "bounce.h5") as file:
            assert len(file["events/time"]) == 2
            rows = file["trajectory"]
            return [file["events/time"][()], rows["velocity"][-1], rows["angular_velocity"][-1]]

    found = zip(bounce("cvode_bdf", 1e-8), bounce("explicit8", 1e-10), strict=True)
    for (one, other), off in zip(found, (5e-9, 5e-6, 2e-4), strict=True):
        assert one == pytest.approx(other, abs=off)
