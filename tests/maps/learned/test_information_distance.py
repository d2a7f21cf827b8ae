"""The information distance, and the map made from it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import csr_matrix

from tactile_maps.maps.learned.information_distance import adaptive_levels, build, dissimilarity, information_distance
from tactile_maps.maps.learned.readings import detect_touch

BINS = 4


@pytest.fixture(scope="module")
def levels():
    drawn = np.random.default_rng(1).integers(0, BINS, size=(200, 7))
    drawn[:, 3] = (drawn[:, 2] * 3) % BINS  # a renaming of column 2
    drawn[:, 4] = 0
    drawn[:, 5] = np.minimum(drawn[:, 6], 1)  # less than column 6
    return drawn


def _entropy(*columns):
    _, counts = np.unique(np.stack(columns), axis=1, return_counts=True)
    share = counts / counts.sum()
    return -(share * np.log2(share)).sum()


def test_distance_follows_the_definition(levels):
    found = information_distance(csr_matrix(levels, dtype=float), bins=BINS)
    for i, x in enumerate(levels.T):
        for j, y in enumerate(levels.T):
            joint = _entropy(x, y)
            expected = 0 if i == j or joint == 0 else (2 * joint - _entropy(x) - _entropy(y)) / joint
            assert found[i, j] == pytest.approx(expected, abs=1e-12)


def test_distance_is_a_metric_from_0_to_1(levels):
    found = information_distance(csr_matrix(levels, dtype=float), bins=BINS)
    assert found.min() == 0
    assert found.max() <= 1 + 1e-12
    assert (found[:, :, None] + found[None] >= found[:, None, :] - 1e-12).all()
    assert found[2, 3] == pytest.approx(0, abs=1e-12), "a renamed signal is fully informative"
    assert found[0, 1] > 0.9, "independent signals share no information"
    assert found[4, 0] == pytest.approx(1, abs=1e-12), "a silent signal carries no information"


def test_touch_levels_are_equally_frequent_and_rest_is_a_separate_level():
    pressures = np.random.default_rng(2).exponential(size=(3000, 3)) * (
        np.random.default_rng(3).random((3000, 3)) < 0.2
    )
    levels = adaptive_levels(csr_matrix(pressures), bins=5).toarray()
    assert np.array_equal(levels == 0, pressures == 0)
    for column, values in zip(levels.T, pressures.T, strict=True):
        counts = np.bincount(column.astype(int))[1:]
        assert len(counts) == 4
        assert np.ptp(counts) <= 1
        assert values[column == 1].max() < values[column == 2].min()


def test_equal_pressures_share_a_level():
    levels = adaptive_levels(csr_matrix(np.array([[7.0], [7], [0], [7], [9]])), bins=3).toarray().ravel()
    assert len(set(levels[[0, 1, 3]])) == 1


def test_taxels_of_a_sheet_are_learned_at_their_positions(touched_sheet, misfit):
    learned = build(touched_sheet[1])
    assert learned.method == "information-distance"
    assert learned.findings == ()
    assert learned.placed.all()
    assert misfit(learned.points) < 0.5
    assert learned.stress < 0.1


def test_distance_does_not_depend_on_touch_force(touched_sheet):
    """Any growing function of the pressure has the same levels."""
    touch = detect_touch(np.where(touched_sheet[1] > 5e4, touched_sheet[1], 0.0))
    assert np.allclose(dissimilarity(touch), dissimilarity(detect_touch(touch.pressures.toarray() ** 3)))


def test_pairs_never_touched_together_are_unknown(touched_sheet):
    touch = detect_touch(touched_sheet[1])
    assert np.array_equal(np.isinf(dissimilarity(touch)), ~touch.together)
    assert np.isinf(dissimilarity(touch)).any()
