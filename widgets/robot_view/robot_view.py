"""The live robot under the hand: turns presses on the skin into pokes, selections and edits, others into camera moves.

``EditToolRouter`` hands mouse and keys to the active edit tool and says whether it owns the mouse.
"""

from __future__ import annotations

from dataclasses import replace

from PySide6.QtCore import QEvent, QObject, QPointF, Qt, Signal
from PySide6.QtGui import QFocusEvent, QKeyEvent, QMouseEvent, QWheelEvent
from PySide6.QtWidgets import QWidget

from app.geometry.mesh import SurfacePoint
from app.session.prepare import PreparedScene
from widgets.common.colours import PressureScale, Theme
from widgets.common.tool_kinds import ToolKind
from widgets.interaction.poke_gesture import Moved, Panned, PokeEvent, PokeGesture, PokeState, Pressed, Released
from widgets.interaction.select_gesture import Pixel, TaxelSelector
from widgets.interaction.view_tool import PointerHit, ShortcutOverrideFilter, ViewTool
from widgets.overlays.body_overlays import NO_MARKS
from widgets.robot_view.camera import look_from, orbit, pan, zoom
from widgets.robot_view.caption_overlay import CubeFace
from widgets.robot_view.robot_display import RobotDisplay


class EditToolRouter:
    """Hands mouse and keys to an edit tool. Mutable; idle without a tool.

    Attributes:
        tool: The one in the hand, or None.
        held: Whether a gesture of it owns the mouse.
    """

    def __init__(self) -> None:
        self.tool: ViewTool | None = None
        self.held = False

    def press(self, place: PointerHit, event: QMouseEvent) -> bool:
        """The left button went down; whether the tool took it."""
        self.held = self.tool is not None and self.tool.press(place, event)
        return self.held

    def move(self, place: PointerHit, event: QMouseEvent) -> None:
        """The pointer moved."""
        if self.tool is not None:
            self.tool.move(place, event)

    def release(self, place: PointerHit, event: QMouseEvent) -> bool:
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

    def cancel(self, *, discard_drawing: bool) -> bool:
        """Whether there was a gesture to give up; if not ``discard_drawing``, only one that holds the mouse is.

        What is drawn click by click goes on in the other view: pressing there takes the focus from this one.
        """
        held, self.held = self.held, False
        return (held or discard_drawing) and self.tool is not None and self.tool.cancel()


_WHEEL_STEP = 1.15


class RobotView(RobotDisplay):
    """Draws the robot and emits what the hand did; decides nothing.

    Left presses poke the skin, choose taxels or go to the tool that edits, and turn the view beside the skin; middle or
    with Shift they pan; the wheel zooms; a click on the orientation cube looks from that side, a double click beside
    the skin frames the robot.

    Args:
        theme: Colours of everything that is not skin.
        scale: Colours of pressure.
        parent: Qt parent.
    """

    poke_pressed = Signal(object)
    """A press on skin: the SurfacePoint under it."""
    poke_moved = Signal(object)
    """A stroke of the pressed finger: the SurfacePoint it is at now."""
    poke_released = Signal()
    """The finger left."""
    hovered = Signal(object)
    """The SurfacePoint under the pointer, or None."""
    cleared = Signal()
    """Escape, while nothing else was going on."""

    def __init__(self, theme: Theme, scale: PressureScale, parent: QWidget | None = None) -> None:
        super().__init__(theme, scale, parent)
        self._hand, self._button, self._tool = PokeGesture(), Qt.MouseButton.NoButton, ToolKind.POKE
        self._hover: SurfacePoint | None = None
        self._editing, self._keys, self._on_cube = EditToolRouter(), ShortcutOverrideFilter(self), False
        self.taxel_selector = TaxelSelector(self, self)
        self.taxel_selector.drawn.connect(self._on_rubber_drawn)
        self.canvas.widget.installEventFilter(self)
        self.setObjectName("robot-view")
        self.setAccessibleName("Robot")
        self.setAccessibleDescription("Press the skin to poke it. Drag beside it to turn the view.")
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setMinimumSize(200, 200)
        self.show_empty()

    # What is shown.

    def show_prepared(self, prepared: PreparedScene) -> None:
        """Show the robot of ``prepared`` at home, framed; if it cannot be, the last one stays."""
        self._cancel_gesture()
        self._hover_at(None)
        super().show_prepared(prepared)

    def set_tool(self, tool: ToolKind) -> None:
        """Take another tool; what the hand was doing ends."""
        self._cancel_gesture()
        self._tool = tool
        self.taxel_selector.set_tool(tool)
        self._show_cursor()

    def set_view_tool(self, tool: ViewTool | None) -> None:
        """Give left presses on the skin, and keys, to this tool; None for none."""
        self._cancel_gesture()
        if self._editing.tool is not None:
            self._editing.tool.drawn.disconnect(self._on_tool_drawn)
        self._editing.tool = self._overlay.tool = self._keys.tool = tool
        if tool is not None:
            tool.drawn.connect(self._on_tool_drawn)
        self._on_tool_drawn()

    def close_view(self) -> None:
        """Give the graphics back; the view draws nothing after this."""
        self.set_view_tool(None)
        self.canvas.widget.removeEventFilter(self)
        super().close_view()

    def _show_card(self, heading: str, text: str, *, button: str, progress: float | None = None) -> None:
        self._cancel_gesture()
        super()._show_card(heading, text, button=button, progress=progress)

    def _on_morphed(self, share: float) -> None:
        self._cancel_gesture()
        super()._on_morphed(share)

    def _on_tool_drawn(self) -> None:
        self.set_marks(NO_MARKS if self._editing.tool is None else self._editing.tool.body_marks())
        self._overlay.update()

    # Where things are, for choosing.

    def taxel_at(self, pixel: Pixel) -> int | None:
        """The taxel nearest to the skin under a pixel; None beside the skin."""
        at = self._at(QPointF(*pixel))
        return None if at is None or self._taxels is None else self._taxels.nearest(at)

    def _on_rubber_drawn(self) -> None:
        self._say(replace(self._captions, rubber_band=self.taxel_selector.rubber_band))

    # The hand.

    def _at(self, position: QPointF) -> SurfacePoint | None:
        if self._picker is None or self._card.isVisible():
            return None
        ray = self.scene.viewpoint.ray((position.x(), position.y()), (self.width(), self.height()))
        return self.scene.pick_flat(ray) if self.scene.morphed else self._picker.pick(ray, self.scene.body_poses)

    def _act(self, act: PokeEvent | None) -> None:
        if isinstance(act, Pressed):
            self.set_hover(None)
            self.poke_pressed.emit(act.at)
        elif isinstance(act, Moved):
            self.poke_moved.emit(act.at)
        elif isinstance(act, Released):
            self.set_hover(self._hover)
            self.poke_released.emit()
        elif isinstance(act, Panned):
            move = orbit if self._button == Qt.MouseButton.LeftButton else pan
            self.look(move(self.scene.viewpoint, act.dx, act.dy, self.height()))
        self._show_cursor()

    def _cancel_gesture(self, *, discard_drawing: bool = True) -> bool:
        """Nothing is in the hand any more; whether an edit was given up. See ``EditHand.cancel``."""
        self._act(self._hand.cancel())
        self.taxel_selector.cancel()
        return self._editing.cancel(discard_drawing=discard_drawing)

    def _hover_at(self, at: SurfacePoint | None) -> None:
        if at != self._hover:
            self._hover = at
            self.set_hover(None if self._hand.mode is PokeState.POKING else at)
            self._show_cursor()
            self.hovered.emit(at)

    def _cube_at(self, position: QPointF) -> CubeFace | None:
        return None if self.prepared is None or self._card.isVisible() else self._overlay.cube_face_at(position)

    def _place(self, at: SurfacePoint | None) -> PointerHit:
        return PointerHit(at, None, self.pixel_size(at))

    def _show_cursor(self) -> None:
        shape = Qt.CursorShape.PointingHandCursor if self._on_cube else Qt.CursorShape.OpenHandCursor
        if self._hand.mode is PokeState.PANNING:
            shape = Qt.CursorShape.ClosedHandCursor
        elif self._editing.tool is not None and (self._hover is not None or self._editing.held):
            shape = self._editing.tool.cursor(self._place(self._hover))
        elif self._hover is not None or self._hand.mode is PokeState.POKING:
            shape = Qt.CursorShape.CrossCursor
        self.canvas.widget.setCursor(shape)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Qt: all of the canvas's mouse and wheel; the canvas's own handling never sees them."""
        if isinstance(event, QMouseEvent):
            self._mouse(event)
            return True
        if isinstance(event, QWheelEvent):
            self.look(zoom(self.scene.viewpoint, _WHEEL_STEP ** (event.angleDelta().y() / 120)))
            return True
        if event.type() == QEvent.Type.Leave:
            self._hover_at(None)
            self.taxel_selector.leave()
            self._editing.leave()
        return False

    def _mouse(self, event: QMouseEvent) -> None:
        kind = event.type()
        if kind == QEvent.Type.MouseButtonPress:
            self._press(event)
        elif kind == QEvent.Type.MouseMove:
            self._on_cube = self._hand.mode is PokeState.IDLE and self._cube_at(event.position()) is not None
            at = None if self._hand.mode is PokeState.PANNING or self._on_cube else self._at(event.position())
            self._act(self._hand.move(event.position().toTuple(), at))
            if self._hand.mode is PokeState.IDLE:
                self._editing.move(self._place(at), event)
            if self._tool.chooses:
                self.taxel_selector.move(event)
            self._hover_at(at)
            self._show_cursor()
        elif kind == QEvent.Type.MouseButtonRelease:
            self._release(event)
        elif event.button() == Qt.MouseButton.LeftButton and not self._anything_at(event.position()):
            self.frame_all()
        else:  # on the skin a second quick press is a second poke, on the cube another look
            self._press(event)

    def _anything_at(self, position: QPointF) -> bool:
        return self._overlay.near_cube(position) or self._at(position) is not None

    def _press(self, event: QMouseEvent) -> None:
        self.setFocus(Qt.FocusReason.MouseFocusReason)
        left, idle = event.button() == Qt.MouseButton.LeftButton, self._hand.mode is PokeState.IDLE
        side = self._cube_at(event.position()) if left and idle and not self._editing.held else None
        if side is not None:
            self.look(look_from(self.scene.viewpoint, side.normal))
            return
        at = self._at(event.position()) if left else None
        if self._editing.held or (left and idle and self._editing.press(self._place(at), event)):
            self._show_cursor()
        elif self._tool.chooses and left and idle and (at is not None or self.taxel_selector.busy):
            self.taxel_selector.press(event)
        elif not self.taxel_selector.busy:
            turns = left and not event.modifiers() & Qt.KeyboardModifier.ShiftModifier
            self._button = Qt.MouseButton.LeftButton if turns else Qt.MouseButton.MiddleButton
            at = at if turns and not self._tool.draws else None
            self._act(self._hand.press(event.position().toTuple(), at, button=event.button(), pan=at is None))

    def _release(self, event: QMouseEvent) -> None:
        left = event.button() == Qt.MouseButton.LeftButton
        if left and self._editing.release(self._place(self._at(event.position())), event):
            self._show_cursor()
            return
        self._act(self._hand.release(event.button()))
        if self._tool.chooses:
            self.taxel_selector.release(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Qt: Escape ends what the hand does, or selects nothing; F frames the robot; others may be the tool's."""
        if event.key() == Qt.Key.Key_Escape:
            busy = self._hand.mode is not PokeState.IDLE or self.taxel_selector.busy
            if not self._cancel_gesture() and not busy:
                self.cleared.emit()
        elif self._editing.key(event):
            event.accept()
        elif event.key() == Qt.Key.Key_F and not event.modifiers():
            self.frame_all()
        else:
            super().keyPressEvent(event)

    def focusOutEvent(self, event: QFocusEvent) -> None:
        """Qt: a finger never stays pressed where no hand can lift it."""
        self._cancel_gesture(discard_drawing=False)
        super().focusOutEvent(event)
