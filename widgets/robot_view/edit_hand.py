"""The edit tool in the hand over the body: what is under the pointer for it, and whether it owns the mouse."""

from __future__ import annotations

from PySide6.QtGui import QKeyEvent, QMouseEvent

from widgets.edit_tool import EditTool, Place


class EditHand:
    """Hands mouse and keys to an edit tool. Mutable; idle without a tool.

    Attributes:
        tool: The one in the hand, or None.
        held: Whether a gesture of it owns the mouse.
    """

    def __init__(self) -> None:
        self.tool: EditTool | None = None
        self.held = False

    def press(self, place: Place, event: QMouseEvent) -> bool:
        """The left button went down; whether the tool took it."""
        self.held = self.tool is not None and self.tool.press(place, event)
        return self.held

    def move(self, place: Place, event: QMouseEvent) -> None:
        """The pointer moved."""
        if self.tool is not None:
            self.tool.move(place, event)

    def release(self, place: Place, event: QMouseEvent) -> bool:
        """The left button came up; whether that ended a gesture."""
        held, self.held = self.held, False
        if held and self.tool is not None:
            self.tool.release(place, event)
        return held

    def key(self, event: QKeyEvent) -> bool:
        """A key was pressed; whether it was for the tool."""
        return self.tool is not None and self.tool.key(event)

    def leave(self) -> None:
        """The pointer left the view."""
        if self.tool is not None and not self.held:
            self.tool.leave()

    def cancel(self, *, all_of_it: bool) -> bool:
        """Whether there was a gesture to give up; if not ``all_of_it``, only one that holds the mouse is.

        What is drawn click by click goes on in the other view: pressing there takes the focus from this one.
        """
        held, self.held = self.held, False
        return (held or all_of_it) and self.tool is not None and self.tool.cancel()
