"""The first hit of a ray, and the faces seen from outside."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.core.errors import MeshError
from tactile_maps.geometry.remesh.repair import repair_mesh
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.geometry.surface.raycast import (
    DIRECTIONS,
    RayCaster,
    fibonacci_sphere,
    outer_faces,
    seen_from_outside,
    without_islands,
)
from tests.hard_cases.meshes import HARD_MESHES, HOPELESS_MESHES, hard_mesh, joined, loose_pieces, moved
from tests.support.references import first_hit
from tests.support.surfaces import frustum, sheet, sphere

CUBE = HARD_MESHES["cube"]  # 0.2 × 0.15 × 0.1 m around the origin
DOWN = np.array([0, 0, -1.0])


def test_ray_hits_the_front_face_instead_of_the_back() -> None:
    hit = RayCaster(CUBE).first_hit(np.array([0.01, 0.02, 1.0]), 5 * DOWN)
    assert hit is not None
    assert hit.distance == pytest.approx(0.95, abs=1e-12)
    assert CUBE.point(hit.face, hit.weights) == pytest.approx([0.01, 0.02, 0.05], abs=1e-12)
    assert CUBE.face_normals[hit.face] == pytest.approx([0, 0, 1])


def test_ray_from_inside_hits_the_back_of_a_face() -> None:
    hit = RayCaster(CUBE).first_hit(np.zeros(3), DOWN)
    assert hit is not None
    assert hit.distance == pytest.approx(0.05)


@pytest.mark.parametrize(("origin", "direction"), [((1, 0, 1), (0, 0, -1)), ((0, 0, 1), (0, 0, 1))])
def test_ray_that_misses_returns_none(origin: tuple[float, ...], direction: tuple[float, ...]) -> None:
    assert RayCaster(CUBE).first_hit(np.array(origin), np.array(direction)) is None


@pytest.mark.parametrize("direction", [np.zeros(3), np.array([np.nan, 0, 1])])
def test_ray_without_direction_is_rejected(direction: np.ndarray) -> None:
    with pytest.raises(MeshError, match="ray"):
        RayCaster(CUBE).first_hit(np.zeros(3), direction)


def test_mesh_without_faces_is_rejected() -> None:
    with pytest.raises(MeshError, match="no faces"):
        RayCaster(HOPELESS_MESHES["no faces"])


def thick_cup(depth: float) -> Mesh:
    """A tube with two walls, joined at one rim and closed at the other end."""
    outer = frustum(length=depth)
    inner = frustum(0.038, 0.038, length=depth)
    around = 36
    rim = np.arange(around) + len(outer.vertices) - around
    other = rim + len(outer.vertices)
    ring = [np.stack([rim, np.roll(rim, -1), np.roll(other, -1)], 1), np.stack([rim, np.roll(other, -1), other], 1)]
    walls = joined(outer, Mesh(inner.vertices, inner.faces[:, ::-1]))
    centre = np.array([[0, 0, 0.0], [0, 0, 0.002]])
    low = np.arange(around)
    caps = [
        np.stack([np.roll(low, -1), low, np.full(around, len(walls.vertices))], axis=1),
        np.stack([low, np.roll(low, -1), np.full(around, -1)], axis=1) + len(outer.vertices),
    ]
    caps[1][:, 2] = len(walls.vertices) + 1
    return Mesh(np.concatenate([walls.vertices, centre]), np.concatenate([walls.faces, *ring, *caps]))


@pytest.mark.parametrize(
    "name", ["sphere", "torus", "cube", "open tube", "moebius", "one triangle", "huge offset", "tiny"]
)
def test_all_faces_of_a_simple_body_are_outer_faces(name: str) -> None:
    assert outer_faces(HARD_MESHES[name]).all()


@pytest.mark.long
def test_faces_of_inner_shells_are_not_outer_faces() -> None:
    result = repair_mesh(hard_mesh("nested shells"))
    outer = outer_faces(result.mesh)
    assert [bool(outer[result.component == component].all()) for component in range(3)] == [False, False, True]
    assert not outer[result.component < 2].any()


def test_protruding_faces_of_overlapping_parts_are_outer_faces() -> None:
    ball = sphere(radius=0.05)
    other = moved(sphere(radius=0.05), (0.06, 0, 0))
    outer = outer_faces(joined(ball, other))
    middle = np.concatenate([ball.vertices[ball.faces].mean(axis=1), other.vertices[other.faces].mean(axis=1)])
    inside = np.minimum(np.linalg.norm(middle, axis=1), np.linalg.norm(middle - [0.06, 0, 0], axis=1)) < 0.047
    clear = np.abs(middle[:, 0] - 0.03) > 0.01
    assert inside.any()
    assert not outer[inside].any()
    assert outer[~inside & clear].all()


def test_inner_wall_of_a_deep_cup_has_no_outer_faces() -> None:
    cup = thick_cup(0.4)
    middle = cup.vertices[cup.faces].mean(axis=1)
    wall = (middle[:, 2] > 0.01) & (middle[:, 2] < 0.3)
    inner = np.linalg.norm(middle[:, :2], axis=1) < 0.039
    outer = outer_faces(cup)
    assert outer[wall & ~inner].all()
    assert outer[wall & inner].mean() < 0.2


def test_points_see_the_outside_only_on_the_side_that_they_face() -> None:
    both = joined(sphere(radius=0.05), moved(sphere(radius=0.02), (0.01, 0, 0)))
    middle = both.vertices[both.faces].mean(axis=1)
    outer = np.linalg.norm(middle, axis=1) > 0.04
    assert outer.any()
    assert not outer.all()
    assert np.array_equal(seen_from_outside(both, middle, both.face_normals), outer)
    assert not seen_from_outside(both, middle, -both.face_normals).any()


def test_points_in_faces_as_large_as_the_mesh_see_the_outside() -> None:
    cube = HARD_MESHES["cube"]
    weights = np.random.default_rng(0).dirichlet(np.ones(3), size=(len(cube.faces), 20))
    points = np.einsum("fkc,fcd->fkd", weights, cube.vertices[cube.faces]).reshape(-1, 3)
    assert seen_from_outside(cube, points, np.repeat(cube.face_normals, 20, axis=0)).all()


def test_orientation_of_the_faces_does_not_matter() -> None:
    mesh = HARD_MESHES["overlapping parts"]
    rng = np.random.default_rng(0)
    turned = np.where(rng.random(len(mesh.faces))[:, None] < 0.5, mesh.faces[:, ::-1], mesh.faces)
    assert np.array_equal(outer_faces(Mesh(mesh.vertices, turned)), outer_faces(mesh))


@pytest.mark.long
def test_outer_faces_agree_with_single_rays() -> None:
    mesh = HARD_MESHES["overlapping parts"]
    outer = outer_faces(mesh)
    middle = mesh.vertices[mesh.faces].mean(axis=1)
    for face in np.random.default_rng(1).integers(len(mesh.faces), size=25):
        seen = 0
        for direction in fibonacci_sphere(DIRECTIONS):
            if abs(mesh.face_normals[face] @ direction) > 0.1:
                seen += first_hit(middle[face] + 2.0 * direction, -direction, mesh) > 2.0 - 1e-6
        assert outer[face] == (seen >= 2)


def test_directions_are_unit_vectors_spread_evenly() -> None:
    directions = fibonacci_sphere(500)
    assert np.linalg.norm(directions, axis=1) == pytest.approx(1.0)
    assert np.abs(directions.mean(axis=0)).max() < 0.01
    assert directions.T @ directions / 500 == pytest.approx(np.eye(3) / 3, abs=0.01)


@pytest.mark.parametrize("name", ["empty", "no faces", "one point"])
def test_outer_faces_of_empty_mesh_raise_an_error(name: str) -> None:
    with pytest.raises(MeshError, match="no faces to look at"):
        outer_faces(HOPELESS_MESHES[name])


def test_small_holes_are_filled_and_small_islands_dropped() -> None:
    mesh = sheet(20, 20)
    middle = mesh.vertices[mesh.faces].mean(axis=1)
    hole = np.linalg.norm(middle[:, :2] - [0.03, 0.04], axis=1) < 0.009
    half = middle[:, 0] < 0.06
    island = np.linalg.norm(middle[:, :2] - [0.09, 0.04], axis=1) < 0.009
    chosen = (half & ~hole) | island
    assert np.array_equal(without_islands(mesh, chosen, 5e-4), half)
    assert np.array_equal(without_islands(mesh, chosen, 0.0), chosen)


def test_completely_chosen_components_are_unchanged_by_the_size_limit() -> None:
    mesh = loose_pieces(50)
    chosen = np.zeros(len(mesh.faces), dtype=bool)
    chosen[-20:] = True
    assert np.array_equal(without_islands(mesh, chosen, 1e3), chosen)
