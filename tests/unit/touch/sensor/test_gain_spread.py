from __future__ import annotations

import numpy as np

from app.touch.sensor.gain_spread import GainSpread
from tests.sensors import readings, refuses, stage


def test_every_taxel_has_a_gain_of_its_own_that_stays():
    at_work = stage(GainSpread(sd=0.2), 4)
    once, twice, double = readings(at_work, [np.full(4, 100.0), np.full(4, 100.0), np.full(4, 200.0)])
    assert len(set(once)) == 4
    assert np.array_equal(once, twice)
    assert np.array_equal(double, 2 * once)
    at_work.reset()
    assert np.array_equal(readings(at_work, [np.full(4, 100.0)])[0], once)
    assert at_work.state().shape == (0,)


def test_without_spread_nothing_changes():
    assert readings(stage(GainSpread(sd=0.0), 3), [[1.0, -2.0, 3.0]]).tolist() == [[1.0, -2.0, 3.0]]


def test_no_gain_is_negative_however_wide_they_spread():
    assert readings(stage(GainSpread(sd=1.0), 10_000), [np.ones(10_000)]).min() > 0


def test_a_deviation_out_of_range_is_refused():
    refuses(GainSpread, "sd", -0.01, 1.01)
