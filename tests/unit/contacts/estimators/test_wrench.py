"""Force and torque on a link, and what joint torques tell of them."""

from __future__ import annotations

import numpy as np
import pytest

from app.contacts.estimators.wrench import Wrench, wrench_of_torques
from app.errors import MapError, RobotError
from app.robots.configuration import Configuration
from app.robots.library import find_robot
from tests.touch import bar


@pytest.mark.parametrize("value", [[1.0, 2.0], [1.0, 2.0, float("nan")]])
def test_a_wrench_is_six_finite_numbers(value):
    with pytest.raises(MapError, match="three finite numbers"):
        Wrench(np.array(value), np.zeros(3))


def test_the_torques_of_an_arm_tell_the_force_at_its_hand():
    """Seven joints tell all six numbers: a push at a known point comes back, with its moment."""
    robot = find_robot("arm")
    configuration = Configuration(robot)
    random = np.random.default_rng(0)
    for link in ("hand",):
        for _ in range(5):
            configuration.update(robot.home + random.normal(0, 0.3, len(robot.joints)))
            point, push = random.normal(0, 0.05, 3), random.normal(0, 5, 3)
            world = configuration.pose(link).rotation @ push
            found = wrench_of_torques(configuration, link, configuration.jacobian(link, point).T @ world)
            assert found.rank == 6
            assert found.force == pytest.approx(push, abs=1e-6)
            assert found.torque == pytest.approx(np.cross(point, push), abs=1e-6)
            assert 1 < found.condition < 1e4


def test_one_hinge_tells_one_number():
    robot = bar()
    found = wrench_of_torques(Configuration(robot), "bar", np.array([2.0]))
    assert found.rank == 1
    assert found.torque[1] == pytest.approx(2.0, rel=1e-6), "about its axis, y"


def test_the_base_tells_nothing():
    robot = bar(hinged=False)
    found = wrench_of_torques(Configuration(robot), "bar", np.zeros(0))
    assert (found.rank, found.condition) == (0, float("inf"))
    assert not found.force.any()


@pytest.mark.parametrize("torques", [[1.0, 2.0], [float("nan")]])
def test_torques_that_are_none_are_refused(torques):
    with pytest.raises(MapError, match="torques"):
        wrench_of_torques(Configuration(bar()), "bar", np.array(torques))


def test_a_link_that_is_none_is_refused():
    with pytest.raises(RobotError):
        wrench_of_torques(Configuration(bar()), "tail", np.zeros(1))
