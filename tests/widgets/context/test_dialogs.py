"""A file that the user did not confirm is never chosen to be replaced."""

from __future__ import annotations

from pathlib import Path

import pytest
from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QApplication, QDialogButtonBox, QLineEdit, QWidget

from tactile_widgets.common.file_dialogs import RECORDING_FILTER, FileDialog
from tactile_widgets.common.settings import Settings
from tactile_widgets.dialogs.dialogs import Dialogs
from tests.widgets.support.mouse import left_click


@pytest.fixture
def dialogs(qtbot, tmp_path, own_files) -> Dialogs:
    parent = QWidget()
    qtbot.addWidget(parent)
    return Dialogs(parent, Settings(tmp_path / "settings.ini"))


def choose(monkeypatch, *answers):
    """The user's choices one after the other; where each dialog opened."""
    opened = []
    left = list(answers)

    def ask(_parent, _title, start, _kinds):
        opened.append(start)
        return str(left.pop(0))

    monkeypatch.setattr(FileDialog, "save_file", ask)
    return opened


def test_name_without_an_extension_is_completed(dialogs, tmp_path, monkeypatch):
    choose(monkeypatch, tmp_path / "a", tmp_path / "b.npz", tmp_path / "c", "")
    assert dialogs.save_file("Save map", "arm.npz", "Maps (*.npz)") == str(tmp_path / "a.npz")
    assert dialogs.save_file("Save map", "arm.npz", "Maps (*.npz)") == str(tmp_path / "b.npz")
    assert dialogs.save_file("Export", "arm 12.30 csv", "New folder (*)") == str(tmp_path / "c")
    assert dialogs.save_file("Save map", "arm.npz", "Maps (*.npz)") == ""


def test_folder_is_remembered_by_kind_and_name_by_default_name(dialogs, tmp_path, monkeypatch):
    folder = tmp_path / "maps"
    folder.mkdir()
    opened = choose(monkeypatch, folder / "left.npz", "", "")
    Path(dialogs.save_file("Save map", "arm.npz", "Tactile maps (*.npz)")).write_bytes(b"a map")
    shown = []
    monkeypatch.setattr(FileDialog, "open_file", lambda _parent, _title, start, _kinds: shown.append(start) or "")
    dialogs.open_file("Open map", "Tactile maps (*.npz *.obj)")
    dialogs.open_file("Open recording", "Recordings (*.mcap)")
    assert shown == [str(folder), str(tmp_path)]
    dialogs.save_file("Save map", "arm.npz", "Tactile maps (*.npz)")
    dialogs.save_file("Save map", "icub.npz", "Tactile maps (*.npz)")
    assert opened[1:] == [str(folder / "left 2.npz"), str(folder / "icub.npz")]


def test_existing_completed_name_requires_confirmation(dialogs, tmp_path, monkeypatch):
    (tmp_path / "a.npz").write_bytes(b"precious")
    opened = choose(monkeypatch, tmp_path / "a", tmp_path / "b")
    assert dialogs.save_file("Save map", "arm.npz", "Maps (*.npz)") == str(tmp_path / "b.npz")
    assert opened[1] == str(tmp_path / "a.npz"), "the dialog opens again, and asks by itself about this name"


def test_folder_and_name_of_a_save_are_remembered_once_it_succeeded(dialogs, tmp_path, monkeypatch):
    good = tmp_path / "good"
    failed = tmp_path / "failed"
    for folder in (good, failed):
        folder.mkdir()
        (folder / "old.npz").write_bytes(b"an older map")
    opened = choose(monkeypatch, good / "old.npz", failed / "old.npz", failed / "new.npz", "", "")
    for _ in range(3):  # the first two in place of an old file
        chosen = Path(dialogs.save_file("Save map", "arm.npz", "Tactile maps (*.npz)"))
        if chosen.parent == good:
            chosen.write_bytes(b"another map")
    dialogs.save_file("Save map", "arm.npz", "Tactile maps (*.npz)")
    assert opened[1:] == [str(good / "old 2.npz")] * 3
    (failed / "new.npz").write_bytes(b"a map that took long")
    dialogs.remember_saved()
    dialogs.save_file("Save map", "arm.npz", "Tactile maps (*.npz)")
    assert opened[4] == str(failed / "new 2.npz")


def test_first_dialogs_open_in_the_folder_of_recordings_of_the_document_or_of_documents(dialogs, tmp_path, monkeypatch):
    """A folder that does not exist yet is replaced by the nearest one that does."""
    shown = []
    for method in ("open_file", "choose_folder", "save_file"):
        monkeypatch.setattr(FileDialog, method, lambda _parent, _title, start, *_kinds: shown.append(start) or "")

    def starts():
        shown.clear()
        dialogs.open_file("Open recording", RECORDING_FILTER)
        dialogs.open_folder("Recordings")
        dialogs.open_file("Open map", "Tactile maps (*.npz)")
        dialogs.save_file("Save map", "arm.npz", "Tactile maps (*.npz)")
        return shown

    assert starts() == [str(tmp_path)] * 3 + [str(tmp_path / "arm.npz")]
    (tmp_path / "recordings").mkdir()
    (tmp_path / "work").mkdir()
    dialogs.document = lambda: tmp_path / "work" / "scene.toml"
    recordings = str(tmp_path / "recordings")
    assert starts() == [recordings, recordings, str(tmp_path / "work"), str(tmp_path / "work" / "arm.npz")]


def test_export_to_a_folder_proposes_a_free_name_each_time(dialogs, tmp_path):
    (tmp_path / "touch 17.40 csv 2").mkdir()
    proposed = []

    def accept():
        dialog = QApplication.activeModalWidget()
        proposed.append((dialog.directory().absolutePath(), dialog.findChild(QLineEdit, "fileNameEdit").text()))
        left_click(dialog.findChild(QDialogButtonBox).button(QDialogButtonBox.StandardButton.Save))
        if dialog.isVisible():
            dialog.reject()

    for _ in range(3):
        QTimer.singleShot(0, accept)
        Path(dialogs.save_file("Export recording", "touch 17.40 csv", "New folder (*)")).mkdir()
    assert proposed == [(str(tmp_path), f"touch 17.40 csv{number}") for number in ("", " 3", " 4")]
