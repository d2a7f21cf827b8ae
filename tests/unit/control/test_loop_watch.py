"""Gains that are too much for how the skin is read are held to what it can hold, or said."""

from __future__ import annotations

import numpy as np
import pytest

from app.control.command import ControlSettings
from app.control.loop_watch import CONTACT_STIFFNESS, SHARE, LoopWatch, most_gain
from app.control.reference import INNER_FREQUENCY
from app.control.skin_readings import SkinReadings
from app.robots.configuration import Configuration
from tests.touch import bar
from tests.unit.control.touched import touch

LEVEL = np.zeros(1)


@pytest.mark.parametrize(("delay", "limit"), [(0, 2.0), (1, 1.0), (2, 0.618), (3, 0.445), (4, 0.347)])
def test_the_most_is_that_of_a_sampled_loop(delay, limit):
    readings = SkinReadings(0.05, 0.05 * delay)
    assert 2000.0 * 0.05 * most_gain(2000.0, readings) == pytest.approx(limit, abs=5e-4)


def most_at(readings: SkinReadings, at: float = 0.3) -> float:
    """The bar's servo in series with a nominal contact."""
    servo = Configuration(bar()).inertia()[0] * INNER_FREQUENCY**2 / at**2
    return most_gain(1 / (1 / servo + 1 / CONTACT_STIFFNESS), readings)


def watch_of(readings: SkinReadings | None) -> LoopWatch:
    watch = LoopWatch(bar())
    watch.readings = readings
    return watch


def test_a_gain_that_stays_as_set_is_told_from_where_it_cannot_be_held():
    """The arm and what touches are in series."""
    slow = SkinReadings(0.05)
    most, watch = most_at(slow), watch_of(slow)
    high, low = (ControlSettings("hybrid", gains="as_set", force_gain=share * most) for share in (1.01, 0.99))
    assert watch.heed(high, LEVEL, touch(3.0, x=0.3)) == (
        high, (f"force gain above {most:.2g}, the most for a skin read at 20 Hz",),
    )  # fmt: skip
    assert watch.heed(low, LEVEL, touch(3.0, x=0.3)) == (low, ())


def test_calm_gains_are_held_to_a_share_and_that_is_told():
    slow = SkinReadings(0.2, 0.1)
    most, watch = most_at(slow), watch_of(slow)
    settings = ControlSettings("hybrid", force_gain=0.015, position_gain=4.0, integral_time=0.3)
    taken, said = watch.heed(settings, LEVEL, touch(3.0, x=0.3))
    assert taken.force_gain == pytest.approx(SHARE * most)
    assert taken.position_gain == pytest.approx(SHARE / 0.3)
    assert taken.integral_time == pytest.approx(12 * 0.3)
    assert said == (
        f"force gain held to {1e3 * SHARE * most:.2g} mm/s per N by a skin read at 5 Hz, 100 ms late",
        "position gain held to 1/s by a skin read at 5 Hz, 100 ms late",
    )
    assert (taken.law, taken.force_goal, taken.task) == (settings.law, settings.force_goal, settings.task)


def test_gains_that_a_skin_can_hold_stay_what_they_are():
    settings = ControlSettings("hybrid")
    assert watch_of(SkinReadings(0.005)).heed(settings, LEVEL, touch(3.0)) == (settings, ())


def test_what_was_lost_is_sought_with_the_gains_it_had_and_nothing_is_said():
    watch, settings = watch_of(SkinReadings(0.2, 0.2)), ControlSettings("hybrid", force_gain=0.05)
    assert watch.heed(settings, LEVEL, ()) == (settings, ()), "nothing has touched yet"
    taken, said = watch.heed(settings, LEVEL, touch(3.0))
    assert said
    assert watch.heed(settings, LEVEL, ()) == (taken, ())
    other = ControlSettings("hybrid", force_gain=0.04)
    assert watch.heed(other, LEVEL, ()) == (other, ()), "other settings"
    watch.reset()
    assert watch.heed(settings, LEVEL, ()) == (settings, ())


def test_it_is_for_laws_that_read_and_for_skins_of_which_something_is_known():
    high = ControlSettings("hybrid", force_gain=0.05)
    assert watch_of(None).heed(high, LEVEL, touch(3.0)) == (high, ())
    posture = ControlSettings("impedance", force_gain=0.05)
    assert watch_of(SkinReadings(0.2, 0.2)).heed(posture, LEVEL, touch(3.0)) == (posture, ())


def test_another_skin_asks_anew():
    watch, high = watch_of(SkinReadings(0.2, 0.2)), ControlSettings("hybrid", force_gain=0.05)
    assert watch.heed(high, LEVEL, touch(3.0))[0].force_gain < 0.01
    watch.readings = SkinReadings(0.0001)
    assert watch.heed(high, LEVEL, touch(3.0)) == (high, ())
