"""The grounds: as many points as promised, on the surface that the formula means, each with its taxel."""

from __future__ import annotations

import numpy as np
import pytest

from app.experiments.touch_skins import GROUNDS, LENGTH, RADIUS, bent, flat


@pytest.mark.parametrize("name", GROUNDS)
def test_points_are_dense_and_cover_the_skin(name):
    ground = GROUNDS[name](100, 0)
    dense = ground.dense
    assert len(ground.skin) == 100
    assert len(dense.areas) == np.prod(ground.shape) == pytest.approx(200_000, rel=0.01)
    assert dense.areas.sum() == pytest.approx(ground.skin.areas.sum(), rel=2e-3)
    by_taxel = np.bincount(dense.taxel, dense.parts, 100)
    np.testing.assert_allclose(by_taxel, ground.skin.areas, rtol=1e-9)
    np.testing.assert_allclose(dense.parts, dense.areas, rtol=0.05)
    np.testing.assert_allclose(np.linalg.norm(dense.normals, axis=1), 1)


def test_the_bent_one_is_a_tube():
    ground = bent(100, 0)
    np.testing.assert_allclose(np.hypot(*ground.dense.positions[:, :2].T), RADIUS)
    surface = ground.skin.patches[0].surface
    np.testing.assert_allclose(np.hypot(*surface.vertices[:, :2].T), RADIUS)
    assert np.ptp(surface.vertices[:, 2]) == pytest.approx(LENGTH)
    at, normal = ground.place(0.0, 0.01)
    np.testing.assert_allclose(at[:2], RADIUS * normal[:2])
    assert at[2] == pytest.approx(0.11, abs=ground.pitch[0])


def test_places_are_counted_from_the_middle():
    ground = flat(100, 0)
    at, normal = ground.place(0.01, -0.02)
    np.testing.assert_allclose(at, [0.06, 0.03, 0], atol=ground.pitch[0])
    np.testing.assert_array_equal(normal, [0, 0, 1])


def test_through_a_bent_body_distances_are_straight():
    """What is felt right across the tube is nothing, and pressure all over is felt whole in the middle."""
    ground = bent(100, 0)
    felt = ground.blur(0.002)(np.ones(len(ground.dense.areas))).reshape(ground.shape)
    middle = felt[ground.shape[0] // 2, ground.shape[1] // 2]
    assert middle == pytest.approx(1, abs=0.01), "a chord is a little shorter than its arc"
