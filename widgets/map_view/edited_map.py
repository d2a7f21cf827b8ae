"""The live tactile map under a tool that edits it or leads the arm: what is under the pointer for it, how it looks."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QPointF, Qt
from PySide6.QtGui import QMouseEvent, QPainter, QWheelEvent
from PySide6.QtWidgets import QWidget

from app.arrays import FloatArray
from app.geometry.surface_point import SurfacePoint
from widgets.colours import PressureScale, Theme
from widgets.edit_tool import EditTool, Place
from widgets.map_view.map_display import MapDisplay
from widgets.tool_keys import ToolKeys


class EditedMap(MapDisplay):
    """Hands presses, the wheel and keys to a tool; decides nothing.

    Args:
        theme: Colours of everything that is not skin.
        scale: Colours of pressure.
        parent: Qt parent.

    Attributes:
        edit_tool: The one in the hand, or None.
    """

    def __init__(self, theme: Theme, scale: PressureScale, parent: QWidget | None = None) -> None:
        super().__init__(theme, scale, parent)
        self.edit_tool: EditTool | None = None
        self._editing, self._place, self._keys = False, Place(None, None, 1.0), ToolKeys(self)

    def _at(self, position: QPointF) -> SurfacePoint | None:
        """The place of the skin under a pixel; None beside the patches, and under a message."""
        if self._picture is None or self._card.isVisible():
            return None
        place = self.scene_point(position)
        return self._picture.hit(place.x(), place.y())

    def _place_at(self, position: QPointF, at: SurfacePoint | None) -> Place:
        if self._picture is None or self._card.isVisible():
            return Place(None, None, 1.0)
        scene, frame = self.scene_point(position), self._picture.shapes.frame
        return Place(at, frame.to_map(np.array([scene.x(), scene.y()])), self._pixel())

    def _pixel(self) -> float:
        """Side of a pixel on the map [m]."""
        return (
            1.0 if self._picture is None else 1.0 / (self._picture.shapes.frame.scale * self.viewportTransform().m11())
        )

    def _press_edit(self, event: QMouseEvent, at: SurfacePoint | None) -> bool:
        """Whether the edit tool has taken the press."""
        if self.edit_tool is None or event.button() != Qt.MouseButton.LeftButton:
            return False
        self._place = self._place_at(event.position(), at)
        self._editing = self._place.point is not None and self.edit_tool.press(self._place, event)
        return self._editing

    def _paint_over(self, painter: QPainter) -> None:
        if self.edit_tool is not None:
            self.edit_tool.paint(painter, self._to_pixels, self._theme)

    def _to_pixels(self, points: FloatArray) -> FloatArray:
        """Map points (k, 2) [m] as pixels of the viewport."""
        if self._picture is None:
            return np.zeros((0, 2))
        view = self.viewportTransform()
        return self._picture.shapes.frame.to_scene(points) * [view.m11(), view.m22()] + [view.dx(), view.dy()]

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Qt: the tool's, where it has something to turn there; else it zooms."""
        place = self._place_at(event.position(), None)
        if self.edit_tool is not None and self.edit_tool.wheel(place, event):
            event.accept()
        else:
            super().wheelEvent(event)
