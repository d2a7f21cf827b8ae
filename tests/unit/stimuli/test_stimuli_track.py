"""A track says where its finger is at any time."""

from __future__ import annotations

import numpy as np
import pytest

from app.stimuli.track import Track, still
from app.touch.poke import Finger

LINE = Track(0, Finger(), np.array([0.0, 1.0, 3.0]), np.zeros(3, int), np.array([[0, 0, 0], [1.0, 0, 0], [1, 4, 0]]))


@pytest.mark.parametrize(("seconds", "point"), [
    (-1, (0, 0, 0)), (0, (0, 0, 0)), (0.25, (0.25, 0, 0)), (1, (1, 0, 0)), (2, (1, 2, 0)), (3, (1, 4, 0)),
    (9, (1, 4, 0)),
])  # fmt: skip
def test_straight_between_points_and_still_outside(seconds, point):
    patch, found = LINE.at(seconds)
    assert patch == 0
    assert np.allclose(found, point)


def test_it_steps_over_to_another_patch_without_a_way_between():
    track = Track(0, Finger(), np.array([0.0, 1.0, 2.0]), np.array([0, 1, 1]), np.eye(3))
    assert track.at(0.99)[0] == 0
    assert np.array_equal(track.at(0.99)[1], [1, 0, 0])
    assert track.at(1.0)[0] == 1
    assert np.allclose(track.at(1.5)[1], [0, 0.5, 0.5])


def test_points_at_the_same_time_take_the_last():
    track = Track(0, Finger(), np.array([0.0, 1.0, 1.0]), np.zeros(3, int), np.eye(3))
    assert np.array_equal(track.at(1.0)[1], [0, 0, 1])


def test_a_still_finger_is_still_and_its_arrays_are_frozen():
    track = still(2, Finger(), 1, np.ones(3), press=0.5, lift=2.0)
    assert track.finger == 2
    assert all(np.array_equal(track.at(t)[1], np.ones(3)) and track.at(t)[0] == 1 for t in (0, 0.5, 1.7, 3))
    assert not track.points.flags.writeable
