"""Bar over the views with a proposed edit, which Enter accepts and Escape declines."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject, Qt, Signal
from PySide6.QtGui import QHideEvent, QKeyEvent, QShowEvent
from PySide6.QtWidgets import QApplication, QLabel, QToolButton, QWidget

from tactile_widgets.common.colours import Theme, mixed
from tactile_widgets.common.make import STYLE_SPACING, make, row_layout
from tactile_widgets.context.notification_bar import FloatingBar
from tactile_widgets.document.map_editor import Proposal

_ACCEPT = (Qt.Key.Key_Return, Qt.Key.Key_Enter)


class ProposalBar(FloatingBar):
    """Shows what a proposed edit gains, with the buttons *Accept* and *Decline*.

    While it is shown, it takes the keys Enter and Escape wherever the focus is, except in dialogs and menus.
    """

    accepted = Signal()
    declined = Signal()

    def __init__(self, theme: Theme, parent: QWidget) -> None:
        super().__init__(parent, widest=480)
        self.setObjectName("proposal-bar")
        self._text = make(QLabel, self, objectName="proposal-text")
        accept = make(QToolButton, self, text="Accept \u23ce", objectName="proposal-accept", clicked=self.accepted)
        decline = make(QToolButton, self, text="Decline Esc", objectName="proposal-decline", clicked=self.declined)
        parts = (self._text, accept, decline)
        row_layout(*parts, parent=self, spacing=STYLE_SPACING, stretch=self._text, margins=(12, 6, 8, 6))
        self.set_theme(theme)
        self.hide()

    @property
    def text(self) -> str:
        """Text of the bar; empty while it is hidden."""
        return self._text.text() if not self.isHidden() else ""

    def show_proposal(self, proposal: Proposal | None) -> None:
        """Show a proposal; hide the bar without one."""
        if proposal is not None:
            self._text.setText(_gain_text(proposal.gain))
        self.setVisible(proposal is not None)

    def set_theme(self, theme: Theme) -> None:
        """Apply a theme."""
        background = mixed(theme.panel, theme.accent, 0.14)
        self.setStyleSheet(
            f"#proposal-bar {{ background: {background}; border: 1px solid {theme.accent}; border-radius: 6px; }}"
        )

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        QApplication.instance().installEventFilter(self)  # type: ignore[union-attr]

    def hideEvent(self, event: QHideEvent) -> None:
        super().hideEvent(event)
        QApplication.instance().removeEventFilter(self)  # type: ignore[union-attr]

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Take the keys before shortcuts and the focused widget, while a proposal is shown."""
        if self.isHidden() or event.type() not in (QEvent.Type.ShortcutOverride, QEvent.Type.KeyPress):
            return super().eventFilter(watched, event)
        assert isinstance(event, QKeyEvent)
        accepts = event.key() in _ACCEPT
        busy = QApplication.activeModalWidget() is not None or QApplication.activePopupWidget() is not None
        if busy or event.modifiers() or not (accepts or event.key() == Qt.Key.Key_Escape):
            return super().eventFilter(watched, event)
        if event.type() == QEvent.Type.ShortcutOverride:
            event.accept()
        elif accepts:
            self.accepted.emit()
        else:
            self.declined.emit()
        return True


def _gain_text(gain: float | None) -> str:
    if gain is None:
        return "A further seam"
    return f"{100 * gain:.0f}\u202f% less distortion" if gain >= 0.005 else "No less distortion"
