"""Between taxels: linear functions are exact, no value is invented, and no patch listens to another."""

from __future__ import annotations

import numpy as np
import pytest

from app.maps.build import build_map
from app.maps.interpolation import interpolation_weights
from tests.numerics.map_surfaces import named, sheet, skin_of


@pytest.fixture(scope="module")
def field(three_patches):
    """Places spread over all patches: patch and map point."""
    points = np.random.default_rng(0).uniform(*three_patches.bounds, (6000, 2))
    return three_patches.to_body_many(points)[0], points


def test_rows_sum_to_one_on_the_skin_and_are_empty_elsewhere(three_patches, field):
    sums = np.asarray(interpolation_weights(three_patches, *field).sum(axis=1)).ravel()
    on = field[0] >= 0
    assert 1000 < on.sum() < 5500
    np.testing.assert_allclose(sums[on], 1, rtol=1e-12)
    assert (sums[~on] == 0).all()


def test_nothing_is_extrapolated(three_patches, field):
    weights = interpolation_weights(three_patches, *field)
    assert weights.data.min() > 0
    assert np.diff(weights.indptr).max() <= 3


def test_no_patch_listens_to_another(three_patches, field):
    weights = interpolation_weights(three_patches, *field).tocoo()
    np.testing.assert_array_equal(three_patches.skin.patch_of[weights.col], field[0][weights.row])


def test_a_linear_field_is_reproduced_between_taxels(three_patches, field):
    patch, points = field
    weights = interpolation_weights(three_patches, patch, points)
    inner = np.diff(weights.indptr) == 3
    assert inner.sum() > 500
    shown = weights @ (three_patches.taxel_points @ [3.0, -2.0] + 1)
    np.testing.assert_allclose(shown[inner], points[inner] @ [3.0, -2.0] + 1, atol=1e-9)


def test_a_gap_is_not_bridged():
    """Across the mouth of a horseshoe the taxels of the far arm are the only ones there, and still not asked."""
    map_ = build_map(skin_of(named("spiral"), taxels=60))
    points = map_.uv[0]
    weights = interpolation_weights(map_, np.zeros(len(points), dtype=int), points).tocoo()
    away = np.linalg.norm(points[weights.row] - map_.taxel_points[weights.col], axis=1)
    pitch = np.sqrt(map_.skin.patches[0].surface.area / 60)
    assert np.ptp(points, axis=0).min() > 8 * pitch
    assert away.max() < 2.5 * pitch


def test_at_a_taxel_its_own_value_is_shown(three_patches):
    skin = three_patches.skin
    weights = interpolation_weights(three_patches, skin.patch_of, three_patches.taxel_points)
    np.testing.assert_allclose(weights.toarray(), np.eye(len(skin)), atol=1e-9)


def test_the_field_is_continuous_where_triangles_end(three_patches):
    step, patch = 1e-7, np.zeros(4000, dtype=int)
    low, high = three_patches.uv[0].min(axis=0), three_patches.uv[0].max(axis=0)
    line = np.linspace(low, high, 4000)
    values = np.random.default_rng(0).random(len(three_patches.skin))
    here = interpolation_weights(three_patches, patch, line) @ values
    there = interpolation_weights(three_patches, patch, line + [step, -step]) @ values
    assert np.ptp(here) > 0.1
    # A jump would be of the order of the values' differences, whatever the step.
    assert np.quantile(np.abs(here - there), 0.99) < 1e-3


@pytest.mark.parametrize("taxels", [1, 2, 3])
def test_a_patch_with_few_taxels_is_shown_too(taxels):
    map_ = build_map(skin_of(sheet(), taxels=taxels))
    points = map_.uv[0]
    weights = interpolation_weights(map_, np.zeros(len(points), dtype=int), points)
    np.testing.assert_allclose(np.asarray(weights.sum(axis=1)).ravel(), 1, rtol=1e-12)


def test_taxels_in_one_line_are_shown_along_it():
    map_ = build_map(skin_of(sheet(30, 1, width=0.3, height=0.01), taxels=8))
    weights = interpolation_weights(map_, np.zeros(1, dtype=int), map_.taxel_points[[3]])
    assert weights[0, 3] == pytest.approx(1)


def test_asking_for_nothing_gives_nothing(three_patches):
    assert interpolation_weights(three_patches, np.zeros(0, dtype=int), np.zeros((0, 2))).shape == (0, 120)
