"""Files dragged over the window: the overlay states what dropping them will do."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QMimeData, QPoint, Qt, QUrl
from PySide6.QtGui import QDragEnterEvent, QDragLeaveEvent
from PySide6.QtWidgets import QApplication


@pytest.mark.parametrize(
    ("files", "text"),
    [
        ({"touch.toml": "[robot]"}, "Open the scene touch.toml"),
        ({"a.csv": "x,y,z\n0,0,0\n", "b.csv": "x,y,z\n1,0,0\n"}, "Place the taxels of 2 files"),
        ({"one.toml": "[robot]", "two.toml": "[robot]"}, "Open the scene one.toml (the first of 2 files)"),
        ({"letter.docx": "Dear"}, "letter.docx cannot be opened"),
    ],
)
def test_overlay_states_what_a_drop_will_do(window_again, tmp_path, files, text):
    window = window_again
    for name, content in files.items():
        (tmp_path / name).write_text(content)
    data = QMimeData()
    data.setUrls([QUrl.fromLocalFile(str(tmp_path / name)) for name in files])
    action = Qt.DropAction.CopyAction
    enter = QDragEnterEvent(QPoint(5, 5), action, data, Qt.MouseButton.LeftButton, Qt.KeyboardModifier.NoModifier)
    QApplication.sendEvent(window, enter)
    assert enter.isAccepted()
    assert window.drop_overlay.isVisible()
    assert window.drop_overlay.geometry() == window.rect()
    assert window.drop_overlay.text == text
    shown = window.drop_overlay.grab().toImage()
    assert len({shown.pixel(x, shown.height() // 2) for x in range(shown.width())}) > 2, "the text is drawn"
    QApplication.sendEvent(window, QDragLeaveEvent())
    assert window.drop_overlay.isHidden()
