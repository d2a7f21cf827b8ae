"""Postures in which a place of the skin reaches a point in the world."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.control.motion.joint_impedance import joint_limits
from tactile_maps.control.path_following.inverse_kinematics import (
    CLOSE,
    ROUNDS,
    TILT,
    LinkPoint,
    PointTarget,
    solve_inverse_kinematics,
)
from tactile_maps.robots.kinematics import Configuration
from tests.support.touch import arm


def spot_of(taxel) -> LinkPoint:
    skin = arm().skin
    at = skin.taxel_point(taxel)
    return LinkPoint(skin.link(at), skin.position(at), skin.normal(at))


def solution(goal, spot, start=None):
    robot = arm().robot
    tried = list(
        solve_inverse_kinematics(
            Configuration(robot), spot, goal, robot.home if start is None else start, *joint_limits(robot)
        )
    )
    return tried[-1], len(tried)


def reached(spot, posture) -> PointTarget:
    configuration = Configuration(arm().robot)
    configuration.update(posture)
    pose = configuration.pose(spot.link)
    return PointTarget(pose.points(spot.point), pose.rotation @ spot.normal)


@pytest.mark.parametrize("taxel", [5, 120, 160, 230, 290])
def test_target_of_a_near_posture_is_reached(taxel):
    robot = arm().robot
    spot = spot_of(taxel)
    lower, upper = joint_limits(robot)
    rng = np.random.default_rng(taxel)
    goal = reached(spot, np.clip(robot.home + rng.uniform(-0.3, 0.3, len(robot.home)), lower, upper))
    posture, rounds = solution(goal, spot)
    assert rounds < ROUNDS
    assert ((posture >= lower) & (posture <= upper)).all()
    got = reached(spot, posture)
    assert np.linalg.norm(got.point - goal.point) < CLOSE
    assert np.arccos(got.normal @ goal.normal) < TILT


def test_position_has_precedence_over_the_normal():
    """The shoulder cannot turn a point of the upper arm about: the place is reached, the normal as nearly as can be."""
    spot = spot_of(40)
    here = reached(spot, arm().robot.home)
    turned = PointTarget(here.point, np.cross(here.normal, [0.0, 0.0, 1.0]) * 0.5 + here.normal * 0.8)
    turned = PointTarget(turned.point, turned.normal / np.linalg.norm(turned.normal))
    posture, _ = solution(turned, spot)
    if posture is not None:
        assert np.linalg.norm(reached(spot, posture).point - here.point) < 2 * CLOSE


def test_target_out_of_reach_has_no_solution():
    spot = spot_of(290)
    here = reached(spot, arm().robot.home)
    assert solution(PointTarget(here.point + [3.0, 0.0, 0.0], here.normal), spot) == (None, ROUNDS + 1)


def test_target_is_raised_along_its_normal():
    raised = PointTarget(np.zeros(3), np.array([0.0, 0.0, 1.0])).raised(-0.06)
    assert raised.point == pytest.approx([0, 0, -0.06])
