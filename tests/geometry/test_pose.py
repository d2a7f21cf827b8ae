from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.geometry.surface.pose import Pose

QUARTER = Pose(np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]]), np.array([1.0, 2, 3]))


def test_identity_pose_leaves_points_unchanged() -> None:
    assert Pose.identity().points(np.array([1.0, 2, 3])).tolist() == [1, 2, 3]


def test_points_are_rotated_then_translated_and_directions_only_rotated() -> None:
    assert QUARTER.points(np.array([[1.0, 0, 0]])).tolist() == [[1, 3, 3]]
    assert QUARTER.directions(np.array([1.0, 0, 0])).tolist() == [0, 1, 0]


def test_product_with_inverse_is_identity_and_products_apply_both_poses() -> None:
    assert (QUARTER @ QUARTER.inverse).matrix == pytest.approx(np.eye(4))
    points = np.random.default_rng(0).normal(size=(5, 3))
    assert (QUARTER @ QUARTER).points(points) == pytest.approx(QUARTER.points(QUARTER.points(points)))


def test_matrix_is_homogeneous() -> None:
    assert QUARTER.matrix[3].tolist() == [0, 0, 0, 1]
    assert QUARTER.matrix[:3, 3].tolist() == [1, 2, 3]
