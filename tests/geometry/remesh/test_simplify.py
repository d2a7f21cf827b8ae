"""Coarser surfaces: as near as they say, closed where the mesh is, of its own vertices, and fewer."""

from __future__ import annotations

import numpy as np
import pytest
import pyvista as pv

from tactile_maps.geometry.remesh.simplify import coarse_mesh, simplify
from tactile_maps.geometry.surface.closest_point import ClosestPoint
from tactile_maps.geometry.surface.mesh import Mesh

TOLERANCES = (0.2e-3, 0.5e-3, 1e-3)


def _mesh(made: pv.PolyData, scale: float = 0.05) -> Mesh:
    made = made.triangulate().clean()
    return Mesh(scale * np.asarray(made.points, float), made.regular_faces)


def _fin() -> Mesh:
    """A plate as thin as paper: its planes alone would let it shrink to nothing."""
    return _mesh(pv.Box((-1, 1, -1, 1, -0.001, 0.001), level=12))


MESHES = {
    "ball": lambda: _mesh(pv.Sphere(theta_resolution=60, phi_resolution=60)),
    "block": lambda: _mesh(pv.Box(level=12)),
    "fin": _fin,
    "open sheet": lambda: _mesh(pv.Plane(i_resolution=30, j_resolution=30)),
    "tube": lambda: _mesh(pv.Cylinder(resolution=80, capping=False)),
    "ring": lambda: _mesh(pv.ParametricTorus(u_res=60, v_res=40, w_res=40)),
}


@pytest.fixture(params=MESHES)
def mesh(request) -> Mesh:
    return MESHES[request.param]()


def _places(mesh: Mesh) -> np.ndarray:
    """All over a mesh, at other places than those that are measured."""
    weights = np.random.default_rng(0).dirichlet(np.ones(3), (8, len(mesh.faces)))
    return np.concatenate([mesh.vertices, *(mesh.points(np.arange(len(mesh.faces)), own) for own in weights)])


def _volume(mesh: Mesh) -> float:
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces], 1, 0)
    return float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6


@pytest.mark.sampled(2)
def test_simplified_surface_is_within_the_stated_distance(mesh):
    levels = simplify(mesh, TOLERANCES)
    assert levels
    for level in levels:
        coarse, _ = coarse_mesh(mesh, level.faces)
        away = ClosestPoint(coarse).query(_places(mesh))[2].max()
        back = ClosestPoint(mesh).query(_places(coarse))[2].max()
        assert max(away, back) <= 1.2 * level.error + 1e-8
        assert level.error < 2 * TOLERANCES[-1]


@pytest.mark.sampled(2)
def test_closed_surface_stays_closed_and_faces_outward(mesh):
    for level in simplify(mesh, TOLERANCES):
        coarse, _ = coarse_mesh(mesh, level.faces)
        assert coarse.connectivity.is_closed == mesh.connectivity.is_closed
        if mesh.is_solid:
            assert abs(_volume(coarse) - _volume(mesh)) <= mesh.area * level.error + 1e-12
        assert np.linalg.norm(coarse.bounds - mesh.bounds) < 4 * max(level.error, 1e-9)


def test_each_level_has_fewer_faces_than_the_one_before():
    mesh = MESHES["ring"]()
    counts = [len(mesh.faces), *(len(level.faces) for level in simplify(mesh, TOLERANCES))]
    assert counts == sorted(counts, reverse=True)
    assert counts[-1] < 0.5 * counts[0]


def test_flat_mesh_is_simplified_to_few_triangles_without_error():
    (level,) = simplify(MESHES["block"](), TOLERANCES[:1])
    assert level.error < 1e-9
    assert len(level.faces) < 40, "twelve are the least"


@pytest.mark.long
def test_same_mesh_gives_the_same_levels():
    mesh = MESHES["ball"]()
    for one, other in zip(simplify(mesh, TOLERANCES), simplify(mesh, TOLERANCES), strict=True):
        np.testing.assert_array_equal(one.faces, other.faces)
