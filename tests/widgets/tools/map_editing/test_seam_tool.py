"""Seam tool with real mouse events: drawing by drags and clicks, rejection, erasing, proposals, and the body view."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QEvent, Qt
from PySide6.QtGui import QMouseEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from tactile_maps.editing.reflatten import set_method
from tactile_maps.editing.seams import paint_interest
from tactile_widgets.tools.map_editing.seam_tool import SeamTool
from tactile_widgets.tools.registry import SEAMS
from tactile_widgets.views.overlays.body_overlays import MarkRole
from tests.widgets.support.executors import HeldJobs
from tests.widgets.support.map_view_driver import (
    ALT,
    CAP,
    LEFT,
    NONE,
    SHEET,
    TUBE,
    MapViewDriver,
    corner,
    middle,
    sheet_vertex,
)


@pytest.fixture
def tool(editor):
    return SeamTool(editor)


@pytest.fixture
def hand(qtbot, editor, tool):
    return MapViewDriver(qtbot, editor, tool, kind=SEAMS)


held = pytest.mark.parametrize("worker", [HeldJobs], indirect=True)


def seams(document, number=SHEET):
    """Return the seams as pairs of vertices."""
    return {tuple(edge) for edge in np.sort(document.charts[number].seams, axis=1).tolist()}


def column(rows, at=4):
    """The edges up a column of the sheet."""
    return {(sheet_vertex(at, k), sheet_vertex(at, k + 1)) for k in range(rows)}


def roles(tool):
    """Return the roles of all lines on the body except those of existing seams."""
    return [line.role for line in tool.body_marks().lines if line.role is not MarkRole.SEAM]


def inside(document, at, row):
    """A place of the sheet near a vertex, surely within the patch."""
    here = corner(document, sheet_vertex(at, row))
    return here + 0.1 * (middle(document, SHEET) - here)


@pytest.mark.long
def test_drag_cuts_from_vertex_to_vertex(hand, editor, document):
    hand.drag(inside(document, 4, 0), inside(document, 4, 4))
    assert seams(editor.document) == column(4)
    assert editor.history.names == ("Open", "Draw a seam")


def test_pointer_off_the_patch_snaps_to_the_border(hand, editor, tool, document):
    edge = corner(document, sheet_vertex(4, 0))
    out = (edge - middle(document, SHEET)) / np.linalg.norm(edge - middle(document, SHEET))
    outside = edge + 6 * hand.view._pixel_size(hand.view.picture.shapes.frame) * out
    assert document.map.to_body(outside) is None
    hand.move(outside)
    assert tool._tip == (SHEET, sheet_vertex(4, 0))
    hand.move(edge + 4 * (outside - edge))
    assert tool._tip is None or tool._tip[0] != SHEET, "another patch may be there"


@pytest.mark.long
def test_clicks_draw_through_several_vertices_and_enter_cuts(hand, editor, document):
    for at, row in ((0, 3), (4, 3), (4, 5)):
        hand.click(inside(document, at, row))
    assert editor.history.names == ("Open",)
    hand.key(Qt.Key.Key_Return)
    row = {(sheet_vertex(k, 3), sheet_vertex(k + 1, 3)) for k in range(4)}
    up = {(sheet_vertex(4, k), sheet_vertex(4, k + 1)) for k in (3, 4)}
    assert seams(editor.document) == row | up


def test_double_click_finishes(hand, editor, document):
    hand.click(inside(document, 4, 0))
    last = inside(document, 4, 4)
    hand.click(last)
    QTest.mouseDClick(hand.view.viewport(), LEFT, NONE, hand.pixel(last))
    assert seams(editor.document) == column(4)


def test_backspace_removes_a_vertex_and_escape_discards(hand, editor, tool, document):
    hand.click(inside(document, 4, 1))
    hand.click(inside(document, 4, 4))
    hand.key(Qt.Key.Key_Backspace)
    assert tool._through == [sheet_vertex(4, 1)]
    hand.key(Qt.Key.Key_Return)
    assert editor.heard[-1][0] == "notified"
    hand.key(Qt.Key.Key_Escape)
    assert tool._through == []
    assert editor.document is document


def test_path_to_the_pointer_is_shown_on_map_and_body(hand, tool, document):
    hand.click(inside(document, 4, 1))
    before = hand.picture()
    hand.move(inside(document, 4, 4))
    (line,) = [line for line in tool.body_marks().lines if line.role is MarkRole.HELD]
    assert line.vertices.tolist() == [sheet_vertex(4, k) for k in range(1, 5)]
    assert hand.picture() != before
    marks = tool.body_marks()
    hand.move(inside(document, 4, 4) + 1e-6)
    assert tool.body_marks() is marks


@pytest.mark.long
def test_seam_that_splits_the_patch_is_rejected_and_can_be_corrected(hand, editor, tool, document):
    hand.click(inside(document, 4, 0))
    hand.click(inside(document, 4, 6))
    hand.key(Qt.Key.Key_Return)
    assert editor.heard[-1][0] == "failed"
    assert "in two" in editor.heard[-1][1]
    assert editor.document is document
    assert len(tool._through) == 2
    hand.key(Qt.Key.Key_Backspace)
    hand.click(inside(document, 4, 4))
    hand.key(Qt.Key.Key_Return)
    assert seams(editor.document) == column(4)


def test_rejected_drag_is_discarded(hand, editor, tool, document):
    hand.drag(inside(document, 4, 0), inside(document, 4, 6))
    assert editor.heard[-1][0] == "failed"
    assert tool._through == []
    assert editor.document is document


@pytest.mark.long
def test_seam_avoids_areas_of_interest_or_is_rejected(hand, editor, document):
    wall = [sheet_vertex(at, row) for at in (0, 1, 2, 3, 4, 5, 7, 8) for row in (3, 4)]
    editor.ask(lambda now: paint_interest(now, SHEET, wall))
    hand.drag(inside(editor.document, 4, 0), inside(editor.document, 4, 5))
    assert (sheet_vertex(6, 3), sheet_vertex(6, 4)) in seams(editor.document)
    editor.undo()
    editor.ask(lambda now: paint_interest(now, SHEET, [sheet_vertex(6, 3), sheet_vertex(6, 4)]))
    hand.drag(inside(editor.document, 4, 0), inside(editor.document, 4, 5))
    assert editor.heard[-1][0] == "failed"
    assert "interest" in editor.heard[-1][1]


def test_seam_stays_on_its_patch(hand, editor, tool, document):
    hand.drag(inside(document, 4, 1), middle(document, CAP))
    assert editor.heard[-1][0] == "failed"
    assert "one patch" in editor.heard[-1][1]
    assert tool._through == []
    hand.click(inside(document, 4, 1))
    hand.click(middle(document, CAP))
    assert tool._through == [sheet_vertex(4, 1)]
    assert [said for said, _ in editor.heard] == ["failed", "failed"]
    hand.drag(inside(document, 4, 3), [1.0, 1.0])
    assert tool._through == [sheet_vertex(4, 1)]


@pytest.mark.long
def test_alt_shows_and_erases_the_run_between_branches(hand, editor, tool, document):
    hand.drag(inside(document, 4, 0), inside(document, 4, 5))
    hand.drag(corner(editor.document, sheet_vertex(4, 2)), corner(editor.document, sheet_vertex(7, 2)))
    branched = editor.document
    branch = {(sheet_vertex(k, 2), sheet_vertex(k + 1, 2)) for k in (4, 5, 6)}
    assert seams(branched) == column(5) | branch
    over = corner(branched, sheet_vertex(6, 2))
    hand_move_with_alt(hand, over)
    assert roles(tool) == [MarkRole.ERASED]
    QTest.mouseClick(hand.view.viewport(), LEFT, ALT, hand.pixel(over))
    assert seams(editor.document) == column(5)
    assert editor.history.names[-1] == "Erase a seam"
    assert roles(tool) == []


def hand_move_with_alt(hand, point):
    """The pointer to a map point with Alt held, as Qt reports it."""
    place = hand.pixel(point).toPointF()
    everywhere = hand.view.viewport().mapToGlobal(place)
    event = QMouseEvent(QEvent.Type.MouseMove, place, everywhere, Qt.MouseButton.NoButton, Qt.MouseButton.NoButton, ALT)
    QApplication.sendEvent(hand.view.viewport(), event)


def test_erasing_without_a_seam_shows_a_message(hand, editor, document):
    QTest.mouseClick(hand.view.viewport(), LEFT, ALT, hand.pixel(middle(document, CAP)))
    assert editor.heard == [("notified", "No seam to erase here")]
    assert editor.document is document


def test_proposal_is_for_the_selected_patch_and_is_drawn(hand, editor, tool, document):
    editor.select([CAP])
    plain = hand.picture()
    tool.propose()
    assert editor.proposal.result.request.jobs[0].number == CAP
    assert MarkRole.OFFERED in roles(tool)
    assert hand.picture() != plain
    assert editor.document is document
    editor.accept()
    assert len(editor.document.charts[CAP].seams) > len(document.charts[CAP].seams)
    assert roles(tool) == []


def test_proposal_without_selection_is_for_the_worst_patch(editor, tool, document):
    tool.propose()
    assert editor.proposal.result.request.jobs[0].number == CAP  # a sheet and a tube flatten without distortion
    assert editor.document is document


@held
def test_seam_being_computed_is_shown_and_a_second_one_waits(hand, editor, tool, worker, document):
    hand.drag(inside(document, 4, 0), inside(document, 4, 4))
    assert roles(tool) == [MarkRole.OFFERED]
    worker.release()
    assert roles(tool) == []
    assert seams(editor.document) == column(4)
    editor.ask(lambda now: set_method(now, [CAP], "tutte"))
    hand.drag(inside(document, 6, 0), inside(document, 6, 4))
    assert "being computed" in editor.heard[-1][1]
    worker.release()
    assert editor.history.names[-1] == "Method"
    assert roles(tool) == [MarkRole.HELD]
    hand.key(Qt.Key.Key_Return)
    worker.release()
    assert seams(editor.document) == column(4) | column(4, at=6)


@pytest.mark.long
def test_erased_only_seam_of_a_tube_is_replaced(hand, editor, document):
    on_seam = document.map.seams[TUBE][0].mean(axis=0)
    QTest.mouseClick(hand.view.viewport(), LEFT, ALT, hand.pixel(on_seam))
    assert editor.history.names == ("Open", "Erase a seam")
    assert len(seams(editor.document, TUBE)) >= len(seams(document, TUBE)) > 0


def test_tool_ignores_presses_while_editing_is_disabled(hand, editor, tool, document):
    editor.set_enabled(enabled=False)
    hand.drag(inside(document, 4, 0), inside(document, 4, 4))
    tool.propose()
    assert editor.document is document
    assert tool._through == []


def test_press_on_another_patch_than_the_last_pointer_position_starts_there(hand, tool, document):
    hand.move(middle(document, TUBE))
    assert tool._tip[0] == TUBE
    QTest.mousePress(hand.view.viewport(), LEFT, NONE, hand.pixel(inside(document, 4, 1)))
    (line,) = [line for line in tool.body_marks().lines if line.role is MarkRole.HELD]
    assert line.patch == SHEET
    assert line.vertices.tolist() == [sheet_vertex(4, 1)]
    QTest.mouseRelease(hand.view.viewport(), LEFT, NONE, hand.pixel(inside(document, 4, 1)))
