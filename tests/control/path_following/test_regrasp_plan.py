"""The route of a regrasp, or the reason why none was found."""

from __future__ import annotations

from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from tactile_maps.control.motion.limits import RegraspFailure
from tactile_maps.control.path_following.clearance import Clearance, Obstacle
from tactile_maps.control.path_following.regrasp_plan import ABOVE, DEPTH, HEIGHTS, RegraspPlan
from tactile_maps.geometry.surface.pose import Pose
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.tactile.mechanics.loads import Sphere
from tests.control.path_following.test_inverse_kinematics import reached, spot_of
from tests.control.path_following.test_regrasp import ends
from tests.support.touch import arm

MOST = 40_000


@cache
def clear_of(*obstacles) -> Clearance:
    return Clearance(arm().robot, arm().skin, obstacles)


def planned(leaves, enters, *obstacles) -> RegraspPlan:
    robot = arm().robot
    touched = spot_of(leaves)
    clearance = clear_of(*obstacles)
    here = reached(touched, robot.home)
    clearance.begin(robot.home, obstacles, touched.link, here.point, here.normal)
    plan = RegraspPlan(robot, Configuration(robot), clearance, robot.home, robot.home, touched, spot_of(enters))
    looked = 0
    while not plan.done:
        plan.look(10)
        looked += 10
        assert looked < MOST, "the search must end"
    return plan


def ball(leaves, radius=0.03) -> Obstacle:
    """Return a ball that touches a taxel at the home posture."""
    here = reached(spot_of(leaves), arm().robot.home)
    return Obstacle("ball", Sphere(radius), Pose(np.eye(3), here.point + radius * here.normal))


def test_postures_of_a_route_are_at_their_heights():
    leaves, enters = ends()
    route = planned(leaves, enters).route
    assert route is not None
    touched = reached(spot_of(leaves), arm().robot.home)
    assert route.start == pytest.approx(arm().robot.home)
    lifted = reached(spot_of(leaves), route.lifted).point
    height = float(touched.normal @ (touched.point - lifted))
    assert any(height == pytest.approx(expected, abs=0.005) for expected in HEIGHTS)
    over = float(touched.normal @ (touched.point - reached(spot_of(enters), route.over).point))
    above, pressed = (reached(spot_of(enters), posture).point for posture in (route.above, route.pressed))
    assert over > ABOVE + 0.002
    assert float(touched.normal @ (pressed - above)) == pytest.approx(ABOVE + DEPTH, abs=0.006)
    assert np.linalg.norm(pressed - touched.raised(DEPTH).point) < 0.03, (
        "where the skin leans, the object is met before"
    )


def test_arm_stays_out_of_the_space_of_an_unknown_object():
    leaves, enters = ends()
    route = planned(leaves, enters).route
    touched = reached(spot_of(leaves), arm().robot.home)
    configuration = Configuration(arm().robot)
    for share in np.linspace(0, 1, 30):
        configuration.update(route.lifted + share * (route.over - route.lifted))
        for link in arm().robot.links[1:]:
            away = configuration.pose(link.name).points(link.mesh.vertices) - touched.point
            along = away @ touched.normal
            aside = np.linalg.norm(away - along[:, None] * touched.normal, axis=1)
            assert not ((along > 0) & (along < 0.2) & (aside < 0.025)).any()


def test_plan_ends_if_there_is_no_route():
    """The upper arm cannot come to where the hand is."""
    _, hand = ends()
    plan = planned(hand, 5)
    assert plan.route is None
    assert plan.problem.cause in (RegraspFailure.UNREACHABLE, RegraspFailure.FACES_AWAY)


@pytest.mark.long
def test_plan_is_deterministic():
    first, second = (planned(*ends()).route for _ in range(2))
    assert np.array_equal(first.over, second.over)


@pytest.mark.long
def test_only_the_contact_place_approaches_a_known_object():
    """Every posture of the route has room, but for the place that touches."""
    leaves, enters = ends()
    known = ball(leaves)
    route = planned(leaves, enters, known).route
    clearance = clear_of(known)
    way = (route.lifted, *route.around, route.over)
    clearance.meeting(None)
    for before, after in pairwise(way):
        assert min(clearance.at(before + share * (after - before)).room for share in np.linspace(0, 1, 40)) > -0.002
    clearance.meeting("hand")
    assert clearance.at(route.above).room > 0
    assert clearance.distance(route.above, "hand", "ball") > 0.005
    assert clearance.distance(route.pressed, "hand", "ball") < 0


def test_obstacle_in_the_way_is_named():
    """A great ball close behind the forearm: it cannot be lifted off what it touches in front."""
    leaves, enters = ends()
    touched = spot_of(leaves)
    home = arm().robot.home
    here = reached(touched, home)

    def behind(far) -> Obstacle:
        return Obstacle("dome", Sphere(1.0), Pose(np.eye(3), here.point - (1.0 + far) * here.normal))

    clearance = clear_of(behind(1.0))
    for far in np.arange(0.2, 0.0, -0.002):
        clearance.begin(home, (behind(far),), touched.link, here.point, here.normal)
        clearance.meeting(touched.link)
        if "dome" in clearance.at(home).between and clearance.at(home).room < 0.006:
            break
    robot = arm().robot
    plan = RegraspPlan(robot, Configuration(robot), clearance, home, home, touched, spot_of(enters))
    plan.look(MOST)
    assert plan.problem.cause is RegraspFailure.NO_LIFT
    assert "dome" in plan.problem.between


def test_lift_that_presses_the_skin_deeper_is_rejected(monkeypatch):
    leaves, enters = ends()
    home = arm().robot.home
    monkeypatch.setattr(Clearance, "distance", lambda _, posture, *pair: 0.0 if (posture == home).all() else -0.01)
    plan = planned(leaves, enters, ball(leaves))
    assert plan.problem.cause is RegraspFailure.NO_LIFT
    assert "ball" in plan.problem.between
