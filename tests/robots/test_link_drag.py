"""A dragged link: it comes where it is expected, keeps the limits, and says which joints hold it back."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.control.motion.joint_impedance import joint_limits
from tactile_maps.core.errors import RobotError
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.robots.library import load_robot
from tactile_maps.robots.link_drag import CLOSE, drag_link

TIP = np.array([0.0, 0.0, 0.05])


@pytest.fixture(scope="module")
def arm():
    return load_robot("arm")


def place(arm, posture):
    configuration = Configuration(arm)
    configuration.update(posture)
    return configuration.pose("hand").points(TIP)


def test_point_reaches_a_target_that_another_posture_reaches(arm):
    limits = joint_limits(arm)
    rng = np.random.default_rng(3)
    for _ in range(5):
        goal = place(arm, np.clip(arm.home + rng.uniform(-0.3, 0.3, len(arm.joints)), *limits))
        result = drag_link(Configuration(arm), "hand", TIP, goal, arm.home, *limits)
        assert result.reached
        assert not result.stuck
        assert np.linalg.norm(place(arm, result.posture) - goal) <= CLOSE


def test_point_gets_close_to_a_target_out_of_reach_and_reports_the_distance(arm):
    limits = joint_limits(arm)
    result = drag_link(Configuration(arm), "hand", TIP, np.array([5.0, 0.0, 1.0]), arm.home, *limits)
    assert not result.reached
    assert result.away == pytest.approx(np.linalg.norm(place(arm, result.posture) - [5.0, 0.0, 1.0]))
    assert result.away < np.linalg.norm(place(arm, arm.home) - [5.0, 0.0, 1.0])


def test_joints_at_their_limits_are_reported_and_no_limit_is_exceeded(arm):
    lower = arm.home - 0.05
    upper = arm.home + 0.05
    result = drag_link(Configuration(arm), "hand", TIP, place(arm, arm.home) + [0.3, 0.0, 0.0], arm.home, lower, upper)
    assert not result.reached
    assert result.stuck
    assert (result.posture >= lower).all()
    assert (result.posture <= upper).all()
    for joint in result.stuck:
        assert result.posture[joint] in (lower[joint], upper[joint])


def test_other_joints_compensate_for_a_joint_at_its_limit(arm):
    lower, upper = joint_limits(arm)
    freely = drag_link(Configuration(arm), "hand", TIP, place(arm, arm.home) + [0.0, 0.1, 0.0], arm.home, lower, upper)
    busiest = int(np.argmax(np.abs(freely.posture - arm.home)))
    lower[busiest] = arm.home[busiest] - 0.01
    upper[busiest] = arm.home[busiest] + 0.01
    goal = place(arm, arm.home) + [0.0, 0.1, 0.0]
    assert drag_link(Configuration(arm), "hand", TIP, goal, arm.home, lower, upper).reached


def test_unknown_link_is_rejected(arm):
    with pytest.raises(RobotError, match="unknown link"):
        drag_link(Configuration(arm), "wing", TIP, TIP, arm.home, *joint_limits(arm))
