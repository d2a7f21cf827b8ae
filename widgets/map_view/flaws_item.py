"""Where the map is not one-to-one, marked so that it cannot be overlooked: flipped triangles and overlaps."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QColor, QPainter, QPolygonF
from PySide6.QtWidgets import QGraphicsItem, QStyleOptionGraphicsItem, QWidget

from app.maps.overlay import Flaws
from widgets.colours import Theme
from widgets.map_view.map_hit import MapFrame
from widgets.map_view.map_items import cosmetic, lines, points

_CROSS_PX = 5.0
_MOST = 400
"""Marks drawn; where a map is as broken as that, more would only hide it."""


class FlawsItem(QGraphicsItem):
    """A red triangle with a dot for every flip, a red cross for every overlap, whatever the zoom.

    Args:
        flaws: What to mark.
        frame: Places the map in the scene.
        theme: Its colour for faults.
    """

    def __init__(self, flaws: Flaws, frame: MapFrame, theme: Theme) -> None:
        super().__init__()
        flips, crosses = frame.to_scene(flaws.flips[:_MOST]), frame.to_scene(flaws.overlaps[:_MOST])
        self._triangles = [QPolygonF(points(corners)) for corners in flips]
        self._dots = points(flips.mean(axis=1)) if len(flips) else []
        self._crosses = crosses
        self._bounds = QRectF(0, 0, *frame.size).adjusted(-2, -2, 2, 2)
        self._ink = QColor(theme.fault)

    def boundingRect(self) -> QRectF:
        """Qt: the map's rectangle."""
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
