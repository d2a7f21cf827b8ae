from __future__ import annotations

import numpy as np

from app.touch.sensor.offset_drift import OffsetDrift
from tests.sensors import readings, refuses, stage


def test_an_offset_is_added_whatever_presses():
    pressed, free = (stage(OffsetDrift(), 3) for _ in range(2))
    assert np.allclose(readings(pressed, [[1e4, 0, 50]] * 9) - readings(free, [[0, 0, 0]] * 9), [1e4, 0, 50])


def test_without_walk_the_offsets_stay():
    read = readings(stage(OffsetDrift(sd=50.0, walk=0.0), 3), np.zeros((5, 3)))
    assert read[0].any()
    assert (read == read[0]).all()


def test_reset_starts_the_same_walk_again():
    at_work = stage(OffsetDrift(), 3)
    start, first = at_work.state(), readings(at_work, np.zeros((5, 3)))
    assert at_work.state()[0] == 5
    assert not np.array_equal(at_work.state()[1:], start[1:])
    at_work.reset()
    assert np.array_equal(at_work.state(), start)
    assert np.array_equal(readings(at_work, np.zeros((5, 3))), first)


def test_numbers_out_of_range_are_refused():
    refuses(OffsetDrift, "sd", -1.0, 1.1e6)
    refuses(OffsetDrift, "walk", -1.0, 1.1e6)
