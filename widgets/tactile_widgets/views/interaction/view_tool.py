"""What a view asks of a tool that edits the map or sets a task: mouse and keys go to it while it is selected.

``ShortcutOverrideFilter`` gives the tool those keys that are also shortcuts of the window, such as Backspace while
something is drawn.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

from PySide6.QtCore import QEvent, QObject, Qt, Signal
from PySide6.QtGui import QKeyEvent, QMouseEvent, QPainter, QWheelEvent
from PySide6.QtWidgets import QWidget

from tactile_maps.core.arrays import FloatArray
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_widgets.common.colours import Theme
from tactile_widgets.views.overlays.body_overlays import NO_MARKS, ToolMarks

ToPixels = Callable[[FloatArray], FloatArray]
"""From map points (k, 2) [m] to pixels of the viewport (k, 2)."""


@dataclass(frozen=True)
class PointedAt:
    """Skin location or body under the pointer.

    Attributes:
        at: Skin location; None next to the skin.
        body: Index of the link, or of the object after the links, where there is no skin; None for neither.
    """

    at: SurfacePoint | None = None
    body: int | None = None


@dataclass(frozen=True, eq=False)
class BodyHit:
    """The place of a link or an object under the pointer, skin or not, in the world.

    Attributes:
        number: Of the link, or of the object behind the links.
        point: (3,) [m].
        direction: (3,) unit, along which it was met.
        origin: (3,) of the body [m].
        rotation: (3, 3) of the body.
    """

    number: int
    point: FloatArray
    direction: FloatArray
    origin: FloatArray
    rotation: FloatArray


@dataclass(frozen=True, eq=False)
class PointerHit:
    """What is under the pointer.

    Attributes:
        at: The place of the skin; None beside it.
        point: (2,) the map point [m]; None in the robot view.
        pixel: How large a pixel is there [m].
        ray: Origin (3,) [m] and unit direction (3,) of the line of sight, for tools that grab links; else None.
        body: What it meets first, likewise.
    """

    at: SurfacePoint | None
    point: FloatArray | None
    pixel: float
    ray: tuple[FloatArray, FloatArray] | None = None
    body: BodyHit | None = None


class ViewTool(QObject):
    """A tool that does nothing, as the views know it.

    Those that edit change the document through the editor alone, those that lead the arm its settings through the lead.
    """

    hint = ""
    """What the mouse and the keys do with it, for people."""
    grabs_links: ClassVar[bool] = False
    """Whether it is told which link or object is under the pointer, skin or not."""
    drawn = Signal()
    """``paint`` would draw something else now."""

    def press(self, place: PointerHit, event: QMouseEvent) -> bool:
        """The left button went down. Whether a gesture begins, which owns the mouse until the release."""
        return False

    def move(self, place: PointerHit, event: QMouseEvent) -> None:
        """The pointer moved, held or hovering."""

    def release(self, place: PointerHit, event: QMouseEvent) -> None:
        """The left button came up."""

    def wheel(self, place: PointerHit, event: QWheelEvent) -> bool:
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

    def body_marks(self) -> ToolMarks:
        """What is marked on the body, where the robot view draws it in three dimensions."""
        return NO_MARKS

    def paint_body(self, painter: QPainter, theme: Theme) -> None:
        """Draw over the robot view, in its pixels, what is at no place of the skin: the brush, words."""

    def leave(self) -> None:
        """The pointer left the view."""

    def cursor(self, place: PointerHit) -> Qt.CursorShape:
        """What the pointer looks like there."""
        return Qt.CursorShape.ArrowCursor


class ShortcutOverrideFilter(QObject):
    """Watches a view, and says so when Qt asks whether a key is to be none of the window's.

    Args:
        view: Whose keys.
        own: Keys, without modifiers, that the view itself takes.

    Attributes:
        tool: The one in use, or None.
    """

    def __init__(self, view: QWidget, *, own: frozenset[Qt.Key] = frozenset()) -> None:
        super().__init__(view)
        self._own = own
        self.tool: ViewTool | None = None
        view.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Qt: take what tool or view want; the key itself then comes to the view."""
        if event.type() != QEvent.Type.ShortcutOverride or not isinstance(event, QKeyEvent):
            return False
        key = Qt.Key(event.key())
        if (key in self._own and not event.modifiers()) or (self.tool is not None and self.tool.wants(key)):
            event.accept()
        return event.isAccepted()
