"""What each task wants, and what the keeper remembers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.control.motion.limits import ActiveLimits, Limit, LimitKind, RegraspFailure
from tactile_maps.control.motion.map_kinematics import MapKinematics
from tactile_maps.control.motion.task_priority import ContactPresence
from tactile_maps.control.task_control.monitors import EnergyTank
from tactile_maps.control.task_control.tasks import MOST_ERROR, SEARCH_TIME, TaskManager
from tactile_maps.robots.kinematics import Configuration
from tests.control.contacts import TICK, region, touch_on
from tests.support.touch import prepared_bar
from tests.support.two_plates import two_plates

BAR = prepared_bar()
MAP = BAR.map
SIGHT = MapKinematics(BAR.map)
CONFIGURATION = Configuration(BAR.robot)
POINTS = MAP.taxel_points
HERE = int(np.argmin(np.linalg.norm(POINTS - POINTS.mean(axis=0), axis=1)))
NEAR = int(np.argsort(np.linalg.norm(POINTS - POINTS[HERE], axis=1))[1])


def asked(task_manager, regions, **settings):
    limits = ActiveLimits()
    wants = task_manager.goals(ControlSettings(**settings), regions, SIGHT, CONFIGURATION, TICK, limits)
    return wants, list(limits.found)


def at(taxel=HERE, force=3.0, id_=1):
    return touch_on(MAP, taxel, force, id_=id_)


def test_nothing_is_wanted_until_something_touches():
    assert asked(TaskManager(), ()) == ([], [])


def test_a_force_is_kept_wherever_the_contact_slides():
    [want], _ = asked(TaskManager(), (at(),), task="keep_force", force_goal=2.0)
    assert (want.force, want.error, want.region.id) == (2.0, None, 1)


def test_a_point_is_held_where_the_contact_began_or_where_it_is_drawn():
    task_manager = TaskManager()
    [want], _ = asked(task_manager, (at(),), task="hold_point")
    assert want.error == pytest.approx([0, 0], abs=1e-12)
    [want], _ = asked(task_manager, (at(NEAR),), task="hold_point")
    expected = POINTS[HERE] - POINTS[NEAR]
    assert want.error == pytest.approx(expected * min(1, MOST_ERROR / np.linalg.norm(expected)))
    drawn = tuple(map(float, POINTS[HERE] + [0.004, 0.003]))
    [want], limits = asked(task_manager, (at(),), task="hold_point", path=(drawn,))
    assert want.error == pytest.approx([0.004, 0.003])
    assert limits == []
    [want], limits = asked(task_manager, (at(),), task="hold_point", path=((9.0, 9.0),))
    assert want.error == pytest.approx([0, 0], abs=1e-12)
    assert limits == [Limit(LimitKind.POINT_OFF_SKIN)]


def walked(task_manager, ticks, *, regions=None, **settings):
    ways = []
    limits = set()
    for _ in range(ticks):
        point = (at(),) if regions is None else regions
        if regions is None and task_manager.target is not None:  # the contact is always where it should be
            place = task_manager.target
            point = (replace(at(), at=place, map_point=MAP.to_map(place), link_position=BAR.skin.position(place)),)
        limits |= set(asked(task_manager, point, task="follow_path", **settings)[1])
        ways.append(task_manager.report(EnergyTank()).way)
    return np.array(ways), limits


def test_a_closed_path_is_walked_round_and_round_at_its_speed():
    ways, limits = walked(TaskManager(), 3000, path_speed=0.02)
    steps = np.diff(ways)
    assert np.median(steps) == pytest.approx(0.02 * TICK)
    assert (steps < 0).sum() == pytest.approx(3000 * TICK * 0.02 / ways.max(), abs=1)
    assert limits == set()


def test_an_open_path_is_walked_to_and_fro():
    ways, _ = walked(TaskManager(), 4000, path_kind="polyline", path_speed=0.02)
    assert np.abs(np.diff(ways)).max() <= 0.02 * TICK * (1 + 1e-9)
    assert ways.max() == pytest.approx(0.03, rel=1e-3)
    assert (np.diff(ways) < 0).any()


def test_a_path_is_started_again_when_asked():
    task_manager = TaskManager()
    ways, _ = walked(task_manager, 100, path_speed=0.02, starts=1)
    again, _ = walked(task_manager, 1, path_speed=0.02, starts=1)
    afresh, _ = walked(task_manager, 1, path_speed=0.02, starts=2)
    assert again[0] > ways[-1] > 0.009
    assert afresh[0] == pytest.approx(0.02 * TICK)


def test_the_goal_s_velocity_is_told_to_and_fro():
    task_manager = TaskManager()
    ways = set()
    against = 0
    last = MAP.to_map(at().at)
    for _ in range(2000):
        place = task_manager.target or at().at
        point = (replace(at(), at=place, map_point=MAP.to_map(place), link_position=BAR.skin.position(place)),)
        [want], _ = asked(task_manager, point, task="follow_path", path_kind="polyline", path_speed=0.02)
        now = MAP.to_map(task_manager.target)
        step = now - last
        last = now
        if np.linalg.norm(step) < 1.5 * 0.02 * TICK and step.any():
            against += bool(step @ want.velocity < 0)
            ways.add(float(np.sign(want.velocity[0])))
    assert ways >= {1.0, -1.0}
    assert against <= 10, "only in the ticks of the turns"


def test_a_path_waits_for_a_contact_that_stays_behind():
    ways, limits = walked(TaskManager(), 2000, regions=(at(),), path_speed=0.02)
    assert 0.009 < ways[-1] < 0.02
    assert limits == {Limit(LimitKind.PATH_WAITS)}


def test_a_skin_that_locates_the_contact_too_coarsely_for_a_path_is_reported():
    """95 % of normally distributed places are within 1.73 times their radial standard deviation."""
    for place_error, reported in (
        (0.0017, set()),
        (0.003, {Limit(LimitKind.PLACE_UNCERTAIN, value=0.0052, bound=0.003)}),
    ):
        _, limits = walked(TaskManager(), 3, regions=(replace(at(), place_error=place_error),), path_speed=0.02)
        assert limits == reported


def test_a_path_that_leaves_the_skin_ends_there_and_one_that_is_nowhere_stands_still():
    line = (tuple(POINTS[HERE]), tuple(POINTS[HERE] + [5.0, 0.0]))
    ways, limits = walked(TaskManager(), 100, path_kind="polyline", path=line)
    assert limits == {Limit(LimitKind.PATH_LEAVES_SKIN)}
    assert ways[-1] > 0
    nowhere = ((9.0, 9.0), (9.1, 9.0))
    ways, limits = walked(TaskManager(), 10, path_kind="polyline", path=nowhere)
    assert limits == {
        Limit(LimitKind.PATH_REFUSED, detail="the path does not start on the skin, but at (9000, 9000) mm")
    }
    assert not ways.any()


def test_balance_wants_the_mean_of_all_and_the_goal_of_one():
    wants, _ = asked(TaskManager(), (at(force=5.0), at(NEAR, 1.0, 2)), task="balance")
    assert [want.force for want in wants] == [3.0, 3.0]
    wants, _ = asked(TaskManager(), (at(force=5.0),), task="balance", force_goal=2.0)
    assert [want.force for want in wants] == [2.0]


def test_retreat_wants_no_force_of_any():
    wants, _ = asked(TaskManager(), (at(), at(NEAR, 1.0, 2)), task="retreat")
    assert [(want.region.id, want.force) for want in wants] == [(1, 0.0), (2, 0.0)]


def test_the_contact_is_kept_when_another_becomes_stronger():
    task_manager = TaskManager()
    asked(task_manager, (at(),))
    wants, _ = asked(task_manager, (at(NEAR, 9.0, 2), at()))
    assert [want.region.id for want in wants] == [1, 2]
    [want], _ = asked(task_manager, (at(NEAR, 9.0, 2),))
    assert want.region.id == 2


@pytest.mark.parametrize("task", ["keep_force", "hold_point", "follow_path", "guide"])
def test_all_other_contacts_above_the_goal_are_kept_at_it_and_may_slide(task):
    task_manager = TaskManager()
    asked(task_manager, (at(),), task=task)
    wants, _ = asked(task_manager, (at(NEAR, 9.0, 2), at(), at(NEAR, 2.9, 3)), task=task)
    assert [(want.region.id, want.force) for want in wants] == [(1, 3.0), (2, 3.0)]
    assert wants[1].error is None
    report = task_manager.report(EnergyTank())
    assert (report.controlled, report.force_goal) == ((1, 2), 3.0)


def test_a_contact_that_is_sought_is_not_controlled():
    task_manager = TaskManager()
    asked(task_manager, (at(),))
    [want], _ = asked(task_manager, ())
    assert want.presence is ContactPresence.LOST
    assert task_manager.report(EnergyTank()).controlled == ()


def test_a_stop_leaves_no_contact_controlled():
    task_manager = TaskManager()
    asked(task_manager, (at(),))
    task_manager.let_go()
    assert task_manager.report(EnergyTank()).controlled == ()


def test_a_lost_contact_is_sought_for_a_while_without_force():
    task_manager = TaskManager()
    asked(task_manager, (at(),))
    ticks = 0
    while (found := asked(task_manager, ()))[0]:
        [want], limits = found
        assert (want.region.force, want.error, limits) == (0.0, None, [Limit(LimitKind.CONTACT_LOST)])
        assert (want.region.id, want.presence) == (1, ContactPresence.LOST)
        ticks += 1
    assert ticks * TICK == pytest.approx(SEARCH_TIME, abs=2 * TICK)
    for task in ("retreat", "guide", "balance"):
        other = TaskManager()
        asked(other, (at(),), task=task)
        assert asked(other, (), task=task) == ([], [])


def test_a_hand_that_comes_again_guides_from_where_it_comes():
    task_manager = TaskManager()
    asked(task_manager, (at(),), task="guide")
    asked(task_manager, (), task="guide")
    [want], _ = asked(task_manager, (at(NEAR, id_=2),), task="guide")
    assert want.error == pytest.approx([0, 0], abs=1e-12)


def test_another_task_starts_afresh():
    task_manager = TaskManager()
    walked(task_manager, 100)
    assert task_manager.report(EnergyTank()).way > 0
    asked(task_manager, (at(),), task="hold_point")
    assert task_manager.report(EnergyTank()).way == 0


def test_another_map_starts_a_path_afresh_and_keeps_a_place_held():
    other = MapKinematics(MAP)
    for task, held in (("hold_point", HERE), ("follow_path", NEAR)):
        task_manager = TaskManager()
        limits = ActiveLimits()
        for map_kinematics, taxel in ((SIGHT, HERE), (other, NEAR)):
            task_manager.goals(ControlSettings(task=task), (at(taxel),), map_kinematics, CONFIGURATION, TICK, limits)
        assert MAP.to_map(task_manager.target) == pytest.approx(POINTS[held], abs=1e-3)


PLATES = MapKinematics(two_plates())


def on_plate(x, y, *, id_=1, force=3.0):
    place = PLATES.map.to_body(np.array([x, y]))
    return region(force, place, PLATES.map.skin.position(place), np.array([x, y]), id_=id_)


def asked_on_plates(task_manager, regions, **settings):
    limits = ActiveLimits()
    wants = task_manager.goals(ControlSettings(**settings), regions, PLATES, CONFIGURATION, TICK, limits)
    return wants, list(limits.found)


def test_a_point_to_hold_on_another_patch_is_said_and_only_the_force_kept():
    [want], limits = asked_on_plates(TaskManager(), (on_plate(0.05, 0.05),), task="hold_point", path=((0.17, 0.05),))
    assert (want.force, want.error) == (3.0, None)
    assert limits == [Limit(LimitKind.CONTACT_ELSEWHERE, ("b", "a"))]


def test_a_point_to_hold_that_is_moved_is_gone_to_and_the_contact_stays_the_same():
    task_manager = TaskManager()
    asked_on_plates(task_manager, (on_plate(0.05, 0.05),), task="hold_point", path=((0.05, 0.05),))
    both = (on_plate(0.02, 0.02, id_=2, force=9.0), on_plate(0.05, 0.05))
    [want, _], _ = asked_on_plates(task_manager, both, task="hold_point", path=((0.06, 0.05),))
    assert want.region.id == 1
    assert want.error == pytest.approx([0.01, 0])


def test_a_far_goal_in_a_patch_drawn_larger_is_gone_to_at_the_same_speed_on_the_body():
    map_kinematics = MapKinematics(two_plates(scale=2.0))
    errors = []
    for y in (0.05, 0.1):
        x = 0.03 if y == 0.05 else 0.14
        place = map_kinematics.map.to_body(np.array([x, y]))
        touched = region(3.0, place, map_kinematics.map.skin.position(place), np.array([x, y]))
        path = ((x + (0.06 if x < 0.12 else 0.12), y),)
        [want] = TaskManager().goals(
            ControlSettings(task="hold_point", path=path),
            (touched,),
            map_kinematics,
            CONFIGURATION,
            TICK,
            ActiveLimits(),
        )
        errors.append(want.error[0])
    assert errors == pytest.approx([MOST_ERROR, 2 * MOST_ERROR])


def test_an_object_on_a_border_is_one_contact_on_a_path():
    near = MapKinematics(two_plates(gap=0.002))
    regions = []
    for id_, x in ((1, 0.096), (2, 0.126)):
        place = near.map.to_body(np.array([x, 0.05]))
        regions.append(region(2.0, place, near.map.skin.position(place), np.array([x, 0.05]), id_=id_))
    path = ((0.09, 0.05), (0.15, 0.05))
    settings = ControlSettings(task="follow_path", path_kind="polyline", path=path)
    [want] = TaskManager().goals(settings, regions, near, CONFIGURATION, TICK, ActiveLimits())
    assert (want.region.id, want.region.force) == (1, pytest.approx(4.0))


def test_where_nothing_can_carry_it_the_contact_stays_before_the_crossing():
    task_manager = TaskManager()
    settings = {"task": "follow_path", "path_kind": "polyline", "path_speed": 0.1, "path": ((0.09, 0.05), (0.15, 0.05))}
    for _ in range(200):
        place = PLATES.map.to_map(task_manager.target) if task_manager.target else (0.09, 0.05)
        [want], limits = asked_on_plates(task_manager, (on_plate(*place),), **settings)
    assert [(limit.kind, limit.cause) for limit in limits] == [(LimitKind.REGRASP_FAILED, RegraspFailure.NO_ARM)]
    assert task_manager.report(EnergyTank()).piece == 0
    assert task_manager.report(EnergyTank()).regrasp is None
    assert want.error == pytest.approx([0, 0], abs=1e-6)
    _, limits = asked_on_plates(
        task_manager, (on_plate(0.09, 0.05),), **{**settings, "path": ((0.09, 0.05), (0.05, 0.05))}
    )
    assert limits == [], "another path"
