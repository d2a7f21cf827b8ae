from __future__ import annotations

import numpy as np
import pytest

from app.touch.sensor.sampling import Sampling
from tests.sensors import readings, refuses, stage


def _read(rate, delay, count, *, tick=0.01):
    """What arrives at each tick when tick k presses with k + 1."""
    return readings(stage(Sampling(rate, delay), tick=tick), np.arange(1.0, count + 1)[:, None])[:, 0].tolist()


def test_between_samples_the_last_one_holds():
    assert _read(50.0, 0.0, 7) == [1, 1, 3, 3, 5, 5, 7]


def test_samples_arrive_late_and_before_the_first_there_is_nothing():
    assert _read(50.0, 0.03, 8) == [0, 0, 0, 1, 1, 3, 3, 5]


def test_a_rate_above_the_ticks_samples_at_every_tick():
    assert _read(1e4, 0.0, 4) == [1, 2, 3, 4]
    assert _read(1e4, 0.02, 5) == [0, 0, 1, 2, 3]


def test_a_sample_is_kept_as_it_was_and_none_may_change_it():
    at_work, pressures = stage(Sampling(10.0, 0.0)), np.array([5.0])
    read = at_work.read(pressures)
    pressures[:] = 9.0
    assert at_work.read(pressures).tolist() == read.tolist() == [5.0]
    assert not read.flags.writeable


@pytest.mark.parametrize(("rate", "delay"), [(100.0, 0.07), (33.0, 0.1), (7.3, 1.0), (1e4, 0.0)])
def test_the_state_has_one_length_and_reset_brings_back_the_first(rate, delay):
    at_work = stage(Sampling(rate, delay), 3)
    start, pressures = at_work.state(), np.random.default_rng(0).random((300, 3))
    first = readings(at_work, pressures)
    for _ in range(100):
        at_work.read(np.ones(3))
        assert at_work.state().shape == start.shape
    at_work.reset()
    assert np.array_equal(at_work.state(), start)
    assert np.array_equal(readings(at_work, pressures), first)


def test_numbers_out_of_range_are_refused():
    refuses(Sampling, "rate", 0.0, -1.0, 1.1e4)
    refuses(Sampling, "delay", -0.01, 1.01)
