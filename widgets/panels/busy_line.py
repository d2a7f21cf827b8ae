"""One line that says what the worker computes for an edit, how far it is, and cancels it."""

from __future__ import annotations

from PySide6.QtCore import Qt, QTimer
from PySide6.QtWidgets import QHBoxLayout, QLabel, QProgressBar, QSizePolicy, QToolButton, QWidget

from widgets.editor import Editor

PATIENCE_MS = 500
"""What is done sooner needs no telling."""
_ROOM = 100
"""For the words [px], until they are laid out."""


class BusyLine(QWidget):
    """There once an edit has taken half a second; its place is kept, so that nothing jumps under the hand."""

    def __init__(self, editor: Editor, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("edit-progress")
        self._text, self._bar, cancel = QLabel(self), QProgressBar(self), QToolButton(self)
        self._text.setProperty("role", "caption")
        self._text.setMinimumWidth(1)  # long words are cut before the panel is
        self._text.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        self._bar.setRange(0, 1000)
        self._bar.setTextVisible(False)
        self._bar.setFixedSize(72, 6)
        self._bar.setAccessibleName("Progress")
        cancel.setText("Cancel")
        cancel.setObjectName("edit-cancel")
        cancel.setToolTip("Keep the map as it is")
        cancel.clicked.connect(editor.cancel_work)
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(8)
        row.addWidget(self._text, 1)
        row.addWidget(self._bar, 0, Qt.AlignmentFlag.AlignVCenter)
        row.addWidget(cancel)
        self._patience = QTimer(self)
        self._patience.setSingleShot(True)
        self._patience.setInterval(PATIENCE_MS)
        self._patience.timeout.connect(self.show)
        kept = self.sizePolicy()
        kept.setRetainSizeWhenHidden(True)
        self.setSizePolicy(kept)
        self.hide()
        editor.working.connect(self._on_working)
        editor.rested.connect(self._on_rested)

    def _on_working(self, text: str, fraction: float) -> None:
        metrics, room = self._text.fontMetrics(), max(self._text.width(), _ROOM)
        self._text.setText(metrics.elidedText(text, Qt.TextElideMode.ElideRight, room))
        self._text.setToolTip(text)
        self._bar.setValue(round(1000 * fraction))
        if self.isHidden() and not self._patience.isActive():
            self._patience.start()

    def _on_rested(self) -> None:
        self._patience.stop()
        self.hide()
