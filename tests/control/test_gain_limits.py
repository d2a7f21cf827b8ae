"""Gains for a slow skin: held or told, by what skin, arm and contact can hold."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.control.force_loop.loop_stability import CONTACT_STIFFNESS, SensorTiming
from tactile_maps.control.force_loop.pressed_arm import LoopFilter, pressed_arm
from tactile_maps.control.force_loop.sampled_loop import max_stable_gain
from tactile_maps.control.gain_limits import (
    CALM,
    GAIN_SHARE,
    LEAST_SHARE,
    NOMINAL_SHARE,
    PLACE_SHARE,
    SAMPLED_SHARE,
    SOFT_RATE,
    GainLimiter,
)
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.joint_impedance import INNER_FREQUENCY, JointImpedance
from tactile_maps.control.motion.limits import Limit, LimitKind
from tactile_maps.robots.kinematics import Configuration
from tests.control.contacts import touch
from tests.support.touch import BAR_INERTIA, bar

LEVEL = np.zeros(1)
DT = 0.005
GAINS = ("force_gain", "position_gain", "integral_time")


def sampled_most(readings: SensorTiming) -> float:
    """Were the bar to follow at once: its servo in series with a nominal contact."""
    servo = Configuration(bar()).inertia()[0] * INNER_FREQUENCY**2 / 0.3**2
    return max_stable_gain(1 / (1 / servo + 1 / CONTACT_STIFFNESS), readings)


def most_at(readings: SensorTiming, stiffness: float = CONTACT_STIFFNESS, *, posture=LEVEL, integral=0.3) -> float:
    """Of the bar, touched at 0.3 m."""
    configuration = Configuration(bar())
    impedance = JointImpedance(configuration, frequency=INNER_FREQUENCY, damping_ratio=1.0)
    configuration.update(posture)
    arm = pressed_arm(configuration, impedance, touch(3.0)[0], stiffness, slides=True)
    return arm.gain_limit(LoopFilter(integral), readings, DT)


def watch_of(readings: SensorTiming | None) -> GainLimiter:
    watch = GainLimiter(bar())
    watch.readings = readings
    return watch


def asked(watch, settings, regions, posture=LEVEL):
    return watch.effective_settings(settings, posture, regions, DT)


def test_a_gain_that_stays_as_set_is_told_from_where_it_cannot_be_held():
    slow = SensorTiming(0.05)
    most = most_at(slow)
    watch = watch_of(slow)
    high, low = (ControlSettings("hybrid", gains="as_given", force_gain=share * most) for share in (1.01, 0.99))
    taken, [limit] = asked(watch, high, touch(3.0))
    assert (taken, limit.kind) == (high, LimitKind.FORCE_GAIN_UNSTABLE)
    assert (limit.value, limit.bound, limit.period) == pytest.approx((high.force_gain, most, 0.05))
    assert asked(watch, low, touch(3.0)) == (low, ())


def test_calm_gains_are_held_to_a_share_and_that_is_told():
    slow = SensorTiming(0.2, 0.1)
    settings = ControlSettings("hybrid", force_gain=0.015, position_gain=4.0, integral_time=0.3)
    taken, said = asked(watch_of(slow), settings, touch(3.0))
    assert taken.force_gain == pytest.approx(SAMPLED_SHARE * sampled_most(slow), rel=0.01)
    assert taken.position_gain == pytest.approx(PLACE_SHARE / 0.3)
    assert taken.integral_time == pytest.approx(12 * 0.3)
    assert said == (
        Limit(LimitKind.FORCE_GAIN_HELD, value=taken.force_gain, bound=0.015, period=0.2, delay=0.1),
        Limit(LimitKind.POSITION_GAIN_HELD, value=taken.position_gain, bound=4.0, period=0.2, delay=0.1),
    )
    assert (taken.controller, taken.force_goal, taken.task) == (settings.controller, settings.force_goal, settings.task)


def test_of_a_quick_skin_what_joints_can_hold_counts():
    quick = SensorTiming(0.005)
    taken, _ = asked(watch_of(quick), ControlSettings("hybrid", force_gain=1.0), touch(3.0))
    assert taken.force_gain == pytest.approx(NOMINAL_SHARE * most_at(quick))
    assert taken.force_gain < SAMPLED_SHARE * sampled_most(quick)


def test_gains_that_a_skin_can_hold_stay_what_they_are():
    settings = ControlSettings("hybrid", force_gain=0.002)
    assert asked(watch_of(SensorTiming(0.005)), settings, touch(3.0)) == (settings, ())


def test_what_was_lost_is_sought_with_the_gains_it_had_and_nothing_is_said():
    watch = watch_of(SensorTiming(0.2, 0.2))
    settings = ControlSettings("hybrid", force_gain=0.05)
    assert asked(watch, settings, ()) == (settings, ()), "nothing has touched yet"
    taken, said = asked(watch, settings, touch(3.0))
    assert said
    assert asked(watch, settings, ()) == (taken, ())
    other = ControlSettings("hybrid", force_gain=0.04)
    assert asked(watch, other, ()) == (other, ()), "other settings"
    watch.reset()
    assert asked(watch, settings, ()) == (settings, ())


def test_it_is_for_controllers_that_read_and_for_skins_of_which_something_is_known():
    high = ControlSettings("hybrid", force_gain=0.05)
    assert asked(watch_of(None), high, touch(3.0)) == (high, ())
    posture = ControlSettings("impedance", force_gain=0.05)
    assert asked(watch_of(SensorTiming(0.2, 0.2)), posture, touch(3.0)) == (posture, ())


def test_another_path_takes_the_gains_that_were_worked_out_and_other_gains_do_not():
    watch = watch_of(SensorTiming(0.01))
    settings = ControlSettings("hybrid", force_gain=1.0)
    before, said = asked(watch, settings, touch(3.0))
    path = replace(settings, path_kind="raster", path=((0.0, 0.0), (0.1, 0.1)), path_size=0.1, path_speed=0.1, starts=7)
    aside = touch(3.0, x=0.2)  # where the limit would be another, were it worked out anew
    taken, limits = asked(watch, path, aside)
    assert limits == said
    assert taken == replace(path, **{name: getattr(before, name) for name in GAINS})
    assert asked(watch, replace(path, force_goal=2.0), aside)[0].force_gain != before.force_gain


def test_another_skin_asks_anew():
    watch = watch_of(SensorTiming(0.2, 0.2))
    high = ControlSettings("hybrid", force_gain=0.05)
    slow = asked(watch, high, touch(3.0))[0].force_gain
    watch.readings = SensorTiming(0.005)
    assert asked(watch, high, touch(3.0))[0].force_gain > 5 * slow


@pytest.mark.parametrize("controller", ["hybrid", "parallel", "admittance"])
def test_an_oscillation_halves_the_gain_until_it_has_been_calm(controller):
    settings = ControlSettings(controller, force_gain=0.002)
    watch = watch_of(SensorTiming(0.005))
    before = asked(watch, settings, touch(3.0))[0].force_gain
    watch.halve(settings)
    assert asked(watch, settings, touch(3.0))[0].force_gain == pytest.approx(before / 2)
    watch.halve(settings)
    assert asked(watch, settings, touch(3.0))[0].force_gain == pytest.approx(before / 4)
    assert watch.reduced
    gains = [asked(watch, settings, touch(3.0))[0].force_gain for _ in range(round(5 * CALM / DT))]
    assert gains[round(1.9 * CALM / DT)] == pytest.approx(before / 4), "twice as long after the second time"
    assert gains[round(2.1 * CALM / DT)] == pytest.approx(before / 2)
    assert gains[-1] == pytest.approx(before)
    assert not watch.reduced


def test_halving_ends_at_the_smallest_share_which_is_reported_until_the_force_is_calm():
    settings = ControlSettings("hybrid", force_gain=0.002)
    watch = watch_of(SensorTiming(0.005))
    before = asked(watch, settings, touch(3.0))[0].force_gain
    for _ in range(round(-np.log2(LEAST_SHARE))):
        assert not watch.exhausted
        watch.halve(settings)
    assert not watch.exhausted, "not known to oscillate with the smallest gain"
    for _ in range(3):
        watch.halve(settings)
        assert watch.exhausted
        assert asked(watch, settings, touch(3.0))[0].force_gain == pytest.approx(LEAST_SHARE * before)
    calm = 0.5 * CALM / LEAST_SHARE
    for _ in range(round((calm + 0.1) / DT)):
        taken = asked(watch, settings, touch(3.0))[0]
    assert taken.force_gain == pytest.approx(2 * LEAST_SHARE * before)
    assert not watch.exhausted


def test_other_settings_take_their_whole_gain_and_given_gains_are_never_reduced():
    settings = ControlSettings("hybrid", force_gain=0.002)
    watch = watch_of(SensorTiming(0.005))
    watch.halve(settings)
    assert asked(watch, replace(settings, force_gain=0.001), touch(3.0))[0].force_gain == pytest.approx(0.001)
    given = replace(settings, gains="as_given")
    watch.halve(given)
    assert asked(watch, given, touch(3.0))[0].force_gain == given.force_gain


SLOW = SensorTiming(0.05)
HIGH = ControlSettings("hybrid", force_gain=0.05, integral_time=0.6)


def pressed(stiffness, *, id_=1, watch=None, settings=HIGH):
    """A limiter after the bar has pressed its own way to 3 N on a spring [N/m]."""
    watch = watch or watch_of(SLOW)
    for depth in 3.0 / stiffness * (1 - np.exp(-np.arange(200) / 30)):
        posture = np.array([-depth / 0.3])
        force = stiffness * depth
        taken, _ = watch.effective_settings(
            settings, posture, touch(force, id_=id_) if force else (), DT, commanded=posture - force * 1e-5
        )
    return watch, taken


@pytest.mark.parametrize("stiffness", [1e3, 5e3, 6e4])
def test_a_measured_contact_gets_the_gains_it_can_hold(stiffness):
    watch, taken = pressed(stiffness)
    assert watch.most == pytest.approx(most_at(SLOW, stiffness, integral=0.6), rel=0.1)
    assert taken.force_gain == pytest.approx(GAIN_SHARE * watch.most)


SERVO = BAR_INERTIA * INNER_FREQUENCY**2 / 0.3**2
"""Stiffness of the bar's servo at 0.3 m [N/m]."""


@pytest.mark.parametrize("controller", ["hybrid", "admittance"])
def test_the_gain_is_raised_where_joints_are_much_softer_than_the_contact(controller):
    low = ControlSettings(controller, force_gain=0.001)
    watch, taken = pressed(6e4, watch=watch_of(SensorTiming(0.005)), settings=low)
    assert taken.force_gain == pytest.approx(SOFT_RATE / SERVO, rel=0.05)
    _, limits = watch.effective_settings(low, np.array([-1e-4]), touch(3.0), DT)
    (limit,) = [one for one in limits if one.kind is LimitKind.FORCE_GAIN_RAISED]
    assert (limit.value, limit.bound) == (pytest.approx(taken.force_gain, rel=0.01), 0.001)
    given = replace(low, gains="as_given")
    assert pressed(6e4, watch=watch_of(SensorTiming(0.005)), settings=given)[1] == given
    fresh = watch_of(SensorTiming(0.005))
    assert asked(fresh, low, touch(3.0))[0].force_gain == 0.001, "not before the contact is measured"
    _, soft = pressed(200.0, watch=watch_of(SensorTiming(0.005)), settings=low)
    assert soft.force_gain < 0.00125, "the contact is soft, not the joints: the point moves as fast as it is told"


def test_an_integral_is_slow_enough_for_what_the_proportional_part_does():
    """Of  s^2 + r s + r / T  the damping ratio is 0.7 at  T = 2 / r,  and with less a soft hand swings."""
    low = ControlSettings("hybrid", force_gain=0.001, integral_time=0.3)
    _, taken = pressed(6e4, watch=watch_of(SensorTiming(0.005)), settings=low)
    assert taken.integral_time == pytest.approx(2 / SOFT_RATE, rel=0.05)
    drawn = replace(low, controller="parallel", position_gain=400.0)
    _, pulled = pressed(6e4, watch=watch_of(SensorTiming(0.005)), settings=drawn)
    assert 0.3 <= pulled.integral_time < taken.integral_time, "drawing back damps too"
    _, quick = pressed(1e3, watch=watch_of(SensorTiming(0.005)), settings=replace(low, force_gain=0.02))
    assert quick.integral_time == 0.3


def test_a_point_that_does_not_make_the_commanded_motion_is_stuck_until_it_moves():
    watch = watch_of(SensorTiming(0.005))
    way = 0.0
    wanted = 0.0

    def went(moved, ticks):
        nonlocal way, wanted
        for _ in range(ticks):
            wanted += 5e-6
            way += moved
            watch.effective_settings(HIGH, np.array([-way / 0.3]), touch(3.0), DT, commanded=np.array([-wanted / 0.3]))
        return watch.stuck

    share = SERVO / (SERVO + CONTACT_STIFFNESS)
    assert went(5e-6 * share, 100) == frozenset(), "joints give way by that much"
    assert went(0.0, 100) == {1}
    assert went(-5e-6, 100) == {1}, "pushed back"
    assert went(5e-6 * share, 200) == frozenset()


def test_another_contact_counts_as_nominal_until_it_is_measured():
    watch, _ = pressed(1e3)
    soft = watch.most
    asked(watch, HIGH, touch(3.0, id_=2), np.array([-0.01]))
    assert watch.most < 0.7 * soft


def test_of_several_contacts_the_smallest_gain_is_taken():
    """A soft contact is measured, then a stiff one comes; each has its own stiffness."""
    watch, alone = pressed(1e3)
    first = touch(3.0)
    posture = np.array([-3e-3 / 0.3])
    both = (*touch(6.0, id_=2), *first)
    taken, _ = watch.effective_settings(HIGH, posture, both, DT, commanded=posture)
    assert taken.force_gain < 0.6 * alone.force_gain, "nominal until it is measured"
    for depth in 6e-5 * (1 - np.exp(-np.arange(200) / 30)):
        posture = np.array([-(3e-3 + depth) / 0.3])
        regions = (*touch(3.2 + 1e5 * depth, id_=2), *touch(3.0 + 1e3 * depth))
        taken, _ = watch.effective_settings(HIGH, posture, regions, DT, commanded=posture - 1e-5 * regions[0].force)
    assert watch.most == pytest.approx(most_at(SLOW, 1e5, posture=posture, integral=0.6), rel=0.1)
    assert taken.force_gain == pytest.approx(GAIN_SHARE * watch.most)
    light = (*first, *touch(0.4 * HIGH.force_goal, id_=2))
    taken, _ = watch.effective_settings(HIGH, posture, light, DT, commanded=posture)
    assert taken.force_gain == pytest.approx(alone.force_gain, rel=0.1), "it has no force goal any longer"


def test_the_oscillation_of_any_controlled_contact_halves_the_gain():
    settings = replace(HIGH, force_gain=0.001)
    watch = watch_of(SensorTiming(0.005))
    for k in range(400):
        swing = np.sin(30 * k * DT)
        regions = (*touch(4.0), *touch(3.0 + 2.5 * swing, id_=2))
        taken, _ = watch.effective_settings(settings, np.array([-1e-4 * swing]), regions, DT)
    assert watch.reduced
    assert taken.force_gain <= 0.5 * settings.force_gain


def test_a_contact_that_bounces_comes_back_as_a_new_one_and_oscillates_all_the_same():
    settings = replace(HIGH, force_gain=0.001)
    watch = watch_of(SensorTiming(0.005))
    for k in range(600):
        swing = np.sin(2 * np.pi * 3 * k * DT)
        id_ = 1 + int(3 * k * DT)
        regions = touch(3.5 * swing, id_=id_) if swing > 0 else ()
        watch.effective_settings(settings, np.array([-1e-4 * swing]), regions, DT)
    assert watch.reduced


def test_what_one_robot_does_to_itself_is_not_measured():
    both = watch_of(SLOW)
    for depth in 3e-3 * (1 - np.exp(-np.arange(200) / 30)):
        (one,), posture = touch(1e3 * depth), np.array([-depth / 0.3])
        both.effective_settings(HIGH, posture, (replace(one, partner=7),), DT, commanded=posture)
    assert both.most == pytest.approx(most_at(SLOW, integral=0.6), rel=1e-3)


def test_the_limit_follows_the_arm():
    """A bar that is touched from the side moves away from nothing; from above it does."""
    watch = watch_of(SLOW)
    tilted = touch(3.0, normal=(np.sin(1.2), 0, np.cos(1.2)))
    asked(watch, HIGH, tilted)
    before = watch.most
    asked(watch, HIGH, tilted, np.array([0.04]))
    assert watch.most == before, "about there it does"
    asked(watch, HIGH, touch(3.0), np.array([0.5]))
    assert watch.most != before
