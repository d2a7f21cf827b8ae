"""Legends are placed where they hide the least of the map."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QRectF, QSizeF
from PySide6.QtGui import QTransform

from tactile_widgets.views.map.items.map_coordinates import SceneTransform
from tactile_widgets.views.map.items.map_shapes import ChartShape, MapShapes, PatchShape
from tactile_widgets.views.map.painting.legend_place import LegendPlace

EDGE = 12.0
ROOM = QRectF(0, 0, 400, 400)
SIZE = QSizeF(120, 60)


def shapes(*outlines):
    """Patches of these outlines (n, 2) [scene units]; y is down."""
    in_place = np.array([[1.0, 0], [0, 1], [0, 0]])
    patches = [PatchShape("", _chart(np.array(outline, float)), in_place) for outline in outlines]
    return MapShapes(SceneTransform.around(np.array([[0.0, 0], [1, 1]])), tuple(patches), 0.1)


def _chart(outline):
    none = np.zeros(0, int)
    return ChartShape(None, outline, (), (), np.zeros((0, 2)), none, none.astype(bool))


WHOLE = [(0, 0), (1, 0), (1, 1), (0, 1)]
WITHOUT = {
    "upper right": [(0, 0), (0.5, 0), (1, 0.5), (1, 1), (0, 1)],
    "lower right": [(0, 0), (1, 0), (1, 0.5), (0.5, 1), (0, 1)],
    "upper left": [(0.5, 0), (1, 0), (1, 1), (0, 1), (0, 0.5)],
    "lower left": [(0, 0), (1, 0), (1, 1), (0.5, 1), (0, 0.5)],
}


def corner(box):
    return f"{'upper' if box.center().y() < 200 else 'lower'} {'left' if box.center().x() < 200 else 'right'}"


@pytest.mark.parametrize("free", WITHOUT)
def test_legends_are_in_the_free_corner(free):
    (box,) = LegendPlace(EDGE).boxes([SIZE], shapes(WITHOUT[free]), ROOM)
    assert corner(box) == free
    assert ROOM.adjusted(EDGE, EDGE, -EDGE, -EDGE).contains(box)


def test_upper_right_corner_is_the_default():
    for whole in (shapes(WHOLE), shapes()):
        (box,) = LegendPlace(EDGE).boxes([SIZE], whole, ROOM)
        assert (box.right(), box.top()) == (388, 12)


@pytest.mark.parametrize("free", ["upper right", "upper left"])
def test_legends_are_stacked_and_aligned_to_the_edge(free):
    wide, narrow = LegendPlace(EDGE).boxes([SIZE, QSizeF(80, 20)], shapes(WITHOUT[free]), ROOM)
    assert narrow.top() > wide.bottom()
    assert (narrow.right() == wide.right()) == (free == "upper right")
    assert (narrow.left() == wide.left()) == (free == "upper left")


def test_layout_without_legends_is_empty():
    assert LegendPlace(EDGE).boxes([], shapes(WHOLE), ROOM) == []


@pytest.mark.parametrize("size", [SIZE, QSizeF(60, 240), QSizeF(240, 60)])
def test_map_is_framed_smaller_where_legends_would_hide_it(size):
    whole = shapes(WHOLE)
    viewport = (ROOM.width(), ROOM.height())
    place = LegendPlace(EDGE)
    alone = place.framing([], whole, ROOM)
    camera = place.framing([size], whole, ROOM)
    assert 0.4 * alone.scale(viewport) <= camera.scale(viewport) < alone.scale(viewport)
    (box,) = place.boxes([size], whole, ROOM)
    corners = (np.array(WHOLE) - camera.centre) * camera.scale(viewport) + np.array(viewport) / 2
    on_screen = QRectF(*corners.min(axis=0), *np.ptp(corners, axis=0))
    assert ROOM.contains(on_screen)
    assert not box.intersects(on_screen)


def test_map_is_not_framed_smaller_for_a_legend_in_a_free_corner_or_one_without_room():
    for whole, size in ((shapes(WITHOUT["upper right"]), SIZE), (shapes(WHOLE), QSizeF(370, 370))):
        place = LegendPlace(EDGE)
        assert place.framing([size], whole, ROOM) == place.framing([], whole, ROOM)
    assert LegendPlace(EDGE).framing([SIZE], shapes(), ROOM) is None


def test_legend_does_not_cover_the_thin_tip_of_a_patch():
    tip = [(0, 0.3), (0.78, 0.3), (0.8, 0.05), (0.82, 0.3), (1, 0.3), (1, 1), (0, 1)]
    (box,) = LegendPlace(EDGE).boxes([SIZE], shapes(tip), ROOM)
    assert corner(box) == "upper left"


def test_legend_is_at_a_side_where_no_corner_is_free():
    waist = [(0, 0), (1, 0), (1, 0.3), (0.6, 0.35), (0.6, 0.65), (1, 0.7), (1, 1), (0, 1)]
    place = LegendPlace(EDGE)
    (box,) = place.boxes([SIZE], shapes(waist), ROOM)
    assert box.right() == ROOM.right() - EDGE
    assert 120 < box.top() < box.bottom() < 280


def test_legend_is_placed_by_the_current_view_and_stays_while_it_hides_nothing():
    """An edit keeps the view, in which another corner may be free than with all of the map framed."""
    place = LegendPlace(EDGE)
    place.framing([], shapes(WHOLE), ROOM)
    left = QTransform.fromScale(200, 380)
    (box,) = place.boxes([SIZE], shapes(WHOLE), ROOM, left)
    assert corner(box) == "upper right"
    assert place.boxes([SIZE], shapes(WHOLE), ROOM, QTransform()) == [box], "another patch of the same shape"
    right = QTransform.fromTranslate(200, 0)
    right.scale(190, 380)
    (box,) = place.boxes([SIZE], shapes(WHOLE), ROOM, right)
    assert corner(box) == "upper left"
    (other,) = place.boxes([SIZE], shapes(WITHOUT["lower right"]), ROOM, right)
    assert other == box, "it hides nothing"


def test_legend_in_a_lower_corner_leaves_room_for_a_message():
    upper_half = shapes([(0, 0), (1, 0), (1, 0.5), (0, 0.5)])
    (box,) = LegendPlace(EDGE).boxes([SIZE], upper_half, ROOM, QTransform.fromScale(396, 396))
    assert corner(box) == "lower right"
    assert box.bottom() < ROOM.bottom() - 70
