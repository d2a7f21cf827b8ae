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


def test_a_point_comes_to_where_another_posture_has_it(arm):
    limits = joint_limits(arm)
    rng = np.random.default_rng(3)
    for _ in range(5):
        goal = place(arm, np.clip(arm.home + rng.uniform(-0.3, 0.3, len(arm.joints)), *limits))
        answer = drag_link(Configuration(arm), "hand", TIP, goal, arm.home, *limits)
        assert answer.reached
        assert not answer.stuck
        assert np.linalg.norm(place(arm, answer.posture) - goal) <= CLOSE


def test_out_of_reach_it_comes_as_near_as_it_goes_and_says_how_far_that_is(arm):
    limits = joint_limits(arm)
    answer = drag_link(Configuration(arm), "hand", TIP, np.array([5.0, 0.0, 1.0]), arm.home, *limits)
    assert not answer.reached
    assert answer.away == pytest.approx(np.linalg.norm(place(arm, answer.posture) - [5.0, 0.0, 1.0]))
    assert answer.away < np.linalg.norm(place(arm, arm.home) - [5.0, 0.0, 1.0])


def test_a_joint_at_its_limit_is_named_and_no_limit_is_passed(arm):
    lower = arm.home - 0.05
    upper = arm.home + 0.05
    answer = drag_link(Configuration(arm), "hand", TIP, place(arm, arm.home) + [0.3, 0.0, 0.0], arm.home, lower, upper)
    assert not answer.reached
    assert answer.stuck
    assert (answer.posture >= lower).all()
    assert (answer.posture <= upper).all()
    for joint in answer.stuck:
        assert answer.posture[joint] in (lower[joint], upper[joint])


def test_where_a_joint_is_at_its_limit_the_others_do_its_part(arm):
    lower, upper = joint_limits(arm)
    freely = drag_link(Configuration(arm), "hand", TIP, place(arm, arm.home) + [0.0, 0.1, 0.0], arm.home, lower, upper)
    busiest = int(np.argmax(np.abs(freely.posture - arm.home)))
    lower[busiest] = arm.home[busiest] - 0.01
    upper[busiest] = arm.home[busiest] + 0.01
    goal = place(arm, arm.home) + [0.0, 0.1, 0.0]
    assert drag_link(Configuration(arm), "hand", TIP, goal, arm.home, lower, upper).reached


def test_a_link_that_is_not_there_is_named(arm):
    with pytest.raises(RobotError, match="unknown link"):
        drag_link(Configuration(arm), "wing", TIP, TIP, arm.home, *joint_limits(arm))
