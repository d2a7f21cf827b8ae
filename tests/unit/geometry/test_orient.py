from __future__ import annotations

import numpy as np
import pytest

from app.geometry.mesh import Mesh
from app.geometry.orient import inside_out, orient, paired_sides, same_direction, turn
from tests.numerics.hard_groups import hard_mesh
from tests.numerics.hard_meshes import HARD_MESHES
from tests.numerics.map_surfaces import cap, sphere


def oriented(mesh: Mesh):
    return orient(mesh.faces, mesh.face_areas)


def clashing_edges(faces: np.ndarray) -> int:
    """Edges of exactly two faces that run through it the same way, counted one by one."""
    directed: dict[tuple[int, int], list[int]] = {}
    for a, b, c in faces.tolist():
        for start, end in ((a, b), (b, c), (c, a)):
            directed.setdefault((min(start, end), max(start, end)), []).append(start)
    return sum(len(starts) == 2 and starts[0] == starts[1] for starts in directed.values())


@pytest.mark.parametrize("name", ["turned at random", "soup", "torus", "three holes", "two triangles", "loose pieces"])
def test_neighbours_agree_afterwards(name: str) -> None:
    mesh = hard_mesh(name)
    result = oriented(mesh)
    assert result.clashes == 0
    assert clashing_edges(turn(mesh.faces, result.turned)) == 0


def test_the_precondition_of_that_test() -> None:
    assert clashing_edges(hard_mesh("turned at random").faces) > 100


@pytest.mark.parametrize("name", ["moebius", "klein bottle"])
def test_a_one_sided_surface_keeps_a_few_clashes_and_counts_them(name: str) -> None:
    mesh = hard_mesh(name)
    result = oriented(mesh)
    left = clashing_edges(turn(mesh.faces, result.turned))
    assert 0 < left == result.clashes < 0.3 * np.sqrt(3 * len(mesh.faces)) + 40


def test_as_little_area_as_possible_turns() -> None:
    ball = sphere()
    few = np.arange(len(ball.faces)) < 100
    assert np.array_equal(oriented(Mesh(ball.vertices, turn(ball.faces, few))).turned, few)
    assert np.array_equal(oriented(Mesh(ball.vertices, turn(ball.faces, ~few))).turned, few)


def test_each_piece_is_decided_by_itself_and_labelled() -> None:
    mesh = HARD_MESHES["two components"]
    few = np.zeros(len(mesh.faces), dtype=bool)
    few[[3, 2000]] = True
    result = oriented(Mesh(mesh.vertices, turn(mesh.faces, few)))
    assert np.array_equal(result.turned, few)
    assert np.array_equal(np.bincount(result.piece), [1280, 1280])


def test_an_edge_with_three_faces_pairs_the_two_of_one_piece() -> None:
    fin = HARD_MESHES["fin"]
    piece = oriented(fin).piece
    assert piece.max() == 1, "the fin is a piece of its own"
    assert len(paired_sides(fin.faces)) == 17
    paired = paired_sides(fin.faces, piece)
    assert len(paired) == 18
    assert not same_direction(fin.faces, paired).any()


@pytest.mark.parametrize("angle", [1.0, 2.0, 3.0])
def test_a_cap_looks_away_from_its_middle_only_when_the_file_is_not_clear(angle: float) -> None:
    mesh = cap(angle)
    inverted = Mesh(mesh.vertices, mesh.faces[:, ::-1])
    piece, opened = np.zeros(len(mesh.faces), dtype=int), np.array([False])
    assert inside_out(inverted, piece, opened, np.array([0.6])).all()
    assert not inside_out(mesh, piece, opened, np.array([0.6])).any()
    assert not inside_out(inverted, piece, opened, np.array([1.0])).any()


def test_a_closed_piece_looks_outward_whatever_the_file_said() -> None:
    ball = sphere()
    piece, closed = np.zeros(len(ball.faces), dtype=int), np.array([True])
    assert inside_out(Mesh(ball.vertices + 5.0, ball.faces[:, ::-1]), piece, closed, np.array([1.0])).all()
    assert not inside_out(Mesh(ball.vertices + 5.0, ball.faces), piece, closed, np.array([1.0])).any()
