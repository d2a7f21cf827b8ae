"""Real skins: iCub's patches without a torn neighbour, the published sleeve, and how true a surface through taxels
alone is.
"""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.geometry.remesh.refine import subdivide
from tactile_maps.geometry.surface.closest_point import ClosestPoint
from tactile_maps.geometry.surface.connectivity import Connectivity
from tactile_maps.maps.build import build_map
from tactile_maps.maps.evaluation.comparison import compare_maps, drawn_layout
from tactile_maps.maps.evaluation.quality import measure
from tactile_maps.skin.formats.icub.layout import apply_layout, read_icub_layout
from tactile_maps.skin.formats.icub.positions import read_icub_positions
from tactile_maps.skin.formats.import_skin import NO_ROBOT
from tactile_maps.skin.formats.taxel_files import read_taxels
from tactile_maps.skin.model.taxel_set import TaxelSet
from tactile_maps.skin.open import SkinOptions, open_skin
from tactile_maps.skin.reconstruction.reconstruct import reconstruct_skin, skin_from_taxels
from tactile_maps.skin.reconstruction.triangulation import triangulate
from tactile_maps.skin.taxel_placement.sampling import (
    distinct_faces,
    face_graph,
    geodesic_voronoi,
    place_evenly,
    straighten_cells,
    taxels_at_points,
)
from tests.support.real_icub import LAYOUTS, POSITIONS, needs_files
from tests.support.surfaces import cap, frustum, sheet, sphere

DRAWN = {"left_arm": "left_arm_V2_7", "left_forearm_V2": "left_forearm_V2", "torso": "torso"}


def sleeve():
    """Taxels in a triangular lattice around an oval handle that narrows and is open along one line."""
    along = 32
    around = 20
    pitch = 0.0076
    row, column = (part.ravel() for part in np.meshgrid(np.arange(along), np.arange(around), indexing="ij"))
    turn = (column + 0.5 * (row % 2)) * pitch / 0.0385 + 0.35
    up = 0.204 * row / (along - 1)  # 6.6 mm from row to row
    narrow = 1 - 0.12 * up / 0.204
    positions = np.stack([0.0365 * narrow * np.cos(turn), 0.033 * narrow * np.sin(turn), up], axis=1)
    return TaxelSet("sleeve", "handle", np.arange(len(positions)), positions)


@pytest.mark.long
def test_sleeve_map_has_ten_times_less_distortion_than_published():
    taxels = sleeve()
    assert len(taxels.positions) == 640
    skin = skin_from_taxels(taxels)
    quality = measure(build_map(skin))
    assert quality.bijective
    assert quality.taxels == 640
    assert quality.edge_error < 0.005
    assert quality.torn_pairs == 0


@needs_files
@pytest.mark.parametrize("name", DRAWN)
def test_icub_patch_keeps_every_neighbour(name):
    skin = open_skin(POSITIONS / f"{name}.txt", SkinOptions(robot=NO_ROBOT))
    quality = measure(build_map(skin))
    assert quality.bijective
    assert quality.torn_pairs == 0
    assert min(quality.trustworthiness, quality.continuity) >= 0.99


@needs_files
@pytest.mark.parametrize("name", DRAWN)
def test_map_of_an_icub_patch_is_at_least_as_good_as_the_drawn_one(name):
    file = POSITIONS / f"{name}.txt"
    skin = open_skin(file, SkinOptions(robot=NO_ROBOT))
    drawn = apply_layout(read_taxels(file), read_icub_layout(LAYOUTS / f"{DRAWN[name]}.ini"))
    assert drawn.points is not None
    result = compare_maps(build_map(skin), drawn_layout(drawn, skin))
    values = {row.name: row for row in result.measures}
    for key in ("torn", "trustworthiness", "continuity", "edge_error"):
        assert values[key].better in ("first", "neither"), (key, values[key])


SHAPES = {
    "tube": lambda: frustum(0.04, 0.04),
    "torso": lambda: cap(2.3, radius=0.12),
    "bumpy sheet": lambda: sheet(
        40, 30, width=0.2, height=0.15, shape=lambda x, y: 0.012 * np.sin(60 * x) * np.cos(50 * y)
    ),
    "ball": lambda: sphere(radius=0.06),
}


def sampled(shape, pitch, *, noise, seed=0):
    """Taxels a pitch apart with their pairs of true neighbours; with noise, also with a hole."""
    surface = subdivide(SHAPES[shape](), longest=pitch / 4).mesh
    points = place_evenly(surface, int(surface.area / (0.866 * pitch**2)), seed=seed).positions
    random = np.random.default_rng(seed)
    if noise:
        points = points[np.linalg.norm(points - points[0], axis=1) > 3 * pitch]
        points = points + random.normal(size=points.shape) * 0.1 * pitch
    faces, weights, _ = ClosestPoint(surface).query(points)
    on = surface.points(faces, weights)
    centres = surface.face_centres
    seeds = distinct_faces(centres, on)
    owner = straighten_cells(surface, on, geodesic_voronoi(face_graph(surface), seeds), seeds)
    true = taxels_at_points(surface, on, owner)
    return on + noise * random.normal(size=on.shape) * pitch / 30, true


def f1(found, true):
    one, other = ({tuple(pair) for pair in pairs.tolist()} for pairs in (found, true))
    return 2 * len(one & other) / (len(one) + len(other))


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("noise", [False, True], ids=["clean", "noise and hole"])
@pytest.mark.parametrize("pitch", [0.012, 0.020])
@pytest.mark.parametrize("shape", SHAPES)
def test_neighbours_match_those_on_the_surface(shape, pitch, noise):
    points, true = sampled(shape, pitch, noise=noise)
    found = triangulate(points)
    assert len(points) > 50
    assert f1(found.mesh.edges, true.neighbours) > (0.93 if noise else 0.95)
    assert len(np.setdiff1d(np.arange(len(points)), found.mesh.faces)) <= 0.02 * len(points)
    assert found.mesh.connectivity.components.max() == 0
    side = np.sign((found.normals * true.normals).sum(axis=1))
    assert abs(side.sum()) == len(points)


@pytest.mark.long
@pytest.mark.sampled(1)
@pytest.mark.parametrize("shape", ["tube", "ball"])
def test_surface_has_the_holes_of_the_body_and_no_others(shape):
    points, _ = sampled(shape, 0.010, noise=False)
    mesh = triangulate(points).mesh
    assert mesh.connectivity.euler_characteristic == {"tube": 0, "ball": 2}[shape]
    assert len(mesh.connectivity.boundary_loops if shape == "tube" else []) == {"tube": 2, "ball": 0}[shape]
    outward = mesh.face_centres * ([1, 1, 0] if shape == "tube" else 1)
    assert (mesh.face_normals * outward).sum(axis=1).min() > 0


@pytest.mark.long
def test_map_does_not_depend_on_position_and_order_of_taxels():
    points, _ = sampled("torso", 0.020, noise=True)
    pairs = {tuple(pair) for pair in triangulate(points).mesh.edges.tolist()}
    order = np.random.default_rng(5).permutation(len(points))
    turned = np.linalg.qr(np.random.default_rng(6).normal(size=(3, 3)))[0]
    moved = triangulate(points[order] @ turned.T + [5, -3, 2]).mesh.edges
    assert {tuple(sorted(pair)) for pair in order[moved].tolist()} == pairs


@needs_files
@pytest.mark.parametrize(
    ("name", "distinct", "patches"),
    [("left_forearm_V2", 148, [107, 41]), ("left_arm", 350, [110, 110, 80, 50]), ("torso", 373, [373])],
)
def test_icub_files_become_connected_patches(name, distinct, patches):
    taxels = read_icub_positions(POSITIONS / f"{name}.txt")
    assert len(taxels) == distinct
    built = reconstruct_skin(taxels)
    assert [len(patch.taxels) for patch in built.skin.patches] == patches
    assert sorted(built.taxel_of.tolist()) == list(range(distinct))
    for patch in built.skin.patches:
        faces = patch.surface.faces
        assert Connectivity(faces).face_count.max() == 2
        assert not len(Connectivity(faces).bow_tie_vertices)
        assert patch.surface.face_areas.min() > 0
        apart = np.diff(patch.taxels.positions[patch.taxels.neighbours], axis=1)[:, 0]
        assert np.median(np.linalg.norm(apart, axis=1)) == pytest.approx(0.0065, abs=0.0007)
        assert np.linalg.norm(apart, axis=1).max() < 0.02
    assert np.median(built.skin.areas) == pytest.approx(45e-6, rel=0.15)  # 42 mm² is a hexagon of 7 mm
    assert np.quantile(built.skin.areas, 0.99) < 2.5 * np.median(built.skin.areas)
