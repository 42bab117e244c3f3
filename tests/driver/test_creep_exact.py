"""Exact laws of creep by way of `contensou eval creep`: the boundary elements.

Tables that others computed: `reference_tables`.
"""

from __future__ import annotations

import csv
import io
import math
import random
import sys
from pathlib import Path

import numpy as np
import pytest
from reference_tables import table

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts"))
import generate_creep

INPUTS = "N,a,b,f,G,nu,vx,vy,w,cx,cy"

F, G, P0, SIZE = 0.3, 8e10, 1e9, 1e-3
E0 = F * P0 / G


def spot(ratio: float, poisson: float = 0.3) -> tuple[float, ...]:
    """Inputs of a spot with sqrt(a b) of 1 mm."""
    a, b = SIZE * ratio**0.5, SIZE / ratio**0.5
    return 2 * math.pi / 3 * a * b * P0, a, b, F, G, poisson


@pytest.fixture
def wrenches(run):
    """Function from a law and rows of inputs to Fx, Fy in f N and Tz in f N sqrt(a b)."""

    def evaluate(model, rows):
        text = "".join(",".join(map(str, row)) + "\n" for row in [INPUTS.split(","), *rows])
        result = run("eval", "creep", "--model", model, input=text)
        assert result.status == 0, result.err
        found = np.array(
            [
                [float(row[name]) for name in ("Fx", "Fy", "Tz")]
                for row in csv.DictReader(io.StringIO(result.out))
            ]
        )
        rows = np.array(rows)
        limit = rows[:, 0] * rows[:, 3]
        return found / np.stack([limit, limit, limit * np.sqrt(rows[:, 1] * rows[:, 2])], axis=1)

    return evaluate


@pytest.fixture
def some(sample):
    """Function from a law and rows to those that are tried: of the boundary elements in the checked
    build, which takes seconds a row, some."""

    def choose(model, rows, number=3):
        return sample(rows, number) if model == "boundary_elements" else rows

    return choose


@pytest.mark.parametrize("model", ["table", "boundary_elements"])
def test_table_of_creep(wrenches, some, model):
    references = some(model, table("creep.csv"))
    rows = [
        (
            *spot(row["a_over_b"], row["nu"]),
            E0 * row["cx"],
            E0 * row["cy"],
            E0 * row["cphi"] / SIZE,
            -1.0,
            0.0,
        )
        for row in references
    ]
    expected = np.array([[row["Fx"], row["Fy"], row["Tz"]] for row in references])
    error = np.abs(wrenches(model, rows) - expected).max(axis=1)
    assert error.mean() <= 0.005
    assert error.max() <= 0.02


@pytest.mark.parametrize("model", ["table", "boundary_elements"])
def test_large_creep_is_full_sliding(wrenches, model):
    rows = [
        (*spot(ratio), *(large * E0 * v for v in (1.0, -0.5)), large * E0 * spin / SIZE, c, 0.3)
        for ratio in (0.3, 1.0, 4.0)
        for large in (1e4, 1e6)
        for spin in (0.0, 0.4, 3.0)
        for c in (0.7, 0.0)
    ]
    error = np.abs(wrenches(model, rows) - wrenches("sliding", rows)).max(axis=1)
    assert error.max() <= 2e-3


@pytest.mark.parametrize("model", ["table", "boundary_elements"])
def test_nothing_rolls(wrenches, model):
    draw = random.Random(3)
    rows = [
        (
            *spot(10 ** draw.uniform(-1, 1)),
            *(draw.gauss(0, 1) for _ in range(2)),
            draw.gauss(0, 1e3),
            0.0,
            0.0,
        )
        for _ in range(20)
    ]
    assert np.abs(wrenches(model, rows) - wrenches("sliding", rows)).max() <= 1e-12


@pytest.mark.parametrize("model", ["table", "boundary_elements"])
def test_no_creep_no_force(wrenches, model):
    rows = [(*spot(ratio), 0.0, 0.0, 0.0, 0.6, -0.8) for ratio in (0.2, 1.0, 2.0)]
    assert not wrenches(model, rows).any()


@pytest.mark.parametrize("model", ["table", "boundary_elements"])
def test_directions(wrenches, some, model):
    """Mirrors of a spot and half a turn of all, and the axes in the other order."""
    state = np.array([0.4, 0.3, 0.5])
    c = np.array([-0.8, 0.6])
    signs = [(1, 1), (1, -1), (-1, 1), (-1, -1)]
    rows = []
    for x, y in signs:
        v = E0 * state * (x, y, x * y)
        rows.append((*spot(2.0), v[0], v[1], v[2] / SIZE, x * c[0], y * c[1]))
    v = E0 * state
    rows.append((*spot(0.5), -v[1], v[0], v[2] / SIZE, -c[1], c[0]))
    found = wrenches(model, some(model, rows, 2))
    first = found[0]
    expected = [first * (x, y, x * y) for x, y in signs]
    expected.append(np.array([-first[1], first[0], first[2]]))
    assert np.abs(found - some(model, np.array(expected), 2)).max() <= 2e-5


@pytest.mark.parametrize("model", ["table", "boundary_elements"])
def test_dissipates(wrenches, some, model):
    draw = random.Random(5)
    rows = []
    for _ in range(40):
        v = np.array([draw.gauss(0, 1) for _ in range(3)])
        v *= E0 * 10 ** draw.uniform(-2, 3) / np.linalg.norm(v)
        turn = draw.uniform(0, 2 * math.pi)
        rows.append(
            (
                *spot(10 ** draw.uniform(-1, 1), draw.uniform(0, 0.5)),
                v[0],
                v[1],
                v[2] / SIZE,
                math.cos(turn),
                math.sin(turn),
            )
        )
    rows = some(model, rows)
    found = wrenches(model, rows)
    velocity = np.array(rows)[:, 6:9] * (1, 1, SIZE)
    assert ((found * velocity).sum(axis=1) < 0).all()
    assert np.hypot(found[:, 0], found[:, 1]).max() <= 1.001


def test_a_needle_that_rolls_nearly_along_itself(wrenches, build_kind):
    """Its lattice is sheared by 3, and GMRES takes hundreds of vectors."""
    if build_kind == "checked":
        pytest.skip("takes minutes there")
    turn = math.radians(1.53)
    row = (*spot(11.44, 0.367), 1e-3 * E0, -6e-4 * E0, 0.0, math.cos(turn), -math.sin(turn))
    elements, table_ = (wrenches(model, [row])[0] for model in ("boundary_elements", "table"))
    assert np.abs(elements - table_).max() <= 0.02 * np.abs(table_).max()


# Newton's method alone runs into cycles.
SHEARED = """\
15.7,2.939e-5,6.6336e-4,0.53922,1.0039927e10,0.43371,2.48e-5,6.0896e-6,-9.1857,0.015442,1.08
286.85,7.3528e-3,3.4563e-4,0.41276,4.1863e8,0.4802,-1.60334e-4,2.99199e-4,0.20289,0.52474,8.604e-3
3.45688,2.33247e-4,5.68847e-3,0.49689,1.63445e9,0.38660,1.94816e-5,6.861e-6,-2.232e-3,0.01914,-1.17
"""


def test_needles_that_roll_nearly_along_their_axis(run):
    text = f"{INPUTS}\n{SHEARED}"
    done = run("eval", "creep", "--model", "boundary_elements", "--elements", "8", input=text)
    assert done.status == 0, done.err
    for row in csv.DictReader(io.StringIO(done.out)):
        state = {name: float(value) for name, value in row.items()}
        limit = state["N"] * state["f"]
        assert 0.05 * limit < math.hypot(state["Fx"], state["Fy"]) <= limit
        power = state["Fx"] * state["vx"] + state["Fy"] * state["vy"] + state["Tz"] * state["w"]
        assert power < 0


# The solution turns back on the way from any slip, smaller or larger.
TURNING = (
    *(5.07336629550558, 1.257141378880205e-4, 3.0213832958429733e-3, 0.8676623661887137),
    *(49502877.44700741, 0.3700076748674096, -3.009386752748587e-4, -2.3653777144545906e-3),
    *(0.6218923025389188, -0.033740332887499655, 2.55548954050088),
)


@pytest.mark.release_only("takes long there")
def test_needle_whose_solution_turns_back(run):
    text = f"{INPUTS}\n{','.join(map(repr, TURNING))}\n"
    found = []
    for elements in ("6", "8", "10"):
        words = ("--model", "boundary_elements", "--elements", elements)
        done = run("eval", "creep", *words, input=text)
        assert done.status == 0, done.err
        found.append([float(value) for value in done.out.splitlines()[1].split(",")[-3:]])
    limit = TURNING[0] * TURNING[3]
    size = math.sqrt(TURNING[1] * TURNING[2])
    found = np.array(found) / (limit * np.array([1, 1, size]))
    # Between those with fewer and with more elements, which are found otherwise.
    assert np.abs(found[1] - 0.5 * (found[0] + found[2])).max() <= 0.05
    assert (found * np.array(TURNING[6:9]) * [1, 1, size]).sum(axis=1).max() < 0


@pytest.mark.parametrize(("elements", "mean", "worst"), [(8, 0.021, 0.05), (16, 0.008, 0.029)])
def test_fewer_elements_err_as_told(run, elements, mean, worst):
    rows, expected = [], []
    for row in table("creep.csv"):
        slip = (row["cx"] * E0, row["cy"] * E0, row["cphi"] * E0 / SIZE, -1.0, 0.0)
        rows.append((*spot(row["a_over_b"], row["nu"]), *slip))
        expected.append([row[name] for name in ("Fx", "Fy", "Tz")])
    text = "".join(",".join(map(str, row)) + "\n" for row in [INPUTS.split(","), *rows])
    words = ("--model", "boundary_elements", "--elements", str(elements))
    done = run("eval", "creep", *words, input=text)
    assert done.status == 0, done.err
    found = np.array([line.split(",")[-3:] for line in done.out.split()[1:]], dtype=float)
    limit = np.array(rows)[:, [0]] * F
    error = np.abs(found / (limit * [1, 1, SIZE]) - expected).max(axis=1)
    assert error.mean() <= mean
    assert error.max() <= worst


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("creep", "--model", "boundary_elements", "--elements", "9"), "an even number"),
        (("creep", "--model", "boundary_elements", "--elements", "98"), "from 4 to 96"),
        (("creep", "--elements", "8"), "--elements goes with the model boundary_elements"),
        (("wrench", "--elements", "8"), "--elements goes with the kernel creep"),
    ],
)
def test_elements_wrong(run, words, message):
    done = run("eval", *words, input=INPUTS + "\n")
    assert done.status == 2
    assert done.out == ""
    assert message in done.err


@pytest.mark.parametrize("model", ["table", "boundary_elements"])
@pytest.mark.parametrize("ratio", [20.0, 100.0, 1e-2, 1e3])
def test_needles(wrenches, build_kind, model, ratio):
    """Any creep, rolling along, across and obliquely: bounded, finite, and it does not drive."""
    if (model, build_kind) == ("boundary_elements", "checked"):
        pytest.skip("takes minutes there")
    rows = []
    for size in (1e-3, 0.1, 0.6, 3.0):
        for v in np.eye(3) * size * E0:
            for turn in (0.0, 0.7, math.pi / 2):
                slip = (v[0], v[1], v[2] / SIZE)
                rows.append((*spot(ratio), *slip, -math.cos(turn), -math.sin(turn)))
    found = wrenches(model, rows)
    assert np.hypot(found[:, 0], found[:, 1]).max() <= 1.001
    velocity = np.array(rows)[:, 6:9] * (1, 1, SIZE)
    assert ((found * velocity).sum(axis=1) <= 0).all()


@pytest.mark.parametrize("model", ["table", "boundary_elements"])
def test_where_the_coefficients_end(wrenches, build_kind, model):
    """There is no jump at the ratio of the axes from which on they are constant."""
    if (model, build_kind) == ("boundary_elements", "checked"):
        pytest.skip("takes minutes there")
    ends = [math.exp(3) * (1 + sign * 1e-6) for sign in (-1, 1)]
    for turn in (0.0, 0.7):
        for v in np.eye(3) * 0.3 * E0:
            slip = (v[0], v[1], v[2] / SIZE, -math.cos(turn), -math.sin(turn))
            one, other = wrenches(model, [(*spot(ratio), *slip) for ratio in ends])
            assert np.abs(one - other).max() <= 1e-5


def steady_rolling() -> tuple[list[tuple], np.ndarray]:
    """Inputs and wrenches of the table of steady rolling."""
    references = table("steady_rolling.csv")
    names = ("N", "a", "b", "f", "G", "nu", "xi", "eta", "phi")
    rows = [(*(row[name] for name in names), -1.0, 0.0) for row in references]
    return rows, np.array([[row["Fx"], row["Fy"], row["Tz"]] for row in references])


def test_table_of_steady_rolling(wrenches):
    """The errors are those of the grid of the data, too: 0.049 f N at a/b = 5."""
    rows, expected = steady_rolling()
    error = wrenches("table", rows) - expected
    assert np.hypot(error[:, 0], error[:, 1]).mean() <= 0.005
    assert np.abs(error[:, 2]).mean() <= 0.005
    assert np.hypot(error[:, 0], error[:, 1]).max() <= 0.045
    assert np.abs(error[:, 2]).max() <= 0.036


def test_fastsim_of_steady_rolling(wrenches):
    """Force along and across, and torque, mean and worst."""
    rows, expected = steady_rolling()
    error = np.abs(wrenches("fastsim", rows) - expected)
    assert (error.mean(axis=0) <= [0.0151, 0.0274, 0.0217]).all()
    assert (error.max(axis=0) <= [0.107, 0.144, 0.129]).all()


def test_grid_of_the_table_of_steady_rolling(wrenches, executable, build_kind):
    """One lattice as wide as the table's makes its values where the law is far from them."""
    if build_kind == "checked":
        pytest.skip("takes minutes there")
    rows, expected = steady_rolling()
    # The shares of the spot that slip are those of 41 elements, on circles of 45.
    for row, reference in zip(rows, table("steady_rolling.csv"), strict=True):
        share = reference["slip_percent"] / 100 * (45 if row[1] == row[2] else 41)
        assert abs(share - round(share)) <= 0.03
    far = np.abs(wrenches("table", rows) - expected).max(axis=1) > 0.025
    assert far.any()
    lines = []
    for load, a, b, f, g, nu, xi, eta, phi, *_ in np.array(rows)[far].tolist():
        assert a != b
        e0 = 1.5 * f * load / (math.pi * a * b * g)
        spin = phi * math.sqrt(a * b)
        lines.append(f"{a / b!r} {nu!r} {xi / e0!r} {eta / e0!r} {spin / e0!r}")
    build = executable.parent.parent
    out = generate_creep.program(build, ["tests/cost/creep_lattice"], "\n".join(["41", *lines, ""]))
    found = np.array([[float(x) for x in line.split()] for line in out.splitlines()])
    assert np.abs(found - expected[far]).max() <= 0.01


@pytest.mark.sample(5)
@pytest.mark.parametrize("model", ["table", "boundary_elements"])
@pytest.mark.parametrize("ratio", [0.1, 0.5, 1.0, 3.0])
@pytest.mark.parametrize("turn", [0.0, 0.5, math.pi / 2])
def test_small_creep_is_linear(wrenches, run, model, ratio, turn):
    result = run("eval", "kalker", input=f"a_over_b,nu,chi\n{ratio},0.3,{math.degrees(turn)}\n")
    row = next(csv.DictReader(io.StringIO(result.out)))
    c11, c12, c22, c13, c23, c33 = (
        float(row[name]) for name in ("C11", "C12", "C22", "C13", "C23", "C33")
    )
    matrix = np.array([[c11, c12, c13], [c12, c22, c23], [-c13, -c23, c33]])
    e = np.array([math.cos(turn), math.sin(turn)])
    frame = np.array([[e[0], e[1], 0], [-e[1], e[0], 0], [0, 0, 1]])
    creep = 1e-6 * np.eye(3)
    rows = [(*spot(ratio), E0 * v[0], E0 * v[1], E0 * v[2] / SIZE, -e[0], -e[1]) for v in creep]
    found = wrenches(model, rows)
    expected = -1.5 / math.pi * (frame.T @ matrix @ frame @ creep).T
    assert np.abs(found - expected).max() <= 1e-5 * np.abs(expected).max()


@pytest.mark.sample(1)
@pytest.mark.parametrize("ratio", [-2.0, 0.0, 1.5])
def test_nodes_of_the_table_are_what_is_generated(wrenches, executable, ratio):
    """At its nodes the law is what the generator computes there, but for omega."""
    build = executable.parent.parent
    index, direction, radius, _ = generate_creep.lattice()
    inner = np.flatnonzero((index**2).sum(axis=1) < (generate_creep.NODES - 0.5) ** 2)
    chosen = inner[:: len(inner) // 5]
    left = 1 - radius[chosen] ** 2
    ball = generate_creep.BALL * radius[chosen] / left
    closed = generate_creep.Closed(build, math.exp(ratio), generate_creep.POISSON)
    creepages = direction[chosen] * ball[:, None] / closed.scales
    lines = [f"{closed.g!r} 0.3 {x!r} {y!r} {w!r}" for x, y, w in creepages.tolist()]
    text = "\n".join(["28", *lines]) + "\n"
    out = generate_creep.program(build, ["tests/cost/creep_nodes"], text)
    exact = np.array([[float(x) for x in line.split()] for line in out.splitlines()])
    remainder = exact - closed(creepages)
    expected = closed(creepages) + remainder * (left / (left + 1e-3))[:, None]
    rows = [(*spot(closed.g), *(E0 * v[:2]), E0 * v[2] / SIZE, -1.0, 0.0) for v in creepages]
    assert np.abs(wrenches("table", rows) - expected).max() <= 2e-4
