"""What readings tell of a distribution."""

from __future__ import annotations

import numpy as np

from app.contacts.estimators.rank import rank_of

FALLING = np.array([1.0, 0.5, 0.1, 0.01])


def test_without_noise_all_can_be_told():
    rank = rank_of(FALLING, np.ones(4), 0.0, unknowns=4)
    assert (rank.effective, rank.condition) == (4, 100.0)
    assert rank.refusal == ""


def test_noise_hides_what_is_weak():
    assert rank_of(FALLING, np.ones(4), 0.05, unknowns=4).effective == 3
    assert rank_of(FALLING, np.ones(4), 0.2, unknowns=4).effective == 2
    assert rank_of(FALLING, np.ones(4), 0.2, unknowns=4).refusal == "", "half is enough"
    rank = rank_of(FALLING, np.ones(4), 0.7, unknowns=4)
    assert rank.effective == 1
    assert "1 of 4" in rank.refusal


def test_readings_of_nothing_tell_nothing():
    assert rank_of(FALLING, np.zeros(4), 1.0, unknowns=4).effective == 0
    assert rank_of(np.zeros(4), np.ones(4), 0.0, unknowns=4).effective == 0
    assert rank_of(np.zeros(0), np.zeros(0), 0.0, unknowns=0).condition == float("inf")


def test_fewer_readings_than_unknowns_are_singular():
    rank = rank_of(FALLING, np.ones(4), 0.0, unknowns=9)
    assert rank.condition == float("inf")
    assert rank.refusal


def test_two_equal_taxels_are_one():
    """Duplicates make two equal rows: one unknown less can be told."""
    matrix = np.eye(4)[[0, 0, 2, 3]]
    values = np.linalg.svd(matrix, compute_uv=False)
    assert rank_of(values, np.ones(4), 0.0, unknowns=4).effective == 3
