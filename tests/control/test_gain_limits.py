"""Gains that are reduced, raised or reported, by what skin, arm and contact allow."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.control.force_loop.loop_stability import CONTACT_STIFFNESS, SensorTiming
from tactile_maps.control.force_loop.pressed_arm import LoopFilter, pressed_arm
from tactile_maps.control.gain_limits import (
    CALM,
    GAIN_SHARE,
    LEAST_SHARE,
    NOMINAL_SHARE,
    PLACE_SHARE,
    SAMPLED_SHARE,
    SOFT_RATE,
    STUCK_SHARE,
    GainLimiter,
)
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.joint_impedance import INNER_FREQUENCY, posture_loop
from tactile_maps.control.motion.limits import Limit, LimitKind
from tactile_maps.robots.kinematics import Configuration
from tests.control.contacts import TICK, touch
from tests.support.generated_robots import leg, load
from tests.support.loop_trials import max_stable_gain
from tests.support.touch import BAR_INERTIA, bar

QUICK = SensorTiming(0.005)
SLOW = SensorTiming(0.05)
SERVO = BAR_INERTIA * INNER_FREQUENCY**2 / 0.3**2
"""Stiffness of the bar's servo at 0.3 m [N/m]."""
APPROACH = 1 - np.exp(-np.arange(200) / 30)


class Bench:
    """A gain limiter of the bar, pressed at 0.3 m."""

    def __init__(self, readings=QUICK, controller="hybrid", **settings):
        self.limiter = GainLimiter(bar())
        self.limiter.readings = readings
        self.settings = ControlSettings(controller, **settings)

    def step(self, contacts=touch(3.0), outward=0.0, *, commanded=None):  # noqa: B008 - frozen
        """The effective settings, where the point of contact is ``outward`` [m] and commanded to be so far."""
        postures = [None if way is None else np.array([-way / 0.3]) for way in (outward, commanded)]
        self.taken, self.limits = self.limiter.effective_settings(
            self.settings, postures[0], contacts, TICK, commanded=postures[1]
        )
        return self.taken

    @property
    def gain(self):
        """The effective force gain after one more tick."""
        return self.step().force_gain

    def press(self, stiffness):
        """Press up to 3 N on a spring [N/m]."""
        for depth in 3.0 / stiffness * APPROACH:
            force = stiffness * depth
            self.step(touch(force) if force else (), depth, commanded=depth + 0.3 * force * 1e-5)
        return self

    def halve(self, times=1):
        for _ in range(times):
            self.limiter.halve(self.settings)


def sampled_most(readings: SensorTiming) -> float:
    """The limit of ideal joints: the bar's servo in series with a nominal contact."""
    return max_stable_gain(1 / (1 / SERVO + 1 / CONTACT_STIFFNESS), readings)


def most_at(readings: SensorTiming, stiffness: float = CONTACT_STIFFNESS, *, outward=0.0, integral=0.3) -> float:
    """The stability limit of the bar, touched at 0.3 m."""
    configuration = Configuration(bar())
    impedance = posture_loop(configuration)
    configuration.update(np.array([-outward / 0.3]))
    arm = pressed_arm(configuration, impedance, touch(3.0)[0], stiffness, slides=True)
    return arm.gain_limit(LoopFilter(integral), readings, TICK)


def test_gain_used_as_given_is_reported_from_the_stability_limit_on():
    most = most_at(SLOW)
    for share, reported in ((0.99, False), (1.01, True)):
        bench = Bench(SLOW, gains="as_given", force_gain=share * most)
        assert bench.step() == bench.settings
        assert len(bench.limits) == reported
    [limit] = bench.limits
    assert limit.kind is LimitKind.FORCE_GAIN_UNSTABLE
    assert (limit.value, limit.bound, limit.period) == pytest.approx((1.01 * most, most, 0.05))


def test_gains_for_a_slow_skin_are_limited_to_a_share_and_reported():
    slow = SensorTiming(0.2, 0.1)
    bench = Bench(slow, force_gain=0.015, position_gain=4.0, integral_time=0.3)
    taken = bench.step()
    force, place = taken.force_gain, taken.position_gain
    assert force == pytest.approx(SAMPLED_SHARE * sampled_most(slow), rel=0.01)
    assert place == pytest.approx(PLACE_SHARE / 0.3)
    assert taken == replace(bench.settings, force_gain=force, position_gain=place, integral_time=12 * (0.2 + 0.1))
    timing = {"period": 0.2, "delay": 0.1}
    assert bench.limits == (
        Limit(LimitKind.FORCE_GAIN_HELD, value=force, bound=0.015, **timing),
        Limit(LimitKind.POSITION_GAIN_HELD, value=place, bound=4.0, **timing),
    )


def test_gains_for_a_fast_skin_are_limited_by_the_joints():
    high = Bench(force_gain=1.0)
    assert high.gain == pytest.approx(NOMINAL_SHARE * most_at(QUICK))
    assert high.gain < SAMPLED_SHARE * sampled_most(QUICK)
    low = Bench(force_gain=0.002)
    assert (low.step(), low.limits) == (low.settings, ())


def test_lost_contact_is_searched_for_with_its_gains_without_a_report():
    bench = Bench(SensorTiming(0.2, 0.2), force_gain=0.05)
    assert (bench.step(()), bench.limits) == (bench.settings, ()), "nothing has touched yet"
    taken = bench.step()
    assert bench.limits
    assert (bench.step(()), bench.limits) == (taken, ())
    bench.limiter.reset()
    assert bench.step(()) == bench.settings
    bench.step()
    bench.settings = replace(bench.settings, force_gain=0.04)
    assert bench.step(()) == bench.settings, "other settings"


@pytest.mark.parametrize(("readings", "controller"), [(None, "hybrid"), (SensorTiming(0.2, 0.2), "impedance")])
def test_gains_are_unlimited_without_timing_of_the_skin_and_for_impedance(readings, controller):
    bench = Bench(readings, controller, force_gain=0.05)
    assert (bench.step(), bench.limits) == (bench.settings, ())


def test_gains_are_computed_again_for_other_settings_and_skins_but_not_for_another_path():
    bench = Bench(SensorTiming(0.01), force_gain=1.0)
    before = bench.step()
    said = bench.limits
    path = {"path_kind": "raster", "path": ((0.0, 0.0), (0.1, 0.1)), "path_size": 0.1, "path_speed": 0.1, "starts": 7}
    bench.settings = replace(bench.settings, **path)
    aside = touch(3.0, x=0.2)  # the limit there would differ
    assert bench.step(aside) == replace(before, **path)
    assert bench.limits == said
    bench.settings = replace(bench.settings, force_goal=2.0)
    assert bench.step(aside).force_gain != before.force_gain
    bench.limiter.readings = SensorTiming(0.2, 0.2)
    assert bench.step(aside).force_gain < 0.2 * before.force_gain


@pytest.mark.sampled(1)
@pytest.mark.parametrize("controller", ["hybrid", "parallel", "admittance"])
def test_oscillation_halves_the_gain_until_it_has_been_calm(controller):
    bench = Bench(QUICK, controller, force_gain=0.002)
    before = bench.gain
    for share in (2, 4):
        bench.halve()
        assert bench.gain == pytest.approx(before / share)
    assert bench.limiter.reduced
    gains = [bench.gain for _ in range(round(7 * CALM / TICK))]
    assert gains[round(1.9 * CALM / TICK)] == pytest.approx(before / 4), "twice as long after the second time"
    assert gains[round(2.1 * CALM / TICK)] == pytest.approx(before / 2)
    assert gains[-1] == pytest.approx(before)
    assert not bench.limiter.reduced


@pytest.mark.parametrize(("yields", "reduced"), [(True, False), (False, True)])
def test_recovered_gain_is_reduced_by_the_loop_and_not_by_three_taps(yields, reduced):
    bench = Bench(force_gain=0.002)
    before = bench.gain
    bench.halve()
    for _ in range(round((CALM + 0.1) / TICK)):
        bench.step()
    assert bench.gain == before
    for pressed in np.tile(np.repeat([1.0, 0.0], round(0.2 / TICK)), 3):
        bench.step(touch(9.0 * pressed + 0.2), (-1e-3 if yields else 1e-3) * pressed)
    assert bench.limiter.reduced == reduced


def test_oscillation_at_the_smallest_gain_is_reported_until_it_has_been_calm():
    bench = Bench(force_gain=0.002)
    before = bench.gain
    bench.halve(round(-np.log2(LEAST_SHARE)))
    assert not bench.limiter.exhausted, "not known to oscillate with the smallest gain"
    for _ in range(3):
        bench.halve()
        assert bench.limiter.exhausted
        assert bench.gain == pytest.approx(LEAST_SHARE * before)
    for _ in range(round((0.5 * CALM / LEAST_SHARE + 0.1) / TICK)):
        bench.step()
    assert bench.taken.force_gain == pytest.approx(2 * LEAST_SHARE * before)
    assert not bench.limiter.exhausted


def test_reduction_ends_with_other_settings_and_spares_gains_used_as_given():
    bench = Bench(force_gain=0.002)
    bench.halve()
    for settings in ({"force_gain": 0.001}, {"force_gain": 0.002, "gains": "as_given"}):
        bench.settings = replace(bench.settings, **settings)
        assert bench.gain == bench.settings.force_gain
    bench.halve()
    assert bench.gain == bench.settings.force_gain


HIGH = {"force_gain": 0.05, "integral_time": 0.6}


@pytest.mark.parametrize("stiffness", [1e3, 5e3, 6e4])
def test_gain_follows_the_measured_stiffness_of_each_contact(stiffness):
    bench = Bench(SLOW, **HIGH).press(stiffness)
    most = bench.limiter.most
    assert most == pytest.approx(most_at(SLOW, stiffness, integral=0.6), rel=0.1)
    assert bench.taken.force_gain == pytest.approx(GAIN_SHARE * most)
    bench.step(touch(3.0, id_=2), 3e-3)
    assert bench.limiter.most == pytest.approx(most_at(SLOW, integral=0.6), rel=0.01), "a new contact is nominal"


@pytest.mark.parametrize("controller", ["hybrid", "admittance"])
def test_gain_is_raised_where_joints_are_much_softer_than_the_contact(controller):
    low = {"controller": controller, "force_gain": 0.001}
    assert Bench(**low).gain == 0.001, "not before the contact is measured"
    bench = Bench(**low).press(6e4)
    assert bench.taken.force_gain == pytest.approx(SOFT_RATE / SERVO, rel=0.05)
    bench.step(outward=3e-5)
    (limit,) = [one for one in bench.limits if one.kind is LimitKind.FORCE_GAIN_RAISED]
    assert (limit.value, limit.bound) == (pytest.approx(bench.taken.force_gain, rel=0.01), 0.001)
    given = Bench(**low, gains="as_given").press(6e4)
    assert given.taken == given.settings
    assert Bench(**low).press(200.0).taken.force_gain < 0.00125, "the contact is soft, not the joints"


def test_integral_is_slow_enough_for_the_proportional_part():
    """The damping ratio of s^2 + r s + r / T is 0.7 at T = 2 / r; a smaller T makes a soft hand oscillate."""
    low = {"force_gain": 0.001, "integral_time": 0.3}
    slowest = Bench(**low).press(6e4).taken.integral_time
    assert slowest == pytest.approx(2 / SOFT_RATE, rel=0.05)
    pulled = Bench(QUICK, "parallel", **low, position_gain=400.0).press(6e4).taken.integral_time
    assert 0.3 <= pulled < slowest, "drawing back damps too"
    assert Bench(force_gain=0.02, integral_time=0.3).press(1e3).taken.integral_time == 0.3


@pytest.mark.parametrize(("home", "share"), [((-1.2, 0.8, 1.0), 0.71), ((0.5, 0.1, -0.5), STUCK_SHARE)])
def test_integral_allows_for_friction_that_holds_the_contact(tmp_path, home, share):
    """The joints of a leg hardly move its shank along the skin: less of a push gets through while a contact sticks."""
    robot = load(leg(), tmp_path, home=dict(zip(("joint1", "joint2", "joint3"), home, strict=True)))
    configuration = Configuration(robot)
    one = replace(touch(3.0, normal=(1, 0, 0))[0], link="link3", link_position=np.array([0.03, 0.0, 0.15]))
    stiffness = 6e4
    arm = pressed_arm(configuration, posture_loop(configuration), one, stiffness, slides=True)
    series = arm.series_stiffness
    assert max(arm.sticking_stiffness, STUCK_SHARE * series) == pytest.approx(share * series, rel=0.02)
    outward = configuration.pose("link3").rotation[:, 0] @ configuration.jacobian("link3", one.link_position)
    push = outward / outward.dot(outward)
    limiter = GainLimiter(robot)
    limiter.readings = QUICK
    settings = ControlSettings("hybrid", task="keep_force", integral_time=0.1)
    for depth in 3.0 / stiffness * APPROACH:
        contacts = (replace(one, force=stiffness * depth),) if depth else ()
        posture = robot.home + push * depth
        commanded = robot.home + push * depth * stiffness / series
        taken, _ = limiter.effective_settings(settings, posture, contacts, TICK, commanded=commanded)
    assert taken.integral_time == pytest.approx(2 / (taken.force_gain * share * series), rel=0.05)


def test_point_that_does_not_make_the_commanded_motion_is_stuck_until_it_moves():
    bench = Bench(**HIGH)
    follows = 5e-6 * SERVO / (SERVO + CONTACT_STIFFNESS)  # joints give way
    way = commanded = 0.0
    for moved, ticks, stuck in ((follows, 100, set()), (0.0, 100, {1}), (-5e-6, 100, {1}), (follows, 200, set())):
        for _ in range(ticks):
            commanded += 5e-6
            way += moved
            bench.step(outward=way, commanded=commanded)
        assert bench.limiter.stuck == stuck


def test_smallest_gain_of_several_contacts_is_used():
    """A soft contact is measured, then a stiff one comes; each has its own stiffness."""
    bench = Bench(SLOW, **HIGH).press(1e3)
    alone = bench.taken.force_gain
    both = bench.step((*touch(6.0, id_=2), *touch(3.0)), 3e-3, commanded=3e-3)
    assert both.force_gain < 0.6 * alone, "nominal until it is measured"
    for depth in 6e-5 * APPROACH:
        contacts = (*touch(3.2 + 1e5 * depth, id_=2), *touch(3.0 + 1e3 * depth))
        way = 3e-3 + depth
        bench.step(contacts, way, commanded=way + 0.3 * 1e-5 * contacts[0].force)
    assert bench.limiter.most == pytest.approx(most_at(SLOW, 1e5, outward=way, integral=0.6), rel=0.1)
    assert bench.taken.force_gain == pytest.approx(GAIN_SHARE * bench.limiter.most)
    bench.step((*touch(3.0), *touch(0.4 * bench.settings.force_goal, id_=2)), way, commanded=way)
    assert bench.taken.force_gain == pytest.approx(alone, rel=0.1), "it has no force goal any longer"


def second_contact_swings(tick):
    swing = np.sin(30 * tick * TICK)
    return (*touch(4.0), *touch(3.0 + 2.5 * swing, id_=2)), swing


def contact_bounces(tick):
    """It returns as a new contact each time."""
    swing = np.sin(2 * np.pi * 3 * tick * TICK)
    return (touch(3.5 * swing, id_=1 + int(3 * tick * TICK)) if swing > 0 else ()), swing


@pytest.mark.parametrize("motion", [second_contact_swings, contact_bounces])
def test_oscillation_of_any_contact_halves_the_gain(motion):
    bench = Bench(force_gain=0.001, integral_time=0.6)
    for tick in range(600):
        contacts, swing = motion(tick)
        bench.step(contacts, 3e-5 * swing)
    assert bench.limiter.reduced
    assert bench.taken.force_gain <= 0.5 * bench.settings.force_gain


def test_self_contact_is_not_measured():
    bench = Bench(SLOW, **HIGH)
    for depth in 3e-3 * APPROACH:
        (one,) = touch(1e3 * depth)
        bench.step((replace(one, partner=7),), depth, commanded=depth)
    assert bench.limiter.most == pytest.approx(most_at(SLOW, integral=0.6), rel=1e-3)


def test_limit_is_computed_again_for_another_posture():
    """A bar that is touched from the side moves away from nothing; from above it does."""
    bench = Bench(SLOW, **HIGH)
    tilted = touch(3.0, normal=(np.sin(1.2), 0, np.cos(1.2)))
    bench.step(tilted)
    before = bench.limiter.most
    bench.step(tilted, -0.04 * 0.3)
    assert bench.limiter.most == before, "for a similar posture it is the same"
    bench.step(touch(3.0), -0.5 * 0.3)
    assert bench.limiter.most != before
