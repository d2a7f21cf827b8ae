"""Paths: their shape, their length, and how they lie on the skin."""

from __future__ import annotations

import numpy as np
import pytest

from app.control.map_path import RASTER_STEP, LaidPath, MapPath, draw_path, path_about
from app.control.settings_check import CHOICES
from app.errors import MapError
from app.maps.glue import Gluing
from tests.touch import arm, prepared_bar

CORNERS = np.array([[0.0, 0.0], [0.03, 0.0], [0.03, 0.04]])


def test_a_polyline_is_walked_by_its_length():
    path = draw_path("polyline", CORNERS)
    assert path.length == pytest.approx(0.07)
    point, direction = path.at(0.05)
    assert point == pytest.approx([0.03, 0.02])
    assert direction == pytest.approx([0, 1])
    assert path.at(-1.0)[0] == pytest.approx(CORNERS[0])
    assert path.at(0.08)[0] == pytest.approx(CORNERS[-1])
    assert not path.at(0.08)[1].any()
    assert not path.closed


def test_points_that_repeat_are_left_out():
    path = MapPath(np.repeat(CORNERS, 3, axis=0))
    assert len(path.points) == 3
    assert path.length == pytest.approx(0.07)


@pytest.mark.parametrize("kind", CHOICES["path_kind"])
def test_every_kind_is_walked_at_even_speed(kind):
    path = draw_path(kind, CORNERS)
    ways = np.linspace(0, path.length, 500, endpoint=False)
    points = np.array([path.at(way)[0] for way in ways])
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    assert steps.max() <= ways[1] * (1 + 1e-9)
    assert np.median(steps) == pytest.approx(ways[1], rel=1e-3)
    assert np.isfinite(points).all()


def test_a_spline_goes_through_its_points_and_closes_smoothly():
    path = draw_path("spline", CORNERS)
    for corner in CORNERS:
        assert np.linalg.norm(path.points - corner, axis=1).min() < 1e-3
    ring = draw_path("spline", [*CORNERS, CORNERS[0]])
    assert ring.closed
    before, after = ring.at(ring.length * (1 - 1e-6))[1], ring.at(0.0)[1]
    assert before @ after > 0.99


def test_a_figure_of_eight_starts_in_its_middle_crosses_it_and_closes():
    path = draw_path("lemniscate", [[-0.02, 0.0], [0.02, 0.0]])
    assert path.closed
    assert path.points.max(axis=0) == pytest.approx([0.02, 0.01], rel=1e-2)
    assert path.at(0.0)[0] == pytest.approx([0, 0], abs=1e-9)
    assert path.at(path.length / 2)[0] == pytest.approx([0, 0], abs=1e-3)


def test_a_raster_leaves_no_gap_and_never_jumps():
    path = draw_path("raster", [[0.03, 0.04], [0.0, 0.0]])
    rows = np.unique(path.points[:, 1])
    assert np.diff(rows).max() <= RASTER_STEP
    assert np.ptp(path.points, axis=0) == pytest.approx([0.03, 0.04])
    assert np.linalg.norm(np.diff(path.points, axis=0), axis=1).max() <= 0.03 + 1e-12


@pytest.mark.parametrize("kind", CHOICES["path_kind"])
def test_one_is_laid_about_a_place(kind):
    path = path_about(kind, np.array([0.5, 0.2]), 0.03)
    assert np.ptp(path.points, axis=0).max() == pytest.approx(0.03, rel=0.02)
    middle = (path.points.max(axis=0) + path.points.min(axis=0)) / 2
    assert middle == pytest.approx([0.5, 0.2], abs=1e-3)


@pytest.mark.parametrize("bad", [[], [[0.0, 0.0]], [[0.0, 0.0], [np.nan, 0.0]], [[0.0, 0.0], [np.inf, 1.0]]])
def test_what_is_no_path_is_refused(bad):
    with pytest.raises(MapError, match="path needs"):
        draw_path("polyline", bad)


def test_a_point_alone_is_a_path_without_direction():
    laid = LaidPath(MapPath(prepared_bar().map.taxel_points[3]), Gluing(prepared_bar().map))
    assert laid.length == 0
    assert not laid.closed
    assert laid.at(0.0)[0] == prepared_bar().map.to_body(prepared_bar().map.taxel_points[3])
    assert not laid.at(0.0)[1].any()


def test_a_path_on_the_skin_is_where_it_is_drawn():
    map_ = prepared_bar().map
    ends = map_.taxel_points[[3, 40]]
    path = draw_path("polyline", ends)
    laid = LaidPath(path, Gluing(map_))
    assert laid.whole
    assert laid.length == pytest.approx(path.length)
    for way in np.linspace(0, laid.length, 20, endpoint=False):
        assert map_.to_map(laid.at(way)[0]) == pytest.approx(path.at(way)[0], abs=1e-9)


def test_a_path_off_the_skin_ends_where_the_skin_does_and_says_so():
    map_ = prepared_bar().map
    inside = map_.taxel_points[20]
    laid = LaidPath(draw_path("polyline", [inside, inside + [2.0, 0.0]]), Gluing(map_))
    assert not laid.whole
    assert 0 < laid.length < 0.5
    assert map_.to_map(laid.at(1.0)[0])[0] == pytest.approx(map_.bounds[1, 0], abs=1e-6)
    with pytest.raises(MapError, match="does not start on the skin"):
        LaidPath(draw_path("polyline", [inside + [9.0, 0.0], inside]), Gluing(map_))


def test_over_a_seam_it_goes_on_without_a_jump_on_the_body():
    map_ = arm().map
    patch = next(k for k, seam in enumerate(map_.seams) if len(seam))
    seam = map_.seams[patch]
    middle, along = seam[len(seam) // 2].mean(axis=0), seam[len(seam) // 2][1] - seam[len(seam) // 2][0]
    across = np.array([along[1], -along[0]]) / np.linalg.norm(along)
    sides = [middle + s * 0.01 * across for s in (1, -1)]
    start, end = sides if map_.to_body(sides[0]) is not None else sides[::-1]
    laid = LaidPath(draw_path("polyline", [start, start + 2 * (end - start)]), Gluing(map_))
    assert len(laid._pieces) >= 2, "it must cross the seam"
    skin = map_.skin
    body = np.array([skin.position(laid.at(way)[0]) for way in np.linspace(0, laid.length, 200, endpoint=False)])
    assert np.linalg.norm(np.diff(body, axis=0), axis=1).max() < 5 * laid.length / 200
