"""Tangential elasticity by way of `contensou eval`: published and independent tables, histories.

Tables that others computed: `reference_tables`.
"""

from __future__ import annotations

import csv
import io
import itertools
import math
import random

import pytest
from reference_tables import table

HISTORY = "N,a,b,f,G,nu,dx,dy,twist"
SPOT = (2.0, 1e-3, 1e-3, 0.3, 8e10, 0.3)
LIMIT = SPOT[0] * SPOT[3]
SHIFT = 1.5 * LIMIT * (2 - SPOT[5]) / (4 * SPOT[4] * SPOT[1])


@pytest.fixture
def evaluate(run):
    """Function from a kernel, names and rows to the rows with results."""

    def evaluate_it(kernel, header, rows, *words):
        text = "".join(",".join(map(str, row)) + "\n" for row in [header.split(","), *rows])
        result = run("eval", kernel, *words, input=text)
        assert result.status == 0, result.err
        return [
            {name: float(value) for name, value in row.items()}
            for row in csv.DictReader(io.StringIO(result.out))
        ]

    return evaluate_it


@pytest.fixture
def history(evaluate):
    """Function from places of body 1 on a spot to wrenches and energies."""

    def history_of(places, *words, spot=SPOT):
        return evaluate("tangential", HISTORY, [(*spot, *place) for place in places], *words)

    return history_of


@pytest.mark.parametrize("nu", [0, 0.3, 0.5])
@pytest.mark.parametrize("words", [(), ("--model", "spring"), ("--layers", "1")])
def test_axes_that_change_places_give_no_energy(evaluate, nu, words):
    """The major axis of a strained spot is the other one at once."""
    spots = [(1.0, 1e-3, 5e-4, 5.0, 8e10, nu), (1.0, 5e-4, 1e-3, 5.0, 8e10, nu)]
    out = [(*spots[0], 1e-11 * i, 3e-12 * i, 0) for i in range(1, 51)]
    back = [(*spots[1], 1e-11 * i, 3e-12 * i, 0) for i in range(50, -1, -1)]
    found = evaluate("tangential", HISTORY, [*out, *back], *words)
    before, after = found[49], found[50]
    has = [row["stored_energy"] + row["slip_work"] for row in (before, after)]
    assert before["stored_energy"] > 0.9 * has[0]
    assert has[1] <= has[0] * (1 + 1e-12)
    # What the contact gives on the way back, by the trapezoidal rule: exact where all sticks.
    given = sum(
        0.5 * (one[name] + next_one[name]) * (there[at] - here[at])
        for one, next_one, here, there in zip(found[50:], found[51:], back, back[1:], strict=False)
        for name, at in (("Fx", 6), ("Fy", 7))
    )
    assert 0 < given <= before["stored_energy"] * (1 + 1e-9)


def test_stiffness_of_a_spectral_solver(evaluate):
    rows = table("stiffness.csv")
    inputs = [(row["a_over_b"] ** 0.5, row["a_over_b"] ** -0.5, 1, row["nu"]) for row in rows]
    found = evaluate("tangential_stiffness", "a,b,G,nu", inputs)
    turned = evaluate("tangential_stiffness", "b,a,G,nu", inputs)
    for row, one, other in zip(rows, found, turned, strict=True):
        for name in ("kx", "ky", "kT"):
            assert one[name] == pytest.approx(row[name], rel=1e-8)
        assert (other["kx"], other["ky"], other["kT"]) == (one["ky"], one["kx"], one["kT"])


@pytest.mark.parametrize("pieces", [1, 6, 24])
def test_shift_with_twist(evaluate, pieces):
    # In one step, as the reference, and by and by.
    errors = {"Fx": [], "Tz": []}
    for row in table("shift_twist.csv"):
        unit = row["f"] * row["N"]
        spot = (row["N"], row["a"], row["a"], row["f"], row["G"], row["nu"])
        ways = [part / pieces for part in range(1, pieces + 1)]
        places = [(*spot, row["shift"] * way, 0, row["twist"] * way) for way in ways]
        last = evaluate("tangential", HISTORY, places)[-1]
        errors["Fx"].append(abs(-last["Fx"] / unit - row["F_over_fN"]))
        errors["Tz"].append(abs(-last["Tz"] / unit / row["a"] - row["T_over_fNa"]))
    for found in errors.values():
        assert sum(found) / len(found) <= 0.005
        assert max(found) <= 0.03


@pytest.mark.parametrize("layers", [1, 30, 40, 100, 128])
def test_a_circle_is_the_limit_of_ellipses(evaluate, layers):
    """Both solve for the slip of a shell in ways of their own, whatever their number."""
    generator = random.Random(5)
    places, to = [], [0.0, 0.0, 0.0]
    for _ in range(12):
        last, to = to, [SHIFT * generator.uniform(-1, 1) for _ in range(3)]
        for part in range(1, 11):
            x, y, w = (a + (b - a) * part / 10 for a, b in zip(last, to, strict=True))
            places.append((x, y, w / SPOT[1]))
    wrenches = []
    for minor in (SPOT[1], SPOT[1] * (1 - 1e-9)):
        spot = (SPOT[0], SPOT[1], minor, *SPOT[3:])
        rows = [(*spot, *place) for place in places]
        wrenches.append(evaluate("tangential", HISTORY, rows, "--layers", str(layers)))
    for circle, ellipse in zip(*wrenches, strict=True):
        for name, unit in (("Fx", LIMIT), ("Fy", LIMIT), ("Tz", LIMIT * SPOT[1])):
            assert circle[name] == pytest.approx(ellipse[name], abs=1e-7 * unit)


@pytest.mark.parametrize(("words", "bar"), [((), 0.02), (("--layers", "24"), 0.01)])
def test_oblique_impact(evaluate, words, bar):
    rows = table("mbf.csv")
    found = evaluate("oblique_impact", "nu,psi1", [(r["nu"], r["psi1"]) for r in rows], *words)
    for row, result in zip(rows, found, strict=True):
        chi = 7 * (1 - row["nu"]) / (2 * (2 - row["nu"]))
        slides = row["psi1"] >= 4 * chi - 1
        assert result["psi2"] == pytest.approx(row["psi2"], abs=1e-4 if slides else bar)


def cattaneo(places):
    """Force by shift along one axis without twist, exactly: what is remembered are the turns."""
    turns, sense = [(0.0, 0.0)], 0
    forces = []

    def virgin(x):
        x = min(x / SHIFT, 1.0)
        return LIMIT * (1 - (1 - x) ** 1.5)

    def force_at(x):
        """Force on the branch that leaves the last turn, in the sense of the motion."""
        if len(turns) == 1:
            return math.copysign(virgin(abs(x)), x)
        at, force = turns[-1]
        return force + math.copysign(2 * virgin(abs(x - at) / 2), x - at)

    last = 0.0
    for x in places:
        now = math.copysign(1, x - last)
        if sense and now != sense:
            turns.append((last, force_at(last)))
        sense = now
        # Branches inside a closed loop are forgotten.
        while len(turns) > 2 and abs(x - turns[-1][0]) > abs(turns[-2][0] - turns[-1][0]):
            del turns[-2:]
        if len(turns) == 2 and abs(x) > abs(turns[1][0]):
            del turns[1:]
        forces.append(force_at(x))
        last = x
    return forces


@pytest.mark.parametrize(("words", "bar"), [((), 1e-3), (("--layers", "128"), 1e-5)])
def test_shift_to_and_fro(history, words, bar):
    corners = [0.0, 0.7, -0.3, 0.4, 0.1, 0.5, -0.7, 0.9, -0.95, 0.2]
    places = [
        (first + (second - first) * part / 10) * SHIFT
        for first, second in itertools.pairwise(corners)
        for part in range(1, 11)
    ]
    found = history([(x, 0, 0) for x in places], *words)
    exact = cattaneo(places)
    assert max(exact) > 0.9 * LIMIT
    for row, force in zip(found, exact, strict=True):
        assert -row["Fx"] == pytest.approx(force, abs=bar * LIMIT)


@pytest.mark.parametrize(("words", "bar"), [((), 1e-3), (("--layers", "128"), 1e-5)])
@pytest.mark.parametrize("reach", [0.3, 0.6, 1.2])
def test_shifts_at_random(history, reach, words, bar):
    """Errors of many turns add: of 400 such histories the worst has 0.9e-3, half have 0.45e-3."""
    generator = random.Random(14)
    for _ in range(8):
        places = [reach * SHIFT * generator.uniform(-1, 1) for _ in range(300)]
        found = history([(x, 0, 0) for x in places], *words)
        errors = [abs(r["Fx"] + f) for r, f in zip(found, cattaneo(places), strict=True)]
        assert max(errors) <= bar * LIMIT


@pytest.mark.parametrize("ratio", [1, 0.3, 1e-3])
@pytest.mark.parametrize("swapped", [False, True])
def test_full_sliding_is_that_of_the_wrench(evaluate, ratio, swapped):
    load, a, b, f, g, nu = SPOT
    b = ratio * a
    spot = (load, b, a, f, g, nu) if swapped else (load, a, b, f, g, nu)
    for motion in [(1, 0, 0), (0.3, -0.8, 400), (0.2, 0.1, -3000), (0, 0, 100)]:
        places = [(*spot, *(step * 1e-3 * part for part in motion)) for step in range(1, 12)]
        last = evaluate("tangential", HISTORY, places)[-1]
        (wrench,) = evaluate("wrench", "N,a,b,f,vx,vy,w", [(*spot[:4], *motion)])
        for name, unit in [("Fx", 1), ("Fy", 1), ("Tz", a)]:
            assert last[name] == pytest.approx(wrench[name], abs=1e-12 * LIMIT * unit)


def test_axes_in_any_order(history):
    rnd = random.Random(1)
    places = [[rnd.uniform(-1, 1) * SHIFT for _ in range(3)] for _ in range(30)]
    places = [(x, y, z / 1e-3) for x, y, z in places]
    plain = history(places, spot=(2, 1e-3, 3e-4, 0.3, 8e10, 0.3))
    turned = history([(y, -x, z) for x, y, z in places], spot=(2, 3e-4, 1e-3, 0.3, 8e10, 0.3))
    for one, other in zip(plain, turned, strict=True):
        expected = {"Fx": one["Fy"], "Fy": -one["Fx"]}
        expected |= {name: one[name] for name in ("Tz", "stored_energy", "slip_work")}
        assert {name: other[name] for name in expected} == pytest.approx(expected, rel=1e-12)


def test_an_ellipse_whose_axes_change_places(evaluate):
    # By way of the circle; the force along y is kept while nothing moves.
    a = 1e-3
    rows = [
        (2, a, b, 0.3, 8e10, 0.3, 0.05 * SHIFT, 0.1 * SHIFT, 0)
        for b in [0.98 * a, 0.99 * a, a, 1.01 * a, 1.02 * a]
    ]
    found = evaluate("tangential", HISTORY, rows)
    for row in found:
        assert row["Fx"] == pytest.approx(found[0]["Fx"], rel=0.03)
        assert row["Fy"] == pytest.approx(found[0]["Fy"], rel=0.03)


def test_rows_outside_the_domain_are_no_part_of_the_history(history):
    places = [(0.1 * SHIFT, 0, 0), ("NaN", 0, 0), (0.2 * SHIFT, 0, 0)]
    found = history(places)
    assert all(math.isnan(found[1][name]) for name in ("Fx", "Fy", "Tz", "stored_energy"))
    assert found[2]["Fx"] == history([places[0], places[2]])[1]["Fx"]
    spots = [(2, 0, 0, 0.3, 8e10, 0.3), (2, 1e-3, 1e-3, 0.3, 0, 0.3), (2, 1e-3, 1e-3, 0.3, 1, 0.6)]
    for spot in spots:
        (row,) = history([(1e-6, 0, 0)], spot=spot)
        assert math.isnan(row["Fx"]), spot


def test_a_poisson_ratio_below_zero(history, evaluate):
    (stiffness,) = evaluate("tangential_stiffness", "a,b,G,nu", [(1e-3, 1e-3, 8e10, -0.3)])
    (row,) = history([(0.01 * SHIFT, 0, 0)], spot=(*SPOT[:5], -0.3))
    assert row["Fx"] == pytest.approx(-stiffness["kx"] * 0.01 * SHIFT, rel=0.01)


def test_a_load_that_vanishes_and_returns(evaluate):
    load, *spot = SPOT
    rows = [
        (load, *spot, 0.3 * SHIFT, 0, 0),
        (0, 0, 0, *spot[2:], 0.3 * SHIFT, 0, 0),
        (load, *spot, 0.3 * SHIFT, 0, 0),
        (load, *spot, 0.2 * SHIFT, 0, 0),
    ]
    first, gone, back, away = evaluate("tangential", HISTORY, rows)
    assert gone["Fx"] == gone["stored_energy"] == back["Fx"] == 0
    assert gone["slip_work"] == pytest.approx(first["stored_energy"] + first["slip_work"])
    assert away["Fx"] > 0


# 0.03 and 0.3 f p0/G.
@pytest.mark.parametrize("twist", [1e-7, 1e-6])
@pytest.mark.parametrize("ratio", [1, 0.4])
@pytest.mark.parametrize(
    "words", [(), ("--layers", "1"), ("--layers", "64"), ("--model", "spring")]
)
def test_a_twist_is_held_under_a_load_that_pulsates(evaluate, words, ratio, twist):
    """Area that comes and goes is not strained; what slips as the load falls has slipped then."""
    rows = []
    for i in range(12 * 40 + 1):
        load = 2 - 0.5 * math.sin(math.pi * i / 20)
        a = 1e-3 * (load / 2) ** (1 / 3)
        rows.append((load, a, ratio * a, *SPOT[3:], 0, 0, twist * min(i, 1)))
    found = evaluate("tangential", HISTORY, rows, *words)
    # Where the load is the least, from the sixth time on: shells at the rim are merged before.
    kept = found[210::40]
    assert abs(kept[0]["Tz"]) > 0.2 * abs(found[1]["Tz"])
    for name in ("Tz", "stored_energy", "slip_work"):
        assert [row[name] for row in kept] == pytest.approx([kept[0][name]] * len(kept), rel=1e-9)


def test_a_twist_that_sticks_returns_what_it_took(evaluate):
    """Twist, more load, less load, and back: nothing is lost or gained once the load varies."""
    rows = []
    for i in range(161):
        load = 2 + math.sin(math.pi * min(max(i - 40, 0), 80) / 80)
        a = 1e-3 * (load / 2) ** (1 / 3)
        rows.append((load, a, a, *SPOT[3:], 0, 0, 1e-9 * min(i, 40, 160 - i)))
    found = evaluate("tangential", HISTORY, rows, "--layers", "20")
    most = max(row["stored_energy"] for row in found)
    assert found[120]["Tz"] == pytest.approx(found[40]["Tz"], rel=1e-3)
    assert abs(found[-1]["Tz"]) < 0.02 * abs(found[40]["Tz"])
    # The rim has slipped as it was twisted first.
    assert found[40]["slip_work"] < 0.02 * most
    assert found[-1]["slip_work"] - found[40]["slip_work"] < 1e-4 * most


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("wrench", "--layers", "3"), "--layers goes with the kernels tangential and"),
        (("tangential", "--layers", "0"), "a number of layers from 1 to 128"),
        (("tangential", "--layers", "129"), "a number of layers from 1 to 128"),
        (
            ("tangential", "--layers", "3", "--model", "spring"),
            "--layers goes with the model shells",
        ),
        (("oblique_impact", "--model", "spings"), "did you mean 'spring'"),
        (("tangential_stiffness", "--model", "shells"), "possible are mindlin"),
    ],
)
def test_words_wrong(run, words, message):
    result = run("eval", *words, input="N\n1\n")
    assert result.status == 2
    assert result.out == ""
    assert message in result.err


def test_negative_magnitudes(run):
    result = run("eval", "tangential_stiffness", input="a,b,G,nu\n-1,1,1,0.3\n")
    assert result.status == 2
    assert "a, b and G must not be negative" in result.err
