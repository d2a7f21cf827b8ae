"""Editing in the whole window, step by step and as a random walk: whatever is done, the map stays whole."""

from __future__ import annotations

import gc
import os
import sys
import tempfile
from pathlib import Path
from typing import ClassVar

import numpy as np
import psutil
import pytest
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    initialize,
    invariant,
    precondition,
    rule,
    run_state_machine_as_test,
)
from PySide6.QtCore import QCoreApplication, QEvent, QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from tactile_maps.editing.arrange import move, rotate
from tactile_maps.editing.document import MapDocument
from tactile_maps.editing.document_file import load_document
from tactile_maps.editing.reflatten import set_lengths, set_method
from tactile_maps.flattening.bijectivity import flipped
from tactile_maps.flattening.methods import METHODS
from tactile_maps.maps.image_atlas import ImageSettings
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.recording.verify import verify
from tactile_maps.session.inputs import MapEdited
from tactile_maps.studies.study.work_precision import Setting
from tactile_widgets.common.settings import Settings
from tactile_widgets.common.tool_kinds import POKE, SELECT_BOX
from tactile_widgets.session.backends import INLINE
from tactile_widgets.tools.registry import ARRANGE, INTEREST, PINS, SEAMS
from tactile_widgets.window.main_window import MainWindow
from tests.widgets.support.window_driver import press_map, run

LEFT = Qt.MouseButton.LeftButton


@pytest.fixture
def window(window_again):
    """The document begins again with the window."""
    return window_again


def shift(document):
    return move(document, [0, 1, 2], (0.05, 0.02))


def shown(window):
    """The document that the map view draws."""
    return window.map_view.picture.document


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
    assert window.live.measurements._measuring[1] is window.editor.document.map.charts


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
    window.editor.do("Rotate", lambda document: rotate(document, [0], 0.5))
    run(window, 0.3)
    QTest.mouseRelease(window.map_view.viewport(), LEFT)
    window.action("record").trigger()
    edited = window.editor.document
    (file,) = (tmp_path / "recordings").glob("*.mcap")
    player = RecordingPlayer(file)
    assert verify(player).identical
    assert [name for _, name in player.edits()] == ["Move", "Undo: Move", "Rotate"]

    window.presenters.files.open_path(str(file))
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


def test_the_first_drag_can_be_taken_back_while_it_goes_on(window):
    window.presenters.view.set_tool(ARRANGE)
    undo = window.action("undo")
    editor = window.editor
    before = editor.document
    assert not undo.isEnabled()
    for done in (undo.trigger, editor.end):
        editor.begin("Move")
        assert undo.isEnabled()
        done()
        assert not editor.gesture
        assert not undo.isEnabled()
    assert editor.document is before


def test_undo_and_redo_say_what_they_would_do(window):
    assert not window.action("undo").isEnabled()
    window.editor.do("Move", shift)
    assert window.action("undo").iconText() == "Undo move"
    window.action("undo").trigger()
    assert not window.action("undo").isEnabled()
    assert window.action("redo").iconText() == "Redo move"
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
    assert window.editor.history.names[-1] == "Repack"
    window.editor.select([0])
    window.action("hide_patches").trigger()
    window.action("show_patches").trigger()
    assert all(patch.visible for patch in window.editor.document.patches)


def test_a_pin_is_put_in_by_key_where_the_pointer_is_or_at_the_selected_taxels(window):
    view = window.map_view
    window.presenters.view.set_tool(PINS)
    view.setFocus()
    QTest.mouseMove(view.viewport(), view.pixel_of(window.live.prepared.skin.taxel_point(70)).toPoint())
    QTest.keyClick(view, Qt.Key.Key_P)
    assert sum(len(patch.pins) for patch in window.editor.document.patches) == 1
    window.views.selection.select_all()
    window.views.selection.invert()
    window.presenters.view.set_tool(SELECT_BOX)
    QTest.mouseClick(view.viewport(), LEFT, pos=view.pixel_of(window.live.prepared.skin.taxel_point(20)).toPoint())
    QTest.keyClick(view, Qt.Key.Key_P)
    assert sum(len(patch.pins) for patch in window.editor.document.patches) == 2
    QTest.keyClick(view, Qt.Key.Key_P, Qt.KeyboardModifier.ShiftModifier)
    QTest.keyClick(view, Qt.Key.Key_P, Qt.KeyboardModifier.AltModifier)
    assert sum(len(patch.pins) for patch in window.editor.document.patches) == 0


def test_a_seam_is_proposed_with_the_tool_that_shows_it_and_enter_accepts(window):
    window.editor.select([1])
    window.action("propose_seam").trigger()
    assert window.views.tool is SEAMS
    assert window.editor.proposal is not None
    assert "less distortion" in window.presenters.map_edit._seams._words()
    QTest.keyClick(window.map_view, Qt.Key.Key_Return)
    assert window.editor.history.names[-1] == "Accept a seam"


def test_tools_say_what_they_do(window):
    for tool in (ARRANGE, PINS, SEAMS, INTEREST):
        window.action(tool.name).trigger()
        assert window.statusBar().currentMessage()
    window.action("poke").trigger()
    assert not window.statusBar().currentMessage()


def test_select_all_means_patches_while_a_tool_edits(window):
    window.presenters.view.set_tool(ARRANGE)
    window.action("select_all").trigger()
    assert window.editor.selected == (0, 1, 2)
    assert not len(window.views.selection.taxels)
    window.action("select_none").trigger()
    assert window.editor.selected == ()


def test_a_point_of_the_accuracy_panel_is_taken(window):
    accuracy = window.column["accuracy"]
    accuracy.chosen.emit(Setting("flatten", "lscm", {}, (1,)))
    assert window.editor.document.charts[1].method == "lscm"
    accuracy.chosen.emit(Setting("image", "nearest", {"pixels": 128}))
    assert window.map_view.picture.atlas.look == ImageSettings("nearest", 128)
    run(window, 0.1)


def test_hovering_marks_the_patch_in_the_panel_and_back(window):
    view = window.map_view
    pixel = view.pixel_of(window.live.prepared.skin.taxel_point(70)).toPoint()
    QTest.mouseMove(view.viewport(), pixel)
    patch = int(window.live.prepared.skin.patch_of[70])
    window.presenters.view.set_tool(ARRANGE)
    window.column["patches"].hovered.emit(patch)
    pointed = view.grab().toImage()
    window.column["patches"].hovered.emit(None)
    QTest.mouseMove(view.viewport(), QPoint(2, 2))
    QApplication.processEvents()
    assert view.grab().toImage() != pointed


def test_a_refused_edit_is_said_in_the_message_bar(window):
    window.editor.do("Move", lambda document: move(document, [0], (1e9, 0.0)))
    assert "too far from the origin" in window.notification_bar.text


ACTS = int(os.environ.get("TACTILE_MAPS_EDITS", "80"))
A_ROUND = 40
_LEFT = Qt.MouseButton.LeftButton

taxels = st.integers(0, 149)
several = st.sets(st.integers(0, 2), min_size=1)
steps = st.tuples(st.integers(-150, 150), st.integers(-150, 150))
simple = st.sampled_from(
    ("mirror", "true_size", "repack", "hide_patches", "show_patches", "align_left", "align_middle", "add_pin",
     "remove_pin", "select_pins", "undo", "redo", "save_map", "cancel_edit")
)  # fmt: skip


class RestlessPerson(RuleBasedStateMachine):
    """Acts on a real window; every one of them must leave it whole."""

    prepared = None
    done = 0
    memory: ClassVar[list[float]] = []

    @initialize()
    def open(self):
        self.folder = tempfile.TemporaryDirectory()
        self.window = MainWindow(Settings(Path(self.folder.name) / "window.ini"), backends=INLINE)
        self.window.resize(1100, 700)
        self.window.show()
        self.window.live.show_prepared(self.prepared)
        self.window.presenters.map_files._file.path = Path(self.folder.name) / "map.npz"
        self.editor = self.window.editor
        self.view = self.window.map_view
        self.first = self.editor.document
        self.failures = []
        self.window.live.halted.connect(self.failures.append)
        QApplication.processEvents()

    def teardown(self):
        if not hasattr(self, "window"):
            return
        self.editor.cancel()
        if len(self.editor.history.names) <= 1000:
            self.editor.go(0)
            assert self.editor.document.layout == MapDocument.of(self.prepared.map).layout
            assert self.editor.document is self.first
        self.window.presenters.map_files.give_up()
        self.window.close()
        self.window.deleteLater()
        self.folder.cleanup()
        QCoreApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete.value)
        QApplication.processEvents()
        del self.window, self.editor, self.view, self.first
        gc.collect()
        type(self).memory.append(psutil.Process().memory_info().rss / 2**20)

    def pixel(self, taxel):
        return self.view.pixel_of(self.prepared.skin.taxel_point(taxel)).toPoint()

    def drag(self, start, by, *, drop=False):
        """Press, move in three steps, then lift, or give up by Escape."""
        viewport = self.view.viewport()
        QTest.mousePress(viewport, _LEFT, pos=start)
        for share in (0.3, 0.7, 1.0):
            QTest.mouseMove(viewport, start + QPoint(round(share * by[0]), round(share * by[1])))
        if drop:
            QTest.keyClick(self.view, Qt.Key.Key_Escape)
        QTest.mouseRelease(viewport, _LEFT, pos=start + QPoint(*by))

    @rule(
        tool=st.sampled_from([ARRANGE, PINS, SEAMS, INTEREST]),
        taxel=taxels,
        by=steps,
        drop=st.booleans(),
    )
    def drags(self, tool, taxel, by, drop):
        self.window.presenters.view.set_tool(tool)
        self.drag(self.pixel(taxel), by, drop=drop)

    @rule(tool=st.sampled_from([ARRANGE, PINS, SEAMS, INTEREST]), taxel=taxels)
    def clicks(self, tool, taxel):
        self.window.presenters.view.set_tool(tool)
        QTest.mouseClick(self.view.viewport(), _LEFT, pos=self.pixel(taxel))

    @rule(chosen=several, name=simple)
    def commands(self, chosen, name):
        self.editor.select(chosen)
        self.window.action(name).trigger()

    @rule(chosen=several, method=st.sampled_from(sorted(METHODS)))
    def lays_flat(self, chosen, method):
        self.editor.ask(lambda document: set_method(document, chosen, method))

    @rule(patch=st.integers(0, 2), lengths=st.floats(0, 1))
    def slides(self, patch, lengths):
        self.editor.ask(lambda document: set_lengths(document, [patch], lengths))

    @rule(accept=st.booleans())
    def proposes(self, accept):
        self.window.action("propose_seam").trigger()
        self.editor.accept() if accept else self.editor.decline()

    @rule(share=st.floats(0, 1))
    def goes_back(self, share):
        self.editor.go(round(share * (len(self.editor.history.names) - 1)))

    @precondition(lambda self: self.window.presenters.map_files.path.exists())
    @rule()
    def reloads(self):
        saved = load_document(self.window.presenters.map_files.path)
        assert self.window.presenters.map_files.open(str(self.window.presenters.map_files.path))
        assert self.editor.document.layout == saved.layout
        for one, other in zip(self.editor.document.charts, saved.charts, strict=True):
            assert np.array_equal(one.plane, other.plane)

    @rule(taxel=taxels)
    def pokes(self, taxel):
        self.window.presenters.view.set_tool(POKE)
        QTest.mousePress(self.view.viewport(), _LEFT, pos=self.pixel(taxel))
        self.window.live.runner.run_for(0.04)
        self.window.live.pump()
        QTest.mouseRelease(self.view.viewport(), _LEFT, pos=self.pixel(taxel))

    @rule(width=st.integers(900, 1500), height=st.integers(500, 1000))
    def resizes(self, width, height):
        self.window.resize(width, height)
        QApplication.processEvents()

    @invariant()
    def whole(self):
        if not hasattr(self, "window"):
            return
        type(self).done += 1
        document = self.editor.document
        assert not self.editor.gesture, "no hand is left holding"
        assert not self.failures
        for chart in document.charts:
            assert not flipped(chart.plane, chart.faces).any()
        self.window.live.runner.run_for(0.01)
        assert self.window.live.runner.session.map is document.map, "touch goes on on the map that is shown"
        self.window.live.pump()
        self.view.viewport().repaint()


@pytest.mark.filterwarnings("error")
def test_whatever_a_restless_person_does_the_map_stays_whole(prepared, qapp, tmp_path, monkeypatch):
    monkeypatch.setattr(
        "tactile_widgets.presenters.maps.map_file_presenter.user_state_path",
        lambda *_args, **_kwargs: tmp_path / "state",
    )
    RestlessPerson.prepared = prepared
    RestlessPerson.done = 0
    run_state_machine_as_test(
        RestlessPerson,
        settings=settings(
            max_examples=max(ACTS // A_ROUND, 1),
            stateful_step_count=A_ROUND,
            deadline=None,
            derandomize=True,
            database=None,
            suppress_health_check=list(HealthCheck),
        ),
    )
    if ACTS > 1000:
        first = RestlessPerson.memory[3]
        last = RestlessPerson.memory[-1]
        sys.stderr.write(f"\n{RestlessPerson.done} acts, {first:.0f} MB after 4 windows, {last:.0f} MB in the end\n")
    assert RestlessPerson.done >= 0.5 * ACTS
