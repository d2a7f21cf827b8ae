"""Information distance finds a flat sheet."""

from __future__ import annotations

import numpy as np

from app.maps.learned.information_distance import build, unlikeness
from app.maps.learned.readings import felt


def test_taxels_of_a_sheet_lie_where_they_lie(touched_sheet, misfit):
    learned = build(touched_sheet[1])
    assert learned.method == "information-distance"
    assert learned.findings == ()
    assert learned.placed.all()
    assert misfit(learned.points) < 0.5
    assert learned.stress < 0.1


def test_how_hard_touches_are_does_not_matter(touched_sheet):
    """Any growing function of the pressure has the same levels."""
    touch = felt(np.where(touched_sheet[1] > 5e4, touched_sheet[1], 0.0))
    assert np.allclose(unlikeness(touch), unlikeness(felt(touch.pressures.toarray() ** 3)))


def test_pairs_never_touched_together_are_unknown(touched_sheet):
    touch = felt(touched_sheet[1])
    assert np.array_equal(np.isinf(unlikeness(touch)), ~touch.together)
    assert np.isinf(unlikeness(touch)).any()
