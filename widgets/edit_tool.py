"""What a view asks of a tool that edits the map or leads the arm: mouse and keys go to it while it is in the hand."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from PySide6.QtCore import QObject, Qt, Signal
from PySide6.QtGui import QKeyEvent, QMouseEvent, QPainter, QWheelEvent

from app.arrays import FloatArray
from app.geometry.surface_point import SurfacePoint
from widgets.body_marks import NO_MARKS, BodyMarks
from widgets.colours import Theme

ToPixels = Callable[[FloatArray], FloatArray]
"""From map points (k, 2) [m] to pixels of the viewport (k, 2)."""


@dataclass(frozen=True, eq=False)
class Place:
    """What is under the pointer.

    Attributes:
        at: The place of the skin; None beside it.
        point: (2,) the map point [m]; None in the robot view.
        pixel: How large a pixel is there [m].
    """

    at: SurfacePoint | None
    point: FloatArray | None
    pixel: float


class EditTool(QObject):
    """A tool that does nothing, as the views know it.

    Those that edit change the document through the editor alone, those that lead the arm its settings through the lead.
    """

    hint = ""
    """What the mouse and the keys do with it, for people."""
    drawn = Signal()
    """``paint`` would draw something else now."""

    def press(self, place: Place, event: QMouseEvent) -> bool:
        """The left button went down. Whether a gesture begins, which owns the mouse until the release."""
        return False

    def move(self, place: Place, event: QMouseEvent) -> None:
        """The pointer moved, held or hovering."""

    def release(self, place: Place, event: QMouseEvent) -> None:
        """The left button came up."""

    def wheel(self, place: Place, event: QWheelEvent) -> bool:
        """The wheel turned. Whether it was for this tool."""
        return False

    def key(self, event: QKeyEvent) -> bool:
        """A key was pressed in the view. Whether it was for this tool."""
        return False

    def wants(self, key: Qt.Key) -> bool:
        """Whether a key that is also one of the window's would now be for this tool."""
        return False

    def cancel(self) -> bool:
        """Escape was pressed, the focus went or another tool was taken. Whether there was a gesture to give up."""
        return False

    def paint(self, painter: QPainter, to_pixels: ToPixels, theme: Theme) -> None:
        """Draw over the view, in the viewport's pixels."""

    def body_marks(self) -> BodyMarks:
        """What is marked on the body, where the robot view draws it in three dimensions."""
        return NO_MARKS

    def paint_body(self, painter: QPainter, theme: Theme) -> None:
        """Draw over the robot view, in its pixels, what is at no place of the skin: the brush, words."""

    def leave(self) -> None:
        """The pointer left the view."""

    def cursor(self, place: Place) -> Qt.CursorShape:
        """What the pointer looks like there."""
        return Qt.CursorShape.ArrowCursor
