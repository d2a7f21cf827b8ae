"""Reach and inertia ratio of robots."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.robots.kinematics import Configuration
from tactile_maps.robots.library import load_robot
from tactile_maps.robots.workspace import inertia_ratio, reach
from tests.support.generated_robots import ROBOTS, load


@pytest.mark.long
@pytest.mark.sampled(2)
@pytest.mark.parametrize(("name", "length"), [("small arm", 0.24), ("arm", 1.2), ("large arm", 4.8), ("leg", 0.9)])
def test_reach_is_the_length_of_a_straight_limb(name, length, tmp_path):
    assert reach(load(ROBOTS[name], tmp_path)) == pytest.approx(length, rel=0.05)


@pytest.mark.long
def test_inertia_ratio_follows_from_the_mass_matrix():
    robot = load_robot("arm")
    inertia = np.diagonal(Configuration(robot).mass_matrix())
    assert inertia_ratio(robot) == pytest.approx(inertia.max() / inertia.min())


def test_robot_without_joints_has_no_reach_and_no_inertia_ratio(tmp_path):
    path = tmp_path / "fixed.xml"
    path.write_text('<mujoco><worldbody><body name="b"><geom size="0.1"/></body></worldbody></mujoco>')
    robot = load_robot(path)
    assert reach(robot) is None
    assert inertia_ratio(robot) is None
