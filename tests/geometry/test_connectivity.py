"""Edges, boundaries and components; neighbours that agree about the outside; no more than a surface anywhere."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.core.errors import MeshError
from tactile_maps.geometry.remesh.repair import inside_out
from tactile_maps.geometry.surface import connectivity
from tactile_maps.geometry.surface.connectivity import (
    Connectivity,
    components_of,
    flip_faces,
    manifold_twins,
    orient_faces,
    same_direction,
    side_ends,
    split_nonmanifold,
    twins_within,
)
from tactile_maps.geometry.surface.mesh import Mesh
from tests.hard_cases.meshes import HARD_MESHES, hard_mesh
from tests.support.surfaces import cap, sphere

SQUARE = np.array([[0, 1, 2], [0, 2, 3]])
BOW_TIE = np.array([[0, 1, 2], [0, 3, 4]])


def test_edges_are_numbered_with_their_face_counts() -> None:
    table = Connectivity(SQUARE)
    assert table.edges.tolist() == [[0, 1], [0, 2], [0, 3], [1, 2], [2, 3]]
    assert table.face_count.tolist() == [1, 2, 1, 1, 1]
    assert table.edge_of.tolist() == [[0, 3, 1], [1, 4, 2]]
    assert table.twins.tolist() == [[2, 3]], "side 2 of the first face is side 0 of the second"
    assert table.twin_edges.tolist() == [1]
    assert table.boundary_sides.tolist() == [0, 1, 4, 5]
    assert not any(part.flags.writeable for part in (table.edges, table.edge_of, table.face_count, table.twins))


def test_faces_with_the_same_edge_direction_are_inconsistent() -> None:
    assert Connectivity(SQUARE).agrees_in_direction
    assert not Connectivity(np.array([[0, 1, 2], [0, 3, 2]])).agrees_in_direction


def test_twin_half_edges_run_in_opposite_directions() -> None:
    mesh = cap(1.2, rings=5)
    found = mesh.connectivity
    corners = mesh.faces.ravel()
    one, two = found.twins.T
    np.testing.assert_array_equal(corners[one], corners[side_ends(two)])
    np.testing.assert_array_equal(corners[two], corners[side_ends(one)])
    np.testing.assert_array_equal(found.edge_of.ravel()[one], found.twin_edges)
    np.testing.assert_array_equal(found.edge_of.ravel()[two], found.twin_edges)


def test_face_pairs_and_components_are_found() -> None:
    assert Connectivity(SQUARE).face_pairs.tolist() == [[0, 1]]
    assert Connectivity(SQUARE).components.tolist() == [0, 0]
    assert len(set(Connectivity(BOW_TIE).components.tolist())) == 2


def test_boundary_of_a_square_is_one_loop() -> None:
    assert sorted(Connectivity(SQUARE).boundary_edges.tolist()) == [[0, 1], [1, 2], [2, 3], [3, 0]]
    (loop,) = Connectivity(SQUARE).boundary_loops
    assert sorted(loop.tolist()) == [0, 1, 2, 3]


def test_tube_has_two_border_loops_and_a_ball_none() -> None:
    assert [len(loop) for loop in HARD_MESHES["open tube"].connectivity.boundary_loops] == [40, 40]
    assert HARD_MESHES["sphere"].connectivity.boundary_loops == ()


def test_vertex_with_two_fans_is_found_and_rejected() -> None:
    assert Connectivity(BOW_TIE).bow_tie_vertices.tolist() == [0]
    with pytest.raises(MeshError, match="vertex 0"):
        _ = Connectivity(BOW_TIE).boundary_loops


def test_inconsistently_oriented_faces_are_rejected() -> None:
    with pytest.raises(MeshError, match="simple loops"):
        _ = Connectivity(np.array([[0, 1, 2], [0, 3, 2]])).boundary_loops


@pytest.mark.parametrize(("name", "value"), [("sphere", 2), ("torus", 0), ("open tube", 0), ("flat plate", 1)])
def test_euler_characteristic_is_correct(name: str, value: int) -> None:
    assert HARD_MESHES[name].connectivity.euler_characteristic == value


@pytest.mark.parametrize(
    ("name", "closed"),
    [("sphere", True), ("torus", True), ("open tube", False), ("moebius", False), ("soup", False), ("fin", False)],
)
def test_closed_manifolds_are_recognized(name: str, closed: bool) -> None:
    assert HARD_MESHES[name].connectivity.is_closed_manifold is closed


def test_unreferenced_vertices_are_removed_and_faces_renumbered() -> None:
    faces, kept = connectivity.remove_unreferenced(np.array([[7, 3, 9]]))
    assert (faces.tolist(), kept.tolist()) == ([[1, 0, 2]], [3, 7, 9])


def test_faces_touching_a_vertex_are_found() -> None:
    assert connectivity.faces_touching(SQUARE, np.array([1]), 4).tolist() == [True, False]


def test_averaging_matrix_gives_the_mean_of_neighbours_or_zero_without_neighbours() -> None:
    mean = connectivity.averaging_matrix(np.array([[0, 1], [0, 2]]), 4) @ np.array([1.0, 2.0, 4.0, 8.0])
    assert mean.tolist() == [3.0, 1.0, 1.0, 0.0]


def oriented(mesh: Mesh):
    return orient_faces(mesh.faces, mesh.face_areas)


def clashing_edges(faces: np.ndarray) -> int:
    """Edges of exactly two faces that run through it the same way, counted one by one."""
    directed: dict[tuple[int, int], list[int]] = {}
    for a, b, c in faces.tolist():
        for start, end in ((a, b), (b, c), (c, a)):
            directed.setdefault((min(start, end), max(start, end)), []).append(start)
    return sum(len(starts) == 2 and starts[0] == starts[1] for starts in directed.values())


@pytest.mark.parametrize("name", ["turned at random", "soup", "torus", "three holes", "two triangles", "loose pieces"])
def test_adjacent_faces_are_consistent_after_orientation(name: str) -> None:
    mesh = hard_mesh(name)
    result = oriented(mesh)
    assert result.clashes == 0
    assert clashing_edges(flip_faces(mesh.faces, result.turned)) == 0


def test_mesh_turned_at_random_has_many_inconsistent_faces() -> None:
    assert clashing_edges(hard_mesh("turned at random").faces) > 100


@pytest.mark.parametrize("name", ["moebius", "klein bottle"])
def test_orientation_of_a_one_sided_surface_counts_the_remaining_conflicts(name: str) -> None:
    mesh = hard_mesh(name)
    result = oriented(mesh)
    left = clashing_edges(flip_faces(mesh.faces, result.turned))
    assert 0 < left == result.clashes < 0.3 * np.sqrt(3 * len(mesh.faces)) + 40


def test_orientation_flips_the_smaller_area() -> None:
    ball = sphere()
    few = np.arange(len(ball.faces)) < 100
    assert np.array_equal(oriented(Mesh(ball.vertices, flip_faces(ball.faces, few))).turned, few)
    assert np.array_equal(oriented(Mesh(ball.vertices, flip_faces(ball.faces, ~few))).turned, few)


def test_each_component_is_oriented_independently_and_labelled() -> None:
    mesh = HARD_MESHES["two components"]
    few = np.zeros(len(mesh.faces), dtype=bool)
    few[[3, 2000]] = True
    result = oriented(Mesh(mesh.vertices, flip_faces(mesh.faces, few)))
    assert np.array_equal(result.turned, few)
    assert np.array_equal(np.bincount(result.component), [1280, 1280])


def test_edge_with_three_faces_pairs_the_two_of_one_component() -> None:
    fin = HARD_MESHES["fin"]
    component = oriented(fin).component
    assert component.max() == 1, "the fin is a component of its own"
    assert len(fin.connectivity.twins) == 17
    paired = twins_within(fin.faces, component)
    assert len(paired) == 18
    assert not same_direction(fin.faces, paired).any()


@pytest.mark.parametrize("angle", [1.0, 2.0, 3.0])
def test_cap_faces_away_from_its_centre_only_if_the_file_is_ambiguous(angle: float) -> None:
    mesh = cap(angle)
    inverted = Mesh(mesh.vertices, mesh.faces[:, ::-1])
    component = np.zeros(len(mesh.faces), dtype=int)
    opened = np.array([False])
    assert inside_out(inverted, component, opened, np.array([0.6])).all()
    assert not inside_out(mesh, component, opened, np.array([0.6])).any()
    assert not inside_out(inverted, component, opened, np.array([1.0])).any()


def test_closed_component_faces_outward_for_any_orientation_of_the_file() -> None:
    ball = sphere()
    component = np.zeros(len(ball.faces), dtype=int)
    closed = np.array([True])
    assert inside_out(Mesh(ball.vertices + 5.0, ball.faces[:, ::-1]), component, closed, np.array([1.0])).all()
    assert not inside_out(Mesh(ball.vertices + 5.0, ball.faces), component, closed, np.array([1.0])).any()


def taken_apart(mesh: Mesh):
    oriented = orient_faces(mesh.faces, mesh.face_areas)
    faces = flip_faces(mesh.faces, oriented.turned)
    twins = manifold_twins(faces, oriented.component)
    return faces, twins, *split_nonmanifold(faces, twins)


def fans(faces: np.ndarray) -> int:
    """Fans of faces around every vertex, counted by walking over shared edges."""
    total = 0
    for vertex in np.unique(faces):
        own = [set(face.tolist()) - {vertex} for face in faces[(faces == vertex).any(axis=1)]]
        while own:
            fan = own.pop()
            total = total + 1
            while touching := next((other for other in own if other & fan), None):
                own.remove(touching)
                fan = fan | touching
    return total


@pytest.mark.parametrize("name", ["fin", "book", "two cubes", "bow-ties", "cube", "one triangle", "moebius"])
def test_split_mesh_has_at_most_two_faces_at_an_edge_and_one_fan_at_a_vertex(name: str) -> None:
    mesh = hard_mesh(name)
    before, _, faces, vertex_of = taken_apart(mesh)
    assert Connectivity(faces).face_count.max() <= 2
    assert not len(Connectivity(faces).bow_tie_vertices)
    assert fans(faces) == len(vertex_of) == faces.max() + 1
    assert np.array_equal(vertex_of[faces], before), "no face is lost or moved"
    assert (np.diff(vertex_of) >= 0).all()


def test_valid_mesh_keeps_its_vertex_numbers() -> None:
    mesh = hard_mesh("torus")
    _, _, faces, vertex_of = taken_apart(mesh)
    assert np.array_equal(faces, mesh.faces)
    assert np.array_equal(vertex_of, np.arange(len(mesh.vertices)))


def test_fin_becomes_a_component_and_box_stays_connected() -> None:
    _, twins, faces, _ = taken_apart(hard_mesh("fin"))
    component = components_of(twins, len(faces))
    assert np.array_equal(np.bincount(component), [12, 1])
    assert (Connectivity(faces[component == 0]).face_count == 2).all()


@pytest.mark.parametrize(("name", "pieces"), [("book", 5), ("two cubes", 2), ("bow-ties", 4), ("torus", 1)])
def test_components_match_the_split_faces(name: str, pieces: int) -> None:
    _, twins, faces, _ = taken_apart(hard_mesh(name))
    assert np.array_equal(components_of(twins, len(faces)), Connectivity(faces).components)
    assert components_of(twins, len(faces)).max() + 1 == pieces
