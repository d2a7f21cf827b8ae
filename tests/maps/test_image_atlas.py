"""The atlas of the live image: it shows what the map's own image shows, and keeps the tiles that are still right."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest

from tactile_maps.maps.image_atlas import ImageAtlas, ImageSettings
from tactile_maps.maps.model.tactile_image import TactileImage


@pytest.fixture(scope="module")
def atlas(three_patches):
    return ImageAtlas(three_patches)


def _stretched(map_, factor):
    """The same map with another first chart."""
    first, *others = map_.charts
    return replace(map_, charts=(replace(first, plane=factor * first.plane), *others))


@pytest.mark.long
def test_atlas_image_equals_that_of_the_whole_map(three_patches, atlas):
    whole = TactileImage(three_patches, width=700)
    pressures = 1e4 * np.random.default_rng(3).random(len(three_patches.skin))
    out = np.zeros(atlas.shape, np.float32)
    atlas.render(pressures, out)
    expected = whole.render(pressures)
    patch, face, bary = atlas.places
    held = np.flatnonzero(face >= 0)[::97]
    points = three_patches.to_map_many(patch[held], face[held], bary[held])
    there = np.array([expected[whole.pixel(point)] for point in points])
    assert len(held) > 1000
    assert np.abs(out.ravel()[held] - there).mean() < 0.02 * out.max()
    for number, chart in enumerate(three_patches.charts):
        middles = atlas.plane(number)[chart.faces].mean(axis=1)
        columns, rows = (middles / atlas.resolution).astype(int).T
        flat = (atlas.shape[0] - 1 - rows) * atlas.shape[1] + columns
        assert (patch[flat] == number).mean() > 0.99


@pytest.mark.long
def test_chart_that_outgrows_its_image_gets_coarser_pixels(three_patches, atlas):
    second = ImageAtlas(_stretched(three_patches, 9.0), known=atlas)
    assert second.resolution > 2 * atlas.resolution
    assert np.prod(second.shape) < 2 * np.prod(atlas.shape)


@pytest.mark.long
def test_only_the_tile_of_a_new_chart_is_computed_and_undo_reuses_tiles(three_patches, atlas):
    second = ImageAtlas(_stretched(three_patches, 1.1), known=atlas)
    again = ImageAtlas(three_patches, known=second)
    kept = [new is old for new, old in zip(second.tiles, atlas.tiles, strict=True)]
    assert kept == [False, True, True]
    assert all(tile is old for tile, old in zip(again.tiles, atlas.tiles, strict=True))
    assert ImageAtlas(three_patches, known=again, look=ImageSettings("nearest")).tiles[0] is not atlas.tiles[0]


def test_atlas_made_in_another_process_is_sent_with_its_map(three_patches, atlas):
    map_, came = pickle.loads(pickle.dumps((three_patches, atlas)))
    assert came.skin is map_.skin
    assert all(tile.chart is chart for tile, chart in zip(came.tiles, map_.charts, strict=True))
    pressures = 1e4 * np.random.default_rng(4).random(len(three_patches.skin))
    here = np.zeros(atlas.shape, np.float32)
    there = np.zeros(atlas.shape, np.float32)
    atlas.render(pressures, here)
    came.render(pressures, there)
    np.testing.assert_array_equal(here, there)
