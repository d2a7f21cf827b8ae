"""The live tactile map under the hand: presses on it become pokes at body points, selections of taxels, or edits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from PySide6.QtCore import QEvent, QPointF, Qt, Signal
from PySide6.QtGui import QFocusEvent, QKeyEvent, QMouseEvent, QPainter, QWheelEvent
from PySide6.QtWidgets import QWidget

from app.core.arrays import BoolArray, FloatArray, IntArray
from app.geometry.mesh import SurfacePoint
from app.session.prepare import PreparedScene
from widgets.common.colours import PressureScale, Theme
from widgets.common.tool_kinds import ToolKind
from widgets.interaction.poke_gesture import Panned
from widgets.interaction.select_gesture import Pixel, RubberBand
from widgets.interaction.view_interaction import ViewInteraction
from widgets.interaction.view_tool import PointerHit, ViewTool
from widgets.map_view.live_image import ImageAtlas
from widgets.map_view.map_coordinates import nearest_taxel
from widgets.map_view.map_display import MapDisplay
from widgets.map_view.map_layer import MapLayerFactory

_POKES = "Press a patch to poke the robot there. Drag beside the patches to pan."
_SELECTS = "Click taxels or draw around them to select them. Escape selects none."
_EDITS = "Edit the map with the active tool. Drag with the middle button, or with Space, to pan."
_LEADS = "Draw the reference path or target. Drag with the middle button, or with Space, to pan."


class MapView(MapDisplay):
    """The map and the hand on it: a ``ViewPort`` whose ``interaction`` emits what the hand does. Decides nothing.

    Args:
        theme: Colours of everything that is not skin.
        scale: Colours of pressure.
        parent: Qt parent.
        layers: Makes each layer that has items, by name.

    Attributes:
        interaction: The hand; its signals are also the view's.
    """

    readout = Signal(str)
    """The words for what is under the pointer; the view shows them too."""
    beside_skin, turns, idle_cursor = True, False, Qt.CursorShape.ArrowCursor

    def __init__(
        self,
        theme: Theme,
        scale: PressureScale,
        parent: QWidget | None = None,
        *,
        layers: Mapping[str, MapLayerFactory] | None = None,
    ) -> None:
        super().__init__(theme, scale, parent, layers=layers)
        hand = self.interaction = ViewInteraction(self, self)
        self.poke_pressed, self.poke_moved, self.poke_released = hand.poke_pressed, hand.poke_moved, hand.poke_released
        self.hovered, self.cleared, self.taxel_selector = hand.hovered, hand.cleared, hand.taxel_selector
        self.hovered.connect(self._read_out)
        self.taxel_selector.drawn.connect(self.viewport().update)
        self.setAccessibleDescription(_POKES)
        self.show_empty()

    def show_prepared(self, prepared: PreparedScene, *, atlas: ImageAtlas | None = None) -> None:
        """Show the map of ``prepared``, framed; ``atlas`` saves building its live image here."""
        self.interaction.cancel()
        super().show_prepared(prepared, atlas=atlas)
        self.interaction.show_nothing()

    def set_tool(self, tool: ToolKind) -> None:
        """Take another tool; what the hand was doing ends."""
        self.interaction.set_tool(tool)
        kinds = ((tool.edits, _EDITS), (tool.controls, _LEADS), (tool.selects, _SELECTS), (True, _POKES))
        self.setAccessibleDescription(next(words for holds, words in kinds if holds))

    def set_view_tool(self, tool: ViewTool | None) -> None:
        """Give presses of the left button, and keys, to ``tool``; what the one before was doing is given up."""
        self.interaction.set_view_tool(tool)

    def _show_card(self, heading: str, text: str, *, button: str, progress: float | None = None) -> None:
        self.interaction.cancel()
        super()._show_card(heading, text, button=button, progress=progress)

    def _refresh(self) -> None:
        super()._refresh()
        self._read_out()

    def _read_out(self) -> None:
        words = self.words_for(self.interaction.hover)
        if words != self._marks.readout:
            self._mark(replace(self._marks, readout=words))
            self.readout.emit(words)

    # What the hand asks.

    @property
    def _covered(self) -> bool:
        return self._picture is None or self._card.isVisible()

    def point_at(self, pixel: QPointF) -> SurfacePoint | None:
        """The place of the skin under a pixel; None beside the patches, and under a message."""
        if self._picture is None or self._covered:
            return None
        place = self.scene_point(pixel)
        return self._picture.hit(place.x(), place.y())

    def hit_at(self, pixel: QPointF, at: SurfacePoint | None) -> PointerHit | None:
        """What a tool is told of a pixel over ``at``; None without a map, and under a message."""
        if self._picture is None or self._covered:
            return None
        scene, frame = self.scene_point(pixel), self._picture.shapes.frame
        return PointerHit(at, frame.to_map(np.array([scene.x(), scene.y()])), self._pixel())

    def empty_at(self, pixel: QPointF) -> bool:
        """Whether a pixel is beside the patches."""
        return self.point_at(pixel) is None

    def over_control(self, pixel: QPointF) -> bool:
        """A map has no controls of its own."""
        return False

    def click_control(self, pixel: QPointF) -> None:
        """A map has no controls of its own."""

    def navigate(self, drag: Panned, *, turn: bool) -> None:
        """Pan."""
        self.pan(drag.dx, drag.dy)

    def set_pointer(self, shape: Qt.CursorShape) -> None:
        """Give the pointer this shape."""
        self.viewport().setCursor(shape)

    def redraw_tool(self) -> None:
        """Paint what the active tool draws over the map."""
        self.viewport().update()

    def taxel_at(self, pixel: Pixel) -> int | None:
        """The taxel nearest to a pixel of a patch; None beside the patches."""
        at = self.point_at(QPointF(*pixel))
        return None if at is None or self._picture is None else nearest_taxel(self._picture.map, at)

    def hidden(self, taxels: IntArray) -> BoolArray:
        """Nothing hides anything on a map."""
        return np.zeros(len(taxels), bool)

    def _pixel(self) -> float:
        """Side of a pixel on the map [m]."""
        return (
            1.0 if self._picture is None else 1.0 / (self._picture.shapes.frame.scale * self.viewportTransform().m11())
        )

    # What the hand draws.

    def rubber_band(self) -> RubberBand:
        """What the gesture draws over the map."""
        return self.taxel_selector.rubber_band

    def _paint_over(self, painter: QPainter) -> None:
        if (tool := self.interaction.view_tool) is not None:
            tool.paint(painter, self._to_pixels, self._theme)

    def _to_pixels(self, points: FloatArray) -> FloatArray:
        """Map points (k, 2) [m] as pixels of the viewport."""
        if self._picture is None:
            return np.zeros((0, 2))
        view = self.viewportTransform()
        return self._picture.shapes.frame.to_scene(points) * [view.m11(), view.m22()] + [view.dx(), view.dy()]

    # Qt's events.

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Qt: left and middle buttons are the hand's."""
        if event.button() in (Qt.MouseButton.LeftButton, Qt.MouseButton.MiddleButton):
            self.interaction.press(event)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Qt: the hand's."""
        self.interaction.move(event)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """Qt: the hand's."""
        self.interaction.release(event)

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        """Qt: left and middle buttons are the hand's."""
        if event.button() in (Qt.MouseButton.LeftButton, Qt.MouseButton.MiddleButton):
            self.interaction.double_click(event)

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Qt: the tool's, where it has something to turn there; else it zooms."""
        if self.interaction.wheel(event):
            event.accept()
        else:
            super().wheelEvent(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Qt: the hand's first; else F frames all, plus and minus zoom, arrows pan."""
        if not self.interaction.key(event):
            super().keyPressEvent(event)

    def keyReleaseEvent(self, event: QKeyEvent) -> None:
        """Qt: the hand's."""
        self.interaction.key_up(event)

    def focusOutEvent(self, event: QFocusEvent) -> None:
        """Qt: what is held is let go."""
        self.interaction.focus_out()
        super().focusOutEvent(event)

    def leaveEvent(self, event: QEvent) -> None:
        """Qt: nothing is under the pointer."""
        self.interaction.leave()
        super().leaveEvent(event)
