"""Keys of the real window: those of a focused control are the control's, else the window's."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QPushButton

from tests.widgets.support.window_driver import run

KEY = Qt.Key


@pytest.fixture
def window(window_again, qtbot):
    """With the focus, so that Qt routes keys as it does for a person."""
    window = window_again
    window.activateWindow()
    window.robot_view.setFocus()
    qtbot.waitUntil(lambda: QApplication.focusWidget() is window.robot_view)
    return window


def focus(widget):
    widget.setFocus()
    QApplication.processEvents()
    assert QApplication.focusWidget() is widget
    return widget


def test_space_pauses_from_the_views(window):
    QTest.keyClick(window.robot_view, KEY.Key_Space)
    assert window.live.mode == "paused"
    focus(window.map_view)
    QTest.keyClick(window.map_view, KEY.Key_Space)
    assert window.live.mode == "live"


@pytest.mark.parametrize("key", [KEY.Key_Space, KEY.Key_Return, KEY.Key_Enter])
def test_a_focused_button_is_pressed(window, key):
    button = window.column["controller"]._buttons["hold_force"]
    assert isinstance(button, QPushButton)
    QTest.keyClick(focus(button), key)
    run(window, 0.02)
    assert window.live.runner.session.settings.controller == "hold_force"
    assert window.live.mode == "live", "and nothing is paused"


def test_a_heading_folds_by_return(window):
    heading = focus(window.column["timing"]._heading)
    QTest.keyClick(heading, KEY.Key_Return)
    assert window.column["timing"].folded


def test_home_and_backspace_on_a_slider_are_the_sliders(window):
    run(window, 0.1)
    tick = window.live.runner.session.frame.tick
    slider = window.column["controller"].sliders.by_name["stiffness"]
    before = window.map_view.camera
    window.map_view.zoom(2.0, window.map_view.viewport().rect().center().toPointF())
    zoomed = window.map_view.camera
    assert zoomed != before
    QTest.keyClick(focus(slider._slider), KEY.Key_Home)
    assert slider._slider.value() == slider._slider.minimum()
    assert window.map_view.camera == zoomed, "the views are not framed"
    QTest.keyClick(slider._slider, KEY.Key_Backspace)
    assert window.live.runner.session.frame.tick >= tick, "and the scene is not reset"


def test_home_on_the_timeline_is_the_timelines(window, tmp_path):
    window.live.start_recording(tmp_path / "a.mcap")
    run(window, 0.3)
    window.live.stop_recording()
    window.live.open_recording(tmp_path / "a.mcap")
    window.live.show_time(0.2)
    window.timeline.set_time(0.2)
    window.map_view.zoom(2.0, window.map_view.viewport().rect().center().toPointF())
    zoomed = window.map_view.camera
    bar = focus(window.timeline._bar)
    QTest.keyClick(bar, KEY.Key_Home)
    assert window.timeline.playhead.time == 0.0
    assert window.map_view.camera == zoomed
    QTest.keyClick(bar, KEY.Key_Space)
    assert window.timeline.playhead.playing
    QTest.keyClick(bar, KEY.Key_Space)
    assert not window.timeline.playhead.playing


def test_home_and_backspace_are_the_windows_elsewhere(window):
    run(window, 0.1)
    window.map_view.zoom(2.0, window.map_view.viewport().rect().center().toPointF())
    QTest.keyClick(window.robot_view, KEY.Key_Home)
    assert window.map_view.camera.zoom == 1.0
    QTest.keyClick(window.robot_view, KEY.Key_Backspace)
    assert window.live.runner.session.frame.tick == 0


def test_space_and_a_drag_move_the_map_and_pause_nothing(window):
    view = focus(window.map_view)
    start, end = QPoint(200, 200), QPoint(260, 230)
    before, touched = view.camera.centre, []
    window.live.touched.connect(lambda: touched.append(1))
    QTest.keyPress(view, KEY.Key_Space)
    assert view.viewport().cursor().shape() == Qt.CursorShape.OpenHandCursor
    QTest.mousePress(view.viewport(), Qt.MouseButton.LeftButton, pos=start)
    QTest.mouseMove(view.viewport(), end)
    QTest.mouseRelease(view.viewport(), Qt.MouseButton.LeftButton, pos=end)
    QTest.keyRelease(view, KEY.Key_Space)
    assert view.camera.centre != before
    assert window.live.mode == "live"
    assert not touched
