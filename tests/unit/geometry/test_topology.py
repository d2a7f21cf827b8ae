from __future__ import annotations

import numpy as np
import pytest

from app.errors import MeshError
from app.geometry import topology
from tests.numerics.hard_meshes import HARD_MESHES

SQUARE = np.array([[0, 1, 2], [0, 2, 3]])
BOW_TIE = np.array([[0, 1, 2], [0, 3, 4]])


def test_edge_table_counts_the_faces_beside_each_edge() -> None:
    table = topology.edge_table(SQUARE)
    assert table.edges.tolist() == [[0, 1], [0, 2], [0, 3], [1, 2], [2, 3]]
    assert table.face_count.tolist() == [1, 2, 1, 1, 1]
    assert table.edge_of.tolist() == [[0, 3, 1], [1, 4, 2]]


def test_face_pairs_and_components() -> None:
    assert topology.face_pairs(SQUARE).tolist() == [[0, 1]]
    assert topology.face_components(SQUARE).tolist() == [0, 0]
    assert len(set(topology.face_components(BOW_TIE).tolist())) == 2


def test_boundary_of_a_square_is_one_loop() -> None:
    assert sorted(topology.boundary_edges(SQUARE).tolist()) == [[0, 1], [1, 2], [2, 3], [3, 0]]
    (loop,) = topology.boundary_loops(SQUARE)
    assert sorted(loop.tolist()) == [0, 1, 2, 3]


def test_a_tube_has_two_loops_and_a_ball_none() -> None:
    assert [len(loop) for loop in topology.boundary_loops(HARD_MESHES["open tube"].faces)] == [40, 40]
    assert topology.boundary_loops(HARD_MESHES["sphere"].faces) == []


def test_two_fans_at_a_vertex_are_found_and_refused() -> None:
    assert topology.bow_tie_vertices(BOW_TIE).tolist() == [0]
    with pytest.raises(MeshError, match="vertex 0"):
        topology.boundary_loops(BOW_TIE)


def test_faces_that_disagree_in_direction_are_refused() -> None:
    with pytest.raises(MeshError, match="simple loops"):
        topology.boundary_loops(np.array([[0, 1, 2], [0, 3, 2]]))


@pytest.mark.parametrize(("name", "value"), [("sphere", 2), ("torus", 0), ("open tube", 0), ("flat plate", 1)])
def test_euler_characteristic(name: str, value: int) -> None:
    assert topology.euler_characteristic(HARD_MESHES[name].faces) == value


@pytest.mark.parametrize(
    ("name", "closed"),
    [("sphere", True), ("torus", True), ("open tube", False), ("moebius", False), ("soup", False), ("fin", False)],
)
def test_closed_manifold(name: str, closed: bool) -> None:
    assert topology.is_closed_manifold(HARD_MESHES[name].faces) is closed


def test_compact_renumbers() -> None:
    faces, kept = topology.compact(np.array([[7, 3, 9]]))
    assert (faces.tolist(), kept.tolist()) == ([[1, 0, 2]], [3, 7, 9])


def test_faces_at_a_vertex() -> None:
    assert topology.faces_at(SQUARE, np.array([1]), 4).tolist() == [True, False]


def test_averaging_takes_the_mean_of_neighbours_and_leaves_loners_at_zero() -> None:
    mean = topology.averaging(np.array([[0, 1], [0, 2]]), 4) @ np.array([1.0, 2.0, 4.0, 8.0])
    assert mean.tolist() == [3.0, 1.0, 1.0, 0.0]
