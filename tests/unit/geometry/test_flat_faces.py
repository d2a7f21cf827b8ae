from __future__ import annotations

import numpy as np
import pytest

from app.geometry.flat_faces import flip_flat_faces, is_flat
from app.geometry.mesh import Mesh
from app.geometry.topology import boundary_loops, edge_table, euler_characteristic
from tests.numerics.hard_groups import hard_mesh, with_flat_fans

TOLERANCE = 1e-7


def flipped_away(mesh: Mesh):
    return flip_flat_faces(mesh.vertices / mesh.size, mesh.faces, TOLERANCE)


def test_flatness_is_the_height_over_the_longest_side() -> None:
    corners = np.array([[[0, 0, 0], [2, 0, 0], [1, 1e-3, 0]], [[0, 0, 0], [1e-3, 0, 0], [0, 1, 0]]])
    assert is_flat(corners, 1.01e-3).tolist() == [True, True]
    assert is_flat(corners, 0.99e-3).tolist() == [False, False]
    assert is_flat(np.zeros((1, 3, 3)), 1e-9).all()


@pytest.mark.parametrize("count", [2, 8, 40])
def test_a_fan_of_flat_faces_becomes_a_fan_of_the_face_behind_it(count: int) -> None:
    mesh = with_flat_fans(count)
    assert is_flat(mesh.vertices[mesh.faces] / mesh.size, TOLERANCE).sum() == count
    faces, owner, flat = flipped_away(mesh)
    assert not flat.any()
    assert len(faces) == len(mesh.faces)
    after = Mesh(mesh.vertices, faces)
    assert after.area == pytest.approx(mesh.area, rel=1e-12)
    assert euler_characteristic(faces) == 1
    assert len(boundary_loops(faces)) == 1, "no slit opens"
    assert edge_table(faces).face_count.max() == 2
    assert (after.face_normals[:, 2] > 0.999).all(), "nothing folds over"
    assert np.bincount(owner, after.face_areas, len(faces)) == pytest.approx(mesh.face_areas, abs=1e-15)


def test_a_flat_face_on_the_border_is_left_to_be_dropped() -> None:
    vertices = [[0, 0, 0], [2, 0, 0], [1, 0, 0], [0.2, 1, 0], [1.8, 1, 0]]
    mesh = Mesh(vertices, [[0, 1, 2], [0, 2, 3], [2, 1, 4], [2, 4, 3]])
    faces, owner, flat = flipped_away(mesh)
    assert flat.tolist() == [True, False, False, False]
    assert np.array_equal(faces, mesh.faces)
    assert owner.tolist() == [0, 1, 2, 3]


def test_no_flip_makes_an_edge_that_is_there_already() -> None:
    pocket = Mesh([[0, 0, 0], [2, 0, 0], [1, 0, 0], [1, 1, 0]], [[0, 2, 1], [0, 1, 3], [2, 0, 3], [1, 2, 3]])
    faces, _, flat = flipped_away(pocket)
    assert flat.tolist() == [True, False, False, False]
    assert np.array_equal(faces, pocket.faces)


def test_a_mesh_without_flat_faces_is_untouched() -> None:
    mesh = hard_mesh("torus")
    faces, owner, flat = flipped_away(mesh)
    assert np.array_equal(faces, mesh.faces)
    assert np.array_equal(owner, np.arange(len(faces)))
    assert not flat.any()
