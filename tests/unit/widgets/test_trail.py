"""The way of a contact: one contact is followed, it ages, fades, and breaks where it is no line on the map."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.contacts.region import ContactRegion
from tests.widgets.hand_made import leaf_map, shifted
from widgets.task_shown import TAIL_SECONDS
from widgets.trail import Trail

LEFT, RIGHT = 0, 1


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
    trail = trail or Trail()
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
    np.testing.assert_allclose(tail.age, np.linspace(1.0, 0.0, 11) / TAIL_SECONDS, atol=1e-9)
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
    points, other = line(tactile_map), tactile_map.boxes[RIGHT].mean(axis=0)
    trail = Trail()
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
    assert trail.tail.age[-1] == pytest.approx(0.2 / TAIL_SECONDS)


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
