"""Arrange tool with real mouse events: select, hide, drag, keys, and undo."""

from __future__ import annotations

import math

import numpy as np
import pytest
from PySide6.QtCore import QEvent, QPoint, QPointF, Qt
from PySide6.QtGui import QMouseEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QLineEdit

from tactile_maps.editing.document import show_patches
from tactile_widgets.tools.map_editing.transform_box import ROTATION_HANDLE
from tactile_widgets.views.interaction.view_tool import PointerHit
from tactile_widgets.views.overlays.body_overlays import NO_MARKS
from tests.widgets.support.arrange_driver import CONTROL, LEFT, NONE, SHIFT, Bench
from tests.widgets.support.samples import leaf_map, middle_taxel, touched

BESIDE = (6.0, 300.0)
FREE = np.array([23.0, -31.0])
"""Displacement that does not snap."""


@pytest.fixture
def bench(qtbot):
    return Bench(qtbot, leaf_map())


@pytest.mark.long
def test_drag_moves_the_patch_under_it_in_one_step(bench):
    first = bench.picture()
    before = bench.middle(0)
    end = bench.drag(bench.over(0), FREE, CONTROL)
    assert bench.editor.gesture
    bench.release(end)
    assert bench.editor.selected == (0,)
    assert bench.steps == ("Move",)
    assert bench.pixels(bench.middle(0))[0] == pytest.approx(bench.pixels(before)[0] + FREE, abs=1e-6)
    assert bench.picture() != first
    bench.editor.select(())
    bench.editor.undo()
    bench.move(BESIDE)
    assert bench.picture() == first


@pytest.mark.long
def test_selected_patches_move_together(bench):
    bench.editor.select([0, 1])
    before = [bench.middle(0), bench.middle(1)]
    bench.release(bench.drag(bench.over(1), FREE, CONTROL))
    moved = [bench.middle(k) - before[k] for k in range(2)]
    assert moved[0] == pytest.approx(moved[1])
    assert np.linalg.norm(moved[0]) > 0.01


@pytest.mark.long
def test_hidden_patch_does_not_move(bench):
    bench.editor.do("Hide patches", lambda document: show_patches(document, [1], visible=False))
    bench.editor.select([0, 1])
    before = bench.placement(1)
    bench.release(bench.drag(bench.over(0), FREE, CONTROL))
    assert bench.steps == ("Hide patches", "Move")
    assert bench.placement(1) == before


@pytest.mark.long
@pytest.mark.parametrize("keys", [NONE, CONTROL], ids=["snaps", "control does not"])
def test_moved_patch_snaps_to_others(bench, keys):
    boxes = bench.document.map.boxes
    gap = boxes[1, 0, 1] - boxes[0, 0, 1]  # of the lower sides
    pixel = bench.view._pixel_size(bench.view.picture.shapes.frame)
    by = np.array([37.0, -(gap / pixel) + 5.0])  # five pixels short, and y runs down
    end = bench.drag(bench.over(0), by, keys)
    lined_up = bench.document.map.boxes[0, 0, 1] == pytest.approx(boxes[1, 0, 1])
    assert lined_up == (keys == NONE)
    assert bool(bench.tool._marks.y) == (keys == NONE)
    bench.release(end)
    assert not bench.tool._marks.y


@pytest.mark.long
def test_shift_moves_along_one_axis(bench):
    before = bench.middle(0)
    bench.release(bench.drag(bench.over(0), (60.0, 20.0), SHIFT))
    moved = bench.middle(0) - before
    assert moved[1] == 0
    assert moved[0] > 0.02


@pytest.mark.long
@pytest.mark.parametrize("keys", [NONE, SHIFT], ids=["opposite corner", "middle"])
@pytest.mark.parametrize("corner", range(4))
def test_corner_drag_scales(bench, corner, keys):
    bench.click(bench.over(0))
    box = bench.document.map.boxes[0]
    corners = np.array([[box[i, 0], box[j, 1]] for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))])
    fixed = box.mean(axis=0) if keys == SHIFT else corners[(corner + 2) % 4]
    arm = bench.pixels(corners[corner])[0] - bench.pixels(fixed)[0]
    bench.release(bench.drag(bench.handle(corner), 0.25 * arm, keys), keys)
    assert bench.steps == ("Scale",)
    assert bench.placement(0).scale == pytest.approx(1.25, rel=1e-3)
    new = bench.document.map.boxes[0]
    ends = np.array([[new[i, 0], new[j, 1]] for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))])
    still = new.mean(axis=0) if keys == SHIFT else ends[(corner + 2) % 4]
    assert still == pytest.approx(fixed, abs=1e-9)


@pytest.mark.long
@pytest.mark.parametrize(("pull", "scale"), [(-3.0, 0.1), (40.0, 10.0)])
def test_scaling_is_clamped_to_valid_factors(bench, pull, scale):
    bench.click(bench.over(0))
    arm = bench.handle(2) - bench.handle(0)
    bench.release(bench.drag(bench.handle(2), pull * arm))
    assert bench.placement(0).scale == pytest.approx(scale, rel=1e-6)
    assert bench.failures == []


@pytest.mark.long
def test_round_handle_rotates(bench):
    bench.click(bench.over(1))
    middle = bench.over(1)
    start = bench.handle(ROTATION_HANDLE)
    before = bench.placement(1).angle
    arm = start - middle
    turned = np.array([arm[1], -arm[0]])  # a quarter counter-clockwise, y running down
    bench.release(bench.drag(start, turned - arm))
    assert bench.steps == ("Rotate",)
    assert bench.placement(1).angle - before == pytest.approx(math.pi / 2, abs=1e-3)
    assert bench.pixels(bench.middle(1))[0] == pytest.approx(middle, abs=12)  # the box is another one


@pytest.mark.long
@pytest.mark.parametrize("numbers", [(1,), (0, 1)])
def test_shift_rotates_in_fixed_steps(bench, numbers):
    bench.editor.select(numbers)
    before = bench.placement(1).angle
    bench.release(bench.drag(bench.handle(ROTATION_HANDLE), (60.0, 10.0), SHIFT), SHIFT)
    turn = bench.placement(1).angle if len(numbers) == 1 else bench.placement(1).angle - before
    assert abs(bench.placement(1).angle - before) > 0.05
    assert math.degrees(turn) / 15 == pytest.approx(round(math.degrees(turn) / 15), abs=1e-6)


@pytest.mark.long
@pytest.mark.parametrize("how", ["escape", "focus", "another tool", "undo", "disabled"])
def test_cancelled_gesture_restores_the_document(bench, qtbot, how):
    bench.click(bench.over(0))
    first = bench.document
    bench.drag(bench.over(0), FREE)
    assert bench.document is not first
    if how == "escape":
        QTest.keyClick(bench.view, Qt.Key.Key_Escape)
    elif how == "focus":
        other = QLineEdit(bench.view)
        other.show()
        bench.view.activateWindow()
        bench.view.setFocus()
        qtbot.waitUntil(bench.view.hasFocus)
        other.setFocus()
    elif how == "another tool":
        bench.view.set_view_tool(None)
        bench.view.set_view_tool(bench.tool)
    elif how == "undo":
        bench.editor.undo()
    else:
        bench.editor.set_enabled(enabled=False)
    bench.move(bench.over(0) + 2 * FREE)
    bench.release(bench.over(0) + 2 * FREE)
    assert bench.document is first
    assert bench.steps == ()


@pytest.mark.long
def test_arrow_keys_move_the_selection_or_else_the_view(bench):
    centre = bench.view.camera.centre
    before = bench.middle(0)
    bench.view.zoom(2.0, bench.view.viewport().rect().center().toPointF())
    QTest.keyClick(bench.view, Qt.Key.Key_Right)
    assert bench.view.camera.centre != centre
    assert bench.steps == ()
    bench.editor.select([0])
    QTest.keyClick(bench.view, Qt.Key.Key_Right)
    assert bench.middle(0) - before == pytest.approx([1e-3, 0])
    QTest.keyClick(bench.view, Qt.Key.Key_Up, SHIFT)
    assert bench.middle(0) - before == pytest.approx([1e-3, 1e-2])
    assert bench.steps == ("Move",)


def test_presses_of_arrow_keys_are_one_step(bench):
    first = bench.document
    bench.editor.select([0])
    before = bench.middle(0)
    for _ in range(10):
        QTest.keyClick(bench.view, Qt.Key.Key_Right)
    assert bench.middle(0) - before == pytest.approx([1e-2, 0])
    assert bench.steps == ("Move",)
    bench.editor.select([1])
    QTest.keyClick(bench.view, Qt.Key.Key_Up)
    assert bench.steps == ("Move", "Move"), "another patch is another step"
    bench.editor.undo()
    bench.editor.undo()
    assert bench.document is first


@pytest.mark.long
def test_tool_does_not_poke_and_the_middle_button_pans(bench):
    pokes = []
    bench.view.interaction.poke_pressed.connect(pokes.append)
    bench.release(bench.drag(bench.over(0), FREE))
    middle = bench.view.camera.centre
    start = QPoint(300, 300)
    QTest.mousePress(bench.view.viewport(), Qt.MouseButton.MiddleButton, NONE, start)
    QTest.mouseMove(bench.view.viewport(), start + QPoint(12, 9))
    QTest.mouseRelease(bench.view.viewport(), Qt.MouseButton.MiddleButton, NONE, start + QPoint(12, 9))
    assert bench.view.camera.centre != middle
    bench.editor.set_enabled(enabled=False)
    middle = bench.view.camera.centre
    bench.release(bench.drag(bench.over(0), FREE))
    assert bench.view.camera.centre != middle
    assert pokes == []
    assert bench.steps == ("Move",)


@pytest.mark.long
def test_touch_is_shown_while_a_patch_is_dragged(bench):
    taxel = middle_taxel(bench.document.map, 0)
    end = bench.drag(bench.over(0), FREE)
    at = bench.document.skin.taxel_point(taxel)
    quiet = bench.picture().pixelColor(bench.view.pixel_of(at).toPoint() + QPoint(5, 5))
    bench.view.show_frame(touched(leaf_map(), [taxel], kilopascals=19.0, radius=0.05))
    assert bench.picture().pixelColor(bench.view.pixel_of(at).toPoint() + QPoint(5, 5)) != quiet
    mark = bench.view.marks.contacts[0].at
    assert bench.view.viewportTransform().map(mark) == bench.view.pixel_of(at)
    bench.release(end)


@pytest.mark.long
def test_cursor_and_text_show_what_a_press_would_do(bench):
    bench.click(bench.over(0))
    shapes = {}
    for name, pixel in (
        ("patch", bench.over(0)),
        ("rising", bench.handle(0)),
        ("falling", bench.handle(1)),
        ("turn", bench.handle(ROTATION_HANDLE)),
        ("beside", BESIDE),
    ):
        bench.move(pixel)
        shapes[name] = bench.view.viewport().cursor().shape()
        assert ("Shift" in bench.tool._marks.words) == (name in ("rising", "falling", "turn"))
    assert shapes == {
        "patch": Qt.CursorShape.SizeAllCursor,
        "rising": Qt.CursorShape.SizeBDiagCursor,
        "falling": Qt.CursorShape.SizeFDiagCursor,
        "turn": Qt.CursorShape.PointingHandCursor,
        "beside": Qt.CursorShape.ArrowCursor,
    }


def test_caption_describes_the_drag(bench):
    bench.release(bench.drag(bench.over(0), FREE, CONTROL))
    for handle, unit in ((None, "mm"), (2, "×"), (2, "of true size"), (ROTATION_HANDLE, "°")):
        end = bench.drag(bench.over(0) if handle is None else bench.handle(handle), -FREE, CONTROL)
        assert unit in bench.tool._marks.words
        bench.release(end)


def test_clicks_select_patches(bench):
    left = bench.over(0)
    right = bench.over(1)
    for pixel, keys, selected in (
        (left, NONE, (0,)),
        (right, NONE, (1,)),
        (left, CONTROL, (0, 1)),
        (right, SHIFT, (0,)),
        (BESIDE, SHIFT, (0,)),
        (BESIDE, NONE, ()),
    ):
        bench.click(pixel, keys)
        assert bench.editor.selected == selected
    assert bench.steps == ()


@pytest.mark.long
@pytest.mark.parametrize("by", [(40.0, 25.0), (0.0, 40.0)])
def test_press_that_moved_is_not_a_click(bench, by):
    bench.editor.select([0, 1])
    start = bench.over(0)
    bench.drag(start, by)
    bench.move(start)
    bench.release(start)
    assert bench.editor.selected == (0, 1)
    assert bench.placement(0).offset == pytest.approx(leaf_map().layout.placements[0].offset)


@pytest.mark.long
def test_small_movement_counts_as_a_click(bench):
    bench.editor.select([0, 1])
    start = bench.over(0)
    bench.press(start)
    bench.move(start + 2)
    bench.release(start + 2)
    assert bench.editor.selected == (0,)
    assert bench.steps == ()


@pytest.mark.long
def test_release_elsewhere_without_a_move_is_not_a_click(bench):
    bench.editor.select([0, 1])
    bench.press(bench.over(0))
    bench.release(bench.over(0) + FREE)
    assert bench.editor.selected == (0, 1)
    assert bench.steps == ()


@pytest.mark.long
def test_second_escape_clears_the_selection(bench):
    bench.click(bench.over(0))
    cleared = []
    bench.view.interaction.cleared.connect(lambda: cleared.append(True))
    QTest.keyClick(bench.view, Qt.Key.Key_Escape)
    assert bench.editor.selected == ()
    assert not cleared
    QTest.keyClick(bench.view, Qt.Key.Key_Escape)
    assert cleared


def test_box_selects_overlapping_patches(bench):
    bench.move(BESIDE)
    assert bench.view.viewport().cursor().shape() == Qt.CursorShape.ArrowCursor
    before = bench.picture()
    end = bench.drag(BESIDE, (8.0, 40.0))
    assert bench.view.viewport().cursor().shape() == Qt.CursorShape.CrossCursor
    assert bench.picture() != before, "an empty box is shown, too"
    bench.release(end)
    assert bench.editor.selected == ()
    low, high = bench.pixels(bench.document.map.boxes[1])
    start = np.array([high[0] + 8, high[1] - 8])
    end = (low + high) / 2
    bench.drag(start, end - start)
    assert bench.editor.selected == (1,)
    bench.release(end)
    assert bench.editor.selected == (1,)
    bench.editor.select([0])
    bench.press(start, SHIFT)
    bench.move(end, SHIFT)
    bench.release(end, SHIFT)
    assert bench.editor.selected == (0, 1)
    bench.editor.select([1])
    bench.drag(start, np.array([4.0, high[1] - 8]) - start)
    QTest.keyClick(bench.view, Qt.Key.Key_Escape)
    assert bench.editor.selected == (1,)
    assert bench.steps == ()


@pytest.mark.long
def test_click_on_the_body_selects_and_a_drag_has_no_effect(bench):
    at = bench.document.skin.taxel_point(0)
    place = PointerHit(at, None, 1e-3)
    assert bench.tool.body_marks() == NO_MARKS
    for press in ((0, 0), (60, 0)):
        event = _event(press)
        assert bench.tool.press(place, _event((0, 0)))
        bench.tool.move(place, event)
        bench.tool.release(place, event)
    assert bench.editor.selected == (0,)
    assert bench.steps == ()
    marks = bench.tool.body_marks()
    assert len(marks.lines) == 1
    assert bench.tool.body_marks() is marks


def _event(pixel):
    return QMouseEvent(QEvent.Type.MouseMove, QPointF(*pixel), QPointF(*pixel), LEFT, LEFT, NONE)
