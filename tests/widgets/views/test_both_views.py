"""Mouse, focus, states and themes on the real map and robot views, which behave the same."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QLineEdit, QPushButton

from tactile_maps.core.errors import TactileMapsError
from tactile_maps.session.session import Session
from tactile_widgets.common.colours import DARK, LIGHT, PressureScale
from tactile_widgets.views.overlays.painting import PAUSED, PRESENT, REPLAYING
from tactile_widgets.views.robot.robot_view import RobotView
from tests.widgets.support.layered_map_view import layered_map_view
from tests.widgets.support.robot_view_driver import LEFT, MIDDLE, NONE, skin_pixel
from tests.widgets.support.samples import touched
from tests.widgets.support.snapshots import pixels

OFF_SKIN = QPoint(4, 4)


class Side:
    """A view with the small arm, and the gestures that it reported."""

    def __init__(self, name, prepared):
        self.prepared = prepared
        self.is_map = name == "map"
        self.view = layered_map_view(DARK, PressureScale()) if self.is_map else RobotView(DARK, PressureScale())
        self.shown = self.view if self.is_map else self.view.display
        self.target = self.view.viewport() if self.is_map else self.view.display.canvas.widget
        self.acts = []
        self.hovers = []
        gestures = self.view.interaction
        gestures.poke_pressed.connect(lambda at: self.acts.append(at))
        gestures.poke_released.connect(lambda: self.acts.append("released"))
        gestures.hovered.connect(self.hovers.append)

    def skin(self):
        """A pixel on the skin."""
        middle = self.prepared.skin.taxel_point(len(self.prepared.skin) // 2)
        return self.view.pixel_of(middle).toPoint() if self.is_map else skin_pixel(self.view, self.prepared)

    def picture(self):
        if not self.is_map:
            self.view.display.draw_now()
        return pixels(self.view.grab().toImage())

    def press(self, pixel, button=LEFT):
        QTest.mousePress(self.target, button, NONE, pixel)

    def drag(self, start, by, button=LEFT):
        self.press(start, button)
        QTest.mouseMove(self.target, start + by)
        QTest.mouseRelease(self.target, button, NONE, start + by)

    def close(self):
        if not self.is_map:
            self.view.close_view()


@pytest.fixture(params=["map", "robot"])
def empty(request, qtbot, prepared):
    side = Side(request.param, prepared)
    qtbot.addWidget(side.view)
    side.view.resize(480, 400)
    side.view.show()
    qtbot.waitExposed(side.view)
    yield side
    side.close()


@pytest.fixture
def side(empty, prepared):
    empty.view.show_prepared(prepared)
    empty.picture()
    return empty


@pytest.fixture
def touch(prepared):
    """A frame of the arm at rest, touched in the middle of the skin."""
    felt = touched(prepared.map, [len(prepared.skin) // 2], kilopascals=19.0)
    return replace(Session(prepared, scripted=False).frame, pressures=felt.pressures)


def apart(one, other):
    return np.hypot(one.x() - other.x(), one.y() - other.y())


@pytest.mark.long
def test_press_pokes_the_location_under_the_pointer(side):
    hits = 0
    for x in range(10, side.view.width(), 30):
        for y in range(10, side.view.height(), 30):
            side.acts.clear()
            QTest.mouseClick(side.target, LEFT, NONE, QPoint(x, y))
            if side.acts:
                assert apart(side.view.pixel_of(side.acts[0]), QPoint(x, y)) < 0.5
                assert side.acts[1:] == ["released"]
                hits += 1
    assert hits >= 8


@pytest.mark.long
@pytest.mark.parametrize("end", ["focus", "escape", "loading"])
def test_poke_ends_with_the_focus_escape_or_a_placeholder(side, qtbot, end):
    other = QLineEdit(side.view)
    other.show()
    side.view.activateWindow()
    side.view.setFocus()
    qtbot.waitUntil(side.view.hasFocus)
    pixel = side.skin()
    side.press(pixel)
    assert len(side.acts) == 1
    if end == "focus":
        other.setFocus()
    elif end == "escape":
        QTest.keyClick(side.view, Qt.Key.Key_Escape)
    else:
        side.view.card.show_loading("Flattening", 0.5)
        QTest.mouseClick(side.target, LEFT, NONE, pixel)
    assert side.acts[1:] == ["released"]


@pytest.mark.long
@pytest.mark.parametrize("button", [LEFT, MIDDLE])
def test_drag_off_skin_or_with_the_middle_button_moves_the_view(side, button):
    skin = side.skin()
    at = side.view.point_at(QPointF(skin))
    side.drag(OFF_SKIN if button == LEFT else skin, QPoint(30, 20), button)
    moved = side.view.pixel_of(at) - QPointF(skin)
    assert np.hypot(moved.x(), moved.y()) > 3
    assert side.acts == []


@pytest.mark.long
def test_key_f_and_double_click_off_the_skin_fit_the_view(side):
    at = side.view.point_at(QPointF(side.skin()))
    fitted = side.view.pixel_of(at)
    for fit in (
        lambda: QTest.keyClick(side.view, Qt.Key.Key_F),
        lambda: QTest.mouseDClick(side.target, LEFT, NONE, OFF_SKIN),
    ):
        side.drag(side.skin(), QPoint(40, 30), MIDDLE)
        assert apart(side.view.pixel_of(at), fitted) > 3
        fit()
        assert apart(side.view.pixel_of(at), fitted) < 1e-6
    assert side.acts == []


@pytest.mark.long
def test_hover_reports_the_location_and_sets_the_pointer(side):
    idle = Qt.CursorShape.ArrowCursor if side.is_map else Qt.CursorShape.OpenHandCursor
    skin = side.skin()
    QTest.mouseMove(side.target, OFF_SKIN)
    assert side.target.cursor().shape() == idle
    QTest.mouseMove(side.target, skin)
    assert side.target.cursor().shape() == Qt.CursorShape.CrossCursor
    assert apart(side.view.pixel_of(side.hovers[-1]), skin) < 0.5
    QTest.mouseMove(side.target, OFF_SKIN)
    assert side.hovers[-1] is None
    side.press(OFF_SKIN)
    assert side.target.cursor().shape() == Qt.CursorShape.ClosedHandCursor
    QTest.mouseRelease(side.target, LEFT, NONE, OFF_SKIN)


@pytest.mark.long
def test_location_hovered_in_the_other_view_is_marked(side):
    QTest.mouseMove(side.target, OFF_SKIN)
    before = side.picture()
    side.view.set_hover(side.view.point_at(QPointF(side.skin())))
    assert (side.picture() != before).any()
    side.view.set_hover(None)
    np.testing.assert_array_equal(side.picture(), before)


@pytest.mark.long
def test_touch_is_drawn_at_its_place_and_follows_the_scale(side, touch, prepared):
    at = prepared.skin.taxel_point(len(prepared.skin) // 2)
    quiet = side.picture()
    side.shown.show_frame(touch)
    loud = side.picture()
    changed = np.abs(loud - quiet).max(axis=2) > 40
    assert 0 < changed.sum() < 0.2 * changed.size
    if side.view.point_at(side.view.pixel_of(at)) is not None:
        rows, columns = np.nonzero(changed)
        place = side.view.pixel_of(at)
        assert np.hypot(columns - place.x(), rows - place.y()).min() < 12
    side.shown.set_scale(PressureScale(200.0))
    assert (side.picture() != loud).any()


def test_placeholder_has_the_button_for_each_state(empty, prepared, qtbot):
    card = empty.view.card
    button = empty.view.findChild(QPushButton)

    def click(signal):
        with qtbot.waitSignal(signal):
            QTest.mouseClick(button, LEFT)

    click(card.open_requested)
    empty.view.show_prepared(prepared)
    assert not button.isVisible()
    card.show_loading("Flattening", 0.5)
    click(card.cancel_requested)
    card.show_failed("The mesh has no surface.")
    click(card.open_requested)
    card.show_last()
    assert not button.isVisible()


def test_empty_view_has_no_pixel_to_poke(empty, prepared):
    at = prepared.skin.taxel_point(0)
    empty.view.set_hover(at)
    QTest.mouseClick(empty.target, LEFT, NONE, QPoint(200, 200))
    empty.view.card.show_last()
    assert empty.acts == []
    with pytest.raises(TactileMapsError, match="is shown"):
        empty.view.pixel_of(at)


@pytest.mark.long
def test_replay_is_marked_by_a_frame_and_pause_by_a_label(side):
    QTest.mouseMove(side.target, OFF_SKIN)
    running = side.picture()
    side.shown.set_state(REPLAYING)
    assert (side.picture()[200, 1] != running[200, 1]).any()
    side.shown.set_state(PAUSED)
    assert (side.picture() != running).any()
    side.shown.set_state(PRESENT)
    np.testing.assert_array_equal(side.picture(), running)


@pytest.mark.long
def test_themes_and_scenes_change_while_the_view_is_open(side, prepared, touch):
    QTest.mouseMove(side.target, OFF_SKIN)
    side.view.show_prepared(prepared)
    dark = side.picture()
    side.shown.set_theme(LIGHT)
    assert side.picture()[OFF_SKIN.y(), OFF_SKIN.x()].min() > 200
    side.shown.set_theme(DARK)
    side.shown.show_frame(touch)
    assert (side.picture() != dark).any()
    side.view.show_prepared(prepared)
    QApplication.processEvents()
    np.testing.assert_array_equal(side.picture(), dark)
