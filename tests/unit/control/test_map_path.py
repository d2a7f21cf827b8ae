"""Paths on the map: their shape and their length."""

from __future__ import annotations

import numpy as np
import pytest

from app.control.map_path import RASTER_STEP, MapPath, draw_path, path_about
from app.control.settings_check import CHOICES
from app.errors import MapError

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
    with pytest.raises(MapError, match="too far out"):
        draw_path("spline", [[0.0, 0.0], [1e300, 0.0]])
