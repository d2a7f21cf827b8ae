"""The patches in the map's scene, each with its part of the live image."""

from __future__ import annotations

from typing import Any

import numpy as np
from PySide6.QtCore import QLineF, QRectF, Qt
from PySide6.QtGui import QBrush, QColor, QPainter, QPainterPath, QPen, QPolygonF, QTransform
from PySide6.QtWidgets import QGraphicsItem, QStyleOptionGraphicsItem, QWidget
from shiboken6 import VoidPtr

from app.arrays import FloatArray
from widgets.colours import BETWEEN_DOTS, Theme
from widgets.map_view.live_image import LiveImage
from widgets.map_view.map_shapes import ChartShape, Net, PatchShape
from widgets.map_view.tile import Tile

_ROOM = 0.02
"""Around what is drawn, as a share of its size: for lines' widths, and so that nothing has no size."""


def points(places: FloatArray) -> QPolygonF:
    """Points at ``places`` (n, 2), written straight into Qt's memory: one by one they cost 0.7 ms a thousand."""
    polygon = QPolygonF()
    polygon.resize(len(places))
    if len(places):
        pointer: Any = VoidPtr  # its stub knows none of its arguments
        np.frombuffer(pointer(polygon.data(), 16 * len(places), True), np.float64)[:] = np.asarray(
            places, np.float64
        ).ravel()
    return polygon


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


def room_around(places: FloatArray) -> QRectF:
    """A rectangle with some room around ``places`` (n, 2); empty for none."""
    if not len(places):
        return QRectF()
    (left, top), (right, bottom) = places.min(axis=0), places.max(axis=0)
    room = _ROOM * max(right - left, bottom - top) + _ROOM
    return QRectF(left, top, right - left, bottom - top).adjusted(-room, -room, room, room)


class PatchItem(QGraphicsItem):
    """One patch: the live image cut out along its border, a hairline around, seams dashed. Mutable.

    It is drawn in its chart's frame, as large as in the scene; ``place`` moves, turns, mirrors and scales it. While its
    chart is in the hand and has no image, it is drawn as a net.
    """

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self._area, self._brush = QPainterPath(), QBrush()
        self._borders: list[QPolygonF] = []
        self._seams: list[QPolygonF] = []
        self._net: list[QLineF] = []
        self._live: LiveImage | None = None
        self._bounds = QRectF()
        self._show_border = self._show_seams = True
        self.set_theme(theme)

    def show_image(self, shape: ChartShape, scale: float, live: LiveImage, tile: Tile, corner: tuple[int, int]) -> None:
        """Draw a chart by its live image.

        Args:
            shape: The chart's.
            scale: Scene units per metre.
            live: Drawn as it is at each paint; it may change in place.
            tile: The chart's part of it.
            corner: Row and column of the tile's first pixel there.
        """
        self._outline(shape, scale)
        self._net = []
        self._live = live  # keeps the memory behind the brush
        self._brush = QBrush(live.image)
        pixel = scale * tile.resolution
        x, y = scale * tile.corner - pixel * np.array([corner[1], -corner[0]])
        self._brush.setTransform(QTransform(pixel, 0, 0, -pixel, x, y))

    def show_net(self, shape: ChartShape, scale: float, net: Net) -> None:
        """Draw a chart by the lines of a ``net``, on a plain ground. Cost: 2 ms for 3000."""
        self._outline(shape, scale)
        self._net = lines(scale * shape.lines(net))
        self._brush = QBrush(QColor(*BETWEEN_DOTS))

    def place(self, shape: PatchShape, scale: float) -> None:
        """Put it where its patch lies, and hide or show it."""
        (a, b), (c, d) = (shape.placed[:2] / scale).tolist()
        x, y = shape.placed[2].tolist()
        self.setTransform(QTransform(a, b, c, d, x, y))
        self.setVisible(shape.shown)

    def line(self, *, border: bool, seams: bool) -> None:
        """Line the skin's end and dash its cuts, or do not."""
        self._show_border, self._show_seams = border, seams
        self.update()

    def set_theme(self, theme: Theme) -> None:
        """Take the theme's line colour."""
        self._border_ink, self._ground = QColor(theme.quiet), QColor(theme.window)
        self.update()

    def boundingRect(self) -> QRectF:
        """Qt: the chart's rectangle."""
        return self._bounds

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        """Qt: draw image and borders."""
        painter.setRenderHints(QPainter.RenderHint.Antialiasing | QPainter.RenderHint.SmoothPixmapTransform)
        painter.fillPath(self._area, self._brush)
        if self._net:
            self._paint_net(painter)
        if self._show_border:
            painter.setPen(cosmetic(painter, self._border_ink, 1.2))
            for border in self._borders:
                painter.drawPolyline(border)
        if self._show_seams:
            self._paint_seams(painter)

    def _outline(self, shape: ChartShape, scale: float) -> None:
        self.prepareGeometryChange()
        self._bounds = room_around(scale * shape.outline)
        self._area = QPainterPath()
        self._area.addPolygon(points(scale * shape.outline))
        self._area.closeSubpath()
        self._area.setFillRule(Qt.FillRule.WindingFill)
        self._borders = [points(scale * line) for line in shape.border]
        self._seams = [points(scale * line) for line in shape.seam]

    def _paint_net(self, painter: QPainter) -> None:
        painter.setRenderHint(QPainter.RenderHint.Antialiasing, False)  # of thousands of lines half the time
        painter.setPen(cosmetic(painter, QColor(29, 33, 38, 70), 1.0))
        painter.drawLines(self._net)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)

    def _paint_seams(self, painter: QPainter) -> None:
        painter.setPen(cosmetic(painter, self._ground, 4.0))
        for seam in self._seams:
            painter.drawPolyline(seam)
        dashes = cosmetic(painter, self._border_ink, 1.6)
        dashes.setCapStyle(Qt.PenCapStyle.FlatCap)
        dashes.setDashPattern([4.0, 3.0])
        painter.setPen(dashes)
        for seam in self._seams:
            painter.drawPolyline(seam)
