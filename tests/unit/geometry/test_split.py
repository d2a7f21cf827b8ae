from __future__ import annotations

import numpy as np
import pytest

from app.geometry.mesh import Mesh
from app.geometry.orient import orient, turn
from app.geometry.split import glued_sides, pieces_of, split
from app.geometry.topology import bow_tie_vertices, edge_table, face_components
from tests.numerics.hard_groups import hard_mesh


def taken_apart(mesh: Mesh):
    oriented = orient(mesh.faces, mesh.face_areas)
    faces = turn(mesh.faces, oriented.turned)
    glued = glued_sides(faces, oriented.piece)
    return faces, glued, *split(faces, glued)


def fans(faces: np.ndarray) -> int:
    """Fans of faces around every vertex, counted by walking over shared edges."""
    total = 0
    for vertex in np.unique(faces):
        own = [set(face.tolist()) - {vertex} for face in faces[(faces == vertex).any(axis=1)]]
        while own:
            fan, total = own.pop(), total + 1
            while touching := next((other for other in own if other & fan), None):
                own.remove(touching)
                fan = fan | touching
    return total


@pytest.mark.parametrize("name", ["fin", "book", "two cubes", "bow-ties", "cube", "one triangle", "moebius"])
def test_every_edge_has_two_faces_at_most_and_every_vertex_one_fan(name: str) -> None:
    mesh = hard_mesh(name)
    before, _, faces, vertex_of = taken_apart(mesh)
    assert edge_table(faces).face_count.max() <= 2
    assert not len(bow_tie_vertices(faces))
    assert fans(faces) == len(vertex_of) == faces.max() + 1
    assert np.array_equal(vertex_of[faces], before), "no face is lost or moved"
    assert (np.diff(vertex_of) >= 0).all()


def test_a_sound_mesh_keeps_its_numbers() -> None:
    mesh = hard_mesh("torus")
    _, _, faces, vertex_of = taken_apart(mesh)
    assert np.array_equal(faces, mesh.faces)
    assert np.array_equal(vertex_of, np.arange(len(mesh.vertices)))


def test_a_fin_leaves_the_box_whole_and_stands_alone() -> None:
    _, glued, faces, _ = taken_apart(hard_mesh("fin"))
    piece = pieces_of(glued, len(faces))
    assert np.array_equal(np.bincount(piece), [12, 1])
    assert (edge_table(faces[piece == 0]).face_count == 2).all()


@pytest.mark.parametrize(("name", "pieces"), [("book", 5), ("two cubes", 2), ("bow-ties", 4), ("torus", 1)])
def test_pieces_are_those_of_the_split_faces(name: str, pieces: int) -> None:
    _, glued, faces, _ = taken_apart(hard_mesh(name))
    assert np.array_equal(pieces_of(glued, len(faces)), face_components(faces))
    assert pieces_of(glued, len(faces)).max() + 1 == pieces
