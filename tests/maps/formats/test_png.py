"""The picture of a map's distortion as PNG."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

from tactile_maps.core.errors import MapError
from tactile_maps.maps.build import build_map
from tactile_maps.maps.evaluation.distortion import distortion
from tactile_maps.maps.formats.png import WIDTH, write_distortion_png
from tactile_maps.maps.model.tactile_image import TactileImage
from tests.support.surfaces import sheet, skin_of


@pytest.fixture
def strip():
    """Map of a narrow strip with waves at its end, whose picture has few pixels."""
    waves = sheet(
        40, 4, width=0.4, height=0.02, shape=lambda x, y: 0.02 * np.sin(60 * x) * np.sin(150 * y) * (x > 0.35)
    )
    return build_map(skin_of(waves, taxels=10))


@pytest.mark.parametrize("name", ["strip", pytest.param("three_patches", marks=pytest.mark.long)])
def test_picture_shows_distortion_taxels_and_true_size(name, request, tmp_path):
    map_ = request.getfixturevalue(name)
    write_distortion_png(map_, tmp_path / "map.png")
    with Image.open(tmp_path / "map.png") as picture:
        levels = np.asarray(picture).astype(int)
        texts = picture.text
        density = np.array(picture.info["dpi"]) / 0.0254
    image = TactileImage(map_, width=WIDTH, interpolation="nearest")
    assert levels.shape == (*image.shape, 3)
    np.testing.assert_allclose(density, 1 / image.resolution, rtol=1e-3)
    assert texts["Colour"] == "largest change of a length, white 1, red 2 or more"
    row, column = image.pixel(map_.taxel_points[0])
    assert levels[row, column].tolist() == [0x1F, 0x2D, 0x3A]
    assert (levels[~image.shown] == 255).mean() > 0.9, "dots of taxels at the border may reach outside"
    patch, face, _ = image.places
    starts = np.cumsum([0, *(len(chart.faces) for chart in map_.charts)])
    worst = distortion(map_).isometry[starts[patch] + face]
    blue = levels[..., 2].ravel()
    taxel = (levels == [0x1F, 0x2D, 0x3A]).all(axis=2).ravel()
    low = (face >= 0) & ~taxel & (worst < np.quantile(worst[face >= 0], 0.1))
    high = (face >= 0) & ~taxel & (worst > np.quantile(worst[face >= 0], 0.9))
    assert blue[low].mean() > blue[high].mean()


@pytest.mark.long
def test_unwritable_path_is_an_error(three_patches, tmp_path):
    with pytest.raises(MapError, match="cannot be written"):
        write_distortion_png(three_patches, tmp_path / "no" / "map.png")
