"""Overlay of a task, built from settings, frames and the map, and the path of its contact."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.control.motion.command import ControlSettings, TaskReport
from tactile_maps.core.reading_units import ReadingUnits
from tactile_widgets.views.overlays.task_overlay import NO_TASK, TRAIL_SECONDS, lines_on_skin
from tactile_widgets.views.overlays.task_overlay_builder import TaskOverlayBuilder, TrailRecorder
from tests.widgets.support.samples import leaf_map, shifted, touched

LEFT = 0
RIGHT = 1


@pytest.fixture(scope="module")
def tactile_map():
    return leaf_map()


def region_at(tactile_map, point, *, number=1, force=1.0):
    at = tactile_map.to_body(np.array(point))
    assert at is not None
    skin = tactile_map.skin
    place = np.array(point), at, skin.link(at), skin.position(at), skin.normal(at)
    return ContactRegion(number, np.zeros(0, int), force, 1e-4, 1e4, *place)


def walked(tactile_map, points, *, trail=None, start=0.0, step=0.1, number=1):
    trail = trail or TrailRecorder()
    for count, point in enumerate(points):
        trail.follow(start + count * step, [region_at(tactile_map, point, number=number)], tactile_map)
    return trail


def line(tactile_map, patch=LEFT, count=11):
    middle = tactile_map.boxes[patch].mean(axis=0)
    return middle + np.linspace([-0.03, 0.0], [0.03, 0.0], count)


def test_path_has_the_contact_locations_oldest_first(tactile_map):
    points = line(tactile_map)
    tail = walked(tactile_map, points).tail
    np.testing.assert_allclose(tail.on_map, points, atol=1e-12)
    np.testing.assert_allclose(tail.age, np.linspace(1.0, 0.0, 11) / TRAIL_SECONDS, atol=1e-9)
    assert tail.lines == [slice(0, 11)]
    skin = tactile_map.skin
    np.testing.assert_allclose(tail.on_body[3], skin.position(tactile_map.to_body(points[3])), atol=1e-12)


def test_resting_contact_leaves_no_path(tactile_map):
    points = line(tactile_map)
    trail = walked(tactile_map, [points[5]] * 4)
    tail = trail.tail
    assert not tail.lines
    walked(tactile_map, [points[5]] * 4, trail=trail, start=0.4)
    assert trail.tail is tail


def test_path_of_a_stopped_contact_fades(tactile_map):
    points = line(tactile_map)
    trail = walked(tactile_map, points)
    walked(tactile_map, [points[-1]] * 20, trail=trail, start=1.1)
    assert trail.tail.lines
    assert trail.tail.age[-1] == 0
    walked(tactile_map, [points[-1]] * 30, trail=trail, start=3.1)
    assert not trail.tail.lines


def test_known_contact_is_followed_despite_a_stronger_one(tactile_map):
    points = line(tactile_map)
    other = tactile_map.boxes[RIGHT].mean(axis=0)
    trail = TrailRecorder()
    trail.follow(0.0, [region_at(tactile_map, points[0])], tactile_map)
    strong = region_at(tactile_map, other, number=2, force=9.0)
    trail.follow(0.1, [strong, region_at(tactile_map, points[1])], tactile_map)
    assert trail.contact == 1
    assert len(trail.tail.lines) == 1
    trail.follow(0.2, [strong], tactile_map)
    assert trail.contact == 2
    assert [part.stop - part.start for part in trail.tail.lines] == [2], "another contact begins another line"
    trail.follow(0.4, [], tactile_map)
    assert trail.contact == 0
    assert trail.tail.age[-1] == pytest.approx(0.2 / TRAIL_SECONDS), "without a contact, the path fades"


def test_path_is_interrupted_at_a_seam(tactile_map):
    """The right leaf laid elsewhere is what a map looks like that was cut between two places."""
    points = line(tactile_map)
    trail = walked(tactile_map, points[:5])
    near = region_at(tactile_map, points[5])
    far = replace(near, at=tactile_map.to_body(points[5] + [0.0, 0.05]))
    trail.follow(0.5, [far], tactile_map)
    assert trail.tail.lines == [slice(0, 5)]


@pytest.mark.parametrize("time", [0.3, 5.0], ids=["back", "far on"])
def test_jump_in_a_replay_discards_the_path(tactile_map, time):
    points = line(tactile_map)
    trail = walked(tactile_map, points)
    trail.follow(time, [region_at(tactile_map, points[2])], tactile_map)
    assert len(trail.tail.age) == 1


@pytest.fixture
def builder(tactile_map):
    made = TaskOverlayBuilder()
    made.show_map(tactile_map)
    return made


def middle(tactile_map, patch=0):
    return tactile_map.boxes[patch].mean(axis=0)


def along(tactile_map, *, kind="polyline"):
    """A path over the left leaf, and on to the right one."""
    here = middle(tactile_map)
    there = middle(tactile_map, 1)
    points = (tuple(here - [0.04, 0.0]), tuple(here), tuple(there))
    return ControlSettings(controller="hybrid", task="follow_path", path_kind=kind, path=points)


def frame(tactile_map, *, time=0.0, taxels=(40,), task=None, ids=(7,)):
    made = touched(tactile_map, taxels, time=time)
    return replace(made, regions=tuple(replace(r, id=i) for r, i in zip(made.regions, ids, strict=True)), task=task)


def test_controller_without_a_task_has_no_overlay(builder, tactile_map):
    builder.show_settings(replace(along(tactile_map), controller="impedance"))
    builder.show_frame(frame(tactile_map))
    assert builder.shown is NO_TASK
    assert not builder.shown


def test_drawn_path_is_shown_at_once_with_the_target_at_its_start(builder, tactile_map):
    builder.show_settings(along(tactile_map))
    shown = builder.shown
    assert [line.patch for line in shown.path.lines] == [0, 1]
    ((leaves, enters),) = shown.path.crossings
    np.testing.assert_allclose(leaves, shown.path.lines[0].on_map[-1], atol=1e-4)
    np.testing.assert_allclose(enters, shown.path.lines[1].on_map[0], atol=1e-4)
    np.testing.assert_allclose(shown.path.lines[0].on_map[0], middle(tactile_map) - [0.04, 0.0], atol=1e-5)
    np.testing.assert_allclose(tactile_map.to_map(shown.target), middle(tactile_map) - [0.04, 0.0], atol=1e-5)


def test_lines_on_body_and_map_agree(builder, tactile_map):
    builder.show_settings(along(tactile_map, kind="spline"))
    for line in builder.shown.path.lines:
        at = [tactile_map.to_body(point) for point in line.on_map[1:-1]]
        places = np.array([tactile_map.skin.position(one) for one in at])
        np.testing.assert_allclose(line.on_body[1:-1], places, atol=1e-9)
        np.testing.assert_allclose(np.linalg.norm(line.normals, axis=1), 1.0)
        assert np.linalg.norm(np.diff(line.on_body, axis=0), axis=1).max() < 0.005


def test_default_path_is_placed_by_the_controller(builder, tactile_map):
    builder.show_settings(replace(along(tactile_map), path=()))
    assert not builder.shown.path
    builder.show_frame(frame(tactile_map, task=TaskReport(laid_at=tuple(middle(tactile_map)))))
    (line,) = builder.shown.path.lines
    np.testing.assert_allclose(line.on_map[0], middle(tactile_map) - [0.015, 0.0], atol=1e-5)
    np.testing.assert_allclose(line.on_map[-1], middle(tactile_map) + [0.015, 0.0], atol=1e-5)


def test_target_and_goal_come_from_the_report(builder, tactile_map):
    target = tactile_map.skin.taxel_point(60)
    builder.show_settings(along(tactile_map))
    builder.show_frame(frame(tactile_map, task=TaskReport(target=target, force_goal=2.5)))
    assert builder.shown.target == target
    assert (builder.shown.goal, builder.shown.contact) == (2.5, 7)
    path = builder.shown.path
    own, other = (region_at(tactile_map, middle(tactile_map), number=number, force=1.84) for number in (7, 8))
    assert builder.shown.force_words(own, ReadingUnits.CALIBRATED) == "1.8 of 2.5\u202fN"
    assert builder.shown.force_words(other, ReadingUnits.CALIBRATED) == "1.8\u202fN"
    assert builder.shown.force_words(other, ReadingUnits.COUNTS) == "10\u202fcounts"
    builder.show_frame(frame(tactile_map, task=TaskReport(force_goal=2.5, controlled=(7, 8))))
    assert builder.shown.force_words(other, ReadingUnits.CALIBRATED) == "1.8 of 2.5\u202fN"
    assert builder.shown.path is path


def test_new_path_moves_the_target_at_once(builder, tactile_map):
    builder.show_settings(along(tactile_map))
    builder.show_frame(frame(tactile_map, task=TaskReport(target=tactile_map.skin.taxel_point(60))))
    other = along(tactile_map)
    start = middle(tactile_map) + [0.01, 0.02]
    for settings in (other, replace(other, task="hold_point")):
        builder.show_settings(replace(settings, path=(tuple(start), *other.path[1:])))
        np.testing.assert_allclose(tactile_map.to_map(builder.shown.target), start, atol=1e-5)


def test_unchanged_overlay_is_the_same_object(builder, tactile_map):
    report = TaskReport(target=tactile_map.skin.taxel_point(60), force_goal=2.5)
    builder.show_settings(along(tactile_map))
    builder.show_frame(frame(tactile_map, task=report))
    shown = builder.shown
    builder.show_frame(frame(tactile_map, time=0.1, task=replace(report, way=0.01, energy=0.1)))
    builder.show_settings(replace(along(tactile_map), force_gain=0.02))
    builder.show_map(tactile_map)
    assert builder.shown is shown


def test_contact_path_ends_with_the_task(builder, tactile_map):
    builder.show_settings(along(tactile_map))
    for step, taxel in enumerate((40, 41, 42)):
        builder.show_frame(frame(tactile_map, time=0.1 * step, taxels=(taxel,), task=TaskReport()))
    assert len(builder.shown.tail.age) == 3
    builder.show_settings(replace(along(tactile_map), controller="hold_force"))
    builder.show_frame(frame(tactile_map, time=0.3, taxels=(43,)))
    assert builder.shown is NO_TASK
    builder.show_settings(along(tactile_map))
    builder.show_frame(frame(tactile_map, time=0.4, taxels=(43,), task=TaskReport()))
    assert len(builder.shown.tail.age) == 1


def test_edited_map_keeps_path_on_map_and_target_on_skin(builder, tactile_map):
    target = tactile_map.skin.taxel_point(60)
    builder.show_settings(along(tactile_map))
    builder.show_frame(frame(tactile_map, task=TaskReport(target=target)))
    before = builder.shown.path.lines[0]
    builder.show_map(shifted(tactile_map, (0.005, 0.0)))
    after = builder.shown.path.lines[0]
    np.testing.assert_allclose(after.on_map[0], before.on_map[0], atol=1e-5)
    assert np.linalg.norm(after.on_body[0] - before.on_body[0]) == pytest.approx(0.005, abs=1e-4)
    assert builder.shown.target == target


def test_compared_layout_has_target_and_contact_path_only(builder, tactile_map):
    target = tactile_map.skin.taxel_point(60)
    builder.show_settings(along(tactile_map))
    for step, taxel in enumerate((40, 41)):
        report = TaskReport(target=target)
        builder.show_frame(frame(tactile_map, time=0.1 * step, taxels=(taxel,), task=report))
    other = shifted(tactile_map, (0.2, 0.1))
    way = builder.shown.tail.on_map
    builder.show_map(other, led=False)
    assert not builder.shown.path
    assert builder.shown.target == target
    np.testing.assert_allclose(builder.shown.tail.on_map, way + [0.2, 0.1])
    builder.show_map(tactile_map)
    assert builder.shown.path


def test_another_skin_has_no_contact_path(builder, tactile_map):
    builder.show_settings(along(tactile_map))
    builder.show_frame(frame(tactile_map, task=TaskReport(target=tactile_map.skin.taxel_point(60))))
    other = leaf_map()
    builder.show_map(other)
    assert len(builder.shown.tail.age) == 0
    assert builder.shown.target != tactile_map.skin.taxel_point(60)


def test_lines_off_the_skin_are_not_drawn(tactile_map):
    low, high = tactile_map.boxes[0]
    through = np.array([[low[0] - 0.05, middle(tactile_map)[1]], [high[0] + 0.01, middle(tactile_map)[1]]])
    (line,) = lines_on_skin(through, tactile_map)
    assert line.patch == 0
    assert line.on_map[0, 0] == pytest.approx(low[0], abs=0.01)
    assert lines_on_skin(through + [0.0, 5.0], tactile_map) == ()
