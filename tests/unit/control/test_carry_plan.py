"""Ways over which a contact is taken from one place of the skin to another."""

from __future__ import annotations

import numpy as np
import pytest

from app.control.carry_plan import ABOVE, DEPTH, HEIGHTS, CarryPlan
from app.robots.configuration import Configuration
from tests.touch import arm, taxel_near
from tests.unit.control.test_aim import reached, spot_of


def planned(leaves, enters) -> CarryPlan:
    robot = arm().robot
    plan = CarryPlan(robot, Configuration(robot), robot.home, robot.home, spot_of(leaves), spot_of(enters))
    rounds = 0
    while not plan.done:
        plan.look(10)
        rounds += 10
        assert rounds < 4000, "the search must end"
    return plan


def ends():
    """A taxel at the end of the forearm's skin, and one of the hand's on the same side."""
    skin = arm().skin
    forearm, hand = (skin.patches[k].taxels.positions for k in (1, 2))
    low, high = forearm[forearm[:, 2].argmax()], hand[hand[:, 2].argmax()]
    return taxel_near(skin, 1, low), taxel_near(skin, 2, high)


def test_from_forearm_to_hand_each_posture_is_where_it_should_be():
    leaves, enters = ends()
    route = planned(leaves, enters).route
    assert route is not None
    touched = reached(spot_of(leaves), arm().robot.home)
    assert route.start == pytest.approx(arm().robot.home)
    lifted = reached(spot_of(leaves), route.lifted).point
    height = float(touched.normal @ (touched.point - lifted))
    assert any(height == pytest.approx(wanted, abs=0.005) for wanted in HEIGHTS)
    for posture, off in ((route.over, -height), (route.above, -ABOVE), (route.pressed, DEPTH)):
        assert np.linalg.norm(reached(spot_of(enters), posture).point - touched.raised(off).point) < 0.006


def test_the_arm_stays_out_of_the_room_of_what_it_touches():
    leaves, enters = ends()
    route, touched = planned(leaves, enters).route, reached(spot_of(leaves), arm().robot.home)
    configuration = Configuration(arm().robot)
    for share in np.linspace(0, 1, 30):
        configuration.update(route.lifted + share * (route.over - route.lifted))
        for link in arm().robot.links[1:]:
            away = configuration.pose(link.name).points(link.mesh.vertices) - touched.point
            along = away @ touched.normal
            aside = np.linalg.norm(away - along[:, None] * touched.normal, axis=1)
            assert not ((along > 0) & (along < 0.2) & (aside < 0.025)).any()


def test_where_there_is_no_way_it_ends_without_one():
    """The upper arm cannot come to where the hand is."""
    _, hand = ends()
    plan = planned(hand, 5)
    assert plan.done
    assert plan.route is None


def test_the_same_question_has_the_same_answer():
    first, second = (planned(*ends()).route for _ in range(2))
    assert np.array_equal(first.over, second.over)
