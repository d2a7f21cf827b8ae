"""The current image of the map and the data shared by the views of a document.

The image is a single buffer in the colours of the scale with an extended rim. The atlas is the map's image, flaws are
those of the whole map, and a camera shows the same.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tactile_maps.editing.arrange import mirror, move, rotate, scale
from tactile_maps.editing.document import MapDocument, show_patches
from tactile_maps.flattening.bijectivity import crossing_sides, flipped
from tactile_maps.maps.evaluation.distortion import nested_patches
from tactile_maps.maps.evaluation.quality import measure
from tactile_maps.maps.image_atlas import ImageAtlas, halo_of
from tactile_widgets.common.colours import PressureScale
from tactile_widgets.views.map.items.bijectivity import FlawFinder, Flaws
from tactile_widgets.views.map.items.live_image import LiveImage
from tests.support.touch import arm
from tests.widgets.support.arrange_driver import bent
from tests.widgets.support.samples import leaf_map


@pytest.fixture
def inside():
    inside = np.zeros((20, 30), dtype=bool)
    inside[5:15, 10:20] = True
    return inside


def live_image(inside):
    return LiveImage(inside.shape, *halo_of(inside))


def colour(live, row, column):
    return live.image.pixel(column, row) & 0xFFFFFF


def test_pressures_have_the_colours_of_the_scale(inside):
    live = live_image(inside)
    scale = PressureScale(20.0)
    kilopascals = np.zeros(inside.shape, np.float32)
    kilopascals[7, 12] = 10.0
    kilopascals[8, 12] = 20.0
    kilopascals[9, 12] = 500.0
    live.fill(kilopascals, scale)
    half = (len(scale.lut) - 1) // 2
    assert colour(live, 6, 12) == int(scale.lut[0]) & 0xFFFFFF
    assert colour(live, 7, 12) == int(scale.lut[half]) & 0xFFFFFF
    assert colour(live, 8, 12) == colour(live, 9, 12) == int(scale.lut[-1]) & 0xFFFFFF


def test_rim_pixels_copy_the_nearest_colour(inside):
    live = live_image(inside)
    scale = PressureScale(20.0)
    live.fill(np.where(inside, np.float32(20.0), np.float32(0.0)), scale)
    top = int(scale.lut[-1]) & 0xFFFFFF
    assert [colour(live, 10, column) == top for column in (21, 22, 24, 9, 7, 5)] == [True, True, False] * 2


@pytest.mark.parametrize("value", [True, False])
def test_image_without_a_rim(value):
    live = live_image(np.full((4, 6), value))
    live.fill(np.zeros((4, 6), np.float32), PressureScale(20.0))
    assert live.image.width() == 6


leaves = cache(leaf_map)


def test_patches_whose_borders_cross_are_those_that_overlap():
    document = MapDocument.of(arm().map)
    (_, forearm, hand) = document.map.boxes
    document = move(document, [2], (forearm[1, 0] - 0.5 * hand[:, 0].sum(), 0.5 * (forearm[:, 1] - hand[:, 1]).sum()))
    found = FlawFinder().of(document)
    assert len(found.overlaps) >= 2
    assert found.patches == (1, 2)


@pytest.mark.long
@pytest.mark.parametrize("kind", ["apart", "over another", "inside another", "flipped", "hidden", "new chart"])
def test_flaws_equal_those_of_the_whole_map(kind):
    document = MapDocument.of(leaves())
    finder = FlawFinder()
    finder.of(document)
    between = document.map.boxes[1].mean(axis=0) - document.map.boxes[0].mean(axis=0)
    edited = {
        "apart": lambda: document,
        "over another": lambda: rotate(move(document, [0], 0.7 * between), [0], 0.4),
        "inside another": lambda: scale(move(document, [0], between), [0], 0.3),
        "flipped": lambda: mirror(bent(document, share=3.0), [0]),
        "hidden": lambda: show_patches(rotate(move(document, [0], 0.7 * between), [0], 0.4), [0], visible=False),
        "new chart": lambda: _folded(move(document, [0], 0.5 * between)),
    }[kind]()
    found = finder.of(edited)
    expected = _flaws_of_the_whole_map(edited.map)
    if kind == "hidden":
        assert len(expected.overlaps)
        assert len(found.overlaps) == len(found.flips) == 0
        return
    if kind in ("over another", "inside another", "new chart"):
        assert len(expected.overlaps)
    if kind == "new chart":
        assert len(expected.flips)
    assert len(found.overlaps) == measure(edited.map).overlaps
    assert _sorted(found.overlaps) == pytest.approx(_sorted(expected.overlaps))
    assert _sorted(found.flips.reshape(-1, 6)) == pytest.approx(_sorted(expected.flips.reshape(-1, 6)))


def _flaws_of_the_whole_map(map_):
    """The same in one go, with nothing remembered and no box looked at."""
    pairs = list(zip(map_.charts, map_.uv, strict=True))
    flips = [uv[chart.faces[flipped(chart.plane, chart.faces)]] for chart, uv in pairs]
    borders = [[uv[loop] for loop in chart.connectivity.boundary_loops] for chart, uv in pairs]
    loops = [loop for border in borders for loop in border]
    i, j = crossing_sides(*loops)
    start = np.concatenate(loops)
    end = np.concatenate([np.roll(loop, -1, axis=0) for loop in loops])
    meetings = 0.25 * (start[i] + end[i] + start[j] + end[j])
    insides = [uv[chart.faces[0]].mean(axis=0) for chart, uv in pairs]
    return Flaws(np.concatenate(flips), np.concatenate([meetings, nested_patches(borders, insides)]))


def _folded(document):
    """Return a chart with a vertex that flips triangles and makes the border cross itself."""
    chart = document.charts[0]
    plane = chart.plane.copy()
    plane[chart.border[0]] *= -1.5
    charts = (replace(chart, plane=plane), *document.charts[1:])
    return replace(document, map=replace(document.map, charts=charts))


@pytest.mark.long
@pytest.mark.parametrize("over_a_background", [False, True])
def test_updated_image_equals_a_new_image(prepared, over_a_background):
    """Bit for bit, whether few taxels changed or all; in the pressures and in the colours."""
    atlas = ImageAtlas(prepared.map)
    scale = PressureScale(20.0)
    random = np.random.default_rng(1)
    count = len(prepared.skin)
    old = np.zeros(len(prepared.skin))
    kept, fresh = (LiveImage(atlas.shape, *atlas.halo) for _ in range(2))
    if over_a_background:
        for live in (kept, fresh):
            live.background = np.full(atlas.shape, 0xFF336699, np.uint32)
            live.touch_from = 1.0
    values = np.zeros(atlas.shape, np.float32)
    atlas.render(old, values)
    kept.fill(values, scale)
    written = []
    for changes in (5, 1, 0, 40, count, 3):
        pressures = old.copy()
        changed = np.sort(random.choice(count, changes, replace=False))
        pressures[changed] = 3e4 * random.random(changes)
        pressures[changed[1::3]] = 0.0
        pixels = atlas.render(pressures, values, changed=np.flatnonzero(pressures != old))
        kept.fill(values, scale, changed=pixels)
        expected = np.zeros(atlas.shape, np.float32)
        assert atlas.render(pressures, expected) is None
        fresh.fill(expected, scale)
        np.testing.assert_array_equal(values, expected)
        np.testing.assert_array_equal(kept.pixels, fresh.pixels)
        written.append(atlas.inside.size if pixels is None else len(pixels))
        old = pressures
    assert written[2] == 0 < written[1] < written[0] < written[3] < written[4]


def _sorted(rows):
    return rows[np.lexsort(np.round(rows, 9).T)]
