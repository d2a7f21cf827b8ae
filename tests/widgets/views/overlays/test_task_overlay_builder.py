"""How a task looks is put together from settings, frames and the map, and is the same object while it is the same; and
the contact's trail.
"""

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


def test_it_lies_where_the_contact_was_oldest_first(tactile_map):
    points = line(tactile_map)
    tail = walked(tactile_map, points).tail
    np.testing.assert_allclose(tail.on_map, points, atol=1e-12)
    np.testing.assert_allclose(tail.age, np.linspace(1.0, 0.0, 11) / TRAIL_SECONDS, atol=1e-9)
    assert tail.lines == [slice(0, 11)]
    skin = tactile_map.skin
    np.testing.assert_allclose(tail.on_body[3], skin.position(tactile_map.to_body(points[3])), atol=1e-12)


def test_what_is_too_old_is_forgotten(tactile_map):
    points = line(tactile_map, count=61)
    trail = walked(tactile_map, points)
    assert trail.tail.age.max() <= 1.0
    np.testing.assert_allclose(trail.tail.on_map[0], points[20], atol=1e-12)


def test_a_contact_that_rests_leaves_nothing_and_is_nothing_new(tactile_map):
    points = line(tactile_map)
    trail = walked(tactile_map, [points[5]] * 4)
    tail = trail.tail
    assert not tail.lines
    walked(tactile_map, [points[5]] * 4, trail=trail, start=0.4)
    assert trail.tail is tail


def test_a_contact_that_came_to_rest_is_drawn_until_its_way_has_faded(tactile_map):
    points = line(tactile_map)
    trail = walked(tactile_map, points)
    walked(tactile_map, [points[-1]] * 20, trail=trail, start=1.1)
    assert trail.tail.lines
    assert trail.tail.age[-1] == 0
    walked(tactile_map, [points[-1]] * 30, trail=trail, start=3.1)
    assert not trail.tail.lines


def test_the_contact_known_is_followed_though_another_presses_more(tactile_map):
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
    assert [part.stop - part.start for part in trail.tail.lines] == [2]


def test_another_contact_at_the_same_place_begins_a_line_of_its_own(tactile_map):
    points = line(tactile_map)
    trail = walked(tactile_map, points[:4])
    walked(tactile_map, points[4:8], trail=trail, start=0.4, number=2)
    assert trail.tail.lines == [slice(0, 4), slice(4, 8)]


def test_without_a_contact_the_way_stays_and_fades(tactile_map):
    trail = walked(tactile_map, line(tactile_map))
    trail.follow(1.2, [], tactile_map)
    assert trail.contact == 0
    assert trail.tail.lines
    assert trail.tail.age[-1] == pytest.approx(0.2 / TRAIL_SECONDS)


def test_over_a_seam_it_is_broken_though_the_body_is_not(tactile_map):
    """The right leaf laid elsewhere is what a map looks like that was cut between two places."""
    points = line(tactile_map)
    trail = walked(tactile_map, points[:5])
    near = region_at(tactile_map, points[5])
    far = replace(near, at=tactile_map.to_body(points[5] + [0.0, 0.05]))
    trail.follow(0.5, [far], tactile_map)
    assert trail.tail.lines == [slice(0, 5)]


@pytest.mark.parametrize("time", [0.3, 5.0], ids=["back", "far on"])
def test_a_jump_in_a_replay_begins_anew(tactile_map, time):
    points = line(tactile_map)
    trail = walked(tactile_map, points)
    trail.follow(time, [region_at(tactile_map, points[2])], tactile_map)
    assert len(trail.tail.age) == 1


def test_another_map_shows_the_same_places(tactile_map):
    points = line(tactile_map)
    trail = walked(tactile_map, points)
    moved = shifted(tactile_map, (0.5, 0.2))
    before = trail.tail
    trail.show_map(moved)
    np.testing.assert_allclose(trail.tail.on_map, points + [0.5, 0.2], atol=1e-12)
    np.testing.assert_array_equal(trail.tail.on_body, before.on_body)
    assert trail.tail.lines == before.lines


@pytest.fixture
def sight(tactile_map):
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


def test_a_law_without_a_task_shows_none(sight, tactile_map):
    sight.show_settings(replace(along(tactile_map), controller="impedance"))
    sight.show_frame(frame(tactile_map))
    assert sight.shown is NO_TASK
    assert not sight.shown


def test_a_drawn_path_is_seen_before_time_goes_on_and_the_target_where_it_begins(sight, tactile_map):
    sight.show_settings(along(tactile_map))
    shown = sight.shown
    assert [line.patch for line in shown.path.lines] == [0, 1]
    ((leaves, enters),) = shown.path.crossings
    np.testing.assert_allclose(leaves, shown.path.lines[0].on_map[-1], atol=1e-4)
    np.testing.assert_allclose(enters, shown.path.lines[1].on_map[0], atol=1e-4)
    np.testing.assert_allclose(shown.path.lines[0].on_map[0], middle(tactile_map) - [0.04, 0.0], atol=1e-5)
    np.testing.assert_allclose(tactile_map.to_map(shown.target), middle(tactile_map) - [0.04, 0.0], atol=1e-5)


def test_the_line_on_the_body_is_the_line_on_the_map(sight, tactile_map):
    sight.show_settings(along(tactile_map, kind="spline"))
    for line in sight.shown.path.lines:
        at = [tactile_map.to_body(point) for point in line.on_map[1:-1]]
        places = np.array([tactile_map.skin.position(one) for one in at])
        np.testing.assert_allclose(line.on_body[1:-1], places, atol=1e-9)
        np.testing.assert_allclose(np.linalg.norm(line.normals, axis=1), 1.0)
        assert np.linalg.norm(np.diff(line.on_body, axis=0), axis=1).max() < 0.005


def test_a_path_nobody_drew_lies_where_the_controller_says(sight, tactile_map):
    sight.show_settings(replace(along(tactile_map), path=()))
    assert not sight.shown.path
    sight.show_frame(frame(tactile_map, task=TaskReport(laid_at=tuple(middle(tactile_map)))))
    (line,) = sight.shown.path.lines
    np.testing.assert_allclose(line.on_map[0], middle(tactile_map) - [0.015, 0.0], atol=1e-5)
    np.testing.assert_allclose(line.on_map[-1], middle(tactile_map) + [0.015, 0.0], atol=1e-5)


def test_the_target_and_the_goal_are_the_report_s(sight, tactile_map):
    target = tactile_map.skin.taxel_point(60)
    sight.show_settings(along(tactile_map))
    sight.show_frame(frame(tactile_map, task=TaskReport(target=target, force_goal=2.5)))
    assert sight.shown.target == target
    assert (sight.shown.goal, sight.shown.contact) == (2.5, 7)
    own, other = (region_at(tactile_map, middle(tactile_map), number=number, force=1.84) for number in (7, 8))
    assert sight.shown.force_words(own, ReadingUnits.CALIBRATED) == "1.8 of 2.5\u202fN"
    assert sight.shown.force_words(other, ReadingUnits.CALIBRATED) == "1.8\u202fN"
    assert sight.shown.force_words(other, ReadingUnits.COUNTS) == "10\u202fcounts"


def test_every_controlled_contact_is_shown_next_to_the_goal(sight, tactile_map):
    sight.show_settings(along(tactile_map))
    words = {}
    for controlled in ((7, 8), (7,)):
        sight.show_frame(frame(tactile_map, task=TaskReport(force_goal=2.5, controlled=controlled)))
        regions = [region_at(tactile_map, middle(tactile_map), number=number, force=1.84) for number in (7, 8, 9)]
        words[controlled] = [sight.shown.force_words(region, ReadingUnits.CALIBRATED) for region in regions]
    assert words[7, 8] == ["1.8 of 2.5\u202fN", "1.8 of 2.5\u202fN", "1.8\u202fN"]
    assert words[7,] == ["1.8 of 2.5\u202fN", "1.8\u202fN", "1.8\u202fN"]


def test_a_held_point_moves_with_the_settings_though_time_stands_still(sight, tactile_map):
    held = ControlSettings(controller="qp", task="hold_point", path=(tuple(middle(tactile_map)),))
    sight.show_settings(held)
    sight.show_frame(frame(tactile_map, task=TaskReport(target=sight.shown.target)))
    there = middle(tactile_map) + [0.01, 0.02]
    sight.show_settings(replace(held, path=(tuple(there),)))
    np.testing.assert_allclose(tactile_map.to_map(sight.shown.target), there, atol=1e-9)


def test_another_path_s_target_is_its_start_before_time_goes_on(sight, tactile_map):
    sight.show_settings(along(tactile_map))
    sight.show_frame(frame(tactile_map, task=TaskReport(target=tactile_map.skin.taxel_point(60))))
    other = along(tactile_map)
    start = middle(tactile_map) + [0.01, 0.02]
    sight.show_settings(replace(other, path=(tuple(start), *other.path[1:])))
    np.testing.assert_allclose(tactile_map.to_map(sight.shown.target), start, atol=1e-5)


def test_nothing_new_is_the_same_object(sight, tactile_map):
    report = TaskReport(target=tactile_map.skin.taxel_point(60), force_goal=2.5)
    sight.show_settings(along(tactile_map))
    sight.show_frame(frame(tactile_map, task=report))
    shown = sight.shown
    sight.show_frame(frame(tactile_map, time=0.1, task=replace(report, way=0.01, energy=0.1)))
    sight.show_settings(replace(along(tactile_map), force_gain=0.02))
    sight.show_map(tactile_map)
    assert sight.shown is shown


def test_a_target_on_its_way_leaves_the_path_untouched(sight, tactile_map):
    sight.show_settings(along(tactile_map))
    path = sight.shown.path
    sight.show_frame(frame(tactile_map, task=TaskReport(target=tactile_map.skin.taxel_point(61))))
    assert sight.shown.path is path


def test_the_contact_s_way_is_kept_while_the_task_is_in_force_and_forgotten_after(sight, tactile_map):
    sight.show_settings(along(tactile_map))
    for step, taxel in enumerate((40, 41, 42)):
        sight.show_frame(frame(tactile_map, time=0.1 * step, taxels=(taxel,), task=TaskReport()))
    assert len(sight.shown.tail.age) == 3
    sight.show_settings(replace(along(tactile_map), controller="hold_force"))
    sight.show_frame(frame(tactile_map, time=0.3, taxels=(43,)))
    assert sight.shown is NO_TASK
    sight.show_settings(along(tactile_map))
    sight.show_frame(frame(tactile_map, time=0.4, taxels=(43,), task=TaskReport()))
    assert len(sight.shown.tail.age) == 1


def test_an_edited_map_has_the_path_where_it_was_drawn_and_the_target_on_the_skin(sight, tactile_map):
    target = tactile_map.skin.taxel_point(60)
    sight.show_settings(along(tactile_map))
    sight.show_frame(frame(tactile_map, task=TaskReport(target=target)))
    before = sight.shown.path.lines[0]
    sight.show_map(shifted(tactile_map, (0.005, 0.0)))
    after = sight.shown.path.lines[0]
    np.testing.assert_allclose(after.on_map[0], before.on_map[0], atol=1e-5)
    assert np.linalg.norm(after.on_body[0] - before.on_body[0]) == pytest.approx(0.005, abs=1e-4)
    assert sight.shown.target == target


def test_a_layout_to_compare_with_has_target_and_way_but_no_path(sight, tactile_map):
    target = tactile_map.skin.taxel_point(60)
    sight.show_settings(along(tactile_map))
    for step, taxel in enumerate((40, 41)):
        report = TaskReport(target=target)
        sight.show_frame(frame(tactile_map, time=0.1 * step, taxels=(taxel,), task=report))
    other = shifted(tactile_map, (0.2, 0.1))
    way = sight.shown.tail.on_map
    sight.show_map(other, led=False)
    assert not sight.shown.path
    assert sight.shown.target == target
    np.testing.assert_allclose(sight.shown.tail.on_map, way + [0.2, 0.1])
    sight.show_map(tactile_map)
    assert sight.shown.path


def test_another_skin_begins_with_nothing(sight, tactile_map):
    sight.show_settings(along(tactile_map))
    sight.show_frame(frame(tactile_map, task=TaskReport(target=tactile_map.skin.taxel_point(60))))
    other = leaf_map()
    sight.show_map(other)
    assert len(sight.shown.tail.age) == 0
    assert sight.shown.target != tactile_map.skin.taxel_point(60)


def test_what_lies_beside_the_skin_is_not_drawn(tactile_map):
    low, high = tactile_map.boxes[0]
    through = np.array([[low[0] - 0.05, middle(tactile_map)[1]], [high[0] + 0.01, middle(tactile_map)[1]]])
    (line,) = lines_on_skin(through, tactile_map)
    assert line.patch == 0
    assert line.on_map[0, 0] == pytest.approx(low[0], abs=0.01)
    assert lines_on_skin(through + [0.0, 5.0], tactile_map) == ()
