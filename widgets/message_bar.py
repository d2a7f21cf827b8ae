"""Slim bars above the views: one message at a time, and the first hints. Nothing modal."""

from __future__ import annotations

from PySide6.QtCore import Qt, Signal
from PySide6.QtWidgets import QHBoxLayout, QLabel, QSizePolicy, QToolButton, QWidget

from widgets.colours import Theme, mixed

HINTS = ("Press the skin or the map to poke it", "Drag along it to stroke", "Ctrl+R records what happens")


class MessageBar(QWidget):
    """Says what went wrong, or what was done, until closed or replaced."""

    def __init__(self, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("message-bar")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        self._theme, self._fault = theme, False
        self._text = QLabel(self)
        self._text.setObjectName("message-text")
        self._text.setWordWrap(True)
        self._text.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self._text.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Minimum)
        close = QToolButton(self)
        close.setText("Dismiss")
        close.setObjectName("message-dismiss")
        close.clicked.connect(self.hide)
        layout = QHBoxLayout(self)
        layout.setContentsMargins(12, 6, 8, 6)
        layout.addWidget(self._text)
        layout.addWidget(close)
        self.hide()

    @property
    def text(self) -> str:
        """What is said; empty when nothing is."""
        return self._text.text() if not self.isHidden() else ""

    def say(self, text: str, *, fault: bool = False) -> None:
        """Show a message; ``fault`` for what failed."""
        self._text.setText(text)
        self._fault = fault
        self.setAccessibleName(text)
        self._dress()
        self.show()

    def set_theme(self, theme: Theme) -> None:
        """Take another theme."""
        self._theme = theme
        self._dress()

    def _dress(self) -> None:
        edge = self._theme.fault if self._fault else self._theme.accent
        ground = mixed(self._theme.panel, edge, 0.14)
        self.setStyleSheet(f"#message-bar {{ background: {ground}; border-left: 4px solid {edge}; }}")


class HintBar(QWidget):
    """Three hints for the first minutes; gone once the skin has been touched, or when dismissed."""

    dismissed = Signal()

    def __init__(self, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("hint-bar")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        layout = QHBoxLayout(self)
        layout.setContentsMargins(12, 4, 8, 4)
        layout.setSpacing(24)
        for number, text in enumerate(HINTS, start=1):
            label = QLabel(f"{number}  {text}", self)
            label.setObjectName(f"hint-{number}")
            layout.addWidget(label)
        layout.addStretch(1)
        close = QToolButton(self)
        close.setText("Got it")
        close.setObjectName("hint-dismiss")
        close.clicked.connect(self.dismissed)
        layout.addWidget(close)
        self.set_theme(theme)

    def set_theme(self, theme: Theme) -> None:
        """Take another theme."""
        ground = mixed(theme.panel, theme.accent, 0.10)
        self.setStyleSheet(f"#hint-bar {{ background: {ground}; border-bottom: 1px solid {theme.line}; }}")
