from __future__ import annotations

import numpy as np
import pytest

from app.errors import MeshError
from app.geometry.clean import clean, distinct_faces, weld_tolerance, welded
from app.geometry.mesh import Mesh
from app.geometry.topology import is_closed_manifold
from tests.numerics.hard_meshes import HARD_MESHES


def test_a_sound_mesh_is_left_alone() -> None:
    cleaned, findings = clean(HARD_MESHES["sphere"])
    assert findings == ()
    assert cleaned.area == pytest.approx(HARD_MESHES["sphere"].area)
    assert is_closed_manifold(cleaned.faces)


def test_each_defect_is_counted() -> None:
    _, findings = clean(HARD_MESHES["duplicates"], where="shell")
    assert {(f.kind, f.where, f.count) for f in findings} == {
        ("duplicate-vertex", "shell", 8),
        ("duplicate-face", "shell", 12),
    }
    _, findings = clean(HARD_MESHES["zero-area faces"])
    # One of the three bad faces has three distinct corners, on a line or not; two name a corner twice.
    assert [(f.kind, f.count) for f in findings] == [("zero-area-face", 3)]


def test_welding_keeps_the_shape_far_from_the_origin() -> None:
    cleaned, _ = clean(HARD_MESHES["huge offset"])
    assert cleaned.area == pytest.approx(HARD_MESHES["cube"].area, rel=1e-9)


def test_unused_vertices_go() -> None:
    cleaned, _ = clean(Mesh([[9, 9, 9], [0, 0, 0], [1, 0, 0], [0, 1, 0]], [[1, 2, 3]]))
    assert len(cleaned.vertices) == 3


def test_nothing_with_area_is_an_error_that_names_the_mesh() -> None:
    with pytest.raises(MeshError, match="wrist: the mesh has no face with an area"):
        clean(Mesh(np.zeros((3, 3)), [[0, 1, 2]]), where="wrist")


def test_vertices_within_the_tolerance_are_one_wherever_they_lie() -> None:
    rng = np.random.default_rng(0)
    points = rng.uniform(size=(200, 3))
    copies = np.concatenate([points, points + 4e-7 * rng.uniform(-1, 1, size=(200, 3)), points])
    assert np.array_equal(welded(copies, 1e-6), np.tile(np.arange(200), 3))


def test_a_chain_of_close_vertices_is_one_and_a_wider_one_is_not() -> None:
    row = np.stack([np.arange(10.0), np.zeros(10), np.zeros(10)], axis=1)
    assert all((welded(gap * row, 1.0) == 0).all() for gap in np.linspace(0.05, 1.0, 40))
    assert len(np.unique(welded(2.1 * row, 1.0))) == 10


def test_the_tolerance_grows_with_size_and_with_distance_from_the_origin() -> None:
    cube = HARD_MESHES["cube"].vertices
    here = weld_tolerance(cube)
    assert weld_tolerance(1e6 * cube) == pytest.approx(1e6 * here)
    assert weld_tolerance(cube + 1e3) == pytest.approx(here)
    assert weld_tolerance(cube + 1e12) > 1e-4


def test_distinct_faces_are_the_first_of_their_corners() -> None:
    faces = np.array([[0, 1, 2], [3, 1, 2], [2, 1, 0], [1, 2, 0], [3, 2, 1]])
    assert distinct_faces(faces).tolist() == [0, 1]
