"""Gains by the theory of sampled loops, and the least time of a path."""

from __future__ import annotations

import pytest

from tactile_maps.control.controller_registry import check_settings
from tactile_maps.control.force_loop.sampled_loop import critical_gain, sampled_loop_limit
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.studies.path_time.gains import LAG, STIFFNESS, least_time, tune_gains

NOMINAL_SETTINGS = ControlSettings(controller="hybrid", task="follow_path")


@pytest.mark.parametrize("delay", range(6))
@pytest.mark.parametrize("period", [0.001, 0.02, 0.1])
def test_no_loop_is_faster_than_it_can_be_without_overshoot(period, delay):
    settings = check_settings(tune_gains(NOMINAL_SETTINGS, period, delay))
    assert settings.position_gain * period <= critical_gain(delay)
    assert settings.force_gain * STIFFNESS * period <= critical_gain(delay)
    assert settings.force_gain * STIFFNESS * period < sampled_loop_limit(delay)


def test_fast_skin_leaves_the_lag_of_the_posture_loop_and_the_given_force_gain():
    settings = tune_gains(NOMINAL_SETTINGS, 1e-6, 0)
    assert settings.position_gain == pytest.approx(1 / (2.718281828 * LAG), rel=1e-3)
    assert settings.force_gain == pytest.approx(NOMINAL_SETTINGS.force_gain, rel=1e-3)
    assert settings.integral_time == pytest.approx(NOMINAL_SETTINGS.integral_time, rel=1e-3)


def test_integral_time_is_inversely_proportional_to_the_force_gain():
    settings = tune_gains(NOMINAL_SETTINGS, 0.1, 2)
    assert settings.force_gain * settings.integral_time == pytest.approx(
        NOMINAL_SETTINGS.force_gain * NOMINAL_SETTINGS.integral_time
    )


def test_example_of_the_theory_page_is_reproduced():
    """20 Hz, one sample late, 200 mm, 2 mm: 20 s."""
    assert least_time(0.2, 0.002, 0.05, 1) == pytest.approx(20.0)


def test_gain_is_inversely_proportional_to_contact_stiffness():
    soft, hard = (tune_gains(NOMINAL_SETTINGS, 0.1, 2, stiffness=factor * STIFFNESS) for factor in (1.0, 10.0))
    assert 8 < soft.force_gain / hard.force_gain < 10
    assert soft.position_gain == hard.position_gain
