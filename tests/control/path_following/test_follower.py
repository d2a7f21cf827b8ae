"""A target that moves along a path, over borders and crossings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.limits import ActiveLimits, Limit, LimitKind, RegraspFailure
from tactile_maps.control.motion.map_kinematics import MapKinematics
from tactile_maps.control.motion.observation import TaskTick
from tactile_maps.control.path_following.follower import LAG, WIDE, PathFollower, over_borders
from tactile_maps.robots.kinematics import Configuration
from tests.control.contacts import TICK, region
from tests.support.touch import bar
from tests.support.two_plates import two_plates

NEAR = MapKinematics(two_plates(gap=0.01))
FAR = MapKinematics(two_plates(gap=0.04))
BORDER = MapKinematics(two_plates(gap=0.002))
CONFIGURATION = Configuration(bar())
SPEED = 0.02
BLOCKED = Limit(LimitKind.REGRASP_FAILED, ("forearm", "hand"), cause=RegraspFailure.UNREACHABLE)


def contact(map_kinematics, x, y=0.05, *, id_=1, force=3.0):
    """A contact at a point of the map."""
    at = map_kinematics.map.to_body(np.array([x, y]))
    return region(force, at, map_kinematics.map.skin.position(at), np.array([x, y]), id_=id_)


class Bench:
    """A follower of a path on two plates; by default the path crosses from one to the other at 10 mm."""

    def __init__(self, map_kinematics=FAR, *path, start=None, **settings):
        path = path or ((0.09, 0.05), (0.13, 0.05))
        self.settings = ControlSettings("hybrid", task="follow_path", path_kind="polyline", path=path, path_speed=SPEED)
        self.settings = replace(self.settings, **settings)
        self.kinematics = map_kinematics
        self.follower = PathFollower()
        assert self.lay(contact(map_kinematics, *(start or path[0])))

    @property
    def now(self):
        return TaskTick(self.settings, (), self.kinematics, CONFIGURATION, TICK, ActiveLimits())

    def lay(self, touched, **settings):
        self.settings = replace(self.settings, **settings)
        return self.follower.lay(self.now, touched)

    def walk(self, *point):
        """Velocity of the target, and a crossing, with the contact at a point of the map; by default on the target."""
        point = point or self.kinematics.map.to_map(self.follower.target)
        return self.follower.walk(self.now, contact(self.kinematics, *point))

    def follow(self, ticks):
        """Distances, velocities and crossings while the contact is on the target."""
        rows = []
        for _ in range(ticks):
            velocity, crossing = self.walk()
            rows.append((self.follower.way, velocity, crossing))
            if crossing is None:
                self.follower.go_to(self.follower.way)
        return zip(*rows, strict=True)

    def join(self, x):
        self.follower.join(self.now, contact(self.kinematics, x, id_=2))
        return self.follower.way


def merged(posture, *contacts):
    configuration = Configuration(bar())
    configuration.update(np.array([posture]))
    return over_borders(TaskTick(ControlSettings(), contacts, BORDER, configuration, TICK, ActiveLimits()), contacts[0])


@pytest.mark.parametrize("posture", [0.0, 0.7])
def test_contact_on_a_border_has_the_force_of_both_sides_and_their_common_centre(posture):
    """The contact is at 96 mm on one patch and 2 + 106 mm on the other, at any orientation of the link."""
    left, right = contact(BORDER, 0.096, force=2.0), contact(BORDER, 0.126, force=1.0, id_=2)
    one = merged(posture, left, right)
    assert (one.id, one.at, one.force) == (left.id, left.at, pytest.approx(3.0))
    assert one.link_position == pytest.approx([0.096 + 0.012 / 3, 0.05, 0.0])
    assert one.map_point == pytest.approx([0.1, 0.05], abs=1e-4), "extrapolated over the border"
    assert merged(posture, right, left).link_position == pytest.approx(one.link_position)
    without_force = merged(posture, replace(left, force=0.0), replace(right, force=0.0))
    assert np.isfinite(without_force.map_point).all()


@pytest.mark.parametrize("others", [(), (0.05,), (0.19,)], ids=["alone", "same patch", "far away"])
def test_other_contacts_do_not_change_a_contact(others):
    assert WIDE * BORDER.pitch < 0.05
    left = contact(BORDER, 0.096)
    assert merged(0.0, left, *(contact(BORDER, x, id_=2) for x in others)) is left


def test_contact_is_moved_straight_to_a_nearby_place():
    bench = Bench(NEAR)
    ways, velocities, crossings = bench.follow(190)
    assert set(crossings) == {None}
    assert np.diff(ways).max() == pytest.approx(SPEED * TICK)
    assert ways[-1] == pytest.approx(190 * SPEED * TICK, abs=2 * SPEED * TICK), "it hardly stops at the crossing"
    assert velocities[0] == pytest.approx([SPEED, 0])
    assert (bench.follower.piece, bench.follower.target.patch) == (1, 1)


def test_contact_is_moved_gently_until_it_has_arrived():
    """The target jumps by 10 mm there."""
    bench = Bench(NEAR)
    bench.follower.go_to(0.01 - 1e-6)
    for point, leads_over in (((), True), ((0.0999, 0.05), True), ((0.1201, 0.05), False)):
        bench.walk(*point)
        assert bench.follower.leads_over == leads_over


@pytest.mark.parametrize("back", [False, True])
def test_path_waits_before_a_distant_place_until_the_contact_has_been_regrasped(back):
    bench = Bench()
    if back:
        for way in (0.015, 0.02 * (1 - 1e-9)):  # it turns at the end
            bench.follower.go_to(way)
            bench.walk()
    ways, velocities, crossings = bench.follow(190)
    crossing = crossings[-1]
    assert ways[-1] == ways[-5] == pytest.approx(0.01, abs=1.1 * SPEED * TICK)
    assert not velocities[-1].any()
    patches = crossing.leaves.patch, crossing.enters.patch
    assert patches == ((1, 0) if back else (0, 1))
    bench.follower.go_to(crossing.way)
    assert (bench.follower.target.patch, bench.follower.piece) == (patches[1], patches[1])
    ways, _, crossings = bench.follow(20)
    assert set(crossings) == {None}, "it continues from there"
    assert (np.diff(ways) > 0).all() != back


def test_speed_is_measured_on_the_map_and_lag_on_the_body():
    """The contact moves half as fast on the body in a patch drawn at twice the size."""
    bench = Bench(MapKinematics(two_plates(scale=2.0)), (0.15, 0.1), (0.25, 0.1))
    ways, *_ = bench.follow(50)
    assert np.diff(ways) == pytest.approx(SPEED * TICK, abs=1e-8)
    bench.follower.go_to(0.016)
    velocity, _ = bench.walk(0.15, 0.1)
    assert bench.follower.behind == pytest.approx(0.008, abs=1e-4), "16 mm of the map"
    assert 0 < velocity[0] < SPEED, "slower near the largest lag"
    bench.follower.go_to(0.03)
    assert not bench.walk(0.15, 0.1)[0].any()
    assert bench.follower.waits
    assert bench.follower.behind > LAG


def test_changed_path_continues_at_its_nearest_point():
    bench = Bench(FAR, (0.02, 0.02), (0.08, 0.02))
    bench.follower.go_to(0.03)
    here = contact(FAR, 0.05, 0.02)
    assert bench.lay(here, path=((0.02, 0.03), (0.08, 0.03), (0.08, 0.09)))
    assert bench.follower.way == pytest.approx(0.03)
    assert not bench.lay(here)
    assert bench.lay(here, path=((0.13, 0.03), (0.2, 0.03)))
    assert bench.follower.way == 0.0
    _, crossing = bench.walk(0.05, 0.02)
    assert (crossing.way, crossing.enters.patch) == (0.0, 1), "the contact has to be regrasped there"


def test_path_keeps_its_place_on_another_map():
    bench = Bench(FAR, (0.02, 0.02), (0.08, 0.02))
    bench.follower.go_to(0.03)
    bench.kinematics = MapKinematics(two_plates(gap=0.04, scale=2.0))
    assert bench.lay(contact(FAR, 0.05, 0.02))
    assert bench.follower.way == pytest.approx(0.03)


def test_changed_default_path_is_centred_at_the_contact_again():
    bench = Bench(start=(0.05, 0.05), path=(), path_kind="lemniscate", path_size=0.02)
    assert bench.follower.laid_at == pytest.approx((0.05, 0.05))
    assert bench.lay(contact(FAR, 0.06), path_size=0.03)
    assert bench.follower.laid_at == pytest.approx((0.06, 0.05))


def test_new_contact_on_another_patch_joins_the_path_there():
    bench = Bench()
    bench.follower.stay(BLOCKED, bench.follower.target)
    assert bench.join(0.129) == pytest.approx(0.019)
    assert bench.follower.blocked is None
    bench.follower.go_to(0.0)
    bench.kinematics = MapKinematics(two_plates(gap=0.001))
    assert bench.join(0.121) == 0.0, "just over the border it is the same contact"
    assert Bench(FAR, (0.02, 0.02), (0.08, 0.02)).join(0.16) == 0.0, "the path is not on that patch"


def test_blocked_path_holds_the_contact_and_keeps_the_reason():
    bench = Bench()
    leaves = FAR.map.to_body(np.array([0.099, 0.05]))
    bench.follower.stay(BLOCKED, leaves)
    velocity, crossing = bench.walk(0.05, 0.05)
    assert not velocity.any()
    assert (crossing, bench.follower.target, bench.follower.blocked) == (None, leaves, BLOCKED)
    assert not bench.follower.waits


@pytest.mark.parametrize("start", [(9.0, 9.0), (0.05, 0.05)])
def test_path_off_the_skin_or_without_length_does_not_move(start):
    bench = Bench(FAR, start, (0.05, 0.05), start=(0.05, 0.05))
    velocity, crossing = bench.walk(0.05, 0.05)
    assert not velocity.any()
    assert crossing is None
    problem = bench.follower.problem
    assert (
        problem is None
        if start[0] < 1
        else (problem.kind is LimitKind.PATH_REFUSED and "does not start on the skin" in problem.detail)
    )
