"""View of the robot: presses on the skin become pokes, selections and edits, others move the camera.

``MorphSlider`` flattens the skin, from the body at its left end to the map at its right end.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from PySide6.QtCore import QEvent, QObject, QPointF, QPropertyAnimation, QRectF, Qt, Signal
from PySide6.QtGui import QFocusEvent, QHideEvent, QKeyEvent, QMouseEvent, QResizeEvent, QShowEvent, QWheelEvent
from PySide6.QtWidgets import QLabel, QSlider, QWidget

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.session.prepare import PreparedScene
from tactile_widgets.common.colours import PressureScale, Theme
from tactile_widgets.common.make import column_layout, make, row_layout
from tactile_widgets.common.tool_kinds import ToolKind
from tactile_widgets.views.interaction.navigation import CameraMotion
from tactile_widgets.views.interaction.select_gesture import Pixel
from tactile_widgets.views.interaction.view_interaction import ViewInteraction
from tactile_widgets.views.interaction.view_tool import BodyHit, PointedAt, PointerHit, ViewTool
from tactile_widgets.views.overlays.body_overlays import NO_MARKS
from tactile_widgets.views.overlays.placeholder_card import CardTexts, PlaceholderCard
from tactile_widgets.views.robot.actors.camera import CameraRay, look_from, zoom
from tactile_widgets.views.robot.actors.robot_actors import BodyLayerFactory
from tactile_widgets.views.robot.caption_overlay import CubeFace
from tactile_widgets.views.robot.picking import BodyTaxels, SkinPicker, facing_pixels
from tactile_widgets.views.robot.robot_display import RobotDisplay

_WHEEL_STEP = 1.15
_TEXTS = CardTexts(
    "No robot yet",
    "Open a robot, or drop its file here: MJCF, URDF or a bare mesh.",
    "Preparing the robot",
    "The robot could not be opened",
)
_DOES = "Press the skin to poke it. Drag next to it, or with Control, to turn the view."
STEPS = 100
EASE_MS = 150
_WIDTH = 190
_HEIGHT = 24
_LEFT = 6
"""Smallest distance of the slider from the left edge of the view [px]."""


class MorphSlider(QWidget):
    """Small slider from body to map; ``toggle`` moves it to the other end with an animation."""

    moved = Signal(float)
    """Requested flatness, from 0 to 1."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setObjectName("morph")
        self.setAttribute(Qt.WidgetAttribute.WA_StyledBackground)
        left = make(QLabel, "Body", self, role="caption")
        self.slider = make(
            QSlider,
            Qt.Orientation.Horizontal,
            self,
            maximum=STEPS,
            accessibleName="Flatten: body to map",
            toolTip="Flatten the skin with the pressures on it; each point moves straight to the map",
            focusPolicy=Qt.FocusPolicy.TabFocus,
            role="caption",
            valueChanged=self._on_value_changed,
        )
        right = make(QLabel, "Map", self, role="caption")
        row_layout(left, self.slider, right, parent=self, spacing=6, margins=(6, 0, 6, 0))
        self._ease = QPropertyAnimation(self.slider, b"value", self)
        self._ease.setDuration(EASE_MS)
        self.resize(_WIDTH, _HEIGHT)
        self.hide()

    @property
    def share(self) -> float:
        """Flatness: 0 on the body, 1 as on the map."""
        return self.slider.value() / STEPS

    def toggle(self) -> None:
        """Move to the other end."""
        self._ease.stop()
        self._ease.setStartValue(self.slider.value())
        self._ease.setEndValue(STEPS if self.share < 0.5 else 0)
        self._ease.start()

    def reset(self) -> None:
        """Return to the body without an animation."""
        self._ease.stop()
        self.slider.setValue(0)

    def _on_value_changed(self, _value: int) -> None:
        self.moved.emit(self.share)


_CUBE_ROOM = 78
"""Width of the orientation cube in the lower right corner [px]."""


class RobotView(QWidget):
    """A ``RobotDisplay`` and a ``ViewPort`` for the gestures on it, which ``interaction`` reports.

    - The left button pokes the skin, selects taxels or operates the active tool; next to the skin it turns the view.
    - The left button with Control turns the view everywhere, and with Shift pans it; the wheel zooms.
    - The right and the middle button move the view as the style of navigation states, see ``motion_of``.
    - A click on the orientation cube shows that side; a double click next to the skin fits the robot to the view.

    Args:
        theme: Colours of everything except the skin.
        scale: Colours of pressure.
        parent: Qt parent.
        layers: Factories of the layers drawn on the body, by name.
        off_screen: Whether the pictures are not shown on a display.

    Attributes:
        display: The picture of the robot.
        card: Placeholder shown while there is no robot.
        morph: Slider that flattens the skin.
        interaction: Gestures on the robot; its signals report them.
    """

    hidden_changed = Signal()
    """Other links or objects are hidden."""

    works_off_skin = False
    turns = True
    idle_cursor = Qt.CursorShape.OpenHandCursor

    def __init__(
        self,
        theme: Theme,
        scale: PressureScale,
        parent: QWidget | None = None,
        *,
        layers: Mapping[str, BodyLayerFactory] | None = None,
        off_screen: bool = False,
    ) -> None:
        super().__init__(parent)
        self._picker: SkinPicker | None = None
        self._taxels: BodyTaxels | None = None
        self.display = RobotDisplay(self, theme, scale, layers=layers, off_screen=off_screen)
        column_layout(self.display.canvas.widget, parent=self)
        self.morph = MorphSlider(self)
        self.morph.moved.connect(self._on_morphed)
        self.card = PlaceholderCard(_TEXTS, self)
        self.card.covered.connect(self._on_covered)
        self.interaction = ViewInteraction(self, self)
        self.interaction.taxel_selector.drawn.connect(self._on_rubber_drawn)
        self.display.canvas.widget.installEventFilter(self)
        self.setObjectName("robot-view")
        self.setAccessibleName("Robot")
        self.setAccessibleDescription(_DOES)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setMinimumSize(200, 200)
        self.card.show_empty()

    def show_prepared(self, prepared: PreparedScene) -> None:
        """Show the robot of ``prepared`` in its home posture, fitted to the view; on failure keep the previous one."""
        self.interaction.show_nothing()
        picker = SkinPicker(prepared)
        self.morph.reset()
        self.card.clear()
        self.display.show_prepared(prepared)
        self.morph.show()
        self._reserve_control()
        picker.hidden = self.display.actors.hidden
        self._picker = picker
        self._taxels = BodyTaxels(prepared, picker)
        self.hidden_changed.emit()

    def hide_bodies(self, bodies: frozenset[int]) -> None:
        """Hide these links, with their skin, and objects, numbered after the links; show all others.

        Hidden bodies cannot be pressed; map and simulation keep them.
        """
        if self._picker is not None and bodies != self._picker.hidden:
            self.interaction.cancel()
            self._picker.hidden = bodies
            self.display.hide(bodies)
            self.hidden_changed.emit()

    def set_tool(self, tool: ToolKind) -> None:
        """Set the tool; the current gesture ends."""
        self.interaction.set_tool(tool)

    def set_view_tool(self, tool: ViewTool | None) -> None:
        """Pass left presses on the skin, and keys, to this tool."""
        self.display.overlay.tool = tool
        self.interaction.set_view_tool(tool)

    def close_view(self) -> None:
        """Release the graphics resources; the view draws nothing after this."""
        self.set_view_tool(None)
        self.display.canvas.widget.removeEventFilter(self)
        self._picker = self._taxels = None
        self.display.close()

    def _on_covered(self, covered: bool) -> None:
        if covered:
            self.interaction.cancel()
        self.display.cover(covered)

    def _on_morphed(self, share: float) -> None:
        self.interaction.cancel()
        self.display.actors.morph(share)
        self.display.request(moving=True)

    def _on_rubber_drawn(self) -> None:
        self.display.set_rubber_band(self.interaction.taxel_selector.rubber_band)

    # The ``ViewPort`` of the gestures.

    def point_at(self, pixel: QPointF) -> SurfacePoint | None:
        """Return the skin location under a pixel; None next to the skin and under the placeholder."""
        if self._picker is None or self.card.isVisible():
            return None
        actors = self.display.actors
        ray = self._ray(pixel)
        return actors.pick_flat(ray) if actors.morphed else self._picker.pick(ray, actors.body_poses)

    def _ray(self, pixel: QPointF) -> CameraRay:
        return self.display.actors.viewpoint.ray((pixel.x(), pixel.y()), self.display.size)

    def pointed_at(self, pixel: QPointF) -> PointedAt:
        """Return what is under a pixel: skin, or else the link or object."""
        at = self.point_at(pixel)
        actors = self.display.actors
        if at is not None or self._picker is None or self.card.isVisible() or actors.morphed:
            return PointedAt(at)
        return PointedAt(None, self._picker.bare_body(self._ray(pixel), actors.body_poses))

    def hit_at(self, pixel: QPointF, at: SurfacePoint | None) -> PointerHit | None:
        """Return what a tool needs to know about a pixel over ``at``; None without a robot."""
        if self.display.prepared is None or self.card.isVisible():
            return None
        size = self.display.pixel_size(at)
        tool = self.interaction.view_tool
        if tool is None or not tool.grabs_links:
            return PointerHit(at, None, size)
        ray = self._ray(pixel)
        return PointerHit(at, None, size, (ray.origin, ray.direction), self._body_along(ray))

    def _body_along(self, ray: CameraRay) -> BodyHit | None:
        actors = self.display.actors
        met = None if self._picker is None or actors.morphed else self._picker.any_body(ray, actors.body_poses)
        if met is None:
            return None
        pose = actors.body_poses[met[0]]
        return BodyHit(met[0], ray.origin + met[1] * ray.direction, ray.direction, pose[:3, 3], pose[:3, :3])

    def empty_at(self, pixel: QPointF) -> bool:
        """Whether there is neither skin nor orientation cube."""
        return not self.display.overlay.near_cube(pixel) and self.point_at(pixel) is None

    def over_control(self, pixel: QPointF) -> bool:
        """Whether the orientation cube is there."""
        return self._cube_at(pixel) is not None

    def click_control(self, pixel: QPointF) -> None:
        """Show the robot from the clicked side of the cube."""
        if (side := self._cube_at(pixel)) is not None:
            self.display.look(look_from(self.display.actors.viewpoint, side.normal))

    def navigate(self, step: QPointF, motion: CameraMotion) -> None:
        """Turn the view around the robot, or pan or zoom it."""
        self.display.navigate(step, motion)

    def set_pointer(self, shape: Qt.CursorShape) -> None:
        """Set the shape of the pointer."""
        self.display.canvas.widget.setCursor(shape)

    def redraw_tool(self) -> None:
        """Show the active tool's marks on the body and its drawings over the view."""
        tool = self.interaction.view_tool
        self.display.set_marks(NO_MARKS if tool is None else tool.body_marks())
        self.display.overlay.update()

    def frame_all(self) -> None:
        """Fit the whole robot to the view."""
        self.display.frame_all()

    def set_hover(self, at: SurfacePoint | None) -> None:
        """Mark the skin location under the pointer."""
        self.display.set_hover(at)

    def pixel_of(self, at: SurfacePoint) -> QPointF:
        """Return the pixel of a skin location; raises RobotError without a robot."""
        return self.display.pixel_of(at)

    def taxel_pixels(self) -> FloatArray:
        """(taxels, 2) pixels of taxels that face the camera; NaN for others."""
        if self._taxels is None:
            return np.zeros((0, 2))
        actors = self.display.actors
        size = self.display.size
        if actors.morphed:
            return facing_pixels(*actors.flat_taxels(), actors.viewpoint, size)
        return self._taxels.pixels(actors.viewpoint, size, actors.poses)

    def hidden(self, taxels: IntArray) -> BoolArray:
        """(k,) whether the robot or an object hides each of these taxels; off the body, none is hidden."""
        actors = self.display.actors
        if self._taxels is None or actors.morphed:
            return np.zeros(len(taxels), bool)
        return self._taxels.hidden(taxels, actors.viewpoint, actors.body_poses)

    def taxel_at(self, pixel: Pixel) -> int | None:
        """Return the taxel nearest to the skin under a pixel; None next to the skin."""
        at = self.point_at(QPointF(*pixel))
        return None if at is None or self._taxels is None else self._taxels.nearest(at)

    def _cube_at(self, pixel: QPointF) -> CubeFace | None:
        covered = self.display.prepared is None or self.card.isVisible()
        return None if covered else self.display.overlay.cube_face_at(pixel)

    # Events.

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Handle all mouse and wheel events of the canvas instead of VTK."""
        if isinstance(event, QMouseEvent):
            self._mouse(event)
            return True
        if isinstance(event, QWheelEvent):
            if not self.interaction.wheel(event):
                self.display.look(zoom(self.display.actors.viewpoint, _WHEEL_STEP ** (event.angleDelta().y() / 120)))
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
        """Pass keys to the gestures; of those left, F fits the view."""
        if self.interaction.key(event):
            event.accept()
        elif event.key() == Qt.Key.Key_F and not event.modifiers():
            self.frame_all()
        else:
            super().keyPressEvent(event)

    def keyReleaseEvent(self, event: QKeyEvent) -> None:
        self.interaction.key_up(event)

    def focusOutEvent(self, event: QFocusEvent) -> None:
        """Release what is held."""
        self.interaction.focus_out()
        super().focusOutEvent(event)

    def showEvent(self, event: QShowEvent) -> None:
        """Draw the newest frame."""
        super().showEvent(event)
        self.display.request()

    def hideEvent(self, event: QHideEvent) -> None:
        """Stop drawing while hidden."""
        super().hideEvent(event)
        self.display.stop()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Draw at the new size, and keep covering the view with the placeholder."""
        super().resizeEvent(event)
        self.display.resize()
        self.card.setGeometry(self.rect())
        self.morph.resize(min(_WIDTH, self.width() - _CUBE_ROOM - _LEFT), _HEIGHT)
        self.morph.move(self.width() - self.morph.width() - _CUBE_ROOM, self.height() - self.morph.height() - 11)
        self._reserve_control()

    def hide_morph(self) -> None:
        """Hide the slider that flattens the skin, for pictures."""
        self.morph.hide()
        self._reserve_control()

    def _reserve_control(self) -> None:
        """Keep captions off the slider, if it is shown."""
        self.display.overlay.control = QRectF() if self.morph.isHidden() else QRectF(self.morph.geometry())
