"""Laws of wrapping, over the catalogue of hard meshes."""

from __future__ import annotations

import igl
import numpy as np
import pytest

from app.errors import MeshError
from app.geometry.clean import clean
from app.geometry.mesh import Mesh
from app.geometry.topology import face_components, is_closed_manifold
from app.geometry.wrap import Wrap, wrap
from tests.numerics.brute_force import distances
from tests.numerics.hard_meshes import HARD_MESHES, HOPELESS_MESHES

CLOSINGS = (0.0, 3.0)  # in thicknesses
APART = ("two components",)


def wrapped(name: str, closing: float) -> tuple[Mesh, Wrap, float]:
    mesh, _ = clean(HARD_MESHES[name])
    thickness = 0.03 * mesh.size
    return mesh, wrap(mesh, thickness=thickness, voxel=1.2 * thickness, closing=closing * thickness), thickness


@pytest.mark.parametrize("closing", CLOSINGS)
@pytest.mark.parametrize("name", HARD_MESHES)
def test_a_wrap_is_one_closed_surface_around_the_mesh(name: str, closing: float) -> None:
    mesh, result, _ = wrapped(name, closing)
    surface = result.surface
    assert is_closed_manifold(surface.faces)
    assert face_components(surface.faces).max() == 0
    assert len(np.unique(surface.faces)) == len(surface.vertices)
    winding = igl.winding_number(surface.vertices, surface.faces, np.ascontiguousarray(mesh.vertices))
    if name not in APART:
        assert np.abs(winding - 1).max() < 1e-6, "the mesh lies inside, and the faces look outward"
    assert surface.face_areas.min() > 0


@pytest.mark.parametrize("closing", CLOSINGS)
@pytest.mark.parametrize("name", HARD_MESHES)
def test_a_wrap_keeps_the_thickness(name: str, closing: float) -> None:
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


def test_closing_spans_a_hole_that_a_ball_cannot_enter() -> None:
    mesh, open_, thickness = wrapped("hole", 0.0)
    _, spanned, _ = wrapped("hole", 3.0)
    centre = mesh.bounds.mean(axis=0)
    inward = np.linalg.norm(open_.surface.vertices - centre, axis=1).min()
    assert inward < 0.1 - 0.9 * thickness, "without closing the cover follows the hole inside"
    assert np.linalg.norm(spanned.surface.vertices - centre, axis=1).min() > inward


@pytest.mark.parametrize("name", ["cube", "soup", "moebius"])
def test_a_wrap_is_the_same_every_time(name: str) -> None:
    first, second = wrapped(name, 3.0)[1].surface, wrapped(name, 3.0)[1].surface
    assert first.vertices.tobytes() == second.vertices.tobytes()
    assert first.faces.tobytes() == second.faces.tobytes()


def test_a_wrap_moves_with_its_mesh() -> None:
    mesh, _ = clean(HARD_MESHES["overlapping parts"])
    here = wrap(mesh, thickness=0.005, voxel=0.006)
    there = wrap(Mesh(mesh.vertices + [1000.0, -1000.0, 500.0], mesh.faces), thickness=0.005, voxel=0.006)
    assert there.surface.area == pytest.approx(here.surface.area, rel=5e-3)


@pytest.mark.parametrize("name", HOPELESS_MESHES)
def test_a_mesh_without_area_is_refused_by_name(name: str) -> None:
    with pytest.raises(MeshError, match="no face with an area"):
        clean(HOPELESS_MESHES[name], where=name)
