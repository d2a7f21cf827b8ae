"""Distances to simple bodies, against points sampled densely on their surfaces."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

from app.touch.shapes import Ball, Box, Cylinder, Plane

BALL, BOX, CYLINDER = Ball(0.03), Box((0.02, 0.03, 0.05)), Cylinder(0.03, 0.02)


def on_ball(generator):
    points = generator.normal(size=(200_000, 3))
    return BALL.radius * points / np.linalg.norm(points, axis=1, keepdims=True)


def on_box(generator):
    points = generator.uniform(-1, 1, size=(200_000, 3)) * BOX.half
    side = generator.integers(3, size=len(points))
    rows = np.arange(len(points))
    points[rows, side] = np.sign(points[rows, side]) * np.asarray(BOX.half)[side]
    return points


def on_cylinder(generator):
    angle = generator.uniform(0, 2 * np.pi, 200_000)
    radius = CYLINDER.radius * np.sqrt(generator.uniform(size=len(angle)))
    height = generator.choice([-1.0, 1.0], len(angle)) * CYLINDER.half
    round_ = np.arange(len(angle)) % 2 == 0
    radius[round_] = CYLINDER.radius
    height[round_] = generator.uniform(-1, 1, round_.sum()) * CYLINDER.half
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), height], axis=1)


def inside_cylinder(points):
    return (np.linalg.norm(points[:, :2], axis=1) < CYLINDER.radius) & (np.abs(points[:, 2]) < CYLINDER.half)


BODIES = [
    (BALL, on_ball, lambda p: np.linalg.norm(p, axis=1) < BALL.radius),
    (BOX, on_box, lambda p: (np.abs(p) < BOX.half).all(axis=1)),
    (CYLINDER, on_cylinder, inside_cylinder),
]


@pytest.mark.parametrize(("shape", "surface", "inside"), BODIES)
def test_the_distance_is_that_to_the_closest_of_many_points_on_the_surface(shape, surface, inside):
    generator = np.random.default_rng(3)
    points = generator.uniform(-0.08, 0.08, size=(500, 3))
    held = inside(points)
    assert held.any()
    assert not held.all()
    away = cKDTree(surface(generator)).query(points)[0]
    found = shape.distance(points)
    np.testing.assert_array_equal(found < 0, held)
    assert np.abs(found) == pytest.approx(away, abs=5e-4)
    assert (np.abs(found) <= away + 1e-12).all(), "no sample is closer than the closest point"


@pytest.mark.parametrize(("shape", "surface", "inside"), BODIES)
def test_the_reach_holds_all_of_it_and_no_more(shape, surface, inside):
    farthest = np.linalg.norm(surface(np.random.default_rng(4)), axis=1).max()
    assert farthest <= shape.reach * (1 + 1e-12)
    assert farthest > 0.97 * shape.reach


@pytest.mark.parametrize("shape", [BALL, BOX, CYLINDER, Plane()])
def test_no_distance_changes_faster_than_the_point_moves(shape):
    generator = np.random.default_rng(5)
    points = generator.uniform(-0.08, 0.08, size=(2000, 3))
    step = generator.normal(scale=0.01, size=points.shape)
    change = np.abs(shape.distance(points + step) - shape.distance(points))
    assert (change <= np.linalg.norm(step, axis=1) + 1e-15).all()


def test_by_hand():
    assert BOX.distance(np.array([[0.0, 0, 0], [0.05, 0, 0], [0.023, 0.034, 0.05]])) == pytest.approx(
        [-0.02, 0.03, 0.005]
    )
    assert CYLINDER.distance(np.array([[0.0, 0, 0], [0.034, 0, 0.023], [0, 0, 0.05]])) == pytest.approx(
        [-0.02, 0.005, 0.03]
    )
    assert Plane().distance(np.array([[5.0, 2, 0.1], [0, 0, -0.2]])) == pytest.approx([0.1, -0.2])
    assert Plane().reach == np.inf


@pytest.mark.parametrize("shape", [BALL, BOX, CYLINDER, Plane()])
def test_no_points_are_no_distances_and_the_points_stay_as_they_are(shape):
    assert shape.distance(np.zeros((0, 3))).shape == (0,)
    points = np.full((2, 3), 0.01)
    shape.distance(points)
    assert (points == 0.01).all()
