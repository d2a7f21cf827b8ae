"""Reachability of a point by a place of the skin: never denied where it exists, and disproved where not."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.control.motion.joint_impedance import joint_limits
from tactile_maps.control.path_following.inverse_kinematics import TILT, PointTarget
from tactile_maps.control.path_following.reach import ReachSearch
from tactile_maps.robots.kinematics import Configuration
from tests.control.path_following.test_inverse_kinematics import reached, spot_of
from tests.support.touch import arm

UPPER_ARM = 40
FOREARM = 150
HAND = 280


def searched(taxel, goal, *, whole=False):
    robot = arm().robot
    search = ReachSearch(Configuration(robot), spot_of(taxel), goal, robot.home, *joint_limits(robot))
    for _ in range(3000):
        if search.done or (search.found is not None and not whole):
            return search.found
        search.look()
    raise AssertionError("it never ended")


def postures(count, seed=0):
    return np.random.default_rng(seed).uniform(*joint_limits(arm().robot), (count, len(arm().robot.joints)))


def places_of(taxel, count):
    """(count, 3) where random postures bring it."""
    configuration = Configuration(arm().robot)
    spot = spot_of(taxel)
    places = []
    for posture in postures(count):
        configuration.update(posture)
        places.append(configuration.pose(spot.link).points(spot.point))
    return np.array(places)


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("taxel", [UPPER_ARM, FOREARM, HAND])
def test_reachable_place_is_never_reported_as_unreachable(taxel):
    """Goals are taken from postures, so each can be reached, leaning or not."""
    lot = np.random.default_rng(1)
    for posture in postures(5):
        here = reached(spot_of(taxel), posture)
        lean = here.normal + np.tan(0.9 * TILT * lot.uniform()) * _side(here.normal, lot)
        found = searched(taxel, PointTarget(here.point, lean / np.linalg.norm(lean)), whole=True)
        assert found.possible


def _side(normal, lot):
    side = np.cross(normal, lot.normal(size=3))
    return side / np.linalg.norm(side)


def test_seeds_are_near_solutions():
    for posture in postures(4, seed=4):
        goal = reached(spot_of(UPPER_ARM), posture)
        found = searched(UPPER_ARM, goal)
        nearest = min(np.linalg.norm(reached(spot_of(UPPER_ARM), seed).point - goal.point) for seed in found.seeds)
        assert nearest < 0.05


def test_distance_out_of_reach_is_at_most_that_of_the_nearest_of_many_postures():
    """Points of the upper arm are on a shell about the shoulder: a goal 0.1 m farther out is proved unreachable."""
    places = places_of(UPPER_ARM, 3000)
    middle = (places.max(axis=0) + places.min(axis=0)) / 2
    far = int(np.linalg.norm(places - middle, axis=1).argmax())
    out = (places[far] - middle) / np.linalg.norm(places[far] - middle)
    goal = PointTarget(places[far] + 0.1 * out, out)
    found = searched(UPPER_ARM, goal, whole=True)
    assert not found.possible
    assert 0.0 < found.short_by <= np.linalg.norm(places - goal.point, axis=1).min()


def test_place_that_never_faces_the_target_is_distinguished():
    here = reached(spot_of(UPPER_ARM), arm().robot.home)
    found = searched(UPPER_ARM, PointTarget(here.point, -here.normal), whole=True)
    assert not found.possible
    assert found.short_by == 0.0
