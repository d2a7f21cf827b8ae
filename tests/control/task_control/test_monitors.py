"""What stops a controller, what holds a contact up, and what energy is given."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from tactile_maps.contacts.force_estimation.wrench_consistency import WrenchMismatch
from tactile_maps.control.motion.limits import Limit, LimitKind
from tactile_maps.control.motion.observation import Observation
from tactile_maps.control.motion.unmeasured_force import UnmeasuredForce
from tactile_maps.control.task_control.monitors import (
    AGAIN,
    AGREED,
    FULL,
    LONGEST,
    LOW,
    QUIET,
    RECOVERED,
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
from tests.control.contacts import TICK, touch

STILL = np.zeros(1)
BENT = np.array([0.3])
HINGE = (Joint("hinge", -1.5, 1.5),)


def test_what_is_safe_goes_on():
    supervisor = SafetyMonitor(HINGE)
    assert supervisor.check(30.0, Observation(BENT, STILL, touch(29.9), TICK))
    assert supervisor.reason is None


@pytest.mark.parametrize(
    ("regions", "velocity", "reason"),
    [
        (touch(31.4), STILL, Limit(LimitKind.STOPPED_BY_FORCE, value=31.4, bound=30.0)),
        (touch(float("nan")), STILL, Limit(LimitKind.STOPPED_UNREADABLE)),
        (touch(3.0, normal=(0, 0, float("nan"))), STILL, Limit(LimitKind.STOPPED_UNREADABLE)),
        ((), np.array([-3.5]), Limit(LimitKind.STOPPED_BY_SPEED, ("hinge",), value=3.5, bound=STOP_SPEED)),
    ],
)
def test_what_is_not_safe_stops_until_nothing_touched_for_a_while(regions, velocity, reason):
    supervisor = SafetyMonitor(HINGE)
    assert not supervisor.check(30.0, Observation(BENT, velocity, regions, TICK))
    assert supervisor.reason == reason
    for _ in range(300):
        assert not supervisor.check(30.0, Observation(STILL, STILL, touch(1.0), TICK)), "still touched"
    assert supervisor.posture == pytest.approx(STILL, abs=0.02), "it has given way to where it is pressed"
    kept = supervisor.posture
    ticks = 0
    while not supervisor.check(30.0, Observation(BENT, STILL, (), TICK)):
        assert np.array_equal(supervisor.posture, kept), "untouched it holds its place"
        ticks += 1
    assert ticks * TICK == pytest.approx(QUIET, abs=2 * TICK)
    assert supervisor.reason is None


def test_a_touched_point_that_is_too_fast_stops_it():
    supervisor = SafetyMonitor(HINGE)
    assert supervisor.check(30.0, Observation(BENT, STILL, touch(1.0), TICK), point_speed=STOP_POINT_SPEED)
    assert not supervisor.check(30.0, Observation(BENT, STILL, touch(1.0), TICK), point_speed=1.5)
    assert supervisor.reason == Limit(LimitKind.STOPPED_BY_POINT_SPEED, value=1.5, bound=STOP_POINT_SPEED)


MIXED = (Joint("hinge", -1.5, 1.5), Joint("lift", 0.0, 0.4, slide=True), Joint("slow", 0.0, 0.4, True, max_speed=0.07))


@pytest.mark.parametrize(
    ("velocity", "reason"),
    [
        ([2.9, 0.45, 0.1], None),
        ([-3.1, 0.0, 0.0], Limit(LimitKind.STOPPED_BY_SPEED, ("hinge",), value=3.1, bound=STOP_SPEED)),
        ([2.9, 0.6, 0.0], Limit(LimitKind.STOPPED_BY_SLIDE_SPEED, ("lift",), value=0.6, bound=STOP_SLIDE_SPEED)),
        (
            [0.0, 0.0, -0.11],
            Limit(LimitKind.STOPPED_BY_SLIDE_SPEED, ("slow",), value=0.11, bound=0.07 * STOP_SPEED_MARGIN),
        ),
    ],
)
def test_hinges_and_slides_have_their_own_speed_limits(velocity, reason):
    supervisor = SafetyMonitor(MIXED)
    assert supervisor.check(30.0, Observation(np.zeros(3), np.array(velocity), (), TICK)) == (reason is None)
    assert supervisor.reason == reason


def test_a_stopped_arm_gives_way_no_faster_than_allowed():
    supervisor = SafetyMonitor(MIXED)
    supervisor.check(30.0, Observation(np.zeros(3), np.zeros(3), touch(31.0), TICK))
    pushed = np.array([1.0, 0.3, -0.2])
    for _ in range(20):
        before = supervisor.posture
        supervisor.check(30.0, Observation(pushed, np.zeros(3), touch(31.0), TICK))
        assert (supervisor.posture - before) / TICK == pytest.approx([YIELD_SPEED, YIELD_SLIDE_SPEED, -0.07])


def test_a_skin_that_cannot_be_read_stops_it_too():
    supervisor = SafetyMonitor(HINGE)
    assert not supervisor.check(30.0, Observation(BENT, STILL, (), TICK, readable=False))
    assert supervisor.reason == Limit(LimitKind.STOPPED_UNREADABLE)


MISMATCH = WrenchMismatch("bar", 2, force=1.0, torque=0.3, max_force=2.0, max_torque=0.1, strongest=5.0)


def test_several_contacts_read_as_one_stop_it_until_one_explains_the_wrench_for_a_while():
    supervisor = SafetyMonitor(HINGE)
    assert not supervisor.check(30.0, Observation(BENT, STILL, touch(1.0), TICK, mismatch=MISMATCH))
    assert supervisor.reason == Limit(LimitKind.STOPPED_BY_MISMATCH, ("bar",), value=0.3, bound=0.1)
    assert not supervisor.check(30.0, Observation(STILL, STILL, touch(1.0), AGREED / 2))
    assert not supervisor.check(30.0, Observation(STILL, STILL, touch(1.0), TICK, mismatch=MISMATCH)), (
        "it counts from the last"
    )
    ticks = 0
    while not supervisor.check(30.0, Observation(STILL, STILL, touch(1.0), TICK)):
        ticks += 1
    assert ticks * TICK == pytest.approx(AGREED, abs=2 * TICK)


def test_what_presses_too_hard_behind_a_small_resultant_stops_it_for_good():
    supervisor = SafetyMonitor(HINGE)
    supervisor.check(30.0, Observation(BENT, STILL, touch(1.0), TICK, mismatch=MISMATCH))
    supervisor.check(30.0, Observation(STILL, STILL, touch(1.0), TICK, mismatch=replace(MISMATCH, strongest=31.0)))
    assert supervisor.reason == Limit(LimitKind.STOPPED_BY_FORCE, value=31.0, bound=30.0)
    assert supervisor.posture == pytest.approx(BENT * (1 - TICK / YIELD_TIME)), "where it stopped first, yielding"
    assert not supervisor.check(30.0, Observation(STILL, STILL, touch(1.0), 2 * AGREED)), "something still touches"


def test_force_that_the_skin_does_not_measure_stops_it_until_it_has_gone():
    supervisor = SafetyMonitor(HINGE)
    assert supervisor.check(30.0, Observation(BENT, STILL, (), TICK), unmeasured=UnmeasuredForce("hand", 29.9))
    assert not supervisor.check(30.0, Observation(BENT, STILL, (), TICK), unmeasured=UnmeasuredForce("hand", 31.0))
    stop = Limit(LimitKind.STOPPED_BY_UNMEASURED_FORCE, ("hand",), value=31.0, bound=30.0)
    assert supervisor.reason == stop
    for _ in range(600):
        pressed = UnmeasuredForce("hand", 1.1 * UNMEASURED_TOUCH)
        assert not supervisor.check(30.0, Observation(STILL, STILL, (), TICK), unmeasured=pressed), "it still presses"
    assert supervisor.posture == pytest.approx(STILL, abs=0.02), "it has given way"
    ticks = 0
    while not supervisor.check(30.0, Observation(BENT, STILL, (), TICK), unmeasured=UnmeasuredForce("hand", 1.0)):
        ticks += 1
    assert ticks * TICK == pytest.approx(QUIET, abs=2 * TICK)


def test_a_reset_lets_go_at_once():
    supervisor = SafetyMonitor(HINGE)
    supervisor.check(30.0, Observation(BENT, STILL, touch(50.0), TICK))
    supervisor.reset()
    assert supervisor.check(30.0, Observation(BENT, STILL, (), TICK))


def test_a_robot_without_joints_is_never_too_fast():
    assert SafetyMonitor(()).check(30.0, Observation(np.zeros(0), np.zeros(0), (), TICK))


ALONG = LimitKind.CONTACT_STICKS
BEYOND = LimitKind.OUT_OF_REACH
DT = 0.005
ERROR = np.array([0.01, 0.0])
ASKED = np.array([0.04, 0.0])
HERE = SurfacePoint(0, 0, (1.0, 0.0, 0.0))
THERE = SurfacePoint(0, 1, (1.0, 0.0, 0.0))


def turned(degrees):
    c = np.cos(np.radians(degrees))
    s = np.sin(np.radians(degrees))
    return np.array([[c, -s], [s, c]])


def watched(share, *, asked=ASKED, tried=1.0, seconds=2.0, jump_at=-1, way=0.0):
    """A contact that moves by a share of what the arm tries, in a direction turned by ``way`` degrees."""
    watch = StallDetector(0.005)
    point = np.zeros(2)
    for tick in range(round(seconds / DT)):
        step = turned(way) @ (share * tried * asked) * DT
        point = point + step + (np.array([-0.3, 0.2]) if tick == jump_at else 0.0)
        watch.look(1, point, ERROR, asked, tried * asked, DT, target=HERE)
    return watch


def look(watch, error=ERROR, *, contact=1, target=HERE):
    return watch.look(contact, np.zeros(2), error, ASKED, ASKED, DT, target=target)


def test_one_that_comes_along_is_stuck_and_one_that_slides_is_not():
    assert watched(0.0).reason == ALONG
    assert watched(-1.0).reason == ALONG
    assert watched(0.5).reason is None
    assert watched(1.0, jump_at=40).reason is None, "over a seam the place jumps"


@pytest.mark.parametrize("way", [30, 60, 75, -90])
def test_one_that_comes_sideways_slides_on_a_map_that_is_wrong(way):
    assert watched(1.0, way=way).reason is None


@pytest.mark.parametrize("share", [0.0, 1.0])
def test_where_the_arm_cannot_even_try_the_target_is_out_of_reach(share):
    assert watched(share, tried=0.0).reason == BEYOND
    assert watched(share, tried=0.3).reason == (None if share else ALONG)


def test_little_is_no_proof():
    assert watched(0.0, seconds=0.2).reason is None
    assert watched(0.0, asked=0.02 * ASKED, seconds=3 * LONGEST).reason is None


def test_it_is_tried_again_when_the_error_changed_or_another_contact_comes():
    watch = watched(0.0)
    assert look(watch) == ALONG
    assert look(watch, ERROR + [0, 1.1 * AGAIN]) is None
    assert look(watched(0.0), contact=2) is None
    watch = watched(0.0)
    watch.reset()
    assert look(watch) is None


def test_what_is_out_of_reach_stays_so_until_the_target_changes_or_is_nearer():
    """A contact that is let go slides away, and comes and goes: that is no reason to try again."""
    watch = watched(0.0, tried=0.0)
    assert look(watch, ERROR + [0.01, 0]) == BEYOND
    assert look(watch, contact=2) == BEYOND
    assert look(watch, ERROR - [1.1 * AGAIN, 0]) is None
    assert look(watched(0.0, tried=0.0), target=THERE) is None


def test_what_is_given_leaves_the_tank_and_what_is_taken_fills_it():
    tank = EnergyTank()
    tank.flow(2.0, 0.0, 0.1)
    assert tank.level == pytest.approx(FULL - 0.2)
    tank.flow(-1.0, 0.0, 0.1)
    assert tank.level == pytest.approx(FULL - 0.1)
    tank.flow(-100.0, 0.0, 1.0)
    assert tank.level == FULL, "it holds no more"
    assert tank.given == pytest.approx(0.1 - 100.0)
    tank.reset()
    assert (tank.level, tank.given) == (FULL, 0.0)


def test_it_gives_nine_tenths_of_a_joule_and_gets_back_half_of_what_is_damped():
    """In numbers of the test's own: a hand is followed with 3 N over 30 cm, and no farther."""
    tank = EnergyTank()
    tank.flow(3.0 * 0.1, 0.0, 2.0)
    assert tank.share == 1
    tank.flow(3.0 * 0.1, 0.0, 1.0)
    assert tank.share == pytest.approx(0, abs=1e-9)
    tank.flow(0.0, 1.0, 0.1)
    assert tank.share == pytest.approx(0.5)


def test_damping_gives_back_a_part():
    tank = EnergyTank()
    tank.flow(5.0, 0.0, 0.1)
    tank.flow(0.0, 1.0, 0.1)
    assert tank.level == pytest.approx(FULL - 0.5 + 0.1 * RECOVERED)


def test_the_share_falls_smoothly_and_never_lets_the_last_go():
    tank = EnergyTank()
    shares = []
    while tank.level > 0:
        tank.flow(1.0, 0.0, 0.01)
        shares.append(tank.share)
    assert shares[0] == 1.0
    assert shares[-1] == 0.0
    assert all(0 <= before - after < 0.16 for before, after in pairwise(shares))
    again = EnergyTank()
    for _ in range(100_000):
        again.flow(10.0 * again.share, 0.0, 0.001)
    assert again.level >= LOW - 1e-2
    assert again.given <= FULL
