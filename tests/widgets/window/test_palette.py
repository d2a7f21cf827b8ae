"""The command palette and the sheet of keys in the real window, by real keys."""

from __future__ import annotations

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from tactile_widgets.actions.keys_sheet import KeysSheet
from tactile_widgets.common.mode import Mode
from tactile_widgets.dialogs.palette import Command, matching
from tests.widgets.support.window_driver import replay_run

KEY = Qt.Key
CTRL = Qt.KeyboardModifier.ControlModifier
SHIFT = Qt.KeyboardModifier.ShiftModifier


@pytest.fixture
def window(window_again, qtbot):
    window = window_again
    window.activateWindow()
    window.robot_view.setFocus()
    qtbot.waitUntil(lambda: QApplication.focusWidget() is window.robot_view)
    return window


@pytest.fixture
def palette(window):
    QTest.keyClick(window.robot_view, KEY.Key_P, CTRL | SHIFT)
    palette = window._commands.palette
    assert palette.isVisible()
    yield palette
    if window._commands.palette is not None:
        palette.close()


def texts(palette):
    return [command.text for command in palette.found]


@pytest.mark.long
def test_palette_lists_actions_scenes_robots_and_settings(window, palette):
    all_of_them = {command.text: command for command in palette._commands}
    for spec in window.context.actions.specs:
        words = window.action(spec.name).iconText().rstrip("…")
        (found,) = [
            c
            for t, c in all_of_them.items()
            if t.split(" > ")[-1] == words and c.tip == window.action(spec.name).toolTip()
        ]
        assert bool(found.keys) == bool(spec.keys)
        assert found.tip, spec.name
    assert "Setting > Controller > Natural frequency" in all_of_them
    assert sum(text.startswith("Open scene > ") for text in all_of_them) > 5
    assert sum(text.startswith("Open robot > ") for text in all_of_them) > 3


@pytest.mark.long
def test_palette_runs_a_command_found_by_letters(window, palette):
    QTest.keyClicks(palette.field, "pause")
    assert texts(palette)[0] == "Session > Pause"
    QTest.keyClick(palette.field, KEY.Key_Return)
    assert window._commands.palette is None
    assert window.live.mode is Mode.PAUSED
    window.action("pause").trigger()


def test_palette_focuses_a_setting(window, palette):
    QTest.keyClicks(palette.field, "natural freq")
    QTest.keyClick(palette.field, KEY.Key_Return)
    slider = window.column["controller"].sliders.by_name["stiffness"]
    assert window.focusWidget() in (slider._slider, slider._value)


@pytest.mark.long
def test_disabled_command_is_listed_without_effect(window, palette):
    QTest.keyClicks(palette.field, "session step")
    assert texts(palette)[0] == "Session > Step"
    palette.list.setCurrentRow(0)
    tick = window.live.runner.session.frame.tick
    QTest.keyClick(palette.field, KEY.Key_Return)
    assert palette.isVisible()
    assert window.live.runner.session.frame.tick == tick


def test_letters_match_in_order_words_and_beginnings_first():
    commands = [
        Command(text, lambda: None) for text in ("Edit > Undo", "View > Frame all", "Select > Find taxel", "Fold")
    ]
    assert matching("fa", commands)[0].text == "View > Frame all"
    assert [c.text for c in matching("find", commands)] == ["Select > Find taxel"]
    assert matching("zz", commands) == []
    assert matching(" ", commands) == commands


def test_first_enabled_match_is_selected(window, palette):
    palette.ask([Command("Undo", lambda: None, enabled=False), Command("Redo", lambda: None)])
    assert palette.list.currentRow() == 1


@pytest.mark.long
def test_palette_leaves_a_recording(window, tmp_path):
    replay_run(window, tmp_path / "short.mcap", 0.1)
    window.action("palette").trigger()
    palette = window._commands.palette
    QTest.keyClicks(palette.field, "back to live")
    assert texts(palette)[0] == "Session > Back to live"
    QTest.keyClick(palette.field, KEY.Key_Return)
    assert window.live.mode is Mode.RUNNING


def test_palette_reports_an_empty_search_result(palette):
    QTest.keyClicks(palette.field, "zzzz")
    assert [palette.list.item(row).text() for row in range(palette.list.count())] == ["Nothing found"]
    QTest.keyClick(palette.field, KEY.Key_Return)
    assert palette.isVisible()


def test_palette_shows_a_panel_of_another_tab(window, palette):
    QTest.keyClicks(palette.field, "panel quality")
    assert texts(palette)[0] == "Panel > Map quality"
    QTest.keyClick(palette.field, KEY.Key_Return)
    assert window.column["quality"].isVisible()


def test_palette_finds_a_panel_by_words_that_its_heading_lacks(window, palette):
    QTest.keyClicks(palette.field, "compare maps")
    assert texts(palette)[0] == "Panel > Compare"
    QTest.keyClick(palette.field, KEY.Key_Return)
    assert window.column["compare"].isVisible()


@pytest.mark.long
def test_list_of_keys_is_searched_and_opens_once(window, qtbot):
    for _ in range(2):
        window.activateWindow()
        qtbot.waitUntil(window.isActiveWindow)
        QTest.keyClick(window.robot_view, KEY.Key_F1)
        (sheet,) = window.findChildren(KeysSheet)
        assert sheet.isVisible()
        assert not sheet.isModal(), "it stays open next to the window"
        sheet.close()
        qtbot.waitUntil(lambda: not window.findChildren(KeysSheet))
    window.action("keys").trigger()
    (sheet,) = window.findChildren(KeysSheet)
    assert sheet.height() <= 700
    assert "turn the view" in sheet.shown[0][1], "gestures come first"
    assert len(sheet.shown) > 60
    QTest.keyClicks(sheet.search, "undo")
    assert sheet.shown == [("Ctrl+Z", "Undo")]
    QTest.keyClick(sheet.search, KEY.Key_Escape)
    qtbot.waitUntil(lambda: not window.findChildren(KeysSheet))
