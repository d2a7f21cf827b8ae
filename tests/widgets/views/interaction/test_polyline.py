"""Strokes: simplified within the tolerance and with few corners; the points that they enclose or pass."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tactile_widgets.views.interaction.polyline import points_in_polygon, points_near_segment, simplify_polyline


def away(points, line):
    """Largest distance of any of the points from a polyline."""
    start = line[:-1]
    side = np.diff(line, axis=0)
    lengths = np.maximum((side**2).sum(axis=1), 1e-300)
    share = np.clip(((points[:, None] - start) * side).sum(axis=2) / lengths, 0, 1)
    gaps = np.linalg.norm(start + share[..., None] * side - points[:, None], axis=2)
    return gaps.min(axis=1).max()


def test_corners_are_kept():
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    line = np.concatenate([np.linspace(a, b, 20) for a, b in pairwise(corners)])
    np.testing.assert_allclose(simplify_polyline(line, 1e-6), corners)


def test_closed_stroke_keeps_the_points_between_its_ends():
    turn = np.linspace(0, 2 * np.pi, 200)[:, None]
    ring = np.concatenate([np.cos(turn), np.sin(turn)], axis=1)
    kept = simplify_polyline(ring, 0.01)
    assert away(ring, kept) <= 0.01
    assert 20 < len(kept) < 40  # a circle's chord is 0.01 off for 44 sides; twice as good would need 31


@pytest.mark.parametrize("count", [1, 2])
def test_polylines_of_one_or_two_points_are_unchanged(count):
    points = np.arange(2.0 * count).reshape(count, 2)
    np.testing.assert_array_equal(simplify_polyline(points, 1.0), points)


@given(st.integers(0, 10_000), st.floats(0.001, 0.5))
def test_removed_points_are_within_the_tolerance(seed, tolerance):
    stroke = np.cumsum(np.random.default_rng(seed).normal(0, 0.05, (80, 2)), axis=0)
    kept = simplify_polyline(stroke, tolerance)
    assert away(stroke, kept) <= tolerance * (1 + 1e-9)
    np.testing.assert_array_equal(kept[[0, -1]], stroke[[0, -1]])


SQUARE = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]])
STAR = np.array([[np.sin(4 * np.pi * k / 5), np.cos(4 * np.pi * k / 5)] for k in range(5)])


@pytest.mark.parametrize(
    ("outline", "points", "expected"),
    [
        (SQUARE, [[5, 5], [-1, 5], [11, 5], [5, -1], [5, 11], [np.nan, 5], [5, np.nan]], [True] + 6 * [False]),
        (SQUARE[::-1], [[5, 5], [-1, 5]], [True, False]),
        (STAR, [[0, 0], *(0.8 * STAR)], [False] + 5 * [True]),  # even-odd: it encloses its middle twice
        (np.array([[1.0, 1.0]]), [[0, 0], [1, 1]], [False, False]),
        (np.array([[0.0, 1.0], [3.0, 1.0]]), [[1, 1], [2, 1]], [False, False]),
    ],
    ids=["square", "turned round", "star", "point", "line"],
)
def test_points_inside_a_polygon_are_found(outline, points, expected):
    assert points_in_polygon(outline, np.array(points, float)).tolist() == expected


def test_points_in_polygon_agrees_with_winding_for_random_simple_outlines():
    rng = np.random.default_rng(3)
    angle = np.sort(rng.uniform(0, 2 * np.pi, 60))
    reach = rng.uniform(0.5, 1.5, 60)
    outline = reach[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    points = rng.uniform(-1.6, 1.6, (400, 2))
    corner = outline[None] - points[:, None]
    following = np.roll(corner, -1, axis=1)
    cross = corner[..., 0] * following[..., 1] - corner[..., 1] * following[..., 0]
    turned = np.arctan2(cross, (corner * following).sum(axis=2)).sum(axis=1)
    around = np.abs(turned) > np.pi
    assert 50 < around.sum() < 350
    np.testing.assert_array_equal(points_in_polygon(outline, points), around)


def test_points_near_segment_include_its_round_ends():
    points = np.array([[5, 2.9], [5, 3.1], [-2.9, 0], [-3.1, 0], [12, 2], [12.5, 2.5], [np.nan, 0]])
    near = points_near_segment(np.array([[0.0, 0.0], [10.0, 0.0]]), points, 3.0)
    assert near.tolist() == [True, False, True, False, True, False, False]
    assert np.flatnonzero(points_near_segment(np.zeros((2, 2)), points, 3.0)).tolist() == [2]
