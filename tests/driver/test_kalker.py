"""Kalker's coefficients by way of `contensou eval kalker`."""

from __future__ import annotations

import csv
import io
import math

import numpy as np
import pytest
import reference_tables

NAMES = ("C11", "C12", "C22", "C13", "C23", "C33")


@pytest.fixture
def kalker(run):
    """Function from rows of a/b, nu and chi [deg] to those of the coefficients."""

    def evaluate(rows):
        lines = [",".join(repr(float(x)) for x in row) for row in rows]
        done = run("eval", "kalker", input="\n".join(["a_over_b,nu,chi", *lines]) + "\n")
        assert done.status == 0, done.err
        found = csv.DictReader(io.StringIO(done.out))
        return np.array([[float(row[name]) for name in NAMES] for row in found])

    return evaluate


@pytest.fixture
def spots():
    """Ratios from 1/20 to 20, Poisson's ratios from 0 to 1/2, directions at random."""
    draw = np.random.default_rng(19)
    ratio = 20 ** draw.uniform(-1, 1, 200)
    return np.column_stack([ratio, draw.uniform(0, 0.5, 200), draw.uniform(-180, 180, 200)])


def test_references(kalker):
    table = reference_tables.table("kalker.csv")
    expected = np.array([[row[name] for name in NAMES] for row in table])
    rows = [(row["a_over_b"], row["nu"], row["chi_deg"]) for row in table]
    # C12 and C13 vanish along the axes: against the largest of their kind.
    size = np.abs(expected)
    size[:, 1] = np.maximum(size[:, 0], size[:, 2])
    size[:, 3] = size[:, 4]
    error = (np.abs(kalker(rows) - expected) / size).max(axis=1)
    ratio = np.array([row["a_over_b"] for row in table])
    assert error[(ratio >= 0.3) & (ratio <= 3)].max() <= 1e-3
    assert error[(ratio >= 0.2) & (ratio <= 5)].max() <= 5e-3


def test_without_contraction(kalker, spots):
    along = kalker([(ratio, 0, 0) for ratio, _, _ in spots])
    np.testing.assert_allclose(along[:, 0], along[:, 2], rtol=1e-6)
    circle = kalker([(1, 0, chi) for chi in (0, 30, 77)])
    np.testing.assert_allclose(circle[:, 0], 32 / (3 * math.pi), rtol=1e-5)
    np.testing.assert_allclose(circle[:, 4], 4 / 3, rtol=1e-5)


def test_axes_exchanged_and_mirrors(kalker, spots):
    found = kalker(spots)
    assert np.isfinite(found).all()
    assert (found[:, 0] * found[:, 2] > found[:, 1] ** 2).all()
    assert (found[:, 5] > 0).all()
    turned = kalker(spots * (1, 1, 1) + (0, 0, 90))
    other = kalker(np.column_stack([1 / spots[:, 0], spots[:, 1:]]))
    np.testing.assert_allclose(turned, other, rtol=1e-9, atol=1e-9)
    mirror = kalker(spots * (1, 1, -1)) * (1, -1, 1, -1, 1, 1)
    np.testing.assert_allclose(mirror, found, rtol=1e-9, atol=1e-9)
