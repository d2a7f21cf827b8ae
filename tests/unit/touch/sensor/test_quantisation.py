from __future__ import annotations

import numpy as np

from app.touch.sensor.quantisation import Quantisation
from tests.sensors import readings, refuses, stage


def test_a_reading_is_the_nearest_whole_number_of_steps_and_a_half_goes_to_the_even():
    at_work = stage(Quantisation(step=200.0), 7)
    read = readings(at_work, [[-130.0, 0, 99, 100, 101, 300, 1e4]])
    assert read.tolist() == [[-200.0, 0, 0, 0, 200, 400, 1e4]]


def test_no_reading_is_minus_nought():
    assert not np.signbit(readings(stage(Quantisation(step=200.0), 2), [[-30.0, -0.0]])).any()


def test_it_remembers_nothing():
    at_work = stage(Quantisation())
    at_work.reset()
    assert at_work.state().shape == (0,)


def test_a_step_out_of_range_is_refused():
    refuses(Quantisation, "step", 0.0, -1.0, 1.1e6)
