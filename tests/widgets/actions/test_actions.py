"""Actions of the real window and of a plain window."""

from __future__ import annotations

import sys

import pytest
from PySide6.QtWidgets import QMainWindow, QMenu, QToolButton, QWidget

from tactile_widgets.actions.mnemonics import without_mnemonic
from tactile_widgets.actions.registry import LINE, ActionRegistry, ActionSpec, Menu, MenuList, build_menus, specs_in
from tactile_widgets.actions.state import WindowState, running
from tactile_widgets.actions.table import menu_bar
from tactile_widgets.common.colours import DARK
from tactile_widgets.common.mode import Mode
from tactile_widgets.context.progress_indicator import ProgressIndicator
from tactile_widgets.window.toolbar import SessionToolbar
from tests.widgets.support.window_driver import run


@pytest.fixture
def window(window_again):
    """Window in its initial state."""
    return window_again


@pytest.mark.long
def test_menus_contain_each_action_once(window):
    def leaves(menu):
        for action in menu.actions():
            if action.menu() is not None:
                yield from leaves(action.menu())
            elif action.objectName().startswith("action-"):
                yield action.objectName().removeprefix("action-")

    names = [name for bar in window.menuBar().actions() for name in leaves(bar.menu())]
    assert names == [spec.name for spec in specs_in(window.context.actions.menus)]


@pytest.mark.long
def test_mnemonics_are_shown_and_kept_when_a_text_changes(window):
    titles = [bar.text() for bar in window.menuBar().actions()]
    assert all(title.count("&") == 1 for title in titles)
    assert [without_mnemonic(title) for title in titles] == [menu.title for menu in window.context.actions.menus]
    pause = window.action("pause")
    assert (pause.text(), pause.iconText()) == ("&Pause", "Pause")
    pause.trigger()
    assert pause.text() == "&Play"
    assert not [spec.name for spec in window.context.actions.specs if "&" in window.action(spec.name).toolTip()]


@pytest.mark.long
def test_tick_does_not_read_the_state(window, monkeypatch):
    read = []
    tracker = window.presenters.state
    monkeypatch.setattr(tracker, "_read", lambda: read.append(1) or tracker.state)
    run(window, 0.4)
    assert not read


def test_action_of_a_missing_package_is_disabled_with_its_install_command(qtbot, monkeypatch):
    monkeypatch.setitem(sys.modules, "av", None)
    plain = QMainWindow()
    qtbot.addWidget(plain)
    actions = ActionRegistry(plain, DARK, menus=menu_bar())
    actions.show(WindowState(mode=Mode.RUNNING))
    enabled = {name: actions[name].isEnabled() for name in ("film", "film_file", "save_figure")}
    assert enabled == {"film": False, "film_file": False, "save_figure": True}
    assert f"{sys.executable} -m pip install" in actions["film"].toolTip()
    assert actions["film"].statusTip() == actions["film"].toolTip()


def test_current_tool_stays_checked_when_clicked_again(window):
    window.action("poke").trigger()
    window.action("poke").trigger()
    assert window.action("poke").isChecked()


@pytest.fixture
def plain(qtbot):
    """Empty main window."""
    window = QMainWindow()
    qtbot.addWidget(window)
    window.setCentralWidget(QWidget())
    return window


def test_action_is_defined_in_one_place(plain):
    """Menu, key, tip, button, enabling and icon come from its spec."""
    spec = ActionSpec(
        "measure",
        "Measure",
        "Ctrl+U",
        "Measure it",
        running,
        icon="measure",
        toolbar="session",
        text_for=lambda state: "Measure again" if state.playing else "Measure",
    )
    inner = Menu("Inner", (ActionSpec("deep", "Deep"),))
    menus = (Menu("Tools", (spec, LINE, inner, MenuList("things", "Things"))),)
    registry = ActionRegistry(plain, DARK, menus=menus)
    asked = []
    filled = []
    registry.bind(measure=lambda: asked.append(1))
    build_menus(plain.menuBar(), registry, {"things": filled.append})
    action = registry["measure"]
    assert action.toolTip() == "Measure it (Ctrl+U)"
    assert not action.isEnabled()
    registry.show(WindowState(mode=Mode.RUNNING, playing=True))
    assert action.isEnabled()
    assert action.iconText() == "Measure again"
    assert not action.icon().isNull()
    action.trigger()
    assert asked == [1]
    plain.findChild(QMenu, "things").aboutToShow.emit()
    assert len(filled) == 1
    assert [spec.name for spec in registry.in_toolbar("session")] == ["measure"]


@pytest.mark.long
def test_toolbar_has_a_button_for_each_action(window):
    bar = window.session_bar
    assert isinstance(bar, SessionToolbar)
    assert isinstance(window.loading_bar, ProgressIndicator)
    for spec in window.context.actions.specs:
        if spec.toolbar and spec.toolbar != "select":
            assert isinstance(bar.widgetForAction(window.action(spec.name)), QToolButton)
