"""Random states of every law of creep: no wrench drives.

    python tests/campaigns/creep.py EXECUTABLE [NUMBER [FIRST [LAW...]]]

evaluates NUMBER (1,000,000) states, from seed FIRST (1) on, of each law; a law may have a number of
elements behind a colon. Of `boundary_elements` with as many as they usually have it takes a
thousandth: ratios of the axes from 1/25 to 25, Poisson's ratios from 0 to 1/2,
creepages over six decades about their scale, spin over another two, rolling in every direction or
not at all. Reports states in which F.v + T w is above zero, the force is above 1.001 f N, or
something is not finite. `linear` has no bound, and no value where nothing rolls. Exit status 1 if
there are any. The tests do a few.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np

NAMES = "N,a,b,f,G,nu,vx,vy,w,cx,cy"
LAWS = (
    *("sliding", "linear", "strip", "polach", "fastsim", "brush", "table"),
    *("boundary_elements:8", "boundary_elements"),
)
BLOCK = 20000


def states(seed: int, number: int) -> np.ndarray:
    """Random states."""
    draw = np.random.default_rng(seed)
    load, modulus = 10 ** draw.uniform(0, 5, number), 10 ** draw.uniform(7, 11, number)
    size, root = 10 ** draw.uniform(-4, -2, number), 5 ** draw.uniform(-1, 1, number)
    friction, poisson = draw.uniform(0.05, 1, number), draw.uniform(0, 0.5, number)
    scale = 1.5 * friction * load / (np.pi * size**2 * modulus)
    velocity = draw.normal(size=(number, 3)) * (scale * 10 ** draw.uniform(-3, 3, number))[:, None]
    velocity[:, 2] *= 10 ** draw.uniform(-1, 1, number) / size
    rolling = draw.normal(size=(number, 2))
    # Along an axis, and none.
    rolling[draw.random(number) < 0.1, 1] = 0
    rolling[draw.random(number) < 0.01] = 0
    fixed = (load, size * root, size / root, friction, modulus, poisson)
    return np.column_stack([*fixed, velocity, rolling])


def wrenches(executable: Path, law: str, rows: np.ndarray) -> np.ndarray:
    """Fx, Fy and Tz of the states."""
    lines = (",".join(map(repr, row)) for row in rows.tolist())
    model, _, elements = law.partition(":")
    words = ["--model", model, *(["--elements", elements] if elements else [])]
    done = subprocess.run(
        [executable, "eval", "creep", *words],
        input="\n".join([NAMES, *lines]) + "\n",
        capture_output=True,
        text=True,
        check=True,
    )
    values = [line.split(",")[-3:] for line in done.stdout.splitlines()[1:]]
    return np.array(values, dtype=float)


def faults(executable: Path, law: str, seed: int, number: int) -> tuple[int, float, float]:
    """States that are wrong; the largest power over that of full sliding, and force over f N."""
    wrong, power, force = 0, -np.inf, 0.0
    for block in range(0, number, BLOCK):
        rows = states(seed + block, min(BLOCK, number - block))
        if law == "linear":
            rows = rows[np.hypot(rows[:, 9], rows[:, 10]) > 0]
        found = wrenches(executable, law, rows)
        limit = rows[:, 0] * rows[:, 3]
        size = np.sqrt(rows[:, 1] * rows[:, 2])
        speed = np.sqrt((rows[:, 6:8] ** 2).sum(axis=1) + (size * rows[:, 8]) ** 2)
        driven = (found * rows[:, 6:9]).sum(axis=1) / (limit * speed)
        pulled = np.hypot(found[:, 0], found[:, 1]) / limit
        bad = ~np.isfinite(found).all(axis=1) | (driven > 0)
        if law != "linear":
            bad |= pulled > 1.001
        wrong += int(bad.sum())
        power, force = max(power, driven.max()), max(force, pulled.max())
        for row in rows[bad][:3]:
            print(f"  {law}: " + ",".join(map(repr, row.tolist())))
    return wrong, power, force


def main() -> int:
    """Run the campaign."""
    executable = Path(sys.argv[1]).resolve()
    number = int(sys.argv[2]) if len(sys.argv) > 2 else 1000000
    seed = int(sys.argv[3]) if len(sys.argv) > 3 else 1
    total = 0
    for law in sys.argv[4:] or LAWS:
        n = -(-number // 1000) if law == "boundary_elements" else number
        wrong, power, force = faults(executable, law, seed, n)
        print(f"{law}: {wrong} of {n} states; power {power:.1e}, force {force:.6f}", flush=True)
        total += wrong
    return int(total > 0)


if __name__ == "__main__":
    sys.exit(main())
