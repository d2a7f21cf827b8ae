"""Bodies by formula have the topology, areas and maps of their formulas."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.flattening.bijectivity import signed_areas
from tactile_maps.studies.testbeds.reference_bodies import MESHES, SIDE, flat_map

HOLES = {"tube": 2, "cone": 2, "torso": 2, "hemisphere": 1, "bumpy shell": 1, "closed link": 0, "torus": 0}
CHARACTERISTIC = {"closed link": 2, "torus": 0, "hemisphere": 1, "bumpy shell": 1, "tube": 0, "cone": 0, "torso": 0}


@pytest.mark.parametrize("name", MESHES)
@pytest.mark.parametrize("faces", [200, 3000])
def test_reference_bodies_have_the_requested_topology_and_resolution(name, faces):
    mesh = MESHES[name](faces)
    assert 0.6 * faces < len(mesh.faces) < 1.6 * faces
    assert len(mesh.connectivity.boundary_loops) == HOLES[name]
    assert mesh.connectivity.euler_characteristic == CHARACTERISTIC[name]
    assert mesh.connectivity.is_closed_manifold == (HOLES[name] == 0)
    assert len(np.unique(mesh.faces)) == len(mesh.vertices)


@pytest.mark.parametrize("name", MESHES)
def test_triangles_are_valid_and_face_outward(name):
    mesh = MESHES[name](2000)
    sides = np.linalg.norm(mesh.vertices[mesh.faces] - np.roll(mesh.vertices[mesh.faces], 1, axis=1), axis=2)
    assert (mesh.face_areas > 0.05 * sides.max(axis=1) ** 2).all()
    middles = mesh.vertices[mesh.faces].mean(axis=1)
    outward = middles * [1, 1, 0] if HOLES[name] == 2 else middles
    if name == "bumpy shell":
        outward = np.broadcast_to([0, 0, 1], middles.shape)
    elif name == "torus":
        ring = middles * [1, 1, 0]
        outward = middles - 0.06 * ring / np.linalg.norm(ring, axis=1, keepdims=True)
    assert ((mesh.face_normals * outward).sum(axis=1) > 0).all()


@pytest.mark.parametrize(
    ("name", "area"),
    [
        ("tube", 2 * np.pi * 0.04 * 0.2),
        ("cone", np.pi * 0.07 * np.hypot(0.03, 0.2)),
        ("hemisphere", 2 * np.pi * 0.05**2),
        ("torus", 4 * np.pi**2 * 0.06 * 0.02),
    ],
)
def test_areas_match_the_closed_forms(name, area):
    assert MESHES[name](20_000).area == pytest.approx(area, rel=2e-3)


@pytest.mark.parametrize("taxels", [1, 2, 100, 1000])
def test_map_and_body_points_correspond(taxels):
    map_ = flat_map(taxels)
    placed = map_.skin.patches[0].taxels
    assert len(map_.skin) == round(np.sqrt(taxels)) ** 2
    np.testing.assert_allclose(map_.taxel_points, placed.positions[:, :2], atol=1e-12)
    np.testing.assert_allclose(map_.bounds, [[0, 0], [SIDE, SIDE]], atol=1e-12)
    assert map_.skin.areas.sum() == pytest.approx(SIDE**2)
    assert map_.skin.areas.min() > 0
    assert (signed_areas(map_.uv[0], map_.charts[0].faces) > 0).all()
