"""Safety stops, contacts that do not follow, and the energy given to contacts."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from tactile_maps.contacts.detection.contact_shear import ContactShear, Slip
from tactile_maps.contacts.force_estimation.wrench_consistency import WrenchMismatch
from tactile_maps.control.motion.limits import Limit, LimitKind
from tactile_maps.control.motion.unmeasured_force import UnmeasuredForce
from tactile_maps.control.task_control.monitors import (
    AGAIN,
    AGREED,
    FULL,
    LONGEST,
    LOW,
    QUIET,
    STOP_POINT_SPEED,
    STOP_SLIDE_SPEED,
    STOP_SPEED,
    STOP_SPEED_MARGIN,
    UNMEASURED_TOUCH,
    YIELD_SLIDE_SPEED,
    YIELD_SPEED,
    YIELD_TIME,
    EnergyTank,
    SafetyMonitor,
    StallDetector,
)
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.robots.model.robot import Joint
from tests.control.contacts import TICK, observed, touch

BENT = [0.3]
HINGE = (Joint("hinge", -1.5, 1.5),)
MIXED = (Joint("hinge", -1.5, 1.5), Joint("lift", 0.0, 0.4, slide=True), Joint("slow", 0.0, 0.4, True, max_speed=0.07))
MISMATCH = WrenchMismatch("bar", 2, force=1.0, torque=0.3, max_force=2.0, max_torque=0.1, strongest=5.0)

_SHEAR = ContactShear((0.0, float("nan"), 0.0), 0.0, 0.0, 1.0, Slip.STICKING, 0.5, estimated=False)
NO_SHEAR = tuple(replace(region, shear=_SHEAR) for region in touch(3.0))


class Safety(SafetyMonitor):
    """A monitor with a largest force of 30 N."""

    def passes(self, contacts=(), posture=BENT, *, velocity=0.0, unmeasured=0.0, point_speed=0.0, **state):
        seen = replace(observed(posture, contacts), velocity=np.broadcast_to(velocity, len(posture)), **state)
        force = UnmeasuredForce("hand", unmeasured)
        return self.check(30.0, seen, point_speed=point_speed, unmeasured=force)

    def seconds_until_it_continues(self, *contacts, **state):
        ticks = 0
        while not self.passes(*contacts, **state):
            ticks += 1
        return ticks * TICK


@pytest.mark.parametrize(
    ("state", "reason"),
    [
        ({"contacts": touch(29.9)}, None),
        ({"contacts": touch(31.4)}, Limit(LimitKind.STOPPED_BY_FORCE, value=31.4, bound=30.0)),
        ({"contacts": touch(float("nan"))}, Limit(LimitKind.STOPPED_UNREADABLE)),
        ({"contacts": touch(3.0, normal=(0, 0, float("nan")))}, Limit(LimitKind.STOPPED_UNREADABLE)),
        ({"contacts": NO_SHEAR}, Limit(LimitKind.STOPPED_UNREADABLE)),
        ({"readable": False}, Limit(LimitKind.STOPPED_UNREADABLE)),
        ({"velocity": -3.5}, Limit(LimitKind.STOPPED_BY_SPEED, ("hinge",), value=3.5, bound=STOP_SPEED)),
        ({"point_speed": STOP_POINT_SPEED}, None),
        ({"point_speed": 1.5}, Limit(LimitKind.STOPPED_BY_POINT_SPEED, value=1.5, bound=STOP_POINT_SPEED)),
        ({"unmeasured": 29.9}, None),
        ({"unmeasured": 31.0}, Limit(LimitKind.STOPPED_BY_UNMEASURED_FORCE, ("hand",), value=31.0, bound=30.0)),
    ],
)
def test_unsafe_state_stops_the_arm_until_nothing_has_touched_for_a_while(state, reason):
    monitor = Safety(HINGE)
    assert monitor.passes(**state) == (reason is None)
    assert monitor.reason == reason
    if reason is None:
        return
    for k in range(600):
        pressed = {"unmeasured": 1.1 * UNMEASURED_TOUCH} if k < 300 else {"contacts": touch(1.0)}
        assert not monitor.passes(posture=[0.0], **pressed), "still touched"
    assert monitor.posture == pytest.approx([0.0], abs=0.02), "it has yielded"
    kept = monitor.posture
    assert not monitor.passes(unmeasured=1.0)
    assert np.array_equal(monitor.posture, kept), "untouched it holds its place"
    assert TICK + monitor.seconds_until_it_continues() == pytest.approx(QUIET, abs=2 * TICK)
    assert monitor.reason is None


@pytest.mark.parametrize(
    ("velocity", "kind", "joint", "bound"),
    [
        ([2.9, 0.45, 0.1], None, "", 0.0),
        ([-3.1, 0.0, 0.0], LimitKind.STOPPED_BY_SPEED, "hinge", STOP_SPEED),
        ([2.9, 0.6, 0.0], LimitKind.STOPPED_BY_SLIDE_SPEED, "lift", STOP_SLIDE_SPEED),
        ([0.0, 0.0, -0.11], LimitKind.STOPPED_BY_SLIDE_SPEED, "slow", 0.07 * STOP_SPEED_MARGIN),
    ],
)
def test_hinges_and_slides_have_their_own_speed_limits(velocity, kind, joint, bound):
    monitor = Safety(MIXED)
    assert monitor.passes(posture=np.zeros(3), velocity=velocity) == (kind is None)
    value = max(map(abs, velocity), key=lambda v: v != 2.9 and v)
    assert monitor.reason == (None if kind is None else Limit(kind, (joint,), value=value, bound=bound))


def test_stopped_arm_yields_no_faster_than_allowed():
    monitor = Safety(MIXED)
    monitor.passes(touch(31.0), np.zeros(3))
    for _ in range(20):
        before = monitor.posture
        monitor.passes(touch(31.0), [1.0, 0.3, -0.2])
        assert (monitor.posture - before) / TICK == pytest.approx([YIELD_SPEED, YIELD_SLIDE_SPEED, -0.07])


def test_mismatch_stops_the_arm_until_one_contact_has_explained_the_wrench_for_a_while():
    monitor = Safety(HINGE)
    assert not monitor.passes(touch(1.0), mismatch=MISMATCH)
    assert monitor.reason == Limit(LimitKind.STOPPED_BY_MISMATCH, ("bar",), value=0.3, bound=0.1)
    assert not monitor.passes(touch(1.0), dt=AGREED / 2)
    assert not monitor.passes(touch(1.0), mismatch=MISMATCH), "it counts from the last"
    assert monitor.seconds_until_it_continues(touch(1.0)) == pytest.approx(AGREED, abs=2 * TICK)


def test_large_forces_with_a_small_resultant_stop_the_arm_until_nothing_touches():
    monitor = Safety(HINGE)
    monitor.passes(touch(1.0), mismatch=MISMATCH)
    monitor.passes(touch(1.0), [0.0], mismatch=replace(MISMATCH, strongest=31.0))
    assert monitor.reason == Limit(LimitKind.STOPPED_BY_FORCE, value=31.0, bound=30.0)
    assert monitor.posture == pytest.approx([0.3 * (1 - TICK / YIELD_TIME)]), "from where it stopped first"
    assert not monitor.passes(touch(1.0), dt=2 * AGREED)
    monitor.reset()
    assert monitor.passes(touch(1.0))


def test_robot_without_joints_is_never_too_fast():
    assert Safety(()).passes(posture=())


STICKS = LimitKind.CONTACT_STICKS
SHORT = LimitKind.NO_APPROACH
ERROR = np.array([0.01, 0.0])
REQUESTED = np.array([0.04, 0.0])
HERE, THERE = (SurfacePoint(0, face, (1.0, 0.0, 0.0)) for face in (0, 1))


def detector(share, *, requested=REQUESTED, tried=1.0, seconds=2.0, jump_at=-1, turn=0.0):
    """A detector after a contact moved by a share of what the arm tried, rotated by ``turn`` degrees."""
    found = StallDetector(0.005)
    point = np.zeros(2)
    c, s = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    for tick in range(round(seconds / TICK)):
        point = point + np.array([[c, -s], [s, c]]) @ (share * tried * requested) * TICK
        point = point + (np.array([-0.3, 0.2]) if tick == jump_at else 0.0)
        found.look(1, point, ERROR, requested, tried * requested, TICK, target=HERE)
    return found


def kind_of(limit):
    return None if limit is None else limit.kind


def look(stalled, error=ERROR, *, contact=1, target=HERE):
    return kind_of(stalled.look(contact, np.zeros(2), error, REQUESTED, REQUESTED, TICK, target=target))


@pytest.mark.parametrize(
    ("motion", "reason"),
    [
        ({"share": 0.0}, STICKS),
        ({"share": -1.0}, STICKS),
        ({"share": 0.5}, None),
        ({"share": 1.0, "jump_at": 40}, None),  # over a seam
        *(({"share": 1.0, "turn": turn}, None) for turn in (30, 60, 75, -90)),  # a wrong map
        ({"share": 0.0, "tried": 0.0}, SHORT),
        ({"share": 1.0, "tried": 0.0}, SHORT),
        ({"share": 0.0, "tried": 0.3}, STICKS),
        ({"share": 1.0, "tried": 0.3}, None),
        ({"share": 0.0, "seconds": 0.2}, None),
        ({"share": 0.0, "requested": 0.02 * REQUESTED, "seconds": 3 * LONGEST}, None),
    ],
)
def test_contact_sticks_if_it_does_not_slide_and_the_arm_is_named_if_it_does_not_try(motion, reason):
    assert kind_of(detector(**motion).reason) == reason


def test_motion_that_falls_short_is_stated_with_its_figures():
    """Motion at 40 mm/s is evaluated after 0.3 s."""
    limit = detector(0.0, tried=0.05).reason
    assert (limit.kind, limit.value / limit.bound) == (SHORT, pytest.approx(0.05))
    assert 0.012 <= limit.bound < 0.013


def test_contact_does_not_stick_while_soft_joints_absorb_the_motion():
    for yielding, reason in ((0.1, None), (0.0, STICKS)):
        stalled = StallDetector(0.005)
        for _ in range(200):
            stalled.look(1, np.zeros(2), ERROR, REQUESTED, REQUESTED, TICK, target=HERE, yielding=yielding)
        assert kind_of(stalled.reason) == reason


def test_sticking_contact_is_tried_again_with_another_error_or_contact():
    stalled = detector(0.0)
    assert look(stalled) == STICKS
    assert look(stalled, ERROR + [0, 1.1 * AGAIN]) is None
    assert look(detector(0.0), contact=2) is None
    stalled = detector(0.0)
    stalled.reset()
    assert look(stalled) is None


def test_target_that_is_not_approached_is_tried_again_when_it_changes_or_is_nearer():
    """A released contact slides away, and comes and goes: that is no reason to try again."""
    stalled = detector(0.0, tried=0.0)
    assert look(stalled, ERROR + [0.01, 0]) == SHORT
    assert look(stalled, contact=2) == SHORT
    assert look(stalled, ERROR - [1.1 * AGAIN, 0]) is None
    assert look(detector(0.0, tried=0.0), target=THERE) is None


def test_tank_counts_energy_and_contains_no_more_than_full():
    tank = EnergyTank()
    for given, damped, seconds, level in (
        (2.0, 0.0, 0.1, FULL - 0.2),
        (-1.0, 0.0, 0.1, FULL - 0.1),
        (0.0, 1.0, 0.1, FULL - 0.05),  # half of what is damped
        (-100.0, 0.0, 1.0, FULL),
    ):
        tank.flow(given, damped, seconds)
        assert tank.level == pytest.approx(level)
    assert tank.given == pytest.approx(0.1 - 100.0)
    tank.reset()
    assert (tank.level, tank.given) == (FULL, 0.0)


def test_tank_gives_nine_tenths_of_a_joule():
    """A hand is followed with 3 N over 30 cm, and no farther; the numbers are those of this test."""
    tank = EnergyTank()
    shares = []
    for given, damped, seconds in ((0.3, 0.0, 2.0), (0.3, 0.0, 1.0), (0.0, 1.0, 0.1)):
        tank.flow(given, damped, seconds)
        shares.append(tank.share)
    assert shares == pytest.approx([1, 0, 0.5], abs=1e-9)


def test_share_of_the_tank_falls_smoothly_and_keeps_a_rest():
    tank = EnergyTank()
    shares = []
    while tank.level > 0:
        tank.flow(1.0, 0.0, 0.01)
        shares.append(tank.share)
    assert (shares[0], shares[-1]) == (1.0, 0.0)
    assert all(0 <= before - after < 0.16 for before, after in pairwise(shares))
    again = EnergyTank()
    for _ in range(100_000):
        again.flow(10.0 * again.share, 0.0, 0.001)
    assert again.level >= LOW - 1e-2
    assert again.given <= FULL
