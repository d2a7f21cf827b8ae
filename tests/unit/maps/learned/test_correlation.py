"""Sparse correlation against numpy's."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import csr_matrix

from app.maps.learned.correlation import cross_correlation


@pytest.fixture(scope="module")
def signals():
    generator = np.random.default_rng(8)
    return generator.exponential(size=(400, 5)) * (generator.random((400, 5)) < 0.3)


def test_at_once_it_is_pearsons(signals):
    sparse = csr_matrix(signals)
    assert np.allclose(cross_correlation(sparse, sparse), np.corrcoef(signals.T))


def test_a_delayed_copy_correlates_at_its_lag_and_in_its_direction(signals):
    delayed = np.roll(signals[:, :1], 3, axis=0)
    first, second = csr_matrix(signals[:, :1]), csr_matrix(delayed)
    assert cross_correlation(first, second, lag=3)[0, 0] == pytest.approx(1, abs=0.03)
    assert abs(cross_correlation(first, second)[0, 0]) < 0.2
    assert abs(cross_correlation(second, first, lag=3)[0, 0]) < 0.2


def test_what_never_changes_correlates_with_nothing(signals):
    constant = csr_matrix(np.ones((400, 1)))
    assert not cross_correlation(constant, csr_matrix(signals)).any()
