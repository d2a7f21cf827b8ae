"""No point is lost between a grid's cells, nor between the triangles of a plane."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.flattening.flatten import flatten
from tactile_maps.geometry.surface.point_location import BoxGrid, PointLocator, owner_and_rank
from tests.support.surfaces import named


@pytest.fixture
def boxes():
    rng = np.random.default_rng(0)
    low = rng.uniform(-1, 1, (80, 2))
    return low, low + rng.uniform(0, 0.3, (80, 2))


def test_every_box_that_contains_a_point_is_a_candidate(boxes):
    low, high = boxes
    points = np.concatenate([np.random.default_rng(1).uniform(-1.5, 1.5, (500, 2)), low, high])
    row, box = BoxGrid(low, high, 0.1).candidates(points)
    found = set(zip(row.tolist(), box.tolist(), strict=True))
    holds = ((points[:, None] >= low) & (points[:, None] <= high)).all(axis=2)
    assert holds.sum() > 300
    assert set(zip(*(part.tolist() for part in np.nonzero(holds)), strict=True)) <= found
    assert len(found) == len(row), "no pair twice"


def test_points_outside_all_boxes_or_not_finite_have_no_candidates(boxes):
    row, _ = BoxGrid(*boxes, 0.1).candidates(np.array([[9, 0], [-9, 0], [0, 1e300], [np.nan, 0], [0, np.inf]]))
    assert len(row) == 0


def test_pairs_contain_every_overlap_once(boxes):
    low, high = boxes
    i, j = BoxGrid(low, high, 0.1).pairs()
    found = set(zip(i.tolist(), j.tolist(), strict=True))
    meets = ((low[:, None] <= high) & (high[:, None] >= low)).all(axis=2)
    assert {(a, b) for a, b in zip(*np.nonzero(meets), strict=True) if a < b} <= found
    assert len(found) == len(i)
    assert (i < j).all()


def test_tiny_cell_size_does_not_exhaust_memory():
    low = np.array([[0.0, 0.0], [1e6, 1e6], [0, 1e6]])
    row, box = BoxGrid(low, low + 1e-9, 1e-9).candidates(low)
    assert (row == box).sum() == 3


def test_boxes_without_extent_are_found():
    low = np.zeros((3, 2))
    assert len(BoxGrid(low, low, 0.0).pairs()[0]) == 3


def test_ranges_count_up_within_each_owner():
    owner, step = owner_and_rank(np.array([2, 0, 3]))
    assert owner.tolist() == [0, 0, 2, 2, 2]
    assert step.tolist() == [0, 1, 0, 1, 2]


@pytest.fixture(scope="module")
def triangles():
    chart = flatten(named("sieve"))
    return chart.plane[chart.faces]


def _weights(count):
    return np.random.default_rng(0).dirichlet([1, 1, 1], count)


@pytest.mark.long
@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e9])
@pytest.mark.parametrize("mirrored", [False, True])
def test_point_inside_is_found_with_its_weights(triangles, scale, mirrored):
    corners = scale * triangles * ([-1, 1] if mirrored else [1, 1])
    weights = _weights(len(corners))
    face, found = PointLocator(corners).query(np.einsum("kc,kcd->kd", weights, corners))
    np.testing.assert_array_equal(face, np.arange(len(corners)))
    np.testing.assert_allclose(found, weights, atol=1e-9)


@pytest.mark.parametrize("weights", [(1, 0, 0), (0, 1, 0), (0.5, 0.5, 0), (0, 0.1, 0.9), (1 / 3, 0, 2 / 3)])
@pytest.mark.parametrize("offset", [0.0, 1e3])
def test_points_on_sides_and_corners_are_always_located(triangles, weights, offset):
    corners = triangles + offset
    points = np.einsum("c,kcd->kd", weights, corners)
    face, found = PointLocator(corners).query(points)
    assert (face >= 0).all()
    np.testing.assert_allclose(np.einsum("kc,kcd->kd", found, corners[face]), points, atol=1e-9 * (1 + offset))
    assert (found >= 0).all()
    np.testing.assert_allclose(found.sum(axis=1), 1, rtol=1e-12)


def test_points_off_the_rim_by_rounding_are_located(triangles):
    """A corner computed with different rounding may be outside all triangles by a few last digits."""
    middle = triangles.mean(axis=(0, 1))
    size = 0.02 * np.ptp(triangles)
    corners = triangles.reshape(-1, 2)
    outward = np.sign(corners - middle)
    face, _ = PointLocator(triangles).query(corners + 1e-10 * size * outward)
    assert (face >= 0).all()


def test_location_agrees_with_testing_every_triangle(triangles):
    points = np.random.default_rng(1).uniform(triangles.min() - 0.02, triangles.max() + 0.02, (300, 2))
    a = triangles[:, 0]
    b = triangles[:, 1]
    c = triangles[:, 2]

    def left(p, q, x):
        u = (q - p)[None]
        v = x[:, None] - p[None]
        return u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0] >= 0

    expected = left(a, b, points) & left(b, c, points) & left(c, a, points)
    face, _ = PointLocator(triangles).query(points)
    assert 50 < (face >= 0).sum() < 250
    np.testing.assert_array_equal(face >= 0, expected.any(axis=1))


def test_points_outside_or_not_finite_are_in_no_triangle(triangles):
    face, weights = PointLocator(triangles).query(np.array([[np.nan, 0], [np.inf, 0], [1e300, -1e300], [-1, -1]]))
    assert (face == -1).all()
    assert (weights == 0).all()


def test_locator_without_area_or_points_finds_nothing():
    assert PointLocator(np.zeros((0, 3, 2))).query(np.zeros((2, 2)))[0].tolist() == [-1, -1]
    assert PointLocator(np.zeros((1, 3, 2))).query(np.zeros((2, 2)))[0].tolist() == [-1, -1]
    assert len(PointLocator(np.eye(3)[None, :, :2]).query(np.zeros((0, 2)))[0]) == 0
