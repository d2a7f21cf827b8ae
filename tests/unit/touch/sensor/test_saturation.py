from __future__ import annotations

import numpy as np

from app.touch.sensor.saturation import Saturation
from tests.sensors import readings, refuses, stage


def test_what_presses_harder_reads_the_highest_and_is_told():
    at_work = stage(Saturation(at=100.0), 4)
    assert not at_work.saturated.any()
    assert readings(at_work, [[-5.0, np.nextafter(100, 0), 100.0, 1e9]]).tolist() == [
        [-5.0, np.nextafter(100, 0), 100.0, 100.0]
    ]
    assert at_work.saturated.tolist() == [False, False, True, True]
    assert readings(at_work, [[0.0, 0, 0, 200]])[0].tolist() == [0, 0, 0, 100]
    assert at_work.saturated.tolist() == [False, False, False, True]


def test_reset_forgets_which_were():
    at_work = stage(Saturation(at=100.0), 2)
    readings(at_work, [[200.0, 0.0]])
    at_work.reset()
    assert not at_work.saturated.any()
    assert at_work.state().shape == (0,)


def test_a_pressure_out_of_range_is_refused():
    refuses(Saturation, "at", 0.0, 0.5, 1.1e9)
