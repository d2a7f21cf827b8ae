from __future__ import annotations

import time

import numpy as np
import pytest

from app.errors import MeshError
from app.geometry.mesh import Mesh
from app.geometry.orient import orient
from app.geometry.repair import Repaired, repair
from app.geometry.topology import boundary_loops, bow_tie_vertices, edge_table, face_components, is_closed_manifold
from tests.numerics.hard_groups import (
    GROUPS,
    HOPELESS,
    hard_mesh,
    jittered,
    loose,
    scaled,
    turned_at_random,
    with_flat_fans,
)
from tests.numerics.hard_meshes import HARD_MESHES, moved
from tests.numerics.map_surfaces import cap, frustum, sphere

EVERY = [name for names in GROUPS.values() for name in names]


def told(result: Repaired) -> dict[str, int]:
    return {finding.kind: finding.count for finding in result.findings}


@pytest.mark.parametrize("name", EVERY)
def test_what_leaves_can_be_laid_flat(name: str) -> None:
    mesh = repair(hard_mesh(name)).mesh
    assert edge_table(mesh.faces).face_count.max() <= 2
    assert orient(mesh.faces, mesh.face_areas).clashes == 0
    assert not orient(mesh.faces, mesh.face_areas).turned.any()
    assert not len(bow_tie_vertices(mesh.faces))
    boundary_loops(mesh.faces)  # raises where the border is not made of simple loops
    assert mesh.face_areas.min() > 0
    assert len(np.unique(mesh.faces)) == len(mesh.vertices)


@pytest.mark.parametrize("name", EVERY)
def test_every_change_leads_back_to_the_file(name: str) -> None:
    mesh = hard_mesh(name)
    result = repair(mesh)
    assert np.array_equal(result.mesh.vertices, mesh.vertices[result.vertex_of])
    assert np.array_equal(np.union1d(result.face_of, result.dropped), np.arange(len(mesh.faces)))
    assert not np.isin(result.dropped, result.face_of).any()
    assert np.array_equal(result.piece, face_components(result.mesh.faces))
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


def test_a_sound_mesh_is_left_alone_to_the_last_bit() -> None:
    mesh = frustum(0.05, 0.03, bump=0.2)
    result = repair(mesh)
    assert result.findings == ()
    assert result.mesh.vertices.tobytes() == mesh.vertices.tobytes()
    assert np.array_equal(result.mesh.faces, mesh.faces)
    for changed in (result.welded, result.dropped, result.turned):
        assert not len(changed)


def test_each_defect_is_counted() -> None:
    assert told(repair(HARD_MESHES["zero-area faces"])) == {"zero-area-face": 3}
    assert told(repair(HARD_MESHES["duplicates"])) == {"duplicate-vertex": 8, "duplicate-face": 12}
    assert told(repair(HARD_MESHES["inside out"])) == {"turned-face": 12}
    assert told(repair(HARD_MESHES["fin"])) == {"non-manifold-edge": 1}
    assert told(repair(hard_mesh("bow-ties"))) == {"duplicate-vertex": 3, "non-manifold-vertex": 3}
    assert told(repair(with_flat_fans(8))) == {"flat-face": 8}
    assert set(told(repair(hard_mesh("moebius")))) == {"one-sided", "turned-face"}
    ball = sphere()
    assert told(repair(loose(ball))) == {"duplicate-vertex": ball.faces.size - len(ball.vertices)}


def test_the_findings_name_the_mesh() -> None:
    assert {finding.where for finding in repair(HARD_MESHES["soup"], where="wrist").findings} == {"wrist"}


@pytest.mark.parametrize("shape", [sphere, frustum], ids=["closed", "open"])
def test_a_mesh_torn_and_turned_is_whole_again(shape) -> None:
    mesh = shape()
    back = repair(turned_at_random(jittered(mesh, 1e-9))).mesh
    assert len(back.vertices) == len(mesh.vertices)
    assert back.area == pytest.approx(mesh.area, rel=1e-5)
    outward = (back.face_normals * (back.vertices[back.faces].mean(axis=1) - mesh.bounds.mean(axis=0))).sum(axis=1)
    assert (outward > 0).all()


def test_vertices_are_welded_across_the_lines_of_any_grid() -> None:
    rng = np.random.default_rng(0)
    ball = sphere()
    for _ in range(5):
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        torn = jittered(Mesh(ball.vertices @ turn.T + rng.normal(size=3), ball.faces), 1e-9)
        assert is_closed_manifold(repair(torn).mesh.faces)


def test_inner_shells_are_turned_outward_too() -> None:
    result = repair(HARD_MESHES["inner shell"])
    corners = result.mesh.vertices[result.mesh.faces]
    assert (np.bincount(result.piece, np.linalg.det(corners) / 6) > 0).all()


def test_an_open_piece_keeps_its_clear_side() -> None:
    mesh = cap(1.0)
    inverted = Mesh(mesh.vertices, mesh.faces[:, ::-1])
    assert repair(inverted).findings == ()


@pytest.mark.parametrize("scale", [1e-6, 1e-3, 1e3, 1e6])
@pytest.mark.parametrize("name", ["soup", "flat fans", "slivers 1e-6", "book", "nearly touching"])
def test_the_unit_does_not_matter(name: str, scale: float) -> None:
    mesh, result = hard_mesh(name), repair(hard_mesh(name))
    there = repair(scaled(mesh, scale))
    assert np.array_equal(there.mesh.faces, result.mesh.faces)
    assert told(there) == told(result)


@pytest.mark.parametrize("name", ["soup", "flat fans", "book", "fin"])
def test_the_offset_does_not_matter(name: str) -> None:
    there = repair(moved(hard_mesh(name), (1e6, -1e6, 1e6)))
    assert told(there) == told(repair(hard_mesh(name)))


@pytest.mark.parametrize("name", [*HOPELESS])
def test_what_has_no_area_or_no_size_is_refused_by_name(name: str) -> None:
    with pytest.raises(MeshError, match=f"{name}.*: the mesh (has no face with an area|is absurdly)"):
        repair(HOPELESS[name], where=name)


def test_many_pieces_cost_no_more_than_one() -> None:
    rng = np.random.default_rng(0)
    corners = rng.normal(size=(45_000, 1, 3)) + 1e-3 * rng.normal(size=(45_000, 3, 3))
    soup = Mesh(corners.reshape(-1, 3), np.arange(135_000).reshape(-1, 3))
    start = time.perf_counter()
    assert repair(soup).piece.max() + 1 == 45_000
    assert time.perf_counter() - start < 3.0
