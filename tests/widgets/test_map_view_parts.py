"""What a shown document stands on: the atlas is the map's image, flaws are the whole map's, a camera sees the same."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from app.editing.arrange import mirror, move, rotate, scale
from app.editing.document import MapDocument
from app.editing.patches import show
from app.editing.reflatten import apply, reflatten, set_lengths
from app.maps.overlay import flaws
from app.maps.tactile_image import TactileImage
from tests.widgets.arranging import bent
from tests.widgets.hand_made import leaf_map
from widgets.map_view.atlas import Atlas, ImageLook
from widgets.map_view.camera import Camera
from widgets.map_view.live_flaws import LiveFlaws

leaves = cache(leaf_map)


@pytest.mark.parametrize("kind", ["apart", "over another", "inside another", "flipped", "hidden", "new chart"])
def test_flaws_are_those_of_the_whole_map(kind):
    document, finder = MapDocument.of(leaves()), LiveFlaws()
    finder.of(document)
    between = document.map.boxes[1].mean(axis=0) - document.map.boxes[0].mean(axis=0)
    edited = {
        "apart": lambda: document,
        "over another": lambda: rotate(move(document, [0], 0.7 * between), [0], 0.4),
        "inside another": lambda: scale(move(document, [0], between), [0], 0.3),
        "flipped": lambda: mirror(bent(document, share=3.0), [0]),
        "hidden": lambda: show(rotate(move(document, [0], 0.7 * between), [0], 0.4), [0], visible=False),
        "new chart": lambda: _folded(move(document, [0], 0.5 * between)),
    }[kind]()
    found, expected = finder.of(edited), flaws(edited.map)
    if kind == "hidden":
        assert len(expected.overlaps)
        assert len(found.overlaps) == len(found.flips) == 0
        return
    if kind in ("over another", "inside another", "new chart"):
        assert len(expected.overlaps)
    if kind == "new chart":
        assert len(expected.flips)
    assert _sorted(found.overlaps) == pytest.approx(_sorted(expected.overlaps))
    assert _sorted(found.flips.reshape(-1, 6)) == pytest.approx(_sorted(expected.flips.reshape(-1, 6)))


def _folded(document):
    """A chart of which one point lies where it turns triangles over and crosses its border."""
    chart = document.charts[0]
    plane = chart.plane.copy()
    plane[chart.border[0]] *= -1.5
    charts = (replace(chart, plane=plane), *document.charts[1:])
    return replace(document, map=replace(document.map, charts=charts))


def _sorted(rows):
    return rows[np.lexsort(np.round(rows, 9).T)]


def test_the_image_is_that_of_the_whole_map(prepared):
    atlas, whole = Atlas(prepared.map), TactileImage(prepared.map, width=700)
    pressures = 1e4 * np.random.default_rng(3).random(len(prepared.skin))
    out = np.zeros(atlas.shape, np.float32)
    atlas.render(pressures, out)
    expected = whole.render(pressures)
    patch, face, bary = atlas.places
    held = np.flatnonzero(face >= 0)[::97]
    points = prepared.map.to_map_many(patch[held], face[held], bary[held])
    there = np.array([expected[whole.pixel(point)] for point in points])
    assert len(held) > 1000
    assert np.abs(out.ravel()[held] - there).mean() < 0.02 * out.max()
    for number, chart in enumerate(prepared.map.charts):
        middles = atlas.plane(number)[chart.faces].mean(axis=1)
        columns, rows = (middles / atlas.resolution).astype(int).T
        flat = (atlas.shape[0] - 1 - rows) * atlas.shape[1] + columns
        assert (patch[flat] == number).mean() > 0.99


def test_a_chart_that_outgrows_its_image_gets_coarser_pixels():
    document = MapDocument.of(leaves())
    first = Atlas(document.map)
    charts = (replace(document.charts[0], plane=9 * document.charts[0].plane), document.charts[1])
    second = Atlas(replace(document.map, charts=charts), known=first)
    assert second.resolution > 2 * first.resolution
    assert np.prod(second.shape) < 2 * np.prod(first.shape)


def test_a_camera_over_other_content_sees_the_same():
    camera, room = Camera((100.0, 50.0), (20.0, 30.0), 2.0), (640.0, 480.0)
    other = camera.over((400.0, 700.0), (-80.0, 5.0), room)
    assert other.to_scene((17.0, 400.0), room) == pytest.approx(camera.to_scene((17.0, 400.0), room))
    framed = Camera.framing(other.content, other.origin)
    assert framed.to_scene((320.0, 240.0), room) == pytest.approx((120.0, 355.0))
    far = other.over((10.0, 10.0), (900.0, 900.0), room)
    assert far.panned(1.0, 1.0, room).centre == pytest.approx(far.centre, abs=1.0)


def test_an_undone_chart_finds_its_tile_again(prepared):
    document = MapDocument.of(prepared.map)
    other = apply(document, reflatten(set_lengths(document, [1], 0.5)))
    first = Atlas(document.map)
    second = Atlas(other.map, known=first)
    again = Atlas(document.map, known=second)
    assert second.tiles[1] is not first.tiles[1]
    assert all(tile is old for tile, old in zip(again.tiles, first.tiles, strict=True))
    assert Atlas(document.map, known=again, look=ImageLook("nearest")).tiles[0] is not first.tiles[0]
