"""Generate the table of the law of creep `table`, src/contact/creep/table_values.f90.

The law is W = alpha L + beta W_exact + gamma omega R, see src/contact/creep/table.f90. R is what
the exact wrench of steady rolling along an axis of the spot has beyond the closed forms, for
Poisson's ratio 0.3: a function of three scaled creepages z, put into a ball by

    z = z0 p/(1 - |p|^2),

and of ln g, where g is the half-length of the spot along the rolling direction over its half-width.
On the nodes of a cubic lattice in p, and at equidistant ln g, the wrench is computed by boundary
elements, with N/2 and N elements across, extrapolated. R is odd under the inversion of all
creepages, and one mirror leaves it; the other half of the creepages along and the spin follow. At
the surface of the ball, creep without end, R is zero; it is continued beyond as an odd function of
the distance. Then R is interpolated by cubic splines in all four directions, without a knot at the
points next to the ends; in the file are their coefficients, in units of 1.25e-4.

    generate_creep.py --build DIR [--elements N] [--wrenches FILE]
                                    write the table, 10 to 20 minutes of one core; FILE keeps the
                                    wrenches, from where a generation that was stopped goes on
    generate_creep.py --build DIR --check N [--seed S]
                                    recompute N random wrenches and compare with the law

Needs numpy and a built folder. Exit status 0, or 1 when the check finds more than 0.03 f N.
"""

from __future__ import annotations

import argparse
import csv
import io
import math
import random
import subprocess
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
TARGET = ROOT / "src" / "contact" / "creep" / "table_values.f90"

# Nodes along a radius of the ball, and its scale z0.
NODES = 13
BALL = 2.3

# First ln g, their distance and number.
FIRST, STEP, RATIOS = -3.0, 0.5, 13

POISSON = 0.3

# As in table.f90.
FORCE_UNIT = 1.5 / math.pi
FADE_IN = 0.1

# Unit of the coefficients, and nodes beyond the surface of the ball at each side.
UNIT = 1.25e-4
MARGIN = 2


def program(build: Path, words: list[str], text: str) -> str:
    """What a program of the build writes."""
    return subprocess.run(
        [build / words[0], *words[1:]], input=text, capture_output=True, text=True, check=True
    ).stdout


def evaluate(build: Path, kernel: list[str], header: str, rows: list[tuple]) -> np.ndarray:
    """Outputs of `contensou eval`."""
    text = "\n".join([header, *(",".join(repr(float(x)) for x in row) for row in rows)])
    out = program(build, ["drivers/contensou", "eval", *kernel], text + "\n")
    inputs = header.split(",")
    return np.array(
        [
            [float(value) for name, value in row.items() if name not in inputs]
            for row in csv.DictReader(io.StringIO(out))
        ]
    )


def lattice() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Nodes that symmetry leaves: indices, directions, radii inside of the ball, signs of R."""
    reach = NODES + MARGIN
    found = []
    along, across = range(reach + 1), range(-reach, reach + 1)
    # To and fro, so that neighbours follow each other.
    for spin in range(reach + 1):
        for i in along if spin % 2 == 0 else reversed(along):
            for j in across if i % 2 == 0 else reversed(across):
                if spin > 0 or j >= 0:
                    found.append((i, j, spin))
    index = np.array(found)
    radius = np.linalg.norm(index / NODES, axis=1)
    keep = (radius > 0) & (radius < 1 + MARGIN / NODES) & (abs(radius - 1) > 1e-9)
    index, radius = index[keep], radius[keep]
    direction = index / NODES / radius[:, None]
    outside = radius > 1
    return index, direction, np.where(outside, 2 - radius, radius), np.where(outside, -1, 1)


class Closed:
    """The closed part of the law for one g."""

    def __init__(self, build: Path, g: float, poisson: float) -> None:
        self.build, self.g = build, g
        c = evaluate(build, ["kalker"], "a_over_b,nu,chi", [(g, poisson, 0.0)])[0]
        c11, _, c22, _, c23, c33 = c
        self.linear = -FORCE_UNIT * np.array([[c11, 0, 0], [0, c22, c23], [0, -c23, c33]])
        spin = self.sliding(np.array([[0.0, 0.0, 1.0]]))
        self.scales = FORCE_UNIT * np.array([c11, c22, math.hypot(c23, c33 / spin[0, 2])])

    def sliding(self, creepages: np.ndarray) -> np.ndarray:
        """Full sliding."""
        a = math.sqrt(self.g)
        rows = [(1, a, 1 / a, 1, *creepage) for creepage in creepages]
        return evaluate(self.build, ["wrench"], "N,a,b,f,vx,vy,w", rows)

    def __call__(self, creepages: np.ndarray) -> np.ndarray:
        """Alpha L + beta W_exact."""
        tau = np.linalg.norm(creepages * self.scales, axis=1)
        s = np.minimum(tau * 4 / (3 * math.pi), 1)
        h = np.sqrt(1 - s * s)
        force = 1.5 * (s * np.arccos(s) + s**4 * (2 + h) / (3 * (1 + h) ** 2))
        share = force**4
        linear = creepages @ self.linear.T
        return ((force - share) / tau)[:, None] * linear + share[:, None] * self.sliding(creepages)


def wrenches(build: Path, elements: int, kept: Path | None) -> list[np.ndarray]:
    """R at the nodes for all g."""
    _, direction, radius, _ = lattice()
    z = direction * (BALL * radius / (1 - radius**2))[:, None]
    size2 = (z**2).sum(axis=1)
    fade = size2 / (size2 + FADE_IN**2)
    known = {}
    if kept and kept.exists():
        with np.load(kept) as file:
            known = dict(file)
    found = []
    for m in range(RATIOS):
        closed = Closed(build, math.exp(FIRST + m * STEP), POISSON)
        creepages = z / closed.scales
        name = f"{elements}_{FIRST + m * STEP:g}"
        if name not in known:
            lines = [f"{closed.g!r} {POISSON} {x!r} {y!r} {w!r}" for x, y, w in creepages.tolist()]
            out = program(
                build, ["tests/cost/creep_nodes"], "\n".join([str(elements), *lines]) + "\n"
            )
            known[name] = np.array([[float(x) for x in line.split()] for line in out.splitlines()])
            if kept:
                np.savez(kept, **known)
            print(f"ln g = {FIRST + m * STEP:g}", file=sys.stderr, flush=True)
        found.append((known[name] - closed(creepages)) / fade[:, None])
    return found


def whole(values: np.ndarray) -> np.ndarray:
    """The lattice of all signs, zero where nothing is known."""
    index, _, _, sign = lattice()
    reach = NODES + MARGIN
    full = np.zeros((2 * reach + 1,) * 3 + (3,))
    for (i, j, k), r in zip(index, sign[:, None] * values, strict=True):
        for mirror in (1, -1):
            for turn in (1, -1):
                at = reach + mirror * turn * i, reach + turn * j, reach + turn * k
                full[at] = turn * r * (mirror, 1, 1)
                if k == 0:
                    full[at[0], reach - turn * j, reach] = turn * r * (mirror, -1, -1)
    return full


def spline(values: np.ndarray, axis: int) -> np.ndarray:
    """Coefficients of the cubic spline along an axis, two more than values."""
    n = values.shape[axis]
    matrix = np.zeros((n + 2, n + 2))
    for i in range(n):
        matrix[i + 1, i : i + 3] = 1 / 6, 4 / 6, 1 / 6
    matrix[0, :5] = matrix[-1, -5:] = 1, -4, 6, -4, 1
    moved = np.moveaxis(values, axis, 0)
    ends = np.zeros((1, *moved.shape[1:]))
    solved = np.tensordot(np.linalg.inv(matrix), np.concatenate([ends, moved, ends]), 1)
    return np.moveaxis(solved, 0, axis)


def coefficients(remainders: list[np.ndarray]) -> np.ndarray:
    """Integers [ln g, spin, across, along, component]."""
    values = np.array([whole(r) for r in remainders])
    for axis in range(4):
        values = spline(values, axis)
    # Of the cells that the ball meets, with creepage along and spin not below zero.
    middle = NODES + MARGIN + 1
    kept = values[
        :,
        middle - 1 : middle + NODES + 2,
        middle - NODES - 1 : middle + NODES + 2,
        middle - 1 : middle + NODES + 2,
    ]
    used = np.zeros(kept.shape[1:4], dtype=bool)
    for i in range(NODES):
        for j in range(-NODES, NODES):
            for k in range(NODES):
                nearest = math.hypot(i, min(abs(j), abs(j + 1)), k)
                if nearest <= NODES:
                    used[i : i + 4, j + NODES : j + NODES + 4, k : k + 4] = True
    numbers = np.rint(kept * used[None, ..., None] / UNIT).astype(int)
    assert abs(numbers).max() < 2**15
    return np.transpose(numbers, (0, 3, 2, 1, 4))


def written(numbers: np.ndarray) -> str:
    """The module."""
    lines = [
        f"""\
!> Table of the law of creep `table`: coefficients of splines. Written by
!> scripts/generate_creep.py, which explains them.
module contensou_contact_creep_table_values
   use, intrinsic :: iso_fortran_env, only : int16
   use contensou_base_kinds, only : wp
   implicit none(type, external)
   private

   !> Nodes along a radius of the ball.
   integer, parameter, public :: nodes = {NODES}

   !> Scale z0 of the ball.
   real(wp), parameter, public :: ball = {BALL}_wp

   !> First ln g, and their distance.
   real(wp), parameter, public :: first_ratio = {FIRST}_wp, ratio_step = {STEP}_wp

   !> Number of ln g.
   integer, parameter, public :: n_ratios = {RATIOS}

   !> Unit of the coefficients.
   real(wp), parameter, public :: unit = {UNIT}_wp

   !> Coefficients by component of the wrench, place along, across and by spin, and ln g.
   integer(int16), protected, public :: correction(3, -1:nodes + 1, -nodes - 1:nodes + 1, &
      -1:nodes + 1, n_ratios + 2)
"""
    ]
    for m, ratio in enumerate(numbers):
        for k, part in enumerate(ratio):
            lines.append(f"   data correction(:, :, :, {k - 1}, {m + 1}) / &")
            words = [str(x) for x in part.reshape(-1)]
            line = "     "
            for position, word in enumerate(words):
                last = position == len(words) - 1
                piece = f" {word}" + ("/" if last else ",")
                if len(line) + len(piece) > 97:
                    lines.append(line + " &")
                    line = "     "
                line += piece
            lines.append(line)
    lines.append("\nend module contensou_contact_creep_table_values")
    return "\n".join(lines) + "\n"


def check(build: Path, number: int, seed: int) -> int:
    """Compare the law with boundary elements in random states."""
    draw = random.Random(seed)
    rows = []
    for _ in range(number):
        state = np.array([draw.gauss(0, 1) for _ in range(3)])
        state *= 10 ** draw.uniform(-1, 1.2) / np.linalg.norm(state)
        root = math.exp(0.5 * draw.uniform(FIRST, FIRST + STEP * (RATIOS - 1)))
        # N and G such that f N = f p0/G = 1.
        rows.append((1, root, 1 / root, 1, FORCE_UNIT, POISSON, *state, -1, 0))
    names = "N,a,b,f,G,nu,vx,vy,w,cx,cy"
    found, exact = (
        evaluate(build, ["creep", "--model", model], names, rows)
        for model in ("table", "boundary_elements")
    )
    error = abs(found - exact).max(axis=1)
    print(f"mean {error.mean():.4f}, worst {error.max():.4f} f N")
    return int(error.max() > 0.03)


def main() -> int:
    """Run the script."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--build", type=Path, required=True, help="built folder")
    parser.add_argument("--elements", type=int, default=28, help="elements across the spot")
    parser.add_argument("--wrenches", type=Path, help="file that keeps the wrenches")
    parser.add_argument("--check", type=int, metavar="N", help="compare N random wrenches")
    parser.add_argument("--seed", type=int, default=1, help="seed of the random wrenches")
    words = parser.parse_args()
    if words.check:
        return check(words.build, words.check, words.seed)
    numbers = coefficients(wrenches(words.build, words.elements, words.wrenches))
    TARGET.write_text(written(numbers))
    return 0


if __name__ == "__main__":
    sys.exit(main())
