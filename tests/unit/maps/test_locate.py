"""Every point is found in its triangle: inside, on sides, at corners; and nowhere else."""

from __future__ import annotations

import numpy as np
import pytest

from app.maps.flatten import flatten
from app.maps.locate import PlaneLocator
from tests.numerics.map_surfaces import named


@pytest.fixture(scope="module")
def triangles():
    chart = flatten(named("sieve"))
    return chart.plane[chart.faces]


def _weights(count):
    return np.random.default_rng(0).dirichlet([1, 1, 1], count)


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e9])
@pytest.mark.parametrize("mirrored", [False, True])
def test_a_point_inside_is_found_with_its_weights(triangles, scale, mirrored):
    corners = scale * triangles * ([-1, 1] if mirrored else [1, 1])
    weights = _weights(len(corners))
    face, found = PlaneLocator(corners).query(np.einsum("kc,kcd->kd", weights, corners))
    np.testing.assert_array_equal(face, np.arange(len(corners)))
    np.testing.assert_allclose(found, weights, atol=1e-9)


@pytest.mark.parametrize("weights", [(1, 0, 0), (0, 1, 0), (0.5, 0.5, 0), (0, 0.1, 0.9), (1 / 3, 0, 2 / 3)])
@pytest.mark.parametrize("offset", [0.0, 1e3])
def test_points_on_sides_and_corners_are_never_lost(triangles, weights, offset):
    corners = triangles + offset
    points = np.einsum("c,kcd->kd", weights, corners)
    face, found = PlaneLocator(corners).query(points)
    assert (face >= 0).all()
    np.testing.assert_allclose(np.einsum("kc,kcd->kd", found, corners[face]), points, atol=1e-9 * (1 + offset))
    assert (found >= 0).all()
    np.testing.assert_allclose(found.sum(axis=1), 1, rtol=1e-12)


def test_rounding_off_the_rim_loses_no_point(triangles):
    """A corner computed elsewhere may lie a few last digits outside of everything."""
    middle, size = triangles.mean(axis=(0, 1)), 0.02 * np.ptp(triangles)
    corners = triangles.reshape(-1, 2)
    outward = np.sign(corners - middle)
    face, _ = PlaneLocator(triangles).query(corners + 1e-10 * size * outward)
    assert (face >= 0).all()


def test_it_agrees_with_trying_every_triangle(triangles):
    points = np.random.default_rng(1).uniform(triangles.min() - 0.02, triangles.max() + 0.02, (300, 2))
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]

    def left(p, q, x):
        u, v = (q - p)[None], x[:, None] - p[None]
        return u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0] >= 0

    expected = left(a, b, points) & left(b, c, points) & left(c, a, points)
    face, _ = PlaneLocator(triangles).query(points)
    assert 50 < (face >= 0).sum() < 250
    np.testing.assert_array_equal(face >= 0, expected.any(axis=1))


def test_points_that_are_nowhere_are_in_no_triangle(triangles):
    face, weights = PlaneLocator(triangles).query(np.array([[np.nan, 0], [np.inf, 0], [1e300, -1e300], [-1, -1]]))
    assert (face == -1).all()
    assert (weights == 0).all()


def test_nothing_holds_nothing():
    assert PlaneLocator(np.zeros((0, 3, 2))).query(np.zeros((2, 2)))[0].tolist() == [-1, -1]
    assert PlaneLocator(np.zeros((1, 3, 2))).query(np.zeros((2, 2)))[0].tolist() == [-1, -1]
    assert len(PlaneLocator(np.eye(3)[None, :, :2]).query(np.zeros((0, 2)))[0]) == 0
