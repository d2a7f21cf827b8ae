"""Touch is distinguished from noise, and silent taxels are named."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.core.errors import MapError
from tactile_maps.maps.learned.readings import detect_touch


def _noisy(touches):
    noise = np.random.default_rng(0).normal(scale=50.0, size=(2000, 6))
    return noise + touches


def test_exact_readings_are_unchanged():
    readings = np.array([[0.0, 3, 0, 1], [2, 0, 5, 0], [0, 1e-9, 0, 7]])
    touch = detect_touch(readings)
    assert np.array_equal(touch.pressures.toarray(), readings)
    assert touch.findings == ()


def test_noise_is_not_a_touch_for_any_rate_of_touches():
    touches = np.zeros((2000, 6))
    touches[:1500, 0] = 2000.0
    touches[::2, 1] = 3000.0
    touches[5:8, 2] = 1000.0
    touch = detect_touch(_noisy(touches))
    assert touch.taxels.tolist() == [0, 1, 2]
    assert np.array_equal(touch.pressures.toarray() > 0, touches[:, :3] > 0)


def test_silent_taxels_are_named_and_placed_at_the_centre_of_the_others():
    touches = np.zeros((2000, 6))
    touches[3:9, [0, 2, 3, 5]] = 1000.0
    touch = detect_touch(_noisy(touches))
    (note,) = touch.findings
    assert (note.kind, note.where, note.count) == ("taxels-never-touched", "taxels 1, 4", 2)
    points, placed = touch.everywhere(np.array([[0.0, 0], [4, 0], [0, 4], [4, 4]]))
    assert placed.tolist() == [True, False, True, True, False, True]
    assert points[[1, 4]].tolist() == [[2, 2], [2, 2]]
    assert points[3].tolist() == [0, 4]


def test_taxels_count_as_touched_together_only_at_the_same_time():
    touch = detect_touch(np.array([[1.0, 2, 0, 0], [0, 0, 3, 0], [0, 0, 0, 1]]))
    assert touch.together.tolist() == [[1, 1, 0, 0], [1, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]


def test_taxels_never_pressed_together_are_not_related():
    """Half of the time the first two, else the last two; by chance once, the outer ones."""
    moments = np.array([[1.0, 1, 0, 0], [0, 0, 1, 1]] * 10 + [[1, 0, 0, 1]])
    assert detect_touch(moments).together.tolist() == [[1, 1, 0, 0], [1, 1, 0, 0], [0, 0, 1, 1], [0, 0, 1, 1]]


@pytest.mark.parametrize(
    "readings", [np.zeros((5, 4)), np.ones(5), np.full((3, 4), np.nan), np.zeros((0, 4)), np.eye(4)[:, :2]]
)
def test_invalid_readings_are_rejected(readings):
    with pytest.raises(MapError):
        detect_touch(readings)
