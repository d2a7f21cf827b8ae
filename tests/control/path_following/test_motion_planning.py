"""Straight paths and paths around, next to a wall."""

from __future__ import annotations

from collections import Counter
from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from tactile_maps.control.path_following.clearance import Clearance, Obstacle
from tactile_maps.control.path_following.motion_planning import RrtConnect, straight
from tactile_maps.geometry.surface.pose import Pose
from tactile_maps.tactile.mechanics.loads import Box
from tests.support.touch import arm

LEFT, RIGHT = (np.array([turn, 1.2, 0.0, 0.6, 0.0, 0.3, 0.0]) for turn in (-0.9, 0.9))


@cache
def next_to_wall(high: float, *, begins: float = 0.35) -> Clearance:
    """The arm stretched out next to a wall in front of it, from this distance [m] to 0.95 m."""
    middle = (0.95 + begins) / 2
    half = (0.95 - begins) / 2
    wall = Obstacle("wall", Box((half, 0.01, high / 2)), Pose(np.eye(3), np.array([middle, 0.0, high / 2])))
    clearance = Clearance(arm().robot, arm().skin, (wall,))
    clearance.begin(LEFT, (wall,), "hand", np.array([0.0, 0.0, 9.0]), np.array([0.0, 0.0, 1.0]))
    return clearance


def run(steps):
    """The result of a generator of costs, and their sum."""
    cost = 0
    while True:
        try:
            cost += next(steps)
        except StopIteration as end:
            return end.value, cost


def limits():
    robot = arm().robot
    return np.array([joint.lower for joint in robot.joints]), np.array([joint.upper for joint in robot.joints])


def test_straight_path_reports_the_obstacle():
    met = Counter()
    assert not run(straight(next_to_wall(0.6), LEFT, RIGHT, met))[0]
    [(one, other)] = met
    assert other == "wall"
    assert one in {link.name for link in arm().robot.links}
    assert run(straight(next_to_wall(0.6), LEFT, LEFT + 0.05, met))[0]


@pytest.mark.long
def test_path_around_is_clear_and_deterministic():
    clearance, (low, high) = next_to_wall(0.6), limits()
    ways = [run(RrtConnect(clearance, LEFT, [RIGHT], low, high, Counter()).search())[0] for _ in range(2)]
    way = ways[0]
    assert len(way) > 2
    assert np.array_equal(way[0], LEFT)
    assert np.array_equal(way[-1], RIGHT)
    for before, after in pairwise(way):
        shares = np.linspace(0, 1, 60)
        assert min(clearance.at(before + share * (after - before)).room for share in shares) > -0.002
    assert ((np.array(way) >= low) & (np.array(way) <= high)).all()
    assert np.array_equal(np.array(ways[0]), np.array(ways[1]))


def test_reachable_one_of_several_goals_is_reached():
    """The other one is inside the wall."""
    inside = (LEFT + RIGHT) / 2
    assert next_to_wall(0.6).at(inside).room < 0
    way, _ = run(RrtConnect(next_to_wall(0.6), LEFT, [inside, RIGHT], *limits(), Counter()).search())
    assert np.array_equal(way[-1], RIGHT)


@pytest.mark.long
def test_search_ends_if_there_is_no_path():
    """A wall as high as the arm can reach, that leaves no room for it to fold up and turn behind."""
    met = Counter()
    way, cost = run(RrtConnect(next_to_wall(8.0, begins=0.1), LEFT, [RIGHT], *limits(), met).search())
    assert way is None
    assert cost < 60_000
    assert met.total() > 100
