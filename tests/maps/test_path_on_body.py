"""Places of a path on the body, and the same path on another map of the skin."""

from __future__ import annotations

import numpy as np
import pytest

from tactile_maps.editing.arrange import mirror, move, rotate
from tactile_maps.maps.path_on_body import PathOnBody, share_off_skin
from tactile_maps.maps.paths import draw_path
from tests.widgets.support.map_view_driver import SHEET, middle, small_document


@pytest.fixture(scope="module")
def document():
    return small_document()


@pytest.fixture(scope="module")
def corners(document):
    centre = middle(document, SHEET)
    return tuple((float(x), float(y)) for x, y in centre + np.array([[-0.01, -0.012], [0.01, 0.012]]))


def carried(kind, path, before, after):
    return PathOnBody.of(kind, path, before.map).on_map(after.map)


def test_raster_remains_one_when_its_patch_is_moved(document, corners):
    kind, path = carried("raster", corners, document, move(document, [SHEET], (0.3, 0.1)))
    assert kind == "raster"
    np.testing.assert_allclose(path, np.array(corners) + (0.3, 0.1), atol=1e-12)


def test_path_is_unchanged_when_another_patch_is_moved(document, corners):
    after = move(document, [number for number in range(3) if number != SHEET], (0.1, 0.7))
    assert carried("spline", corners, document, after) == ("spline", corners)


@pytest.mark.parametrize("edit", [lambda d: rotate(d, [SHEET], 0.7), lambda d: mirror(d, [SHEET])])
def test_lines_of_a_raster_keep_their_places_as_a_polyline(document, corners, edit):
    after = edit(document)
    kind, path = carried("raster", corners, document, after)
    assert kind == "polyline"
    lines = draw_path("raster", corners).points
    assert len(path) == len(lines)
    for point, line in zip(path, lines, strict=True):
        there = after.map.skin.position(after.map.to_body(np.array(point)))
        np.testing.assert_allclose(there, document.map.skin.position(document.map.to_body(line)), atol=1e-9)


def test_point_off_the_skin_moves_with_the_nearest_patch(document):
    centre = middle(document, SHEET)
    high = document.map.boxes[SHEET, 1]
    outside = (float(centre[0]), float(high[1]) + 1e-3)
    assert document.map.to_body(np.array(outside)) is None
    path = ((float(centre[0]), float(centre[1])), outside)
    kind, found = carried("polyline", path, document, rotate(document, [SHEET], np.pi, about=centre))
    assert kind == "polyline"
    np.testing.assert_allclose(found, 2 * centre - np.array(path), atol=1e-12)


def test_share_off_skin(document):
    centre = middle(document, SHEET)
    high = document.map.boxes[SHEET, 1]
    inside = (float(centre[0]), float(centre[1]))
    border = (float(high[0]), float(centre[1]))
    assert share_off_skin("polyline", (inside, border), document.map) < 0.01
    far = (float(centre[0]), float(document.map.bounds[1, 1] + 10.0))
    assert share_off_skin("polyline", (inside, far), document.map) > 0.9
    assert share_off_skin("polyline", (inside, (1e9, 0.0)), document.map) == 1.0
    for point, share in ((inside, 0.0), (far, 1.0)):
        assert share_off_skin("polyline", (point,), document.map) == share
