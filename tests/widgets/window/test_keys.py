"""Keys of the real window: those of a focused control are the control's, else the window's."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QWheelEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QAbstractSpinBox, QApplication, QComboBox, QPushButton, QSlider

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


def has_keyboard(view):
    QApplication.processEvents()  # it is given back once the event is over
    return view.window().focusWidget() is view


def wheel(widget, notches=-3):
    """What the wheel over a control sends, and its parents after it where it does not want that."""
    middle = QPointF(widget.rect().center())
    turned = QPoint(0, 120 * notches)
    none = Qt.MouseButton.NoButton, Qt.KeyboardModifier.NoModifier, Qt.ScrollPhase.NoScrollPhase, False
    event = QWheelEvent(middle, QPointF(widget.mapToGlobal(middle.toPoint())), QPoint(), turned, *none)
    QApplication.sendEvent(widget, event)


def value_of(control):
    return control.currentIndex() if isinstance(control, QComboBox) else control.value()


def test_tool_keys_work_after_a_controller_was_clicked(window):
    """Wherever the keyboard is, but where text is typed."""
    button = window.column["controller"]._buttons["hold_force"]
    QTest.mouseClick(button, Qt.MouseButton.LeftButton)
    assert has_keyboard(window.robot_view), "the click gave the keyboard back"
    focus(button)
    for key, name in ((KEY.Key_G, "set_target"), (KEY.Key_D, "draw_path"), (KEY.Key_B, "select_box")):
        QTest.keyClick(QApplication.focusWidget(), key)
        assert window.action(name).isChecked(), name
    box = focus(window.session_bar.speed)
    speed = box.currentIndex()
    QTest.keyClick(box, KEY.Key_T)
    assert window.action("poke").isChecked()
    assert box.currentIndex() == speed


def test_letters_are_text_where_text_is_typed(window):
    editor = window.colour_bar._editor
    window.colour_bar.edit()
    focus(editor)
    QTest.keyClick(editor, KEY.Key_B)
    assert window.action("poke").isChecked()
    QTest.keyClick(editor, KEY.Key_Return)
    assert has_keyboard(window.robot_view) or has_keyboard(window.map_view)


def test_no_control_takes_a_passing_wheel_and_a_focused_one_does(window):
    window.column.set_folded(())
    kinds = (QComboBox, QSlider, QAbstractSpinBox)
    controls = [found for kind in kinds for found in window.findChildren(kind)]
    assert len(controls) > 20
    changed = []
    for control in controls:
        before = value_of(control)
        wheel(control)
        wheel(control, 3)
        wheel(control, -1)
        if value_of(control) != before or control.hasFocus():
            changed.append(control.objectName() or control.accessibleName() or type(control).__name__)
    assert not changed
    slider = focus(window.column["controller"].sliders.by_name["stiffness"]._slider)
    before = slider.value()
    wheel(slider)
    assert slider.value() != before


@pytest.mark.qt_log_ignore("This plugin does not support (raise|grabbing the keyboard)")
def test_a_drop_down_gives_the_keyboard_back_when_it_closes(window, qtbot):
    box = window.session_bar.speed
    focus(window.map_view)
    QTest.mousePress(box, Qt.MouseButton.LeftButton)
    QTest.mouseRelease(box, Qt.MouseButton.LeftButton)
    assert box.view().isVisible()
    QTest.keyClick(box.view(), KEY.Key_T)
    assert box.view().isVisible(), "a letter is for the list while it is open"
    QTest.keyClick(box.view(), KEY.Key_Escape)
    assert not box.view().isVisible()
    qtbot.waitUntil(lambda: has_keyboard(window.map_view))


def test_return_and_escape_on_a_slider_give_the_keyboard_back(window):
    for key in (KEY.Key_Return, KEY.Key_Escape):
        slider = focus(window.column["controller"].sliders.by_name["stiffness"]._slider)
        QTest.keyClick(slider, key)
        assert has_keyboard(window.robot_view)
