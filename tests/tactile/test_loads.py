"""Bodies that press by their signed distance, meshes among them, and one of them as a load on a link."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scipy.spatial import cKDTree

from tactile_maps.core.errors import MeshError, SimulationError
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.geometry.surface.pose import Pose
from tactile_maps.tactile.mechanics.loads import (
    Box,
    Cylinder,
    LayerShape,
    Load,
    MeshShape,
    Sphere,
    sphere_load,
)

BALL = Sphere(0.03)
BOX = Box((0.02, 0.03, 0.05))
CYLINDER = Cylinder(0.03, 0.02)


def on_ball(generator):
    points = generator.normal(size=(200_000, 3))
    return BALL.radius * points / np.linalg.norm(points, axis=1, keepdims=True)


def on_box(generator):
    points = generator.uniform(-1, 1, size=(200_000, 3)) * BOX.half
    side = generator.integers(3, size=len(points))
    rows = np.arange(len(points))
    points[rows, side] = np.sign(points[rows, side]) * np.asarray(BOX.half)[side]
    return points


def on_cylinder(generator):
    angle = generator.uniform(0, 2 * np.pi, 200_000)
    radius = CYLINDER.radius * np.sqrt(generator.uniform(size=len(angle)))
    height = generator.choice([-1.0, 1.0], len(angle)) * CYLINDER.half
    round_ = np.arange(len(angle)) % 2 == 0
    radius[round_] = CYLINDER.radius
    height[round_] = generator.uniform(-1, 1, round_.sum()) * CYLINDER.half
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), height], axis=1)


def inside_cylinder(points):
    return (np.linalg.norm(points[:, :2], axis=1) < CYLINDER.radius) & (np.abs(points[:, 2]) < CYLINDER.half)


BODIES = [
    (BALL, on_ball, lambda p: np.linalg.norm(p, axis=1) < BALL.radius),
    (BOX, on_box, lambda p: (np.abs(p) < BOX.half).all(axis=1)),
    (CYLINDER, on_cylinder, inside_cylinder),
]


@pytest.mark.sampled(1)
@pytest.mark.parametrize(("shape", "surface", "inside"), BODIES)
def test_distance_to_primitive_matches_dense_sampling_of_its_surface(shape, surface, inside):
    generator = np.random.default_rng(3)
    points = generator.uniform(-0.08, 0.08, size=(500, 3))
    held = inside(points)
    assert held.any()
    assert not held.all()
    away = cKDTree(surface(generator)).query(points)[0]
    found = shape.distance(points)
    np.testing.assert_array_equal(found < 0, held)
    assert np.abs(found) == pytest.approx(away, abs=5e-4)
    assert (np.abs(found) <= away + 1e-12).all(), "no sample is closer than the closest point"


@pytest.mark.parametrize(("shape", "surface", "inside"), BODIES)
def test_reach_encloses_the_body_tightly(shape, surface, inside):
    farthest = np.linalg.norm(surface(np.random.default_rng(4)), axis=1).max()
    assert farthest <= shape.reach * (1 + 1e-12)
    assert farthest > 0.97 * shape.reach


HALF = (0.02, 0.03, 0.05)


def as_mesh(solid) -> Mesh:
    return Mesh(solid.vertices, solid.faces)


def box() -> Mesh:
    return as_mesh(trimesh.creation.box(2 * np.array(HALF)))


def spike() -> Mesh:
    """A needle on a ball: at its tip, the normals of the faces around are nearly across the way out."""
    solid = trimesh.creation.icosphere(1, 0.02)
    solid.vertices[0] *= 5.0
    return as_mesh(solid)


def fan() -> Mesh:
    """A sharp pyramid, one of its three sides in 40 slivers: at its tip, most faces look the same way."""
    base = 0.01 * np.array([[1, 0, 0], [-0.5, 0.75**0.5, 0], [-0.5, -(0.75**0.5), 0]])
    row = base[0] + np.linspace(0, 1, 41)[:, None] * (base[1] - base[0])
    tip = 41
    last = 42
    slivers = [f for k in range(40) for f in ((tip, k, k + 1), (last, k + 1, k))]
    return Mesh(np.concatenate([row, [[0, 0, 0.06]], base[2:]]), np.array([*slivers, (tip, 40, last), (tip, last, 0)]))


def notched() -> Mesh:
    """An L, extruded: an edge where it is hollow."""
    corners = 0.02 * np.array([[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]])
    caps = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]
    bottom = [(a, c, b) for a, b, c in caps]
    top = [(a + 6, b + 6, c + 6) for a, b, c in caps]
    sides = [f for k in range(6) for f in ((k, (k + 1) % 6, k + 6), ((k + 1) % 6, (k + 1) % 6 + 6, k + 6))]
    low = np.column_stack([corners, np.zeros(6)])
    return Mesh(np.concatenate([low, low + [0, 0, 0.03]]), np.array(bottom + top + sides))


def hollow() -> Mesh:
    """A ball with a ball-shaped hole in it: two shells, the inner one looks inward."""
    outer = trimesh.creation.icosphere(2, 0.04)
    inner = trimesh.creation.icosphere(2, 0.02)
    faces = np.concatenate([outer.faces, inner.faces[:, ::-1] + len(outer.vertices)])
    return Mesh(np.concatenate([outer.vertices, inner.vertices]), faces)


SOLIDS = {
    "box": box(),
    "spike": spike(),
    "fan": fan(),
    "notched": notched(),
    "hollow": hollow(),
    "ring": as_mesh(trimesh.creation.torus(0.04, 0.012, major_sections=14, minor_sections=7)),
}


def windings(mesh: Mesh, points):
    """Winding number of the mesh around each point, from solid angles (van Oosterom and Strackee, 1983)."""
    a, b, c = (mesh.vertices[mesh.faces[:, k]][None] - points[:, None] for k in range(3))
    la, lb, lc = (np.linalg.norm(v, axis=2) for v in (a, b, c))
    over = np.einsum("ijk,ijk->ij", a, np.cross(b, c))
    under = la * lb * lc + (a * b).sum(2) * lc + (b * c).sum(2) * la + (c * a).sum(2) * lb
    return np.arctan2(over, under).sum(axis=1) / (2 * np.pi)


def around(mesh: Mesh, count=1500):
    """Points in and around a mesh, many of them straight out from its corners and edges."""
    generator = np.random.default_rng(7)
    low, high = mesh.bounds
    anywhere = generator.uniform(low - 0.02, high + 0.02, size=(count, 3))
    corners = mesh.vertices[generator.integers(len(mesh.vertices), size=count)]
    edges = mesh.vertices[mesh.edges[generator.integers(len(mesh.edges), size=count)]].mean(axis=1)
    near = np.concatenate([corners, edges]) + generator.normal(scale=0.004, size=(2 * count, 3))
    return np.concatenate([anywhere, near])


@pytest.mark.sampled(1)
@pytest.mark.parametrize("name", SOLIDS)
def test_sign_of_distance_matches_the_winding_number(name):
    mesh = SOLIDS[name]
    points = around(mesh)
    distances = MeshShape(mesh).distance(points)
    clear = np.abs(distances) > 1e-9
    inside = windings(mesh, points) > 0.5
    assert clear.mean() > 0.99
    assert 0.02 < inside.mean() < 0.9
    np.testing.assert_array_equal(distances[clear] < 0, inside[clear])


def test_distance_of_a_box_is_exact():
    points = around(SOLIDS["box"])
    assert MeshShape(SOLIDS["box"]).distance(points) == pytest.approx(Box(HALF).distance(points), abs=1e-15)


@pytest.mark.parametrize("name", SOLIDS)
def test_distance_to_mesh_matches_dense_sampling_of_its_faces(name):
    mesh = SOLIDS[name]
    generator = np.random.default_rng(8)
    points = around(mesh, 20)
    corners = generator.dirichlet((1, 1, 1), size=(len(mesh.faces), 4000 // len(mesh.faces) + 60))
    samples = np.einsum("fsc,fcd->fsd", corners, mesh.vertices[mesh.faces]).reshape(-1, 3)
    away = np.linalg.norm(points[:, None] - samples[None], axis=2).min(axis=1)
    found = np.abs(MeshShape(mesh).distance(points))
    assert (found <= away + 1e-12).all()
    assert found == pytest.approx(away, abs=3e-3)


def test_repeated_corners_degenerate_faces_and_unused_vertices_are_ignored():
    mesh = SOLIDS["box"]
    soup = mesh.vertices[mesh.faces].reshape(-1, 3)
    faces = np.concatenate([np.arange(len(soup)).reshape(-1, 3), [[0, 0, 1], [0, 1, 0]]])
    shape = MeshShape(Mesh(np.concatenate([soup, [[9.0, 9, 9]]]), faces))
    points = around(mesh, 50)
    assert shape.distance(points) == pytest.approx(Box(HALF).distance(points), abs=1e-12)
    assert shape.reach == pytest.approx(np.linalg.norm(HALF))


def test_layer_behind_a_closed_surface_is_its_interior_down_to_the_depth():
    mesh = trimesh.creation.box((0.04, 0.06, 0.1))
    solid = Mesh(np.asarray(mesh.vertices), np.asarray(mesh.faces))
    points = np.random.default_rng(0).uniform(-0.08, 0.08, (500, 3))
    exact = MeshShape(solid).distance(points)
    deep = exact < -0.01
    assert deep.any()
    layer = LayerShape(solid, depth=0.01)
    assert layer.distance(points) == pytest.approx(np.where(deep, -exact, exact), abs=1e-12)
    assert layer.reach == MeshShape(solid).reach


def test_layer_behind_an_open_surface_ends_at_its_border_and_not_at_seams():
    """Two squares side by side, with vertices of their own; a third is perpendicular to the second at its far side."""
    corners = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], float)
    wall = np.array([(2, 0, 0), (2, 0, 1), (2, 1, 1), (2, 1, 0)], float)
    vertices = np.concatenate([corners, corners + [1, 0, 0], wall])
    faces = np.array([(0, 1, 2), (0, 2, 3)])
    layer = LayerShape(Mesh(vertices, np.concatenate([faces, faces + 4, faces + 8])), depth=0.3)
    cases = {
        (0.5, 0.5, 0.2): 0.2,
        (0.5, 0.5, -0.2): -0.2,
        (1.0, 0.5, -0.2): -0.2,  # behind the seam
        (2.1, 0.5, -0.1): -np.hypot(0.1, 0.1),  # behind the valley between the second and the third
        (0.5, 0.5, -0.4): 0.4,  # below the layer
        (-0.1, 0.5, -0.1): np.hypot(0.1, 0.1),  # behind the border
        (-0.1, -0.1, -0.1): np.sqrt(0.03),  # behind its corner
    }
    assert layer.distance(np.array(list(cases))) == pytest.approx(list(cases.values()), abs=1e-12)


def test_mesh_without_interior_is_rejected_by_name():
    mesh = SOLIDS["box"]
    with pytest.raises(MeshError, match=r"lid: an open mesh has no inside.*3 edges"):
        MeshShape(Mesh(mesh.vertices, mesh.faces[1:]), where="lid")
    with pytest.raises(MeshError, match=r"twist: the mesh is not the boundary of a solid"):
        MeshShape(Mesh(mesh.vertices, np.concatenate([mesh.faces[1:], mesh.faces[:1, ::-1]])), where="twist")
    with pytest.raises(MeshError, match=r"nothing: the mesh has no face with an area"):
        MeshShape(Mesh(np.zeros((3, 3)), np.array([[0, 1, 2]])), where="nothing")


UP = np.array([0.0, 0.0, 1.0])


def test_lowest_point_of_a_ball_has_its_depth():
    point = np.array([0.1, 0.2, 0.3])
    normal = np.array([0.6, 0.0, 0.8])
    load = sphere_load("arm", point, normal, 5.0, 0.01, depth=0.002)
    assert load.distances(point[None]) == pytest.approx([-0.002])
    assert load.distances(point[None] - 0.002 * normal) == pytest.approx([0.0], abs=1e-15)
    assert load.shape == Sphere(0.01)
    assert load.force == 5.0
    assert sphere_load("arm", point, normal, 5.0, 0.01).distances(point[None]) == pytest.approx([0.0], abs=1e-15)


def test_distances_use_link_coordinates():
    turn = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    load = Load("arm", np.zeros(3), UP, 1.0, Box((0.03, 0.01, 0.01)), Pose(turn, np.array([1.0, 0, 0])))
    assert load.distances(np.array([[1.0, 0.05, 0], [1.05, 0, 0]])) == pytest.approx([0.02, 0.04])


@pytest.mark.parametrize("force", [-1e-9, np.nan, np.inf])
def test_invalid_force_is_rejected(force):
    with pytest.raises(SimulationError, match=r"on arm: the force of a load is out of range"):
        sphere_load("arm", np.zeros(3), UP, force, 0.01)


@pytest.mark.parametrize("radius", [0.0, -0.01, np.nan, np.inf])
def test_invalid_ball_radius_is_rejected(radius):
    with pytest.raises(SimulationError, match="radius of a ball must be positive"):
        sphere_load("arm", np.zeros(3), UP, 1.0, radius)
