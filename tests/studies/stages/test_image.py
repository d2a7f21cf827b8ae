"""The image stage: fields that are known, and errors ordered as theory says."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.maps.model.interpolation import INTERPOLATIONS
from tactile_maps.maps.model.tactile_image import TactileImage
from tactile_maps.studies.stages.image import PIXELS, STAGE, resolution, sample_fields
from tactile_maps.studies.study.work_precision import Setting


@pytest.fixture(scope="module")
def found(tube):
    """Errors by interpolation and pixels."""
    requested = [Setting("image", method, {"pixels": n}) for method in INTERPOLATIONS for n in (16, 128)]
    return {(s.method, s.values["pixels"]): next(iter(STAGE.trials(tube, s))) for s in requested}


def test_every_interpolation_and_number_of_pixels_is_tried(tube):
    requested = STAGE.settings(tube)
    assert {(s.method, s.values["pixels"]) for s in requested} == {(m, n) for m in INTERPOLATIONS for n in PIXELS}
    assert all(s.patches == () for s in requested), "an image is of the whole map"
    assert STAGE.current(tube) is None
    assert STAGE.recipes is None


@pytest.mark.long
def test_more_pixels_are_more_exact(found):
    for method in INTERPOLATIONS:
        coarse = found[method, 16].errors
        fine = found[method, 128].errors
        assert fine["place"] < 0.25 * coarse["place"], "a pixel is an eighth as wide"
        assert fine["press"] < coarse["press"]


def test_smoother_interpolations_show_smooth_pressure_better(found):
    errors = {method: found[method, 128].errors["smooth"] for method in INTERPOLATIONS}
    assert errors["thin-plate"] < errors["barycentric"] < errors["nearest"]
    assert all(0 < error < 50 for error in errors.values())


def test_image_has_about_the_requested_number_of_pixels(bodies):
    image = TactileImage(bodies, resolution=resolution(bodies, 64))
    assert np.prod(image.shape) == pytest.approx(64**2, rel=0.05)


def test_fields_are_between_0_and_1_and_reproducible(bodies):
    one, other = (sample_fields(bodies.skin, count=2000) for _ in range(2))
    for field in (*one.press, *one.smooth):
        assert 0 <= field.min() < field.max() <= 1
    np.testing.assert_array_equal(one.press[0], other.press[0])
    assert 0 < one.pressed.mean() < 1
    assert (one.press[0][~one.pressed] == 0).all()
    share = np.bincount(one.patch) / 2000
    areas = np.array([patch.surface.area for patch in bodies.skin.patches])
    np.testing.assert_allclose(share, areas / areas.sum(), atol=0.05)


def test_error_of_sampled_positions_has_an_interval_and_that_of_all_taxels_none(tube):
    (found,) = STAGE.trials(tube, Setting("image", "nearest", {"pixels": 64}))
    assert set(found.intervals) == {"press", "smooth"}
    for key, (low, high) in found.intervals.items():
        assert low < found.errors[key] < high < 1.1 * low
