"""Kinematics: poses, Jacobians and inertia of a posture, and errors for invalid postures."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tactile_maps.core.errors import RobotError
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.robots.library import load_robot
from tactile_maps.robots.load import load_robot_file


@pytest.fixture
def configuration(tiny: Path) -> Configuration:
    return Configuration(load_robot_file(tiny))


def test_configuration_starts_at_home_and_returns_on_reset(configuration):
    home = configuration.poses()
    configuration.update(np.array([-0.5]))
    assert not np.allclose(configuration.poses(), home)
    configuration.reset()
    assert np.array_equal(configuration.poses(), home)


def test_poses_agree_with_geometry(configuration):
    configuration.update(np.array([0.3]))
    pose = configuration.pose("rod")
    assert pose.translation == pytest.approx([0, 0, 0.8])
    assert pose.directions(np.array([0, 0, 1.0])) == pytest.approx([np.sin(0.3), 0, np.cos(0.3)])
    assert configuration.poses()[1] == pytest.approx(pose.matrix)


@pytest.mark.parametrize("posture", [[0.0, 0.0], [], [np.nan]])
def test_invalid_posture_is_rejected_without_changes(configuration, posture):
    before = configuration.poses()
    with pytest.raises(RobotError, match="1 finite numbers"):
        configuration.update(np.array(posture))
    assert np.array_equal(configuration.poses(), before)


def test_unknown_link_is_rejected_with_the_valid_ones(configuration):
    with pytest.raises(RobotError, match="base, rod"):
        configuration.pose("tail")
    with pytest.raises(RobotError, match="base, rod"):
        configuration.jacobian("tail", np.zeros(3))


def test_jacobian_follows_from_axes_of_the_joints_before_the_link():
    """A small turn about an axis moves a point as the Jacobian says; joints that do not move a link have none there."""
    robot = load_robot("arm")
    configuration = Configuration(robot)
    point = np.array([0.02, -0.01, 0.05])
    configuration.update(robot.home + 0.2)
    anchors, axes, slides = configuration.joint_axes()
    assert not slides.any()
    for link in ("turret", "forearm", "hand"):
        before = configuration.joints_before(link)
        jacobian = configuration.jacobian(link, point)
        world = configuration.pose(link).points(point)
        assert before.tolist() == list(range(len(before)))
        assert jacobian[:, before] == pytest.approx(np.cross(axes[before], world - anchors[before]).T, abs=1e-12)
        assert not np.delete(jacobian, before, axis=1).any()
    assert configuration.joints_before("base").size == 0
