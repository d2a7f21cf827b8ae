"""What is measured of loops: growth, settling, lag; and benches that come to rest first."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.control.force_loop.sampled_loop import sampled_loop_limit
from tactile_maps.studies.loop_laws.closed_loop import Loop
from tactile_maps.studies.loop_laws.step_trials import (
    FORCE_STEP,
    PLACE_STEP,
    LoopTest,
    diverges,
    plant_stiffness,
    proportional_settings,
    settling_samples,
    tracking_lag,
)

LOOP = Loop(period=0.1, stiffness=1000.0)


def test_the_plant_is_contact_and_posture_loop_in_series():
    assert plant_stiffness(LOOP) == 1000.0
    assert plant_stiffness(Loop(servo=40.0, stiffness=6400.0)) == pytest.approx(3200.0)


def test_growth_is_seen_in_the_last_quarter_or_at_once_beyond_a_bound():
    k = np.arange(80)
    assert not diverges(0.99**k, 2.0)
    assert diverges(1.01**k, 9.0)
    assert diverges(np.where(k == 3, 5.0, 0.1 * 0.9**k), 2.0)


def test_settling_counts_from_the_step_and_the_delay_on_top():
    errors = np.outer(0.5 ** np.arange(20), [3.0, 4.0])
    assert settling_samples(errors, 0) == 6
    assert settling_samples(errors + [1.0, 2.0], 3) == 9, "from where it ends"


def test_a_bench_begins_at_rest():
    bench = LoopTest(LOOP)
    settings = proportional_settings("hybrid", 0.5 / (1000.0 * 0.1))
    assert bench.force_step(settings, 10)[0] == pytest.approx(-FORCE_STEP, abs=1e-6)
    assert bench.place_step(2.0, 10)[0] == pytest.approx([-PLACE_STEP, 0.0], abs=1e-6)
    assert LoopTest(LOOP, axis=1).place_step(2.0, 10)[0] == pytest.approx([0.0, -PLACE_STEP], abs=1e-6)


def test_stability_is_told_on_both_sides_of_the_limit():
    bench = LoopTest(Loop(period=0.1, delay=1, stiffness=1000.0))
    for share, stable in ((0.9, True), (1.1, False)):
        assert bench.force_stable(proportional_settings("hybrid", share * sampled_loop_limit(1) / 100.0)) == stable
        assert bench.place_stable(share * sampled_loop_limit(1) / 0.1) == stable


def test_a_controller_that_is_told_the_speed_is_not_behind():
    bench = LoopTest(LOOP)
    assert tracking_lag(bench, 2.0, 0.002, told=False, periods=60) == pytest.approx((0.001, 0.001), rel=1e-3)
    assert tracking_lag(bench, 2.0, 0.002, told=True, periods=60) == pytest.approx((0.0, 0.0), abs=1e-8)
