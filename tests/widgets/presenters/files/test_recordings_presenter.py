"""The list of recordings, parts as new files, labels and the trash: by their buttons, and no recording is changed."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QInputDialog, QMessageBox, QPushButton

from tactile_maps.recording.encoding.annotations import (
    Annotations,
    LabelledEpisode,
    Outcome,
    load_annotations,
    save_annotations,
)
from tactile_maps.recording.overview.summary import RecordingSummary
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.recording.recorder import Recorder
from tactile_maps.session.session import Session
from tactile_widgets.common.colours import PressureScale
from tactile_widgets.dialogs.recordings_dialog import RecordingsDialog
from tactile_widgets.jobs.executor import ProcessExecutor
from tactile_widgets.plots.timeline.playhead import Span
from tests.support.recordings import with_checksum_damage
from tests.widgets.support.mouse import left_click
from tests.widgets.support.window_driver import activate, answer, cancel, click_remedy


@pytest.fixture(scope="module")
def recorded(prepared, tmp_path_factory):
    path = tmp_path_factory.mktemp("recorded") / "one.mcap"
    session = Session(prepared)
    with Recorder(prepared, path, viewers=False) as recorder:
        for _ in range(100):
            recorder.write(session.tick(), session.inputs)
    return path.read_bytes()


@pytest.fixture
def folder(recorded, tmp_path, monkeypatch):
    """Folder with two recordings and a damaged file; the trash belongs to this test."""
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    folder = tmp_path / "recordings"
    folder.mkdir()
    for name in ("one.mcap", "two.mcap"):
        (folder / name).write_bytes(recorded)
    (folder / "junk.mcap").write_bytes(b"no recording")
    return folder


@pytest.fixture
def dialog(window_again, folder):
    window_again.presenters.recordings._trashed.clear()  # files of previous tests
    yield open_list(window_again, folder)
    if (dialog := window_again.presenters.recordings.dialog) is not None:
        dialog.close()
    window_again.live.replay.leave()


def open_list(window, folder):
    """Press the keys of *Recordings*, and list the folder."""
    activate(window)
    QTest.keyClick(window, Qt.Key.Key_R, Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.ShiftModifier)
    dialog = window.presenters.recordings.dialog
    dialog.show_folder(folder, [], 0)
    window.presenters.recordings.show_folder(folder)
    return dialog


def row_of(dialog, name):
    names = [dialog.table.item(row, 0).text() for row in range(dialog.table.rowCount())]
    return next(row for row, text in enumerate(names) if text.endswith(name))


def text(dialog, name, column):
    titles = [dialog.table.horizontalHeaderItem(k).text() for k in range(dialog.table.columnCount())]
    return dialog.table.item(row_of(dialog, name), titles.index(column)).text()


def click(dialog, name, button):
    dialog.table.selectRow(row_of(dialog, name))
    left_click(dialog.findChild(QPushButton, f"recordings-{button}"))


@pytest.mark.parametrize("name", ["two.mcap", "junk.mcap"])
def test_list_closes_when_a_recording_is_replayed(window_again, dialog, folder, name):
    """A message about a file that cannot be replayed is in the window too."""
    window = window_again
    assert dialog.isVisible()
    click(dialog, name, "replay")
    QApplication.processEvents()
    assert not [top for top in QApplication.topLevelWidgets() if top.isVisible() and top is not window]
    assert window.presenters.recordings.dialog is None
    assert name in (window.windowTitle() if name == "two.mcap" else window.notification_bar.text)


@pytest.mark.parametrize("key", [Qt.Key.Key_Return, Qt.Key.Key_Enter])
def test_return_replays_the_selected_recording(window_again, dialog, folder, key):
    dialog.table.setFocus()
    dialog.table.selectRow(row_of(dialog, "two.mcap"))
    QTest.keyClick(dialog.table, key)
    QApplication.processEvents()
    assert window_again.presenters.recordings.dialog is None
    assert "two.mcap" in window_again.windowTitle()


@pytest.mark.long
def test_recordings_are_listed_labelled_replayed_and_deleted(window_again, dialog, folder, prepared, recorded):
    window = window_again
    assert text(dialog, "one.mcap", "Robot") == prepared.robot.name
    assert text(dialog, "one.mcap", "Length") == "0:00.4"
    assert not dialog.table.item(row_of(dialog, "one.mcap"), 0).icon().isNull()
    assert dialog.table.item(row_of(dialog, "junk.mcap"), 0).text().startswith("⚠")
    dialog.table.selectRow(row_of(dialog, "junk.mcap"))
    assert "not a recording" in dialog.note.text()
    assert not dialog.findChild(QPushButton, "recordings-success").isEnabled()
    click(dialog, "two.mcap", "success")
    assert "Success" in text(dialog, "two.mcap", "Outcome")
    click(dialog, "two.mcap", "label")
    box = window.findChild(QInputDialog)
    box.setTextValue("gentle")
    box.accept()
    assert load_annotations(folder / "two.mcap") == Annotations(label="gentle", outcome=Outcome.SUCCESS)
    QTest.keyClicks(dialog.search, "gentle")
    hidden = [dialog.table.isRowHidden(row) for row in range(3)]
    assert hidden.count(True) == 2
    assert not hidden[row_of(dialog, "two.mcap")]
    dialog.search.clear()
    click(dialog, "one.mcap", "replay")
    assert window.live.replay.player.path == folder / "one.mcap"
    dialog = open_list(window, folder)
    assert dialog.selected == folder / "one.mcap", "the list is closed by Replay and opened again"
    click(dialog, "one.mcap", "failure")
    assert window.context.notes.value.outcome is Outcome.FAILURE, "the notes that are shown are a document"
    assert (folder / "one.mcap").read_bytes() == recorded
    click(dialog, "two.mcap", "delete")
    window.findChild(QMessageBox, "delete-recording").button(QMessageBox.StandardButton.Yes).click()
    assert not (folder / "two.mcap").exists()
    assert load_annotations(folder / "two.mcap") is None
    assert sorted(path.name for path in folder.parent.glob("data/Trash/files/*")) == ["two.mcap", "two.notes.json"]
    assert dialog.table.rowCount() == 2


def delete(window, dialog, name):
    click(dialog, name, "delete")
    answer(window, QMessageBox.StandardButton.Yes, "delete-recording")


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def test_deleted_recordings_are_moved_back_with_their_notes(window_again, dialog, folder, recorded):
    window = window_again
    notes = Annotations(label="gentle")
    save_annotations(folder / "two.mcap", notes)
    undo = dialog.findChild(QPushButton, "recordings-undo")
    assert not undo.isEnabled()
    delete(window, dialog, "two.mcap")
    delete(window, dialog, "junk.mcap")
    assert names(folder) == ["one.mcap"]
    assert undo.toolTip().startswith("Move junk.mcap back")
    click_remedy(window, "Undo")
    assert names(folder) == ["junk.mcap", "one.mcap"]
    assert dialog.selected == folder / "junk.mcap"
    left_click(undo)
    assert names(folder) == ["junk.mcap", "one.mcap", "two.mcap", "two.notes.json"]
    assert (folder / "two.mcap").read_bytes() == recorded
    assert load_annotations(folder / "two.mcap") == notes
    assert text(dialog, "two.mcap", "Label") == "gentle"
    assert window.notification_bar.text == f"two.mcap is back in {folder}"
    assert not [path for path in folder.parent.rglob("data/Trash/*/*") if path.is_file()]
    assert not undo.isEnabled()


def test_deleted_recording_does_not_replace_another_file(window_again, dialog, folder, recorded):
    window = window_again
    delete(window, dialog, "two.mcap")
    (folder / "two.mcap").write_bytes(b"another")
    click_remedy(window, "Undo")
    assert "another file of this name" in window.notification_bar.text
    assert (folder / "two.mcap").read_bytes() == b"another"
    (folder / "two.mcap").unlink()
    left_click(dialog.findChild(QPushButton, "recordings-undo"))
    assert (folder / "two.mcap").read_bytes() == recorded
    delete(window, dialog, "two.mcap")
    for path in folder.parent.glob("data/Trash/*/*"):
        path.unlink()
    click_remedy(window, "Undo")
    assert "no longer in the trash" in window.notification_bar.text
    assert not dialog.findChild(QPushButton, "recordings-undo").isEnabled()


@pytest.mark.long
def test_range_and_episodes_are_saved_as_recordings(window_again, folder, recorded, choose_file):
    window = window_again
    part = folder / "part.mcap"
    save_annotations(
        folder / "one.mcap", Annotations(episodes=(LabelledEpisode(10, 20, "a"), LabelledEpisode(30, 35, "b")))
    )
    window.live.open_recording(folder / "one.mcap")
    window.timeline.set_range(Span(0.1, 0.3))
    choose_file("save_file", part)
    window.action("trim_range").trigger()
    assert [RecordingPlayer(part).frame(k).tick for k in (0, -1)] == [21, 61]
    assert "Saved" in window.notification_bar.text
    choose_file("choose_folder", folder / "parts")
    window.action("save_episodes").trigger()
    assert sorted(path.name for path in (folder / "parts").iterdir()) == ["01 a.mcap", "02 b.mcap"]
    (folder / "parts" / "01 a.mcap").unlink()
    (folder / "parts" / "02 b.mcap").write_bytes(b"precious")
    window.action("save_episodes").trigger()
    assert "02 b.mcap: the file already exists" in window.notification_bar.text
    assert "remove this file first" in window.notification_bar.text
    assert [(path.name, path.read_bytes()) for path in (folder / "parts").iterdir()] == [("02 b.mcap", b"precious")]
    choose_file("save_file", folder / "one.mcap")
    window.action("trim_range").trigger()
    assert "into itself" in window.notification_bar.text
    assert (folder / "one.mcap").read_bytes() == recorded
    assert not [path for path in folder.rglob("*") if path.name.startswith(".")], "no temporary files remain"
    window.live.replay.leave()


def test_summary_of_saved_parts_names_the_damage_of_the_recording(window_again, folder, recorded, choose_file):
    window = window_again
    path = folder / "one.mcap"
    path.write_bytes(with_checksum_damage(recorded))
    save_annotations(path, Annotations(episodes=(LabelledEpisode(10, 20, "a"), LabelledEpisode(30, 35, "b"))))
    window.live.open_recording(path)
    window.timeline.set_range(Span(0.1, 0.3))
    choose_file("save_file", folder / "part.mcap")
    window.action("trim_range").trigger()
    assert "part.mcap with the damage of the recording: the file does not match" in window.notification_bar.text
    choose_file("choose_folder", folder / "parts")
    window.action("save_episodes").trigger()
    assert window.notification_bar.text.startswith("Saved 2 episodes")
    assert window.notification_bar.text.count("does not match its checksum") == 1
    window.live.replay.leave()


@pytest.mark.long
def test_cancelled_part_leaves_no_file(new_window, folder, choose_file, qtbot):
    window = new_window
    presenter = new_window.presenters.recordings
    worker = ProcessExecutor("test", window)
    presenter._cutter = worker
    window.live.open_recording(folder / "one.mcap")
    window.timeline.set_range(Span(0.1, 0.3))
    choose_file("save_file", folder / "part.mcap")
    window.action("trim_range").trigger()
    qtbot.waitUntil(lambda: any(path.name.startswith(".") for path in folder.iterdir()), timeout=60_000)
    cancel(window)
    assert sorted(path.name for path in folder.iterdir()) == ["junk.mcap", "one.mcap", "two.mcap"]


def test_list_shows_labels_of_episodes_and_large_pictures(qtbot, tmp_path):
    dialog = RecordingsDialog()
    qtbot.addWidget(dialog)
    path = tmp_path / "three.mcap"
    dialog.show_folder(tmp_path, [path], 0)
    episodes = tuple(LabelledEpisode(10 * k, 10 * k + 9, label) for k, label in enumerate(("grasp", "lift", "grasp")))
    picture = np.zeros((88, 144), np.float32)
    picture[:, :72] = np.nan
    picture[:, 120:] = 5.0
    dialog.show_summary(
        RecordingSummary(path, 0.0, 1.0, "arm", "Arm", 3, Annotations(label="demo", episodes=episodes), picture)
    )
    assert text(dialog, "three.mcap", "Label") == "demo\ngrasp ×2, lift"
    assert dialog.table.iconSize().width() >= 128
    shown = dialog.table.item(0, 0).icon().pixmap(dialog.table.iconSize()).toImage()
    off, untouched, pressed = (
        shown.pixelColor(round(share * shown.width()), shown.height() // 2) for share in (0.25, 0.6, 0.95)
    )
    assert off.alpha() == 0, "the background of the theme shows next to the skin"
    colours = PressureScale(5.0).table
    assert [one.getRgb() for one in (untouched, pressed)] == [(*colours[level], 255) for level in (0, 255)]
    assert dialog.table.rowHeight(0) >= dialog.table.iconSize().height()
