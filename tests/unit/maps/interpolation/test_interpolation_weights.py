"""Between taxels, whatever the method: sums of one, own values kept, linear fields exact, patches apart."""

from __future__ import annotations

import numpy as np
import pytest

from app.errors import MapError
from app.maps.build import build_map
from app.maps.interpolation.triangles import TaxelTriangles
from app.maps.interpolation.weights import INTERPOLATIONS, interpolation_weights
from tests.numerics.map_surfaces import named, sheet, skin_of
from tests.numerics.taxel_fields import jittered

EVERY = pytest.mark.parametrize("method", INTERPOLATIONS)
CONTINUOUS = pytest.mark.parametrize("method", [name for name in INTERPOLATIONS if name != "nearest"])


@pytest.fixture(scope="module")
def field(three_patches):
    """Places spread over all patches: patch and map point."""
    points = np.random.default_rng(0).uniform(*three_patches.bounds, (6000, 2))
    return three_patches.to_body_many(points)[0], points


def test_there_are_four_methods():
    assert list(INTERPOLATIONS) == ["barycentric", "nearest", "natural-neighbour", "thin-plate"]


def test_an_unknown_method_is_a_named_error(three_patches, field):
    with pytest.raises(MapError, match=r"cubic.*natural-neighbour"):
        interpolation_weights(three_patches, *field, interpolation="cubic")


@EVERY
def test_rows_sum_to_one_on_the_skin_and_are_empty_elsewhere(three_patches, field, method):
    weights = interpolation_weights(three_patches, *field, interpolation=method)
    sums, on = np.asarray(weights.sum(axis=1)).ravel(), field[0] >= 0
    assert 1000 < on.sum() < 5500
    np.testing.assert_allclose(sums[on], 1, rtol=1e-12)
    assert (np.diff(weights.indptr)[~on] == 0).all()


@pytest.mark.parametrize(
    ("method", "most"), [("barycentric", 3), ("nearest", 1), ("natural-neighbour", 12), ("thin-plate", 48)]
)
def test_few_taxels_near_the_point_are_asked(three_patches, field, method, most):
    weights = interpolation_weights(three_patches, *field, interpolation=method)
    assert np.diff(weights.indptr).max() <= most
    asked = weights.tocoo()
    away = np.linalg.norm(field[1][asked.row] - three_patches.taxel_points[asked.col], axis=1)
    assert away.max() < 0.7 * np.ptp(three_patches.uv[0], axis=0).max()


@pytest.mark.parametrize("method", ["barycentric", "nearest", "natural-neighbour"])
def test_nothing_is_extrapolated(three_patches, field, method):
    assert interpolation_weights(three_patches, *field, interpolation=method).data.min() > -1e-12


@EVERY
def test_no_patch_listens_to_another(three_patches, field, method):
    weights = interpolation_weights(three_patches, *field, interpolation=method).tocoo()
    np.testing.assert_array_equal(three_patches.skin.patch_of[weights.col], field[0][weights.row])


@CONTINUOUS
def test_a_linear_field_is_reproduced_between_taxels(three_patches, field, method):
    patch, points = field
    inner = np.diff(interpolation_weights(three_patches, patch, points).indptr) == 3
    assert inner.sum() > 500
    weights = interpolation_weights(three_patches, patch, points, interpolation=method)
    shown = weights @ (three_patches.taxel_points @ [3.0, -2.0] + 1)
    np.testing.assert_allclose(shown[inner], points[inner] @ [3.0, -2.0] + 1, atol=1e-12)


@EVERY
def test_a_gap_is_not_bridged(method):
    """Across the mouth of a horseshoe the taxels of the far arm are the only ones there, and still not asked."""
    map_ = build_map(skin_of(named("spiral"), taxels=60))
    points = map_.uv[0]
    weights = interpolation_weights(map_, np.zeros(len(points), dtype=int), points, interpolation=method).tocoo()
    away = np.linalg.norm(points[weights.row] - map_.taxel_points[weights.col], axis=1)
    pitch = np.sqrt(map_.skin.patches[0].surface.area / 60)
    assert np.ptp(points, axis=0).min() > 8 * pitch
    assert away.max() < (6 if method == "thin-plate" else 2.5) * pitch


@EVERY
def test_at_a_taxel_its_own_value_is_shown(three_patches, method):
    skin = three_patches.skin
    weights = interpolation_weights(three_patches, skin.patch_of, three_patches.taxel_points, interpolation=method)
    np.testing.assert_allclose(weights.toarray(), np.eye(len(skin)), atol=1e-9)


@CONTINUOUS
def test_the_field_is_continuous_where_triangles_end(three_patches, method):
    step, patch = 1e-7, np.zeros(4000, dtype=int)
    low, high = three_patches.uv[0].min(axis=0), three_patches.uv[0].max(axis=0)
    line = np.linspace(low, high, 4000)
    values = np.random.default_rng(0).random(len(three_patches.skin))
    here, there = (
        interpolation_weights(three_patches, patch, line + move, interpolation=method) @ values
        for move in ([0, 0], [step, -step])
    )
    assert np.ptp(here) > 0.1
    # A jump would be of the order of the values' differences, whatever the step.
    assert np.quantile(np.abs(here - there), 0.99) < 1e-3


@EVERY
@pytest.mark.parametrize("taxels", [1, 2, 3])
def test_a_patch_with_few_taxels_is_shown_too(taxels, method):
    map_ = build_map(skin_of(sheet(), taxels=taxels))
    points = map_.uv[0]
    weights = interpolation_weights(map_, np.zeros(len(points), dtype=int), points, interpolation=method)
    np.testing.assert_allclose(np.asarray(weights.sum(axis=1)).ravel(), 1, rtol=1e-12)


@EVERY
def test_taxels_in_one_line_are_shown_along_it(method):
    map_ = build_map(skin_of(sheet(30, 1, width=0.3, height=0.01), taxels=8))
    weights = interpolation_weights(map_, np.zeros(1, dtype=int), map_.taxel_points[[3]], interpolation=method)
    assert weights[0, 3] == pytest.approx(1)


@EVERY
def test_asking_for_nothing_gives_nothing(three_patches, method):
    weights = interpolation_weights(three_patches, np.zeros(0, dtype=int), np.zeros((0, 2)), interpolation=method)
    assert weights.shape == (0, 120)


@EVERY
def test_many_points_have_the_weights_that_few_have(method):
    """They are worked off in parts."""
    triangles = TaxelTriangles(jittered())
    points = np.random.default_rng(0).uniform(-0.01, 0.1, (90_000, 2))
    assert (triangles.locate(points)[0] >= 0).sum() > 2**15
    every = INTERPOLATIONS[method](triangles, points)
    for few in (slice(0, 200), slice(50_000, 50_200), slice(-200, None)):
        alone = INTERPOLATIONS[method](triangles, points[few])
        assert abs(every[few] - alone).max() < 1e-12
