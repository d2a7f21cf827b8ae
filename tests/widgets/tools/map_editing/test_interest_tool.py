"""Brush for areas of interest with real mouse events: live preview, one step per stroke, Alt erases."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest

from tactile_maps.editing.reflatten import set_method
from tactile_widgets.tools.map_editing.interest_tool import InterestTool
from tactile_widgets.tools.registry import INTEREST
from tests.widgets.support.executors import HeldJobs
from tests.widgets.support.map_view_driver import ALT, CAP, LEFT, SHEET, MapViewDriver, middle


@pytest.fixture
def tool(editor):
    return InterestTool(editor)


@pytest.fixture
def hand(qtbot, editor, tool):
    return MapViewDriver(qtbot, editor, tool, kind=INTEREST)


held = pytest.mark.parametrize("worker", [HeldJobs], indirect=True)


def painted(document, number=CAP):
    """(k,) vertices of interest."""
    importance = document.patches[number].seams.importance
    return np.zeros(0, int) if importance is None else np.flatnonzero(importance)


def under(document, start, end, radius, number=CAP):
    """(k,) vertices within ``radius`` [m] of a stroke on the map."""
    start = np.asarray(start)
    end = np.asarray(end)
    points = document.map.uv[number]
    along = end - start
    share = np.clip((points - start) @ along / (along @ along), 0, 1)
    away = np.linalg.norm(start + share[:, None] * along - points, axis=1)
    return np.unique(document.charts[number].vertex_of[away <= radius])


@pytest.mark.long
def test_stroke_paints_the_covered_vertices_in_one_step(hand, editor, document):
    start = middle(document, CAP) - [0.02, 0]
    end = middle(document, CAP) + [0.02, 0]
    start = hand.point(hand.pixel(start))
    end = hand.point(hand.pixel(end))
    hand.drag(start, end)
    np.testing.assert_array_equal(
        painted(editor.document),
        under(document, start, end, 24 * hand.view._pixel_size(hand.view.picture.shapes.frame)),
    )
    assert len(painted(editor.document)) > 5
    assert editor.history.names == ("Open", "Paint an area of interest")


@pytest.mark.long
def test_click_paints_an_area_of_the_brush_size(hand, editor, tool, document):
    hand.click(middle(document, CAP))
    small = len(painted(editor.document))
    tool.set_radius(60)
    hand.click(middle(document, CAP))
    assert 0 < small < len(painted(editor.document))


@pytest.mark.long
def test_stroke_over_two_patches_is_one_step(hand, editor, document):
    hand.drag(middle(document, SHEET), middle(document, CAP), steps=20)
    assert len(painted(editor.document, SHEET))
    assert len(painted(editor.document, CAP))
    assert editor.history.names == ("Open", "Paint an area of interest")


def test_stroke_is_shown_on_map_and_body_while_painting(hand, editor, tool, document):
    hand.move(middle(document, CAP))
    before = hand.picture()
    hand.press(middle(document, CAP))
    hand.move(middle(document, CAP) + [0.01, 0])
    (tint,) = tool.body_marks().tints
    assert tint.patch == CAP
    hand.move(middle(document, CAP) + [0.03, 0])
    (more,) = tool.body_marks().tints
    assert set(tint.vertices.tolist()) < set(more.vertices.tolist())
    assert hand.picture() != before
    assert editor.document is document
    hand.release(middle(document, CAP) + [0.03, 0])
    (done,) = tool.body_marks().tints
    np.testing.assert_array_equal(done.vertices, more.vertices)


@pytest.mark.long
def test_stroke_with_alt_erases(hand, editor, document):
    hand.drag(middle(document, CAP) - [0.02, 0], middle(document, CAP) + [0.02, 0])
    before = len(painted(editor.document))
    QTest.mouseClick(hand.view.viewport(), LEFT, ALT, hand.pixel(middle(editor.document, CAP)))
    assert 0 < len(painted(editor.document)) < before
    assert editor.history.names[-1] == "Erase an area of interest"


def test_painting_a_painted_area_adds_no_step(hand, editor, document):
    hand.click(middle(document, CAP))
    hand.click(middle(editor.document, CAP))
    assert len(editor.history.names) == 2
    QTest.mouseClick(hand.view.viewport(), LEFT, ALT, hand.pixel(middle(document, SHEET)))
    assert len(editor.history.names) == 2


def test_escape_cancels_the_stroke(hand, editor, tool, document):
    hand.press(middle(document, CAP))
    hand.move(middle(document, CAP) + [0.02, 0])
    hand.key(Qt.Key.Key_Escape)
    assert tool.body_marks().tints == ()
    hand.release(middle(document, CAP))
    assert editor.document is document


def test_stroke_cannot_start_off_the_patches(hand, editor, tool, document):
    before = hand.view.scene_point(QPoint(0, 0).toPointF())
    hand.press(hand.point(QPoint(5, 5)))
    hand.move(QPoint(80, 60))
    hand.release(QPoint(80, 60))
    assert editor.document is document
    assert tool.body_marks().tints == ()
    assert hand.view.scene_point(QPoint(0, 0).toPointF()) != before  # the map was panned


def test_brush_is_drawn_at_the_pointer_until_it_leaves(hand, tool, document):
    hand.move(QPoint(3, 3))
    tool.leave()
    bare = hand.picture()
    hand.move(middle(document, CAP))
    assert hand.picture() != bare
    tool.leave()
    assert tool._pointer is None


@pytest.mark.long
@held
def test_stroke_is_shown_while_its_map_is_computed(hand, editor, tool, worker, document):
    hand.click(middle(document, CAP))
    (tint,) = tool.body_marks().tints
    worker.release()
    (done,) = tool.body_marks().tints
    np.testing.assert_array_equal(done.vertices, tint.vertices)
    editor.ask(lambda now: set_method(now, [SHEET], "tutte"))
    hand.drag(middle(document, CAP), middle(document, CAP) + [0.02, 0])
    assert "being computed" in editor.heard[-1][1]
    worker.release()
    assert editor.history.names[-1] == "Method"
    np.testing.assert_array_equal(painted(editor.document), done.vertices)
