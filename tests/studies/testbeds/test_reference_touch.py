"""The touch that is known, against springs and stress worked out by hand, and the skins it is on."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.studies.testbeds.reference_touch import (
    INDENTATION,
    LENGTH,
    RADIUS,
    REFERENCE_SKINS,
    DensePoints,
    ball_radius,
    cell_centres,
    flat_skin,
    pairwise_blur,
    press_ball,
    touch_errors,
    tubular_skin,
)
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer

LAYER = ElasticLayer()
TESTED = flat_skin(100, 0)


@pytest.fixture(scope="module")
def touch():
    at, normal = TESTED.place(0.002, -0.003)
    blur = TESTED.blur(LAYER.depth)
    return press_ball(TESTED.dense, at, normal, 0.01, taxels=len(TESTED.skin), blur=blur, layer=LAYER)


def test_force_follows_the_winkler_formula(touch):
    """F = π K d² (R - d): depths R - s along the radii, of which h / s is across the plane, h = R - d."""
    radius = ball_radius(0.01)
    assert np.sqrt(radius**2 - (radius - INDENTATION) ** 2) == pytest.approx(0.01)
    # Along the ball's radius, not the vertical, a point is a little less deep: cos of at most 11 degrees.
    assert touch.load.force == pytest.approx(
        np.pi * LAYER.foundation * INDENTATION**2 * (radius - INDENTATION), rel=0.01
    )
    assert touch.surface.sum() == pytest.approx(touch.load.force, rel=1e-12)
    assert touch.felt.sum() == pytest.approx(touch.load.force, rel=1e-3), "none of it near the border"


@pytest.mark.long
def test_sum_over_pairs_equals_the_transform(touch):
    """Both methods are compared at the few points around a touch."""
    near = np.linalg.norm(TESTED.dense.positions - touch.load.point, axis=1) < 0.006
    thin = np.flatnonzero(near)
    pressures = np.zeros(len(near))
    pressures[thin] = 1e4
    dense = TESTED.dense
    fields = (dense.positions, dense.normals, dense.areas, dense.taxel, dense.parts)
    part = DensePoints(dense.link, *(values[thin] for values in fields))
    plain = pairwise_blur(part, LAYER.depth)(pressures[thin])
    np.testing.assert_allclose(TESTED.blur(LAYER.depth)(pressures)[thin], plain, rtol=2e-3)


def test_exact_reading_has_only_a_position_error(touch):
    skin = TESTED.skin
    centres = cell_centres(TESTED.skin)
    exact = touch_errors(touch, touch.surface / skin.areas, skin, centres)
    assert exact["force_percent"] < 1e-9
    assert exact["surface_percent"] < 1e-9
    assert 5 < exact["depth_percent"] < 20
    assert 0 < exact["place_mm"] < 1, "a cell's force is taken to act in its middle"
    assert touch_errors(touch, touch.felt / skin.areas, skin, centres)["depth_percent"] < 1e-9


def test_errors_agree_with_their_definitions(touch):
    skin = TESTED.skin
    centres = cell_centres(TESTED.skin)
    half = touch_errors(touch, 0.5 * touch.surface / skin.areas, skin, centres)
    assert half["force_percent"] == pytest.approx(50)
    assert half["surface_percent"] == pytest.approx(50)
    elsewhere = np.zeros(len(skin))
    elsewhere[0] = touch.load.force / skin.areas[0]
    wrong = touch_errors(touch, elsewhere, skin, centres)
    assert wrong["surface_percent"] == pytest.approx(200)
    assert wrong["place_mm"] == pytest.approx(1e3 * np.linalg.norm((centres[0] - touch.load.point)[:2]))
    nothing = touch_errors(touch, np.zeros(len(skin)), skin, centres)
    assert nothing["force_percent"] == pytest.approx(100)
    assert nothing["place_mm"] is None


@pytest.mark.parametrize("name", REFERENCE_SKINS)
def test_points_are_dense_and_cover_the_skin(name):
    tested = REFERENCE_SKINS[name](100, 0)
    dense = tested.dense
    assert len(tested.skin) == 100
    assert len(dense.areas) == np.prod(tested.shape) == pytest.approx(200_000, rel=0.01)
    assert dense.areas.sum() == pytest.approx(tested.skin.areas.sum(), rel=2e-3)
    by_taxel = np.bincount(dense.taxel, dense.parts, 100)
    np.testing.assert_allclose(by_taxel, tested.skin.areas, rtol=1e-9)
    np.testing.assert_allclose(dense.parts, dense.areas, rtol=0.05)
    np.testing.assert_allclose(np.linalg.norm(dense.normals, axis=1), 1)


def test_tubular_skin_has_the_stated_radius_and_length():
    tested = tubular_skin(100, 0)
    np.testing.assert_allclose(np.hypot(*tested.dense.positions[:, :2].T), RADIUS)
    surface = tested.skin.patches[0].surface
    np.testing.assert_allclose(np.hypot(*surface.vertices[:, :2].T), RADIUS)
    assert np.ptp(surface.vertices[:, 2]) == pytest.approx(LENGTH)
    at, normal = tested.place(0.0, 0.01)
    np.testing.assert_allclose(at[:2], RADIUS * normal[:2])
    assert at[2] == pytest.approx(0.11, abs=tested.pitch[0])


def test_distances_through_a_curved_body_are_straight():
    """No pressure reaches the opposite side of the tube; uniform pressure is unchanged in the middle."""
    tested = tubular_skin(100, 0)
    felt = tested.blur(0.002)(np.ones(len(tested.dense.areas))).reshape(tested.shape)
    middle = felt[tested.shape[0] // 2, tested.shape[1] // 2]
    assert middle == pytest.approx(1, abs=0.01), "a chord is a little shorter than its arc"
