"""The log of what the window has said: messages and errors with their time, to be read again and copied."""

from __future__ import annotations

from PySide6.QtCore import QTime
from PySide6.QtWidgets import QWidget

from tactile_widgets.common.panel import Panel
from tactile_widgets.panels.note_list import Note, NoteList

_HEIGHT = 120
_MOST = 200
_EMPTY = "Messages and errors are listed here; Ctrl+C copies them."


class MessagesPanel(Panel):
    """Lists them, the newest on top."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__("Messages", "messages-panel", parent)
        self.list = NoteList("messages-list", _EMPTY, _HEIGHT, self)
        self.list.setAccessibleName("Messages, the newest first")
        self.column.addWidget(self.list)

    def add(self, text: str, fault: bool) -> None:
        """The window said ``text`` now; ``fault`` where something failed."""
        kind = "Error" if fault else "Message"
        self.list.put_first(Note(f"{kind}, {QTime.currentTime().toString('HH:mm:ss')}", text, fault), most=_MOST)
