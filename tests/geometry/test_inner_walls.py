"""The inner side of a thin wall is found; plates, sheets, thick walls and convex bodies have none."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from tactile_maps.geometry.inner_walls import inner_walls
from tactile_maps.geometry.remesh.repair import repair_mesh
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.geometry.surface.raycast import outer_faces
from tests.hard_cases.meshes import GROUPS, bowl, hard_mesh, joined, moved, revolved, scaled, walled_tube
from tests.support.surfaces import frustum, solid, sphere


def found(mesh: Mesh) -> np.ndarray:
    return inner_walls(mesh, outer_faces(mesh))


def distances(mesh: Mesh, axes: slice) -> np.ndarray:
    """Distances of the faces' centres from the origin or the z axis."""
    return np.linalg.norm(mesh.vertices[mesh.faces].mean(axis=1)[:, axes], axis=1)


@pytest.mark.long
@pytest.mark.sampled(2)
@pytest.mark.parametrize("rounded", [False, True])
@pytest.mark.parametrize("half_angle", [np.pi / 2, 2 * np.pi / 3])
def test_inner_wall_of_a_bowl_is_found_without_its_rim(half_angle: float, rounded: bool) -> None:
    mesh = bowl(half_angle, rounded=rounded)
    inner = found(mesh)
    radius = distances(mesh, slice(None))
    middle = mesh.vertices[mesh.faces].mean(axis=1)
    away_from_rim = np.arccos(-middle[:, 2] / radius) < half_angle - 0.1
    assert inner[away_from_rim & (radius < 0.0485) & outer_faces(mesh)].all()
    assert not inner[radius > 0.0485].any()


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_inner_wall_of_a_tube_is_found_in_any_unit(scale: float) -> None:
    mesh = walled_tube()
    inner = found(moved(scaled(mesh, scale), (scale, 0, 0)))
    assert np.array_equal(inner, distances(mesh, slice(2)) < 0.0275)


@pytest.mark.long
def test_only_outermost_side_of_nested_walls_remains() -> None:
    sheets = joined(frustum(0.05, 0.05, length=0.2), frustum(0.046, 0.046, length=0.2))
    assert np.array_equal(found(sheets), distances(sheets, slice(2)) < 0.048)
    walls = joined(walled_tube(0.03), walled_tube(0.026))
    sides = outer_faces(walls) & (np.abs(walls.face_normals[:, 2]) < 0.5)
    assert np.array_equal(found(walls)[sides], distances(walls, slice(2))[sides] < 0.0285)


def test_rib_in_a_cavity_is_part_of_the_inner_wall_and_outer_rib_is_not() -> None:
    up = np.linspace(0, 0.1, 16)
    down = np.linspace(0.1, 0, 16)
    outer = [(0.05, z) for z in up[:8]] + [(0.065, up[7]), (0.065, up[8])] + [(0.05, z) for z in up[8:]]
    inner = [(0.047, z) for z in down[:8]] + [(0.03, down[7]), (0.03, down[8])] + [(0.047, z) for z in down[8:]]
    mesh = revolved(np.array([*outer, *inner]))
    side = np.abs(mesh.face_normals[:, 2]) < 0.5
    rib = ~side & (distances(mesh, slice(2)) < 0.046)
    assert rib.sum() == 160
    assert found(mesh)[rib].all()
    assert np.array_equal(found(mesh)[side], distances(mesh, slice(2))[side] < 0.0485)


NONE = {
    "plate": lambda: solid(trimesh.creation.box((0.2, 0.15, 0.004)).subdivide().subdivide()),
    "thick tube": lambda: walled_tube(wall=0.012),
    "shallow bowl": lambda: bowl(np.pi / 4),
    "finger": lambda: solid(trimesh.creation.capsule(0.1, 0.008)),
    "sphere": sphere,
    "open tube": lambda: frustum(0.05, 0.05),
    "cube": lambda: hard_mesh("cube"),
}


@pytest.mark.sampled(2)
@pytest.mark.parametrize("name", NONE)
def test_body_without_a_cavity_in_a_thin_wall_has_no_inner_wall(name: str) -> None:
    assert not found(NONE[name]()).any()


WALLED = ("bowl with walls", "tube with walls", "nested open tubes")


@pytest.mark.long
@pytest.mark.parametrize(
    "name", [name for group, names in GROUPS.items() if group not in ("edges", "shapes") for name in names]
)
def test_only_shells_of_the_catalogue_have_inner_walls(name: str) -> None:
    assert found(repair_mesh(hard_mesh(name)).mesh).any() == (name in WALLED)


def test_no_inner_walls_are_found_without_chosen_components() -> None:
    mesh = bowl()
    assert not inner_walls(mesh, np.zeros(len(mesh.faces), dtype=bool)).any()
