"""Panels of a window without a robot disable what they cannot do, and state the reason."""

from __future__ import annotations

import pytest
from PySide6.QtWidgets import QApplication, QLabel, QPushButton

from tactile_widgets.panels.registry import PanelTab
from tactile_widgets.session.backends import INLINE
from tests.widgets.support.mouse import left_click
from tests.widgets.support.window_driver import close_window, open_window

REASON = "Open a robot or a scene first."


@pytest.fixture
def window(qtbot, tmp_path, own_files):
    window = open_window(tmp_path, INLINE)
    window.column.set_folded(())
    window.column.show_tab(PanelTab.CONTROL)
    QApplication.processEvents()
    yield window
    close_window(window)


def buttons(window, panel):
    return [button for button in window.column[panel].findChildren(QPushButton) if button.isVisible()]


def test_controls_of_the_robot_are_enabled_once_there_is_one(window, prepared):
    for name in ("controller", "behaviours", "posture"):
        panel = window.column[name]
        assert buttons(window, name)
        for button in buttons(window, name):
            assert not button.isEnabled(), button.text()
            assert button.toolTip().endswith(REASON)
        assert panel.findChild(QLabel, f"{panel.objectName()}-reason").isVisible()
        assert panel.help.isEnabled()
    left_click(window.column["controller"].findChild(QPushButton, "controller-qp"))
    assert window.column["controller"].settings.controller == "impedance"
    assert window.column["controller"].findChild(QLabel, "controller-difference").isEnabled(), "its link opens a scene"

    window.live.show_prepared(prepared)
    QApplication.processEvents()
    for button in buttons(window, "controller"):
        assert REASON not in button.toolTip()
    left_click(window.column["controller"].findChild(QPushButton, "controller-qp"))
    assert window.column["controller"].settings.controller == "qp"
    assert window.column["controller"].findChild(QPushButton, "compare-controllers").isEnabled()


def test_comparison_runs_only_with_a_stimulus(window, prepared):
    comparison = window.presenters.comparison
    comparison.open()
    run = comparison.board.findChild(QPushButton, "comparison-run")
    note = comparison.board.findChild(QLabel, "stimulus-note")
    assert not run.isEnabled()
    assert run.toolTip() == note.text() == "No stimulus to compare controllers on: open a robot, or choose a recording."
    window.live.show_prepared(prepared)
    comparison.open()
    assert run.isEnabled()
    assert run.toolTip() == "Run these controllers on this stimulus"
    comparison.close()
