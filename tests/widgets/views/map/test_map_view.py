"""The map under a real hand: presses, strokes, pans, zooms and hovers on the real widget."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, QRectF, Qt
from PySide6.QtGui import QImage, QPainter, QWheelEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QLineEdit, QPushButton

from tactile_widgets.common.colours import DARK, LIGHT, PressureScale
from tactile_widgets.views.map.items.map_coordinates import MARGIN_PX
from tests.widgets.support.layered_map_view import layered_map_view
from tests.widgets.support.samples import touched
from tests.widgets.support.snapshots import pixels

LEFT = Qt.MouseButton.LeftButton
MIDDLE = Qt.MouseButton.MiddleButton
NONE = Qt.KeyboardModifier.NoModifier
BESIDE = QPoint(4, 4)


class Heard:
    """Remembers what a view emitted."""

    def __init__(self, view):
        self.acts = []
        self.hovers = []
        self.words = []
        self.painted = []
        view.interaction.poke_pressed.connect(self._on_pressed)
        view.interaction.poke_moved.connect(self._on_moved)
        view.interaction.poke_released.connect(self._on_released)
        view.interaction.hovered.connect(self.hovers.append)
        view.readout_changed.connect(self.words.append)
        view.painted.connect(self.painted.append)

    def _on_pressed(self, at):
        self.acts.append(("pressed", at))

    def _on_moved(self, at):
        self.acts.append(("moved", at))

    def _on_released(self):
        self.acts.append(("released", None))

    @property
    def kinds(self):
        return [kind for kind, _ in self.acts]


@pytest.fixture
def view(open_map_view, prepared):
    return open_map_view(700, 600, lambda view: view.show_prepared(prepared))


@pytest.fixture
def heard(view):
    return Heard(view)


def pixel_of_taxel(view, prepared, taxel):
    return view.pixel_of(prepared.skin.taxel_point(taxel)).toPoint()


def wheel(view, position, notches):
    place = QPointF(position)
    event = QWheelEvent(place, view.viewport().mapToGlobal(place), QPoint(), QPoint(0, 120 * notches),
                        Qt.MouseButton.NoButton, NONE, Qt.ScrollPhase.NoScrollPhase, False)  # fmt: skip
    QApplication.sendEvent(view.viewport(), event)


def test_a_press_is_the_body_point_under_the_pointer(view, heard, prepared):
    taxels = range(0, len(prepared.skin), max(1, len(prepared.skin) // 20))
    for taxel in taxels:
        pixel = pixel_of_taxel(view, prepared, taxel)
        heard.acts.clear()
        QTest.mouseClick(view.viewport(), LEFT, NONE, pixel)
        if heard.kinds != ["pressed", "released"]:  # a taxel on the very rim may round to a pixel beside the patch
            continue
        away = view.pixel_of(heard.acts[0][1]) - QPointF(pixel)
        assert np.hypot(away.x(), away.y()) <= 1.0
    assert heard.kinds == ["pressed", "released"]


def test_drag_strokes_and_off_the_patches_it_stays(view, heard, prepared):
    start = pixel_of_taxel(view, prepared, len(prepared.skin) // 2)
    QTest.mousePress(view.viewport(), LEFT, NONE, start)
    QTest.mouseMove(view.viewport(), start + QPoint(3, 0))
    QTest.mouseMove(view.viewport(), BESIDE)
    assert heard.kinds == ["pressed", "moved"]
    away = view.pixel_of(heard.acts[1][1]) - QPointF(start + QPoint(3, 0))
    assert np.hypot(away.x(), away.y()) <= 1.0
    QTest.mouseRelease(view.viewport(), LEFT, NONE, BESIDE)
    assert heard.kinds == ["pressed", "moved", "released"]


def test_escape_ends_a_poke(view, heard, prepared):
    pixel = pixel_of_taxel(view, prepared, 0)
    wheel(view, pixel, 6)
    QTest.mousePress(view.viewport(), LEFT, NONE, pixel)
    QTest.keyClick(view, Qt.Key.Key_Escape)
    QTest.mouseRelease(view.viewport(), LEFT, NONE, pixel)
    assert heard.kinds == ["pressed", "released"]


def test_losing_the_focus_ends_a_poke(view, heard, prepared, qtbot):
    other = QLineEdit(view)
    other.show()
    view.activateWindow()
    view.setFocus()
    qtbot.waitUntil(view.hasFocus)
    QTest.mousePress(view.viewport(), LEFT, NONE, pixel_of_taxel(view, prepared, len(prepared.skin) // 2))
    assert heard.kinds == ["pressed"]
    other.setFocus()
    assert heard.kinds == ["pressed", "released"]


@pytest.mark.parametrize("how", ["beside", "middle", "space"])
def test_panning_moves_the_map_and_pokes_nothing(view, heard, prepared, how):
    middle = view.viewport().rect().center()
    wheel(view, middle, 4)
    inside = pixel_of_taxel(view, prepared, len(prepared.skin) // 2)
    start = BESIDE if how == "beside" else inside
    if how == "beside":
        view.frame_all()
        wheel(view, BESIDE, 1)
    if how == "space":
        QTest.keyPress(view, Qt.Key.Key_Space)
    held = view.scene_point(QPointF(start))
    button = MIDDLE if how == "middle" else LEFT
    QTest.mousePress(view.viewport(), button, NONE, start)
    QTest.mouseMove(view.viewport(), start + QPoint(12, 9))
    QTest.mouseRelease(view.viewport(), button, NONE, start + QPoint(12, 9))
    assert heard.acts == []
    away = view.viewportTransform().map(held) - QPointF(start + QPoint(12, 9))
    assert np.hypot(away.x(), away.y()) <= 0.01


@pytest.mark.parametrize("notches", [1, 5, -2])
def test_the_wheel_keeps_the_point_under_the_pointer(view, notches):
    middle = view.viewport().rect().center()
    wheel(view, middle, 4)
    pointer = middle + QPoint(60, -40)
    before = view.scene_point(QPointF(pointer))
    zoom = view.camera.zoom
    wheel(view, pointer, notches)
    assert view.camera.zoom == pytest.approx(zoom * 1.2**notches)
    away = view.viewportTransform().map(before) - QPointF(pointer)
    assert np.hypot(away.x(), away.y()) <= 0.01


def test_f_and_a_double_click_beside_the_patches_frame_all(view, heard):
    for frame_all in (
        lambda: QTest.keyClick(view, Qt.Key.Key_F),
        lambda: QTest.mouseDClick(view.viewport(), LEFT, NONE, BESIDE),
    ):
        wheel(view, BESIDE, 2)
        assert view.camera.zoom > 1.4
        frame_all()
        assert view.camera.zoom == 1.0
    assert heard.acts == []


def test_a_double_click_on_a_patch_is_a_second_poke(view, heard, prepared):
    pixel = pixel_of_taxel(view, prepared, len(prepared.skin) // 2)
    QTest.mouseClick(view.viewport(), LEFT, NONE, pixel)
    QTest.mouseDClick(view.viewport(), LEFT, NONE, pixel)
    QTest.mouseRelease(view.viewport(), LEFT, NONE, pixel)
    assert heard.kinds == ["pressed", "released"] * 2
    assert view.camera.zoom == 1.0


def test_keys_zoom_and_pan(view):
    QTest.keyClick(view, Qt.Key.Key_Plus)
    assert view.camera.zoom == pytest.approx(1.2)
    centre = view.camera.centre
    QTest.keyClick(view, Qt.Key.Key_Right)
    assert view.camera.centre[0] > centre[0]


def test_a_resize_keeps_the_framing(view):
    middle = view.viewport().rect().center()
    wheel(view, middle + QPoint(30, 20), 3)
    centre = view.camera.centre
    zoom = view.camera.zoom
    view.resize(420, 500)
    assert (view.camera.centre, view.camera.zoom) == (centre, zoom)
    room = view.viewport().size()
    shown = view.viewportTransform().map(QPointF(*centre)) - QPointF(room.width() / 2, room.height() / 2)
    assert np.hypot(shown.x(), shown.y()) <= 0.01


def test_hover_tells_place_and_pressure(view, heard, prepared):
    taxel = len(prepared.skin) // 2
    view.show_frame(touched(prepared.map, [taxel]))
    QTest.mouseMove(view.viewport(), pixel_of_taxel(view, prepared, taxel))
    assert heard.hovers[-1].patch == prepared.skin.patch_of[taxel]
    assert f"taxel {taxel}" in heard.words[-1]
    assert "12.0\u202fkPa" in heard.words[-1]
    view.show_frame(touched(prepared.map, []))
    assert "0.00\u202fkPa" in heard.words[-1]
    QTest.mouseMove(view.viewport(), BESIDE)
    assert heard.hovers[-1] is None
    assert heard.words[-1] == ""


def test_a_hover_from_elsewhere_is_marked(view, prepared):
    before = view.grab().toImage()
    view.set_hover(prepared.skin.taxel_point(len(prepared.skin) // 2))
    assert view.grab().toImage() != before
    view.set_hover(None)
    assert view.grab().toImage() == before


def test_painted_follows_each_frame_once(view, heard, prepared):
    view.show_frame(touched(prepared.map, [3], tick=7))
    assert heard.painted == []
    view.viewport().repaint()
    view.viewport().repaint()
    assert heard.painted == [7]


def test_a_hidden_view_draws_nothing_and_catches_up(view, heard, prepared, qtbot):
    view.hide()
    view.show_frame(touched(prepared.map, [3], tick=7))
    view.show_frame(touched(prepared.map, [3], tick=8))
    with qtbot.waitSignal(view.painted):
        view.show()
    assert heard.painted == [8]


def test_the_touch_is_drawn_where_it_is(view, prepared):
    taxel = len(prepared.skin) // 2
    pixel = pixel_of_taxel(view, prepared, taxel)
    quiet = view.grab().toImage().pixelColor(pixel)
    view.show_frame(replace(touched(prepared.map, [taxel], kilopascals=19.0), regions=(), pokes=()))
    loud = view.grab().toImage().pixelColor(pixel)
    assert loud != quiet
    view.set_scale(PressureScale(200.0))
    assert view.grab().toImage().pixelColor(pixel) != loud


def test_each_state_says_what_helps(qtbot, prepared, view):
    empty = layered_map_view(LIGHT, PressureScale(20.0))
    qtbot.addWidget(empty)
    empty.show()
    button = empty.findChild(QPushButton)
    with qtbot.waitSignal(empty.card.open_requested):
        QTest.mouseClick(button, LEFT)
    view.card.show_loading("Flattening", 0.5)
    button = view.findChild(QPushButton)
    with qtbot.waitSignal(view.card.cancel_requested):
        QTest.mouseClick(button, LEFT)
    view.card.show_failed("The mesh has no surface.")
    with qtbot.waitSignal(view.card.open_requested):
        QTest.mouseClick(button, LEFT)
    view.card.show_last()
    assert not button.isVisible()


def test_nothing_is_poked_through_a_message(view, heard, prepared):
    pixel = pixel_of_taxel(view, prepared, len(prepared.skin) // 2)
    view.card.show_loading("Flattening", 0.5)
    QTest.mouseClick(view.viewport(), LEFT, NONE, pixel)
    assert heard.acts == []


def test_loading_ends_a_poke(view, heard, prepared):
    QTest.mousePress(view.viewport(), LEFT, NONE, pixel_of_taxel(view, prepared, len(prepared.skin) // 2))
    view.card.show_loading("Flattening", 0.5)
    assert heard.kinds == ["pressed", "released"]


def test_replaying_has_an_edge(view):
    corner = view.grab().toImage().pixelColor(1, 300)
    view.set_replaying(replaying=True)
    assert view.grab().toImage().pixelColor(1, 300) != corner
    view.set_replaying(replaying=False)
    live = view.grab().toImage()
    assert live.pixelColor(1, 300) == corner
    view.set_paused(paused=True)
    assert view.grab().toImage() != live


def test_themes_and_maps_change_while_it_is_open(view, prepared, qtbot):
    dark = view.grab().toImage()
    view.set_theme(LIGHT)
    assert view.grab().toImage() != dark
    view.set_theme(DARK)
    view.show_prepared(prepared)
    assert view.grab().toImage() == dark


def seen(view):
    return pixels(view.grab().toImage())


def test_nothing_is_drawn_over_a_touch(view, prepared):
    """At the zoom that frames the map: ring, number and pointer leave the pressed skin as it is."""
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


def test_a_patch_that_is_copied_looks_as_one_that_is_painted(view, prepared):
    """Pressed, let go and coloured otherwise, each three times: what is kept of a patch is never what it was before."""
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


def test_taxels_are_faint_points_at_the_zoom_that_frames_the_map(view, prepared):
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


def test_scale_is_below_the_map_while_all_of_it_is_shown(view):
    room = QRectF(view.viewport().rect())
    image = QImage(view.viewport().size(), QImage.Format.Format_RGB32)
    painter = QPainter(image)
    box = view._painter._paint_scale_bar(painter, 1000.0, room)
    painter.end()
    assert room.bottom() - MARGIN_PX <= box.top() < box.bottom() < room.bottom()
