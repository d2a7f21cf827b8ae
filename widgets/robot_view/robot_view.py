"""The live robot under the hand: presses on the skin become pokes, selections and edits, others move the camera."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from PySide6.QtCore import QEvent, QObject, QPointF, Qt
from PySide6.QtGui import QFocusEvent, QKeyEvent, QMouseEvent, QWheelEvent
from PySide6.QtWidgets import QWidget

from app.geometry.mesh import SurfacePoint
from app.session.prepare import PreparedScene
from widgets.common.colours import PressureScale, Theme
from widgets.common.tool_kinds import ToolKind
from widgets.interaction.poke_gesture import Panned
from widgets.interaction.select_gesture import Pixel
from widgets.interaction.view_interaction import ViewInteraction
from widgets.interaction.view_tool import PointerHit, ViewTool
from widgets.overlays.body_overlays import NO_MARKS
from widgets.robot_view.body_layer import BodyLayerFactory
from widgets.robot_view.camera import look_from, orbit, pan, zoom
from widgets.robot_view.caption_overlay import CubeFace
from widgets.robot_view.robot_display import RobotDisplay

_WHEEL_STEP = 1.15


class RobotView(RobotDisplay):
    """The robot and the hand on it: a ``ViewPort`` whose ``interaction`` emits what the hand does. Decides nothing.

    Left presses poke the skin, select taxels or go to the active tool, and turn the view beside the skin; middle or
    with Shift they pan; the wheel zooms; a click on the orientation cube looks from that side, a double click beside
    the skin frames the robot.

    Args:
        theme: Colours of everything that is not skin.
        scale: Colours of pressure.
        parent: Qt parent.
        layers: Makes each layer that has actors, by name.

    Attributes:
        interaction: The hand; its signals are also the view's.
    """

    beside_skin, turns, idle_cursor = False, True, Qt.CursorShape.OpenHandCursor

    def __init__(
        self,
        theme: Theme,
        scale: PressureScale,
        parent: QWidget | None = None,
        *,
        layers: Mapping[str, BodyLayerFactory] | None = None,
    ) -> None:
        super().__init__(theme, scale, parent, layers=layers)
        hand = self.interaction = ViewInteraction(self, self)
        self.poke_pressed, self.poke_moved, self.poke_released = hand.poke_pressed, hand.poke_moved, hand.poke_released
        self.hovered, self.cleared, self.taxel_selector = hand.hovered, hand.cleared, hand.taxel_selector
        self.taxel_selector.drawn.connect(self._on_rubber_drawn)
        self.canvas.widget.installEventFilter(self)
        self.setObjectName("robot-view")
        self.setAccessibleName("Robot")
        self.setAccessibleDescription("Press the skin to poke it. Drag beside it to turn the view.")
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setMinimumSize(200, 200)
        self.show_empty()

    def show_prepared(self, prepared: PreparedScene) -> None:
        """Show the robot of ``prepared`` at home, framed; if it cannot be, the last one stays."""
        self.interaction.show_nothing()
        super().show_prepared(prepared)

    def set_tool(self, tool: ToolKind) -> None:
        """Take another tool; what the hand was doing ends."""
        self.interaction.set_tool(tool)

    def set_view_tool(self, tool: ViewTool | None) -> None:
        """Give left presses on the skin, and keys, to this tool; None for none."""
        self._overlay.tool = tool
        self.interaction.set_view_tool(tool)

    def close_view(self) -> None:
        """Give the graphics back; the view draws nothing after this."""
        self.set_view_tool(None)
        self.canvas.widget.removeEventFilter(self)
        super().close_view()

    def _show_card(self, heading: str, text: str, *, button: str, progress: float | None = None) -> None:
        self.interaction.cancel()
        super()._show_card(heading, text, button=button, progress=progress)

    def _on_morphed(self, share: float) -> None:
        self.interaction.cancel()
        super()._on_morphed(share)

    def _on_rubber_drawn(self) -> None:
        self._say(replace(self._captions, rubber_band=self.taxel_selector.rubber_band))

    # What the hand asks.

    def point_at(self, pixel: QPointF) -> SurfacePoint | None:
        """The place of the skin under a pixel; None beside the skin, and under a message."""
        if self._picker is None or self._card.isVisible():
            return None
        ray = self.scene.viewpoint.ray((pixel.x(), pixel.y()), (self.width(), self.height()))
        return self.scene.pick_flat(ray) if self.scene.morphed else self._picker.pick(ray, self.scene.body_poses)

    def hit_at(self, pixel: QPointF, at: SurfacePoint | None) -> PointerHit | None:
        """What a tool is told of a pixel over ``at``; None without a robot, and under a message."""
        if self.prepared is None or self._card.isVisible():
            return None
        return PointerHit(at, None, self.pixel_size(at))

    def empty_at(self, pixel: QPointF) -> bool:
        """Whether there is neither skin nor orientation cube."""
        return not self._overlay.near_cube(pixel) and self.point_at(pixel) is None

    def over_control(self, pixel: QPointF) -> bool:
        """Whether the orientation cube is there."""
        return self._cube_at(pixel) is not None

    def click_control(self, pixel: QPointF) -> None:
        """Look from the side of the cube that was clicked."""
        if (side := self._cube_at(pixel)) is not None:
            self.look(look_from(self.scene.viewpoint, side.normal))

    def navigate(self, drag: Panned, *, turn: bool) -> None:
        """Turn around the robot, or pan."""
        self.look((orbit if turn else pan)(self.scene.viewpoint, drag.dx, drag.dy, self.height()))

    def set_pointer(self, shape: Qt.CursorShape) -> None:
        """Give the pointer this shape."""
        self.canvas.widget.setCursor(shape)

    def redraw_tool(self) -> None:
        """Show what the active tool marks on the body, and paint what it draws over the view."""
        tool = self.interaction.view_tool
        self.set_marks(NO_MARKS if tool is None else tool.body_marks())
        self._overlay.update()

    def taxel_at(self, pixel: Pixel) -> int | None:
        """The taxel nearest to the skin under a pixel; None beside the skin."""
        at = self.point_at(QPointF(*pixel))
        return None if at is None or self._taxels is None else self._taxels.nearest(at)

    def _cube_at(self, pixel: QPointF) -> CubeFace | None:
        return None if self.prepared is None or self._card.isVisible() else self._overlay.cube_face_at(pixel)

    # Qt's events.

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Qt: all of the canvas's mouse and wheel; the canvas's own handling never sees them."""
        if isinstance(event, QMouseEvent):
            self._mouse(event)
            return True
        if isinstance(event, QWheelEvent):
            if not self.interaction.wheel(event):
                self.look(zoom(self.scene.viewpoint, _WHEEL_STEP ** (event.angleDelta().y() / 120)))
            return True
        if event.type() == QEvent.Type.Leave:
            self.interaction.leave()
        return False

    def _mouse(self, event: QMouseEvent) -> None:
        kind = event.type()
        if kind == QEvent.Type.MouseMove:
            self.interaction.move(event)
        elif kind == QEvent.Type.MouseButtonRelease:
            self.interaction.release(event)
        else:
            self.setFocus(Qt.FocusReason.MouseFocusReason)
            (self.interaction.press if kind == QEvent.Type.MouseButtonPress else self.interaction.double_click)(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Qt: the hand's first; else F frames the robot."""
        if self.interaction.key(event):
            event.accept()
        elif event.key() == Qt.Key.Key_F and not event.modifiers():
            self.frame_all()
        else:
            super().keyPressEvent(event)

    def keyReleaseEvent(self, event: QKeyEvent) -> None:
        """Qt: the hand's."""
        self.interaction.key_up(event)

    def focusOutEvent(self, event: QFocusEvent) -> None:
        """Qt: what is held is let go."""
        self.interaction.focus_out()
        super().focusOutEvent(event)
