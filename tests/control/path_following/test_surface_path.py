"""Paths on the skin: where what is drawn on the map lies on the body."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.control.motion.command import ControlSettings, TaskReport
from tactile_maps.control.path_following.surface_path import SurfacePath, active_path, project_path
from tactile_maps.core.errors import MapError
from tactile_maps.maps.model.seam_transitions import SeamTransitions
from tactile_maps.maps.paths import MapPath, draw_path
from tests.support.touch import arm, prepared_bar
from tests.support.two_plates import two_plates

MAP = two_plates()
TRANSITIONS = SeamTransitions(MAP)


def laid(*points, kind="polyline", transitions=TRANSITIONS, drawn=True) -> SurfacePath:
    return SurfacePath(draw_path(kind, points), transitions, drawn=drawn)


def test_a_point_alone_is_a_path_without_direction():
    map_ = prepared_bar().map
    path_laid = SurfacePath(MapPath(map_.taxel_points[3]), SeamTransitions(map_))
    assert path_laid.length == 0
    assert not path_laid.closed
    assert map_.to_map(path_laid.at(0.0)[0]) == pytest.approx(map_.taxel_points[3])
    assert not path_laid.at(0.0)[1].any()


def test_a_path_on_the_skin_is_where_it_is_drawn():
    map_ = prepared_bar().map
    ends = map_.taxel_points[[3, 40]]
    path = draw_path("polyline", ends)
    path_laid = SurfacePath(path, SeamTransitions(map_))
    assert path_laid.whole
    assert path_laid.length == pytest.approx(path.length)
    for way in np.linspace(0, path_laid.length, 20, endpoint=False):
        assert map_.to_map(path_laid.at(way)[0]) == pytest.approx(path.at(way)[0], abs=1e-9)


def test_a_path_off_the_skin_ends_where_the_skin_does_and_says_so():
    map_ = prepared_bar().map
    inside = map_.taxel_points[20]
    path_laid = SurfacePath(draw_path("polyline", [inside, inside + [2.0, 0.0]]), SeamTransitions(map_))
    assert not path_laid.whole
    assert 0 < path_laid.length < 0.5
    assert map_.to_map(path_laid.at(1.0)[0])[0] == pytest.approx(map_.bounds[1, 0], abs=1e-6)
    with pytest.raises(MapError, match="does not start on the skin"):
        SurfacePath(draw_path("polyline", [inside + [9.0, 0.0], inside]), SeamTransitions(map_))


def test_over_a_seam_it_goes_on_without_a_jump_on_the_body():
    map_ = arm().map
    patch = next(k for k, seam in enumerate(map_.seams) if len(seam))
    seam = map_.seams[patch]
    middle = seam[len(seam) // 2].mean(axis=0)
    along = seam[len(seam) // 2][1] - seam[len(seam) // 2][0]
    across = np.array([along[1], -along[0]]) / np.linalg.norm(along)
    sides = [middle + s * 0.01 * across for s in (1, -1)]
    start, end = sides if map_.to_body(sides[0]) is not None else sides[::-1]
    path_laid = SurfacePath(draw_path("polyline", [start, start + 2 * (end - start)]), SeamTransitions(map_))
    assert len(path_laid._pieces) >= 2, "it must cross the seam"
    skin = map_.skin
    body = np.array(
        [skin.position(path_laid.at(way)[0]) for way in np.linspace(0, path_laid.length, 200, endpoint=False)]
    )
    assert np.linalg.norm(np.diff(body, axis=0), axis=1).max() < 5 * path_laid.length / 200


def over_a_seam(map_, *, before=0.01, after=0.01):
    """Two points: on one side of a seam of our arm, and as far beyond it as drawn, off the patch."""
    patch = next(k for k, seam in enumerate(map_.seams) if len(seam))
    seam = map_.seams[patch]
    middle = seam[len(seam) // 2].mean(axis=0)
    along = seam[len(seam) // 2][1] - seam[len(seam) // 2][0]
    across = np.array([along[1], -along[0]]) / np.linalg.norm(along)
    if map_.to_body(middle + 1e-3 * across) is None:
        across = -across
    return middle + before * across, middle - after * across


def test_a_path_drawn_from_patch_to_patch_crosses_the_ground():
    path = laid((0.05, 0.05), (0.20, 0.05))
    assert path.whole
    assert path.length == pytest.approx(0.05 + 0.08), "the ground between counts nothing"
    [crossing] = path.crossings
    assert crossing.way == pytest.approx(0.05)
    assert MAP.skin.position(crossing.leaves) == pytest.approx([0.10, 0.05, 0], abs=1e-6)
    assert MAP.skin.position(crossing.enters) == pytest.approx([0.14, 0.05, 0], abs=1e-6)
    assert [path.piece(way) for way in (0.0, 0.0499, 0.0501, 0.12)] == [0, 0, 1, 1]
    assert [line.shape[1] for line in path.points_on_map] == [2, 2]
    assert [x for line in path.points_on_map for x in line[[0, -1], 0]] == pytest.approx([0.05, 0.10, 0.12, 0.20])
    assert [line.link for line in path.points_on_body] == ["bar", "bar"]
    assert path.points_on_body[1].points[[0, -1], 0] == pytest.approx([0.14, 0.22], abs=1e-5)


def test_a_path_that_nobody_drew_never_crosses():
    path = laid((0.05, 0.05), (0.20, 0.05), drawn=False)
    assert (path.length, path.whole, path.crossings) == (pytest.approx(0.05), False, ())


def test_a_path_that_looks_out_of_a_patch_and_comes_in_near_by_goes_straight_over():
    path = laid((0.05, 0.05), (0.05, -0.01), (0.06, -0.01), (0.06, 0.05))
    assert path.whole
    assert path.crossings == ()
    assert path.length == pytest.approx(0.10)


def test_far_along_the_border_it_crosses():
    path = laid((0.02, 0.05), (0.02, -0.01), (0.08, -0.01), (0.08, 0.05))
    assert [crossing.way for crossing in path.crossings] == pytest.approx([0.05])


def test_a_raster_larger_than_the_patch_is_what_of_it_is_inside():
    path = laid((0.05, 0.02), (0.115, 0.06), kind="raster")
    assert path.whole
    assert path.crossings == (), "from line to line it is near"
    assert path.length == pytest.approx(6 * 0.05 + 2 * 0.008, abs=0.01)


def test_what_lies_behind_a_seam_is_laid_there_and_comes_back():
    """A loop over a seam: out, along behind it, and in again where it was drawn."""
    map_ = arm().map
    transitions = SeamTransitions(arm().map)
    inside, outside = over_a_seam(map_)
    across = inside - outside
    side = 0.3 * np.array([across[1], -across[0]])
    path = laid(inside, outside, outside + side, inside + side, transitions=transitions)
    assert path.whole
    assert path.crossings == ()
    assert path.length == pytest.approx(2 * np.linalg.norm(across) + np.linalg.norm(side), rel=0.15)
    assert len(path.points_on_map) >= 3, "here, behind the seam, and here again"
    [line] = path.points_on_body
    assert np.linalg.norm(np.diff(line.points, axis=0), axis=1).max() < 0.012


def test_over_a_seam_into_another_patch_it_crosses():
    map_ = arm().map
    transitions = SeamTransitions(arm().map)
    inside, outside = over_a_seam(map_)
    patch = map_.to_body(inside).patch
    other = map_.taxel_points[int(map_.skin.first[(patch + 1) % 3]) + 5]
    path = laid(inside, outside, other, transitions=transitions)
    assert path.whole
    assert path.crossings, "it comes in elsewhere"
    assert path.at(path.length * (1 - 1e-9))[0].patch != patch
    assert path.points_on_map[-1][-1] == pytest.approx(other, abs=1e-6)


@pytest.mark.parametrize("kind", ["polyline", "spline", "lemniscate", "raster"])
@pytest.mark.parametrize("drawn", [True, False])
@pytest.mark.parametrize("size", [1e-6, 0.01, 0.1, 1.0, 50.0])
def test_every_point_of_a_path_lies_on_the_skin_where_its_lines_say(kind, drawn, size):
    map_ = arm().map
    transitions = SeamTransitions(arm().map)
    start = map_.taxel_points[100]
    points = start + size * np.array([[-1.0, 0.0], [1.0, 0.1], [0.3, 0.4], [-0.2, 1.0]])
    corner = {"lemniscate": points[:2].mean(axis=0), "raster": points.min(axis=0)}.get(kind, points[0])
    points = points - corner + start
    path = laid(*points, kind=kind, transitions=transitions, drawn=drawn)
    lines = np.concatenate(path.points_on_map)
    assert sum(np.linalg.norm(np.diff(line, axis=0), axis=1).sum() for line in path.points_on_map) == pytest.approx(
        path.length, rel=1e-4
    )
    low = lines.min(axis=0) - 1e-6
    high = lines.max(axis=0) + 1e-6
    for way in np.random.default_rng(0).uniform(0, path.length, 30):
        at, direction = path.at(way)
        assert np.linalg.norm(direction) == pytest.approx(1.0)
        point = map_.to_map(at)
        assert ((point >= low) & (point <= high)).all()
        again = map_.to_body(point)
        assert np.linalg.norm(map_.skin.position(again) - map_.skin.position(at)) < 1e-6
    if size <= 0.01 and kind == "polyline":
        assert path.length == pytest.approx(draw_path(kind, points).length)


def test_two_thousand_points_are_laid_in_a_moment():
    turn = np.linspace(0, 40, 2000)[:, None]
    spiral = 0.05 + 0.001 * turn * np.concatenate([np.cos(turn), np.sin(turn)], axis=1)
    path = laid(*spiral)
    assert path.whole
    assert path.length == pytest.approx(MapPath(spiral).length)


def test_the_nearest_point_is_that_in_the_patch():
    path = laid((0.05, 0.05), (0.20, 0.05))
    assert path.nearest(MAP.to_body(np.array([0.07, 0.09]))) == pytest.approx(0.02)
    assert path.nearest(MAP.to_body(np.array([0.13, 0.01]))) == pytest.approx(0.06)
    assert laid((0.05, 0.05), (0.06, 0.05)).nearest(MAP.to_body(np.array([0.13, 0.01]))) is None
    assert path.nearest(MAP.to_body(np.array([0.219, 0.05]))) < path.length


def test_a_path_is_closed_only_where_it_comes_back_on_the_body():
    ring = [(0.02, 0.02), (0.08, 0.02), (0.08, 0.08), (0.02, 0.02)]
    assert laid(*ring).closed
    assert laid(*[(x + 0.04, y) for x, y in ring]).closed, "outside it goes straight over or crosses, and comes back"
    assert not laid(*[(x + 0.04, y) for x, y in ring], drawn=False).closed


def test_the_path_in_force_is_drawn_or_laid_about_a_place():
    follow = ControlSettings(controller="hybrid", task="follow_path", path_size=0.02)
    assert active_path(follow, None, TRANSITIONS) is None
    assert active_path(follow, TaskReport(), TRANSITIONS) is None, "nothing touched yet"
    about = active_path(follow, TaskReport(laid_at=(0.05, 0.05)), TRANSITIONS)
    assert about.points_on_map[0].mean(axis=0) == pytest.approx([0.05, 0.05], abs=1e-3)
    drawn = replace(follow, path_kind="polyline", path=((0.05, 0.05), (0.20, 0.05)))
    assert len(active_path(drawn, TaskReport(), TRANSITIONS).crossings) == 1
    assert active_path(replace(drawn, task="hold_point"), TaskReport(), TRANSITIONS) is None
    assert active_path(replace(drawn, path=((9.0, 9.0), (0.05, 0.05))), TaskReport(), TRANSITIONS) is None
    with pytest.raises(MapError, match=r"does not start on the skin, but at \(9000, 9000\) mm"):
        project_path(replace(drawn, path=((9.0, 9.0), (0.05, 0.05))), np.zeros(2), TRANSITIONS)
    one = project_path(replace(follow, path=((0.05, 0.05),)), np.zeros(2), TRANSITIONS)
    assert one.length == pytest.approx(about.length), "one point drawn is what it is laid about"
