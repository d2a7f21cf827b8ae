from __future__ import annotations

import numpy as np

from app.touch.sensor.noise import Noise
from tests.sensors import readings, refuses, stage


def test_it_is_new_at_every_taxel_and_every_reading():
    read = readings(stage(Noise(), 4), np.zeros((5, 4)))
    assert len(set(read.ravel())) == 20


def test_a_seed_makes_its_own_noise_and_reset_the_same_again():
    at_work, other = stage(Noise(), 4), stage(Noise(), 4, seed=1)
    first = readings(at_work, np.zeros((5, 4)))
    assert not np.array_equal(readings(other, np.zeros((5, 4))), first)
    assert at_work.state().tolist() == [5.0]
    at_work.reset()
    assert np.array_equal(readings(at_work, np.zeros((5, 4))), first)


def test_a_reading_is_not_overwritten_by_the_next():
    at_work = stage(Noise(), 4)
    first = at_work.read(np.zeros(4))
    kept = first.copy()
    at_work.read(np.zeros(4))
    assert np.array_equal(first, kept)


def test_a_deviation_out_of_range_is_refused():
    refuses(Noise, "sd", -1.0, 1.1e6)
