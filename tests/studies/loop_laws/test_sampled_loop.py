"""The theory of sampled loops, in closed form and as a linear machine, against the numbers it was worked out with."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.control.force_loop.sampled_loop import critical_gain, sampled_loop_limit
from tactile_maps.core.errors import UsageError
from tactile_maps.studies.loop_laws.closed_loop import Loop
from tactile_maps.studies.loop_laws.sampled_loop import (
    MOST_SAMPLES,
    LinearLoop,
    samples_until_within,
    settling_samples_of,
)
from tactile_maps.studies.testbeds.force_loop import (
    Filter,
    stability_limit,
)
from tests.support.loop_trials import best_gain, settling_on_stretched_map, settling_on_turned_map

UNIT = Loop(period=1.0, stiffness=1.0)


def test_limits_match_the_tables_of_the_theory():
    assert [sampled_loop_limit(d) for d in range(5)] == pytest.approx([2, 1, 0.618, 0.445, 0.347], abs=5e-4)
    assert [critical_gain(d) for d in range(5)] == pytest.approx([1, 0.25, 0.148, 0.105, 0.082], abs=5e-4)
    assert [int(settling_samples_of(np.array([critical_gain(d)]), d)[0]) for d in range(5)] == [1, 9, 16, 23, 29]
    assert [best_gain(lambda gains, d=d: settling_samples_of(gains, d), sampled_loop_limit(d))[1] for d in (1, 2)] == [
        6,
        10,
    ]
    assert [best_gain(settling_on_stretched_map(1, k), 1.5)[1] for k in (1.18, 2.0, 3.0, 5.0)] == pytest.approx(
        [8, 11, 16, 24], abs=1
    )
    assert [best_gain(settling_on_turned_map(1, a), 1.0)[1] for a in (5, 15, 30, 45, 60, 75)] == pytest.approx(
        [9, 12, 20, 37, 84, 341], rel=0.01
    )


def test_unsettled_loops_are_reported():
    assert settling_samples_of(np.array([2.1]), 0).tolist() == [MOST_SAMPLES + 1]
    assert samples_until_within(np.array([3.0, 0.1, 2.0, 0.1]), 1.0) == 3
    assert samples_until_within(np.array([np.nan, 0.0]), 1.0) == 1
    assert samples_until_within(np.zeros(3), 1.0) == 0


@pytest.mark.parametrize("delay", range(5))
def test_linear_loop_of_ideal_joints_follows_the_closed_form(delay):
    loop = replace(UNIT, delay=delay)
    found = stability_limit(lambda gain: LinearLoop(loop, Filter(gain)).stable, 1.0, steps=14)
    assert found == pytest.approx(sampled_loop_limit(delay), rel=1e-3)
    assert (
        LinearLoop(loop, Filter(critical_gain(delay))).settling()
        == settling_samples_of(np.array([critical_gain(delay)]), delay)[0]
    )


@pytest.mark.parametrize("degrees", [30.0, 60.0])
def test_angle_lowers_the_limit_by_its_cosine(degrees):
    angle = math.radians(degrees)
    found = stability_limit(lambda gain: LinearLoop(UNIT, Filter(gain, angle=angle)).stable, 1.0, steps=14)
    assert found == pytest.approx(2 * math.cos(angle), rel=1e-3)


def test_limit_for_small_steps_is_the_routh_bound():
    loop = replace(UNIT, period=1e-4)
    controller = Filter(10.0, position_gain=5.0, inertia_time=0.2)
    shortest = 1 / stability_limit(
        lambda rate: LinearLoop(loop, replace(controller, integral_time=1 / rate)).stable, 7.0
    )
    assert shortest == pytest.approx(0.2 * 10 / 15, rel=0.01)


@pytest.mark.parametrize(
    ("period", "delay", "expected"),
    [(0.05, 0, 54), (0.05, 1, 17), (0.05, 2, 11), (0.001, 0, 2011), (0.001, 1, 673), (0.001, 2, 406)],
)
def test_joint_lag_of_30_ms_gives_the_expected_stability_limits(period, delay, expected):
    loop = Loop(period=period, delay=delay, ticks=100, lag=0.03, stiffness=1.0)
    assert stability_limit(lambda gain: LinearLoop(loop, Filter(gain)).stable, expected) == pytest.approx(
        expected, rel=0.03
    )


def test_onset_far_from_its_guess_is_nan():
    for is_stable in (lambda value: value < 1e6, lambda _: False):
        with pytest.raises(UsageError, match="near the guess"):
            stability_limit(is_stable, 1.0)
    assert stability_limit(lambda value: value < 20.0, 1.0, steps=12) == pytest.approx(20.0, rel=1e-3)
