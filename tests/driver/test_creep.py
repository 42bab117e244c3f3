"""Laws of creep by way of `contensou eval creep`."""

from __future__ import annotations

import csv
import io
import math
import os
import random
from pathlib import Path

import pytest

TABLES = Path(os.environ.get("CONTENSOU_TANGENTIAL", "/work/shared/reference/tangential"))
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


LAWS = ["strip", "polach", "brush"]


def off(row, one, other):
    """Largest difference of two wrenches in f N and f N a."""
    unit = row[0] * row[3]
    scale = {"Fx": unit, "Fy": unit, "Tz": unit * max(row[1:3])}
    return max(abs(one[name] - other[name]) / scale[name] for name in scale)


def test_brush_without_rolling_is_the_exact_wrench(evaluate):
    rows = [(*row[:9], 0, 0) for row in states(2, 100)]
    found = evaluate("creep", INPUTS, rows, "--model", "brush")
    exact = evaluate("creep", INPUTS, rows, "--model", "sliding")
    assert max(map(off, rows, found, exact)) <= 1e-12


def test_small_creep_of_the_brush_is_linear(evaluate):
    rows = [(*row[:6], *(1e-9 * x for x in row[6:9]), *row[9:]) for row in states(3, 200)]
    found = evaluate("creep", INPUTS, rows, "--model", "brush")
    linear = evaluate("creep", INPUTS, rows, "--model", "linear")
    for row, one, other in zip(rows, found, linear, strict=True):
        nothing = dict.fromkeys(one, 0)
        assert off(row, one, other) <= 1e-5 * off(row, other, nothing)


@pytest.mark.parametrize("law", LAWS)
def test_dissipation(evaluate, law):
    rows = states(4, 3000)
    for row, one in zip(rows, evaluate("creep", INPUTS, rows, "--model", law), strict=True):
        power = one["Fx"] * row[6] + one["Fy"] * row[7] + one["Tz"] * row[8]
        assert power <= 0


@pytest.mark.parametrize("law", LAWS)
def test_no_friction_no_force(evaluate, law):
    rows = [(*row[:3], 0, *row[4:]) for row in states(5, 10)]
    for one in evaluate("creep", INPUTS, rows, "--model", law):
        assert all(one[name] == 0 for name in ("Fx", "Fy", "Tz"))


def test_brush_against_boundary_elements(evaluate):
    path = TABLES / "creep.csv"
    if not path.is_file():
        pytest.skip(f"the references {path} are not here")
    with open(path, encoding="utf-8") as file:
        table = [{k: float(x) for k, x in row.items()} for row in csv.DictReader(file)]
    rows = []
    for row in table:
        a, b = row["a_over_b"] ** 0.5, row["a_over_b"] ** -0.5
        load, scale = 2000 * math.pi / 3, 0.3 * 1000 / 80000
        slip = (row["cx"] * scale, row["cy"] * scale, row["cphi"] * scale)
        rows.append((load, a, b, 0.3, 80000, row["nu"], *slip, -1, 0))
    found = evaluate("creep", INPUTS, rows, "--model", "brush")
    errors = [
        max(abs(one[name] / (0.3 * input_[0]) - row[name]) for name in ("Fx", "Fy", "Tz"))
        for input_, one, row in zip(rows, found, table, strict=True)
    ]
    assert sum(errors) / len(errors) <= 0.03
    assert max(errors) <= 0.09


@pytest.mark.parametrize("law", LAWS)
def test_force_is_within_its_limit(evaluate, law):
    rows = states(6, 1000)
    for row, one in zip(rows, evaluate("creep", INPUTS, rows, "--model", law), strict=True):
        assert math.hypot(one["Fx"], one["Fy"]) <= 1.05 * row[0] * row[3]


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
