"""How true a surface through taxels is: against surfaces that the taxels were taken from, and on iCub's real files.

The truth is which cells touch when each taxel owns what is nearest over the surface (geodesic Voronoi cells); the score
is F1 over neighbouring pairs. A hole is cut three pitches wide; noise is a tenth of the pitch along the surface and a
thirtieth off it. The iCub files are not ours to ship; where they are not beside this checkout their tests say so and
skip.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from app.geometry.closest import ClosestPoint
from app.geometry.subdivide import subdivide
from app.geometry.topology import boundary_loops, bow_tie_vertices, edge_table, euler_characteristic, face_components
from app.skin.exchange.icub import read_icub_positions
from app.skin.from_taxels import build_skin
from app.skin.place import cells, own_faces, place_taxels, straight_cells, surface_graph, taxels_at
from app.skin.triangulate import triangulate
from tests.numerics.map_surfaces import cap, frustum, sheet, sphere

REAL = Path(__file__).parents[3] / "shared" / "data" / "icub-skin" / "positions"
needs_files = pytest.mark.skipif(not REAL.is_dir(), reason="the real iCub skin files are not beside this checkout")
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
    points = place_taxels(surface, int(surface.area / (0.866 * pitch**2)), seed=seed).positions
    random = np.random.default_rng(seed)
    if noise:
        points = points[np.linalg.norm(points - points[0], axis=1) > 3 * pitch]
        points = points + random.normal(size=points.shape) * 0.1 * pitch
    faces, weights, _ = ClosestPoint(surface).query(points)
    on = surface.points(faces, weights)
    centres = surface.vertices[surface.faces].mean(axis=1)
    seeds = own_faces(centres, on)
    owner = straight_cells(surface, on, cells(surface_graph(surface, centres), seeds), seeds)
    true = taxels_at(surface, on, owner)
    return on + noise * random.normal(size=on.shape) * pitch / 30, true


def f1(found, true):
    one, other = ({tuple(pair) for pair in pairs.tolist()} for pairs in (found, true))
    return 2 * len(one & other) / (len(one) + len(other))


@pytest.mark.parametrize("noise", [False, True], ids=["clean", "noise and hole"])
@pytest.mark.parametrize("pitch", [0.012, 0.020])
@pytest.mark.parametrize("shape", SHAPES)
def test_neighbours_are_those_of_the_surface(shape, pitch, noise):
    points, true = sampled(shape, pitch, noise=noise)
    found = triangulate(points)
    assert len(points) > 50
    assert f1(found.mesh.edges, true.neighbours) > (0.93 if noise else 0.95)
    assert len(np.setdiff1d(np.arange(len(points)), found.mesh.faces)) <= 0.02 * len(points)
    assert face_components(found.mesh.faces).max() == 0
    side = np.sign((found.normals * true.normals).sum(axis=1))
    assert abs(side.sum()) == len(points)


@pytest.mark.parametrize("shape", ["tube", "ball"])
def test_the_surface_has_the_holes_of_the_body_and_no_others(shape):
    points, _ = sampled(shape, 0.010, noise=False)
    mesh = triangulate(points).mesh
    assert euler_characteristic(mesh.faces) == {"tube": 0, "ball": 2}[shape]
    assert len(boundary_loops(mesh.faces) if shape == "tube" else []) == {"tube": 2, "ball": 0}[shape]
    outward = mesh.vertices[mesh.faces].mean(axis=1) * ([1, 1, 0] if shape == "tube" else 1)
    assert (mesh.face_normals * outward).sum(axis=1).min() > 0


def test_places_and_order_do_not_matter():
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
def test_icubs_files_become_whole_patches(name, distinct, patches):
    taxels = read_icub_positions(REAL / f"{name}.txt")
    assert len(taxels) == distinct
    built = build_skin(taxels)
    assert [len(patch.taxels) for patch in built.skin.patches] == patches
    assert sorted(built.taxel_of.tolist()) == list(range(distinct))
    for patch in built.skin.patches:
        faces = patch.surface.faces
        assert edge_table(faces).face_count.max() == 2
        assert not len(bow_tie_vertices(faces))
        assert patch.surface.face_areas.min() > 0
        apart = np.diff(patch.taxels.positions[patch.taxels.neighbours], axis=1)[:, 0]
        assert np.median(np.linalg.norm(apart, axis=1)) == pytest.approx(0.0065, abs=0.0007)
        assert np.linalg.norm(apart, axis=1).max() < 0.02
    assert np.median(built.skin.areas) == pytest.approx(45e-6, rel=0.15)  # 42 mm² is a hexagon of 7 mm
    assert np.quantile(built.skin.areas, 0.99) < 2.5 * np.median(built.skin.areas)
