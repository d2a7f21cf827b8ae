"""The actions of the real window: all bound, shown by one state, and an action of one's own in one place."""

from __future__ import annotations

import pytest
from PySide6.QtWidgets import QMainWindow, QMenu, QToolButton, QWidget

from tactile_widgets.actions.mnemonics import without_mnemonic
from tactile_widgets.actions.registry import LINE, ActionRegistry, ActionSpec, Menu, MenuList, build_menus, specs_in
from tactile_widgets.actions.state import WindowState, running
from tactile_widgets.common.colours import DARK
from tactile_widgets.common.mode import Mode
from tactile_widgets.context.progress_indicator import ProgressIndicator
from tactile_widgets.window.toolbar import SessionToolbar
from tests.widgets.support.window_driver import run


@pytest.fixture
def window(window_again):
    """Nothing that a test does here outlives the scene."""
    return window_again


def test_every_action_does_something(window):
    registry = window.context.actions
    assert registry.bound == {spec.name for spec in registry.specs}


def test_the_menus_hold_each_action_once(window):
    def leaves(menu):
        for action in menu.actions():
            if action.menu() is not None:
                yield from leaves(action.menu())
            elif action.objectName().startswith("action-"):
                yield action.objectName().removeprefix("action-")

    names = [name for bar in window.menuBar().actions() for name in leaves(bar.menu())]
    assert names == [spec.name for spec in specs_in(window.context.actions.menus)]


def test_the_window_shows_the_mnemonics_and_keeps_them_when_a_text_changes(window):
    titles = [bar.text() for bar in window.menuBar().actions()]
    assert all(title.count("&") == 1 for title in titles)
    assert [without_mnemonic(title) for title in titles] == [menu.title for menu in window.context.actions.menus]
    pause = window.action("pause")
    assert (pause.text(), pause.iconText()) == ("&Pause", "Pause")
    pause.trigger()
    assert pause.text() == "&Play"
    assert not [spec.name for spec in window.context.actions.specs if "&" in window.action(spec.name).toolTip()]


def test_what_is_shown_follows_the_session(window):
    state = window.presenters.state
    assert state.state.mode is Mode.RUNNING
    assert not window.action("step").isEnabled()
    window.action("pause").trigger()
    assert state.state.mode is Mode.PAUSED
    assert window.action("step").isEnabled()
    assert window.action("pause").iconText() == "Play"
    window.action("pause").trigger()
    assert window.action("pause").iconText() == "Pause"


def test_a_frame_reads_no_state(window):
    read = []
    window.presenters.state._read = lambda: read.append(1) or window.presenters.state.state
    run(window, 0.4)
    assert not read


def test_a_button_that_changed_nothing_comes_up_again(window):
    """Its tool was in the hand already; a recording that cannot begin is not being made."""
    window.action("poke").trigger()
    window.action("poke").trigger()
    assert window.action("poke").isChecked()


@pytest.fixture
def plain(qtbot):
    """A window of one's own, with one menu."""
    window = QMainWindow()
    qtbot.addWidget(window)
    window.setCentralWidget(QWidget())
    return window


def test_an_action_needs_one_place(plain):
    """Menu, key, tip, button, enabling and icon come from its spec."""
    spec = ActionSpec(
        "measure", "Measure", ("Ctrl+U",), "Measure it", running, icon="measure", toolbar="session",
        text_for=lambda state: "Measure again" if state.playing else "Measure",
    )  # fmt: skip
    inner = Menu("Inner", (ActionSpec("deep", "Deep"),))
    menus = (Menu("Tools", (spec, LINE, inner, MenuList("things", "Things"))),)
    registry = ActionRegistry(plain, DARK, menus=menus)
    asked = []
    filled = []
    registry.bind("measure", lambda: asked.append(1))
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


def test_the_toolbar_is_made_of_the_actions(window):
    bar = window.session_bar
    assert isinstance(bar, SessionToolbar)
    assert isinstance(window.loading_bar, ProgressIndicator)
    for spec in window.context.actions.specs:
        if spec.toolbar and spec.toolbar != "select":
            assert isinstance(bar.widgetForAction(window.action(spec.name)), QToolButton)
