"""Coincidence in time: traces, coupling and the sheet."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import csr_matrix

from tactile_maps.maps.learned.readings import detect_touch
from tactile_maps.maps.learned.temporal_correlation import build, dissimilarity, traces


def test_trace_decays_by_e_within_its_time_constant():
    pulse = np.zeros((40, 1))
    pulse[2] = 5.0
    trace = traces(csr_matrix(pulse), fading=4.0).toarray().ravel()
    assert trace[:2].tolist() == [0, 0]
    assert trace[2] == 5
    assert trace[6] == pytest.approx(5 / np.e)
    assert trace[39] == 0, "forgotten"


def test_correlation_without_memory_is_the_cosine():
    signals = np.random.default_rng(9).random((50, 4))
    norms = np.linalg.norm(signals, axis=0)
    expected = np.sqrt(-np.log(np.minimum(signals.T @ signals / np.outer(norms, norms), 1)))
    assert np.allclose(dissimilarity(detect_touch(signals), fading=1), expected, atol=1e-7)


def test_taxels_pressed_in_quick_succession_are_near():
    order = np.eye(4)[np.array([0, 1, 2, 3] * 30)]
    order[::4] *= 1.0
    gaps = np.zeros((120 * 5, 4))
    gaps[np.arange(120) // 4 * 20 + np.arange(120) % 4] = order
    unlike = dissimilarity(detect_touch(gaps), fading=2)
    assert unlike[0, 1] < unlike[0, 2] < unlike[0, 3] < np.inf
    assert np.isinf(dissimilarity(detect_touch(gaps), fading=1)[0, 1]), "at the same moment they never fire"


def test_taxels_of_a_sheet_are_learned_at_their_positions(touched_sheet, misfit):
    learned = build(touched_sheet[1])
    assert learned.method == "temporal-correlation"
    assert misfit(learned.points) < 0.5
