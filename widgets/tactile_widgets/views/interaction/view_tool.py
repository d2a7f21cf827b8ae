"""Interface between the views and the tools that edit the map or set a task: an active tool gets mouse and keys.

``ShortcutOverrideFilter`` gives the tool those keys that are also shortcuts of the window, such as Backspace while
something is drawn.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import ClassVar

from PySide6.QtCore import QEvent, QObject, QRectF, Qt, Signal
from PySide6.QtGui import QFont, QKeyEvent, QMouseEvent, QPainter, QWheelEvent
from PySide6.QtWidgets import QWidget

from tactile_maps.core.arrays import FloatArray
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_widgets.common.colours import Theme
from tactile_widgets.views.overlays.body_overlays import NO_MARKS, ToolMarks

ToPixels = Callable[[FloatArray], FloatArray]
"""Converts map points (k, 2) [m] to pixels of the viewport (k, 2)."""


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
    """Intersection of the pointer's ray with a link or an object, covered by skin or not, in world coordinates.

    Attributes:
        number: Index of the link, or of the object after the links.
        point: (3,) [m].
        direction: (3,) unit vector of the ray.
        origin: (3,) origin of the body [m].
        rotation: (3, 3) rotation of the body.
    """

    number: int
    point: FloatArray
    direction: FloatArray
    origin: FloatArray
    rotation: FloatArray


@dataclass(frozen=True, eq=False)
class PointerHit:
    """Skin location, map point and body under the pointer.

    Attributes:
        at: Skin location; None next to the skin.
        point: (2,) map point [m]; None in the robot view.
        pixel: Size of a pixel there [m].
        ray: Origin (3,) [m] and unit direction (3,) of the line of sight, for tools that grab links; else None.
        body: First body on that ray, for tools that grab links; else None.
    """

    at: SurfacePoint | None
    point: FloatArray | None
    pixel: float
    ray: tuple[FloatArray, FloatArray] | None = None
    body: BodyHit | None = None


@dataclass(frozen=True)
class ToolBoxes:
    """Boxes in which a tool draws over the map view [px].

    Attributes:
        labels: Boxes of texts, which no caption covers.
        handles: Boxes of handles, which captions cover only if no other space is left.
    """

    labels: Sequence[QRectF] = ()
    handles: Sequence[QRectF] = ()


NO_BOXES = ToolBoxes()


class ViewTool(QObject):
    """Base class of tools in the views; does nothing.

    Tools that edit change the document only through the map editor. Tools that control the arm change the settings
    only through the control settings editor.
    """

    grabs_links: ClassVar[bool] = False
    """True if ``PointerHit`` must contain ray and body."""
    drawn = Signal()
    """``paint`` would draw something else now."""

    @property
    def hint(self) -> str:
        """Instructions for mouse and keys, shown to the user."""
        return ""

    def press(self, place: PointerHit, event: QMouseEvent) -> bool:
        """Handle the pressed left button; True starts a gesture that owns the mouse until the release."""
        return False

    def move(self, place: PointerHit, event: QMouseEvent) -> None:
        """Handle pointer motion, with or without a pressed button."""

    def release(self, place: PointerHit, event: QMouseEvent) -> None:
        """Handle the released left button."""

    def wheel(self, place: PointerHit, event: QWheelEvent) -> bool:
        """Handle the wheel; returns whether this tool used it."""
        return False

    def key(self, event: QKeyEvent) -> bool:
        """Handle a key pressed in the view; returns whether this tool used it."""
        return False

    def overrides_shortcut(self, key: Qt.Key) -> bool:
        """Whether this tool, rather than the window's shortcut, gets a key now."""
        return False

    def cancel(self) -> bool:
        """Cancel the gesture, after Escape, loss of focus or a change of tool; returns whether there was one."""
        return False

    def paint(self, painter: QPainter, to_pixels: ToPixels, theme: Theme) -> None:
        """Draw over the map view, in the viewport's pixels."""

    def boxes(self, to_pixels: ToPixels, font: QFont) -> ToolBoxes:
        """Boxes of what ``paint`` draws with this font, of which captions keep clear."""
        return NO_BOXES

    def body_marks(self) -> ToolMarks:
        """Marks on the body, drawn by the robot view in three dimensions."""
        return NO_MARKS

    def paint_body(self, painter: QPainter, theme: Theme) -> None:
        """Draw what has no location on the skin, such as brush and texts, over the robot view in its pixels."""

    def leave(self) -> None:
        """Handle the pointer leaving the view."""

    def cursor(self, place: PointerHit) -> Qt.CursorShape:
        """Shape of the pointer at this place."""
        return Qt.CursorShape.ArrowCursor


class ShortcutOverrideFilter(QObject):
    """Event filter of a view that keeps some keys from the window's shortcuts, so that the view receives them.

    Args:
        view: The view.
        own: Keys, without modifiers, that the view itself uses.

    Attributes:
        tool: The active tool, or None; queried for each key.
    """

    def __init__(self, view: QWidget, *, own: frozenset[Qt.Key] = frozenset()) -> None:
        super().__init__(view)
        self._own = own
        self.tool: ViewTool | None = None
        view.installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Accept the keys that tool or view use; Qt then delivers the key itself to the view."""
        if event.type() != QEvent.Type.ShortcutOverride or not isinstance(event, QKeyEvent):
            return False
        key = Qt.Key(event.key())
        if (key in self._own and not event.modifiers()) or (
            self.tool is not None and self.tool.overrides_shortcut(key)
        ):
            event.accept()
        return event.isAccepted()
