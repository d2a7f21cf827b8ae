"""Card of a view that has nothing to show: a heading, a sentence, progress, and the button that helps."""

from __future__ import annotations

from dataclasses import dataclass

from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QPalette
from PySide6.QtWidgets import QLabel, QPushButton, QVBoxLayout, QWidget

from tactile_widgets.common.make import make, progress_bar, small_font


@dataclass(frozen=True)
class CardTexts:
    """Texts of the placeholder of a view.

    Attributes:
        empty: Heading before the first content.
        hint: How to fill the view.
        loading: Heading while content is being loaded.
        failed: Heading after loading failed.
    """

    empty: str
    hint: str
    loading: str
    failed: str


class PlaceholderCard(QWidget):
    """A centred message that covers a view until ``clear``.

    Args:
        texts: Its texts.
        parent: The view; its resize event must resize the card.
    """

    covered = Signal(bool)
    """True if the card covers the view."""
    open_requested = Signal()
    """The button of the empty or failed state was pressed."""
    cancel_requested = Signal()
    """The button of the loading state was pressed."""

    def __init__(self, texts: CardTexts, parent: QWidget) -> None:
        super().__init__(parent)
        self._texts = texts
        self._parent = parent
        self._filled = False
        self._loading = False
        self.setObjectName("state-card")
        self.setAutoFillBackground(True)
        self.setBackgroundRole(QPalette.ColorRole.Base)  # background of the views
        self._heading, self._text = QLabel(self), QLabel(self)
        self._text.setTextFormat(Qt.TextFormat.PlainText)
        self._progress = make(progress_bar, self, fixedWidth=240)
        self._button = make(QPushButton, self, clicked=self._on_clicked)
        self._heading.setFont(small_font(self.font(), 16))
        self._text.setWordWrap(True)
        self._heading.setForegroundRole(QPalette.ColorRole.Text)
        self._text.setForegroundRole(QPalette.ColorRole.PlaceholderText)
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

    def show_empty(self) -> None:
        """Show how to fill the view."""
        self._say(self._texts.empty, self._texts.hint)

    def show_loading(self, text: str, progress: float) -> None:
        """Show the stage and the progress of loading, 0 to 1."""
        self._say(self._texts.loading, text, progress)

    def show_waiting(self) -> None:
        """Show that content is being loaded; another view shows the progress."""
        self._say(self._texts.loading, "")
        self._button.hide()

    def show_failed(self, text: str) -> None:
        """Show why loading failed."""
        self._say(self._texts.failed, text)

    def show_last(self) -> None:
        """Show the previous content again after loading failed or was cancelled."""
        if self._filled:
            self.clear()
        else:
            self.show_empty()

    def clear(self) -> None:
        """Hide the card, because the view has content."""
        self._filled = True
        self.hide()
        self.covered.emit(False)

    def _say(self, heading: str, text: str, progress: float | None = None) -> None:
        self._loading = progress is not None
        self.setGeometry(self._parent.rect())
        self._heading.setText(heading)
        self._text.setText(text)
        self._progress.setVisible(self._loading)
        self._progress.setValue(round(1000 * (progress or 0.0)))
        self._button.show()
        self._button.setText("Cancel" if self._loading else "Open robot…")
        self.setAccessibleName(heading)
        self.setAccessibleDescription(text)
        self.show()
        self.raise_()
        self.covered.emit(True)

    def _on_clicked(self) -> None:
        (self.cancel_requested if self._loading else self.open_requested).emit()
