"""New vertices change nothing but the number of faces."""

from __future__ import annotations

import numpy as np
import pytest

from app.geometry.topology import euler_characteristic
from app.maps.insert import INSET, SNAP, insert_points
from tests.numerics.map_surfaces import cap, named, sheet, taxels_on


def _random(surface, count, seed=0):
    generator = np.random.default_rng(seed)
    return generator.integers(0, len(surface.faces), count), generator.dirichlet([1, 1, 1], count)


@pytest.mark.parametrize("count", [0, 1, 30, 3000])
def test_points_become_vertices_and_the_surface_stays(count):
    surface = cap(1.0, rings=8)
    faces, weights = _random(surface, count)
    mesh, vertices = insert_points(surface, faces, weights)
    size = np.linalg.norm(np.ptp(surface.vertices[surface.faces], axis=1), axis=1).max()
    np.testing.assert_allclose(
        mesh.vertices[vertices].reshape(-1, 3), surface.points(faces, weights), atol=2 * SNAP * size
    )
    assert mesh.area == pytest.approx(surface.area, rel=1e-12)
    assert euler_characteristic(mesh.faces) == euler_characteristic(surface.faces)
    np.testing.assert_array_equal(mesh.vertices[: len(surface.vertices)], surface.vertices)
    assert (mesh.face_areas > 0).all()


def test_a_point_inside_a_face_is_met_exactly():
    surface = sheet(1, 1)
    mesh, vertices = insert_points(surface, np.array([0, 0]), np.array([[0.2, 0.3, 0.5], [0.6, 0.3, 0.1]]))
    np.testing.assert_allclose(
        mesh.vertices[vertices],
        surface.points(np.array([0, 0]), np.array([[0.2, 0.3, 0.5], [0.6, 0.3, 0.1]])),
        atol=1e-17,
    )


def test_corners_are_used_and_sides_avoided():
    surface = sheet(1, 1)
    faces, weights = np.array([0, 0]), np.array([[1.0, 0, 0], [0.5, 0.5, 0]])
    mesh, vertices = insert_points(surface, faces, weights)
    assert vertices[0] == surface.faces[0, 0]
    away = np.linalg.norm(mesh.vertices[vertices[1]] - surface.point(0, weights[1]))
    assert 0 < away <= 2 * INSET * surface.size


def test_points_in_one_place_share_a_vertex():
    mesh, vertices = insert_points(sheet(1, 1), np.array([1, 1, 1]), np.tile([0.2, 0.2, 0.6], (3, 1)))
    assert len(set(vertices.tolist())) == 1
    assert len(mesh.faces) == 4


def test_normals_keep_their_side():
    surface = named("saddle")
    taxels = taxels_on(surface, 60)
    mesh, _ = insert_points(surface, taxels.faces, taxels.weights)
    assert (mesh.face_normals[:, 2] > 0).all() == (surface.face_normals[:, 2] > 0).all()
