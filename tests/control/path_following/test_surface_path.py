"""Paths on the skin: the projection of paths drawn on the map."""

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

PLATES = SeamTransitions(two_plates())
BAR = SeamTransitions(prepared_bar().map)


def projected(*points, kind="polyline", transitions=PLATES, drawn=True) -> SurfacePath:
    return SurfacePath(draw_path(kind, points), transitions, drawn=drawn)


def test_path_on_the_skin_is_where_it_is_drawn():
    map_ = BAR.map
    drawn = draw_path("polyline", map_.taxel_points[[3, 40]])
    path = SurfacePath(drawn, BAR)
    assert path.whole
    assert path.length == pytest.approx(drawn.length)
    for way in np.linspace(0, path.length, 20, endpoint=False):
        assert map_.to_map(path.at(way)[0]) == pytest.approx(drawn.at(way)[0], abs=1e-9)
    point = SurfacePath(MapPath(map_.taxel_points[3]), BAR)
    at, direction = point.at(0.0)
    assert (point.length, point.closed, direction.any()) == (0, False, False)
    assert map_.to_map(at) == pytest.approx(map_.taxel_points[3])


def test_path_off_the_skin_ends_at_the_border_and_one_that_starts_there_raises():
    inside = BAR.map.taxel_points[20]
    path = projected(inside, inside + [2.0, 0.0], transitions=BAR)
    assert not path.whole
    assert 0 < path.length < 0.5
    assert BAR.map.to_map(path.at(1.0)[0])[0] == pytest.approx(BAR.map.bounds[1, 0], abs=1e-6)
    with pytest.raises(MapError, match="does not start on the skin"):
        projected(inside + [9.0, 0.0], inside, transitions=BAR)


def over_a_seam(distance=0.01):
    """Seam transitions of the arm; a point on one side of a seam, and one as far beyond it as drawn, off the patch."""
    map_ = arm().map
    patch = next(k for k, seam in enumerate(map_.seams) if len(seam))
    edge = map_.seams[patch][len(map_.seams[patch]) // 2]
    along = edge[1] - edge[0]
    across = distance * np.array([along[1], -along[0]]) / np.linalg.norm(along)
    if map_.to_body(edge.mean(axis=0) + 0.1 * across) is None:
        across = -across
    return SeamTransitions(map_), edge.mean(axis=0) + across, edge.mean(axis=0) - across


def test_path_over_a_seam_continues_without_a_jump_on_the_body():
    transitions, inside, outside = over_a_seam()
    path = projected(inside, inside + 2 * (outside - inside), transitions=transitions)
    assert len(path._pieces) >= 2, "it must cross the seam"
    ways = np.linspace(0, path.length, 200, endpoint=False)
    body = np.array([transitions.map.skin.position(path.at(way)[0]) for way in ways])
    assert np.linalg.norm(np.diff(body, axis=0), axis=1).max() < 5 * path.length / 200


def test_loop_over_a_seam_returns_to_where_it_was_drawn():
    transitions, inside, outside = over_a_seam()
    across = inside - outside
    side = 0.3 * np.array([across[1], -across[0]])
    path = projected(inside, outside, outside + side, inside + side, transitions=transitions)
    assert path.whole
    assert path.crossings == ()
    assert path.length == pytest.approx(2 * np.linalg.norm(across) + np.linalg.norm(side), rel=0.15)
    assert len(path.points_on_map) >= 3, "here, behind the seam, and here again"


def test_path_over_a_seam_into_another_patch_crosses():
    transitions, inside, outside = over_a_seam()
    map_ = transitions.map
    patch = map_.to_body(inside).patch
    other = map_.taxel_points[int(map_.skin.first[(patch + 1) % 3]) + 5]
    path = projected(inside, outside, other, transitions=transitions)
    assert path.whole
    assert path.crossings
    assert path.at(path.length * (1 - 1e-9))[0].patch != patch
    assert path.points_on_map[-1][-1] == pytest.approx(other, abs=1e-6)


def test_path_drawn_from_patch_to_patch_crosses_the_base():
    path = projected((0.05, 0.05), (0.20, 0.05))
    assert path.whole
    assert path.length == pytest.approx(0.05 + 0.08), "the base between them has no length"
    [crossing] = path.crossings
    assert crossing.way == pytest.approx(0.05)
    assert PLATES.map.skin.position(crossing.leaves) == pytest.approx([0.10, 0.05, 0], abs=1e-6)
    assert PLATES.map.skin.position(crossing.enters) == pytest.approx([0.14, 0.05, 0], abs=1e-6)
    assert [path.piece(way) for way in (0.0, 0.0499, 0.0501, 0.12)] == [0, 0, 1, 1]
    assert [x for line in path.points_on_map for x in line[[0, -1], 0]] == pytest.approx([0.05, 0.10, 0.12, 0.20])


@pytest.mark.parametrize(
    ("points", "how", "length", "whole", "crossings"),
    [
        ([(0.05, 0.05), (0.20, 0.05)], {"drawn": False}, 0.05, False, []),
        ([(0.05, 0.05), (0.05, -0.01), (0.06, -0.01), (0.06, 0.05)], {}, 0.10, True, []),
        ([(0.02, 0.05), (0.02, -0.01), (0.08, -0.01), (0.08, 0.05)], {}, 0.10, True, [0.05]),
        ([(0.05, 0.02), (0.115, 0.06)], {"kind": "raster"}, 6 * 0.05 + 2 * 0.008, True, []),
    ],
    ids=["default paths never cross", "straight over nearby", "crosses far along the border", "larger than the patch"],
)
def test_path_that_leaves_its_patch_has_the_expected_crossings_and_length(points, how, length, whole, crossings):
    path = projected(*points, **how)
    assert path.whole == whole
    assert [crossing.way for crossing in path.crossings] == pytest.approx(crossings)
    assert path.length == pytest.approx(length, abs=0.01)


@pytest.mark.sampled(5)
@pytest.mark.parametrize("kind", ["polyline", "spline", "lemniscate", "raster"])
@pytest.mark.parametrize("drawn", [True, False])
@pytest.mark.parametrize("size", [1e-6, 0.01, 0.1, 1.0, 50.0])
def test_every_point_of_a_path_is_on_the_skin_and_its_lines(kind, drawn, size):
    map_ = arm().map
    start = map_.taxel_points[100]
    points = start + size * np.array([[-1.0, 0.0], [1.0, 0.1], [0.3, 0.4], [-0.2, 1.0]])
    corner = {"lemniscate": points[:2].mean(axis=0), "raster": points.min(axis=0)}.get(kind, points[0])
    points = points - corner + start
    path = projected(*points, kind=kind, transitions=SeamTransitions(map_), drawn=drawn)
    lines = path.points_on_map
    length = sum(np.linalg.norm(np.diff(line, axis=0), axis=1).sum() for line in lines)
    assert length == pytest.approx(path.length, rel=1e-4)
    low = np.concatenate(lines).min(axis=0) - 1e-6
    high = np.concatenate(lines).max(axis=0) + 1e-6
    for way in np.random.default_rng(0).uniform(0, path.length, 30):
        at, direction = path.at(way)
        assert np.linalg.norm(direction) == pytest.approx(1.0)
        point = map_.to_map(at)
        assert ((point >= low) & (point <= high)).all()
        assert np.linalg.norm(map_.skin.position(map_.to_body(point)) - map_.skin.position(at)) < 1e-6
    if size <= 0.01 and kind == "polyline":
        assert path.length == pytest.approx(draw_path(kind, points).length)


def test_nearest_point_is_in_the_patch_of_the_place():
    path = projected((0.05, 0.05), (0.20, 0.05))
    near = [path.nearest(PLATES.map.to_body(np.array(point))) for point in ((0.07, 0.09), (0.13, 0.01), (0.219, 0.05))]
    assert near == pytest.approx([0.02, 0.06, path.length])
    assert near[2] < path.length
    assert projected((0.05, 0.05), (0.06, 0.05)).nearest(PLATES.map.to_body(np.array([0.13, 0.01]))) is None


@pytest.mark.parametrize(("shift", "drawn", "closed"), [(0.0, True, True), (0.04, True, True), (0.04, False, False)])
def test_path_is_closed_if_it_returns_to_its_start_on_the_body(shift, drawn, closed):
    ring = [(x + shift, y) for x, y in ((0.02, 0.02), (0.08, 0.02), (0.08, 0.08), (0.02, 0.02))]
    assert projected(*ring, drawn=drawn).closed == closed


def test_active_path_is_the_drawn_one_or_a_default_one_about_a_place():
    follow = ControlSettings(controller="hybrid", task="follow_path", path_size=0.02)
    about = active_path(follow, TaskReport(laid_at=(0.05, 0.05)), PLATES)
    assert about.points_on_map[0].mean(axis=0) == pytest.approx([0.05, 0.05], abs=1e-3)
    one = project_path(replace(follow, path=((0.05, 0.05),)), np.zeros(2), PLATES)
    assert one.length == pytest.approx(about.length), "a single drawn point is the centre"
    drawn = replace(follow, path_kind="polyline", path=((0.05, 0.05), (0.20, 0.05)))
    off = replace(drawn, path=((9.0, 9.0), (0.05, 0.05)))
    assert len(active_path(drawn, TaskReport(), PLATES).crossings) == 1
    for settings, report in (
        (follow, None),
        (follow, TaskReport()),  # nothing touched yet
        (replace(drawn, task="hold_point"), TaskReport()),
        (off, TaskReport()),
    ):
        assert active_path(settings, report, PLATES) is None
    with pytest.raises(MapError, match=r"does not start on the skin, but at \(9000, 9000\) mm"):
        project_path(off, np.zeros(2), PLATES)
