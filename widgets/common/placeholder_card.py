"""What a view says while it has nothing to show: a heading, a sentence, progress, and the button that helps."""

from __future__ import annotations

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QFont, QPalette
from PySide6.QtWidgets import QLabel, QProgressBar, QPushButton, QVBoxLayout, QWidget


class PlaceholderCard(QWidget):
    """A centred message over a view. Emits ``helped`` when its button is pressed."""

    helped = Signal()

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setObjectName("state-card")
        self.setAutoFillBackground(True)
        self.setBackgroundRole(QPalette.ColorRole.Base)  # the views' ground
        self._heading, self._text = QLabel(self), QLabel(self)
        self._text.setTextFormat(Qt.TextFormat.PlainText)
        self._progress, self._button = QProgressBar(self), QPushButton(self)
        heading = QFont(self.font())
        heading.setPixelSize(16)
        self._heading.setFont(heading)
        self._text.setWordWrap(True)
        self._heading.setForegroundRole(QPalette.ColorRole.Text)
        self._text.setForegroundRole(QPalette.ColorRole.PlaceholderText)
        self._progress.setRange(0, 1000)
        self._progress.setTextVisible(False)
        self._progress.setFixedSize(240, 6)
        self._progress.setAccessibleName("Progress")
        self._button.clicked.connect(self.helped)
        layout = QVBoxLayout(self)
        layout.setSpacing(8)
        layout.addStretch(1)
        for label in (self._heading, self._text):
            label.setAlignment(Qt.AlignmentFlag.AlignCenter)
            layout.addWidget(label)
        layout.addSpacing(8)
        layout.addWidget(self._progress, 0, Qt.AlignmentFlag.AlignHCenter)
        layout.addWidget(self._button, 0, Qt.AlignmentFlag.AlignHCenter)
        layout.addStretch(1)

    def say(self, heading: str, text: str, *, button: str = "", progress: float | None = None) -> None:
        """Show a message; ``progress`` in 0..1 shows a bar, an empty ``button`` none."""
        self._heading.setText(heading)
        self._text.setText(text)
        self._progress.setVisible(progress is not None)
        self._progress.setValue(round(1000 * (progress or 0.0)))
        self._button.setVisible(bool(button))
        self._button.setText(button)
        self.setAccessibleName(heading)
        self.setAccessibleDescription(text)
        self.show()
        self.raise_()
