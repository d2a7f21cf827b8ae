"""Cells of taxels: exact cuts, equal and centred on regular grids, never across a gap."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import ConvexHull, Delaunay, Voronoi, cKDTree

from tactile_maps.contacts.detection.detection import ContactDetector
from tactile_maps.geometry.remesh.wrap import wrap_mesh
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.maps.build import build_map
from tactile_maps.skin.model.skin import Patch, Skin
from tactile_maps.skin.model.taxel_set import TaxelSet
from tactile_maps.skin.reconstruction.reconstruct import skin_from_taxels
from tactile_maps.skin.taxel_placement import cells
from tactile_maps.skin.taxel_placement.cells import cut_cells
from tactile_maps.skin.taxel_placement.sampling import distinct_faces, face_graph, geodesic_voronoi, taxels_at_points
from tactile_maps.tactile.mechanics.loads import sphere_load
from tactile_maps.tactile.models.half_space import HalfSpaceModel
from tactile_maps.tactile.models.punch import PunchModel
from tactile_maps.tactile.models.water_fill import WaterFillModel
from tests.hard_cases.meshes import HARD_MESHES
from tests.hard_cases.touch import PLACES
from tests.support.surfaces import frustum

PITCH = 0.005
HALF = 5 * PITCH
"""Half of the side of the sheets below [m]."""


def square():
    """10 x 10 taxels on the sheet."""
    steps = PITCH * (np.arange(10) - 4.5)
    return np.array([(x, y, 0.0) for x in steps for y in steps])


def hexagonal():
    """10 rows of 10 taxels, each shifted by half a pitch against the one before."""
    steps = PITCH * (np.arange(10) - 4.5)
    rows = enumerate(steps * np.sqrt(3) / 2)
    return np.array([(x + PITCH * (row % 2 - 0.5) / 2, y, 0.0) for row, y in rows for x in steps])


GRIDS = {"square": (square(), 1.0, 8), "hexagonal": (hexagonal(), np.sqrt(3) / 2, 6)}


def irregular_sheet(seed=0):
    """A flat square with triangles between random points."""
    rim = np.linspace(-HALF, HALF, 30)
    inside = np.random.default_rng(seed).uniform(-0.98 * HALF, 0.98 * HALF, (900, 2))
    sides = [np.stack(np.broadcast_arrays(*pair), 1) for s in (-HALF, HALF) for pair in ((rim, s), (s, rim[1:-1]))]
    points = np.concatenate([inside, *sides])
    faces = Delaunay(points).simplices
    a, b, c = (points[faces[:, k]] for k in range(3))
    (ux, uy), (vx, vy) = (b - a).T, (c - a).T
    area = ux * vy - uy * vx
    faces = np.where((area < 0)[:, None], faces[:, ::-1], faces)[np.abs(area) > 1e-15]
    return Mesh(np.column_stack([points, np.zeros(len(points))]), faces)


def mirrored_sheet(steps=12):
    """A flat square whose triangles are their own mirror image: four around the middle of each small square."""
    at = np.linspace(-HALF, HALF, 2 * steps + 1)
    vertices = np.array([(x, y, 0.0) for x in at for y in at])
    i, j = (k.ravel() for k in np.meshgrid(2 * np.arange(steps), 2 * np.arange(steps), indexing="ij"))
    around = [(0, 0), (1, 0), (2, 0), (2, 1), (2, 2), (1, 2), (0, 2), (0, 1)]
    rim = [(i + a) * len(at) + j + b for a, b in around]
    middle = (i + 1) * len(at) + j + 1
    sides = [np.stack([middle, one, other], 1) for one, other in zip(rim, rim[1:] + rim[:1], strict=True)]
    return Mesh(vertices, np.concatenate(sides))


def placed(surface, points):
    """Taxels whose faces are those with the closest middle."""
    owner = cKDTree(points).query(surface.face_centres)[1].astype(np.int64)
    return taxels_at_points(surface, points, owner)


def centroids(taxels):
    points = taxels.quadrature
    sums = [np.bincount(points.taxel, points.areas * points.positions[:, k], len(taxels)) for k in range(3)]
    return np.stack(sums, axis=1) / taxels.areas[:, None]


@pytest.mark.parametrize("name", GRIDS)
@pytest.mark.parametrize("surface", [irregular_sheet(0), irregular_sheet(1), mirrored_sheet()])
def test_cells_of_a_flat_grid_are_equal_and_centred_on_their_taxels(name, surface):
    points, area, around = GRIDS[name]
    taxels = placed(surface, points)
    inside = (np.abs(points[:, :2]) < HALF - 1.6 * PITCH).all(axis=1)
    assert inside.sum() >= 16
    assert taxels.areas.sum() == pytest.approx(surface.area, rel=1e-12)
    assert taxels.areas[inside] == pytest.approx(area * PITCH**2, rel=1e-9)
    assert np.linalg.norm(centroids(taxels) - points, axis=1)[inside].max() < 1e-6 * PITCH
    assert (np.bincount(taxels.neighbours.ravel(), minlength=len(points))[inside] == around).all()


@pytest.mark.parametrize("turn", [0.0, 0.5])
def test_cells_of_a_grid_around_a_cylinder_are_equal_and_centred_along_the_surface(turn):
    surface = frustum(0.02, 0.02, length=0.06, around=96, along=33)
    up = 0.06 * (np.arange(12) + 0.5) / 12
    angles = 2 * np.pi * (np.arange(24) + turn / 4) / 24
    points = np.array([(0.02 * np.cos(a), 0.02 * np.sin(a), z) for a in angles for z in up])
    if turn:  # in the middle of a facet
        points[:, :2] *= np.cos(np.pi / 96)
    taxels = placed(surface, points)
    assert np.allclose(taxels.positions, points, atol=1e-12)
    assert taxels.areas == pytest.approx(surface.area / len(points), rel=1e-9)
    radial = np.column_stack([points[:, :2], np.zeros(len(points))]) / np.linalg.norm(points[:, :2], axis=1)[:, None]
    off = centroids(taxels) - points
    along = off - (off * radial).sum(axis=1)[:, None] * radial
    assert np.linalg.norm(along, axis=1).max() < 1e-6 * PITCH


@pytest.mark.parametrize("name", GRIDS)
def test_cells_of_a_reconstructed_grid_are_equal_and_centred_inside(name):
    points, area, _ = GRIDS[name]
    (patch,) = skin_from_taxels(TaxelSet("grid", None, np.arange(len(points)), points)).patches
    inside = (np.abs(points[:, :2]) < HALF - 1.6 * PITCH).all(axis=1)
    assert patch.taxels.areas[inside] == pytest.approx(area * PITCH**2, rel=1e-9)
    assert np.linalg.norm(centroids(patch.taxels) - points, axis=1)[inside].max() < 1e-6 * PITCH


@pytest.mark.long
@pytest.mark.parametrize("model", [WaterFillModel, PunchModel, HalfSpaceModel])
def test_mirrored_loads_give_mirrored_readings_and_centres(model):
    points = square()
    surface = mirrored_sheet()
    skin = Skin((Patch("sheet", "sheet", surface, placed(surface, points)),))
    map_ = build_map(skin)
    mirror = cKDTree(points).query(points * [-1, 1, 1])[1]
    at = np.array([0.0021, 0.0034, 0.0])
    up = np.array([0.0, 0.0, 1.0])
    loads = [sphere_load("sheet", at * [sign, 1, 1], up, 3.0, 0.012) for sign in (1, -1)]
    one, other = (model(skin).pressures([load]) for load in loads)
    assert one == pytest.approx(other[mirror], rel=1e-9, abs=1e-9 * one.max())
    (first,), (second,) = (ContactDetector(map_).read(pressures) for pressures in (one, other))
    assert first.force == pytest.approx(second.force, rel=1e-9)
    assert first.link_position * [-1, 1, 1] == pytest.approx(second.link_position, abs=1e-9 * PITCH)


def test_shares_of_every_face_add_up_to_its_area():
    surface = irregular_sheet(2)
    points = np.random.default_rng(2).uniform(-HALF, HALF, (60, 3)) * [1, 1, 0]
    taxels = placed(surface, points)
    face = cKDTree(points)  # each part is nearest to its own taxel
    assert (face.query(taxels.quadrature.positions)[1] == taxels.quadrature.taxel).all()
    assert taxels.areas.sum() == pytest.approx(surface.area, rel=1e-13)
    assert len(taxels.quadrature.areas) > len(surface.faces)


def test_coincident_taxels_share_their_cell_equally():
    surface = mirrored_sheet()
    points = np.concatenate([square(), square()[[44]]])
    owner = cKDTree(square()).query(surface.face_centres)[1].astype(np.int64)
    taxels = taxels_at_points(
        surface, points, np.where(owner == 44, np.where(np.arange(len(owner)) % 2, 44, 100), owner)
    )
    assert taxels.areas[[44, 100]] == pytest.approx(PITCH**2 / 2, rel=1e-9)


def test_face_equidistant_from_two_taxels_is_shared_equally():
    """A ridge: two slopes with a taxel each, and a wall between them on which both are equally far."""
    vertices = np.array([(0, 0, 0), (0, 2, 0), (0, 0, 1), (0, 2, 1), (-1, 1, 0), (1, 1, 0)], float)
    surface = Mesh(vertices, np.array([(0, 1, 3), (0, 3, 2), (0, 4, 1), (0, 1, 5)]))
    points = np.array([(-0.4, 1, 0), (0.4, 1, 0)])
    cut = cut_cells(surface, points, np.array([0, 1, 0, 1]))
    areas = np.bincount(cut.quadrature.taxel, cut.quadrature.areas)
    assert areas == pytest.approx([2.0, 2.0], rel=1e-12)


def test_cells_are_the_same_whether_faces_are_cut_at_once_or_in_blocks(monkeypatch):
    surface = irregular_sheet()
    points = hexagonal()
    owner = cKDTree(points).query(surface.face_centres)[1].astype(np.int64)
    at_once = cut_cells(surface, points, owner)
    monkeypatch.setattr(cells, "_BLOCK", 100)
    in_blocks = cut_cells(surface, points, owner)
    assert np.array_equal(in_blocks.neighbours, at_once.neighbours)
    assert np.array_equal(in_blocks.quadrature.taxel, at_once.quadrature.taxel)
    assert in_blocks.quadrature.areas == pytest.approx(at_once.quadrature.areas, rel=1e-12)


def test_taxel_left_without_area_by_the_cut_gets_half_of_its_faces():
    surface = mirrored_sheet()
    points = square()
    owner = cKDTree(points).query(surface.face_centres)[1].astype(np.int64)
    far = np.concatenate([points, [[0.0, 0.0, 1.0]]])  # its own place is nowhere on the surface
    faces = np.flatnonzero(owner == 33)[:2]
    owner[faces] = len(points)
    cut = cut_cells(surface, far, owner)
    areas = np.bincount(cut.quadrature.taxel, cut.quadrature.areas)
    assert areas[-1] == pytest.approx(surface.face_areas[faces].sum() / 2, rel=1e-12)
    assert areas.sum() == pytest.approx(surface.area, rel=1e-12)


def test_cells_stay_on_their_side_of_a_thin_plate():
    plate = wrap_mesh(HARD_MESHES["flat plate"], thickness=0.002, voxel=0.0035).surface
    centres = plate.face_centres
    steps = np.stack(np.meshgrid(np.arange(0.05, 0.26, 0.01), np.arange(0.05, 0.16, 0.01)), -1).reshape(-1, 2)
    sides = [np.column_stack([steps + shift, np.full(len(steps), z)]) for z, shift in ((0.002, 0), (-0.002, 0.005))]
    points = np.concatenate(sides)
    owner = geodesic_voronoi(face_graph(plate), distinct_faces(centres, points), reach=0.01)
    parts = cut_cells(plate, points, owner).quadrature
    assert (np.sign(parts.positions[:, 2]) == np.sign(points[parts.taxel, 2])).all()


def test_taxel_with_few_faces_is_a_neighbour_of_surrounding_taxels():
    taxels = PLACES["one tiny taxel"]().prepared.skin.patches[0].taxels
    around = {(1, 2), (1, 3), (2, 4), (3, 4)}
    assert {tuple(pair) for pair in taxels.neighbours.tolist()} == around | {(0, other) for other in (1, 2, 3, 4)}


def test_cells_with_many_corners_inside_one_face_are_those_of_the_plane():
    """Each vertex of a triangle has a fan of faces, so that 23 taxels on a circle own faces next to it."""
    corner = 1.2 * np.exp(2j * np.pi * np.arange(3) / 3)
    arc = np.exp(1j * np.linspace(-1.0, 1.0, 9))
    rim = corner[:, None] * (1 + 0.2 * arc)
    flat = np.concatenate([corner, rim.ravel()])
    fans = [(k, 3 + 9 * k + j, 4 + 9 * k + j) for k in range(3) for j in range(8)]
    surface = Mesh(np.column_stack([flat.real, flat.imag, 0 * flat.real]), np.array([(0, 1, 2), *fans]))
    places = np.concatenate([[0.1 + 0.05j, -0.1 - 0.05j], np.exp(2j * np.pi * np.arange(23) / 23)])
    points = np.column_stack([places.real, places.imag, np.zeros(25)])
    cut = cut_cells(surface, points, np.arange(25))
    areas = np.bincount(cut.quadrature.taxel, cut.quadrature.areas)
    plane = Voronoi(points[:, :2])
    for taxel in range(2):
        cell = plane.vertices[plane.regions[plane.point_region[taxel]]]
        assert len(cell) > 8
        assert areas[taxel] == pytest.approx(ConvexHull(cell).volume, rel=1e-9)
    assert areas.sum() == pytest.approx(surface.area, rel=1e-12)
