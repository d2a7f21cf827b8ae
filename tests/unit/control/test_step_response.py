"""The figures of a step, against second-order systems whose figures are known."""

from __future__ import annotations

import numpy as np
import pytest

from app.control.step_response import BAND, step_response

TIME = np.linspace(0.0, 4.0, 4001)


def second_order(ratio, *, omega=10.0):
    """Response of a unit step."""
    damped = omega * np.sqrt(1 - ratio**2)
    lag = ratio / np.sqrt(1 - ratio**2)
    return 1 - np.exp(-ratio * omega * TIME) * (np.cos(damped * TIME) + lag * np.sin(damped * TIME))


@pytest.mark.parametrize("ratio", [0.2, 0.4, 0.6])
@pytest.mark.parametrize(("before", "goal"), [(0.0, 1.0), (2.0, 6.0), (5.0, 1.0)])
def test_overshoot_is_the_textbook_s_up_and_down(ratio, before, goal):
    values = before + (goal - before) * second_order(ratio)
    found = step_response(TIME, values, before=before, goal=goal)
    assert found.overshoot == pytest.approx(np.exp(-np.pi * ratio / np.sqrt(1 - ratio**2)), rel=1e-3)
    assert (found.before, found.goal) == (before, goal)


def test_a_first_order_lag_settles_after_three_time_constants_without_overshoot():
    found = step_response(TIME, 3 * (1 - np.exp(-TIME / 0.2)), before=0.0, goal=3.0)
    assert found.overshoot == 0
    assert found.settling == pytest.approx(-0.2 * np.log(BAND), abs=2e-3)
    assert found.ripple < 0.05


def test_ripple_is_what_stays():
    ripple = np.random.default_rng(0).normal(0, 0.01, len(TIME))
    found = step_response(TIME, np.where(TIME < 0.5, 0.0, 1.0) + ripple * (TIME >= 0.5), before=0.0, goal=1.0)
    assert found.settling == pytest.approx(0.5, abs=1e-3)
    assert found.ripple == pytest.approx(0.01, rel=0.05)


def test_what_has_not_settled_has_no_settling_time():
    for values in (0.5 * np.ones(4001), np.where(TIME > 3.998, 0.5, 1.0)):
        found = step_response(TIME, values, before=0.0, goal=1.0)
        assert np.isnan(found.settling)
        assert np.isnan(found.ripple)


def test_a_step_just_made_has_nothing_to_show_yet():
    found = step_response(np.zeros(0), np.zeros(0), before=0.0, goal=1.0)
    assert found.overshoot == 0
    assert np.isnan(found.settling)
