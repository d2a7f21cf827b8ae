from __future__ import annotations

import numpy as np
import pytest

from app.errors import MeshError
from app.geometry.raycast import RayCaster
from tests.numerics.hard_meshes import HARD_MESHES, HOPELESS_MESHES

CUBE = HARD_MESHES["cube"]  # 0.2 × 0.15 × 0.1 m around the origin
DOWN = np.array([0, 0, -1.0])


def test_the_front_face_is_hit_not_the_back() -> None:
    hit = RayCaster(CUBE).first_hit(np.array([0.01, 0.02, 1.0]), 5 * DOWN)
    assert hit is not None
    assert hit.distance == pytest.approx(0.95, abs=1e-12)
    assert CUBE.point(hit.face, hit.weights) == pytest.approx([0.01, 0.02, 0.05], abs=1e-12)
    assert CUBE.face_normals[hit.face] == pytest.approx([0, 0, 1])


def test_from_inside_the_back_of_a_face_is_hit() -> None:
    hit = RayCaster(CUBE).first_hit(np.zeros(3), DOWN)
    assert hit is not None
    assert hit.distance == pytest.approx(0.05)


@pytest.mark.parametrize(("origin", "direction"), [((1, 0, 1), (0, 0, -1)), ((0, 0, 1), (0, 0, 1))])
def test_a_miss_is_none(origin: tuple[float, ...], direction: tuple[float, ...]) -> None:
    assert RayCaster(CUBE).first_hit(np.array(origin), np.array(direction)) is None


@pytest.mark.parametrize("direction", [np.zeros(3), np.array([np.nan, 0, 1])])
def test_a_ray_without_direction_is_refused(direction: np.ndarray) -> None:
    with pytest.raises(MeshError, match="ray"):
        RayCaster(CUBE).first_hit(np.zeros(3), direction)


def test_a_mesh_without_faces_is_refused() -> None:
    with pytest.raises(MeshError, match="no faces"):
        RayCaster(HOPELESS_MESHES["no faces"])
