"""What lies still in the map's scene: the patches with their live image, and the taxels."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QLineF, QPointF, QRectF, Qt
from PySide6.QtGui import QBrush, QColor, QPainter, QPainterPath, QPen, QPolygonF, QTransform
from PySide6.QtWidgets import QGraphicsItem, QStyleOptionGraphicsItem, QWidget

from app.arrays import FloatArray
from widgets.colours import PressureScale, Theme
from widgets.map_view.live_image import LiveImage
from widgets.map_view.map_shapes import MapShapes

TAXELS_FROM_PITCH_PX = 20.0
"""Taxels are drawn once their distance on the screen reaches this: below, dots would hide the image."""
BUCKETS = 32
"""Colours in which taxels are drawn; one call of Qt for each."""


def points(places: FloatArray) -> list[QPointF]:
    """Points at ``places`` (n, 2)."""
    return [QPointF(x, y) for x, y in places.tolist()]


def lines(segments: FloatArray) -> list[QLineF]:
    """Lines of ``segments`` (s, 2, 2)."""
    return [QLineF(x0, y0, x1, y1) for (x0, y0), (x1, y1) in segments.tolist()]


def cosmetic(painter: QPainter, colour: QColor, width: float) -> QPen:
    """A round pen as wide as asked in logical pixels, whatever the zoom and the display's scale."""
    device = painter.device()
    pen = QPen(colour, width * device.devicePixelRatio())  # cosmetic widths are in the device's own pixels
    pen.setCapStyle(Qt.PenCapStyle.RoundCap)
    pen.setJoinStyle(Qt.PenJoinStyle.RoundJoin)
    pen.setCosmetic(True)
    return pen


class PatchesItem(QGraphicsItem):
    """All patches: the live image cut out along their borders, a hairline around, seams dashed.

    Args:
        shapes: The map's shapes.
        live: Its image is drawn as it is at each paint; it may change in place.
        place: Where the image lies [scene units].
    """

    def __init__(self, shapes: MapShapes, live: LiveImage, place: QRectF, theme: Theme) -> None:
        super().__init__()
        self._area = QPainterPath()
        for patch in shapes.patches:
            self._area.addPolygon(QPolygonF(points(patch.outline)))
            self._area.closeSubpath()
        self._area.setFillRule(Qt.FillRule.WindingFill)
        self._borders = [points(line) for patch in shapes.patches for line in patch.border]
        self._seams = [points(line) for patch in shapes.patches for line in patch.seam]
        self._live = live  # keeps the memory behind the brush
        self._brush, image = QBrush(live.image), live.image
        to_scene = QTransform.fromTranslate(place.x(), place.y())
        self._brush.setTransform(to_scene.scale(place.width() / image.width(), place.height() / image.height()))
        self._bounds = QRectF(0, 0, *shapes.frame.size).adjusted(-2, -2, 2, 2)
        self.set_theme(theme)

    def set_theme(self, theme: Theme) -> None:
        """Take the theme's line colour."""
        self._border_ink, self._ground = QColor(theme.quiet), QColor(theme.window)
        self.update()

    def boundingRect(self) -> QRectF:
        """Qt: the map's rectangle."""
        return self._bounds

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        """Qt: draw image and borders."""
        painter.setRenderHints(QPainter.RenderHint.Antialiasing | QPainter.RenderHint.SmoothPixmapTransform)
        painter.fillPath(self._area, self._brush)
        painter.setPen(cosmetic(painter, self._border_ink, 1.2))
        for border in self._borders:
            painter.drawPolyline(border)
        painter.setPen(cosmetic(painter, self._ground, 4.0))
        for seam in self._seams:
            painter.drawPolyline(seam)
        dashes = cosmetic(painter, self._border_ink, 1.6)
        dashes.setCapStyle(Qt.PenCapStyle.FlatCap)
        dashes.setDashPattern([4.0, 3.0])
        painter.setPen(dashes)
        for seam in self._seams:
            painter.drawPolyline(seam)


class TaxelsItem(QGraphicsItem):
    """The taxels as dots in the pressure's colour, ringed to stand out of the image; only when zoomed in enough."""

    def __init__(self, shapes: MapShapes) -> None:
        super().__init__()
        self._points, self._pitch = points(shapes.taxels), shapes.pitch
        self._dots: list[tuple[QColor, list[QPointF]]] = []
        self._kilopascals = np.zeros(len(shapes.taxels))
        self._scale: PressureScale | None = None
        self._bounds = QRectF(0, 0, *shapes.frame.size).adjusted(-2, -2, 2, 2)

    def colour(self, kilopascals: FloatArray, scale: PressureScale) -> None:
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
        size = min(2.0 + 0.1 * self._pitch * pixels_per_unit, 9.0)
        painter.setPen(cosmetic(painter, QColor(29, 33, 38, 120), size + 1.6))
        painter.drawPoints(self._points)
        for colour, dots in self._dots:
            painter.setPen(cosmetic(painter, colour, size))
            painter.drawPoints(dots)

    def _buckets(self, scale: PressureScale) -> list[tuple[QColor, list[QPointF]]]:
        share = np.clip(self._kilopascals / scale.maximum, 0, 1)
        bucket = np.ceil(share * (BUCKETS - 1)).astype(int)
        entry = np.arange(BUCKETS) * (len(scale.lut) - 1) // (BUCKETS - 1)
        return [
            (QColor.fromRgb(int(scale.lut[entry[k]])), [self._points[i] for i in np.flatnonzero(bucket == k).tolist()])
            for k in np.unique(bucket)
        ]
