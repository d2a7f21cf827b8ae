"""A target led along a path, over borders and crossings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.limits import Limit, LimitKind, RegraspFailure
from tactile_maps.control.motion.map_kinematics import MapKinematics
from tactile_maps.control.path_following.follower import LAG, WIDE, PathFollower, over_borders
from tactile_maps.robots.kinematics import Configuration
from tests.control.contacts import TICK, region
from tests.support.touch import bar
from tests.support.two_plates import two_plates

SIGHT = MapKinematics(two_plates(gap=0.002))


def touching(x, force, id_):
    at = SIGHT.map.to_body(np.array([x, 0.05]))
    return region(force, at, SIGHT.map.skin.position(at), np.array([x, 0.05]), id_=id_)


def together(posture, *regions):
    configuration = Configuration(bar())
    configuration.update(np.array([posture]))
    return over_borders(regions[0], regions, SIGHT, configuration, "smoothed")


@pytest.mark.parametrize("posture", [0.0, 0.7])
def test_its_force_is_that_of_both_and_its_place_between(posture):
    """At 96 mm on the one patch, and 2 + 106 mm from its beginning on the other, whatever way the link is turned."""
    left = touching(0.096, 2.0, 1)
    right = touching(0.126, 1.0, 2)
    one = together(posture, left, right)
    assert one.force == pytest.approx(3.0)
    assert one.link_position == pytest.approx([0.096 + 0.012 / 3, 0.05, 0.0])
    assert one.map_point == pytest.approx([0.1, 0.05], abs=1e-4), "as if the map went on over the border"
    assert (one.id, one.at) == (left.id, left.at)
    other = together(posture, right, left)
    assert other.link_position == pytest.approx(one.link_position)


def test_what_is_alone_stays_as_it_is():
    left = touching(0.096, 2.0, 1)
    assert together(0.0, left) is left


def test_what_is_far_and_what_is_on_the_same_patch_are_other_contacts():
    left = touching(0.096, 2.0, 1)
    assert together(0.0, left, touching(0.05, 1.0, 2)) is left
    assert WIDE * SIGHT.pitch < 0.05
    assert together(0.0, left, touching(0.19, 1.0, 2)) is left


def test_without_force_it_is_in_the_middle_of_nothing():
    left, right = (replace(touching(x, 1.0, k), force=0.0) for k, x in ((1, 0.096), (2, 0.126)))
    assert np.isfinite(together(0.0, left, right).map_point).all()


NEXT = MapKinematics(two_plates(gap=0.01))
FAR = MapKinematics(two_plates(gap=0.04))
CONFIGURATION = Configuration(bar())
OVER = ControlSettings(
    controller="hybrid", task="follow_path", path_kind="polyline", path=((0.09, 0.05), (0.13, 0.05)), path_speed=0.02
)


def contact(map_kinematics, x, y, id_=1):
    """One at a point of the map."""
    at = map_kinematics.map.to_body(np.array([x, y]))
    return region(3.0, at, map_kinematics.map.skin.position(at), np.array([x, y]), id_=id_)


def on_target(map_kinematics, follower):
    point = map_kinematics.map.to_map(follower.target)
    return region(3.0, follower.target, map_kinematics.map.skin.position(follower.target), point)


def walked(follower, map_kinematics, settings, ticks):
    """Ways, velocities and crossings while the contact is always where it should be."""
    rows = []
    for _ in range(ticks):
        velocity, crossing = follower.walk(
            settings, on_target(map_kinematics, follower), map_kinematics, CONFIGURATION, TICK
        )
        rows.append((follower.way, velocity, crossing))
        if crossing is None:
            follower.go_to(follower.way)
    return zip(*rows, strict=True)


def begun(map_kinematics, settings=OVER, x=0.09, y=0.05):
    follower = PathFollower()
    assert follower.lay(settings, contact(map_kinematics, x, y), map_kinematics)
    return follower


def test_a_contact_is_led_straight_over_to_a_place_that_is_near():
    follower = begun(NEXT)
    ways, velocities, crossings = walked(follower, NEXT, OVER, 190)
    assert set(crossings) == {None}
    assert np.diff(ways).max() == pytest.approx(0.02 * TICK)
    assert ways[-1] == pytest.approx(190 * 0.02 * TICK, abs=2 * 0.02 * TICK), "it hardly stops at the crossing"
    assert velocities[0] == pytest.approx([0.02, 0])
    assert follower.piece == 1
    assert follower.target.patch == 1


def test_it_is_led_over_gently_until_it_has_come():
    """The target jumps by 10 mm there: the contact is not to be thrown after it."""
    follower = begun(NEXT)
    follower.go_to(0.01 - 1e-6)
    follower.walk(OVER, on_target(NEXT, follower), NEXT, CONFIGURATION, TICK)
    assert follower.leads_over
    follower.walk(OVER, contact(NEXT, 0.0999, 0.05), NEXT, CONFIGURATION, TICK)
    assert follower.leads_over
    follower.walk(OVER, contact(NEXT, 0.1201, 0.05), NEXT, CONFIGURATION, TICK)
    assert not follower.leads_over


@pytest.mark.parametrize("back", [False, True])
def test_before_a_place_that_is_far_it_waits_for_the_contact_to_be_taken_over(back):
    follower = begun(FAR)
    if back:
        follower.go_to(0.015)
        follower.walk(OVER, on_target(FAR, follower), FAR, CONFIGURATION, TICK)
        follower.go_to(0.02 * (1 - 1e-9))
        follower.walk(OVER, on_target(FAR, follower), FAR, CONFIGURATION, TICK)  # it turns here
    ways, velocities, crossings = walked(follower, FAR, OVER, 190)
    crossing = crossings[-1]
    assert ways[-1] == ways[-5] == pytest.approx(0.01, abs=1.1 * 0.02 * TICK)
    assert not velocities[-1].any()
    patches = crossing.leaves.patch, crossing.enters.patch
    assert patches == ((1, 0) if back else (0, 1))
    follower.go_to(crossing.way)
    assert follower.target.patch == patches[1]
    assert follower.piece == patches[1]
    ways, _, crossings = walked(follower, FAR, OVER, 20)
    assert set(crossings) == {None}, "it goes on from there"
    assert (np.diff(ways) > 0).all() != back


def test_the_speed_is_that_on_the_map_and_the_lag_that_on_the_body():
    """A patch drawn twice as large: half as fast on the body, and no nearer to what the path waits for."""
    map_kinematics = MapKinematics(two_plates(scale=2.0))
    settings = replace(OVER, path=((0.15, 0.1), (0.25, 0.1)))
    follower = begun(map_kinematics, settings, 0.15, 0.1)
    ways, _, _ = walked(follower, map_kinematics, settings, 50)
    assert np.diff(ways) == pytest.approx(0.02 * TICK, abs=1e-8)
    follower.go_to(0.016)
    behind = contact(map_kinematics, 0.15, 0.1)
    velocity, _ = follower.walk(settings, behind, map_kinematics, CONFIGURATION, TICK)
    assert follower.behind == pytest.approx(0.008, abs=1e-4), "16 mm of the map"
    assert 0 < velocity[0] < 0.02, "slower, as it is near the greatest lag"
    follower.go_to(0.03)
    assert not follower.walk(settings, behind, map_kinematics, CONFIGURATION, TICK)[0].any()
    assert follower.waits
    assert follower.behind > LAG


def test_a_path_that_is_changed_goes_on_where_it_is_nearest():
    settings = replace(OVER, path=((0.02, 0.02), (0.08, 0.02)))
    follower = begun(FAR, settings, 0.02, 0.02)
    follower.go_to(0.03)
    moved = replace(settings, path=((0.02, 0.03), (0.08, 0.03), (0.08, 0.09)))
    assert follower.lay(moved, contact(FAR, 0.05, 0.02), FAR)
    assert follower.way == pytest.approx(0.03)
    assert not follower.lay(moved, contact(FAR, 0.05, 0.02), FAR)
    elsewhere = replace(settings, path=((0.13, 0.03), (0.2, 0.03)))
    assert follower.lay(elsewhere, contact(FAR, 0.05, 0.02), FAR)
    assert follower.way == 0.0
    _, crossing = follower.walk(elsewhere, contact(FAR, 0.05, 0.02), FAR, CONFIGURATION, TICK)
    assert (crossing.way, crossing.enters.patch) == (0.0, 1), "it has to be taken there"


def test_on_another_map_the_path_stays_where_it_was_drawn():
    follower = begun(FAR, replace(OVER, path=((0.02, 0.02), (0.08, 0.02))), 0.02, 0.02)
    follower.go_to(0.03)
    other = MapKinematics(two_plates(gap=0.04, scale=2.0))
    assert follower.lay(replace(OVER, path=((0.02, 0.02), (0.08, 0.02))), contact(FAR, 0.05, 0.02), other)
    assert follower.way == pytest.approx(0.03)


def test_a_path_that_nobody_drew_is_laid_about_the_contact_anew():
    settings = replace(OVER, path=(), path_kind="lemniscate", path_size=0.02)
    follower = begun(FAR, settings, 0.05, 0.05)
    assert follower.laid_at == pytest.approx((0.05, 0.05))
    assert follower.lay(replace(settings, path_size=0.03), contact(FAR, 0.06, 0.05), FAR)
    assert follower.laid_at == pytest.approx((0.06, 0.05))


BLOCKED = Limit(LimitKind.REGRASP_FAILED, ("forearm", "hand"), cause=RegraspFailure.UNREACHABLE)


def test_a_contact_that_comes_on_another_patch_joins_the_path_there():
    follower = begun(FAR)
    follower.stay(BLOCKED, follower.target)
    follower.join(contact(FAR, 0.129, 0.05, id_=2), FAR, CONFIGURATION)
    assert follower.way == pytest.approx(0.019)
    assert follower.blocked is None
    follower.go_to(0.0)
    beside = MapKinematics(two_plates(gap=0.001))
    follower.join(contact(beside, 0.121, 0.05, id_=2), beside, CONFIGURATION)
    assert follower.way == 0.0, "just over the border it is still the same"
    alone = begun(FAR, replace(OVER, path=((0.02, 0.02), (0.08, 0.02))))
    alone.join(contact(FAR, 0.16, 0.05, id_=2), FAR, CONFIGURATION)
    assert alone.way == 0.0, "the path is not on that patch"


def test_where_it_is_blocked_it_holds_and_says_why():
    follower = begun(FAR)
    leaves = FAR.map.to_body(np.array([0.099, 0.05]))
    follower.stay(BLOCKED, leaves)
    velocity, crossing = follower.walk(OVER, contact(FAR, 0.05, 0.05), FAR, CONFIGURATION, TICK)
    assert not velocity.any()
    assert crossing is None
    assert follower.target == leaves
    assert follower.blocked == BLOCKED
    assert not follower.waits


@pytest.mark.parametrize("path", [((9.0, 9.0), (0.05, 0.05)), ((0.05, 0.05), (0.05, 0.05))])
def test_a_path_that_cannot_be_stands_still_where_the_contact_is(path):
    settings = replace(OVER, path=path)
    follower = begun(FAR, settings, 0.05, 0.05)
    velocity, crossing = follower.walk(settings, contact(FAR, 0.05, 0.05), FAR, CONFIGURATION, TICK)
    assert not velocity.any()
    assert crossing is None
    if path[0][0] > 1:
        assert follower.problem.kind is LimitKind.PATH_REFUSED
        assert "does not start on the skin" in follower.problem.detail
    else:
        assert follower.problem is None
