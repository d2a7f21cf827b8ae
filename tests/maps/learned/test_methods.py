"""Properties of every builder."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.core.errors import MapError
from tactile_maps.maps.learned.methods import LEARNING_METHODS


def test_method_names_match_the_methods(touched_sheet):
    assert len(LEARNING_METHODS) == 5
    assert [build(touched_sheet[1][:400]).method for build in LEARNING_METHODS.values()] == list(LEARNING_METHODS)


@pytest.mark.long
@pytest.mark.sampled(2)
@pytest.mark.parametrize("method", LEARNING_METHODS)
def test_dead_taxel_is_named_and_does_not_affect_others(method, touched_sheet, misfit, true_places):
    readings = touched_sheet[1].copy()
    readings[:, [7, 40]] = 0.0
    learned = LEARNING_METHODS[method](readings)
    (note,) = learned.findings
    assert (note.kind, note.where) == ("taxels-never-touched", "taxels 7, 40")
    assert np.flatnonzero(~learned.placed).tolist() == [7, 40]
    points = learned.points.copy()
    whole = LEARNING_METHODS[method](touched_sheet[1]).points
    apart = [np.linalg.norm(p[:, None] - p[None], axis=-1)[learned.placed][:, learned.placed] for p in (points, whole)]
    assert np.corrcoef(apart[0].ravel(), apart[1].ravel())[0, 1] > 0.98


@pytest.mark.parametrize("method", LEARNING_METHODS)
def test_untouched_skin_is_rejected(method):
    with pytest.raises(MapError, match="too few taxels"):
        LEARNING_METHODS[method](np.zeros((50, 9)))


@pytest.mark.sampled(2)
@pytest.mark.parametrize("method", LEARNING_METHODS)
def test_progress_is_reported_and_may_cancel(method, touched_sheet):
    reported = []
    LEARNING_METHODS[method](touched_sheet[1], progress=lambda text, fraction: reported.append((text, fraction)))
    assert reported
    assert all(text and 0 <= fraction <= 1 for text, fraction in reported)

    def cancel(_text, _fraction):
        raise InterruptedError

    with pytest.raises(InterruptedError):
        LEARNING_METHODS[method](touched_sheet[1], progress=cancel)
