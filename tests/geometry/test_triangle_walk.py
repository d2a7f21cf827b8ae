"""Walking to the triangle that holds a point."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.geometry.surface.point_location import PointLocator
from tactile_maps.geometry.surface.triangle_walk import TriangleWalk
from tests.support.touch import arm


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("patch", [0, 1, 2])
def test_walk_agrees_with_a_search_or_reports_failure(patch):
    map_ = arm().map
    random = np.random.default_rng(patch)
    faces = map_.charts[patch].faces
    corners = map_.uv[patch]
    walk = TriangleWalk(faces)
    search = PointLocator(corners[faces])
    arrived = 0
    for _ in range(200):
        goal = int(random.integers(len(faces)))
        point = random.dirichlet(np.ones(3)) @ corners[faces[goal]]
        start = int(np.linalg.norm(corners[faces].mean(axis=1) - point - random.normal(0, 0.01, 2), axis=1).argmin())
        found = walk.find(corners, (float(point[0]), float(point[1])), start)
        if found is not None:
            arrived += 1
            face, weights = found
            assert weights.sum() == pytest.approx(1, abs=1e-12)
            assert (weights >= 0).all()
            assert weights @ corners[faces[face]] == pytest.approx(point, abs=1e-12)
            assert search.query(point[None])[0][0] >= 0
    assert arrived > 150


SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])


def test_walk_crosses_a_shared_edge():
    walk = TriangleWalk(np.array([[0, 1, 2], [0, 2, 3]]))
    face, weights = walk.find(SQUARE, (0.2, 0.8), 0)
    assert face == 1
    assert weights @ SQUARE[[0, 2, 3]] == pytest.approx([0.2, 0.8])


def test_walk_ends_at_the_border():
    walk = TriangleWalk(np.array([[0, 1, 2], [0, 2, 3]]))
    assert walk.find(SQUARE, (2.0, 0.5), 1) is None


def test_corner_belongs_to_a_triangle():
    walk = TriangleWalk(np.array([[0, 1, 2], [0, 2, 3]]))
    for corner in SQUARE.tolist():
        assert walk.find(SQUARE, tuple(corner), 0) is not None


def test_degenerate_triangle_is_not_crossed():
    walk = TriangleWalk(np.array([[0, 1, 1]]))
    assert walk.find(SQUARE, (0.5, 0.0), 0) is None
