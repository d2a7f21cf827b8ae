"""Keys that are the window's, but that the tool in the hand wants now: Backspace while something is drawn."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QWidget

from widgets.edit_tool import EditTool


class ToolKeys(QObject):
    """Watches a view, and says so when Qt asks whether a key is to be none of the window's.

    Args:
        view: Whose keys.

    Attributes:
        tool: The one in the hand, or None.
    """

    def __init__(self, view: QWidget) -> None:
        super().__init__(view)
        self.tool: EditTool | None = None
        view.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Qt: take what the tool wants; the key itself then comes to the view."""
        if self.tool is None or event.type() != QEvent.Type.ShortcutOverride or not isinstance(event, QKeyEvent):
            return False
        if self.tool.wants(Qt.Key(event.key())):
            event.accept()
        return event.isAccepted()
