"""The map view: zoom, keys, hover and painting."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, QRectF, Qt
from PySide6.QtTest import QTest

from tactile_widgets.common.colours import PressureScale
from tactile_widgets.views.map.items.map_coordinates import MARGIN_PX
from tests.widgets.support.heard import Heard
from tests.widgets.support.mouse import turn_wheel
from tests.widgets.support.samples import touched
from tests.widgets.support.snapshots import pixels

LEFT = Qt.MouseButton.LeftButton
MIDDLE = Qt.MouseButton.MiddleButton
NONE = Qt.KeyboardModifier.NoModifier
OFF_SKIN = QPoint(4, 4)


@pytest.fixture
def view(open_map_view, prepared):
    return open_map_view(700, 600, lambda view: view.show_prepared(prepared))


@pytest.fixture
def heard(view):
    return Heard(view, words=view.readout_changed, painted=view.painted)


def pixel_of_taxel(view, prepared, taxel):
    return view.pixel_of(prepared.skin.taxel_point(taxel)).toPoint()


@pytest.mark.parametrize("notches", [1, 5, -2])
def test_wheel_zooms_around_the_pointer(view, notches):
    middle = view.viewport().rect().center()
    turn_wheel(view.viewport(), middle, 4)
    pointer = middle + QPoint(60, -40)
    before = view.scene_point(QPointF(pointer))
    zoom = view.camera.zoom
    turn_wheel(view.viewport(), pointer, notches)
    assert view.camera.zoom == pytest.approx(zoom * 1.2**notches)
    away = view.viewportTransform().map(before) - QPointF(pointer)
    assert np.hypot(away.x(), away.y()) <= 0.01


def test_keys_zoom_and_pan(view):
    QTest.keyClick(view, Qt.Key.Key_Plus)
    assert view.camera.zoom == pytest.approx(1.2)
    centre = view.camera.centre
    QTest.keyClick(view, Qt.Key.Key_Right)
    assert view.camera.centre[0] > centre[0]


def test_resize_keeps_centre_and_zoom(view):
    middle = view.viewport().rect().center()
    turn_wheel(view.viewport(), middle + QPoint(30, 20), 3)
    centre = view.camera.centre
    zoom = view.camera.zoom
    view.resize(420, 500)
    assert (view.camera.centre, view.camera.zoom) == (centre, zoom)
    room = view.viewport().size()
    shown = view.viewportTransform().map(QPointF(*centre)) - QPointF(room.width() / 2, room.height() / 2)
    assert np.hypot(shown.x(), shown.y()) <= 0.01


def test_hover_describes_location_and_pressure(view, heard, prepared):
    taxel = len(prepared.skin) // 2
    view.show_frame(touched(prepared.map, [taxel]))
    QTest.mouseMove(view.viewport(), pixel_of_taxel(view, prepared, taxel))
    assert heard.hovers[-1].patch == prepared.skin.patch_of[taxel]
    assert f"taxel {taxel}" in heard.words[-1]
    assert "12.0\u202fkPa" in heard.words[-1]
    view.show_frame(touched(prepared.map, []))
    assert "0.00\u202fkPa" in heard.words[-1]
    QTest.mouseMove(view.viewport(), OFF_SKIN)
    assert heard.hovers[-1] is None
    assert heard.words[-1] == ""


def test_painted_is_emitted_once_per_frame(view, heard, prepared):
    view.show_frame(touched(prepared.map, [3], tick=7))
    assert heard.painted == []
    view.viewport().repaint()
    view.viewport().repaint()
    assert heard.painted == [7]


def test_hidden_view_draws_the_newest_frame_when_shown(view, heard, prepared, qtbot):
    view.hide()
    view.show_frame(touched(prepared.map, [3], tick=7))
    view.show_frame(touched(prepared.map, [3], tick=8))
    with qtbot.waitSignal(view.painted):
        view.show()
    assert heard.painted == [8]


def seen(view):
    return pixels(view.grab().toImage())


def test_no_mark_covers_a_touch(view, prepared):
    """While the whole map is shown, ring, number and pointer do not cover the pressed skin."""
    taxel = 40
    view.show_frame(touched(prepared.map, [taxel], radius=0.03))
    view.set_hover(prepared.skin.taxel_point(taxel))
    marked = seen(view)
    marks = view.marks
    view.marks = replace(marks, contacts=(), fingers=(), hover=None)
    bare = seen(view)
    view.marks = marks
    at = view.pixel_of(prepared.skin.taxel_point(taxel))
    rows, columns = np.indices(bare.shape[:2])
    away = np.hypot(columns - at.x(), rows - at.y())
    changed = np.abs(marked - bare).max(axis=2) > 8
    assert changed.any(), "there are marks"
    assert not changed[(away > 3.5) & (away < 10)].any(), "but for the dot at the centre of a large one"
    assert np.ptp(bare[away < 10], axis=0).max() > 60, "the pressure is seen there"


@pytest.mark.long
def test_cached_patch_equals_painted_patch(view, prepared):
    """Pressed, released and with another scale, each three times: no outdated pixels are copied."""
    pressed = replace(touched(prepared.map, [40], radius=0.03), regions=(), pokes=())
    quiet = replace(pressed, pressures=np.zeros_like(pressed.pressures))
    pictures = {}
    for name, frame, scale in [("quiet", quiet, 20.0), ("pressed", pressed, 20.0), ("pale", pressed, 60.0)] * 2:
        view.set_scale(PressureScale(scale))
        view.show_frame(frame)
        shown = [seen(view) for _ in range(3)]
        pictures.setdefault(name, shown[0])
        for picture in shown:
            np.testing.assert_array_equal(picture, pictures[name], err_msg=name)
    assert np.abs(pictures["quiet"] - pictures["pressed"]).max() > 60
    assert np.abs(pictures["pale"] - pictures["pressed"]).max() > 20


def test_taxels_are_faint_points_while_the_whole_map_is_shown(view, prepared):
    view.resize(420, 380)
    picture = view.picture
    assert picture.taxels.pitch * view.viewportTransform().m11() < 20, "too small for dots"
    image = seen(view)
    at = view.taxel_pixels().round().astype(int)
    at = at[(at > 2).all(axis=1)]
    darkest = [image[y - 1 : y + 2, x - 1 : x + 2].min() for x, y in at.tolist()]
    around = [np.median(image[y - 4 : y + 5, x - 4 : x + 5]) for x, y in at.tolist()]
    fainter = np.array(around) - np.array(darkest)
    assert (fainter > 10).mean() > 0.8
    assert np.median(fainter) < 90, "and no more than that"


def test_scale_bar_is_below_the_whole_map(view):
    room = QRectF(view.viewport().rect())
    box, *_ = view._painter._scale(1000.0, room)
    assert room.bottom() - MARGIN_PX <= box.top() < box.bottom() < room.bottom()
