"""No row of the column moves because a controller is chosen, something is touched, or a text changes."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QPoint
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QLabel, QPushButton, QScrollArea, QWidget

from tactile_maps.control.controller_registry import CONTROLLERS
from tactile_widgets.common.controller_settings import SETTING_CHOICES
from tactile_widgets.common.panel import Panel
from tactile_widgets.panels.control.controller_panel import ControllerPanel
from tactile_widgets.panels.registry import PanelTab
from tests.widgets.support.mouse import left_release
from tests.widgets.support.window_driver import press_map, run


@pytest.fixture
def window(window_again):
    """The module's window."""
    return window_again


def rows(window):
    """Return the top positions of the panels and buttons of the column."""
    for _ in range(3):  # layouts settle in their own time
        QApplication.processEvents()
    content = window.column
    found = [*window.column.findChildren(Panel), *window.column.findChildren(QPushButton)]
    return {
        part.objectName(): part.mapTo(content, QPoint(0, 0)).y() for part in found if part.isVisible() and named(part)
    }


def named(part: QWidget) -> bool:
    return bool(part.objectName())


@pytest.mark.long
@pytest.mark.parametrize("task", ["keep_force", "follow_path"])
def test_no_row_moves_when_a_controller_is_chosen(window, task):
    panel = window.column.get(ControllerPanel)
    window.column.reveal(panel)
    panel.choose_controller("hybrid")
    panel.choose_task(task)
    before = rows(window)
    assert task in SETTING_CHOICES["task"][1]
    for controller in CONTROLLERS:
        window.findChild(QPushButton, f"controller-{controller}").click()
        run(window, 0.05)
        assert rows(window) == before, controller


@pytest.mark.long
def test_no_row_moves_when_the_skin_is_touched_and_released(window):
    before = rows(window)
    pixel = press_map(window, 70)
    run(window, 0.4)
    assert window.live.runner.session.frame.regions
    assert rows(window) == before
    left_release(window.map_view.viewport(), pixel)
    run(window, 0.3)
    assert rows(window) == before


@pytest.mark.parametrize("tab", [tab for tab in PanelTab if tab is not PanelTab.LIVE])
def test_no_row_moves_under_the_pointer(window, tab):
    window.column.show_tab(tab)
    before = rows(window)
    for button in window.column.findChildren(QPushButton):
        if button.isVisible():
            QTest.mouseMove(button)
    assert rows(window) == before


@pytest.mark.parametrize("tab", [tab for tab in PanelTab if tab is not PanelTab.LIVE])
def test_long_text_widens_no_tab(window, tab):
    column = window.column
    column.show_tab(tab)
    labels = [label for label in column.findChildren(QLabel) if label.isVisible()]
    before = [label.text() for label in labels]
    for label in labels:
        label.setText("a_very_long_name_without_spaces_" * 10)
    QApplication.sendPostedEvents()
    page = next(page for page in column.findChildren(QScrollArea) if page.isVisible())
    widths = page.widget().width(), page.viewport().width()
    for label, text in zip(labels, before, strict=True):
        label.setText(text)
    assert widths[0] == widths[1]
