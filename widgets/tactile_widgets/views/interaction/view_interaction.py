"""Mouse and keys on the views: routes Qt's events to pokes, selections, edits and the camera.

A view implements ``ViewPort``: it finds what is under a pixel and moves its camera. Everything else is here, so that
gestures mean the same on the robot and on the map.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

from PySide6.QtCore import QObject, QPointF, Qt, Signal
from PySide6.QtGui import QKeyEvent, QMouseEvent, QWheelEvent
from PySide6.QtWidgets import QWidget

from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_widgets.common.settings import NavigationStyle
from tactile_widgets.common.tool_kinds import POKE, ToolKind
from tactile_widgets.views.interaction.navigation import CameraMotion, motion_of
from tactile_widgets.views.interaction.select_gesture import CLICK_PX, TaxelLocator, TaxelSelector
from tactile_widgets.views.interaction.view_tool import PointerHit, ShortcutOverrideFilter, ViewTool


class ViewPort(TaxelLocator, Protocol):
    """A view that the gestures act on.

    Attributes:
        works_off_skin: Whether tools and selections also work next to the skin, as on the map.
        turns: Whether drags can turn the view; others pan it instead.
        idle_cursor: Pointer shape where a drag can only move the view.
    """

    works_off_skin: bool
    turns: bool
    idle_cursor: Qt.CursorShape

    def point_at(self, pixel: QPointF) -> SurfacePoint | None:
        """Return the skin location under a pixel; None next to the skin and under a placeholder."""

    def hit_at(self, pixel: QPointF, at: SurfacePoint | None) -> PointerHit | None:
        """Return what a tool needs to know about a pixel over ``at``; None if there is nothing to act on."""

    def empty_at(self, pixel: QPointF) -> bool:
        """Whether there is neither skin nor one of the view's controls."""

    def over_control(self, pixel: QPointF) -> bool:
        """Whether one of the view's controls, such as the orientation cube, is there."""

    def click_control(self, pixel: QPointF) -> None:
        """Click the control there."""

    def navigate(self, step: QPointF, motion: CameraMotion) -> None:
        """Move the camera by a drag [px]."""

    def frame_all(self) -> None:
        """Fit the view."""

    def set_hover(self, at: SurfacePoint | None) -> None:
        """Mark the skin location under the pointer."""

    def set_pointer(self, shape: Qt.CursorShape) -> None:
        """Give the pointer this shape over the view."""

    def redraw_tool(self) -> None:
        """Redraw the marks of the active tool."""


@dataclass
class _Hold:
    """A held mouse button that pokes the skin or moves the camera.

    Attributes:
        button: The button; only its release ends the hold.
        pixel: Position of the latest motion.
        at: Skin location of the press, or of a finger that strokes: it stays there while the pointer is off the skin.
        pokes: Whether a finger touches the skin; otherwise the drag moves the camera.
        motion: Motion of the camera by the drag.
        slack: Distance that the pointer must leave before the camera moves [px]; released before that, it is a click.
    """

    button: Qt.MouseButton
    pixel: QPointF
    at: SurfacePoint | None
    pokes: bool
    motion: CameraMotion
    slack: float


class ViewInteraction(QObject):
    """Routes mouse and keys of one view to poke, selection, active tool and camera. Mutable.

    Args:
        port: The view.
        view: The same view as a Qt parent, which receives the keys.

    Attributes:
        style: Buttons that move the camera.
        view_tool: Tool that receives presses of the left button, and keys; None without one.
        taxel_selector: Selection of taxels.
        hover: Skin location under the pointer, or None.
    """

    poke_pressed = Signal(SurfacePoint)
    """The user's finger pressed the skin here."""
    poke_moved = Signal(SurfacePoint)
    poke_pulled = Signal(SurfacePoint)
    """The pressed finger moved here."""
    poke_released = Signal()
    """The user's finger left the skin."""
    hovered = Signal(SurfacePoint)
    """Skin location under the pointer; None next to the skin."""
    cleared = Signal()
    """Escape was pressed outside of any gesture."""
    menu_requested = Signal(QPointF)
    """The right button was clicked without a drag, at this pixel of the view."""
    latch_requested = Signal(SurfacePoint)
    """A Shift-click on the skin: a finger stays here."""
    space_tapped = Signal()
    """Space, which pans during a drag, was pressed and released without one."""

    def __init__(self, port: ViewPort, view: QWidget) -> None:
        super().__init__(view)
        self._port = port
        self._hold: _Hold | None = None
        self._kind = POKE
        self.style = NavigationStyle.STANDARD
        self.view_tool: ViewTool | None = None
        self.taxel_selector = TaxelSelector(port, self)
        self.hover: SurfacePoint | None = None
        self._hit = PointerHit(None, None, 1.0)
        self._editing = self._space = self._over_control = False
        self._tapping = False  # Space is down, and no drag has followed
        self._keys = ShortcutOverrideFilter(view, own=frozenset({Qt.Key.Key_Space}))

    @property
    def editing(self) -> bool:
        """Whether a gesture of the active tool owns the mouse."""
        return self._editing

    @property
    def busy(self) -> bool:
        """Whether a button is held for any gesture."""
        return self._hold is not None or self.taxel_selector.busy or self._editing

    def set_tool(self, kind: ToolKind) -> None:
        """Set the kind of tool; the current gesture ends."""
        self.cancel()
        self._kind = kind
        self.taxel_selector.set_tool(kind)
        self._show_pointer()

    def set_view_tool(self, tool: ViewTool | None) -> None:
        """Pass presses of the left button, and keys, to ``tool``; the previous tool's gesture is cancelled."""
        self.cancel()
        if self.view_tool is not None:
            self.view_tool.drawn.disconnect(self._port.redraw_tool)
        self.view_tool = self._keys.tool = tool
        if tool is not None:
            tool.drawn.connect(self._port.redraw_tool)
        self._show_pointer()
        self._port.redraw_tool()

    def cancel(self, *, discard_drawing: bool = True) -> bool:
        """Cancel the current gesture; returns whether there was one.

        With ``discard_drawing``, also cancel what a tool keeps between presses. A drawing made click by click continues
        in the other view, and pressing there moves the focus away from this one.
        """
        busy = self.busy
        editing = self._editing
        self._editing = False
        self._end_hold()
        self.taxel_selector.cancel()
        if self.view_tool is not None and (discard_drawing or editing):
            busy = self.view_tool.cancel() or busy
        return busy

    # The mouse.

    def press(self, event: QMouseEvent) -> None:
        """Handle a pressed button: click a control, edit, select, poke, or move the view.

        The left button pokes the skin; next to it, and with Shift or Control on it, it moves the view. The other
        buttons move it everywhere, as ``motion_of`` states.
        """
        self._tapping = False
        if self.busy:
            return
        pixel = event.position()
        left = event.button() == Qt.MouseButton.LeftButton
        if left and self._port.over_control(pixel):
            self._port.click_control(pixel)
            return
        at = self._port.point_at(pixel)
        if not left or self._space:
            self._start_hold(event, at, clicks=event.button() == Qt.MouseButton.RightButton)
            return
        self._hover_at(at)
        if not self._press_tool(event, at):
            shift = bool(event.modifiers() & Qt.KeyboardModifier.ShiftModifier)
            control = bool(event.modifiers() & Qt.KeyboardModifier.ControlModifier)
            touches = at is not None and not self._kind.draws
            pokes = touches and not (shift or control)
            self._start_hold(event, at, pokes=pokes, clicks=touches and shift)

    def _press_tool(self, event: QMouseEvent, at: SurfacePoint | None) -> bool:
        """Whether the active tool, or the selection, has taken the press."""
        if self.view_tool is None and not self._kind.selects:
            return False
        hit = self._port.hit_at(event.position(), at)
        if hit is None:
            return False
        self._hit = hit
        if self.view_tool is not None and self.view_tool.press(hit, event):
            self._editing = True
            self._hover_at(None)
        elif self._kind.selects and (at is not None or self._port.works_off_skin):
            self.taxel_selector.press(event)
        else:
            return False
        self._show_pointer()
        return True

    def _start_hold(self, event: QMouseEvent, at: SurfacePoint | None, *, clicks: bool, pokes: bool = False) -> None:
        """Poke, or move the view; where a click has a meaning (``clicks``) only once the pointer has moved."""
        motion = motion_of(self.style, event.button(), event.modifiers())
        if self._space and event.button() == Qt.MouseButton.LeftButton:
            motion = CameraMotion.PAN
        if motion is CameraMotion.TURN and not self._port.turns:
            motion = CameraMotion.PAN
        self._hold = _Hold(event.button(), event.position(), at, pokes, motion, CLICK_PX if clicks else 0.0)
        if pokes:
            self._port.set_hover(None)
            self.poke_pressed.emit(at)
        self._show_pointer()

    def _end_hold(self) -> None:
        hold = self._hold
        self._hold = None
        if hold is not None and hold.pokes:
            self._port.set_hover(self.hover)
            self.poke_released.emit()
        self._show_pointer()

    def move(self, event: QMouseEvent) -> None:
        """Handle pointer motion: stroke, select, edit, move the view, or hover."""
        pixel = event.position()
        hold = self._hold
        if hold is not None and not hold.pokes:
            step = pixel - hold.pixel
            if math.hypot(step.x(), step.y()) > hold.slack:
                hold.pixel = pixel
                hold.slack = 0.0
                self._port.navigate(step, hold.motion)
            return
        self._over_control = not self.busy and self._port.over_control(pixel)
        at = None if self._over_control else self._port.point_at(pixel)
        if hold is not None and at is not None and at != hold.at:
            hold.at = at
            pulls = bool(event.modifiers() & Qt.KeyboardModifier.AltModifier)
            (self.poke_pulled if pulls else self.poke_moved).emit(at)
        if self._kind.selects:
            self.taxel_selector.move(event)
        self._update_hit(pixel, at)
        if self.view_tool is not None and hold is None:
            self.view_tool.move(self._hit, event)
        self._hover_at(None if self._editing else at)
        self._show_pointer()

    def _update_hit(self, pixel: QPointF, at: SurfacePoint | None) -> None:
        self._hit = self._port.hit_at(pixel, at) or PointerHit(None, None, 1.0)

    def release(self, event: QMouseEvent) -> None:
        """Handle a released button: it ends the gesture that it began."""
        if self._editing and self.view_tool is not None:
            if event.button() == Qt.MouseButton.LeftButton:
                self._editing = False
                at = self._port.point_at(event.position())
                self._update_hit(event.position(), at)
                self.view_tool.release(self._hit, event)
                self._hover_at(at)
                self._show_pointer()
            return
        hold = self._hold
        if hold is not None and event.button() == hold.button:
            self._end_hold()
            if hold.slack and event.button() == Qt.MouseButton.RightButton:
                self.menu_requested.emit(hold.pixel)
            elif hold.slack and hold.at is not None:
                self.latch_requested.emit(hold.at)
        if self._kind.selects:
            self.taxel_selector.release(event)

    def double_click(self, event: QMouseEvent) -> None:
        """Fit the view if next to the skin; on the skin, handle a second press."""
        drawing = self.view_tool is not None and self._port.works_off_skin
        if event.button() == Qt.MouseButton.LeftButton and not drawing and self._port.empty_at(event.position()):
            self._port.frame_all()
        else:
            self.press(event)

    def wheel(self, event: QWheelEvent) -> bool:
        """Whether the active tool used the wheel; if not, the view zooms."""
        hit = self._port.hit_at(event.position(), None)
        return hit is not None and self.view_tool is not None and self.view_tool.wheel(hit, event)

    def leave(self) -> None:
        """Handle the pointer leaving the view."""
        self._hover_at(None)
        self.taxel_selector.leave()
        if self.view_tool is not None and not self._editing:
            self.view_tool.leave()

    # The keys.

    def key(self, event: QKeyEvent) -> bool:
        """Whether a gesture or the active tool used the key.

        Escape cancels the gesture, or clears the selection; Space pans during a drag.
        """
        escape = event.key() == Qt.Key.Key_Escape
        if escape and self.cancel():
            return True
        if self.view_tool is not None and self.view_tool.key(event):
            return True
        if escape:
            self.cleared.emit()
        elif event.key() == Qt.Key.Key_Space and not event.modifiers():
            if not event.isAutoRepeat():
                self._space = self._tapping = True
                self._show_pointer()
        else:
            return False
        return True

    def key_up(self, event: QKeyEvent) -> None:
        """Handle a released key."""
        if event.key() == Qt.Key.Key_Space and not event.isAutoRepeat():
            tapped = self._tapping
            self._space = False
            self._tapping = False
            self._show_pointer()
            if tapped:
                self.space_tapped.emit()

    def focus_out(self) -> None:
        """Handle loss of the keyboard focus: the finger is lifted, because no release would arrive."""
        self._space = self._tapping = False
        self.cancel(discard_drawing=False)

    # Inside.

    @property
    def _poking(self) -> bool:
        return self._hold is not None and self._hold.pokes

    def _hover_at(self, at: SurfacePoint | None) -> None:
        if at != self.hover:
            self.hover = at
            self._port.set_hover(None if self._poking else at)
            self._show_pointer()
            self.hovered.emit(at)

    def show_nothing(self) -> None:
        """Handle another scene: cancel the gesture and clear the hover."""
        self.cancel()
        self._hit = PointerHit(None, None, 1.0)
        self._hover_at(None)

    def _show_pointer(self) -> None:
        tool = self.view_tool
        if self._hold is not None and not self._hold.pokes:
            shape = Qt.CursorShape.ClosedHandCursor
        elif self._over_control:
            shape = Qt.CursorShape.PointingHandCursor
        elif self._space and not self._editing:
            shape = Qt.CursorShape.OpenHandCursor
        elif tool is not None and (self.hover is not None or self._editing or self._port.works_off_skin):
            shape = tool.cursor(self._hit)
        elif self.hover is not None or self._poking or (self._kind.selects and self._port.works_off_skin):
            shape = Qt.CursorShape.CrossCursor
        else:
            shape = self._port.idle_cursor
        self._port.set_pointer(shape)
