"""Progress of a background job, shown while the current scene continues."""

from __future__ import annotations

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QSizePolicy, QToolButton, QWidget

from tactile_widgets.common.make import ElidedLabel, make, progress_bar, row_layout

_TEXT_PX = 240
"""Width up to which the text of a stage is shown whole [px]; a path may be longer."""


class ProgressIndicator(QWidget):
    """Stage, progress bar and Cancel button in the status line, where they cover and move nothing.

    Attributes:
        text_label: Label with the stage.
    """

    cancelled = Signal()
    """The user pressed Cancel."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("loading-bar")
        self.setSizePolicy(QSizePolicy.Policy.Maximum, QSizePolicy.Policy.Ignored)
        self._parts = QWidget(self)
        self.text_label = ElidedLabel("loading-text", elided=Qt.TextElideMode.ElideMiddle)
        self._progress = make(progress_bar, self, fixedWidth=100)
        cancel = make(
            QToolButton,
            text="Cancel",
            objectName="loading-cancel",
            toolTip="Keep the current scene",
            clicked=self.cancelled,
        )
        self.text_label.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        parts = (self.text_label, self._progress, cancel)
        row_layout(*parts, parent=self._parts, stretch=self.text_label, margins=(16, 0, 16, 0))
        row_layout(self._parts, parent=self)
        self.clear()

    @property
    def busy(self) -> bool:
        """True while progress is shown."""
        return not self._parts.isHidden()

    def show_progress(self, text: str, fraction: float | None) -> None:
        """Show the stage, and the share of the whole that is done, 0 to 1; None if unknown."""
        self.text_label.setText(text)
        self.text_label.setMinimumWidth(min(self.text_label.sizeHint().width(), _TEXT_PX))
        self._progress.setVisible(fraction is not None)
        self._progress.setValue(round(1000 * (fraction or 0.0)))
        self.setAccessibleName(text)
        self._parts.show()

    def clear(self) -> None:
        """Hide the progress."""
        self._parts.hide()
