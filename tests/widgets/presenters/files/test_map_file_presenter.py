"""Map files in the window: saving, opening, export, autosave, recovery after a crash, and questions."""

from __future__ import annotations

import pickle
import threading
from dataclasses import replace

import numpy as np
import pytest
from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QApplication, QComboBox, QMessageBox

from tactile_maps.editing.arrange import move, rotate
from tactile_maps.editing.document_file import DocumentFile, load_document, save_document
from tactile_maps.maps.formats.map_file import save_map
from tactile_maps.recording.player import open_recording
from tactile_maps.scene.scene_file import load_scene
from tactile_maps.studies.testbeds.reference_bodies import flat_map
from tactile_widgets.common.file_dialogs import FileDialog
from tactile_widgets.common.settings import Settings
from tactile_widgets.session.backends import INLINE
from tactile_widgets.window.main_window import MainWindow
from tests.support.special_files import is_special, make_special_file, special_kinds
from tests.widgets.support.window_driver import answer, click_remedy, replay_run, run


@pytest.fixture
def window(window_again):
    """Window without a map file; a test that closes the window uses ``new_window``."""
    return window_again


@pytest.fixture
def files(window):
    """File presenter of a window with one unsaved edit."""
    return edited(window).presenters.map_files


def edited(window):
    """Make one unsaved edit and return the window."""
    assert not window.presenters.map_files.unsaved
    window.editor.do("Rotate", lambda document: rotate(document, [1], 0.5))
    return window


def message(window):
    """Return the text of the message bar."""
    return window.notification_bar.text


def test_edit_is_unsaved_until_saved_or_undone(window, files, tmp_path, choose_file):
    assert files.unsaved
    assert window.isWindowModified()
    window.editor.undo()
    assert not files.unsaved
    window.editor.redo()
    chosen = tmp_path / "my map"
    choose_file("save_file", chosen)
    window.action("save").trigger()
    assert not files.unsaved
    assert not window.isWindowModified()
    assert files.path == tmp_path / "my map.npz"
    assert "my map.npz" in window.windowTitle()
    saved = load_document(files.path)
    present = window.editor.document
    assert saved.layout == present.layout
    assert all(np.array_equal(a.plane, b.plane) for a, b in zip(saved.charts, present.charts, strict=True))


@pytest.mark.long
def test_second_save_uses_the_same_file(window, files, tmp_path, monkeypatch, choose_file):
    choose_file("save_file", tmp_path / "a.npz")
    window.action("save").trigger()
    monkeypatch.setattr(FileDialog, "save_file", lambda *_args: pytest.fail("asked again"))
    window.editor.do("Move", lambda document: move(document, [0], (0.1, 0.0)))
    window.action("save").trigger()
    assert not files.unsaved
    assert load_document(tmp_path / "a.npz").layout == window.editor.document.layout


@pytest.mark.long
@pytest.mark.parametrize("kind", special_kinds())
def test_special_file_is_not_replaced(window, files, tmp_path, choose_file, kind):
    path = make_special_file(kind, tmp_path / "a.npz")
    choose_file("save_file", path)
    window.editor.do("Move", lambda document: move(document, [0], (0.1, 0.0)))
    window.action("save_map_as").trigger()
    assert f"not a regular file (found: a {kind})" in window.notification_bar.text
    assert is_special(path)
    assert files.unsaved


def test_failed_saving_shows_a_message_and_the_map_stays_unsaved(window, files, tmp_path, choose_file):
    choose_file("save_file", tmp_path / "none" / "a.npz")
    window.action("save").trigger()
    assert files.unsaved
    assert "cannot be written" in message(window)


@pytest.mark.long
def test_saved_map_is_opened_as_one_edit(window, files, tmp_path):
    turned = window.editor.document
    save_document(turned, tmp_path / "turned.npz")
    window.editor.undo()
    first = window.editor.document
    window.presenters.files.open_path(str(tmp_path / "turned.npz"))
    assert window.editor.document.layout == turned.layout
    assert window.editor.history.names[-1] == "Open turned.npz"
    assert files.path == tmp_path / "turned.npz"
    assert not files.unsaved
    window.editor.undo()
    assert window.editor.document is first
    assert files.unsaved, "the file has the other layout"


@pytest.mark.parametrize("kind", ["another skin", "garbage", "missing"])
def test_map_of_another_skin_is_rejected(window, files, tmp_path, kind):
    path = tmp_path / "other.npz"
    present = window.editor.document
    if kind == "another skin":
        save_map(flat_map(30), path)
    elif kind == "garbage":
        path.write_bytes(b"no map")
    window.presenters.files.open_path(str(path))
    assert window.editor.document is present
    assert files.path is None
    assert message(window)


@pytest.mark.long
@pytest.mark.sampled(3)
@pytest.mark.parametrize("ending", [".obj", ".svg", ".csv", ".npz", ".png", ".xml"])
def test_map_is_exported_in_each_format(window, files, tmp_path, choose_file, ending):
    path = tmp_path / f"map{ending}"
    choose_file("save_file", path)
    window.action("export_map").trigger()
    assert path.stat().st_size > 1000
    assert files.unsaved, "an export is no save"


@pytest.mark.parametrize("ending", [".obj", ".svg", pytest.param(".npz", marks=pytest.mark.long)])
def test_exported_map_is_dropped_or_opened_as_one_edit(window, files, tmp_path, monkeypatch, ending):
    path = str(tmp_path / f"map{ending}")
    expected = window.editor.document.map.taxel_points
    files.export(path)
    window.editor.do("Move", lambda document: move(rotate(document, [0], 1.0), [0, 1], (0.4, 0.1)))
    moved = window.editor.document
    assert not np.allclose(moved.map.taxel_points, expected, atol=1e-3)
    window.presenters.files.open_path(path)
    np.testing.assert_allclose(window.editor.document.map.taxel_points, expected, atol=5e-6)
    assert window.editor.history.names[window.editor.history.position] == f"Open map{ending}"
    window.editor.undo()
    assert window.editor.document is moved
    monkeypatch.setattr(FileDialog, "open_file", lambda *_args: path)
    window.action("open_map").trigger()
    np.testing.assert_allclose(window.editor.document.map.taxel_points, expected, atol=5e-6)


@pytest.mark.parametrize(
    ("name", "text", "missing"),
    [
        ("foreign.svg", "<svg xmlns='http://www.w3.org/2000/svg'><circle id='a' cx='1' cy='2'/></svg>", "taxel-0"),
        ("foreign.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "texture coordinate"),
    ],
)
def test_file_of_another_program_gives_one_message_about_missing_data(window, files, tmp_path, name, text, missing):
    before = window.editor.document
    (tmp_path / name).write_text(text)
    assert not files.open(str(tmp_path / name))
    assert missing in message(window)
    assert name in message(window)
    assert window.editor.document is before


def test_export_in_an_unknown_format_is_rejected(window, files, tmp_path):
    files.export(str(tmp_path / "map.doc"))
    assert "Choose one of: .npz, .obj, .svg, .png, .json, .csv, .xml" in message(window)


def test_format_that_cannot_hold_the_skin_is_greyed_with_the_reason(window, files):
    entries = {}

    def read():
        box = QApplication.activeModalWidget().findChild(QComboBox, "fileTypeCombo")
        entries.update({box.itemText(row): box.model().item(row).isEnabled() for row in range(box.count())})
        QApplication.activeModalWidget().reject()

    QTimer.singleShot(0, read)
    window.action("export_map").trigger()
    links = len(window.live.prepared.skin.links)
    reason = f"only for a skin on one link, and this one is on {links}"
    assert [entry for entry, enabled in entries.items() if not enabled] == [
        f"JSON skin and map of Genoa (CySkin): {reason}"
    ]
    assert len(entries) == 7


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("taxels.csv", "x,y,z\n0,0,0\n", "this is a taxel file, not a map. Open it with File > Import taxels."),
        ("rows.csv", "level,seed\n1,0\n", "this is a study table, not a map. Open it with File > Open study table."),
        ("notes.doc", "", "this type of file is not a map (found: .doc). Choose one of: .npz, .obj, .svg."),
    ],
)
def test_open_map_states_what_another_file_is_and_where_it_is_opened(window, tmp_path, choose_file, name, text, said):
    (tmp_path / name).write_text(text)
    choose_file("open_file", tmp_path / name)
    window.action("open_map").trigger()
    assert message(window) == f"{tmp_path / name}: {said}"


def test_cancel_keeps_the_window_with_unsaved_edits_open(window, files):
    assert not window.close()
    assert window.isVisible()
    answer(window, QMessageBox.StandardButton.Cancel)
    assert window.isVisible()
    assert files.unsaved


@pytest.mark.long
def test_closing_saves_unsaved_edits(new_window, tmp_path, choose_file):
    window = edited(new_window)
    choose_file("save_file", tmp_path / "a.npz")
    layout = window.editor.document.layout
    window.close()
    answer(window, QMessageBox.StandardButton.Save)
    assert not window.isVisible()
    assert load_document(tmp_path / "a.npz").layout == layout


def test_cancelled_save_does_not_close_the_window(window, files, monkeypatch):
    monkeypatch.setattr(FileDialog, "save_file", lambda *_args: "")
    window.close()
    answer(window, QMessageBox.StandardButton.Save)
    assert window.isVisible()


@pytest.mark.long
def test_closing_discards_unsaved_edits(new_window):
    window = edited(new_window)
    window.close()
    answer(window, QMessageBox.StandardButton.Discard)
    assert not window.isVisible()


def test_discarded_edits_remain_if_the_scene_fails_to_open(window, files, tmp_path):
    present = window.editor.document
    window.presenters.files.open_scene(replace(load_scene("arm"), robot="no-such-robot"))
    answer(window, QMessageBox.StandardButton.Discard)
    assert "no-such-robot" in message(window)
    assert window.editor.document is present
    assert files.unsaved
    assert window.isWindowModified()
    files.autosave()
    files._wait()
    assert list((tmp_path / "state").rglob("*.autosave"))
    assert not window.close()
    answer(window, QMessageBox.StandardButton.Cancel)
    assert files._save(tmp_path / "kept.npz")
    assert load_document(tmp_path / "kept.npz").layout == present.layout


@pytest.mark.long
def test_discarded_edits_are_deleted_with_their_autosave(window, files, prepared, tmp_path):
    files.autosave()
    files._wait()
    assert list((tmp_path / "state").rglob("*.autosave"))
    files.leave(lambda: window.live.show_prepared(reopened(prepared)))
    answer(window, QMessageBox.StandardButton.Discard)
    assert not files.unsaved
    assert message(window) == ""
    assert not list((tmp_path / "state").rglob("*.autosave"))


def test_autosave_waits_for_the_end_of_a_gesture(window, files, tmp_path):
    window.editor.begin("Move")
    window.editor.change(lambda document: move(document, [0], (0.1, 0.0)))
    files.autosave()
    files._wait()
    assert not list((tmp_path / "state").rglob("*.autosave"))
    window.editor.end()
    files.autosave()
    files._wait()
    assert list((tmp_path / "state").rglob("*.autosave"))


def test_edits_are_restored_after_a_crash(window, files, prepared, tmp_path):
    files.autosave()
    files._wait()
    edited = window.editor.document
    window.live.show_prepared(reopened(prepared))  # as a new start of the program would
    assert window.editor.history.names == ("Open",)
    assert "not saved when the program ended" in message(window)
    files.autosave()
    window.action("restore_map").trigger()
    assert window.editor.document.layout == edited.layout
    assert window.editor.history.names == ("Open", "Restore")


@pytest.fixture
def left(window, files, prepared):
    """Document that a crash left; its map is shown again without edits."""
    files.autosave()
    files._wait()
    document = window.editor.document
    window.live.show_prepared(reopened(prepared))
    return document


def copies(tmp_path):
    """Autosaves on the disk."""
    return list((tmp_path / "state").rglob("*.autosave"))


@pytest.fixture
def release(files):
    """Function that ends an autosave that is being written meanwhile. The timer starts no other one."""
    files._timer.stop()
    ended = threading.Event()
    in_time = files._writer.submit(ended.wait, 60.0)
    files.autosave()
    yield ended.set
    ended.set()
    assert in_time.result(), "the window did not wait for it"
    files._timer.start()


def turn(window, number=0):
    """Make another unsaved edit; return the layout."""
    window.editor.do("Rotate", lambda document: rotate(document, [number], 0.25))
    return window.editor.document.layout


def test_edits_during_an_autosave_are_autosaved_right_after_it(window, files, release, tmp_path, qtbot):
    for number in (0, 1):
        latest = turn(window, number)
        files.autosave()
    assert copies(tmp_path) == []
    release()
    qtbot.waitUntil(lambda: [load_document(copy).layout for copy in copies(tmp_path)] == [latest])


def test_edits_during_an_autosave_are_kept_when_the_document_ends(window, files, release, prepared):
    latest = turn(window)
    files.autosave()
    release()
    window.live.show_prepared(reopened(prepared))
    click_remedy(window, "Restore edits")
    assert window.editor.document.layout == latest


def test_discarded_edits_are_not_autosaved_after_an_autosave_that_was_being_written(window, files, release, tmp_path):
    turn(window)
    files.autosave()
    release()
    files.give_up()
    assert copies(tmp_path) == []


def test_restored_copy_remains_until_another_one_is_written(window, files, left, release, tmp_path, qtbot):
    (before,) = copies(tmp_path)
    click_remedy(window, "Restore edits")
    assert window.editor.document.layout == left.layout
    assert copies(tmp_path) == [before]
    release()
    qtbot.waitUntil(lambda: before not in copies(tmp_path))
    (after,) = copies(tmp_path)
    assert load_document(after).layout == left.layout


def test_restored_copy_is_deleted_with_the_discarded_edits(window, files, left, release, tmp_path):
    click_remedy(window, "Restore edits")
    release()
    files.give_up()
    assert copies(tmp_path) == []
    assert message(window) == ""


@pytest.mark.long
def test_offer_to_restore_returns_after_other_messages(window, left):
    window.notifier.say("Something else")
    assert window.notification_bar.text == "Something else"
    click_remedy(window, "Dismiss")
    assert "not saved when the program ended" in window.notification_bar.text
    click_remedy(window, "Later")
    assert window.notification_bar.text == ""
    assert window.action("restore_map").isEnabled(), "still in the menu"
    click_menu = window.action("restore_map")
    click_menu.trigger()
    assert window.editor.document.layout == left.layout
    assert not window.action("restore_map").isEnabled()


@pytest.mark.long
def test_offer_to_restore_is_kept_while_another_scene_is_shown(window, left, prepared, small_arm, tmp_path):
    window.live.show_prepared(small_arm)
    assert window.notification_bar.text == "", "another skin of the same robot"
    assert not window.action("restore_map").isEnabled()
    window.editor.do("Rotate", lambda document: rotate(document, [1], 0.5))
    window.presenters.map_files.autosave()
    window.presenters.map_files.leave(lambda: window.live.show_prepared(reopened(prepared)))
    answer(window, QMessageBox.StandardButton.Discard)
    assert len(copies(tmp_path)) == 1
    click_remedy(window, "Restore edits")
    assert window.editor.document.layout == left.layout
    assert window.isWindowModified()


@pytest.mark.long
def test_offer_to_restore_is_hidden_during_a_replay(window, left, tmp_path):
    replay_run(window, tmp_path / "a.mcap", 0.1)
    assert "not saved when" not in window.notification_bar.text
    assert not window.action("restore_map").isEnabled()
    window.live.replay.leave()
    assert "not saved when" in window.notification_bar.text


@pytest.mark.long
def test_undecided_offer_returns_at_the_next_start(window, left, prepared, tmp_path):
    window.presenters.map_files.end()  # as closing does
    other = MainWindow(Settings(tmp_path / "other.ini"), backends=INLINE)
    other.live.show_prepared(reopened(prepared))
    assert "not saved when" in message(other)
    other.editor.do("Move", lambda document: move(document, [0], (0.05, 0.0)))
    other.presenters.map_files.autosave()
    other.presenters.map_files._wait()
    assert len(copies(tmp_path)) == 2, "newer edits do not replace it"
    other.presenters.map_files.give_up()
    other.close()
    other.deleteLater()
    assert len(copies(tmp_path)) == 1
    window.presenters.map_files.begin(prepared, window.editor.document)
    assert "not saved when" in message(window)
    window.action("restore_map").trigger()
    assert window.editor.document.layout == left.layout


def test_restoring_over_newer_edits_asks_first(window, left, tmp_path):
    window.editor.do("Move", lambda document: move(document, [0], (0.05, 0.0)))
    newer = window.editor.document
    click_remedy(window, "Restore edits")
    answer(window, QMessageBox.StandardButton.Cancel, "restore")
    assert window.editor.document is newer
    assert "not saved when" in message(window)
    click_remedy(window, "Restore edits")
    answer(window, QMessageBox.StandardButton.Yes, "restore")
    assert window.editor.document.layout == left.layout
    window.action("undo").trigger()
    assert window.editor.document is newer


@pytest.mark.long
def test_restored_autosave_is_replaced_by_a_new_one(window, files, left, tmp_path):
    (before,) = copies(tmp_path)
    click_remedy(window, "Restore edits")
    files._wait()
    (after,) = copies(tmp_path)
    assert after != before
    assert load_document(after).layout == left.layout


@pytest.mark.long
def test_discarding_an_autosave_asks_first(window, left, tmp_path):
    click_remedy(window, "Discard edits")
    answer(window, QMessageBox.StandardButton.Cancel, "discard")
    assert "not saved when" in message(window)
    assert copies(tmp_path)
    click_remedy(window, "Discard edits")
    answer(window, QMessageBox.StandardButton.Discard, "discard")
    assert message(window) == ""
    assert not copies(tmp_path)
    assert not window.action("restore_map").isEnabled()


@pytest.mark.long
def test_edits_of_a_saved_map_are_restored_after_a_crash(window, files, prepared, tmp_path, choose_file):
    path = tmp_path / "own.npz"
    choose_file("save_file", path)
    window.action("save").trigger()
    window.editor.do("Move", lambda document: move(document, [0], (0.05, 0.0)))
    layout = window.editor.document.layout
    files.autosave()
    files._wait()
    window.live.show_prepared(reopened(prepared))
    assert "own.npz has edits" in message(window)
    click_remedy(window, "Restore edits")
    assert files.path == path
    assert files.unsaved
    assert window.editor.document.layout == layout


@pytest.mark.long
def test_undone_edits_leave_no_autosave(window, files, prepared, tmp_path):
    files.autosave()
    files._wait()
    window.action("undo").trigger()
    files.leave(lambda: window.live.show_prepared(reopened(prepared)))
    assert message(window) == ""
    assert not copies(tmp_path)


@pytest.mark.long
def test_two_windows_use_separate_autosaves(window, files, prepared, tmp_path, qtbot):
    """The second neither offers what the first is working on, nor writes over it, nor removes it."""
    files.autosave()
    files._wait()
    (kept,) = (tmp_path / "state").rglob("*.autosave")
    content = kept.read_bytes()
    other = MainWindow(Settings(tmp_path / "other.ini"), backends=INLINE)
    other.live.show_prepared(prepared)
    assert "not saved" not in message(other)
    other.editor.do("Move", lambda document: move(document, [0], (0.05, 0.0)))
    other.presenters.map_files.autosave()
    other.presenters.map_files._wait()
    assert len(list((tmp_path / "state").rglob("*.autosave"))) == 2
    assert kept.read_bytes() == content
    other.presenters.map_files.give_up()
    other.close()
    other.deleteLater()
    assert kept.read_bytes() == content


def test_file_changed_by_another_window_is_replaced_after_a_question(window, files, prepared, tmp_path, choose_file):
    path = tmp_path / "shared.npz"
    choose_file("save_file", path)
    window.action("save").trigger()
    theirs = rotate(window.editor.document, [0], 0.25)
    save_document(theirs, path)
    window.editor.do("Rotate", lambda document: rotate(document, [1], 0.5))
    window.action("save").trigger()
    assert load_document(path).layout == theirs.layout
    assert files.unsaved
    answer(window, QMessageBox.StandardButton.Cancel, "overwrite")
    assert load_document(path).layout == theirs.layout
    window.action("save").trigger()
    answer(window, QMessageBox.StandardButton.Save, "overwrite")
    assert load_document(path).layout == window.editor.document.layout
    assert not files.unsaved
    window.editor.do("Rotate", lambda document: rotate(document, [1], 0.5))
    window.action("save").trigger()
    assert not files.unsaved, "one's own saving is no reason to ask"


@pytest.mark.long
def test_regular_end_leaves_no_autosave(window, files, prepared):
    files.autosave()
    files.give_up()
    window.live.show_prepared(reopened(prepared))
    assert message(window) == ""


def test_failed_autosave_is_reported_once(new_window, qtbot, tmp_path):
    window = edited(new_window)
    files = window.presenters.map_files
    files._file._folder = tmp_path / "blocked"
    files._timer.setInterval(1)
    qtbot.waitUntil(lambda: "cannot be written" in message(window))
    shown = []
    window.context.notifier.message_shown.connect(shown.append)
    asked = []
    again = QTimer(window)
    again.timeout.connect(lambda: asked.append(files._timer.isActive()))
    again.start(1)
    qtbot.waitUntil(lambda: len(asked) > 100)
    again.stop()
    assert not any(asked)
    assert not shown


def test_unexpected_error_of_an_autosave_is_reported(window, files, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))

    class Broken(DocumentFile):
        def autosave(self, document, **texts):
            raise ZeroDivisionError("unforeseen")

    files._file = Broken(None, None, folder=tmp_path)
    files.autosave()
    files._wait()
    assert "unforeseen" in message(window)


def reopened(prepared):
    """The same scene, as another process would hand it over."""
    return pickle.loads(pickle.dumps(prepared))


@pytest.mark.long
def test_title_names_the_recording_during_a_replay(window, files, tmp_path):
    live = window.live
    before = window.windowTitle()
    live.recording.start(tmp_path / "touch.mcap")
    run(window, 0.2)
    live.recording.stop()
    live.show_player(open_recording(tmp_path / "touch.mcap"))
    assert window.windowTitle() == "touch.mcap – arm – replaying – Tactile Maps"
    assert not window.isWindowModified(), "the edit is of the map behind it"
    live.replay.leave()
    assert window.windowTitle() == before
    assert window.isWindowModified()
    assert files.unsaved
