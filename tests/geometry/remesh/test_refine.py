"""A refined mesh has the shape of the coarse one and vertices at the requested places."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.core.errors import MeshError
from tactile_maps.geometry.remesh.refine import CORNER_SNAP, SIDE_INSET, insert_vertices, subdivide, subdivided_count
from tactile_maps.geometry.surface.mesh import Mesh
from tests.hard_cases.meshes import HARD_MESHES, hard_mesh
from tests.support.surfaces import cap, named, sheet, taxels_on


def longest(mesh: Mesh) -> float:
    return float(np.linalg.norm(np.diff(mesh.vertices[mesh.edges], axis=1)[:, 0], axis=1).max())


@pytest.mark.parametrize("name", ["cube", "two triangles", "one triangle", "spike", "star", "book", "needles", "rod"])
@pytest.mark.parametrize("share", [0.3, 0.05])
def test_edges_are_short_enough_and_the_shape_is_unchanged(name: str, share: float) -> None:
    mesh = hard_mesh(name)
    result = subdivide(mesh, longest=share * mesh.size)
    fine = result.mesh
    assert longest(fine) <= 2 * share * mesh.size
    assert np.bincount(result.parent, fine.face_areas) == pytest.approx(mesh.face_areas, rel=1e-9)
    np.testing.assert_allclose(fine.face_normals, mesh.face_normals[result.parent], atol=1e-6)
    assert np.array_equal(fine.vertices[: len(mesh.vertices)], mesh.vertices)
    assert len(np.unique(fine.faces)) == len(np.unique(mesh.faces)) + len(fine.vertices) - len(mesh.vertices)
    assert fine.connectivity.euler_characteristic == mesh.connectivity.euler_characteristic
    assert fine.connectivity.face_count.max() == max(2, mesh.connectivity.face_count.max())
    assert (np.diff(result.parent) >= 0).all()


@pytest.mark.parametrize("name", ["cube", "book"])
def test_edges_of_the_coarse_mesh_are_cut_into_equal_parts(name: str) -> None:
    mesh = hard_mesh(name)
    fine = subdivide(mesh, longest=0.1 * mesh.size).mesh
    for a, b in mesh.vertices[mesh.edges]:
        share = (fine.vertices - a) @ (b - a) / ((b - a) @ (b - a))
        on = np.linalg.norm(fine.vertices - a - share[:, None] * (b - a), axis=1) < 1e-12
        parts = int(np.ceil(np.linalg.norm(b - a) / (0.1 * mesh.size)))
        assert np.sort(share[on & (share > -1e-9) & (share < 1 + 1e-9)]) == pytest.approx(np.linspace(0, 1, parts + 1))


def test_number_of_faces_is_little_above_the_minimum_for_the_area() -> None:
    mesh = hard_mesh("cube")
    step = 0.01 * mesh.size
    assert len(subdivide(mesh, longest=step).mesh.faces) < 1.2 * mesh.area / (np.sqrt(3) / 4 * step**2)


def test_needle_shaped_face_is_split_like_a_ladder() -> None:
    needle = Mesh([[0, 0, 0], [1e-3, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    assert len(subdivide(needle, longest=0.01).mesh.faces) < 210
    assert len(subdivide(needle, longest=0.01).mesh.faces) == subdivided_count(needle, longest=0.01)


def test_fine_mesh_is_returned_unchanged() -> None:
    mesh = HARD_MESHES["sphere"]
    result = subdivide(mesh, longest=1.01 * longest(mesh))
    assert result.mesh is mesh
    assert np.array_equal(result.parent, np.arange(len(mesh.faces)))


def test_implausible_number_of_faces_is_rejected() -> None:
    with pytest.raises(MeshError, match="two million"):
        subdivide(HARD_MESHES["cube"], longest=1e-5)


def _random_points(surface, count, seed=0):
    generator = np.random.default_rng(seed)
    return generator.integers(0, len(surface.faces), count), generator.dirichlet([1, 1, 1], count)


@pytest.mark.parametrize("count", [0, 1, 30, 3000])
def test_points_become_vertices_and_the_surface_is_unchanged(count):
    surface = cap(1.0, rings=8)
    faces, weights = _random_points(surface, count)
    mesh, vertices = insert_vertices(surface, faces, weights)
    size = np.linalg.norm(np.ptp(surface.vertices[surface.faces], axis=1), axis=1).max()
    np.testing.assert_allclose(
        mesh.vertices[vertices].reshape(-1, 3), surface.points(faces, weights), atol=2 * CORNER_SNAP * size
    )
    assert mesh.area == pytest.approx(surface.area, rel=1e-12)
    assert mesh.connectivity.euler_characteristic == surface.connectivity.euler_characteristic
    np.testing.assert_array_equal(mesh.vertices[: len(surface.vertices)], surface.vertices)
    assert (mesh.face_areas > 0).all()


def test_point_inside_a_face_becomes_an_exact_vertex():
    surface = sheet(1, 1)
    mesh, vertices = insert_vertices(surface, np.array([0, 0]), np.array([[0.2, 0.3, 0.5], [0.6, 0.3, 0.1]]))
    np.testing.assert_allclose(
        mesh.vertices[vertices],
        surface.points(np.array([0, 0]), np.array([[0.2, 0.3, 0.5], [0.6, 0.3, 0.1]])),
        atol=1e-17,
    )


def test_points_at_corners_reuse_the_vertex_and_points_on_sides_are_moved_inside():
    surface = sheet(1, 1)
    faces = np.array([0, 0])
    weights = np.array([[1.0, 0, 0], [0.5, 0.5, 0]])
    mesh, vertices = insert_vertices(surface, faces, weights)
    assert vertices[0] == surface.faces[0, 0]
    away = np.linalg.norm(mesh.vertices[vertices[1]] - surface.point(0, weights[1]))
    assert 0 < away <= 2 * SIDE_INSET * surface.size


def test_points_at_one_place_share_a_vertex():
    mesh, vertices = insert_vertices(sheet(1, 1), np.array([1, 1, 1]), np.tile([0.2, 0.2, 0.6], (3, 1)))
    assert len(set(vertices.tolist())) == 1
    assert len(mesh.faces) == 4


def test_normals_keep_their_side():
    surface = named("saddle")
    taxels = taxels_on(surface, 60)
    mesh, _ = insert_vertices(surface, taxels.faces, taxels.weights)
    assert (mesh.face_normals[:, 2] > 0).all() == (surface.face_normals[:, 2] > 0).all()
