"""Correlation between taxels, and the map made from it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import csr_matrix

from tactile_maps.maps.learned.human_touch import build, cross_correlation, dissimilarity
from tactile_maps.maps.learned.readings import detect_touch
from tactile_maps.tactile.babbling import BabbleSpec, babble


@pytest.fixture(scope="module")
def signals():
    generator = np.random.default_rng(8)
    return generator.exponential(size=(400, 5)) * (generator.random((400, 5)) < 0.3)


def test_similarity_without_lag_is_the_pearson_correlation(signals):
    sparse = csr_matrix(signals)
    assert np.allclose(cross_correlation(sparse, sparse), np.corrcoef(signals.T))


def test_delayed_copy_correlates_at_its_lag_and_in_its_direction(signals):
    delayed = np.roll(signals[:, :1], 3, axis=0)
    first = csr_matrix(signals[:, :1])
    second = csr_matrix(delayed)
    assert cross_correlation(first, second, lag=3)[0, 0] == pytest.approx(1, abs=0.03)
    assert abs(cross_correlation(first, second)[0, 0]) < 0.2
    assert abs(cross_correlation(second, first, lag=3)[0, 0]) < 0.2


def test_constant_signal_correlates_with_nothing(signals):
    constant = csr_matrix(np.ones((400, 1)))
    assert not cross_correlation(constant, csr_matrix(signals)).any()


@pytest.mark.long
def test_strokes_over_a_sheet_determine_its_taxel_positions(touched_sheet, misfit):
    strokes = babble(touched_sheet[0], BabbleSpec(touches=150, samples=10, rest=4))
    learned = build(strokes)
    assert learned.method == "human-touch"
    assert misfit(learned.points) < 0.5


def test_neighbour_touched_later_is_as_near_as_one_touched_simultaneously():
    generator = np.random.default_rng(10)
    strokes = np.repeat(generator.random(200) < 0.3, 3)
    source = generator.random(600) * strokes
    readings = np.stack([source, np.roll(source, 2), generator.random(600)], axis=1)
    touch = detect_touch(readings)
    assert touch.together[0, 1]
    unlike = dissimilarity(touch, lags=2)
    assert unlike[0, 1] < 0.2
    assert unlike[1, 0] == unlike[0, 1], "whichever came first"
    assert dissimilarity(touch, lags=1)[0, 1] > 1


def test_pairs_never_touched_together_are_unknown(touched_sheet):
    touch = detect_touch(touched_sheet[1])
    assert np.array_equal(np.isinf(dissimilarity(touch, lags=2)), ~touch.together)
