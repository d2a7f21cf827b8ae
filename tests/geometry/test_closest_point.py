from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.core.errors import MeshError
from tactile_maps.geometry.surface.closest_point import ClosestPoint, barycentric
from tactile_maps.geometry.surface.mesh import Mesh
from tests.hard_cases.meshes import HOPELESS_MESHES

TRIANGLE = Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])


def test_closest_point_is_found_inside_on_an_edge_and_at_a_corner() -> None:
    faces, weights, away = ClosestPoint(TRIANGLE).query(np.array([[0.25, 0.25, 2], [0.5, -1, 0], [-3, -4, 0.0]]))
    assert faces.tolist() == [0, 0, 0]
    assert weights == pytest.approx(np.array([[0.5, 0.25, 0.25], [0.5, 0.5, 0], [1, 0, 0]]))
    assert away == pytest.approx([2, 1, 5])


def test_query_without_points_returns_empty_arrays() -> None:
    faces, weights, away = ClosestPoint(TRIANGLE).query(np.zeros((0, 3)))
    assert (len(faces), weights.shape, len(away)) == (0, (0, 3), 0)


def test_input_that_would_crash_native_code_is_rejected() -> None:
    with pytest.raises(MeshError, match="no faces"):
        ClosestPoint(HOPELESS_MESHES["empty"])
    with pytest.raises(MeshError, match="not finite"):
        ClosestPoint(TRIANGLE).query(np.array([[np.nan, 0, 0]]))


def test_weights_in_a_degenerate_triangle_are_on_its_nearest_side() -> None:
    line = np.array([[[0, 0, 0], [1, 0, 0], [3, 0, 0.0]], [[2, 2, 2], [2, 2, 2], [2, 2, 2.0]]])
    weights = barycentric(line, np.array([[2.5, 0, 0], [2, 2, 2.0]]))
    assert np.einsum("kc,kcd->kd", weights, line) == pytest.approx(np.array([[2.5, 0, 0], [2, 2, 2]]))


def test_barycentric_weights_work_in_two_dimensions() -> None:
    corners = np.array([[[0, 0], [1, 0], [0, 1.0]]])
    assert barycentric(corners, np.array([[0.2, 0.3]])) == pytest.approx(np.array([[0.5, 0.2, 0.3]]))
