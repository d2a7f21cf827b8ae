"""The dense truth is what theory says of a ball on a bed of springs, and its errors are what they are called."""

from __future__ import annotations

import numpy as np
import pytest

from app.experiments.dense_touch import (
    PRESSED,
    DensePoints,
    ball_radius,
    cell_centres,
    errors,
    misplaced,
    near_blur,
    press,
)
from app.experiments.touch_skins import flat
from app.touch.layer import Layer

LAYER = Layer()
GROUND = flat(100, 0)


@pytest.fixture(scope="module")
def touch():
    at, normal = GROUND.place(0.002, -0.003)
    blur = GROUND.blur(LAYER.depth)
    return press(GROUND.dense, at, normal, 0.01, taxels=len(GROUND.skin), blur=blur, layer=LAYER)


def test_force_is_winklers(touch):
    """F = π K d² (R - d): depths R - s along the radii, of which h / s is across the plane, h = R - d."""
    radius = ball_radius(0.01)
    assert np.sqrt(radius**2 - (radius - PRESSED) ** 2) == pytest.approx(0.01)
    # Along the ball's radius, not the vertical, a point is a little less deep: cos of at most 11 degrees.
    assert touch.load.force == pytest.approx(np.pi * LAYER.foundation * PRESSED**2 * (radius - PRESSED), rel=0.01)
    assert touch.surface.sum() == pytest.approx(touch.load.force, rel=1e-12)
    assert touch.felt.sum() == pytest.approx(touch.load.force, rel=1e-3), "none of it near the border"


def test_what_is_felt_is_spread_farther(touch):
    assert (touch.felt > 1e-3).sum() > (touch.surface > 0).sum()
    assert touch.felt.max() < touch.surface.max()


def test_the_sum_over_pairs_is_the_transform(touch):
    """On the few points around a touch, by both ways."""
    near = np.linalg.norm(GROUND.dense.positions - touch.load.point, axis=1) < 0.006
    thin = np.flatnonzero(near)
    pressures = np.zeros(len(near))
    pressures[thin] = 1e4
    dense = GROUND.dense
    fields = (dense.positions, dense.normals, dense.areas, dense.taxel, dense.parts)
    part = DensePoints(dense.link, *(values[thin] for values in fields))
    plain = near_blur(part, LAYER.depth)(pressures[thin])
    np.testing.assert_allclose(GROUND.blur(LAYER.depth)(pressures)[thin], plain, rtol=2e-3)


def test_the_truth_has_no_error_but_the_place(touch):
    skin, centres = GROUND.skin, cell_centres(GROUND.skin)
    exact = errors(touch, touch.surface / skin.areas, skin, centres)
    assert exact["force_percent"] < 1e-9
    assert exact["surface_percent"] < 1e-9
    assert 5 < exact["felt_percent"] < 20
    assert 0 < exact["place_mm"] < 1, "a cell's force is taken to act in its middle"
    assert errors(touch, touch.felt / skin.areas, skin, centres)["felt_percent"] < 1e-9


def test_errors_are_what_they_are_called(touch):
    skin, centres = GROUND.skin, cell_centres(GROUND.skin)
    half = errors(touch, 0.5 * touch.surface / skin.areas, skin, centres)
    assert half["force_percent"] == pytest.approx(50)
    assert half["surface_percent"] == pytest.approx(50)
    elsewhere = np.zeros(len(skin))
    elsewhere[0] = touch.load.force / skin.areas[0]
    wrong = errors(touch, elsewhere, skin, centres)
    assert wrong["surface_percent"] == pytest.approx(200)
    assert wrong["place_mm"] == pytest.approx(1e3 * np.linalg.norm((centres[0] - touch.load.point)[:2]))
    nothing = errors(touch, np.zeros(len(skin)), skin, centres)
    assert nothing["force_percent"] == pytest.approx(100)
    assert np.isnan(nothing["place_mm"])


def test_a_misplaced_ball_is_told_elsewhere_but_presses_as_it_does(touch):
    told = misplaced(touch, 1e-3)
    moved = told.load.pose.translation - touch.load.pose.translation
    assert np.linalg.norm(moved) == pytest.approx(1e-3)
    assert moved @ touch.load.normal == pytest.approx(0, abs=1e-15)
    np.testing.assert_array_equal(told.load.point, touch.load.point)
    np.testing.assert_array_equal(told.surface, touch.surface)


def test_a_cells_centre_is_the_mean_of_its_points():
    np.testing.assert_allclose(cell_centres(GROUND.skin)[:, :2].mean(axis=0), 0.05, atol=2e-3)
    away = np.linalg.norm(cell_centres(GROUND.skin) - GROUND.skin.patches[0].taxels.positions, axis=1)
    assert away.max() < 0.006, "taxels are 10 mm apart and up to 2 mm off the middles of their cells"
