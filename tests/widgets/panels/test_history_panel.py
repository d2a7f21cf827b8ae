"""The list of steps: what was done, where we are, and a click goes there."""

from __future__ import annotations

from functools import partial

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from tactile_maps.editing.arrange import move
from tactile_maps.editing.document import MapDocument
from tactile_maps.editing.history import MOST_STEPS
from tactile_widgets.panels.history_panel import ROW, HistoryPanel
from tactile_widgets.panels.panel_column import COLUMN_WIDTH
from tests.support.cost import cost_of
from tests.widgets.support.mouse import left_click


@pytest.fixture
def panel(qtbot, editor):
    made = HistoryPanel(editor)
    qtbot.addWidget(made)
    made.resize(COLUMN_WIDTH, 300)
    made.show()
    qtbot.waitExposed(made)
    return made


def _move(editor, steps):
    for step in range(steps):
        assert editor.do(f"Move {step + 1}", partial(move, numbers=[0], by=(0.001, 0.0)))


def _rows(panel, role=Qt.ItemDataRole.DisplayRole):
    return [panel.steps.index(row).data(role) for row in range(panel.steps.rowCount())]


def _states(panel):
    return [text.rsplit(", ", 1)[1] for text in _rows(panel, Qt.ItemDataRole.AccessibleTextRole)]


def test_steps_are_named_and_the_current_one_is_marked(panel, editor):
    assert not panel.list.isVisible(), "nothing was done yet"
    _move(editor, 3)
    assert _rows(panel) == ["Open", "Move 1", "Move 2", "Move 3"]
    assert _states(panel) == ["done", "done", "done", "now"]
    editor.undo()
    editor.undo()
    assert _states(panel) == ["done", "now", "undone", "undone"]
    assert panel.list.height() == 4 * ROW


def test_click_selects_the_step(panel, editor):
    _move(editor, 3)
    QApplication.processEvents()
    left_click(panel.list.viewport(), QPoint(60, ROW + 4))
    assert editor.history.position == 1
    assert editor.document.layout.placements[0].offset[0] == pytest.approx(
        0.001 + panel.steps._editor.history._steps[0].document.layout.placements[0].offset[0]
    )
    left_click(panel.list.viewport(), QPoint(60, 3 * ROW + 4))
    assert editor.history.position == 3


def test_enter_selects_the_step_chosen_by_keys(panel, editor):
    _move(editor, 2)
    panel.list.setFocus()
    QTest.keyClick(panel.list, Qt.Key.Key_Up)
    assert editor.history.position == 2, "looking is not going"
    QTest.keyClick(panel.list, Qt.Key.Key_Return)
    assert editor.history.position == 1


def test_new_step_replaces_undone_steps(panel, editor):
    _move(editor, 2)
    editor.undo()
    editor.do("Another way", partial(move, numbers=[1], by=(0.001, 0.0)))
    assert _rows(panel) == ["Open", "Move 1", "Another way"]


def test_list_keeps_the_current_step_visible(panel, editor):
    _move(editor, 40)
    QApplication.processEvents()
    assert panel.list.height() < 41 * ROW
    assert panel.list.viewport().rect().contains(panel.list.visualRect(panel.steps.index(40)))
    editor.go(5)
    assert panel.list.viewport().rect().contains(panel.list.visualRect(panel.steps.index(5)))


def test_unfolded_list_shows_the_current_step(panel, editor):
    panel.set_folded(True)
    _move(editor, 40)
    panel.set_folded(False)
    QApplication.processEvents()
    assert panel.list.viewport().rect().contains(panel.list.visualRect(panel.steps.index(40)))


def test_replay_does_not_change_the_step(panel, editor):
    _move(editor, 2)
    editor.set_enabled(enabled=False)
    left_click(panel.list.viewport(), QPoint(60, 4))
    assert editor.history.position == 2


def test_another_document_starts_a_new_list(panel, editor, prepared):
    _move(editor, 3)
    editor.open(MapDocument.of(prepared.map), name="Load")
    assert _rows(panel) == ["Load"]


@pytest.mark.parametrize("steps", [100, pytest.param(MOST_STEPS + 5, marks=pytest.mark.long)])
def test_update_cost_does_not_grow_with_the_number_of_steps(panel, editor, steps):
    def show():
        panel._update_state()
        panel.steps.items = ()  # as if all were another history
        panel._update_state()
        panel.repaint()

    functions = ("data", "sizeHint", "paint")
    _move(editor, 20)
    few = [cost_of(show, function=function).steps for function in functions]
    _move(editor, steps)
    assert panel.steps.rowCount() == len(editor.history.names) == min(20 + steps, MOST_STEPS) + 1
    for function, cost in zip(functions, few, strict=True):
        assert 0 < cost <= cost_of(show, function=function).steps < 2 * cost, function
