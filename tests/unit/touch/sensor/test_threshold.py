from __future__ import annotations

import numpy as np

from app.touch.sensor.threshold import Threshold
from tests.sensors import readings, refuses, stage


def test_what_is_below_reads_nothing_and_what_is_not_reads_in_full():
    at_work = stage(Threshold(at=100.0), 5)
    read = readings(at_work, [[-5.0, 0.0, np.nextafter(100, 0), 100.0, 1e6]])
    assert read.tolist() == [[0.0, 0.0, 0.0, 100.0, 1e6]]


def test_it_has_no_hysteresis():
    at_work = stage(Threshold(at=100.0))
    assert readings(at_work, [[99.0], [101.0], [99.0], [101.0]]).ravel().tolist() == [0, 101, 0, 101]
    at_work.reset()
    assert at_work.state().shape == (0,)


def test_at_nought_only_what_is_negative_is_lost():
    assert readings(stage(Threshold(at=0.0), 3), [[-1.0, 0.0, 1e-9]]).tolist() == [[0.0, 0.0, 1e-9]]


def test_a_pressure_out_of_range_is_refused():
    refuses(Threshold, "at", -1.0, 1.1e6)
