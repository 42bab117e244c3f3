"""Rows of a motion thinned out to keys, between which it is interpolated within a tolerance.

Blocks of rows are halved until each is met by the interpolation between its ends; all blocks of a
length are tested at once. A block of two neighbouring rows always passes: nothing is known between.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

LONGEST = 1 << 14
PROBES = 9
PORTION = 1 << 16  # rows that are tested at a time

Error = Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]


def keys(rows: int, error: Error) -> np.ndarray:
    """Numbers of the rows to keep, the first and the last always.

    `error(first, last, between)` tells how far the rows `between` (blocks, rows) are from the
    interpolation from `first` to `last` (blocks,), in parts of the tolerance.
    """
    if rows < 2:
        return np.arange(rows)
    # Few rows are no block of many, or each of thousands of bodies would cost as many.
    length = min(LONGEST, 1 << (rows - 2).bit_length())
    starts = np.arange(0, rows - 1, length)
    kept = [starts, np.array([rows - 1])]
    while length > 1 and len(starts):
        ends = np.minimum(starts + length, rows - 1)
        bad = np.zeros(len(starts), dtype=bool)
        count = min(PROBES, length - 1)
        for part in portions(len(starts), count):
            bad[part] = fails(error, starts[part], ends[part], count)
        if count < length - 1:
            rest = np.flatnonzero(~bad)
            for part in portions(len(rest), length - 1):
                at = rest[part]
                bad[at] = fails(error, starts[at], ends[at], length - 1)
        length //= 2
        starts = starts[bad]
        middles = starts + length
        middles = middles[middles < np.minimum(starts + 2 * length, rows - 1)]
        kept.append(middles)
        starts = np.sort(np.concatenate([starts, middles]))
    return np.unique(np.concatenate(kept))


def portions(blocks: int, rows: int) -> list[slice]:
    """Slices of the blocks that have a bounded number of rows each."""
    step = max(1, PORTION // max(rows, 1))
    return [slice(i, i + step) for i in range(0, blocks, step)]


def fails(error: Error, first: np.ndarray, last: np.ndarray, count: int) -> np.ndarray:
    """Whether one of `count` rows, evenly spread in each block, is off by more than the tolerance.
    Rows behind the end of a short block count as its last one."""
    steps = np.arange(1, count + 1)
    # All rows where there are as many.
    between = first[:, None] + steps * np.maximum(last - first, 1)[:, None] // (count + 1)
    whole = last - first - 1 <= count
    between[whole] = first[whole, None] + steps
    between = np.minimum(between, last[:, None])
    return ~(error(first, last, between) <= 1).all(axis=1)


def shares(time: np.ndarray, first: np.ndarray, last: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Where rows stand between the ends of their block, from 0 to 1."""
    start = time[first][:, None]
    return (time[at] - start) / (time[last][:, None] - start)


def line_error(time: np.ndarray, values: np.ndarray, tolerance: np.ndarray | float) -> Error:
    """Error of straight lines between values (rows, components) in parts of the tolerance."""

    def error(first: np.ndarray, last: np.ndarray, at: np.ndarray) -> np.ndarray:
        share = shares(time, first, last, at)[..., None]
        drawn = values[first][:, None] * (1 - share) + values[last][:, None] * share
        return np.max(np.abs(drawn - values[at]) / tolerance, axis=-1)

    return error


def distance_error(time: np.ndarray, values: np.ndarray, tolerance: float) -> Error:
    """Distance of straight lines from points (rows, 3) in parts of the tolerance."""

    def error(first: np.ndarray, last: np.ndarray, at: np.ndarray) -> np.ndarray:
        share = shares(time, first, last, at)[..., None]
        drawn = values[first][:, None] * (1 - share) + values[last][:, None] * share
        return np.linalg.norm(drawn - values[at], axis=-1) / tolerance

    return error


def turn_error(
    time: np.ndarray, quaternion: np.ndarray, turned: np.ndarray, tolerance: float
) -> Error:
    """Angle of interpolated attitudes in parts of the tolerance [rad].

    Between two keys a body turns by the integral of its angular velocity, as many turns as that
    has, and by the small rotation that then remains, both in proportion to time.
    """

    def error(first: np.ndarray, last: np.ndarray, at: np.ndarray) -> np.ndarray:
        share = shares(time, first, last, at)[..., None]
        drawn = between(
            quaternion[first][:, None],
            quaternion[last][:, None],
            (turned[last] - turned[first])[:, None],
            share,
        )
        cosine = np.minimum(np.abs(np.sum(drawn * quaternion[at], axis=-1)), 1)
        return 2 * np.arccos(cosine) / tolerance

    return error


def between(first: np.ndarray, last: np.ndarray, turn: np.ndarray, share: np.ndarray) -> np.ndarray:
    """The attitude between two, w, x, y, z: exp(share rest) exp(share turn) first."""
    rest = logarithm(product(last, conjugate(product(exponential(turn), first))))
    return product(exponential(share * rest), product(exponential(share * turn), first))


def integral(time: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """Integral over time of a rate (rows, 3), by the trapezoidal rule."""
    total = np.zeros_like(rate)
    np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(time)[:, None], axis=0, out=total[1:])
    return total


def product(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Product of quaternions w, x, y, z."""
    pw, px, py, pz = np.moveaxis(p, -1, 0)
    qw, qx, qy, qz = np.moveaxis(q, -1, 0)
    return np.stack(
        [
            pw * qw - px * qx - py * qy - pz * qz,
            pw * qx + px * qw + py * qz - pz * qy,
            pw * qy - px * qz + py * qw + pz * qx,
            pw * qz + px * qy - py * qx + pz * qw,
        ],
        axis=-1,
    )


def conjugate(q: np.ndarray) -> np.ndarray:
    """The inverse of a unit quaternion."""
    return q * np.array([1.0, -1.0, -1.0, -1.0])


def exponential(vector: np.ndarray) -> np.ndarray:
    """The quaternion of a rotation vector [rad]."""
    half = 0.5 * np.linalg.norm(vector, axis=-1, keepdims=True)
    return np.concatenate([np.cos(half), 0.5 * np.sinc(half / np.pi) * vector], axis=-1)


def logarithm(q: np.ndarray) -> np.ndarray:
    """The shorter rotation vector of a quaternion [rad]."""
    q = np.where(q[..., :1] < 0, -q, q)
    sine = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
    angle = 2 * np.arctan2(sine, q[..., :1])
    return q[..., 1:] * np.where(sine > 1e-12, angle / np.maximum(sine, 1e-12), 2.0)


def matrices(q: np.ndarray) -> np.ndarray:
    """Rotation matrices of quaternions w, x, y, z (..., 4)."""
    w, x, y, z = np.moveaxis(q, -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def quaternions(frames: np.ndarray) -> np.ndarray:
    """Quaternions of rotation matrices (rows, 3, 3), one next to the other of the same sign."""
    m = np.asarray(frames)
    diagonal = np.stack([m[:, 0, 0], m[:, 1, 1], m[:, 2, 2]], axis=1)
    squares = np.concatenate(
        [1 + diagonal.sum(axis=1, keepdims=True), 1 + 2 * diagonal - diagonal.sum(1)[:, None]], 1
    )
    q = np.empty((len(m), 4))
    best = squares.argmax(axis=1)
    for k in range(4):
        at = best == k
        a = m[at]
        root = np.sqrt(squares[at, k])
        if k == 0:
            parts = [
                root * root,
                a[:, 2, 1] - a[:, 1, 2],
                a[:, 0, 2] - a[:, 2, 0],
                a[:, 1, 0] - a[:, 0, 1],
            ]
        else:
            i, j, n = k - 1, k % 3, (k + 1) % 3
            parts = [a[:, n, j] - a[:, j, n], None, None, None]
            parts[1 + i] = root * root
            parts[1 + j] = a[:, j, i] + a[:, i, j]
            parts[1 + n] = a[:, n, i] + a[:, i, n]
        q[at] = np.stack(parts, axis=1) / (2 * root[:, None])
    signs = np.where(np.sum(q[1:] * q[:-1], axis=1) < 0, -1.0, 1.0)
    q[1:] *= np.cumprod(signs)[:, None]
    return q
