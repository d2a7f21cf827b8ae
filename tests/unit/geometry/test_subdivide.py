from __future__ import annotations

import numpy as np
import pytest

from app.errors import MeshError
from app.geometry.mesh import Mesh
from app.geometry.subdivide import subdivide
from app.geometry.topology import edge_table, euler_characteristic
from tests.numerics.hard_groups import hard_mesh
from tests.numerics.hard_meshes import HARD_MESHES


def longest(mesh: Mesh) -> float:
    return float(np.linalg.norm(np.diff(mesh.vertices[mesh.edges], axis=1)[:, 0], axis=1).max())


@pytest.mark.parametrize("name", ["cube", "two triangles", "one triangle", "spike", "star", "book", "needles", "rod"])
@pytest.mark.parametrize("share", [0.3, 0.05])
def test_no_edge_is_too_long_and_the_shape_stays(name: str, share: float) -> None:
    mesh = hard_mesh(name)
    result = subdivide(mesh, longest=share * mesh.size)
    fine = result.mesh
    assert longest(fine) <= 2 * share * mesh.size
    assert np.bincount(result.parent, fine.face_areas) == pytest.approx(mesh.face_areas, rel=1e-9)
    np.testing.assert_allclose(fine.face_normals, mesh.face_normals[result.parent], atol=1e-6)
    assert np.array_equal(fine.vertices[: len(mesh.vertices)], mesh.vertices)
    assert len(np.unique(fine.faces)) == len(np.unique(mesh.faces)) + len(fine.vertices) - len(mesh.vertices)
    assert euler_characteristic(fine.faces) == euler_characteristic(mesh.faces)
    assert edge_table(fine.faces).face_count.max() == max(2, edge_table(mesh.faces).face_count.max())
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


def test_the_faces_are_hardly_more_than_the_area_asks_for() -> None:
    mesh = hard_mesh("cube")
    step = 0.01 * mesh.size
    assert len(subdivide(mesh, longest=step).mesh.faces) < 1.2 * mesh.area / (np.sqrt(3) / 4 * step**2)


def test_a_needle_becomes_a_ladder() -> None:
    needle = Mesh([[0, 0, 0], [1e-3, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    assert len(subdivide(needle, longest=0.01).mesh.faces) < 210


def test_a_fine_mesh_is_returned_as_it_is() -> None:
    mesh = HARD_MESHES["sphere"]
    result = subdivide(mesh, longest=1.01 * longest(mesh))
    assert result.mesh is mesh
    assert np.array_equal(result.parent, np.arange(len(mesh.faces)))


def test_an_absurd_number_of_faces_is_refused() -> None:
    with pytest.raises(MeshError, match="two million"):
        subdivide(HARD_MESHES["cube"], longest=1e-5)
