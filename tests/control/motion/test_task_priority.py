"""Contacts as rows, solved level by level within limits."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.control.limit_texts import limit_text
from tactile_maps.control.motion.joint_impedance import MAX_JOINT_SPEED, MAX_POINT_SPEED, PostureReference
from tactile_maps.control.motion.limits import ActiveLimits, LimitKind
from tactile_maps.control.motion.task_priority import (
    ContactGoal,
    PriorityLevel,
    point_rows,
    single_level,
    singular_directions,
    solve_hierarchy,
    solve_within_limits,
)
from tactile_maps.robots.kinematics import Configuration
from tests.control.contacts import TO_MAP, contact, touch
from tests.support.limits import kinds
from tests.support.touch import arm


def test_rows_that_are_no_numbers_are_refused_and_none_at_all_have_no_directions():
    with pytest.raises(np.linalg.LinAlgError):
        singular_directions(np.full((3, 7), np.nan))
    left, gains, right = singular_directions(np.zeros((3, 0)))
    assert (left.shape, gains.shape, right.shape) == ((3, 0), (0,), (0, 0))


def test_outward_is_the_normal_s_share_of_motion():
    assert contact().outward == pytest.approx([8, 9, 10, 11])


def test_map_axes_lie_along_the_skin_as_the_map_s_do_and_are_square_to_each_other():
    axes = contact().map_axes
    assert axes @ axes.T == pytest.approx(np.eye(2))
    assert axes @ contact().normal == pytest.approx([0, 0])
    stretch = TO_MAP @ axes.T
    assert stretch == pytest.approx(stretch.T), "what is left of the map is stretch without a turn"


def test_the_skin_goes_the_other_way_so_that_the_contact_comes_where_it_should():
    mine = contact(np.array([0.01, -0.02]), (0.003, 0.004))
    skin = mine.along(5.0, 1.0)
    assert -TO_MAP @ skin == pytest.approx(5.0 * mine.error + mine.velocity)
    assert skin @ mine.normal == pytest.approx(0)
    slow = mine.along(5.0, 0.01)
    assert np.linalg.norm(slow) == pytest.approx(0.01)
    assert np.cross(slow, skin) == pytest.approx(np.zeros(3), abs=1e-12)
    assert not contact().along(5.0, 1.0).any(), "one that may slide is not moved along"


def test_a_want_leaves_place_open_unless_it_says():
    want = ContactGoal(touch(1.0)[0], 3.0)
    assert want.error is None
    assert want.velocity is None


FAST = np.full(7, MAX_JOINT_SPEED)


def random_rows(seed, m, n=7):
    return np.random.default_rng(seed).normal(size=(m, n))


@pytest.mark.parametrize("seed", range(10))
def test_levels_that_do_not_conflict_are_all_met_by_the_least_motion(seed):
    rows = random_rows(seed, 3)
    wanted = np.array([0.1, -0.2, 0.05])
    levels = [PriorityLevel(rows[:1], wanted[:1]), PriorityLevel(rows[1:], wanted[1:])]
    speed, weak = solve_hierarchy(levels, np.zeros(7), FAST)
    assert rows @ speed == pytest.approx(wanted, abs=1e-9)
    assert speed == pytest.approx(np.linalg.pinv(rows) @ wanted, abs=1e-9)
    assert weak is None


@pytest.mark.parametrize("size", [0.01, 1.0, 100.0])
def test_the_size_of_the_robot_does_not_matter(size):
    """Short levers are not singular: only a speed beyond that of the joints is damped."""
    rows = size * random_rows(0, 3)
    wanted = size * np.array([0.1, -0.2, 0.05])
    speed, weak = solve_hierarchy([PriorityLevel(rows, wanted)], np.zeros(7), FAST)
    assert rows @ speed == pytest.approx(wanted, rel=1e-9)
    assert weak is None


def test_slow_joints_leave_the_motion_to_fast_ones():
    rows = np.ones((1, 2))
    speed, _ = solve_hierarchy([PriorityLevel(rows, np.array([0.1]))], np.zeros(2), np.array([1.0, 0.1]))
    assert speed[0] == pytest.approx(100 * speed[1])
    assert speed.sum() == pytest.approx(0.1)


def test_what_is_more_wanted_is_exact_in_a_conflict():
    row = random_rows(0, 1)
    both = np.concatenate([row, random_rows(1, 1)])
    levels = [PriorityLevel(row, np.array([0.1])), PriorityLevel(both, np.array([-0.3, 0.2]))]
    speed, _ = solve_hierarchy(levels, np.zeros(7), FAST)
    assert (row @ speed)[0] == pytest.approx(0.1, abs=1e-9)
    assert levels[1].rows[1] @ speed == pytest.approx(0.2, abs=1e-6)


def test_rest_moves_only_what_is_free():
    rows = random_rows(3, 3)
    rest = np.full(7, 0.3)
    speed, _ = solve_hierarchy([PriorityLevel(rows, np.zeros(3))], rest, FAST)
    assert rows @ speed == pytest.approx(np.zeros(3), abs=1e-12)
    assert np.linalg.norm(speed) > 0.1
    assert solve_hierarchy([], rest, FAST)[0] == pytest.approx(rest)


@pytest.mark.parametrize("gain", np.geomspace(1e-9, 1.0, 30))
def test_near_a_singularity_the_greatest_point_speed_asks_for_no_more_than_the_greatest_joint_speed(gain):
    rows = np.diag([0.5, gain]) @ np.linalg.qr(random_rows(4, 2, 7).T)[0].T
    level = PriorityLevel(rows, np.array([0.0, MAX_POINT_SPEED]))
    speed, weak = solve_hierarchy([level], np.zeros(7), FAST)
    assert np.linalg.norm(speed) <= MAX_JOINT_SPEED * (1 + 1e-6)
    most = gain * MAX_JOINT_SPEED
    if most >= MAX_POINT_SPEED:
        assert weak is None
        assert np.linalg.norm(speed) == pytest.approx(MAX_POINT_SPEED / gain, rel=1e-6)
    else:
        damped = 2 * most * MAX_POINT_SPEED / (most**2 + MAX_POINT_SPEED**2)
        assert np.linalg.norm(speed) == pytest.approx(MAX_JOINT_SPEED * damped, rel=1e-6)
        assert weak is not None
        assert weak.value == pytest.approx(MAX_POINT_SPEED - most * damped), "lost speed"
        assert weak.bound == pytest.approx(most, rel=1e-6), "singular value"
    strong, _ = solve_hierarchy([PriorityLevel(rows, np.array([0.1, MAX_POINT_SPEED]))], np.zeros(7), FAST)
    assert rows[0] @ strong == pytest.approx(0.1, abs=1e-9), "the strong direction is not damped"


def test_nothing_wanted_of_no_joints():
    speed, _ = solve_hierarchy([PriorityLevel(np.zeros((2, 0)), np.ones(2))], np.zeros(0), np.zeros(0))
    assert speed.shape == (0,)


def limits_of_joints() -> PostureReference:
    return PostureReference(arm().robot, Configuration(arm().robot))


def test_a_contact_that_may_slide_has_one_row():
    one = point_rows(contact(), np.array([1.0, 2.0, 3.0]))
    assert (one.rows.shape, one.speed) == ((1, 4), [3.0])
    assert one.axes == pytest.approx(contact().normal[None])
    three = point_rows(contact(np.zeros(2)), np.array([1.0, 2.0, 3.0]))
    assert three.rows.shape == (3, 4)
    assert three.speed == pytest.approx([1, 2, 3])
    assert three.axes == pytest.approx(np.eye(3))
    assert single_level([three]) == [three]
    [level] = single_level([point_rows(contact(), np.ones(3)), point_rows(contact(np.zeros(2)), np.ones(3))])
    assert level.rows.shape == (4, 4)
    assert level.axes is None


def test_a_joint_at_its_limit_leaves_the_work_to_the_others():
    robot = arm().robot
    joint = next(k for k, j in enumerate(robot.joints) if np.isfinite(j.upper))
    start = robot.home.copy()
    limits = ActiveLimits()
    start[joint] = robot.joints[joint].upper
    level = PriorityLevel(np.full((1, 7), 0.5), np.array([0.2]))
    speed = solve_within_limits([level], limits_of_joints(), start, limits)
    assert speed[joint] == 0
    assert level.rows @ speed == pytest.approx([0.2])
    assert kinds(limits) == [LimitKind.JOINT_LIMIT]
    assert limits.found[0].names == (robot.joints[joint].name,)


def test_when_no_joint_is_left_nothing_moves():
    robot = arm().robot
    limits = ActiveLimits()
    start = np.array([j.upper for j in robot.joints])
    assert np.isfinite(start).all()
    assert not solve_within_limits(
        [PriorityLevel(np.ones((1, 7)), np.array([0.2]))], limits_of_joints(), start, limits
    ).any()
    assert LimitKind.JOINT_LIMIT in limits


def test_lost_speed_is_reported_with_its_direction_and_singular_value():
    limits = ActiveLimits()
    rows = np.zeros((3, 7))
    rows[0, 0] = 0.5
    rows[1, 1] = 0.02
    rows[2, 2] = 0.5
    level = PriorityLevel(rows, np.array([0.1, -0.1, 0.1]), np.eye(3))
    solve_within_limits([level], limits_of_joints(), arm().robot.home, limits)
    assert kinds(limits) == [LimitKind.WEAK_DIRECTION]
    [limit] = limits.found
    assert limit.direction == pytest.approx((0.0, -1.0, 0.0))
    assert limit.bound == pytest.approx(0.02 * MAX_JOINT_SPEED)
    lever_change = np.linalg.norm(rows) * MAX_JOINT_SPEED**2
    assert limit.value == pytest.approx(0.1 * (1 - 2 * 0.03**2 / (0.03**2 + 0.1 * lever_change / 2.0)))
    text = "singular configuration: little motion along the contact: 98\u202fmm/s lost along (0, -1, 0)"
    assert limit_text(limit) == text + ", at most 30\u202fmm/s there"


def test_near_a_stretched_posture_joint_speeds_change_slowly_with_posture():
    """A planar arm of two 0.3 m links: beyond four per second it would pass back and forth through that posture."""
    elbows = np.linspace(-0.3, 0.3, 2001)
    one = 0.3 * np.exp(0.0j * elbows)
    two = 0.3 * np.exp(1j * elbows)
    speeds = []
    for upper, lower in zip(one, two, strict=True):
        motion = 1j * np.array([upper + lower, lower])
        level = PriorityLevel(np.array([motion.real, motion.imag]), np.array([-0.04, 0.0]), np.eye(2, 3))
        speeds.append(solve_hierarchy([level], np.zeros(2), np.full(2, 3.0))[0])
    slopes = np.abs(np.diff(speeds, axis=0)).max(axis=1) / np.diff(elbows)
    assert slopes.max() < 4.0
    assert np.abs(speeds).max() > 0.05, "it moves on either side"


def test_a_short_lever_that_is_fast_enough_is_not_reported():
    limits = ActiveLimits()
    level = PriorityLevel(np.full((1, 7), 0.01), np.array([0.01]))
    assert level.rows @ solve_within_limits([level], limits_of_joints(), arm().robot.home, limits) == (
        pytest.approx(level.speed)
    )
    assert limits.found == ()
