"""Editing in the whole window: from menu, panel or tool to the document, and on to touch, views and recordings."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from app.editing.arrange import move, rotate
from app.experiments.work_precision import Setting
from app.recording.player import Player
from app.recording.verify import verify
from app.session.inputs import MapEdited
from tests.widgets.window_acts import press_map, run
from widgets.map_view.atlas import ImageLook
from widgets.tools import Tool

LEFT = Qt.MouseButton.LeftButton


def shift(document):
    return move(document, [0, 1, 2], (0.05, 0.02))


def shown(window):
    """The document that the map view draws."""
    return window.map_view._picture.document


def test_touch_goes_on_on_the_edited_map(window):
    press_map(window, 70)
    run(window, 0.4)
    before = window.live.runner.session.frame.regions[0]
    window.editor.do("Move", shift)
    run(window, 0.1)
    after = window.live.runner.session.frame.regions[0]
    assert after.id == before.id, "the contact is still the same one"
    assert window.live.runner.session.map is window.editor.document.map
    assert np.allclose(after.map_point, window.editor.document.map.to_map(after.at), atol=1e-12)
    assert window.live.measurer._newest is window.editor.document.map


def test_a_gesture_reaches_the_session_once_when_it_is_done(window):
    session = window.live.runner.session
    window.editor.begin("Move")
    for step in range(5):
        window.editor.change(lambda document, step=step: move(document, [1], (0.01 * step, 0.0)))
        run(window, 0.05)
    assert not [act for _, act in session.inputs if isinstance(act, MapEdited)]
    window.editor.end()
    run(window, 0.05)
    assert [act.name for _, act in session.inputs if isinstance(act, MapEdited)] == ["Move"]


def test_a_recording_notes_edits_replays_them_and_is_verified(window, tmp_path):
    press_map(window, 70)
    run(window, 0.2)
    window.action("record").trigger()
    run(window, 0.3)
    first = window.editor.document.layout
    window.editor.do("Move", shift)
    run(window, 0.3)
    window.action("undo").trigger()
    window.editor.do("Turn", lambda document: rotate(document, [0], 0.5))
    run(window, 0.3)
    QTest.mouseRelease(window.map_view.viewport(), LEFT)
    window.action("record").trigger()
    edited = window.editor.document
    (file,) = (tmp_path / "recordings").glob("*.mcap")
    player = Player(file)
    assert verify(player).identical
    assert [name for _, name in player.edits()] == ["Move", "Undo: Move", "Turn"]

    window.commands.open_path(str(file))
    assert not window.action("arrange").isEnabled(), "a replay is looked at, not edited"
    assert not window.editor.do("Move", shift)
    for seconds, layout in ((0.1, first), (0.3, shift_layout(player, 1)), (0.5, edited.layout)):
        window.timeline.scrubbed.emit(seconds)
        assert shown(window).layout == layout
    window.timeline.scrubbed.emit(0.1)
    assert shown(window).layout == first
    window.timeline.live_requested.emit()
    assert shown(window) is edited
    assert window.action("arrange").isEnabled()


def shift_layout(player, number):
    """The layout after so many edits of the recording."""
    edits = [act for _, act in player.inputs if isinstance(act, MapEdited)]
    return edits[number - 1].map.layout


def test_undo_and_redo_say_what_they_would_do(window):
    assert not window.action("undo").isEnabled()
    window.editor.do("Move", shift)
    assert window.action("undo").text() == "Undo move"
    window.action("undo").trigger()
    assert not window.action("undo").isEnabled()
    assert window.action("redo").text() == "Redo move"
    QTest.keyClick(window, Qt.Key.Key_Z, Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.ShiftModifier)
    assert window.editor.history.position == 1


@pytest.mark.parametrize(
    ("name", "step"),
    [("mirror", "Mirror"), ("align_left", "Align"), ("align_middle", "Align"), ("hide_patches", "Hide patches")],
)
def test_the_edit_menu_edits_the_selected_patches(window, name, step):
    assert not window.action(name).isEnabled(), "nothing is selected"
    window.editor.select([0, 2])
    window.action(name).trigger()
    assert window.editor.history.names[-1] == step
    assert shown(window) is window.editor.document


def test_patches_are_packed_drawn_true_and_shown_again(window):
    window.editor.do("Away", lambda document: move(document, [0], (0.3, 0.3)))
    window.action("repack").trigger()
    assert window.editor.history.names[-1] == "Pack again"
    window.editor.select([0])
    window.action("hide_patches").trigger()
    window.action("show_patches").trigger()
    assert all(patch.visible for patch in window.editor.document.patches)


def test_a_pin_is_put_in_by_key_where_the_pointer_is_or_at_the_selected_taxels(window):
    view = window.map_view
    window.seeing.set_tool(Tool.PINS)
    view.setFocus()
    QTest.mouseMove(view.viewport(), view.pixel_of(window.live.prepared.skin.taxel_point(70)).toPoint())
    QTest.keyClick(view, Qt.Key.Key_P)
    assert sum(len(patch.pins) for patch in window.editor.document.patches) == 1
    window.views.selection.select_all()
    window.views.selection.invert()
    window.seeing.set_tool(Tool.BOX)
    QTest.mouseClick(view.viewport(), LEFT, pos=view.pixel_of(window.live.prepared.skin.taxel_point(20)).toPoint())
    QTest.keyClick(view, Qt.Key.Key_P)
    assert sum(len(patch.pins) for patch in window.editor.document.patches) == 2
    QTest.keyClick(view, Qt.Key.Key_P, Qt.KeyboardModifier.ShiftModifier)
    QTest.keyClick(view, Qt.Key.Key_P, Qt.KeyboardModifier.AltModifier)
    assert sum(len(patch.pins) for patch in window.editor.document.patches) == 0


def test_a_seam_is_proposed_with_the_tool_that_shows_it_and_enter_accepts(window):
    window.editor.select([1])
    window.action("propose_seam").trigger()
    assert window.views.tool is Tool.SEAMS
    assert window.editor.proposal is not None
    assert "less distortion" in window.editing._seams._words()
    QTest.keyClick(window.map_view, Qt.Key.Key_Return)
    assert window.editor.history.names[-1] == "Accept a seam"


def test_tools_say_what_they_do(window):
    for tool in (Tool.ARRANGE, Tool.PINS, Tool.SEAMS, Tool.INTEREST):
        window.action(tool.value).trigger()
        assert window.statusBar().currentMessage()
    window.action("poke").trigger()
    assert not window.statusBar().currentMessage()


def test_select_all_means_patches_while_a_tool_edits(window):
    window.seeing.set_tool(Tool.ARRANGE)
    window.action("select_all").trigger()
    assert window.editor.selected == (0, 1, 2)
    assert not len(window.views.selection.taxels)
    window.action("select_none").trigger()
    assert window.editor.selected == ()


def test_a_point_of_the_accuracy_panel_is_taken(window):
    accuracy = window.column.accuracy
    accuracy.chosen.emit(Setting("flatten", "lscm", {}, (1,)))
    assert window.editor.document.charts[1].method == "lscm"
    accuracy.chosen.emit(Setting("image", "nearest", {"pixels": 128}))
    assert window.map_view._picture._atlas.look == ImageLook("nearest", 128)
    run(window, 0.1)


def test_hovering_marks_the_patch_in_the_panel_and_back(window):
    view = window.map_view
    pixel = view.pixel_of(window.live.prepared.skin.taxel_point(70)).toPoint()
    QTest.mouseMove(view.viewport(), pixel)
    patch = int(window.live.prepared.skin.patch_of[70])
    window.seeing.set_tool(Tool.ARRANGE)
    window.column.patches.hovered.emit(patch)
    pointed = view.grab().toImage()
    window.column.patches.hovered.emit(None)
    QTest.mouseMove(view.viewport(), QPoint(2, 2))
    QApplication.processEvents()
    assert view.grab().toImage() != pointed


def test_a_refused_edit_is_said_in_the_message_bar(window):
    window.editor.do("Move", lambda document: move(document, [0], (1e9, 0.0)))
    assert "too far out" in window.message_bar.text
