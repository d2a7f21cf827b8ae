"""Gains for a slow skin, oscillation, and what a step shows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.control.command import ControlSettings
from app.control.joint_impedance import INNER_FREQUENCY
from app.control.limits import Limit, LimitKind
from app.control.loop_stability import (
    BAND,
    CONTACT_STIFFNESS,
    GAIN_SHARE,
    GONE,
    MEMORY,
    TURNS,
    GainLimiter,
    OscillationDetector,
    SensorTiming,
    assume_goal_where_saturated,
    max_stable_gain,
    step_response,
)
from app.robots.kinematics import Configuration
from tests.support.touch import bar
from tests.unit.control.contacts_by_hand import touch


def test_a_reading_at_its_end_is_no_less_than_the_goal():
    (weak,), (strong,) = touch(1.0), touch(2.0, id_=2)
    end = replace(weak, peak=180e3)
    taken, plateau = assume_goal_where_saturated((strong, end), 3.0, 180e3)
    assert plateau
    assert [(region.id, region.force) for region in taken] == [(1, 3.0), (2, 2.0)], "the strongest first"
    assert assume_goal_where_saturated((replace(end, force=5.0),), 3.0, 180e3)[0][0].force == 5.0
    assert assume_goal_where_saturated((strong, weak), 3.0, 180e3) == ((strong, weak), False)
    assert assume_goal_where_saturated((), 3.0, 180e3) == ((), False)


LEVEL = np.zeros(1)


@pytest.mark.parametrize(("delay", "limit"), [(0, 2.0), (1, 1.0), (2, 0.618), (3, 0.445), (4, 0.347)])
def test_the_most_is_that_of_a_sampled_loop(delay, limit):
    readings = SensorTiming(0.05, 0.05 * delay)
    assert 2000.0 * 0.05 * max_stable_gain(2000.0, readings) == pytest.approx(limit, abs=5e-4)


def most_at(readings: SensorTiming, at: float = 0.3) -> float:
    """The bar's servo in series with a nominal contact."""
    servo = Configuration(bar()).inertia()[0] * INNER_FREQUENCY**2 / at**2
    return max_stable_gain(1 / (1 / servo + 1 / CONTACT_STIFFNESS), readings)


def watch_of(readings: SensorTiming | None) -> GainLimiter:
    watch = GainLimiter(bar())
    watch.readings = readings
    return watch


def test_a_gain_that_stays_as_set_is_told_from_where_it_cannot_be_held():
    """The arm and what touches are in series."""
    slow = SensorTiming(0.05)
    most, watch = most_at(slow), watch_of(slow)
    high, low = (ControlSettings("hybrid", gains="as_given", force_gain=share * most) for share in (1.01, 0.99))
    taken, [limit] = watch.effective_settings(high, LEVEL, touch(3.0, x=0.3))
    assert (taken, limit.kind) == (high, LimitKind.FORCE_GAIN_UNSTABLE)
    assert (limit.value, limit.bound, limit.period) == pytest.approx((high.force_gain, most, 0.05))
    assert watch.effective_settings(low, LEVEL, touch(3.0, x=0.3)) == (low, ())


def test_calm_gains_are_held_to_a_share_and_that_is_told():
    slow = SensorTiming(0.2, 0.1)
    most, watch = most_at(slow), watch_of(slow)
    settings = ControlSettings("hybrid", force_gain=0.015, position_gain=4.0, integral_time=0.3)
    taken, said = watch.effective_settings(settings, LEVEL, touch(3.0, x=0.3))
    assert taken.force_gain == pytest.approx(GAIN_SHARE * most)
    assert taken.position_gain == pytest.approx(GAIN_SHARE / 0.3)
    assert taken.integral_time == pytest.approx(12 * 0.3)
    assert said == (
        Limit(LimitKind.FORCE_GAIN_HELD, value=taken.force_gain, bound=0.015, period=0.2, delay=0.1),
        Limit(LimitKind.POSITION_GAIN_HELD, value=taken.position_gain, bound=4.0, period=0.2, delay=0.1),
    )
    assert (taken.controller, taken.force_goal, taken.task) == (settings.controller, settings.force_goal, settings.task)


def test_gains_that_a_skin_can_hold_stay_what_they_are():
    settings = ControlSettings("hybrid")
    assert watch_of(SensorTiming(0.005)).effective_settings(settings, LEVEL, touch(3.0)) == (settings, ())


def test_what_was_lost_is_sought_with_the_gains_it_had_and_nothing_is_said():
    watch, settings = watch_of(SensorTiming(0.2, 0.2)), ControlSettings("hybrid", force_gain=0.05)
    assert watch.effective_settings(settings, LEVEL, ()) == (settings, ()), "nothing has touched yet"
    taken, said = watch.effective_settings(settings, LEVEL, touch(3.0))
    assert said
    assert watch.effective_settings(settings, LEVEL, ()) == (taken, ())
    other = ControlSettings("hybrid", force_gain=0.04)
    assert watch.effective_settings(other, LEVEL, ()) == (other, ()), "other settings"
    watch.reset()
    assert watch.effective_settings(settings, LEVEL, ()) == (settings, ())


def test_it_is_for_laws_that_read_and_for_skins_of_which_something_is_known():
    high = ControlSettings("hybrid", force_gain=0.05)
    assert watch_of(None).effective_settings(high, LEVEL, touch(3.0)) == (high, ())
    posture = ControlSettings("impedance", force_gain=0.05)
    assert watch_of(SensorTiming(0.2, 0.2)).effective_settings(posture, LEVEL, touch(3.0)) == (posture, ())


def test_another_skin_asks_anew():
    watch, high = watch_of(SensorTiming(0.2, 0.2)), ControlSettings("hybrid", force_gain=0.05)
    assert watch.effective_settings(high, LEVEL, touch(3.0))[0].force_gain < 0.01
    watch.readings = SensorTiming(0.0001)
    assert watch.effective_settings(high, LEVEL, touch(3.0)) == (high, ())


DT, GOAL = 0.005, 3.0


def swung(amplitude, *, rate=5.0, seconds=3.0, goal=GOAL):
    """Whether a sine about the goal counts as a swing at the end."""
    watch, swings = OscillationDetector(), False
    for k in range(round(seconds / DT)):
        swings = watch.look(goal, max(goal + amplitude * np.sin(2 * np.pi * rate * k * DT), 0.0), DT)
    return swings


def test_large_swings_count_and_small_or_slow_ones_do_not():
    assert swung(2.0)
    assert swung(10.0), "down to nothing"
    assert not swung(1.0)
    assert not swung(2.0, rate=0.4, seconds=12.0)
    assert not swung(2.0, seconds=0.3)
    assert not swung(2.0, goal=0.0)


def test_calm_is_noticed_too():
    watch = OscillationDetector()
    for k in range(round(3.0 / DT)):
        watch.look(GOAL, GOAL + 2 * np.sin(30 * k * DT), DT)
    assert watch.look(GOAL, GOAL, DT)
    calm = [watch.look(GOAL, GOAL, DT) for _ in range(round(MEMORY / DT))]
    assert not calm[-1]


@pytest.mark.parametrize("pause", [GONE + 0.1, 1.0])
def test_taps_are_no_swings(pause):
    watch = OscillationDetector()
    for _ in range(2 * TURNS):
        for force, seconds in ((6.0, 0.1), (0.0, pause)):
            assert not any(watch.look(GOAL, force, DT) for _ in range(round(seconds / DT)))


def test_a_reset_forgets():
    watch = OscillationDetector()
    for k in range(round(3.0 / DT)):
        watch.look(GOAL, GOAL + 2 * np.sin(30 * k * DT), DT)
    watch.reset()
    assert not watch.look(GOAL, GOAL, DT)


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
        assert found.settling is None
        assert found.ripple is None


def test_a_step_just_made_has_nothing_to_show_yet():
    found = step_response(np.zeros(0), np.zeros(0), before=0.0, goal=1.0)
    assert found.overshoot == 0
    assert found.settling is None
