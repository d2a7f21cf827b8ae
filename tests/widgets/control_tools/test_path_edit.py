"""A path in force under a real hand: corners, sides and line are dragged, taken out, moved by keys, and undone."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import Qt

from tests.widgets.control_tools.path_hand import PIXEL, path
from tests.widgets.map_hand import SHIFT
from widgets.control_tools.lead_tool import FINE_STEP, STEP


def test_a_corner_is_dragged_and_asked_for_when_let_go(drawn, lead, corners):
    drawn.press(corners[1])
    drawn.move(corners[1] + [0.0, 0.01])
    drawn.move(corners[1] + [0.0, 0.02])
    assert len(lead.asked) == 1
    drawn.release(corners[1] + [0.0, 0.02])
    assert len(lead.asked) == 2
    np.testing.assert_allclose(path(lead), corners + [[0, 0], [0, 0.02], [0, 0]], atol=2 * PIXEL)
    assert lead.undo_name == "move a corner"


def test_a_corner_is_pulled_from_the_middle_of_a_side(drawn, lead, corners):
    start = corners[:2].mean(axis=0)
    drawn.drag(start, start + [-0.02, 0.01])
    assert lead.undo_name == "add a corner"
    np.testing.assert_allclose(np.delete(path(lead), 1, axis=0), corners, atol=PIXEL)
    np.testing.assert_allclose(path(lead)[1], start + [-0.02, 0.01], atol=2 * PIXEL)


def test_the_line_is_dragged_with_all_of_the_path(drawn, lead, corners):
    start = corners[0] + 0.25 * (corners[1] - corners[0])
    drawn.drag(start, start + [0.01, 0.01])
    assert lead.undo_name == "move the path"
    np.testing.assert_allclose(path(lead), corners + 0.01, atol=2 * PIXEL)


def test_escape_in_a_drag_leaves_the_path(drawn, lead, corners):
    before = lead.settings
    drawn.press(corners[1])
    drawn.move(corners[1] + [0.0, 0.02])
    drawn.key(Qt.Key.Key_Escape)
    drawn.release(corners[1] + [0.0, 0.02])
    assert lead.settings is before


def test_a_chosen_corner_is_taken_out(drawn, lead, corners):
    drawn.click(corners[1])
    drawn.key(Qt.Key.Key_Delete)
    np.testing.assert_allclose(path(lead), corners[[0, 2]], atol=PIXEL)
    drawn.click(corners[0])
    drawn.key(Qt.Key.Key_Delete)
    assert len(path(lead)) == 2
    assert lead.heard == ["This path needs the corners it has"]


def test_without_a_corner_nothing_is_lost_by_delete(drawn, lead, corners):
    drawn.move(corners[0] + [0.0, 0.05])
    drawn.key(Qt.Key.Key_Delete)
    assert len(path(lead)) == 3
    assert lead.heard == ["Click a corner to choose it, then Delete takes it out"]


def test_arrows_move_the_chosen_corner_or_all_and_are_one_step(drawn, lead, corners):
    before = path(lead)
    drawn.click(corners[2])
    for _ in range(3):
        drawn.key(Qt.Key.Key_Right)
    drawn.key(Qt.Key.Key_Up, SHIFT)
    np.testing.assert_allclose(path(lead) - before, [[0, 0], [0, 0], [3 * STEP, FINE_STEP]], atol=1e-12)
    lead.undo()
    np.testing.assert_allclose(path(lead), before)
    drawn.click(corners[0] + 0.25 * (corners[1] - corners[0]))  # the line: no corner is chosen
    drawn.key(Qt.Key.Key_Down)
    np.testing.assert_allclose(path(lead) - before, np.tile([0, -STEP], (3, 1)), atol=1e-12)


def test_undo_goes_through_all_steps(drawn, lead, corners):
    first = lead.settings
    drawn.drag(corners[1], corners[1] + [0.0, 0.02])
    assert lead.settings != first
    lead.undo()
    assert lead.settings == first
    lead.undo()
    assert lead.settings.law == "impedance"
    assert lead.settings.path == ()
    lead.redo()
    assert lead.settings == first
