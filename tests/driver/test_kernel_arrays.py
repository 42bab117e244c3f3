"""The kernels of the Python package on arrays: what they give, and what an element costs."""

from __future__ import annotations

import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from programs import captured, instructions

ROOT = Path(__file__).resolve().parents[2]

# The arguments are those of tests/cost/kernel_loops.f90.
LOOPS = """
import sys, numpy as np, contensou
kernel, n, rounds = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
x = np.arange(1, n + 1) / n
a = np.full(n, 1e-3)
b = 0.7 * a
rubs = np.full(n, 2.0), a, b, np.full(n, 0.05), np.full(n, 0.01), 100 * x
friction = contensou.Friction("contensou_exact", 0.3)
stiff = np.full(n, 8e10), np.full(n, 0.3)
zero = np.zeros(n)
hertz = 50 * x, 70 * x, np.full(n, 1.1e11), 1e-6 * x
spot = contensou.Tangential(8e10, 0.3)
shifts = np.full(n, 0.6), a, b, 1e-9 * (x - 0.5), zero, zero
sizes = a * x, b * x
calls = {
    "hertz": lambda: contensou.hertz(*hertz),
    "elliptic": lambda: contensou.elliptic(x),
    "wrench": lambda: friction.wrench(*rubs),
    "jacobian": lambda: friction.jacobian(*rubs).wrench,
    "stiffness": lambda: contensou.tangential_stiffness(*sizes, *stiff),
    "tangential": lambda: spot.advance(*shifts),
}
for _ in range(rounds):
    found = calls[kernel]()
print(found[0].sum(), file=sys.stderr)
"""


def test_kernels_broadcast(contensou):
    radius, modulus = 0.01, np.array([1e9, 1e11])[:, None]
    approach = np.linspace(0, 1e-5, 7)
    found = contensou.hertz(1 / (2 * radius), 1 / (2 * radius), modulus, approach)
    assert found.force.shape == (2, 7)
    expected = 4 / 3 * modulus * np.sqrt(radius) * approach**1.5
    np.testing.assert_allclose(found.force, expected, rtol=1e-14)
    np.testing.assert_allclose(found.a, np.sqrt(radius * approach) * np.ones((2, 1)), rtol=1e-14)
    assert contensou.hertz(50, 50, 1e11, 1e-6).force.shape == ()
    assert np.isnan(contensou.hertz(50, [49, 50], 1e11, 1e-6).force).tolist() == [True, False]
    assert contensou.hertz(50, 50, 1e11, np.zeros((0, 3))).a.shape == (0, 3)
    k, e = contensou.elliptic(np.array([1.0, 0.0, 2.0]))
    assert (k[0], e[0]) == pytest.approx((np.pi / 2, np.pi / 2))
    assert np.isinf(k[1])
    assert np.isnan(k[2])
    back = approach[::-2]
    np.testing.assert_array_equal(
        contensou.hertz(50, 50, 1e11, back).force,
        contensou.hertz(50, 50, 1e11, approach).force[::-2],
    )
    with pytest.raises(ValueError, match="shape"):
        contensou.hertz([1, 2], [1, 2, 3], 1, 1)


def test_friction_of_arrays(contensou, unpacked):
    """The numbers of `contensou eval wrench`, to the last bit that it prints."""
    friction = contensou.Friction("pade22", 0.3)
    speed, spin = np.meshgrid([0.0, 1e-3, 0.1], [0.0, 50.0, -1e3], indexing="ij")
    found = friction.wrench(10.0, 2e-3, 1e-3, speed, 0.02, spin)
    rows = [f"10,2e-3,1e-3,0.3,{x!r},0.02,{w!r}" for x, w in np.c_[speed.flat, spin.flat].tolist()]
    done = subprocess.run(
        [unpacked / "bin/contensou", "eval", "wrench", "--model", "pade22"],
        input="\n".join(["N,a,b,f,vx,vy,w", *rows, ""]),
        capture_output=True,
        text=True,
        check=True,
    )
    names, *lines = done.stdout.splitlines()
    table = np.array([[float(x) for x in line.split(",")] for line in lines])
    for name, column in (("Fx", found.fx), ("Fy", found.fy), ("Tz", found.tz)):
        expected = table[:, names.split(",").index(name)]
        np.testing.assert_allclose(column.ravel(), expected, rtol=1e-15)
    assert np.isnan(friction.wrench(1, 1e-3, 2e-3, 1, 0, 0).fx)
    for words in (("bronze", 0.3), ("pade22", -1), ("coulomb", 0.3, 0.0), ("pade22", np.nan)):
        with pytest.raises(contensou.SceneError, match="there is no friction"):
            contensou.Friction(*words)


def test_kernels_let_other_threads_run(contensou):
    """While a kernel works on an array, Python counts on."""
    approach = np.full(2_000_000, 1e-6)
    with ThreadPoolExecutor(1) as pool:
        work = pool.submit(contensou.hertz, 50.0, 70.0, 1e11, approach)
        counted = 0
        while not work.done():
            counted += 1
    assert work.result().force[-1] > 0
    assert counted > 1000


def test_friction_and_its_slopes(contensou):
    friction = contensou.Friction("contensou_exact", 0.3)
    at = np.array([10.0, 2e-3, 1e-3, 0.02, -0.01, 30.0])
    found = friction.jacobian(at[0], at[1], at[2], at[3], [[at[4]], [at[4]]], at[5])
    assert found.slopes.shape == (2, 1, 3, 5)
    assert np.array_equal(found.wrench.fx, np.broadcast_to(friction.wrench(*at).fx, (2, 1)))
    for column, keys in enumerate([(0,), (1, 2), (3,), (4,), (5,)]):
        up, down = at.copy(), at.copy()
        for key in keys:
            up[key] *= 1 + 1e-6
            down[key] *= 1 - 1e-6
        step = up[keys[0]] - down[keys[0]]
        slope = (np.array(friction.wrench(*up)) - np.array(friction.wrench(*down))) / step
        np.testing.assert_allclose(found.slopes[1, 0, :, column], slope, rtol=1e-7, atol=1e-12)
    assert np.isnan(friction.jacobian(1, 1e-3, 2e-3, 1, 0, 0).slopes).all()


def test_tangential_stiffness_and_steps(contensou):
    """Circle: 4 G a/(2 - nu) and 8/3 G a^3; one spring is linear up to its limit."""
    a = np.array([[1e-3], [2e-3]])
    found = contensou.tangential_stiffness(a, a, 8e10, [0.2, 0.3])
    np.testing.assert_allclose(found.kx, 4 * 8e10 * a / (2 - np.array([0.2, 0.3])), rtol=1e-13)
    np.testing.assert_allclose(found.ky, found.kx, rtol=1e-13)
    np.testing.assert_allclose(found.kt, 8 / 3 * 8e10 * a**3 * np.ones(2), rtol=1e-13)
    spring = contensou.Tangential(8e10, 0.3, layers=0)
    shift = np.array([1e-10, 1e-10, 1.0, -1e-10])
    steps = spring.advance(0.6, 1e-3, 1e-3, shift, 0.0, 0.0)
    k = found.kx[0, 1]
    np.testing.assert_allclose(steps.fx, [-k * 1e-10, -k * 2e-10, -0.6, -0.6 + k * 1e-10])
    np.testing.assert_allclose(steps.energy, steps.fx**2 / (2 * k))
    assert steps.lost[2] == pytest.approx(0.6, rel=1e-6)
    assert np.isnan(spring.advance(-1, 1e-3, 1e-3, 0, 0, 0).fx)
    assert spring.advance(0.0, 1e-3, 1e-3, 0, 0, 0).fx == 0
    for words in ((0, 0.3), (8e10, 0.6), (8e10, 0.3, 129), (8e10, 0.3, -1), (np.nan, 0.3)):
        with pytest.raises(contensou.SceneError, match="there is no spot"):
            contensou.Tangential(*words)


def test_layers_unless_told_are_those_of_eval(contensou, run):
    """The shear of a circle, with no number of layers, and with others."""
    shift = [1.5e-9, 1.5e-9, -4e-9, 1.5e-9]
    rows = [f"2,1e-3,1e-3,0.3,8e10,0.3,{x!r},0,0" for x in np.cumsum(shift).tolist()]
    text = "\n".join(["N,a,b,f,G,nu,dx,dy,twist", *rows, ""])
    done = run("eval", "tangential", input=text)
    assert done.status == 0, done.err
    names = done.out.split()[0].split(",")
    told = [float(line.split(",")[names.index("Fx")]) for line in done.out.split()[1:]]
    found = contensou.Tangential(8e10, 0.3).advance(0.6, 1e-3, 1e-3, shift, 0.0, 0.0)
    np.testing.assert_allclose(found.fx, told, rtol=1e-12)
    other = contensou.Tangential(8e10, 0.3, 11).advance(0.6, 1e-3, 1e-3, shift, 0.0, 0.0)
    assert np.abs(other.fx - told).max() > 1e-6


@pytest.mark.parametrize(
    "kernel", ["hertz", "elliptic", "wrench", "jacobian", "stiffness", "tangential"]
)
def test_arrays_cost_what_loops_in_fortran_cost(kernel, unpacked, tmp_path, build_kind):
    """At most 1.3 times the instructions of a loop that a Fortran program has, through NumPy."""
    library = ROOT / "build-wheel/meson/src/libcontensou.a"
    if os.environ.get("CONTENSOU_WHEEL") or not library.exists():
        pytest.skip("the library of the wheel is not here")
    program = tmp_path / "loops"
    command = ["gfortran", "-O3", f"-I{library}.p", f"-J{tmp_path}", "-o", program]
    command += [ROOT / "tests/cost/kernel_loops.f90", library, "-lgsl", "-lgslcblas", "-lm"]
    done = captured(command)
    assert done.returncode == 0, done.stderr
    script = tmp_path / "arrays.py"
    script.write_text(f"import sys\nsys.path.insert(0, {str(unpacked.parent)!r})\n{LOOPS}")
    n, few, many = (2000 if kernel == "tangential" else 20000), 1, 11

    def cost(words):
        """Of an element, without what makes the arguments."""
        # Threads of NumPy's algebra, of no use here, would spin while they wait.
        words = ["env", "PYTHONHASHSEED=0", "OPENBLAS_NUM_THREADS=1", *words, kernel, n]
        spent = [instructions([*words, k], tmp_path, build_kind) for k in (few, many)]
        return (spent[1] - spent[0]) / (n * (many - few))

    python = [sys.executable, script]
    sums = [float(captured([*words, kernel, "100", "2"]).stderr) for words in ([program], python)]
    assert sums[0] == pytest.approx(sums[1], rel=1e-12)
    assert cost(python) < 1.3 * cost([program])
