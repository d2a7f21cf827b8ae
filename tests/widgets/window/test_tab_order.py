"""Tab moves through all controls of the window and returns, so that no control traps the keyboard focus."""

from __future__ import annotations

from itertools import pairwise

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from tactile_widgets.panels.registry import PanelTab
from tests.widgets.support.window_driver import activate

_SAME_ROW = 12
"""Controls of one row may be so much higher or lower [px]."""


def walk(window, key):
    """The controls that have the keyboard one after the other, from the robot view until it has it again."""
    window.robot_view.setFocus(Qt.FocusReason.TabFocusReason)
    visited = [QApplication.focusWidget()]
    for _ in range(300):
        QTest.keyClick(visited[-1], key)
        found = QApplication.focusWidget()
        if found is visited[0]:
            return visited
        assert found not in visited, f"{found.objectName() or found} is never left"
        visited.append(found)
    raise AssertionError("it never comes back")


@pytest.mark.parametrize(
    ("tab", "included"),
    [
        (PanelTab.TOUCH, {"map-view", "colour-bar", "plot-force", "panel-tabs", "events-panel-help"}),
        pytest.param(PanelTab.MODEL, {"effect-skin-choice", "messages-panel-help"}, marks=pytest.mark.long),
    ],
)
def test_tab_visits_all_panels_in_order(window_again, tab, included):
    window_again.column.show_tab(tab)
    activate(window_again)
    visited = walk(window_again, Qt.Key.Key_Tab)
    column = window_again.column
    content = column.page_of(next(panel for panel in column if panel.isVisible())).widget()
    rows = [one.mapTo(content, QPoint()).y() for one in visited if content.isAncestorOf(one)]
    assert len(rows) > 8
    jumps = [(one, other) for one, other in pairwise(rows) if other < one - _SAME_ROW]
    assert not jumps, "up again"
    assert included <= {one.objectName() for one in visited}
    assert all(one.isVisible() for one in visited)


def test_backtab_visits_all_panels_in_reverse_order(window_again):
    activate(window_again)
    there = walk(window_again, Qt.Key.Key_Tab)
    back = walk(window_again, Qt.Key.Key_Backtab)
    assert {one.objectName() for one in back} == {one.objectName() for one in there}


def test_returned_panels_have_their_places_in_the_tab_order(window_again):
    window_again.column.show_tab(PanelTab.MAP)
    activate(window_again)
    before = walk(window_again, Qt.Key.Key_Tab)
    panels = [panel for panel in window_again.column if panel.isVisible()]
    assert len(panels) > 2
    for panel in panels:
        window_again.panel_docks.toggle(panel)
    QApplication.processEvents()
    for panel in (*panels[1:], panels[0]):
        window_again.panel_docks.toggle(panel)
    QApplication.processEvents()
    activate(window_again)
    assert walk(window_again, Qt.Key.Key_Tab) == before
