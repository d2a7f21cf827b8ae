"""The tactile image against what scipy, analysis and brute force say, on bodies that are not flat."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import LinearNDInterpolator, NearestNDInterpolator, RBFInterpolator, griddata

from tactile_maps.maps.build import build_map
from tactile_maps.maps.model.interpolation import INTERPOLATIONS
from tactile_maps.maps.model.tactile_image import TactileImage
from tactile_maps.studies.sweeps.image_cost import sharp, smooth
from tactile_maps.studies.testbeds.reference_bodies import SIDE, flat_map
from tests.support.surfaces import frustum, named, sheet, skin_of

SURFACES = {
    "tube": lambda: frustum(along=16, around=30),
    "bumpy tube": lambda: frustum(0.05, 0.03, bump=0.2),
    "hemisphere": lambda: named("hemisphere"),
    "sieve": lambda: named("sieve"),
    "torus": lambda: named("torus"),
    "spiral": lambda: named("spiral"),
}


@pytest.fixture(scope="module")
def square():
    return flat_map(400, seed=2)


def _inner(image, map_, margin=1.5):
    """(rows, columns) pixels well inside the outermost taxels."""
    away = np.abs(image.centres() / SIDE - 0.5).max(axis=1)
    return (away < 0.5 - margin / np.sqrt(len(map_.skin))).reshape(image.shape)


def _shown(image, values):
    return image.weights.astype(np.float64) @ values


@pytest.mark.parametrize(
    ("interpolation", "scipys"), [("barycentric", LinearNDInterpolator), ("nearest", NearestNDInterpolator)]
)
def test_image_equals_that_of_scipy(square, interpolation, scipys):
    image = TactileImage(square, width=100, interpolation=interpolation)
    values = np.random.default_rng(0).random(len(square.skin))
    expected = scipys(square.taxel_points, values)(image.centres()).reshape(image.shape)
    inner = _inner(image, square)
    assert inner.mean() > 0.6
    np.testing.assert_allclose(_shown(image, values).reshape(image.shape)[inner], expected[inner], atol=1e-6)


def test_image_equals_that_of_griddata(square):
    image = TactileImage(square, width=64)
    values = 1e4 * smooth(square.taxel_points)
    expected = griddata(square.taxel_points, values, image.centres()).reshape(image.shape)
    inner = _inner(image, square)
    np.testing.assert_allclose(1e3 * image.render(values)[inner], expected[inner], rtol=1e-5)


def test_local_plates_approximate_the_global_plate(square):
    image = TactileImage(square, width=64, interpolation="thin-plate")
    values = smooth(square.taxel_points)
    inner = _inner(image, square)
    whole = RBFInterpolator(square.taxel_points, values, kernel="thin_plate_spline")(image.centres())
    apart = (_shown(image, values) - whole).reshape(image.shape)[inner]
    assert np.sqrt((apart**2).mean()) < 1.5e-3


@pytest.mark.long
@pytest.mark.sampled(2)
@pytest.mark.parametrize(
    ("interpolation", "order"), [("nearest", 1), ("barycentric", 2), ("natural-neighbour", 2), ("thin-plate", 2)]
)
def test_errors_on_a_smooth_field_decrease_with_the_pitch_as_predicted(interpolation, order):
    errors = []
    for taxels in (400, 3600):
        map_ = flat_map(taxels)
        image = TactileImage(map_, width=150, interpolation=interpolation)
        error = _shown(image, smooth(map_.taxel_points)) - smooth(image.centres())
        errors.append(np.sqrt((error.reshape(image.shape)[_inner(image, map_)] ** 2).mean()))
    assert np.log(errors[0] / errors[1]) / np.log(3) == pytest.approx(order, abs=0.45)


def test_sharp_edge_is_blurred_by_at_most_one_pitch(square):
    """Only where the contact's rim is near may the image be wrong by much."""
    image = TactileImage(square, width=128)
    error = np.abs(_shown(image, sharp(square.taxel_points)) - sharp(image.centres()))
    from_rim = np.abs(np.linalg.norm(image.centres() - SIDE / 2, axis=1) - SIDE / 4)
    assert error[from_rim < 0.002].max() > 0.1
    assert error[from_rim > 2 * SIDE / 20].max() < 0.04


@pytest.mark.long
@pytest.mark.sampled(4)
@pytest.mark.parametrize("interpolation", INTERPOLATIONS)
@pytest.mark.parametrize("name", SURFACES)
def test_force_is_conserved_to_rounding_on_any_body(name, interpolation):
    map_ = build_map(skin_of(SURFACES[name](), taxels=60))
    image = TactileImage(map_, width=128, interpolation=interpolation)
    areas = image.pixel_areas.ravel()
    np.testing.assert_allclose(image.weights.T.astype(np.float64) @ areas, map_.skin.areas, rtol=1e-12)
    assert areas.sum() == pytest.approx(map_.skin.areas.sum(), rel=1e-6)


@pytest.mark.long
@pytest.mark.sampled(2)
@pytest.mark.parametrize("name", SURFACES)
def test_rows_sum_to_one_and_blank_pixels_are_blank(name):
    map_ = build_map(skin_of(SURFACES[name](), sheet(), taxels=30))
    for interpolation in INTERPOLATIONS:
        image = TactileImage(map_, width=96, interpolation=interpolation)
        sums = np.asarray(image.weights.astype(np.float64).sum(axis=1)).reshape(image.shape)
        np.testing.assert_allclose(sums[image.shown], 1, rtol=3e-6)
        assert (sums[~image.shown] == 0).all()
        asked = image.weights.tocoo()
        patch = map_.to_body_many(image.centres())[0][asked.row]
        on = patch >= 0
        np.testing.assert_array_equal(map_.skin.patch_of[asked.col[on]], patch[on])


def test_coarse_image_conserves_the_force_of_visible_taxels():
    """Force on taxels that no pixel shows is not kept if pixels are fewer than taxels, and this is detectable."""
    map_ = flat_map(400)
    image = TactileImage(map_, width=12, interpolation="nearest")
    kept = image.weights.T.astype(np.float64) @ image.pixel_areas.ravel()
    seen = np.unique(image.weights.indices)
    assert 100 < len(seen) < 200
    np.testing.assert_allclose(kept[seen], map_.skin.areas[seen], rtol=1e-12)
    assert (np.delete(kept, seen) == 0).all()
