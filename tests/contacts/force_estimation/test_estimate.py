"""Input and output of estimators, and the sum of pressure times area."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.contacts.force_estimation.estimate import (
    AreaSum,
    EstimateRefusal,
    ForceEstimate,
    Wrench,
    numerical_rank,
)
from tactile_maps.core.errors import MapError
from tests.contacts.force_estimation.readings_by_hand import SKIN, reading


@pytest.mark.parametrize("value", [[1.0, 2.0], [1.0, 2.0, float("nan")]])
def test_wrench_is_six_finite_numbers(value):
    with pytest.raises(MapError, match="three finite numbers"):
        Wrench(np.array(value), np.zeros(3))


def test_misfit_is_residual_over_noise():
    assert ForceEstimate(1.0, None, residual=200.0, noise=100.0).misfit == 2.0
    assert ForceEstimate(1.0, None, residual=200.0).misfit == float("inf")
    assert ForceEstimate(1.0, None).misfit == 0.0


FALLING = np.array([1.0, 0.5, 0.1, 0.01])


def test_rank_is_full_without_noise():
    rank = numerical_rank(FALLING, np.ones(4), 0.0, unknowns=4)
    assert (rank.effective, rank.condition) == (4, 100.0)
    assert rank.refusal is None


def test_noise_reduces_the_effective_rank():
    assert numerical_rank(FALLING, np.ones(4), 0.05, unknowns=4).effective == 3
    assert numerical_rank(FALLING, np.ones(4), 0.2, unknowns=4).effective == 2
    assert numerical_rank(FALLING, np.ones(4), 0.2, unknowns=4).refusal is None, "half is enough"
    rank = numerical_rank(FALLING, np.ones(4), 0.7, unknowns=4)
    assert rank.effective == 1
    assert rank.refusal is EstimateRefusal.RANK


def test_rank_without_signal_is_zero():
    assert numerical_rank(FALLING, np.zeros(4), 1.0, unknowns=4).effective == 0
    assert numerical_rank(np.zeros(4), np.ones(4), 0.0, unknowns=4).effective == 0
    assert numerical_rank(np.zeros(0), np.zeros(0), 0.0, unknowns=0).condition == float("inf")


def test_fewer_readings_than_unknowns_are_singular():
    rank = numerical_rank(FALLING, np.ones(4), 0.0, unknowns=9)
    assert rank.condition == float("inf")
    assert rank.refusal is EstimateRefusal.RANK


@pytest.mark.parametrize("depth", [0.0, 0.002, 0.005])
def test_area_sum_equals_the_force_of_the_region(depth):
    given = reading(depth=depth)
    found = AreaSum(SKIN).estimate(given)
    assert found.force == pytest.approx(given.region.force, rel=1e-12)
    assert found.force == pytest.approx(10.0, rel=0.05)
    assert found.at == given.region.at
    assert found.forces.sum() == pytest.approx(found.force)
    assert (found.condition, found.effective_rank) == (1.0, found.unknowns)
    assert found.refused is None
    assert found.misfit == 0.0
