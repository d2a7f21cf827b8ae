"""Keys of the real window: those of a focused control are the control's, else the window's; they can be changed."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QAbstractSpinBox, QApplication, QComboBox, QPushButton, QSlider, QVBoxLayout, QWidget

from tactile_widgets.actions.keymap import KeyMap
from tactile_widgets.common.mode import Mode
from tactile_widgets.common.settings import Settings
from tactile_widgets.panels.registry import PanelTab
from tactile_widgets.window.palette_commands import action_commands
from tests.widgets.support.mouse import left_click, left_drag, left_press, left_release, turn_wheel
from tests.widgets.support.window_driver import replay_run, run

KEY = Qt.Key
CTRL = Qt.KeyboardModifier.ControlModifier
SHIFT = Qt.KeyboardModifier.ShiftModifier
ALT = Qt.KeyboardModifier.AltModifier


@pytest.fixture
def window(window_again, qtbot):
    """The window with the focus, so that Qt delivers keys as for a user."""
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
    assert window.live.mode is Mode.PAUSED
    focus(window.map_view)
    QTest.keyClick(window.map_view, KEY.Key_Space)
    assert window.live.mode is Mode.RUNNING


@pytest.mark.long
@pytest.mark.parametrize("key", [KEY.Key_Space, KEY.Key_Return, KEY.Key_Enter])
def test_return_presses_a_focused_button(window, key):
    button = window.column["controller"]._buttons["hold_force"]
    assert isinstance(button, QPushButton)
    QTest.keyClick(focus(button), key)
    run(window, 0.02)
    assert window.live.runner.session.settings.controller == "hold_force"
    assert window.live.mode is Mode.RUNNING, "and nothing is paused"


def test_return_folds_a_panel(window):
    heading = focus(window.column["timing"]._heading)
    QTest.keyClick(heading, KEY.Key_Return)
    assert window.column["timing"].folded


def test_slider_keeps_home_and_backspace(window):
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


@pytest.mark.long
def test_timeline_keeps_home(window, tmp_path):
    replay_run(window, tmp_path / "a.mcap", 0.3)
    window.live.replay.seek(0.2)
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


@pytest.mark.long
def test_home_and_backspace_trigger_window_actions_outside_fields(window):
    run(window, 0.1)
    window.map_view.zoom(2.0, window.map_view.viewport().rect().center().toPointF())
    QTest.keyClick(window.robot_view, KEY.Key_Home)
    assert window.map_view.camera.zoom == 1.0
    QTest.keyClick(window.robot_view, KEY.Key_Backspace)
    assert window.live.runner.session.frame.tick == 0


def test_space_drag_moves_the_map_without_pausing(window):
    view = focus(window.map_view)
    start = QPoint(200, 200)
    end = QPoint(260, 230)
    before = view.camera.centre
    touched = []
    window.presenters.touch.touched.connect(lambda: touched.append(1))
    QTest.keyPress(view, KEY.Key_Space)
    assert view.viewport().cursor().shape() == Qt.CursorShape.OpenHandCursor
    left_drag(view.viewport(), start, end)
    QTest.keyRelease(view, KEY.Key_Space)
    assert view.camera.centre != before
    assert window.live.mode is Mode.RUNNING
    assert not touched


def has_keyboard(view):
    QApplication.processEvents()  # it is given back once the event is over
    return view.window().focusWidget() is view


def value_of(control):
    return control.currentIndex() if isinstance(control, QComboBox) else control.value()


def test_tool_keys_work_after_a_click_on_a_controller(window):
    """Wherever the keyboard is, but where text is typed."""
    window.column.show_tab(PanelTab.CONTROL)
    button = window.column["controller"]._buttons["hold_force"]
    left_click(button)
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


def test_letters_are_typed_in_text_fields(window):
    editor = window.colour_bar._editor
    window.colour_bar.edit()
    focus(editor)
    QTest.keyClick(editor, KEY.Key_B)
    assert window.action("poke").isChecked()
    QTest.keyClick(editor, KEY.Key_Return)
    assert has_keyboard(window.robot_view) or has_keyboard(window.map_view)


def test_wheel_changes_only_focused_controls(window):
    window.column.set_folded(())
    kinds = (QComboBox, QSlider, QAbstractSpinBox)
    controls = [found for kind in kinds for found in window.findChildren(kind)]
    assert len(controls) > 20
    changed = []
    for control in controls:
        before = value_of(control)
        for notches in (-3, 3, -1):
            turn_wheel(control, notches=notches)
        if value_of(control) != before or control.hasFocus():
            changed.append(control.objectName() or control.accessibleName() or type(control).__name__)
    assert not changed
    slider = focus(window.column["controller"].sliders.by_name["stiffness"]._slider)
    before = slider.value()
    turn_wheel(slider, notches=-3)
    assert slider.value() != before


@pytest.mark.qt_log_ignore("This plugin does not support (raise|grabbing the keyboard)")
def test_closed_drop_down_returns_the_focus(window, qtbot):
    box = window.session_bar.speed
    focus(window.map_view)
    left_press(box)
    left_release(box)
    assert box.view().isVisible()
    QTest.keyClick(box.view(), KEY.Key_T)
    assert box.view().isVisible(), "a letter is for the list while it is open"
    QTest.keyClick(box.view(), KEY.Key_Escape)
    assert not box.view().isVisible()
    qtbot.waitUntil(lambda: has_keyboard(window.map_view))


@pytest.mark.parametrize("leave", [lambda button: button.setEnabled(False), QPushButton.hide])
def test_button_that_its_press_disables_or_hides_returns_the_focus(window, leave):
    box = QWidget(window)
    column = QVBoxLayout(box)
    button, other = QPushButton("Send", box), QPushButton("Stop", box)
    for part in (button, other):
        column.addWidget(part)
    button.clicked.connect(lambda: leave(button))
    box.show()
    focus(window.map_view)
    QTest.keyClick(focus(button), KEY.Key_Return)
    QApplication.processEvents()
    assert QApplication.focusWidget() is window.map_view
    button.show()
    button.setEnabled(True)
    left_click(button)
    QApplication.processEvents()
    assert QApplication.focusWidget() is window.map_view
    box.deleteLater()


def test_return_and_escape_on_a_slider_return_the_focus(window):
    for key in (KEY.Key_Return, KEY.Key_Escape):
        slider = focus(window.column["controller"].sliders.by_name["stiffness"]._slider)
        QTest.keyClick(slider, key)
        assert has_keyboard(window.robot_view)


@pytest.fixture
def sheet(window):
    """The sheet of keys; all keys are restored afterwards."""
    window.action("keys").trigger()
    sheet = window._commands._sheet
    yield sheet
    if window._commands._sheet is sheet:
        sheet.close()
    window.context.actions.use_keys(KeyMap(window.context.actions.keymap.defaults))
    window.settings.keys = {}


def press(sheet, name, *key):
    """Choose an action in the sheet and press its new key."""
    sheet.choose(name)
    left_click(sheet.editor.change)
    QTest.keyClick(sheet.editor.field, *key)


def press_in_map(window, qtbot, *key):
    window.activateWindow()
    window.map_view.setFocus()
    qtbot.waitUntil(lambda: QApplication.focusWidget() is window.map_view)
    QTest.keyClick(window.map_view, *key)


def row(sheet, text):
    return [keys for keys, does in sheet.shown if does == text]


def test_new_key_works_at_once_and_is_shown_everywhere(window, sheet, qtbot):
    sheet.search.setFocus()
    QTest.keyClicks(sheet.search, "by lasso")
    QTest.keyClick(sheet.search, KEY.Key_Down)
    QTest.keyClick(sheet.search, KEY.Key_Return)
    QTest.keyClick(sheet.editor.field, KEY.Key_U)
    assert sheet.shown == [("U", "Select by lasso")]
    action = window.action("select_lasso")
    assert action.toolTip().endswith("(U)")
    assert action.shortcut().toString() == "U", "menus show it"
    (found,) = [c for c in action_commands(window.context.actions) if c.text.endswith("Select by lasso")]
    assert found.keys == "U"
    press_in_map(window, qtbot, KEY.Key_L)
    assert window.action("poke").isChecked(), "the key it had is free"
    press_in_map(window, qtbot, KEY.Key_U)
    assert action.isChecked()


def test_key_of_another_action_is_named_and_swapped(window, sheet):
    press(sheet, "select_box", KEY.Key_G)
    assert "G is the key of Target" in sheet.editor.message.text()
    assert window.context.actions.keys("select_box") == ("B",), "and nothing is done yet"
    left_click(sheet.editor.keep)
    assert window.context.actions.keys("select_box") == ("B",)
    press(sheet, "select_box", KEY.Key_G)
    left_click(sheet.editor.swap)
    assert (row(sheet, "Select by box"), row(sheet, "Target")) == (["G"], ["B"])
    sheet.choose("set_target")
    left_click(sheet.editor.reset)
    assert "G is the key of Select by box" in sheet.editor.message.text()
    left_click(sheet.editor.swap)
    assert (row(sheet, "Select by box"), row(sheet, "Target")) == (["B"], ["G"])
    assert not window.settings.keys


@pytest.mark.parametrize(("key", "words"), [((KEY.Key_Tab,), "between controls"), ((KEY.Key_F, ALT), "menu File")])
def test_reserved_key_names_its_use(sheet, key, words):
    press(sheet, "poke", *key)
    assert words in sheet.editor.message.text()
    QTest.keyClick(sheet.editor.field, KEY.Key_Escape)
    assert sheet.isVisible(), "Escape leaves the key unchanged and the sheet open"
    assert row(sheet, "Poke") == ["T"]


def test_punctuation_key_ignores_shift(window, sheet):
    press(sheet, "poke", "%", SHIFT)
    assert window.context.actions.keys("poke") == ("%",)
    press(sheet, "poke", KEY.Key_F7, CTRL | SHIFT)
    assert window.context.actions.keys("poke") == ("Ctrl+Shift+F7",)


def test_reassigned_space_no_longer_pauses(window, sheet, qtbot):
    press(sheet, "select_lasso", KEY.Key_Space)
    left_click(sheet.editor.swap)
    assert window.context.actions.keys("pause") == ("L",)
    press_in_map(window, qtbot, KEY.Key_Space)
    assert window.live.mode is Mode.RUNNING
    assert window.action("select_lasso").isChecked()
    press_in_map(window, qtbot, KEY.Key_L)
    run(window, 0.02)
    assert window.live.mode is Mode.PAUSED


def test_keys_are_stored_and_reset(window, sheet):
    sheet.choose("poke")
    assert not sheet.editor.reset.isEnabled()
    press(sheet, "poke", KEY.Key_U)
    assert sheet.editor.reset.isEnabled(), "only a changed key can be reset"
    sheet.choose("undo")
    left_click(sheet.editor.remove)
    path = window.settings._store.fileName()
    window.settings._store.sync()
    assert Settings(Path(path)).keys == {"poke": ("U",), "undo": ()}
    window.context.actions.use_keys(replace(window.context.actions.keymap, changes=Settings(Path(path)).keys))
    assert window.action("poke").toolTip().endswith("(U)")
    assert window.action("undo").shortcut().isEmpty()
    left_click(sheet.editor.reset_all)
    assert window.action("undo").shortcut().toString() == "Ctrl+Z"
    assert Settings(Path(path)).keys == {}
