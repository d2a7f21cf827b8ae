"""The goals of each task, and what its manager remembers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.contacts.detection.contact_shear import ContactShear, Slip
from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.limits import ActiveLimits, Limit, LimitKind, RegraspFailure
from tactile_maps.control.motion.map_kinematics import MapKinematics
from tactile_maps.control.motion.observation import TaskTick
from tactile_maps.control.motion.task_priority import ContactPresence
from tactile_maps.control.path_following.contact_place import SPARSE
from tactile_maps.control.task_control.monitors import EnergyTank
from tactile_maps.control.task_control.tasks import MOST_ERROR, SEARCH_TIME, TaskManager
from tactile_maps.robots.kinematics import Configuration
from tests.control.contacts import TICK, region
from tests.support.touch import prepared_bar
from tests.support.two_plates import two_plates

BAR = prepared_bar()
CONFIGURATION = Configuration(BAR.robot)
POINTS = BAR.map.taxel_points
HERE, NEAR = POINTS[np.argsort(np.linalg.norm(POINTS - POINTS.mean(axis=0), axis=1))[:2]]


def sheared(force):
    """Shear of a contact with this force along the skin [N] and a friction of 0.5."""
    return ContactShear((force, 0.0, 0.0), 0.0, 0.0, 1.0, Slip.STICKING, 0.5, estimated=False)


class Bench:
    """A task manager on the map of the bar, or of two plates.

    Contacts move over skin at rest; taxels are fine, so that their places are used as read.
    """

    def __init__(self, task="keep_force", map_=BAR.map, **settings):
        self.manager = TaskManager()
        self.kinematics = MapKinematics(map_)
        self.kinematics.pitch = min(self.kinematics.pitch, SPARSE)
        self.settings = ControlSettings(task=task, **settings)

    def step(self, *contacts, **settings):
        """The goals of one tick."""
        self.settings = replace(self.settings, **settings)
        limits = ActiveLimits()
        goals = self.manager.goals(TaskTick(self.settings, contacts, self.kinematics, CONFIGURATION, TICK, limits))
        self.limits = limits.found
        return goals

    def at(self, point=HERE, force=3.0, id_=1, **changed):
        """A contact at a point of the map."""
        map_ = self.kinematics.map
        place = map_.to_body(np.asarray(point))
        return replace(region(force, place, map_.skin.position(place), np.asarray(point), id_=id_), **changed)

    def on_target(self, start=HERE):
        """A contact at the target of the path."""
        target = self.report.target
        return self.at(start if target is None else self.kinematics.map.to_map(target))

    def follow(self, ticks, contact=None):
        """Distance along the path, and velocity of the target, of each tick; the default contact is on the target."""
        rows = []
        self.kinds = set()
        for _ in range(ticks):
            [goal] = self.step(self.on_target() if contact is None else contact)
            rows.append((self.report.way, *goal.velocity))
            self.kinds |= set(self.limits)
        return np.array(rows).T

    @property
    def report(self):
        return self.manager.report(EnergyTank())


def test_keep_force_lets_the_contact_slide():
    bench = Bench("keep_force", force_goal=2.0)
    assert bench.step() == []
    [goal] = bench.step(bench.at())
    assert (goal.force, goal.error, goal.region.id) == (2.0, None, 1)


def test_hold_point_keeps_the_contact_where_it_began_or_at_the_drawn_point():
    bench = Bench("hold_point")
    assert bench.step(bench.at())[0].error == pytest.approx([0, 0], abs=1e-12)
    expected = HERE - NEAR
    error = bench.step(bench.at(NEAR))[0].error
    assert error == pytest.approx(expected * min(1, MOST_ERROR / np.linalg.norm(expected)))
    for point, expected, limits in (
        (tuple(HERE + [0.004, 0.003]), [0.004, 0.003], ()),
        ((9.0, 9.0), [0, 0], (Limit(LimitKind.POINT_OFF_SKIN),)),
    ):
        assert bench.step(bench.at(), path=(point,))[0].error == pytest.approx(expected, abs=1e-9)
        assert bench.limits == limits


@pytest.mark.long
def test_closed_path_is_followed_round_and_round_at_its_speed():
    bench = Bench("follow_path", path_speed=0.02)
    way, *_ = bench.follow(3000)
    steps = np.diff(way)
    assert np.median(steps) == pytest.approx(0.02 * TICK)
    assert (steps < 0).sum() == pytest.approx(3000 * TICK * 0.02 / way.max(), abs=1)
    assert bench.kinds == set()


@pytest.mark.long
def test_open_path_is_followed_back_and_forth_with_the_velocity_of_the_target():
    way, velocity, _ = Bench("follow_path", path_kind="polyline", path_speed=0.02).follow(4000)
    steps = np.diff(way)
    assert np.abs(steps).max() <= 0.02 * TICK * (1 + 1e-9)
    assert way.max() == pytest.approx(0.03, rel=1e-3)
    assert set(np.sign(steps)) >= {1.0, -1.0}
    assert (steps * velocity[1:] < 0).sum() <= 10, "only in the ticks of the turns"


def test_path_restarts_with_a_new_number_of_starts_and_another_task():
    bench = Bench("follow_path", path_speed=0.02, starts=1)
    before = bench.follow(101)[0][-1]
    assert before > 0.009
    bench.settings = replace(bench.settings, starts=2)
    assert bench.follow(1)[0][0] == pytest.approx(0.02 * TICK)
    bench.step(bench.at(), task="hold_point")
    assert bench.report.way == 0


@pytest.mark.long
def test_path_waits_for_a_contact_that_lags():
    bench = Bench("follow_path", path_speed=0.02)
    assert 0.009 < bench.follow(2000, bench.at())[0][-1] < 0.02
    assert bench.kinds == {Limit(LimitKind.PATH_WAITS)}


def test_skin_too_coarse_for_a_path_is_reported():
    """95 % of normally distributed places are within 1.73 times their radial standard deviation."""
    reported = Limit(LimitKind.PLACE_UNCERTAIN, value=0.0052, bound=0.003)
    for place_error, limits in ((0.0017, set()), (0.003, {reported})):
        bench = Bench("follow_path", path_speed=0.02)
        bench.follow(3, bench.at(place_error=place_error))
        assert bench.kinds == limits


def test_path_that_leaves_the_skin_is_followed_to_its_border():
    bench = Bench("follow_path", path_kind="polyline", path=(tuple(HERE), tuple(HERE + [5.0, 0.0])))
    assert bench.follow(100)[0][-1] > 0
    assert bench.kinds == {Limit(LimitKind.PATH_LEAVES_SKIN)}


@pytest.mark.parametrize(
    ("task", "forces", "goals"),
    [("balance", (5.0, 1.0), [3.0, 3.0]), ("balance", (5.0,), [2.0]), ("retreat", (3.0, 1.0), [0.0, 0.0])],
)
def test_balance_shares_the_force_and_retreat_has_no_goal(task, forces, goals):
    bench = Bench(task, force_goal=2.0)
    contacts = [
        bench.at(point, force, id_) for id_, (point, force) in enumerate(zip((HERE, NEAR), forces, strict=False))
    ]
    assert [goal.force for goal in bench.step(*contacts)] == goals


@pytest.mark.parametrize("task", ["keep_force", "hold_point", "follow_path", "guide"])
def test_other_contacts_above_the_goal_are_kept_at_it_and_may_slide(task):
    bench = Bench(task)
    bench.step(bench.at())
    goals = bench.step(bench.at(NEAR, 9.0, 2), bench.at(), bench.at(NEAR, 2.9, 3))
    assert [(goal.region.id, goal.force) for goal in goals] == [(1, 3.0), (2, 3.0)], "the first contact stays first"
    assert goals[1].error is None
    assert (bench.report.controlled, bench.report.force_goal) == ((1, 2), 3.0)
    bench.manager.let_go()
    assert bench.report.controlled == ()


def test_lost_contact_is_searched_for_without_force_by_tasks_that_do_not_yield():
    bench = Bench()
    bench.step(bench.at())
    ticks = 0
    while goals := bench.step():
        [goal] = goals
        assert (goal.region.id, goal.region.force, goal.error) == (1, 0.0, None)
        assert goal.presence is ContactPresence.LOST
        assert bench.limits == (Limit(LimitKind.CONTACT_LOST),)
        assert bench.report.controlled == ()
        ticks += 1
    assert ticks * TICK == pytest.approx(SEARCH_TIME, abs=2 * TICK)
    for task in ("retreat", "guide", "balance"):
        other = Bench(task)
        other.step(other.at())
        assert (other.step(), other.limits) == ([], ())


def test_guide_starts_from_each_new_contact():
    bench = Bench("guide")
    bench.step(bench.at())
    bench.step()
    assert bench.step(bench.at(NEAR, id_=2))[0].error == pytest.approx([0, 0], abs=1e-12)


@pytest.mark.parametrize(("task", "held"), [("hold_point", HERE), ("follow_path", NEAR)])
def test_new_map_restarts_a_default_path_and_keeps_a_held_place(task, held):
    bench = Bench(task)
    bench.step(bench.at(HERE))
    bench.kinematics = MapKinematics(BAR.map)
    bench.step(bench.at(NEAR))
    assert BAR.map.to_map(bench.report.target) == pytest.approx(held, abs=1e-3)


def test_point_on_another_patch_is_reported_and_only_the_force_kept():
    bench = Bench("hold_point", two_plates(), path=((0.17, 0.05),))
    [goal] = bench.step(bench.at((0.05, 0.05)))
    assert (goal.force, goal.error) == (3.0, None)
    assert bench.limits == (Limit(LimitKind.CONTACT_ELSEWHERE, ("b", "a")),)


def test_moved_point_is_approached_with_the_same_contact():
    bench = Bench("hold_point", two_plates(), path=((0.05, 0.05),))
    bench.step(bench.at((0.05, 0.05)))
    goal, _ = bench.step(bench.at((0.02, 0.02), 9.0, 2), bench.at((0.05, 0.05)), path=((0.06, 0.05),))
    assert goal.region.id == 1
    assert goal.error == pytest.approx([0.01, 0])


@pytest.mark.parametrize(("point", "far", "scale"), [((0.03, 0.05), 0.06, 1), ((0.14, 0.1), 0.12, 2)])
def test_largest_error_on_the_body_does_not_depend_on_the_scale_of_the_patch(point, far, scale):
    bench = Bench("hold_point", two_plates(scale=2.0), path=((point[0] + far, point[1]),))
    assert bench.step(bench.at(point))[0].error[0] == pytest.approx(scale * MOST_ERROR)


def test_object_on_a_border_is_one_contact_on_a_path():
    path = ((0.09, 0.05), (0.15, 0.05))
    bench = Bench("follow_path", two_plates(gap=0.002), path_kind="polyline", path=path)
    [goal] = bench.step(bench.at((0.096, 0.05), 2.0), bench.at((0.126, 0.05), 2.0, 2))
    assert (goal.region.id, goal.region.force) == (1, pytest.approx(4.0))


def test_contact_stops_before_an_impassable_crossing():
    path = ((0.09, 0.05), (0.15, 0.05))
    bench = Bench("follow_path", two_plates(), path_kind="polyline", path_speed=0.1, path=path)
    for _ in range(200):
        [goal] = bench.step(bench.on_target(path[0]))
    assert [(limit.kind, limit.cause) for limit in bench.limits] == [(LimitKind.REGRASP_FAILED, RegraspFailure.NO_ARM)]
    assert (bench.report.piece, bench.report.regrasp) == (0, None)
    assert goal.error == pytest.approx([0, 0], abs=1e-6)
    bench.step(bench.at(path[0]), path=(path[0], (0.05, 0.05)))
    assert bench.limits == (), "another path"


@pytest.mark.parametrize(("max_shear", "size"), [(float("inf"), 1.35), (1.2, 1.2), (5.0, 1.35)])
def test_shear_goal_is_limited_by_friction_and_the_cap(max_shear, size):
    """A contact of 3 N with a friction of 0.5."""
    bench = Bench(shear_goal=2.0, shear_direction=0.5, max_shear=max_shear)
    [goal] = bench.step(bench.at(shear=sheared(0.1)))
    assert goal.shear.force == pytest.approx(size * np.array([np.cos(0.5), np.sin(0.5)]))
    assert bench.limits == (Limit(LimitKind.SHEAR_GOAL_LIMITED, ("bar",), value=2.0, bound=pytest.approx(size)),)
    [goal] = bench.step(bench.at(shear=sheared(0.1)), shear_goal=1.0)
    assert np.linalg.norm(goal.shear.force) == pytest.approx(1.0)
    assert bench.limits == ()


@pytest.mark.parametrize("changes", [{"shear_goal": 1.0}, {"max_shear": 1.0}])
def test_contact_on_skin_without_shear_is_reported_if_the_settings_need_it(changes):
    bench = Bench(**changes)
    [goal] = bench.step(bench.at())
    assert goal.shear is None
    assert bench.limits == (Limit(LimitKind.SHEAR_UNMEASURED, ("bar",)),)


@pytest.mark.parametrize("task", ["follow_path", "balance", "retreat"])
def test_other_tasks_have_no_shear_goal(task):
    bench = Bench(task, shear_goal=1.0)
    assert [goal.shear for goal in bench.step(bench.at(shear=sheared(0.1)))] == [None]


def test_guide_yields_to_the_hand_if_shear_is_measured_and_holds_its_place_otherwise():
    bench = Bench("guide", shear_threshold=0.3)
    [goal] = bench.step(bench.at(shear=sheared(1.0)))
    assert (goal.error, goal.shear.slack) == (None, 0.3)
    assert not goal.shear.force.any()
    for changes, contact in (
        ({}, bench.at(NEAR)),
        ({"shear_threshold": float("inf")}, bench.at(NEAR, shear=sheared(1))),
    ):
        [goal] = bench.step(contact, **changes)
        assert goal.shear is None
        assert np.linalg.norm(goal.error) > 0
