"""Room between the robot's shapes, and between them and obstacles."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from tactile_maps.control.path_following.clearance import (
    CLOSE_MARGIN,
    FAR,
    MARGIN,
    SLACK,
    TOUCHED,
    Clearance,
    Obstacle,
)
from tactile_maps.geometry.surface.pose import Pose
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.skin.link_hulls import overlapping_hulls
from tactile_maps.tactile.mechanics.loads import Box, Cylinder, Plane, Sphere
from tests.support.hollows import BOWL_DEPTH, bowl_and_ball, hollow
from tests.support.touch import arm, pair

EYE = np.eye(3)
UP = np.array([0.0, 0.0, 1.0])


def at(name, shape, *place) -> Obstacle:
    return Obstacle(name, shape, Pose(EYE, np.array(place)))


def blocks(*obstacles, top=5.0) -> Clearance:
    """Two blocks of 0.1 m, 30 mm apart, of which the left one slides along x; touched far away, or on its top."""
    robot, skin = pair()
    clearance = Clearance(robot, skin, obstacles)
    clearance.begin(np.zeros(1), obstacles, "left", np.array([-0.065, 0.0, top]), UP)
    return clearance


@cache
def of_arm() -> Clearance:
    box = at("box", Box((0.1, 0.3, 0.2)), 0.45, 0.2, 0.2)
    clearance = Clearance(arm().robot, arm().skin, (box,))
    clearance.begin(np.zeros(7), (box,), "hand", np.array([0.0, 0.0, 5.0]), UP)
    return clearance


@pytest.mark.sampled(3)
@pytest.mark.parametrize("moved", [0.0, 0.01, 0.029, 0.035])
def test_room_is_the_distance_minus_the_margin(moved):
    gap = blocks().at(np.array([moved]))
    assert gap.room == pytest.approx(0.03 - moved - MARGIN, abs=1e-6)
    assert set(gap.between) == {"left", "right"}


@pytest.mark.sampled(3)
@pytest.mark.parametrize(
    ("shape", "place", "room"),
    [
        (Sphere(0.02), (-0.2, 0.0, 0.0), 0.065),
        (Box((0.02, 0.03, 0.03)), (-0.2, 0.0, 0.0), 0.065),
        (Cylinder(0.02, 0.05), (-0.2, 0.0, 0.0), 0.065),
        (Plane(), (0.0, 0.0, -0.06), 0.01),
    ],
)
def test_distance_of_obstacles_of_every_shape(shape, place, room):
    clearance = blocks(at("post", shape, *place))
    gap = clearance.at(np.array([-0.01 if room > 0.05 else 0.0]))
    expected = room - 0.01 if room > 0.05 else room
    if expected < 0.03 + 0.01:  # else the other block is nearer
        assert gap.between == ("left", "post")
        assert gap.room == pytest.approx(expected - MARGIN, abs=1e-6)
    else:
        assert set(gap.between) == {"left", "right"}


def test_shapes_close_at_the_start_may_stay_as_close():
    robot, skin = pair()
    clearance = Clearance(robot, skin)
    clearance.begin(np.array([0.027]), (), "left", np.array([0.0, 0.0, 5.0]), UP)
    assert clearance.at(np.array([0.027])).room == pytest.approx(SLACK, abs=1e-6)
    assert clearance.at(np.array([0.0285])).room < 0


def test_touched_object_is_found_and_only_its_link_may_be_near():
    ball = at("ball", Sphere(0.03), -0.065, 0.0, 0.079)
    other = at("other", Sphere(0.03), -0.2, 0.0, 0.0)
    clearance = blocks(other, ball, top=0.05)
    assert clearance.touched == "ball"
    assert clearance.at(np.zeros(1)).between == ("left", "ball")
    assert clearance.at(np.zeros(1)).room < 0
    clearance.meeting("left")
    assert clearance.at(np.zeros(1)).room > 0
    clearance.meeting("right")
    assert clearance.at(np.zeros(1)).room < 0
    clearance.meeting(None)
    assert clearance.at(np.zeros(1)).room < 0, "it has to be left"


def test_link_that_is_lifted_off_presses_no_deeper():
    robot, skin = pair()
    ball = at("ball", Sphere(0.03), -0.145, 0.0, 0.0)
    clearance = Clearance(robot, skin, (ball,))
    clearance.begin(np.zeros(1), (ball,), "left", np.array([-0.115, 0.0, 0.0]), np.array([-1.0, 0.0, 0.0]))
    clearance.meeting("left", leaves=True)
    assert clearance.at(np.array([0.0])).room > 0
    assert clearance.at(np.array([0.005])).room > 0
    assert clearance.at(np.array([-0.002])).room < 0
    clearance.meeting("left")
    assert clearance.at(np.array([-0.002])).room > 0


def test_space_is_reserved_for_an_unknown_touched_object():
    clearance = blocks(top=0.05)
    assert clearance.touched == TOUCHED
    assert clearance.at(np.zeros(1)).between == ("left", TOUCHED)
    clearance.meeting("left")
    assert set(clearance.at(np.zeros(1)).between) == {"left", "right"}


def test_place_in_a_hollow_is_touched_on_the_hull():
    clearance = blocks()
    inside = clearance.on_hull("left", np.array([0.0, 0.01, 0.02]), UP)
    assert inside == pytest.approx([0.0, 0.01, 0.05], abs=1e-6)
    outside = np.array([0.0, 0.01, 0.052])
    assert clearance.on_hull("left", outside, UP) == pytest.approx(outside)


def test_place_in_a_bowl_is_touched_on_the_skin():
    """The link collides in pieces, not as its hull."""
    robot, skin = hollow("bowl")
    clearance = Clearance(robot, skin)
    bottom = np.array([0.0, 0.0, -BOWL_DEPTH])
    assert clearance.on_hull("block", bottom, UP) == pytest.approx(bottom)


BALL_RADIUS = 0.02
PIECES_ERROR = 6e-4
"""Error of the pieces of the bowl, and of the mesh of the ball [m]."""


def in_bowl(height: float) -> Clearance:
    """A ball at this height above the rim of a bowl, and its hull in that of the bowl; touched far away."""
    robot, skin = bowl_and_ball(height)
    assert frozenset(("block", "ball")) in overlapping_hulls(robot, skin)[1]
    clearance = Clearance(robot, skin)
    clearance.begin(np.zeros(1), (), "block", np.array([0.0, 0.0, 5.0]), UP)
    return clearance


@pytest.mark.parametrize(
    ("height", "required"), [(0.015, MARGIN), (0.005, CLOSE_MARGIN)], ids=["far apart at home", "close at home"]
)
def test_links_whose_hulls_overlap_at_home_are_checked_by_their_pieces(height, required):
    clearance = in_bowl(height)
    apart = height + BOWL_DEPTH - BALL_RADIUS
    assert clearance.at(np.zeros(1)).room > 0
    for near in (0.5 * required, -0.003):
        gap = clearance.at(np.array([near - apart]))
        assert set(gap.between) == {"block", "ball"}
        assert gap.room == pytest.approx(near - required, abs=PIECES_ERROR)


def test_links_whose_pieces_touch_at_home_are_not_checked():
    robot, skin = bowl_and_ball(-0.004)
    post = at("post", Sphere(0.02), 0.2, 0.0, 0.0)
    clearance = Clearance(robot, skin, (post,))
    clearance.begin(np.zeros(1), (post,), "block", np.array([0.0, 0.0, 5.0]), UP)
    assert clearance.at(np.array([-0.03])).room > 0


def test_clearance_is_kept_between_two_checked_postures():
    """Checked at many points of the same line, also where one motion begins at the end of another."""
    clearance = of_arm()
    lot = np.random.default_rng(2)
    met = 0
    looks = 0
    dense = 0
    for _ in range(12):
        start, end = lot.uniform(-1.0, 1.0, (2, 7)) + [0.0, 0.5, 0.0, 1.0, 0.0, 0.0, 0.0]
        gaps = list(clearance.along(start, end))
        looks += len(gaps)
        rooms = [clearance.at(start + share * (end - start)).room for share in np.linspace(0, 1, 80)]
        dense += len(rooms)
        if gaps[-1].room < 0:
            met += 1
            assert min(rooms) < 0.002
        else:
            assert min(rooms) > -MARGIN
    assert 2 < met < 11, "both cases came"
    assert looks < dense


def test_no_shape_moves_farther_than_its_bound():
    clearance = of_arm()
    robot = arm().robot
    lot = np.random.default_rng(3)
    configuration = Configuration(robot)
    for _ in range(50):
        posture, step = lot.uniform(-1, 1, (2, len(robot.joints))) * [[1.5], [0.05]]
        places = []
        for here in (posture, posture + step):
            configuration.update(here)
            places.append(np.concatenate([configuration.pose(x.name).points(x.mesh.vertices) for x in robot.links]))
        assert np.linalg.norm(places[1] - places[0], axis=1).max() <= clearance.motion(step)


def test_room_is_at_most_the_largest_measured_distance():
    robot, skin = pair()
    clearance = Clearance(robot, skin)
    clearance.begin(np.zeros(1), (), "right", np.array([0.0, 0.0, 5.0]), UP)
    assert clearance.at(np.array([-5.0])).room <= FAR
