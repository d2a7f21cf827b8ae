"""The progress of what is prepared in a process beside the window, while the scene before it goes on."""

from __future__ import annotations

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QHBoxLayout, QLabel, QProgressBar, QSizePolicy, QToolButton, QWidget

_TEXT_PX = 240
"""Room that a stage's words are given [px]: as long as any of ours is."""


class ProgressIndicator(QWidget):
    """Stage, progress and a way out, in the status line: it covers nothing and moves nothing.

    Attributes:
        text_label: Names the stage; long words are cut before the line is.
    """

    cancelled = Signal()
    """The user does not want it any more."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("loading-bar")
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Ignored)
        self._parts = QWidget(self)
        self.text_label = QLabel()
        self._progress = QProgressBar()
        cancel = QToolButton()
        self.text_label.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        self.text_label.setTextFormat(Qt.TextFormat.PlainText)
        self._progress.setRange(0, 1000)
        self._progress.setTextVisible(False)
        self._progress.setFixedSize(120, 6)
        self._progress.setAccessibleName("Progress")
        cancel.setText("Cancel")
        cancel.setObjectName("loading-cancel")
        cancel.setToolTip("Keep the current scene")
        cancel.clicked.connect(self.cancelled)
        row = QHBoxLayout(self._parts)
        row.setContentsMargins(16, 0, 16, 0)
        row.setSpacing(8)
        row.addWidget(self.text_label, 1)
        row.addWidget(self._progress)
        row.addWidget(cancel)
        whole = QHBoxLayout(self)
        whole.setContentsMargins(0, 0, 0, 0)
        whole.addWidget(self._parts)
        self.clear()

    @property
    def busy(self) -> bool:
        """Whether something is being prepared."""
        return not self._parts.isHidden()

    def show_progress(self, text: str, fraction: float | None) -> None:
        """The stage, and how far the whole is, 0 to 1; None where nobody knows."""
        self.text_label.setText(text)
        self.text_label.setToolTip(text)
        self.text_label.setMinimumWidth(min(self.text_label.sizeHint().width(), _TEXT_PX))
        self._progress.setVisible(fraction is not None)
        self._progress.setValue(round(1000 * (fraction or 0.0)))
        self.setAccessibleName(text)
        self._parts.show()

    def clear(self) -> None:
        """Nothing is being prepared any more."""
        self._parts.hide()
