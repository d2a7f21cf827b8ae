"""Gains by the theory of sampled loops."""

from __future__ import annotations

import pytest

from app.control.command import ControlSettings
from app.control.settings_check import check_settings
from app.experiments.control_gains import LAG, STIFFNESS, least_time, tuned
from app.experiments.sampled_loop import calm_gain, stable_gain

NOMINAL = ControlSettings(law="hybrid", task="follow_path")


@pytest.mark.parametrize("delay", range(6))
@pytest.mark.parametrize("period", [0.001, 0.02, 0.1])
def test_no_loop_is_faster_than_it_can_be_without_overshoot(period, delay):
    settings = check_settings(tuned(NOMINAL, period, delay))
    assert settings.position_gain * period <= calm_gain(delay)
    assert settings.force_gain * STIFFNESS * period <= calm_gain(delay)
    assert settings.force_gain * STIFFNESS * period < stable_gain(delay)


def test_a_fast_skin_leaves_the_posture_loops_lag_and_the_given_force_gain():
    settings = tuned(NOMINAL, 1e-6, 0)
    assert settings.position_gain == pytest.approx(1 / (2.718281828 * LAG), rel=1e-3)
    assert settings.force_gain == pytest.approx(NOMINAL.force_gain, rel=1e-3)
    assert settings.integral_time == pytest.approx(NOMINAL.integral_time, rel=1e-3)


def test_the_integral_goes_with_the_gain():
    settings = tuned(NOMINAL, 0.1, 2)
    assert settings.force_gain * settings.integral_time == pytest.approx(NOMINAL.force_gain * NOMINAL.integral_time)


def test_theorys_own_example():
    """20 Hz, one sample late, 200 mm, 2 mm: 20 s."""
    assert least_time(0.2, 0.002, 0.05, 1) == pytest.approx(20.0)
