"""Meshes are checked frozen values; a surface point can be a key."""

from __future__ import annotations

import dataclasses
import pickle

import numpy as np
import pytest

from tactile_maps.core.errors import MeshError
from tactile_maps.geometry.surface.mesh import Mesh, SurfacePoint
from tests.support.surfaces import sheet

TRIANGLE = Mesh([[0, 0, 0], [2, 0, 0], [0, 2, 0]], [[0, 1, 2]])


def test_triangle_has_correct_areas_normals_edges_bounds_and_size() -> None:
    assert TRIANGLE.face_areas.tolist() == [2.0]
    assert TRIANGLE.area == 2.0
    assert TRIANGLE.face_normals.tolist() == [[0, 0, 1]]
    assert TRIANGLE.vertex_normals.tolist() == [[0, 0, 1]] * 3
    assert TRIANGLE.edges.tolist() == [[0, 1], [0, 2], [1, 2]]
    assert TRIANGLE.bounds.tolist() == [[0, 0, 0], [2, 2, 0]]
    assert TRIANGLE.size == pytest.approx(np.sqrt(8))


def test_points_and_normals_are_interpolated_by_weights() -> None:
    assert TRIANGLE.point(0, (0.5, 0.25, 0.25)).tolist() == [0.5, 0.5, 0]
    assert TRIANGLE.points(np.array([0, 0]), np.array([[1, 0, 0], [0, 1, 0.0]])).tolist() == [[0, 0, 0], [2, 0, 0]]
    assert TRIANGLE.normal(0, (1 / 3, 1 / 3, 1 / 3)).tolist() == pytest.approx([0, 0, 1])


def test_face_without_area_has_no_normal() -> None:
    mesh = Mesh([[0, 0, 0], [1, 0, 0]], [[0, 1, 1]])
    assert mesh.face_normals.tolist() == [[0, 0, 0]]
    assert mesh.normal(0, (1, 0, 0)).tolist() == [0, 0, 0]


def test_empty_mesh_is_valid() -> None:
    mesh = Mesh(np.zeros((0, 3)), np.zeros((0, 3), dtype=int))
    assert (mesh.area, mesh.size, len(mesh.edges)) == (0, 0, 0)


def test_mesh_copies_its_arrays_and_makes_them_read_only() -> None:
    vertices = np.eye(3)
    mesh = Mesh(vertices, np.array([[0, 1, 2]]))
    vertices[0, 0] = 9
    assert mesh.vertices[0, 0] == 1
    with pytest.raises(ValueError, match="read-only"):
        mesh.vertices[0, 0] = 2


def test_vertex_that_is_not_finite_is_named() -> None:
    with pytest.raises(MeshError, match="vertex 1.*finite"):
        Mesh([[0, 0, 0], [np.nan, 0, 0], [0, 1, 0]], [[0, 1, 2]])


@pytest.mark.parametrize("index", [3, -1])
def test_face_with_an_unknown_vertex_is_named(index: int) -> None:
    with pytest.raises(MeshError, match="face 1"):
        Mesh(np.eye(3), [[0, 1, 2], [0, 1, index]])


def test_surface_point_is_frozen_and_hashable() -> None:
    at = SurfacePoint(0, 7, (0.2, 0.3, 0.5))
    assert {at: 1}[SurfacePoint(0, 7, (0.2, 0.3, 0.5))] == 1
    with pytest.raises(dataclasses.FrozenInstanceError):
        at.face = 3  # type: ignore[misc]


def test_connectivity_is_computed_once_and_reused() -> None:
    mesh = sheet()
    assert mesh.connectivity is mesh.connectivity
    moved = Mesh.of(mesh.connectivity, 2 * mesh.vertices)
    assert moved.connectivity is mesh.connectivity
    np.testing.assert_allclose(moved.edge_lengths, 2 * mesh.edge_lengths, rtol=1e-12)
    assert mesh.edge_lengths.shape == (len(mesh.edges),)


def test_cached_values_of_mesh_are_not_pickled() -> None:
    mesh = sheet()
    bare = len(pickle.dumps(mesh))
    assert mesh.connectivity.boundary_loops
    assert mesh.vertex_normals.any()
    assert len(pickle.dumps(mesh)) == bare
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(mesh)).edges, mesh.edges)


def test_mesh_is_solid_if_closed_with_faces_outward() -> None:
    corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    outward = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    far = np.array(corners) + 1e3
    assert Mesh(corners, outward).is_solid
    assert Mesh(far, outward).is_solid
    assert not Mesh(corners, outward[:, ::-1]).is_solid, "inside out"
    assert not Mesh(corners, outward[:3]).is_solid, "open"
    one_turned = np.array([*outward[:3], outward[3, ::-1]])
    assert not Mesh(corners, one_turned).is_solid


def test_mesh_of_touching_closed_bodies_is_solid_if_each_faces_outward() -> None:
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    outward = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    # The second shares the edge from 0 to 1, which four faces meet in.
    both = np.vstack([corners, [[0, -1, 0], [0, 0, -1]]])
    touching = np.vstack([outward, np.array([0, 1, 4, 5])[outward]])
    assert not Mesh(both, touching).connectivity.is_closed_manifold
    assert Mesh(both, touching).is_solid
    apart = np.vstack([corners, corners + 3])
    assert Mesh(apart, np.vstack([outward, outward + 4])).is_solid
    large = np.vstack([9 * corners, corners + 20])
    assert not Mesh(large, np.vstack([outward, outward[:, ::-1] + 4])).is_solid, "one is inside out"
    assert not Mesh(np.zeros((0, 3)), np.zeros((0, 3), int)).is_solid


def test_mesh_without_faces_has_no_normals() -> None:
    alone = Mesh(np.eye(3), np.zeros((0, 3), dtype=np.int64))
    np.testing.assert_array_equal(alone.vertex_normals, np.zeros((3, 3)))
