"""Map edits in the real window: single edits, and random edits after which the map is still valid."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QAbstractSpinBox, QApplication, QInputDialog, QLabel, QToolButton

from tactile_maps.core.errors import counted
from tactile_maps.editing.arrange import move, rotate, scale
from tactile_maps.editing.document import show_patches
from tactile_maps.editing.document_file import load_document
from tactile_maps.editing.reflatten import set_lengths, set_method
from tactile_maps.flattening.bijectivity import flipped
from tactile_maps.flattening.methods import METHODS
from tactile_maps.maps.image_atlas import ImageSettings
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.recording.verify import verify
from tactile_maps.session.inputs import MapEdited
from tactile_maps.studies.study.work_precision import Setting
from tactile_maps.tactile.mechanics.half_space_stress import TAIL_SHARE
from tactile_widgets.common.tool_kinds import POKE, SELECT_BOX
from tactile_widgets.panels.maps.quality_panel import QualityPanel
from tactile_widgets.tools.registry import ARRANGE, INTEREST, PINS, SEAMS
from tests.widgets.support.mouse import left_click, left_press, left_release
from tests.widgets.support.snapshots import pixels
from tests.widgets.support.window_driver import click_remedy, press_map, run


@pytest.fixture
def window(window_again):
    """Window with the map of the scene, without edits."""
    return window_again


def shift(document):
    return move(document, [0, 1, 2], (0.05, 0.02))


def shown(window):
    """The document that the map view draws."""
    return window.map_view.picture.document


@pytest.mark.long
def test_contact_continues_on_the_edited_map(window):
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


@pytest.mark.long
def test_gesture_is_one_edit_of_the_session(window):
    session = window.live.runner.session
    window.editor.begin("Move")
    for step in range(5):
        window.editor.change(lambda document, step=step: move(document, [1], (0.01 * step, 0.0)))
        run(window, 0.05)
    assert not [act for _, act in session.inputs if isinstance(act, MapEdited)]
    window.editor.end()
    run(window, 0.05)
    assert [act.name for _, act in session.inputs if isinstance(act, MapEdited)] == ["Move"]


@pytest.mark.long
def test_quality_in_a_replay_is_that_of_the_map_shown(window, tmp_path):
    def shown_quality():
        window.show_quality()
        return window.context.panels.get(QualityPanel)._facts

    unedited = shown_quality()
    window.action("record").trigger()
    run(window, 0.1)
    window.editor.do("Scale", lambda document: scale(document, [0], 2.0))
    run(window, 0.1)
    window.action("record").trigger()
    edited = shown_quality()
    assert edited != unedited
    (file,) = (tmp_path / "recordings").glob("*.mcap")
    window.presenters.files.open_path(str(file))
    for seconds, quality in ((0.15, edited), (0.05, unedited)):
        window.timeline.scrubbed.emit(seconds)
        assert shown_quality() == quality
    window.timeline.live_requested.emit()
    assert shown_quality() == edited


@pytest.mark.long
def test_recorded_edits_are_replayed_and_verified(window, tmp_path):
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
    left_release(window.map_view.viewport())
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


@pytest.mark.long
def test_first_drag_can_be_undone_while_it_continues(window):
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


@pytest.mark.long
def test_undo_and_redo_name_their_step(window):
    assert not window.action("undo").isEnabled()
    window.editor.do("Move", shift)
    assert window.action("undo").iconText() == "Undo move"
    window.action("undo").trigger()
    assert not window.action("undo").isEnabled()
    assert window.action("redo").iconText() == "Redo move"
    QTest.keyClick(window, Qt.Key.Key_Z, Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.ShiftModifier)
    assert window.editor.history.position == 1


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "step"),
    [
        ("mirror", "Mirror"),
        ("align_left", "Align left"),
        ("align_middle", "Align middle"),
        ("hide_patches", "Hide patches"),
    ],
)
def test_menu_edits_the_selected_patches(window, name, step):
    assert not window.action(name).isEnabled(), "nothing is selected"
    window.editor.select([0, 2])
    window.action(name).trigger()
    assert window.editor.history.names[-1] == step
    assert shown(window) is window.editor.document


def test_patches_are_repacked_hidden_and_shown(window):
    window.editor.do("Away", lambda document: move(document, [0], (0.3, 0.3)))
    window.action("repack").trigger()
    assert window.editor.history.names[-1] == "Repack"
    window.editor.select([0])
    window.action("hide_patches").trigger()
    window.action("show_patches").trigger()
    assert all(patch.visible for patch in window.editor.document.patches)


def test_repack_that_moves_nothing_states_why_and_offers_to_arrange_all_patches(window):
    editor = window.editor
    arranged = editor.document.layout
    names = [patch.name for patch in editor.document.patches]
    editor.do("Move", lambda document: move(document, [0, 1], (3.0, 0.0)))
    editor.select([0])
    window.action("repack").trigger()
    assert editor.history.names == ("Open", "Move")
    assert window.notification_bar.text == f"{names[0]} stays in place: it overlaps no other patch."
    editor.select([0, 1])
    window.action("repack").trigger()
    assert editor.history.names == ("Open", "Move", "Repack")
    window.action("repack").trigger()
    assert editor.history.names == ("Open", "Move", "Repack")
    assert window.notification_bar.text.startswith("The selected patches stay in place")
    click_remedy(window, "Repack all")
    assert editor.history.names == ("Open", "Move", "Repack", "Repack")
    for placed, before in zip(editor.document.layout.placements, arranged.placements, strict=True):
        assert placed.offset == pytest.approx(before.offset)
    editor.select([])
    window.action("repack").trigger()
    assert len(editor.history.names) == 4
    assert window.notification_bar.text == "The patches are already arranged as on the body."


def test_map_states_that_all_patches_are_hidden_and_how_to_show_them(window):
    def middle():
        picture = pixels(window.map_view.viewport().grab().toImage())
        rows, columns = picture.shape[:2]
        return picture[rows // 2 - 20 : rows // 2 + 20, columns // 4 : 3 * columns // 4]

    window.presenters.view.set_tool(ARRANGE)
    window.map_view.setFocus()
    QTest.keyClick(window.map_view, Qt.Key.Key_A)
    QTest.keyClick(window.map_view, Qt.Key.Key_H)
    assert not any(patch.visible for patch in shown(window).patches)
    written = middle()
    inked = np.any(written != written[0, 0], axis=-1)
    assert inked.any(axis=1).sum() > 15, "two lines of text"
    assert inked.any(axis=0).sum() > 100
    QTest.keyClick(window.map_view, Qt.Key.Key_H, Qt.KeyboardModifier.AltModifier)
    everything = middle()
    assert all(patch.visible for patch in shown(window).patches)
    window.editor.undo()
    assert np.array_equal(middle(), written)
    for number in range(len(shown(window).patches)):
        window.editor.do("Show", lambda document, number=number: show_patches(document, [number]))
    assert np.array_equal(middle(), everything), "the text is gone"


@pytest.mark.long
def test_pin_key_pins_the_pointer_position_or_the_selected_taxels(window):
    view = window.map_view
    window.presenters.view.set_tool(PINS)
    view.setFocus()
    QTest.mouseMove(view.viewport(), view.pixel_of(window.live.prepared.skin.taxel_point(70)).toPoint())
    QTest.keyClick(view, Qt.Key.Key_P)
    assert sum(len(patch.pins) for patch in window.editor.document.patches) == 1
    window.views.selection.select_all()
    window.views.selection.invert()
    window.presenters.view.set_tool(SELECT_BOX)
    left_click(view.viewport(), view.pixel_of(window.live.prepared.skin.taxel_point(20)).toPoint())
    QTest.keyClick(view, Qt.Key.Key_P)
    assert sum(len(patch.pins) for patch in window.editor.document.patches) == 2
    QTest.keyClick(view, Qt.Key.Key_P, Qt.KeyboardModifier.ShiftModifier)
    QTest.keyClick(view, Qt.Key.Key_P, Qt.KeyboardModifier.AltModifier)
    assert sum(len(patch.pins) for patch in window.editor.document.patches) == 0


@pytest.mark.parametrize(
    ("key", "button", "last"),
    [
        (Qt.Key.Key_Return, "proposal-accept", "Accept a seam"),
        pytest.param(Qt.Key.Key_Escape, "proposal-decline", "Open", marks=pytest.mark.long),
    ],
)
def test_proposed_seam_is_accepted_or_declined_wherever_the_focus_is(window, key, button, last):
    bar = window.presenters.map_edit.proposal
    focused = (
        window.map_view,
        window.robot_view,
        window.column["controller"].findChild(QAbstractSpinBox),
        window.session_bar.findChild(QToolButton),
    )
    for focus in (*focused, None):
        window.editor.select([1])
        window.action("propose_seam").trigger()
        assert window.views.tool is SEAMS
        window.presenters.view.set_tool(POKE)
        assert "less distortion" in bar.text
        if focus is None:
            left_click(bar.findChild(QToolButton, button))
        else:
            focus.setFocus()
            QTest.keyClick(focus, key)
        assert bar.text == ""
        assert window.editor.proposal is None
        assert window.editor.history.names[-1] == last
        if window.editor.history.position:
            window.editor.undo()


def test_proposal_leaves_keys_to_dialogs(window):
    window.action("propose_seam").trigger()
    window.context.dialogs.ask_text("name", "Name", "Name", lambda _text: None)
    (dialog,) = window.findChildren(QInputDialog)
    QTest.keyClick(dialog, Qt.Key.Key_Escape)
    assert not dialog.isVisible()
    assert window.editor.proposal is not None
    window.editor.decline()


@pytest.mark.long
def test_tool_shows_its_hint_in_the_status_line(window):
    for tool in (ARRANGE, PINS, SEAMS, INTEREST):
        window.action(tool.name).trigger()
        assert window.statusBar().currentMessage()
    window.action("poke").trigger()
    assert not window.statusBar().currentMessage()


def test_select_all_selects_patches_while_an_editing_tool_is_used(window):
    window.presenters.view.set_tool(ARRANGE)
    window.action("select_all").trigger()
    assert window.editor.selected == (0, 1, 2)
    assert not len(window.views.selection.taxels)
    window.action("select_none").trigger()
    assert window.editor.selected == ()


def test_setting_of_the_accuracy_panel_is_applied(window):
    accuracy = window.column["accuracy"]
    accuracy.chosen.emit(Setting("flatten", "lscm", {}, (1,)))
    assert window.editor.document.charts[1].method == "lscm"
    accuracy.chosen.emit(Setting("image", "nearest", {"pixels": 128}))
    assert window.map_view.picture.atlas.look == ImageSettings("nearest", 128)
    touch = Setting("touch", "half-space", {"share": TAIL_SHARE})
    accuracy.chosen.emit(touch)
    run(window, 0.1)
    assert window.live.runner.session.effects.skin == "half-space"
    assert accuracy._present["touch"] == touch


@pytest.mark.long
def test_patch_hovered_in_the_panel_is_marked_on_the_map(window):
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


def test_rejected_edit_shows_a_message(window):
    window.editor.do("Move", lambda document: move(document, [0], (1e9, 0.0)))
    assert "too far from the origin" in window.notification_bar.text


TOOLS = (ARRANGE, PINS, SEAMS, INTEREST)
COMMANDS = (
    "mirror",
    "true_size",
    "repack",
    "hide_patches",
    "show_patches",
    "align_left",
    "align_middle",
    "add_pin",
    "remove_pin",
    "select_pins",
    "undo",
    "redo",
    "save",
    "cancel_edit",
)


class RandomEditor:
    """Random edits of the map in a window, by gestures, actions and panels."""

    def __init__(self, window, seed):
        self.rng = np.random.default_rng(seed)
        self.window = window
        self.editor = window.editor
        self.files = window.presenters.map_files
        self.acts = (self.drag, self.drag, self.run_command, self.flatten, self.propose_seam, self.go, self.reload)

    def choose(self, options):
        return options[self.rng.integers(len(options))]

    def drag(self):
        """Drag with an editing tool, or cancel by Escape."""
        view = self.window.map_view
        self.window.presenters.view.set_tool(self.choose(TOOLS))
        start = view.pixel_of(self.window.live.prepared.skin.taxel_point(int(self.rng.integers(150)))).toPoint()
        way = QPoint(*self.rng.integers(-150, 151, 2).tolist()) * self.choose((0.0, 1.0, 1.0))
        left_press(view.viewport(), start)
        for share in (0.3, 0.7, 1.0):
            QTest.mouseMove(view.viewport(), start + way * share)
        if self.choose((True, False, False)):
            QTest.keyClick(view, Qt.Key.Key_Escape)
        left_release(view.viewport(), start + way)

    def run_command(self):
        self.editor.select(self.rng.permutation(3)[: self.rng.integers(1, 4)].tolist())
        self.window.action(self.choose(COMMANDS)).trigger()

    def flatten(self):
        method = self.choose(sorted(METHODS))
        self.editor.ask(lambda document: set_method(document, [int(self.rng.integers(3))], method))
        self.editor.ask(lambda document: set_lengths(document, [1], self.rng.random()))

    def propose_seam(self):
        self.window.action("propose_seam").trigger()
        self.choose((self.editor.accept, self.editor.decline))()

    def go(self):
        self.editor.go(int(self.rng.integers(len(self.editor.history.names))))

    def reload(self):
        if self.files.path.exists():
            saved = load_document(self.files.path)
            assert self.files.open(str(self.files.path))
            assert self.editor.document.layout == saved.layout
            for one, other in zip(self.editor.document.charts, saved.charts, strict=True):
                assert np.array_equal(one.plane, other.plane)


@pytest.mark.long
@pytest.mark.parametrize("count", [20, pytest.param(80, marks=pytest.mark.long)])
def test_random_edits_keep_the_map_valid_and_can_all_be_undone(window, tmp_path, count):
    user = RandomEditor(window, 3)
    editor = user.editor
    first = editor.document
    user.files._file.path = tmp_path / "map.npz"
    for _ in range(count):
        user.choose(user.acts)()
        assert not editor.gesture
        assert not any(flipped(chart.plane, chart.faces).any() for chart in editor.document.charts)
        window.live.runner.run_for(0.01)
        assert window.live.runner.session.map is editor.document.map
        window.live.pump()
    assert len(editor.history.names) > count / 8
    editor.cancel()
    editor.go(0)
    assert editor.document is first


def test_overlapping_patches_are_named_and_repack_is_offered(window):
    names = [patch.name for patch in window.editor.document.patches]
    apart = window.editor.document.map
    centre = [apart.layout.placements[number].apply(apart.charts[number].plane).mean(axis=0) for number in (0, 1)]
    window.editor.do("Move", lambda document: move(document, [1], tuple(centre[0] - centre[1])))
    text = window.notification_bar.text
    assert names[0] in text
    assert names[1] in text
    assert names[2] not in text
    window.show_quality()
    count = len(window.map_view.picture._flaws.overlaps)
    assert window.map_view.picture.legend.flaws[0] == (
        f"0 flipped triangles, {counted(count, 'overlap')} ({names[0]}, {names[1]})"
    )
    card = window.column.get(QualityPanel).findChild(QLabel, "quality-note").text()
    assert card == f"Not bijective: 0 flipped triangles, {counted(count, 'overlap')}."
    (button,) = [
        button
        for button in window.notification_bar.findChildren(QToolButton)
        if button.objectName() == "message-remedy"
    ]
    left_click(button)
    assert window.map_view.picture.overlapping == ()
    assert not any(message.fault for message in window.notification_bar.messages)
