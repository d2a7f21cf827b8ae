"""What lies still in the map's scene: the patches with their live image, and the taxels."""

from __future__ import annotations

import numpy as np
import shiboken6
from PySide6.QtCore import QLineF, QPointF, QRectF, Qt
from PySide6.QtGui import QBrush, QColor, QImage, QPainter, QPainterPath, QPen, QPolygonF, QTransform
from PySide6.QtWidgets import QGraphicsItem, QStyleOptionGraphicsItem, QWidget

from app.arrays import FloatArray
from widgets.colours import PressureScale, Theme
from widgets.map_view.map_shapes import MapShapes

TAXELS_FROM_PITCH_PX = 11.0
"""Taxels are drawn once their distance on the screen reaches this: below, dots would hide the image."""
BUCKETS = 32


def polygon(points: FloatArray) -> QPolygonF:
    """A polygon of ``points`` (n, 2), copied in one piece rather than point by point."""
    result = QPolygonF()
    if len(points):
        result.resize(len(points))
        memory = shiboken6.VoidPtr(result.data(), 16 * len(points), True)
        np.frombuffer(memory, np.float64).reshape(-1, 2)[:] = points
    return result


def lines(segments: FloatArray) -> list[QLineF]:
    """Lines of ``segments`` (s, 2, 2)."""
    return [QLineF(x0, y0, x1, y1) for (x0, y0), (x1, y1) in segments.tolist()]


def cosmetic(colour: QColor, width: float, style: Qt.PenStyle = Qt.PenStyle.SolidLine) -> QPen:
    """A round pen whose width is in pixels whatever the zoom."""
    pen = QPen(colour, width, style, Qt.PenCapStyle.RoundCap, Qt.PenJoinStyle.RoundJoin)
    pen.setCosmetic(True)
    return pen


class PatchesItem(QGraphicsItem):
    """All patches: the live image cut out along their borders, a hairline around, seams dashed.

    Args:
        shapes: The map's shapes.
        image: Drawn as it is at each paint; it may change in place.
        place: Where the image lies [scene units].
    """

    def __init__(self, shapes: MapShapes, image: QImage, place: QRectF, theme: Theme) -> None:
        super().__init__()
        self._area = QPainterPath()
        for patch in shapes.patches:
            self._area.addPolygon(polygon(patch.outline))
            self._area.closeSubpath()
        self._area.setFillRule(Qt.FillRule.WindingFill)
        self._border = [line for patch in shapes.patches for line in lines(patch.border)]
        self._seams = [line for patch in shapes.patches for line in lines(patch.seam)]
        self._brush = QBrush(image)
        to_scene = QTransform.fromTranslate(place.x(), place.y())
        self._brush.setTransform(to_scene.scale(place.width() / image.width(), place.height() / image.height()))
        self._bounds = QRectF(0, 0, *shapes.frame.size).adjusted(-2, -2, 2, 2)
        self.set_theme(theme)

    def set_theme(self, theme: Theme) -> None:
        """Take the theme's line colour."""
        ink = QColor(theme.quiet)
        self._border_pen = cosmetic(ink, 1.2)
        self._seam_pen = cosmetic(ink, 1.0)
        self._seam_pen.setDashPattern([4.0, 4.0])
        self.update()

    def boundingRect(self) -> QRectF:
        """Qt: the map's rectangle."""
        return self._bounds

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        """Qt: draw image and borders."""
        painter.setRenderHints(QPainter.RenderHint.Antialiasing | QPainter.RenderHint.SmoothPixmapTransform)
        painter.fillPath(self._area, self._brush)
        painter.setPen(self._border_pen)
        painter.drawLines(self._border)
        painter.setPen(self._seam_pen)
        painter.drawLines(self._seams)


class TaxelsItem(QGraphicsItem):
    """The taxels as dots in the pressure's colour, ringed to stand out of the image; only when zoomed in enough."""

    def __init__(self, shapes: MapShapes) -> None:
        super().__init__()
        self._points, self._pitch = shapes.taxels, shapes.pitch
        self._rings = polygon(shapes.taxels)
        self._dots: list[tuple[QColor, QPolygonF]] = []
        self._kilopascals = np.zeros(len(shapes.taxels))
        self._scale: PressureScale | None = None
        self._bounds = QRectF(0, 0, *shapes.frame.size).adjusted(-2, -2, 2, 2)

    def show(self, kilopascals: FloatArray, scale: PressureScale) -> None:
        """Take the pressures (n,) [kPa]; they are sorted into colours when next drawn."""
        self._kilopascals, self._scale, self._dots = kilopascals, scale, []

    def visible_at(self, pixels_per_unit: float) -> bool:
        """Whether the dots are drawn at this zoom."""
        return self._pitch * pixels_per_unit >= TAXELS_FROM_PITCH_PX

    def boundingRect(self) -> QRectF:
        """Qt: the map's rectangle."""
        return self._bounds

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        """Qt: draw the dots."""
        pixels_per_unit = option.levelOfDetailFromTransform(painter.worldTransform())
        if self._scale is None or not self.visible_at(pixels_per_unit):
            return
        if not self._dots:
            self._dots = self._buckets(self._scale)
        size = min(2.5 + 0.12 * self._pitch * pixels_per_unit, 9.0)
        painter.setPen(cosmetic(QColor(29, 33, 38, 150), size + 1.6))
        painter.drawPoints(self._rings)
        for colour, points in self._dots:
            painter.setPen(cosmetic(colour, size))
            painter.drawPoints(points)

    def _buckets(self, scale: PressureScale) -> list[tuple[QColor, QPolygonF]]:
        share = np.clip(self._kilopascals / scale.maximum, 0, 1)
        bucket = np.ceil(share * (BUCKETS - 1)).astype(int)
        entry = np.arange(BUCKETS) * (len(scale.lut) - 1) // (BUCKETS - 1)
        return [
            (QColor.fromRgb(int(scale.lut[entry[k]])), polygon(self._points[bucket == k])) for k in np.unique(bucket)
        ]


def point(values: FloatArray) -> QPointF:
    """A point of ``values`` (2,)."""
    return QPointF(float(values[0]), float(values[1]))
