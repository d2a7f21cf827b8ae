"""Target tool with real mouse events: a click sets the target, a drag and keys move it, the plate sets the force."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest

from tactile_maps.editing.document import MapDocument
from tactile_widgets.tools.control.target_tool import TargetTool
from tactile_widgets.tools.registry import PATH
from tactile_widgets.views.interaction.arrow_keys import FINE_STEP, STEP
from tests.widgets.support.executors import InlineSceneJobs
from tests.widgets.support.map_view_driver import CAP, LEFT, NONE, SHEET, SHIFT, MapViewDriver, middle, open_editor
from tests.widgets.support.mouse import turn_wheel
from tests.widgets.support.samples import leaf_map, middle_taxel, touched

PIXEL = 1.5e-3


@pytest.fixture
def tool(lead):
    return TargetTool(lead)


@pytest.fixture
def centre(document):
    return middle(document, SHEET)


@pytest.fixture
def held(hand, lead, centre):
    """A target in the middle of the sheet."""
    hand.click(centre)
    assert lead.settings.task == "hold_point"
    return hand


def target(lead):
    return np.array(lead.settings.path[0])


def plate(hand, tool):
    """The middle of the force's plate [px]."""
    hand.view.viewport().repaint()
    return tool._plate._box.center()


@pytest.mark.long
def test_click_sets_the_target(hand, lead, centre):
    hand.click(centre)
    (settings,) = lead.asked
    assert (settings.controller, settings.task) == ("hybrid", "hold_point")
    np.testing.assert_allclose(settings.path, [centre], atol=PIXEL)
    assert lead.steps.undo_step.name == "set the target"


def test_drag_moves_the_target_in_one_step(held, lead, centre):
    asked = len(lead.asked)
    held.drag(centre, centre + [0.02, 0.01], steps=5)
    assert len(lead.asked) >= asked + 5
    np.testing.assert_allclose(target(lead), centre + [0.02, 0.01], atol=PIXEL)
    lead.undo()
    np.testing.assert_allclose(target(lead), centre, atol=PIXEL)


def test_target_stays_at_the_last_skin_location_off_the_skin(held, lead, document, centre):
    held.press(centre)
    held.move(centre + [0.02, 0.0])
    held.move(QPoint(3, 3))
    assert document.map.to_body(target(lead)) is not None
    np.testing.assert_allclose(target(lead), centre + [0.02, 0.0], atol=PIXEL)
    held.release(QPoint(3, 3))


def test_target_can_move_to_another_patch(held, lead, document, centre):
    held.drag(centre, middle(document, CAP), steps=9)
    assert document.map.to_body(target(lead)).patch == CAP


def test_escape_during_a_drag_restores_the_target(held, lead, centre):
    before = lead.settings
    held.press(centre)
    held.move(centre + [0.02, 0.0])
    assert lead.settings != before
    held.key(Qt.Key.Key_Escape)
    assert lead.settings == before
    held.move(centre + [0.03, 0.0])
    held.release(centre)
    assert lead.settings == before


def test_arrows_move_the_target_within_the_skin(held, lead, document, centre):
    held.key(Qt.Key.Key_Left)
    held.key(Qt.Key.Key_Up, SHIFT)
    np.testing.assert_allclose(target(lead), centre + [-STEP, FINE_STEP], atol=PIXEL)
    for _ in range(200):
        held.key(Qt.Key.Key_Left)
    assert document.map.to_body(target(lead)) is not None
    assert "The target cannot leave the skin" in lead.heard
    lead.undo()
    np.testing.assert_allclose(target(lead), centre, atol=PIXEL)


def test_delete_removes_the_target(held, lead):
    held.key(Qt.Key.Key_Delete)
    assert lead.settings.path == ()
    held.key(Qt.Key.Key_Delete)
    assert lead.heard == ["No path to clear"]


def test_caption_of_a_contact_at_the_target_is_next_to_the_plate(qtbot, lead, tool, painted_captions):
    fine = MapDocument.of(leaf_map())
    lead.show_map(fine.map)
    hand = MapViewDriver(qtbot, open_editor(InlineSceneJobs(), fine), tool, kind=PATH)
    taxel = middle_taxel(fine.map, 0)
    hand.click(fine.map.taxel_points[taxel])
    hand.view.show_frame(touched(fine.map, [taxel], radius=0.005))
    (caption,) = painted_captions(hand.view)
    plate = tool._plate._box
    assert not caption.intersects(plate)
    hand.view.set_view_tool(None)
    (alone,) = painted_captions(hand.view)
    assert alone.intersects(plate), "where it is without the plate"


def test_wheel_changes_the_force_on_the_plate_and_zooms_elsewhere(held, lead, tool, centre):
    at = plate(held, tool)
    turn_wheel(held.view.viewport(), at)
    assert lead.settings.force_goal == 3.5
    assert held.view.camera.zoom == 1.0
    for _ in range(4):
        turn_wheel(held.view.viewport(), at, -0.5)  # a fine wheel
    assert lead.settings.force_goal == 2.5
    lead.undo()
    assert lead.settings.force_goal == 3.0
    turn_wheel(held.view.viewport(), held.pixel(centre - [0.03, 0.0]))
    assert held.view.camera.zoom > 1.0


def test_dragging_the_plate_up_increases_the_force_within_its_range(held, lead, tool):
    pixel = plate(held, tool).toPoint()
    viewport = held.view.viewport()
    QTest.mouseMove(viewport, pixel)
    assert viewport.cursor().shape() == Qt.CursorShape.SizeVerCursor
    QTest.mousePress(viewport, LEFT, NONE, pixel)
    QTest.mouseMove(viewport, pixel - QPoint(0, 24))
    assert lead.settings.force_goal == 4.5
    QTest.mouseMove(viewport, pixel + QPoint(0, 300))
    assert lead.settings.force_goal == 0.0
    held.key(Qt.Key.Key_Escape)
    assert lead.settings.force_goal == 3.0
    QTest.mouseRelease(viewport, LEFT, NONE, pixel)
    assert lead.settings.force_goal == 3.0


def test_page_keys_change_the_force(held, lead):
    held.key(Qt.Key.Key_PageUp)
    held.key(Qt.Key.Key_PageUp)
    held.key(Qt.Key.Key_PageDown)
    assert lead.settings.force_goal == 3.5


def test_force_is_rounded_to_steps(held, lead):
    lead.show_settings(replace(lead.settings, force_goal=3.3))
    held.key(Qt.Key.Key_PageUp)
    assert lead.settings.force_goal == 4.0


def test_target_cannot_be_set_without_an_arm(hand, lead, centre):
    lead.set_enabled(enabled=False)
    hand.click(centre)
    hand.key(Qt.Key.Key_PageUp)
    assert lead.asked == []
    assert hand.view.viewport().cursor().shape() == Qt.CursorShape.ArrowCursor
