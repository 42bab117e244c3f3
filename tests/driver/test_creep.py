"""Laws of creep by way of `contensou eval creep`."""

from __future__ import annotations

import csv
import io
import random

import pytest

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
