"""File dialogs do not read the files that they list."""

from __future__ import annotations

from PySide6.QtCore import Qt, QTimer
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QComboBox, QDialog, QFileSystemModel, QLineEdit

from tactile_widgets.common.file_dialogs import FileDialog
from tests.widgets.support.snapshots import FOLDER


def test_type_of_a_listed_file_is_not_read_from_its_content(qtbot, tmp_path):
    (tmp_path / "picture").write_bytes((FOLDER / "window_dark.png").read_bytes())
    dialog = FileDialog(None, "Open", str(tmp_path))
    qtbot.addWidget(dialog)
    dialog.show()
    model = dialog.findChild(QFileSystemModel)
    index = model.index(str(tmp_path / "picture"))
    qtbot.waitUntil(lambda: bool(model.type(index)))
    assert model.type(index) == "File"
    assert (
        model.fileIcon(index).cacheKey() == dialog.iconProvider().icon(dialog.iconProvider().IconType.File).cacheKey()
    )


def test_chosen_file_is_returned(qapp, tmp_path):
    (tmp_path / "arm.npz").write_bytes(b"")

    def accept():
        (dialog,) = [shown for shown in QApplication.topLevelWidgets() if isinstance(shown, FileDialog)]
        dialog.selectFile(str(tmp_path / "arm.npz"))
        QTest.qWait(0)
        dialog.done(QDialog.DialogCode.Accepted)

    QTimer.singleShot(0, accept)
    assert FileDialog.open_file(None, "Open", str(tmp_path), "Maps (*.npz)") == str(tmp_path / "arm.npz")
    QTimer.singleShot(0, lambda: QApplication.activeModalWidget().reject())
    assert FileDialog.save_file(None, "Save", str(tmp_path / "new.npz"), "Maps (*.npz)") == ""


def test_kind_of_the_proposed_name_is_chosen_and_another_kind_changes_the_name(qapp, tmp_path):
    seen = []

    def look():
        dialog = QApplication.activeModalWidget()
        kinds = dialog.findChild(QComboBox, "fileTypeCombo")
        name = dialog.findChild(QLineEdit, "fileNameEdit")
        seen.append((kinds.currentText(), name.text()))
        QTest.keyClick(kinds, Qt.Key.Key_End)
        seen.append((kinds.currentText(), name.text()))
        dialog.reject()

    QTimer.singleShot(0, look)
    FileDialog.save_file(
        None, "Save", str(tmp_path / "plots.pdf"), "Vector (*.svg);;Page (*.pdf *.eps);;Pixels (*.png)"
    )
    assert seen == [("Page (*.pdf *.eps)", "plots.pdf"), ("Pixels (*.png)", "plots.png")]
