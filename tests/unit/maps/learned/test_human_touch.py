"""Correlation over strokes."""

from __future__ import annotations

import numpy as np

from app.maps.learned.human_touch import build, unlikeness
from app.maps.learned.readings import felt
from app.touch.babbling import BabbleSpec, babble


def test_strokes_over_a_sheet_place_its_taxels(touched_sheet, misfit):
    strokes = babble(touched_sheet[0], BabbleSpec(touches=150, samples=10, rest=4))
    learned = build(strokes)
    assert learned.method == "human-touch"
    assert misfit(learned.points) < 0.5


def test_a_neighbour_reached_later_is_as_near_as_one_at_once():
    generator = np.random.default_rng(10)
    strokes = np.repeat(generator.random(200) < 0.3, 3)
    source = generator.random(600) * strokes
    readings = np.stack([source, np.roll(source, 2), generator.random(600)], axis=1)
    touch = felt(readings)
    assert touch.together[0, 1]
    unlike = unlikeness(touch, lags=2)
    assert unlike[0, 1] < 0.2
    assert unlike[1, 0] == unlike[0, 1], "whichever came first"
    assert unlikeness(touch, lags=1)[0, 1] > 1


def test_pairs_never_touched_together_are_unknown(touched_sheet):
    touch = felt(touched_sheet[1])
    assert np.array_equal(np.isinf(unlikeness(touch, lags=2)), ~touch.together)
