"""Few corners of many points: never farther from the stroke than the tolerance, and no more of them than it needs."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tactile_widgets.views.interaction.polyline import simplify_polyline


def away(points, line):
    """Largest distance of any of the points from a polyline."""
    start = line[:-1]
    side = np.diff(line, axis=0)
    lengths = np.maximum((side**2).sum(axis=1), 1e-300)
    share = np.clip(((points[:, None] - start) * side).sum(axis=2) / lengths, 0, 1)
    gaps = np.linalg.norm(start + share[..., None] * side - points[:, None], axis=2)
    return gaps.min(axis=1).max()


def test_straight_lines_keep_their_ends():
    line = np.linspace([0.0, 0.0], [1.0, 2.0], 50)
    np.testing.assert_array_equal(simplify_polyline(line, 1e-9), line[[0, -1]])


def test_corners_are_kept():
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    line = np.concatenate([np.linspace(a, b, 20) for a, b in pairwise(corners)])
    np.testing.assert_allclose(simplify_polyline(line, 1e-6), corners)


def test_a_stroke_that_comes_back_to_its_start_keeps_what_lies_between():
    turn = np.linspace(0, 2 * np.pi, 200)[:, None]
    ring = np.concatenate([np.cos(turn), np.sin(turn)], axis=1)
    kept = simplify_polyline(ring, 0.01)
    assert away(ring, kept) <= 0.01
    assert 20 < len(kept) < 40  # a circle's chord is 0.01 off for 44 sides; twice as good would need 31


@pytest.mark.parametrize("count", [1, 2])
def test_nothing_is_too_short(count):
    points = np.arange(2.0 * count).reshape(count, 2)
    np.testing.assert_array_equal(simplify_polyline(points, 1.0), points)


@given(st.integers(0, 10_000), st.floats(0.001, 0.5))
def test_what_is_left_out_is_within_the_tolerance(seed, tolerance):
    stroke = np.cumsum(np.random.default_rng(seed).normal(0, 0.05, (80, 2)), axis=0)
    kept = simplify_polyline(stroke, tolerance)
    assert away(stroke, kept) <= tolerance * (1 + 1e-9)
    np.testing.assert_array_equal(kept[[0, -1]], stroke[[0, -1]])
