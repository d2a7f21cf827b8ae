from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.core.errors import MeshError, SkinError
from tactile_maps.geometry.surface.closest_point import ClosestPoint
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.skin.mesh_skin import findings_of_mesh, skin_of_mesh
from tactile_maps.skin.taxel_placement.placement import PaintedZone, PlacementSpec, SphereZone
from tests.hard_cases.meshes import HARD_MESHES, HOPELESS_MESHES, hard_mesh, joined, loose, loose_pieces, moved
from tests.support.findings import kinds, only
from tests.support.surfaces import sphere


@pytest.mark.sampled(5)
@pytest.mark.parametrize("name", ["cube", "sphere", "open tube", "soup", "fin", "two components", "hole", "moebius"])
@pytest.mark.parametrize("pattern", ["even", "hexagonal"])
def test_cells_cover_the_whole_surface_of_the_mesh(name, pattern):
    mesh = HARD_MESHES[name]
    skin = skin_of_mesh(mesh, PlacementSpec(taxels=80, pattern=pattern), name=name, surface="all")
    assert abs(len(skin) - 80) <= 8 * (pattern == "hexagonal")
    assert skin.areas.sum() == pytest.approx(sum(patch.surface.area for patch in skin.patches), rel=1e-9)
    for patch in skin.patches:
        assert patch.link == name
        assert patch.surface.connectivity.components.max() == 0
        _ = patch.surface.connectivity.boundary_loops
        assert ClosestPoint(mesh).query(patch.surface.vertices)[2].max() < 1e-9 * mesh.size


def test_fine_mesh_keeps_its_own_triangles():
    mesh = HARD_MESHES["sphere"]
    (patch,) = skin_of_mesh(mesh, PlacementSpec(taxels=30)).patches
    assert np.array_equal(patch.surface.faces, mesh.faces)
    assert patch.surface.vertices.tobytes() == mesh.vertices.tobytes()


def test_coarse_mesh_is_refined_for_the_taxels():
    (patch,) = skin_of_mesh(HARD_MESHES["cube"], PlacementSpec(taxels=200)).patches
    assert len(patch.surface.faces) > 10 * 200
    assert patch.surface.area == pytest.approx(HARD_MESHES["cube"].area)


@pytest.mark.long
def test_inner_shells_stay_bare_unless_requested():
    mesh = HARD_MESHES["inner shell"]
    spec = PlacementSpec(taxels=40)
    outer = skin_of_mesh(mesh, spec)
    assert len(outer.patches) == 1
    assert np.linalg.norm(outer.patches[0].surface.vertices, axis=1) == pytest.approx(0.1)
    assert kinds(outer.findings)["hidden-face"] == 1280
    everything = skin_of_mesh(mesh, spec, surface="all")
    assert len(everything.patches) == 2
    assert "hidden-face" not in kinds(everything.findings)


@pytest.mark.parametrize("name", ["bowl with walls", "tube with walls", "nested open tubes"])
def test_inner_wall_of_a_shell_is_left_bare_unless_all_is_requested(name):
    mesh = hard_mesh(name)
    spec = PlacementSpec(taxels=40)
    outer = skin_of_mesh(mesh, spec)
    everything = skin_of_mesh(mesh, spec, surface="all")
    assert len(outer.patches) == 1
    covered = sum(patch.surface.area for patch in outer.patches)
    assert 0.5 < covered / mesh.area < 0.6
    note = only(outer.findings, "inner-wall")
    assert note.count > 0.4 * len(mesh.faces)
    assert f"{1e4 * (mesh.area - covered):.3g} cm²" in note.action
    assert outer.coverage == 1.0, "an inner wall was not requested"
    assert "inner-wall" not in kinds(everything.findings)
    assert sum(patch.surface.area for patch in everything.patches) == pytest.approx(mesh.area)


def test_coverage_is_the_share_of_the_requested_surface_and_warns_below_nine_tenths():
    whole = skin_of_mesh(sphere(), PlacementSpec(taxels=40))
    assert (whole.coverage, whole.bare_area) == (1.0, 0.0)
    cloud = loose_pieces(300)
    few = skin_of_mesh(cloud, PlacementSpec(taxels=40), surface="all")
    (patch,) = few.patches
    assert kinds(few.findings)["small-piece"] == 300
    assert few.coverage == pytest.approx(patch.surface.area / cloud.area)
    assert "low-coverage" not in kinds(few.findings)
    pieces = loose_pieces(600)
    small_ball = joined(Mesh(pieces.vertices, pieces.faces[-600:]), sphere(radius=0.4))
    low = skin_of_mesh(small_ball, PlacementSpec(taxels=40), surface="all")
    assert low.coverage < 0.9
    warning = only(low.findings, "low-coverage")
    assert f"warning: taxels on {100 * low.coverage:.0f} % of the requested surface" in warning.action
    assert f"{warning.count} pieces ({1e4 * low.bare_area:.3g} cm²) are too small for a taxel" in warning.action
    assert "place more taxels" in warning.action


def test_pieces_too_small_for_taxels_count_as_bare():
    mesh = joined(sphere(), moved(sphere(), (0.3, 0, 0)))
    spec = PlacementSpec(taxels=40, keep_out=(SphereZone(np.zeros(3), 0.1),))
    skin = skin_of_mesh(mesh, spec)
    assert skin.coverage == pytest.approx(0.5)
    assert (len(skin.patches), kinds(skin.findings)["bare-piece"]) == (1, 1)
    with pytest.raises(SkinError, match="nothing of the surface is left"):
        skin_of_mesh(sphere(), spec)
    warning = only(skin.findings, "low-coverage")
    assert "1 (" in warning.action
    assert "have no room for taxels" in warning.action


def test_protruding_parts_of_overlapping_bodies_have_taxels():
    skin = skin_of_mesh(joined(sphere(), moved(sphere(), (0.06, 0, 0))), PlacementSpec(taxels=60))
    assert len(skin) == 60
    for patch, centre in zip(skin.patches, sorted([0.0, 0.06]), strict=True):
        assert len(patch.surface.connectivity.boundary_loops) == 1
        other = 0.06 - centre
        assert np.linalg.norm(patch.taxels.positions - [other, 0, 0], axis=1).min() > 0.045


def test_taxels_are_shared_by_area_and_patches_named_after_the_largest():
    mesh = joined(sphere(radius=0.02), moved(sphere(radius=0.04), (0.2, 0, 0)))
    skin = skin_of_mesh(mesh, PlacementSpec(taxels=50), name="hand")
    assert [(patch.name, patch.link, len(patch.taxels)) for patch in skin.patches] == [
        ("hand", "hand", 40),
        ("hand 2", "hand", 10),
    ]


def test_number_of_taxels_is_at_most_the_requested_one():
    row = joined(*(moved(sphere(), (0.2 * number, 0, 0)) for number in range(3)))
    skin = skin_of_mesh(row, PlacementSpec(taxels=2))
    assert [len(patch.taxels) for patch in skin.patches] == [1, 1]
    assert kinds(skin.findings) == {"small-piece": 1, "low-coverage": 1}


def test_mesh_without_a_large_part_is_rejected():
    cloud = loose_pieces(300)
    with pytest.raises(SkinError, match="no piece of the mesh is large enough"):
        skin_of_mesh(Mesh(cloud.vertices, cloud.faces[-300:]), PlacementSpec(taxels=3))


def test_values_painted_on_vertices_are_assigned_to_their_piece():
    mesh = HARD_MESHES["soup"]
    marked = mesh.vertices[:, 2] > 0
    skin = skin_of_mesh(mesh, PlacementSpec(taxels=30, keep_out=(PaintedZone(marked),)))
    assert skin.patches[0].taxels.positions[:, 2].max() < 0.01


def test_painted_zone_is_kept_on_overlapping_parts():
    mesh = loose(joined(sphere(), moved(sphere(), (0.06, 0, 0))))
    skin = skin_of_mesh(mesh, PlacementSpec(taxels=60, keep_out=(PaintedZone(mesh.vertices[:, 2] > 0),)))
    assert {"hidden-face", "duplicate-vertex"} <= set(kinds(skin.findings))
    assert max(patch.taxels.positions[:, 2].max() for patch in skin.patches) < 0.005


@pytest.mark.parametrize("name", HOPELESS_MESHES)
def test_mesh_with_zero_area_is_rejected_by_name(name):
    with pytest.raises(MeshError, match=name):
        skin_of_mesh(HOPELESS_MESHES[name], name=name)


@pytest.mark.long
def test_progress_rises_and_may_cancel():
    fractions = []
    skin_of_mesh(HARD_MESHES["two components"], progress=lambda _text, fraction: fractions.append(fraction))
    assert fractions == sorted(fractions)
    assert len(fractions) == 4


@pytest.mark.long
def test_modules_are_numbered_consecutively_over_pieces():
    one = sphere(radius=0.06)
    other = sphere(radius=0.04)
    faces = np.concatenate([one.faces, other.faces + len(one.vertices)])
    both = Mesh(np.concatenate([one.vertices, other.vertices + 0.2]), faces)
    skin = skin_of_mesh(both, PlacementSpec(pattern="modules"))
    assert len(skin.patches) == 2
    np.testing.assert_array_equal(skin.identity.modules, np.arange(len(skin)) // 10)
    np.testing.assert_array_equal(skin.identity.channels, np.arange(len(skin)) % 10)


@pytest.mark.sampled(8)
@pytest.mark.parametrize("name", HARD_MESHES)
def test_findings_without_placed_taxels_are_the_same(name):
    assert findings_of_mesh(HARD_MESHES[name], name=name) == skin_of_mesh(HARD_MESHES[name], name=name).findings


@pytest.mark.parametrize("name", HOPELESS_MESHES)
def test_mesh_with_zero_area_raises_an_error_instead_of_findings(name):
    with pytest.raises(MeshError):
        findings_of_mesh(HOPELESS_MESHES[name], name=name)
