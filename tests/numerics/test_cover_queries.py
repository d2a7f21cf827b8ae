"""Closest points and rays against slow and plain answers."""

from __future__ import annotations

import numpy as np
import pytest

from app.geometry.closest import ClosestPoint
from app.geometry.mesh import Mesh
from app.geometry.raycast import RayCaster
from tests.numerics.brute_force import distances, first_hit
from tests.numerics.hard_meshes import HARD_MESHES

NAMES = ("cube", "torus", "soup", "slivers", "moebius", "huge offset", "tiny", "zero-area faces", "one triangle")


def around(mesh: Mesh, count: int) -> np.ndarray:
    low, high = mesh.bounds
    return np.random.default_rng(3).uniform(low - 0.3 * mesh.size, high + 0.3 * mesh.size, (count, 3))


@pytest.mark.parametrize("name", NAMES)
def test_closest_points_agree_with_brute_force(name: str) -> None:
    mesh = HARD_MESHES[name]
    points = around(mesh, 100)
    faces, weights, away = ClosestPoint(mesh).query(points)
    scale = max(mesh.size, 1e-3 * np.abs(mesh.bounds).max())
    assert away == pytest.approx(distances(points, mesh), abs=1e-9 * scale)
    assert (weights >= 0).all()
    assert weights.sum(axis=1) == pytest.approx(1.0, abs=1e-12)
    reached = np.linalg.norm(mesh.points(faces, weights) - points, axis=1)
    assert reached == pytest.approx(away, abs=1e-6 * scale)


@pytest.mark.parametrize("name", NAMES)
def test_first_hits_agree_with_brute_force(name: str) -> None:
    mesh = HARD_MESHES[name]
    caster, hits = RayCaster(mesh), 0
    inside = mesh.bounds[0] + np.random.default_rng(5).uniform(0.2, 0.8, (80, 3)) * np.ptp(mesh.bounds, axis=0)
    for origin, target in zip(around(mesh, 80), inside, strict=True):
        direction = (target - origin) / np.linalg.norm(target - origin)
        expected = first_hit(origin, direction, mesh)
        found = caster.first_hit(origin, 3.0 * direction)
        assert (found is None) == np.isinf(expected)
        if found is not None:
            hits += 1
            assert found.distance == pytest.approx(expected, abs=1e-5 * mesh.size)
            place = mesh.point(found.face, found.weights)
            assert place == pytest.approx(origin + found.distance * direction, abs=1e-5 * mesh.size)
    assert hits > 10


def test_a_far_camera_still_hits_to_a_micrometre() -> None:
    mesh = HARD_MESHES["cube"]
    found = RayCaster(mesh).first_hit(np.array([0.01, 0.02, 1000.0]), np.array([0.0, 0.0, -1.0]))
    assert found is not None
    assert found.distance == pytest.approx(1000.0 - 0.05, abs=1e-6)
