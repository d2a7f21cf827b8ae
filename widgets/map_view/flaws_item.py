"""Where the map is not one-to-one, marked so that it cannot be overlooked: flipped triangles and overlaps."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QColor, QPainter, QPolygonF
from PySide6.QtWidgets import QGraphicsItem, QStyleOptionGraphicsItem, QWidget

from app.arrays import FloatArray
from app.maps.overlay import Flaws
from widgets.colours import Theme
from widgets.map_view.map_hit import MapFrame
from widgets.map_view.map_items import cosmetic, lines, points, room_around

_CROSS_PX = 5.0
_MOST = 400
"""Marks drawn; where a map is as broken as that, more would only hide it."""


class FlawsItem(QGraphicsItem):
    """A red triangle with a dot for every flip, a red cross for every overlap, whatever the zoom. Mutable: ``mark``."""

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self._triangles: list[QPolygonF] = []
        self._dots = QPolygonF()
        self._crosses: FloatArray = np.zeros((0, 2))
        self._bounds = QRectF()
        self._ink = QColor(theme.fault)

    def mark(self, flaws: Flaws, frame: MapFrame) -> None:
        """Mark these; ``frame`` places the map in the scene."""
        flips, crosses = frame.to_scene(flaws.flips[:_MOST]), frame.to_scene(flaws.overlaps[:_MOST])
        places = np.concatenate([flips.reshape(-1, 2), crosses])
        self.prepareGeometryChange()
        self._bounds = room_around(places)
        self._triangles = [points(corners) for corners in flips]
        self._dots = points(flips.mean(axis=1)) if len(flips) else QPolygonF()
        self._crosses = crosses

    def boundingRect(self) -> QRectF:
        """Qt: around all marks."""
        return self._bounds

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        """Qt: draw the marks."""
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(cosmetic(painter, self._ink, 1.5))
        painter.setBrush(QColor(224, 49, 49, 120))
        for triangle in self._triangles:
            painter.drawPolygon(triangle)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        reach = _CROSS_PX / option.levelOfDetailFromTransform(painter.worldTransform())
        arms = np.array([[[-1.0, -1.0], [1.0, 1.0]], [[-1.0, 1.0], [1.0, -1.0]]])
        for colour, width in ((QColor(255, 255, 255), 4.5), (self._ink, 2.2)):
            painter.setPen(cosmetic(painter, colour, 2.2 * width))
            painter.drawPoints(self._dots)
            painter.setPen(cosmetic(painter, colour, width))
            painter.drawLines(lines((self._crosses[:, None, None] + reach * arms).reshape(-1, 2, 2)))
