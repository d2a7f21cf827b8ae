from __future__ import annotations

import struct

import numpy as np
import pytest
from PIL import Image

from tactile_maps.core.errors import MapError
from tactile_maps.maps.formats.png import write_image_png
from tactile_maps.maps.model.tactile_image import TactileImage


@pytest.fixture(scope="module")
def image(three_patches) -> TactileImage:
    return TactileImage(three_patches, width=90)


@pytest.fixture(scope="module")
def pressures(three_patches):
    return np.linspace(0, 8000, len(three_patches.skin))


def decoded(path):
    """Levels, bits a pixel, texts, and pixels a metre across and up with their unit."""
    data = path.read_bytes()
    at = data.index(b"pHYs") + 4
    with Image.open(path) as picture:
        bits = {"L": 8, "I;16": 16}[picture.mode]
        return np.asarray(picture).astype(int), bits, picture.text, struct.unpack_from(">IIB", data, at)


@pytest.mark.parametrize("bits", [8, 16])
def test_levels_are_pressures_over_the_full_scale(image, pressures, tmp_path, bits):
    write_image_png(image, pressures, tmp_path / "image.png", full_scale=10.0, bits=bits)
    levels, depth, texts, density = decoded(tmp_path / "image.png")
    assert (depth, levels.shape) == (bits, image.shape)
    np.testing.assert_allclose(levels / (2**bits - 1) * 10.0, image.render(pressures), atol=10.0 / 2**bits)
    assert levels.max() > 0.7 * 2**bits
    assert (levels[~image.shown] == 0).all()
    assert float(texts["Full scale kPa"]) == 10.0
    np.testing.assert_array_equal(np.array(texts["Extent m"].split(), dtype=float), image.extent.ravel())
    assert texts["Pixels above full scale"] == "0"
    assert density == (round(1 / image.resolution), round(1 / image.resolution), 1)


def test_the_largest_pixel_is_white_unless_told_otherwise(image, pressures, tmp_path):
    write_image_png(image, pressures, tmp_path / "image.png")
    levels, _, texts, _ = decoded(tmp_path / "image.png")
    assert levels.max() == 65535
    assert float(texts["Full scale kPa"]) == pytest.approx(float(image.render(pressures).max()))
    write_image_png(image, 0 * pressures, tmp_path / "dark.png")
    levels, _, texts, _ = decoded(tmp_path / "dark.png")
    assert (levels.max(), texts["Full scale kPa"]) == (0, "1.0")


def test_what_is_above_full_scale_is_counted(image, pressures, tmp_path):
    write_image_png(image, pressures, tmp_path / "image.png", full_scale=4.0)
    levels, _, texts, _ = decoded(tmp_path / "image.png")
    above = int((image.render(pressures) > 4.0).sum())
    assert above > 0
    assert int(texts["Pixels above full scale"]) == above
    assert (levels == 65535).sum() >= above


def test_what_cannot_be_is_refused(image, pressures, tmp_path):
    with pytest.raises(MapError, match="8 or 16 bits.*12"):
        write_image_png(image, pressures, tmp_path / "image.png", bits=12)
    for scale in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(MapError, match="above zero"):
            write_image_png(image, pressures, tmp_path / "image.png", full_scale=scale)
    with pytest.raises(MapError, match="cannot be written"):
        write_image_png(image, pressures, tmp_path / "no" / "image.png")
