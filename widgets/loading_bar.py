"""Says that another robot is being prepared while the one before it goes on living."""

from __future__ import annotations

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QHBoxLayout, QLabel, QProgressBar, QToolButton, QWidget

from widgets.colours import Theme, mixed
from widgets.message_bar import FloatingBar

_WIDTH = 460


class LoadingBar(FloatingBar):
    """Stage, progress and a way out, over the lower middle of the views."""

    cancelled = Signal()
    """The hand does not want it any more."""

    def __init__(self, theme: Theme, parent: QWidget) -> None:
        super().__init__(parent, widest=_WIDTH)
        self.setObjectName("loading-bar")
        self._text, self._progress, cancel = QLabel(self), QProgressBar(self), QToolButton(self)
        self._progress.setRange(0, 1000)
        self._progress.setTextVisible(False)
        self._progress.setFixedSize(120, 6)
        self._progress.setAccessibleName("Progress")
        cancel.setText("Cancel")
        cancel.setObjectName("loading-cancel")
        cancel.clicked.connect(self.cancelled)
        row = QHBoxLayout(self)
        row.setContentsMargins(12, 6, 8, 6)
        row.setSpacing(8)
        row.addWidget(self._text, 1)
        row.addWidget(self._progress)
        row.addWidget(cancel)
        self.set_theme(theme)
        self.hide()

    def show_progress(self, text: str, fraction: float) -> None:
        """The stage, and how far the whole is, 0 to 1."""
        self._text.setText(text)
        self._progress.setValue(round(1000 * fraction))
        self.setAccessibleName(text)
        if self.isHidden():
            self.show()

    def place(self) -> None:
        """The lower middle: messages come from above, hints sit at the right."""
        super().place()
        self.move(self.x(), self._parent.height() - self.height() - self.EDGE)

    def set_theme(self, theme: Theme) -> None:
        """Take another theme."""
        ground = mixed(theme.panel, theme.accent, 0.10)
        self.setStyleSheet(
            f"#loading-bar {{ background: {ground}; border: 1px solid {theme.line}; border-radius: 6px; }}"
        )
