"""Path tool with real mouse events: drawing, and editing the current path by drags and keys, with undo."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import QEvent, QPoint, QPointF, Qt
from PySide6.QtGui import QColor, QMouseEvent
from PySide6.QtTest import QTest

from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_widgets.common.colours import DARK
from tactile_widgets.tools.control.path_tool import PathTool
from tactile_widgets.tools.control.target_tool import TargetTool
from tactile_widgets.views.interaction.arrow_keys import FINE_STEP, STEP
from tactile_widgets.views.interaction.view_tool import PointerHit
from tests.widgets.support.map_view_driver import (
    LEFT,
    NONE,
    PIXEL,
    SHEET,
    SHIFT,
    middle,
    path_in_force,
    set_path_kind,
)
from tests.widgets.support.mouse import turn_wheel
from tests.widgets.support.samples import touched


@pytest.mark.parametrize("made", [PathTool, TargetTool])
def test_body_location_on_another_skin_is_ignored_without_an_arm(made, lead):
    """A recording of another robot is shown: the map that can be drawn on has no such place."""
    tool = made(lead)
    lead.set_enabled(enabled=False)
    beyond = PointerHit(SurfacePoint(0, 1_000_000, (1.0, 0.0, 0.0)), None, 1e-3)
    away = QPointF(3, 3)
    press = QMouseEvent(QEvent.Type.MouseButtonPress, away, away, LEFT, LEFT, NONE)
    assert not tool.press(beyond, press)
    tool.move(beyond, press)
    assert tool.cursor(beyond) == Qt.CursorShape.ArrowCursor
    assert lead.asked == []


def test_caption_of_a_contact_is_next_to_the_force_and_the_handles(drawn, lead, tool, document, painted_captions):
    taxel = int(np.argmin(np.linalg.norm(document.map.taxel_points - middle(document, SHEET), axis=1)))
    at = document.map.taxel_points[taxel]
    view = drawn.view
    view.show_frame(touched(document.map, [taxel], radius=0.005))
    view.set_view_tool(None)
    (alone,) = painted_captions(view)
    end = drawn.point(alone.center().toPoint())
    lead.show_settings(replace(lead.settings, path=tuple(map(tuple, (end - [0.02, 0.02], at - [0.0, 0.02], end)))))
    view.set_view_tool(tool)
    (caption,) = painted_captions(view)
    boxes = tool.boxes(view.map_to_pixels, view.font())
    assert [alone.intersects(box) for box in boxes.handles] == [False, False, True], "the end is on the caption"
    assert [box.center() for box in boxes.labels] == [tool._plate._box.center()]
    assert not any(caption.intersects(box) for box in (*boxes.labels, *boxes.handles))


@pytest.mark.long
@pytest.mark.parametrize("kind", ["polyline", "spline"])
def test_clicks_and_enter_request_to_follow_a_path(hand, lead, corners, kind):
    set_path_kind(lead, kind)
    for corner in corners:
        hand.click(corner)
    assert lead.asked == []
    hand.key(Qt.Key.Key_Return)
    (settings,) = lead.asked
    assert (settings.controller, settings.task, settings.path_kind) == ("hybrid", "follow_path", kind)
    np.testing.assert_allclose(settings.path, corners, atol=PIXEL)


def test_controller_with_tasks_is_kept(hand, lead, corners):
    lead.show_settings(replace(lead.settings, controller="qp", path_kind="polyline"))
    hand.drag(corners[0], corners[1])
    assert lead.settings.controller == "qp"


def test_double_click_ends_the_path(hand, lead, corners):
    set_path_kind(lead, "polyline")
    for corner in corners:
        hand.click(corner)
    QTest.mouseDClick(hand.view.viewport(), LEFT, NONE, hand.pixel(corners[-1]))
    assert len(lead.settings.path) == 3


def test_click_on_the_first_corner_closes_the_path(hand, lead, corners):
    set_path_kind(lead, "polyline")
    for corner in [*corners, corners[0]]:
        hand.click(corner)
    (settings,) = lead.asked
    assert len(settings.path) == 4
    assert settings.path[0] == settings.path[-1]


@pytest.mark.long
def test_stroke_is_a_path_with_few_corners(hand, lead, corners):
    set_path_kind(lead, "polyline")
    hand.press(corners[0])
    for start, end in ((0, 1), (1, 2)):
        for share in np.linspace(0, 1, 12)[1:]:
            hand.move(corners[start] + share * (corners[end] - corners[start]))
    hand.release(corners[2])
    assert len(lead.asked) == 1
    assert len(path_in_force(lead)) <= 5
    assert all(np.linalg.norm(path_in_force(lead) - corner, axis=1).min() < 2 * PIXEL for corner in corners)


def test_hint_names_the_shape_that_a_drag_draws(lead, tool):
    set_path_kind(lead, "lemniscate")
    assert "end to end of a figure of eight" in tool.hint
    assert "Polyline" in tool.hint
    set_path_kind(lead, "polyline")
    assert "in one stroke" in tool.hint


@pytest.mark.parametrize("kind", ["lemniscate", "raster"])
def test_figure_of_eight_and_box_are_drawn_by_a_drag(hand, lead, corners, kind):
    set_path_kind(lead, kind)
    hand.drag(corners[0], corners[1])
    (settings,) = lead.asked
    assert settings.path_kind == kind
    np.testing.assert_allclose(settings.path, corners[:2], atol=PIXEL)


def test_backspace_removes_corners_and_discards_the_path_with_the_first(hand, lead, tool, corners):
    set_path_kind(lead, "polyline")
    hand.click(corners[0])
    hand.click(corners[1])
    hand.key(Qt.Key.Key_Backspace)
    hand.click(corners[2])
    hand.key(Qt.Key.Key_Return)
    np.testing.assert_allclose(path_in_force(lead), corners[[0, 2]], atol=PIXEL)
    hand.click(corners[1])
    hand.key(Qt.Key.Key_Backspace)
    assert not tool.drawing
    assert len(lead.asked) == 1


def test_backspace_is_left_to_the_window_without_a_drawn_path(hand, lead, tool, corners):
    assert not tool.overrides_shortcut(Qt.Key.Key_Backspace)
    set_path_kind(lead, "polyline")
    hand.click(corners[0])
    assert tool.overrides_shortcut(Qt.Key.Key_Backspace)


def test_escape_discards_the_drawn_path_and_keeps_the_current_one(drawn, lead, tool, corners):
    before = lead.settings
    drawn.click(corners[0] + [0.0, 0.05])
    assert tool.drawing
    drawn.key(Qt.Key.Key_Escape)
    assert not tool.drawing
    assert lead.settings is before


def test_enter_after_one_corner_has_no_effect(hand, lead, tool, corners):
    set_path_kind(lead, "polyline")
    hand.click(corners[0])
    hand.key(Qt.Key.Key_Return)
    assert tool.drawing
    assert lead.asked == []


def test_press_off_the_skin_pans_the_map(hand, lead, tool):
    centre = hand.view.camera.centre
    hand.drag(hand.point(QPoint(3, 3)), hand.point(QPoint(40, 30)))
    assert not tool.drawing
    assert hand.view.camera.centre != centre


def test_figure_of_eight_with_its_middle_off_the_skin_is_rejected(hand, lead, document):
    set_path_kind(lead, "lemniscate")
    low, high = document.map.boxes[SHEET]
    ways = [3 * (high - low) * way for way in ((0.0, 1.0), (0.0, -1.0), (1.0, 0.0), (-1.0, 0.0))]
    way = next(way for way in ways if document.map.to_body(middle(document, SHEET) + way / 2) is None)
    hand.drag(middle(document, SHEET), middle(document, SHEET) + way)
    assert lead.asked == []
    assert lead.heard == ["A path must start on the skin"]


@pytest.mark.parametrize("kind", ["polyline", "raster"])
def test_cursor_shows_what_a_press_would_do(hand, lead, corners, kind):
    set_path_kind(lead, kind)
    hand.drag(corners[0], corners[1])
    for place, shown in (
        (corners[0], Qt.CursorShape.OpenHandCursor),
        (corners[2] + [0.0, 0.05], Qt.CursorShape.CrossCursor),
        (QPoint(3, 3), Qt.CursorShape.ArrowCursor),
    ):
        hand.move(place)
        assert hand.view.viewport().cursor().shape() == shown
    line = corners[0] + (0.2 * (corners[1] - corners[0]) if kind == "polyline" else [0.012, 0.0])
    hand.move(line)
    assert hand.view.viewport().cursor().shape() == Qt.CursorShape.SizeAllCursor


def test_handles_are_larger_under_the_pointer_and_filled_when_chosen(drawn, corners):
    intent = QColor(DARK.intent)

    def violet(at):
        image = drawn.picture()
        pixel = drawn.pixel(at)
        area = [image.pixelColor(pixel.x() + dx, pixel.y() + dy) for dx in range(-7, 8) for dy in range(-7, 8)]
        return sum(abs(c.red() - intent.red()) + abs(c.blue() - intent.blue()) < 30 for c in area)

    drawn.move(QPoint(3, 3))
    small = violet(corners[1])
    drawn.move(corners[1])
    large = violet(corners[1])
    drawn.click(corners[1])
    drawn.move(QPoint(3, 3))
    assert 10 < small < large
    assert violet(corners[1]) > 2 * small


def test_line_being_drawn_is_shown_on_map_and_body(hand, lead, tool, corners):
    set_path_kind(lead, "polyline")
    before = hand.picture()
    hand.click(corners[0])
    hand.move(corners[1])
    assert hand.picture() != before
    marks = tool.body_marks()
    assert len(marks.spots) == 2
    (stroke,) = marks.strokes
    assert stroke.line.patch == SHEET
    np.testing.assert_allclose(stroke.line.on_map[[0, -1]], corners[:2], atol=PIXEL)


def test_path_cannot_be_drawn_without_an_arm(hand, lead, tool, corners):
    lead.set_enabled(enabled=False)
    hand.click(corners[0])
    hand.drag(corners[0], corners[1])
    assert not tool.drawing
    assert lead.asked == []


def test_wheel_and_drag_on_the_plate_change_the_force(drawn, lead, tool):
    drawn.view.viewport().repaint()
    plate = tool._plate._box.center()
    turn_wheel(drawn.view.viewport(), plate, 2)
    assert lead.settings.force_goal == 4.0
    pixel = plate.toPoint()
    QTest.mouseMove(drawn.view.viewport(), pixel)
    assert drawn.view.viewport().cursor().shape() == Qt.CursorShape.SizeVerCursor
    QTest.mousePress(drawn.view.viewport(), LEFT, NONE, pixel)
    QTest.mouseMove(drawn.view.viewport(), pixel + QPoint(0, 16))
    QTest.mouseRelease(drawn.view.viewport(), LEFT, NONE, pixel + QPoint(0, 16))
    assert lead.settings.force_goal == 3.0
    assert len(path_in_force(lead)) == 3


def test_dragged_corner_is_requested_on_release(drawn, lead, corners):
    drawn.press(corners[1])
    drawn.move(corners[1] + [0.0, 0.01])
    drawn.move(corners[1] + [0.0, 0.02])
    assert len(lead.asked) == 1
    drawn.release(corners[1] + [0.0, 0.02])
    assert len(lead.asked) == 2
    np.testing.assert_allclose(path_in_force(lead), corners + [[0, 0], [0, 0.02], [0, 0]], atol=2 * PIXEL)
    assert lead.steps.undo_step.name == "move a corner"


def test_dragging_a_middle_adds_a_corner(drawn, lead, corners):
    start = corners[:2].mean(axis=0)
    drawn.drag(start, start + [-0.02, 0.01])
    assert lead.steps.undo_step.name == "add a corner"
    np.testing.assert_allclose(np.delete(path_in_force(lead), 1, axis=0), corners, atol=PIXEL)
    np.testing.assert_allclose(path_in_force(lead)[1], start + [-0.02, 0.01], atol=2 * PIXEL)


def test_dragging_the_line_moves_the_path(drawn, lead, corners):
    start = corners[0] + 0.25 * (corners[1] - corners[0])
    drawn.drag(start, start + [0.01, 0.01])
    assert lead.steps.undo_step.name == "move the path"
    np.testing.assert_allclose(path_in_force(lead), corners + 0.01, atol=2 * PIXEL)


def test_escape_during_a_drag_keeps_the_path(drawn, lead, corners):
    before = lead.settings
    drawn.press(corners[1])
    drawn.move(corners[1] + [0.0, 0.02])
    drawn.key(Qt.Key.Key_Escape)
    drawn.release(corners[1] + [0.0, 0.02])
    assert lead.settings is before


def test_delete_removes_the_chosen_corner(drawn, lead, corners):
    drawn.click(corners[1])
    drawn.key(Qt.Key.Key_Delete)
    np.testing.assert_allclose(path_in_force(lead), corners[[0, 2]], atol=PIXEL)
    drawn.click(corners[0])
    drawn.key(Qt.Key.Key_Delete)
    assert len(path_in_force(lead)) == 2
    assert lead.heard == ["This path has the fewest corners already"]


def test_delete_without_a_chosen_corner_keeps_the_path(drawn, lead, corners):
    drawn.move(corners[0] + [0.0, 0.05])
    drawn.key(Qt.Key.Key_Delete)
    assert len(path_in_force(lead)) == 3
    assert lead.heard == ["Click a corner to choose it, then Delete removes it"]


def test_arrows_move_the_chosen_corner_or_all_in_one_step(drawn, lead, corners):
    before = path_in_force(lead)
    drawn.click(corners[2])
    for _ in range(3):
        drawn.key(Qt.Key.Key_Right)
    drawn.key(Qt.Key.Key_Up, SHIFT)
    np.testing.assert_allclose(path_in_force(lead) - before, [[0, 0], [0, 0], [3 * STEP, FINE_STEP]], atol=1e-12)
    lead.undo()
    np.testing.assert_allclose(path_in_force(lead), before)
    drawn.click(corners[0] + 0.25 * (corners[1] - corners[0]))  # the line: no corner is chosen
    drawn.key(Qt.Key.Key_Down)
    np.testing.assert_allclose(path_in_force(lead) - before, np.tile([0, -STEP], (3, 1)), atol=1e-12)


def test_all_steps_are_undone(drawn, lead, corners):
    first = lead.settings
    drawn.drag(corners[1], corners[1] + [0.0, 0.02])
    assert lead.settings != first
    lead.undo()
    assert lead.settings == first
    lead.undo()
    assert lead.settings.controller == "impedance"
    assert lead.settings.path == ()
    lead.redo()
    assert lead.settings == first
