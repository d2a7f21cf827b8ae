"""Cells as numbers, and statistics of those that are known."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tactile_maps.studies.base.rows import (
    bootstrap_interval,
    number,
    number_or,
    p95,
    rms,
    rms_interval,
)

NAN = math.nan
INF = math.inf


@pytest.mark.parametrize(("cell", "value"), [(2, 2.0), (0.5, 0.5), (True, 1.0), (INF, INF)])
def test_numeric_cell_is_read_as_a_number(cell, value):
    assert number(cell) == number_or(cell, 7.0) == value


@pytest.mark.parametrize("cell", [None, "", "3"])
def test_missing_cells_have_the_chosen_default(cell):
    assert number(cell) is None
    assert number_or(cell, INF) == INF


def test_statistics_use_only_finite_values():
    values = np.array([3.0, NAN, -4.0, INF])
    assert rms(values) == pytest.approx(math.sqrt(12.5))
    assert p95(np.array([*range(101), NAN], dtype=float)) == pytest.approx(95.0)


@pytest.mark.parametrize("values", [[], [NAN, INF]])
def test_statistics_without_values_are_unknown(values):
    assert rms(np.array(values)) is None
    assert p95(np.array(values)) is None


@pytest.mark.long
def test_bootstrap_interval_contains_the_truth_in_95_percent():
    held = 0
    random = np.random.default_rng(1)
    for _ in range(200):
        low, high = bootstrap_interval(random.normal(3.0, 1.0, 60), lambda rows: rows.mean(axis=1))
        held += low <= 3.0 <= high
    assert 0.9 <= held / 200 <= 0.99


def test_interval_of_a_root_mean_square_contains_the_truth_in_95_percent():
    held = 0
    random = np.random.default_rng(2)
    for _ in range(400):
        low, high = rms_interval(random.laplace(0.0, 1.0, 3000))  # of variance 2
        held += low <= math.sqrt(2.0) <= high
    assert 0.92 <= held / 400 <= 0.98
    assert rms_interval(np.zeros(40)) == (0.0, 0.0)
    assert rms_interval(np.ones(29)) is None
