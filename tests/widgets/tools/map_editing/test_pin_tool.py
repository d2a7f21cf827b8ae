"""Pin tool with real mouse and key events: clicks, drags, keys, and interruptions."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QColor

from tactile_maps.editing.pins import add_pin, pin_places
from tactile_maps.editing.reflatten import set_method
from tactile_widgets.common.colours import DARK
from tactile_widgets.tools.map_editing.pin_tool import PinTool
from tests.widgets.support.executors import HeldJobs
from tests.widgets.support.map_view_driver import CAP, SHEET, SHIFT, MapViewDriver, flips, middle


@pytest.fixture
def tool(editor):
    return PinTool(editor)


@pytest.fixture
def hand(qtbot, editor, tool):
    return MapViewDriver(qtbot, editor, tool)


held = pytest.mark.parametrize("worker", [HeldJobs], indirect=True)


def pins(editor, number=CAP):
    return editor.document.patches[number].pins


def place(editor, pin=0, number=CAP):
    """Return the position of a pin on the map."""
    return editor.document.map.to_map(pins(editor, number)[pin].at)


@pytest.mark.long
def test_click_adds_a_pin_without_moving_the_map(hand, editor, tool, document):
    hand.click(middle(document, CAP))
    (pin,) = pins(editor)
    assert editor.history.names == ("Open", "Add a pin")
    assert editor.document.charts[CAP] is document.charts[CAP]
    np.testing.assert_allclose(place(editor), hand.point(hand.pixel(middle(document, CAP))), atol=1e-9)
    assert tool.chosen == {CAP: [0]}
    assert editor.document.map.to_body(place(editor)).face == pin.at.face


@pytest.mark.long
def test_press_and_drag_adds_and_drags_a_pin_in_one_step(hand, editor, document):
    start = middle(document, CAP)
    goal = start + [0.02, 0.01]
    hand.drag(start, goal)
    assert editor.history.names == ("Open", "Drag a pin")
    assert len(pins(editor)) == 1
    np.testing.assert_allclose(place(editor), goal, atol=1e-3)
    assert len(editor.seen) > 4
    assert all(flips(shown) == 0 for shown in editor.seen)


@pytest.mark.long
def test_existing_pin_is_dragged_with_its_grab_offset(hand, editor, document):
    hand.click(middle(document, CAP))
    other = middle(document, CAP) - [0.03, 0]
    hand.click(other)
    hand.drag(place(editor, 1), place(editor, 1) + [0, 0.01])
    assert editor.history.names[1:] == ("Add a pin", "Add a pin", "Drag a pin")
    assert len(pins(editor)) == 2
    np.testing.assert_allclose(pin_places(editor.document, CAP)[0], middle(document, CAP), atol=1e-3)
    np.testing.assert_allclose(place(editor, 1), other + [0, 0.01], atol=2e-3)


@pytest.mark.long
def test_map_is_exact_after_the_drag(hand, editor, document):
    hand.drag(middle(document, CAP), middle(document, CAP) + [0.01, 0.0])
    assert editor.document.charts[CAP].method != document.charts[CAP].method or len(
        editor.document.charts[CAP].energies
    )
    assert editor.document.charts[CAP].seconds != document.charts[CAP].seconds
    editor.undo()
    assert editor.document is document


def test_map_converges_while_the_pointer_rests(hand, editor, tool, document, qtbot):
    hand.press(middle(document, CAP))
    before = len(editor.seen)  # the hand's own step is one; the next may come while it still moves
    hand.move(middle(document, CAP) + [0.02, 0.02])
    qtbot.waitUntil(lambda: tool._drag._gripped.still)
    assert len(editor.seen) > before + 1
    qtbot.waitUntil(lambda: not tool._drag._rest.isActive())
    hand.release(middle(document, CAP) + [0.02, 0.02])


def test_escape_cancels_the_drag(hand, editor, document):
    hand.press(middle(document, CAP))
    hand.move(middle(document, CAP) + [0.02, 0])
    assert editor.gesture
    hand.key(Qt.Key.Key_Escape)
    assert editor.document is document
    hand.move(middle(document, CAP) + [0.03, 0])
    hand.release(middle(document, CAP) + [0.03, 0])
    assert editor.document is document
    assert editor.history.names == ("Open",)


def test_undo_during_a_drag_ends_the_drag(hand, editor, tool, document):
    hand.press(middle(document, CAP))
    hand.move(middle(document, CAP) + [0.02, 0])
    editor.undo()
    assert editor.document is document
    hand.move(middle(document, CAP) + [0.03, 0])
    hand.release(middle(document, CAP) + [0.03, 0])
    assert editor.document is document
    assert editor.history.names == ("Open",)
    hand.click(middle(document, CAP))
    assert editor.history.names == ("Open", "Add a pin")


@pytest.mark.long
def test_pin_dragged_out_of_the_window_keeps_the_map_valid(hand, editor, document):
    hand.press(middle(document, CAP))
    for pixel in (QPoint(1200, 300), QPoint(5000, -4000), QPoint(-900, 60), QPoint(10**7, 10**7)):
        hand.move(pixel)
    hand.release(QPoint(10**7, 10**7))
    assert all(flips(shown) == 0 for shown in editor.seen)
    assert flips(editor.document) == 0
    assert editor.history.names == ("Open", "Drag a pin")


@pytest.mark.long
def test_pin_dragged_onto_another_stops_before_it(hand, editor, document):
    hand.click(middle(document, CAP))
    start = middle(document, CAP) + [0.02, 0]
    hand.press(start)
    for share in (0.5, 1.0, 1.0):
        hand.move(start - [0.02 * share, 0])
    lag = np.linalg.norm(pin_places(editor.document, CAP)[1] - place(editor, 1))
    assert lag > 2e-4
    hand.release(middle(document, CAP))
    assert all(flips(shown) == 0 for shown in editor.seen)


def test_pin_that_cannot_reach_its_target_shows_the_distance(hand, editor, document, monkeypatch):
    hand.press(middle(document, CAP))
    hand.move(QPoint(2000, 2000))
    lag = np.linalg.norm(pin_places(editor.document, CAP)[0] - place(editor))
    assert lag > 0.05
    said = hand.picture()
    monkeypatch.setattr("tactile_widgets.tools.map_editing.pin_tool._LAG_PX", np.inf)
    assert hand.picture() != said
    hand.key(Qt.Key.Key_Escape)


@held
def test_request_from_another_tool_is_not_discarded(hand, editor, worker, document):
    editor.ask(lambda now: set_method(now, [SHEET], "tutte"))
    assert editor.busy
    hand.drag(middle(document, CAP), middle(document, CAP) + [0.02, 0])
    assert editor.heard[-1][0] == "notified"
    assert "being computed" in editor.heard[-1][1]
    assert editor.document is document
    worker.release()
    assert editor.history.names == ("Open", "Method")


@pytest.mark.long
@held
def test_second_drag_does_not_wait_for_the_exact_map_of_the_first(hand, editor, worker, document):
    hand.drag(middle(document, CAP), middle(document, CAP) + [0.02, 0])
    assert editor.busy
    hand.drag(place(editor), place(editor) + [0, 0.01])
    assert editor.history.names == ("Open", "Drag a pin", "Drag a pin")
    worker.release()
    assert editor.history.names == ("Open", "Drag a pin", "Drag a pin")
    assert flips(editor.document) == 0
    assert not editor.busy


@pytest.mark.long
def test_delete_removes_the_selected_pins_of_all_patches_in_one_step(hand, editor, document):
    hand.click(middle(document, CAP))
    hand.click(middle(document, SHEET), SHIFT)
    hand.tool.select_pinned()
    hand.key(Qt.Key.Key_Delete)
    assert pins(editor) == pins(editor, SHEET) == ()
    assert editor.history.names[-1] == "Remove pins"
    editor.undo()
    assert len(pins(editor)) == len(pins(editor, SHEET)) == 1


def test_delete_without_selection_removes_the_pin_under_the_pointer(hand, editor, tool, document):
    hand.click(middle(document, CAP))
    hand.click(middle(document, CAP) + [0.02, 0])
    hand.click([hand.point(QPoint(2, 2))[0], hand.point(QPoint(2, 2))[1]])
    assert tool.chosen == {}
    tool.remove()
    assert len(pins(editor)) == 2
    assert editor.heard[-1][0] == "notified"
    hand.move(middle(document, CAP))
    tool.remove()
    assert len(pins(editor)) == 1
    np.testing.assert_allclose(place(editor), middle(document, CAP) + [0.02, 0], atol=2e-3)


@pytest.mark.long
def test_arrow_keys_move_the_selected_pin_by_a_millimetre(hand, editor, document):
    hand.click(middle(document, CAP))
    hand.click(middle(document, CAP) + [0.02, 0])
    before = pin_places(editor.document, CAP)
    hand.key(Qt.Key.Key_Right)
    hand.key(Qt.Key.Key_Up, SHIFT)
    np.testing.assert_allclose(pin_places(editor.document, CAP) - before, [[0, 0], [1e-3, 1e-4]], atol=1e-9)


@held
def test_arrow_keys_accumulate_while_the_map_is_computed(hand, editor, worker, document):
    hand.click(middle(document, CAP))
    before = pin_places(editor.document, CAP)
    for _ in range(3):
        hand.key(Qt.Key.Key_Left)
    worker.release()
    np.testing.assert_allclose(pin_places(editor.document, CAP) - before, [[-3e-3, 0]], atol=1e-9)
    assert editor.history.names == ("Open", "Add a pin", "Move pins")


def test_taxels_are_pinned_in_one_step_and_only_once(hand, editor, tool, document):
    tool.pin_taxels([0, 12, 13])
    assert editor.history.names == ("Open", "Pin 3 taxels")
    assert [len(patch.pins) for patch in editor.document.patches] == [1, 2, 0]
    tool.pin_taxels([0, 12])
    assert editor.heard == [("notified", "These taxels are pinned already")]
    tool.pin_taxels([0, 30])
    assert editor.history.names[-1] == "Add a pin"


def test_select_pinned_selects_pins_of_selected_patches_or_of_all(editor, tool):
    tool.pin_taxels([0, 12, 13])
    editor.select([1])
    tool.select_pinned()
    assert tool.chosen == {1: [0, 1]}
    editor.select(())
    tool.select_pinned()
    assert tool.chosen == {0: [0], 1: [0, 1]}


def test_add_pin_uses_the_pointer_and_explains_itself_off_the_skin(hand, editor, tool, document):
    hand.move(middle(document, CAP))
    tool.add_here()
    assert editor.heard == []
    assert len(pins(editor)) == 1
    tool.add_here()
    assert editor.heard[-1][0] == "failed"
    assert len(pins(editor)) == 1
    hand.move(QPoint(2, 2))
    tool.add_here()
    assert editor.heard[-1] == ("notified", "Point at the skin to pin it there")


def test_pins_are_diamonds_and_the_selected_one_has_the_accent_colour(hand, editor, document):
    hand.click(middle(document, CAP))
    at = hand.pixel(place(editor))
    hand.move(QPoint(2, 2))
    assert hand.picture().pixelColor(at) == QColor(DARK.accent)
    hand.tool._choose([])
    assert hand.picture().pixelColor(at) == QColor("#ffffff")
    assert hand.picture().pixelColor(at + QPoint(0, 4)).lightness() < 150
    hand.move(at)
    assert hand.picture().pixelColor(at + QPoint(0, 4)).lightness() > 250
    assert hand.view.viewport().cursor().shape() == Qt.CursorShape.OpenHandCursor


def test_tool_ignores_presses_while_editing_is_disabled(hand, editor, document):
    editor.set_enabled(enabled=False)
    hand.drag(middle(document, CAP), middle(document, CAP) + [0.02, 0])
    assert editor.document is document


@pytest.mark.long
def test_pin_is_marked_on_the_body_also_during_a_drag(hand, editor, tool, document):
    assert tool.body_marks().spots == ()
    hand.click(middle(document, CAP))
    (spot,) = tool.body_marks().spots
    assert spot.at == pins(editor)[0].at
    hand.press(place(editor))
    hand.move(place(editor) + [0.01, 0])
    marks = tool.body_marks()
    hand.move(place(editor) + [0.01, 0.01])
    assert tool.body_marks() is marks  # a new list would redraw the body with every frame of the map
    hand.release(place(editor))


def test_document_with_a_new_pin_equals_add_pin(editor, tool, document):
    at = document.skin.taxel_point(30)
    tool.pin_taxels([30])
    assert editor.document.patches[at.patch].pins == add_pin(document, at).patches[at.patch].pins
