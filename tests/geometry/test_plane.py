"""Left is positive, and a polygon runs as often around a point as one would count."""

from __future__ import annotations

import numpy as np

from tactile_maps.geometry.surface.plane import cross, winding_numbers


def test_cross_product_is_positive_for_a_left_turn():
    assert cross(np.array([2.0, 0.0]), np.array([1.0, 3.0])) == 6
    several = np.array([[1.0, 0.0], [0.0, 1.0]])
    assert cross(several, several[::-1]).tolist() == [1, -1]


def test_winding_number_is_nonzero_only_for_points_inside_the_polygon():
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    points = np.array([[0.5, 0.5], [2.0, 0.5], [0.9, 0.1]])
    assert winding_numbers(square, points).tolist() == [1, 0, 1]
    assert winding_numbers(square[::-1], points).tolist() == [-1, 0, -1]
    twice = np.concatenate([square, square])
    assert winding_numbers(twice, points).tolist() == [2, 0, 2]
