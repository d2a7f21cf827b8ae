"""The tour in the real window, gone through with mouse and keys, and left by Escape."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QColor
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QPushButton

from tactile_widgets.common.colours import mixed
from tactile_widgets.common.mode import Mode
from tests.widgets.support.mouse import left_click, left_press, left_release
from tests.widgets.support.window_driver import press_map, run, visible_skin

LEFT = Qt.MouseButton.LeftButton
RIGHT = Qt.MouseButton.RightButton
CTRL = Qt.KeyboardModifier.ControlModifier


@pytest.fixture
def window(window_again):
    yield window_again
    window_again._commands.tour.leave()
    window_again.action("frame").trigger()


@pytest.fixture
def tour(window):
    window.action("tour").trigger()
    return window._commands.tour


def drag(target, start, by, button):
    QTest.mousePress(target, button, pos=start)
    for share in (0.3, 0.7, 1.0):
        QTest.mouseMove(target, start + by * share)
    QTest.mouseRelease(target, button, pos=start + by)


def go_on(tour, number):
    """The step that is shown was done; the next one."""
    assert tour.card.title.text().startswith("✓"), tour.card.title.text()
    assert tour.step == number - 1
    left_click(tour.card.skip)
    assert tour.step == number


def test_tour_steps_are_completed_by_the_user(window, tour):
    view = window.robot_view
    body = window.robot_view.display.canvas.widget
    before = window.robot_view.display.actors.viewpoint.eye.tolist()
    drag(body, QPoint(40, 40), QPoint(60, 20), RIGHT)
    view.display.draw_now()
    assert window.robot_view.display.actors.viewpoint.eye.tolist() != before
    go_on(tour, 1)
    _, pixel = visible_skin(window)
    left_press(body, pixel)
    run(window, 0.02)
    left_release(body, pixel)
    go_on(tour, 2)
    pixel = press_map(window, 5)
    left_release(window.map_view.viewport(), pixel)
    go_on(tour, 3)
    assert window.action("arrange").isChecked()
    steps = len(window.editor.history.names)
    drag(window.map_view.viewport(), pixel, QPoint(30, 20), LEFT)
    assert len(window.editor.history.names) == steps + 1
    assert "undo" in tour.card.text.text()
    QTest.keyClick(window.map_view, Qt.Key.Key_Z, CTRL)
    go_on(tour, 4)
    left_click(window.column["controller"].findChild(QPushButton, "controller-hold_force"))
    run(window, 0.02)
    assert "press the skin" in tour.card.text.text()
    pixel = press_map(window, 5)
    left_release(window.map_view.viewport(), pixel)
    go_on(tour, 5)
    left_click(tour.card.leave)
    assert tour.step is None


def test_tour_blocks_nothing_and_escape_ends_it(window, tour):
    window.map_view.setFocus()
    QTest.keyClick(window.map_view, Qt.Key.Key_Space)
    assert window.live.mode is Mode.PAUSED
    left_click(tour.card.skip)
    assert tour.step == 1
    assert tour.card.grab().toImage().pixelColor(12, 12) == QColor(mixed(window.theme.panel, window.theme.accent, 0.10))
    QTest.keyClick(window.map_view, Qt.Key.Key_Escape)
    assert tour.step is None
    assert tour.card.isHidden()
    assert tour._frame.isHidden()


def test_first_hints_offer_the_tour_once(window):
    window.settings.hints_read = False
    window.notifier.show_hints(shown=True)
    left_click(window.hint_bar.findChild(object, "hint-tour"))
    assert window._commands.tour.step == 0
    assert window.hint_bar.isHidden()
    assert window.settings.hints_read
