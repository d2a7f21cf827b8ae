from __future__ import annotations

import numpy as np
import pytest

from app.errors import MeshError
from app.geometry.clean import clean
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
