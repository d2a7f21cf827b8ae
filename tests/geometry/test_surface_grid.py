"""Straight walks and grids against surfaces whose straight lines are known: plane, cylinder, sphere."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.core.errors import MeshError
from tactile_maps.geometry.surface.closest_point import ClosestPoint
from tactile_maps.geometry.surface_grid import StraightWalks, surface_grid
from tests.support.surfaces import cap, frustum, sheet

RADIUS = 0.04
AROUND = 120
CYLINDER = frustum(RADIUS, RADIUS, length=0.2, around=AROUND, along=40)
UNROLLED = AROUND / np.pi * RADIUS * np.sin(np.pi / AROUND)
"""Radius [m] of the circle that is as long as the polygon around the cylinder."""
BALL = 0.05


def on_cylinder(turn, up):
    return np.array([RADIUS * np.cos(turn), RADIUS * np.sin(turn), up])


def unrolled(points):
    """(..., 2) places on the unrolled polygon around the cylinder."""
    side = 2 * np.pi / AROUND
    turn = np.unwrap(np.unwrap(np.arctan2(points[..., 1], points[..., 0]), axis=0), axis=1)
    whole = np.floor(turn / side)
    within = np.tan(turn - (whole + 0.5) * side) / np.tan(side / 2) / 2 + 0.5
    return np.stack([2 * RADIUS * np.sin(side / 2) * (whole + within), points[..., 2]], axis=-1)


def walkers(surface, point, direction):
    faces, weights, _ = ClosestPoint(surface).query(np.atleast_2d(point))
    walks = StraightWalks(surface)
    return walks, walks.start(faces, surface.points(faces, weights), np.atleast_2d(direction))


def test_straight_walk_is_a_helix_on_a_cylinder():
    walks, start = walkers(CYLINDER, on_cylinder(0.1, 0.03), [0.0, 1.0, 0.4])
    here = walks.go(start, np.array([0.1]))
    ends = unrolled(np.stack([start.points, here.points])[:, :, None])[:, 0, 0]
    assert np.linalg.norm(ends[1] - ends[0]) == pytest.approx(0.1, rel=1e-6)
    # The direction is levelled on a flat facet, which is off the tangent by a degree or two.
    assert here.points[0, 2] == pytest.approx(0.03 + 0.1 * 0.4 / np.hypot(1.0, 0.4), rel=3e-3)


def test_walk_along_a_great_circle_keeps_its_direction():
    ball = cap(1.4, rings=40, radius=BALL)
    walks, start = walkers(ball, [-0.03, 0.0, 0.04], [1.0, 0.0, 0.75])
    end = walks.go(start, np.array([0.06]))
    angle = np.arccos(end.points[0] @ start.points[0] / np.linalg.norm(end.points[0]) / np.linalg.norm(start.points[0]))
    assert angle * BALL == pytest.approx(0.06, rel=2e-3)
    assert abs(end.points[0, 1]) < 2e-4


def test_round_trip_returns_to_the_start():
    walks, start = walkers(CYLINDER, np.stack([on_cylinder(0.4, 0.05 + 0.01 * k) for k in range(5)]), np.ones((5, 3)))
    there = walks.go(start, np.linspace(0.0, 0.08, 5))
    back = walks.go(walks.turned(there, np.full(5, np.pi)), np.linspace(0.0, 0.08, 5))
    np.testing.assert_allclose(back.points, start.points, atol=1e-12)
    np.testing.assert_allclose(back.ahead, -start.ahead, atol=1e-9)


def test_walk_over_border_is_marked_and_continues_in_the_plane():
    walks, start = walkers(sheet(), [0.11, 0.04, 0], [1.0, 0.0, 0.0])
    end = walks.go(start, np.array([0.03]))
    assert not end.on.any()
    np.testing.assert_allclose(walks.go(end, np.array([0.01])).points, [[0.15, 0.04, 0]], atol=1e-12)


@pytest.mark.parametrize("mirrored", [False, True])
def test_grid_on_a_plane_is_regular(mirrored):
    first = np.array([0.03, 0.03, 0])
    last = np.array([0.08, 0.03, 0])
    grid = surface_grid(sheet(), first, last, 3, 5, mirrored=mirrored)
    assert grid.on.all()
    np.testing.assert_allclose(grid.points[[0, -1], [0, -1]], [first, last], atol=1e-6)
    np.testing.assert_allclose(grid.pitch, 0.05 / np.hypot(2, 4), rtol=1e-4)
    right = grid.points[0, 1] - grid.points[0, 0]
    up = grid.points[1, 0] - grid.points[0, 0]
    assert right @ up == pytest.approx(0, abs=1e-12)
    assert np.cross(right, up)[2] * (-1 if mirrored else 1) > 0
    whole = first + np.arange(3)[:, None, None] * up + np.arange(5)[:, None] * right
    np.testing.assert_allclose(grid.points, whole, atol=1e-6)


@pytest.mark.long
@pytest.mark.parametrize(
    ("first", "last", "rows", "columns", "aspect"),
    [
        ((0.0, 0.05), (1.2, 0.12), 8, 6, 1.0),
        ((-0.5, 0.05), (2.0, 0.15), 5, 12, 1.0),
        ((0.0, 0.05), (1.2, 0.12), 6, 6, 0.5),
        ((0.1, 0.05), (0.9, 0.12), 1, 7, 1.0),
    ],
)
def test_rows_and_columns_keep_their_distance_around_a_cylinder(first, last, rows, columns, aspect):
    first = on_cylinder(*first)
    last = on_cylinder(*last)
    grid = surface_grid(CYLINDER, first, last, rows, columns, aspect=aspect)
    assert grid.on.all()
    assert np.linalg.norm(grid.points[[0, -1], [0, -1]] - [first, last], axis=1).max() < 30e-6  # chord and grid
    flat = unrolled(grid.points)
    for axis in (0, 1):
        gaps = np.linalg.norm(np.diff(flat, axis=axis), axis=-1)
        np.testing.assert_allclose(gaps, grid.pitch[axis], rtol=1e-3)
    assert grid.pitch[1] == pytest.approx(aspect * grid.pitch[0])
    if rows > 1:
        across = (np.diff(flat, axis=0)[:, :-1] * np.diff(flat, axis=1)[:-1]).sum(axis=-1) / grid.pitch.prod()
        assert np.abs(across).max() < 1e-3


def test_columns_on_a_sphere_are_exact_and_rows_converge_like_great_circles():
    ball = cap(1.4, rings=40, radius=BALL)
    tip = np.array([0.45, 0.36, 1.0]) / np.linalg.norm([0.45, 0.36, 1.0]) * BALL
    grid = surface_grid(ball, tip * [-1, -1, 1], tip, 8, 10)
    normals = grid.points / np.linalg.norm(grid.points, axis=-1, keepdims=True)

    def arcs(a, b):
        return np.arccos(np.clip((a * b).sum(axis=-1), -1, 1)) * BALL

    np.testing.assert_allclose(arcs(normals[1:], normals[:-1]), grid.pitch[0], rtol=1e-3)
    aside = (np.arange(8) - 3.5) * grid.pitch[0] / BALL
    expected = BALL * np.arccos(1 - np.cos(aside) ** 2 * (1 - np.cos(grid.pitch[1] / BALL)))
    np.testing.assert_allclose(arcs(normals[:, 1:], normals[:, :-1]), np.tile(expected[:, None], 9), rtol=0.012)
    assert expected.min() < 0.95 * grid.pitch[1]
    assert np.linalg.norm(grid.points[-1, -1] - tip) < 30e-6


def test_points_beyond_a_sharp_edge_are_not_on_the_grid():
    def roof(x, y):
        return -5.0 * np.maximum(x - 0.08, 0)

    surface = sheet(24, 8, shape=roof)
    grid = surface_grid(surface, np.array([0.03, 0.03, 0]), np.array([0.084, 0.05, -0.02]), 4, 8)
    inner = grid.points[..., 2] > -1e-9
    assert not (grid.on & ~inner).any()
    assert (grid.on == inner).mean() > 0.9  # but for those right at the edge
    assert 0 < (~inner).sum() < 16
    over = surface_grid(sheet(), np.array([0.0, 0.0, 0]), np.array([0.12, 0.08, 0]), 4, 9)
    assert over.on[1, 4]
    assert not over.on[0, -1]


def test_corners_without_a_grid_are_rejected():
    point = np.array([0.03, 0.03, 0])
    with pytest.raises(MeshError, match="two different corners"):
        surface_grid(sheet(), point, point, 3, 3)
    with pytest.raises(MeshError, match="two different corners"):
        surface_grid(sheet(), point, point + 0.01, 1, 1)
