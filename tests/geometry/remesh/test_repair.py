"""A file's mesh cleaned or repaired: what leaves can be flattened, and every change leads back to the file."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.core.errors import MeshError
from tactile_maps.geometry.remesh.repair import (
    RepairedMesh,
    clean_mesh,
    flip_degenerate_faces,
    is_degenerate,
    repair_mesh,
    unique_faces,
    weld_tolerance,
    weld_vertices,
)
from tactile_maps.geometry.surface.connectivity import Connectivity, orient_faces
from tactile_maps.geometry.surface.mesh import Mesh
from tests.hard_cases.meshes import (
    GROUPS,
    HARD_MESHES,
    HOPELESS,
    hard_mesh,
    jittered,
    loose,
    moved,
    scaled,
    turned_at_random,
    with_flat_fans,
)
from tests.support.cost import Cost, cost_of
from tests.support.surfaces import cap, frustum, sphere


def test_cleaning_does_not_change_a_valid_mesh() -> None:
    cleaned, findings = clean_mesh(HARD_MESHES["sphere"])
    assert findings == ()
    assert cleaned.area == pytest.approx(HARD_MESHES["sphere"].area)
    assert cleaned.connectivity.is_closed_manifold


def test_each_defect_is_counted_by_cleaning() -> None:
    _, findings = clean_mesh(HARD_MESHES["duplicates"], where="shell")
    assert {(f.kind, f.where, f.count) for f in findings} == {
        ("duplicate-vertex", "shell", 8),
        ("duplicate-face", "shell", 12),
    }
    _, findings = clean_mesh(HARD_MESHES["zero-area faces"])
    # One of the three bad faces has three distinct corners, on a line or not; two name a corner twice.
    assert [(f.kind, f.count) for f in findings] == [("zero-area-face", 3)]


def test_welding_keeps_the_shape_far_from_the_origin() -> None:
    cleaned, _ = clean_mesh(HARD_MESHES["huge offset"])
    assert cleaned.area == pytest.approx(HARD_MESHES["cube"].area, rel=1e-9)


def test_unused_vertices_are_removed() -> None:
    cleaned, _ = clean_mesh(Mesh([[9, 9, 9], [0, 0, 0], [1, 0, 0], [0, 1, 0]], [[1, 2, 3]]))
    assert len(cleaned.vertices) == 3


def test_mesh_without_area_raises_an_error_with_its_name() -> None:
    with pytest.raises(MeshError, match="wrist: the mesh has no face with an area"):
        clean_mesh(Mesh(np.zeros((3, 3)), [[0, 1, 2]]), where="wrist")


def test_vertices_within_tolerance_are_welded_anywhere() -> None:
    rng = np.random.default_rng(0)
    points = rng.uniform(size=(200, 3))
    copies = np.concatenate([points, points + 4e-7 * rng.uniform(-1, 1, size=(200, 3)), points])
    assert np.array_equal(weld_vertices(copies, 1e-6), np.tile(np.arange(200), 3))


def test_chain_of_close_vertices_is_welded_and_a_wider_chain_is_not() -> None:
    row = np.stack([np.arange(10.0), np.zeros(10), np.zeros(10)], axis=1)
    assert all((weld_vertices(gap * row, 1.0) == 0).all() for gap in np.linspace(0.05, 1.0, 40))
    assert len(np.unique(weld_vertices(2.1 * row, 1.0))) == 10


def test_tolerance_grows_with_size_and_with_distance_from_the_origin() -> None:
    cube = HARD_MESHES["cube"].vertices
    here = weld_tolerance(cube)
    assert weld_tolerance(1e6 * cube) == pytest.approx(1e6 * here)
    assert weld_tolerance(cube + 1e3) == pytest.approx(here)
    assert weld_tolerance(cube + 1e12) > 1e-4


def test_first_of_several_faces_with_equal_corners_is_kept() -> None:
    faces = np.array([[0, 1, 2], [3, 1, 2], [2, 1, 0], [1, 2, 0], [3, 2, 1]])
    assert unique_faces(faces).tolist() == [0, 1]


TOLERANCE = 1e-7


def flipped_away(mesh: Mesh):
    return flip_degenerate_faces(mesh.vertices / mesh.size, mesh.faces, TOLERANCE)


def test_flatness_is_the_height_divided_by_the_longest_side() -> None:
    corners = np.array([[[0, 0, 0], [2, 0, 0], [1, 1e-3, 0]], [[0, 0, 0], [1e-3, 0, 0], [0, 1, 0]]])
    assert is_degenerate(corners, 1.01e-3).tolist() == [True, True]
    assert is_degenerate(corners, 0.99e-3).tolist() == [False, False]
    assert is_degenerate(np.zeros((1, 3, 3)), 1e-9).all()


@pytest.mark.parametrize("count", [2, 8, 40])
def test_fan_of_flat_faces_becomes_a_fan_of_the_face_behind_it(count: int) -> None:
    mesh = with_flat_fans(count)
    assert is_degenerate(mesh.vertices[mesh.faces] / mesh.size, TOLERANCE).sum() == count
    faces, owner, flat = flipped_away(mesh)
    assert not flat.any()
    assert len(faces) == len(mesh.faces)
    after = Mesh(mesh.vertices, faces)
    assert after.area == pytest.approx(mesh.area, rel=1e-12)
    assert Connectivity(faces).euler_characteristic == 1
    assert len(Connectivity(faces).boundary_loops) == 1, "no slit opens"
    assert Connectivity(faces).face_count.max() == 2
    assert (after.face_normals[:, 2] > 0.999).all(), "nothing folds over"
    assert np.bincount(owner, after.face_areas, len(faces)) == pytest.approx(mesh.face_areas, abs=1e-15)


def test_flat_face_on_the_border_is_not_flipped() -> None:
    vertices = [[0, 0, 0], [2, 0, 0], [1, 0, 0], [0.2, 1, 0], [1.8, 1, 0]]
    mesh = Mesh(vertices, [[0, 1, 2], [0, 2, 3], [2, 1, 4], [2, 4, 3]])
    faces, owner, flat = flipped_away(mesh)
    assert flat.tolist() == [True, False, False, False]
    assert np.array_equal(faces, mesh.faces)
    assert owner.tolist() == [0, 1, 2, 3]


def test_no_flip_creates_an_existing_edge() -> None:
    pocket = Mesh([[0, 0, 0], [2, 0, 0], [1, 0, 0], [1, 1, 0]], [[0, 2, 1], [0, 1, 3], [2, 0, 3], [1, 2, 3]])
    faces, _, flat = flipped_away(pocket)
    assert flat.tolist() == [True, False, False, False]
    assert np.array_equal(faces, pocket.faces)


def test_mesh_without_flat_faces_is_unchanged() -> None:
    mesh = hard_mesh("torus")
    faces, owner, flat = flipped_away(mesh)
    assert np.array_equal(faces, mesh.faces)
    assert np.array_equal(owner, np.arange(len(faces)))
    assert not flat.any()


EVERY = [name for names in GROUPS.values() for name in names]


def reported(result: RepairedMesh) -> dict[str, int]:
    return {finding.kind: finding.count for finding in result.findings}


@pytest.mark.sampled(8)
@pytest.mark.parametrize("name", EVERY)
def test_repaired_mesh_can_be_flattened(name: str) -> None:
    mesh = repair_mesh(hard_mesh(name)).mesh
    assert mesh.connectivity.face_count.max() <= 2
    assert orient_faces(mesh.faces, mesh.face_areas).clashes == 0
    assert not orient_faces(mesh.faces, mesh.face_areas).turned.any()
    assert not len(mesh.connectivity.bow_tie_vertices)
    _ = mesh.connectivity.boundary_loops  # raises where the border is not made of simple loops
    assert mesh.face_areas.min() > 0
    assert len(np.unique(mesh.faces)) == len(mesh.vertices)


@pytest.mark.sampled(6)
@pytest.mark.parametrize("name", EVERY)
def test_repaired_vertices_and_faces_map_back_to_the_file(name: str) -> None:
    mesh = hard_mesh(name)
    result = repair_mesh(mesh)
    assert np.array_equal(result.mesh.vertices, mesh.vertices[result.vertex_of])
    assert np.array_equal(np.union1d(result.face_of, result.dropped), np.arange(len(mesh.faces)))
    assert not np.isin(result.dropped, result.face_of).any()
    assert np.array_equal(result.component, result.mesh.connectivity.components)
    size = np.linalg.norm(np.ptp(mesh.vertices[np.unique(mesh.faces)], axis=0))
    welded = mesh.vertices[result.welded]
    assert np.linalg.norm(welded[:, 0] - welded[:, 1], axis=1).max(initial=0) < 1e-6 * size
    # Each face of the file keeps its corners, or is split where a flat neighbour had a corner on its side.
    stands_for = np.arange(len(mesh.vertices))
    stands_for[result.welded[:, 0]] = result.welded[:, 1]
    same = np.sort(result.vertex_of[result.mesh.faces], axis=1) == np.sort(
        stands_for[mesh.faces[result.face_of]], axis=1
    )
    split = np.isin(result.face_of, np.flatnonzero(np.bincount(result.face_of) > 1))
    assert (same.all(axis=1) | split).all()


def test_valid_mesh_is_unchanged_bit_for_bit() -> None:
    mesh = frustum(0.05, 0.03, bump=0.2)
    result = repair_mesh(mesh)
    assert result.findings == ()
    assert result.mesh.vertices.tobytes() == mesh.vertices.tobytes()
    assert np.array_equal(result.mesh.faces, mesh.faces)
    for changed in (result.welded, result.dropped, result.turned):
        assert not len(changed)


def test_each_defect_is_counted() -> None:
    assert reported(repair_mesh(HARD_MESHES["zero-area faces"])) == {"zero-area-face": 3}
    assert reported(repair_mesh(HARD_MESHES["duplicates"])) == {"duplicate-vertex": 8, "duplicate-face": 12}
    assert reported(repair_mesh(HARD_MESHES["inside out"])) == {"turned-face": 12}
    assert reported(repair_mesh(HARD_MESHES["fin"])) == {"non-manifold-edge": 1}
    assert reported(repair_mesh(hard_mesh("bow-ties"))) == {"duplicate-vertex": 3, "non-manifold-vertex": 3}
    assert reported(repair_mesh(with_flat_fans(8))) == {"flat-face": 8}
    assert set(reported(repair_mesh(hard_mesh("moebius")))) == {"one-sided", "turned-face"}
    ball = sphere()
    assert reported(repair_mesh(loose(ball))) == {"duplicate-vertex": ball.faces.size - len(ball.vertices)}


def test_findings_name_the_mesh() -> None:
    assert {finding.where for finding in repair_mesh(HARD_MESHES["soup"], where="wrist").findings} == {"wrist"}


@pytest.mark.parametrize("shape", [sphere, frustum], ids=["closed", "open"])
def test_mesh_with_split_vertices_and_flipped_faces_is_restored(shape) -> None:
    mesh = shape()
    back = repair_mesh(turned_at_random(jittered(mesh, 1e-9))).mesh
    assert len(back.vertices) == len(mesh.vertices)
    assert back.area == pytest.approx(mesh.area, rel=1e-5)
    outward = (back.face_normals * (back.vertices[back.faces].mean(axis=1) - mesh.bounds.mean(axis=0))).sum(axis=1)
    assert (outward > 0).all()


def test_vertices_on_both_sides_of_a_cell_boundary_are_welded() -> None:
    rng = np.random.default_rng(0)
    ball = sphere()
    for _ in range(5):
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        torn = jittered(Mesh(ball.vertices @ turn.T + rng.normal(size=3), ball.faces), 1e-9)
        assert Connectivity(repair_mesh(torn).mesh.faces).is_closed_manifold


def test_inner_shells_are_oriented_outward() -> None:
    result = repair_mesh(HARD_MESHES["inner shell"])
    corners = result.mesh.vertices[result.mesh.faces]
    assert (np.bincount(result.component, np.linalg.det(corners) / 6) > 0).all()


def test_open_component_keeps_its_unambiguous_orientation() -> None:
    mesh = cap(1.0)
    inverted = Mesh(mesh.vertices, mesh.faces[:, ::-1])
    assert repair_mesh(inverted).findings == ()


@pytest.mark.sampled(5)
@pytest.mark.parametrize("scale", [1e-6, 1e-3, 1e3, 1e6])
@pytest.mark.parametrize("name", ["soup", "flat fans", "slivers 1e-6", "book", "nearly touching"])
def test_repair_does_not_depend_on_the_unit(name: str, scale: float) -> None:
    mesh = hard_mesh(name)
    result = repair_mesh(hard_mesh(name))
    there = repair_mesh(scaled(mesh, scale))
    assert np.array_equal(there.mesh.faces, result.mesh.faces)
    assert reported(there) == reported(result)


@pytest.mark.parametrize("name", ["soup", "flat fans", "book", "fin"])
def test_repair_does_not_depend_on_the_offset(name: str) -> None:
    there = repair_mesh(moved(hard_mesh(name), (1e6, -1e6, 1e6)))
    assert reported(there) == reported(repair_mesh(hard_mesh(name)))


@pytest.mark.parametrize("name", [*HOPELESS])
def test_mesh_without_area_or_size_is_rejected_by_name(name: str) -> None:
    with pytest.raises(MeshError, match=f"{name}.*: the mesh (has no face with an area|is implausibly)"):
        repair_mesh(HOPELESS[name], where=name)


@pytest.mark.long
def test_cost_does_not_depend_on_the_number_of_pieces() -> None:
    def cost(pieces: int) -> Cost:
        rng = np.random.default_rng(0)
        corners = rng.normal(size=(pieces, 1, 3)) + 1e-3 * rng.normal(size=(pieces, 3, 3))
        soup = Mesh(corners.reshape(-1, 3), np.arange(3 * pieces).reshape(-1, 3))
        assert repair_mesh(soup).component.max() + 1 == pieces
        return cost_of(lambda: repair_mesh(soup))

    few = cost(2500)
    many = cost(10_000)
    assert many.steps < 1.2 * few.steps
    assert many.memory < 1.5 * 4 * few.memory
