"""Contacts as rows of Jacobians, solved level by level within limits."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.joint_impedance import MAX_JOINT_SPEED, MAX_POINT_SPEED, PostureReference
from tactile_maps.control.motion.limits import ActiveLimits, Limit, LimitKind
from tactile_maps.control.motion.task_priority import (
    PriorityLevel,
    point_rows,
    single_level,
    singular_directions,
    solve_hierarchy,
    solve_within_limits,
)
from tactile_maps.robots.kinematics import Configuration
from tests.control.contacts import TO_MAP, contact
from tests.support.touch import arm

FAST = np.full(7, MAX_JOINT_SPEED)
REST = np.zeros(7)


SETTINGS = ControlSettings(position_gain=5.0)


def test_singular_directions_reject_nan_and_accept_no_joints():
    with pytest.raises(np.linalg.LinAlgError):
        singular_directions(np.full((3, 7), np.nan))
    left, gains, right = singular_directions(np.zeros((3, 0)))
    assert (left.shape, gains.shape, right.shape) == ((3, 0), (0,), (0, 0))


def test_map_axes_are_orthonormal_along_the_skin_and_not_rotated_against_the_map():
    assert contact().outward == pytest.approx([8, 9, 10, 11])
    axes = contact().map_axes
    assert axes @ axes.T == pytest.approx(np.eye(2))
    assert axes @ contact().normal == pytest.approx([0, 0])
    stretch = TO_MAP @ axes.T
    assert stretch == pytest.approx(stretch.T), "the rest of the map is stretch without rotation"


def test_skin_moves_in_the_opposite_direction_of_the_contact():
    one = contact(np.array([0.01, -0.02]), (0.003, 0.004))
    skin = one.along(SETTINGS, 1.0)
    assert -TO_MAP @ skin == pytest.approx(5.0 * one.error + one.velocity)
    assert skin @ one.normal == pytest.approx(0)
    slow = one.along(SETTINGS, 0.01)
    assert np.linalg.norm(slow) == pytest.approx(0.01)
    assert np.cross(slow, skin) == pytest.approx(np.zeros(3), abs=1e-12)
    assert not contact().along(SETTINGS, 1.0).any(), "a contact that may slide is not moved along"


def random_rows(seed, m, n=7):
    return np.random.default_rng(seed).normal(size=(m, n))


@pytest.mark.parametrize("size", [0.01, 1.0, 100.0])
@pytest.mark.parametrize("seed", range(5))
def test_compatible_levels_are_met_by_the_least_motion_at_any_size_of_the_robot(seed, size):
    """Short levers are not singular: only a speed beyond that of the joints is damped."""
    rows = size * random_rows(seed, 3)
    requested = size * np.array([0.1, -0.2, 0.05])
    levels = [PriorityLevel(rows[:1], requested[:1]), PriorityLevel(rows[1:], requested[1:])]
    speed, weak = solve_hierarchy(levels, REST, FAST)
    assert rows @ speed == pytest.approx(requested, rel=1e-8)
    assert speed == pytest.approx(np.linalg.pinv(rows) @ requested, abs=1e-9)
    assert weak is None


def test_fast_joints_do_most_of_the_motion():
    rows = np.ones((1, 2))
    speed, _ = solve_hierarchy([PriorityLevel(rows, np.array([0.1]))], np.zeros(2), np.array([1.0, 0.1]))
    assert speed[0] == pytest.approx(100 * speed[1])
    assert speed.sum() == pytest.approx(0.1)


def test_higher_priority_is_exact_in_a_conflict():
    row = random_rows(0, 1)
    both = np.concatenate([row, random_rows(1, 1)])
    levels = [PriorityLevel(row, np.array([0.1])), PriorityLevel(both, np.array([-0.3, 0.2]))]
    speed, _ = solve_hierarchy(levels, REST, FAST)
    assert row @ speed == pytest.approx([0.1], abs=1e-9)
    assert both[1] @ speed == pytest.approx(0.2, abs=1e-6)


def test_return_to_rest_uses_only_the_remaining_freedom():
    rows = random_rows(3, 3)
    rest = np.full(7, 0.3)
    speed, _ = solve_hierarchy([PriorityLevel(rows, np.zeros(3))], rest, FAST)
    assert rows @ speed == pytest.approx(np.zeros(3), abs=1e-12)
    assert np.linalg.norm(speed) > 0.1
    assert solve_hierarchy([], rest, FAST)[0] == pytest.approx(rest)
    no_joints, _ = solve_hierarchy([PriorityLevel(np.zeros((2, 0)), np.ones(2))], np.zeros(0), np.zeros(0))
    assert no_joints.shape == (0,)


@pytest.mark.parametrize("gain", np.geomspace(1e-9, 1.0, 12))
def test_largest_point_speed_near_a_singularity_requests_at_most_the_largest_joint_speed(gain):
    rows = np.diag([0.5, gain]) @ np.linalg.qr(random_rows(4, 2, 7).T)[0].T
    speed, weak = solve_hierarchy([PriorityLevel(rows, np.array([0.0, MAX_POINT_SPEED]))], REST, FAST)
    assert np.linalg.norm(speed) <= MAX_JOINT_SPEED * (1 + 1e-6)
    most = gain * MAX_JOINT_SPEED
    if most >= MAX_POINT_SPEED:
        assert weak is None
        assert np.linalg.norm(speed) == pytest.approx(MAX_POINT_SPEED / gain, rel=1e-6)
    else:
        damped = 2 * most * MAX_POINT_SPEED / (most**2 + MAX_POINT_SPEED**2)
        assert np.linalg.norm(speed) == pytest.approx(MAX_JOINT_SPEED * damped, rel=1e-6)
        assert weak.value == pytest.approx(MAX_POINT_SPEED - most * damped), "lost speed"
        assert weak.bound == pytest.approx(most, rel=1e-6), "singular value"
    strong, _ = solve_hierarchy([PriorityLevel(rows, np.array([0.1, MAX_POINT_SPEED]))], REST, FAST)
    assert rows[0] @ strong == pytest.approx(0.1, abs=1e-9), "the strong direction is not damped"


def test_contact_that_may_slide_has_one_row():
    one, three = (point_rows(contact(error), np.array([1.0, 2.0, 3.0])) for error in (None, np.zeros(2)))
    assert (one.rows.shape, one.speed) == ((1, 4), [3.0])
    assert one.axes == pytest.approx(contact().normal[None])
    assert three.rows.shape == (3, 4)
    assert three.speed == pytest.approx([1, 2, 3])
    assert three.axes == pytest.approx(np.eye(3))
    assert single_level([three]) == [three]
    [level] = single_level([one, three])
    assert level.rows.shape == (4, 4)
    assert level.axes is None


def solved(level, start=None):
    """The joint velocity of the arm, by default at home, and its limits."""
    robot = arm().robot
    limits = ActiveLimits()
    reference = PostureReference(robot, Configuration(robot))
    start = robot.home if start is None else start
    return solve_within_limits([level], reference, start, limits), limits.found


def test_other_joints_do_the_work_of_a_joint_at_its_limit():
    joints = arm().robot.joints
    joint = next(k for k, j in enumerate(joints) if np.isfinite(j.upper))
    start = arm().robot.home.copy()
    start[joint] = joints[joint].upper
    level = PriorityLevel(np.full((1, 7), 0.5), np.array([0.2]))
    speed, limits = solved(level, start)
    assert speed[joint] == 0
    assert level.rows @ speed == pytest.approx([0.2])
    assert limits == (Limit(LimitKind.JOINT_LIMIT, (joints[joint].name,)),)
    speed, limits = solved(PriorityLevel(np.ones((1, 7)), np.array([0.2])), np.array([j.upper for j in joints]))
    assert not speed.any(), "no joint is left"
    assert limits[0].kind is LimitKind.JOINT_LIMIT


def test_lost_speed_is_reported_with_its_direction_and_singular_value():
    rows = np.zeros((3, 7))
    np.fill_diagonal(rows, [0.5, 0.02, 0.5])
    _, [limit] = solved(PriorityLevel(rows, np.array([0.1, -0.1, 0.1]), np.eye(3)))
    assert limit.kind is LimitKind.WEAK_DIRECTION
    assert limit.direction == pytest.approx((0.0, -1.0, 0.0))
    assert limit.bound == pytest.approx(0.02 * MAX_JOINT_SPEED)
    lever_change = np.linalg.norm(rows) * MAX_JOINT_SPEED**2
    assert limit.value == pytest.approx(0.1 * (1 - 2 * 0.03**2 / (0.03**2 + 0.1 * lever_change / 2.0)))
    level = PriorityLevel(np.full((1, 7), 0.01), np.array([0.01]))
    speed, limits = solved(level)
    assert level.rows @ speed == pytest.approx(level.speed), "a short lever that is fast enough"
    assert limits == ()


def test_joint_speeds_change_slowly_with_posture_near_a_stretched_posture():
    """A planar arm of two 0.3 m links: beyond four per second it would pass back and forth through that posture."""
    elbows = np.linspace(-0.3, 0.3, 2001)
    speeds = []
    for elbow in elbows:
        motion = 0.3j * np.array([1 + np.exp(1j * elbow), np.exp(1j * elbow)])
        level = PriorityLevel(np.array([motion.real, motion.imag]), np.array([-0.04, 0.0]), np.eye(2, 3))
        speeds.append(solve_hierarchy([level], np.zeros(2), np.full(2, 3.0))[0])
    slopes = np.abs(np.diff(speeds, axis=0)).max(axis=1) / np.diff(elbows)
    assert slopes.max() < 4.0
    assert np.abs(speeds).max() > 0.05, "it moves on either side"
