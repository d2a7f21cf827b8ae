"""File dialogs do not read the files that they list."""

from __future__ import annotations

from PySide6.QtCore import QTimer
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QDialog, QFileSystemModel

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
