"""The graphics items of the map: patches, each with its part of the live image, and taxels.

Taxels are dots in the pressure's colour, with rings around the selected ones and numbers on demand. Above them, helpers
that turn arrays into Qt's polygons, lines and pens.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from PySide6.QtCore import QLineF, QPointF, QRectF, Qt
from PySide6.QtGui import QBrush, QColor, QFont, QFontMetricsF, QPainter, QPainterPath, QPen, QPolygonF, QTransform
from PySide6.QtWidgets import QGraphicsItem, QStyleOptionGraphicsItem, QWidget
from shiboken6 import VoidPtr

from app.core.arrays import FloatArray, IntArray
from widgets.common.colours import BETWEEN_DOTS, PressureScale, Theme
from widgets.document.taxel_selection import TAXEL_COLOURS
from widgets.map_view.live_image import AtlasTile, LiveImage
from widgets.map_view.map_shapes import ChartShape, MapShapes, PatchShape, Wireframe

_ROOM = 0.02
"""Around what is drawn, as a share of its size: for lines' widths, and so that nothing has no size."""


def to_polygon(places: FloatArray) -> QPolygonF:
    """Points at ``places`` (n, 2), written straight into Qt's memory: one by one they cost 0.7 ms a thousand."""
    polygon = QPolygonF()
    polygon.resize(len(places))
    if len(places):
        pointer: Any = VoidPtr  # its stub knows none of its arguments
        np.frombuffer(pointer(polygon.data(), 16 * len(places), True), np.float64)[:] = np.asarray(
            places, np.float64
        ).ravel()
    return polygon


def to_lines(segments: FloatArray) -> list[QLineF]:
    """Lines of ``segments`` (s, 2, 2)."""
    return [QLineF(x0, y0, x1, y1) for (x0, y0), (x1, y1) in segments.tolist()]


def cosmetic_pen(painter: QPainter, colour: QColor, width: float) -> QPen:
    """A round pen as wide as asked in logical pixels, whatever the zoom and the display's scale."""
    device = painter.device()
    pen = QPen(colour, width * device.devicePixelRatio())  # cosmetic widths are in the device's own pixels
    pen.setCapStyle(Qt.PenCapStyle.RoundCap)
    pen.setJoinStyle(Qt.PenJoinStyle.RoundJoin)
    pen.setCosmetic(True)
    return pen


def padded_bounds(places: FloatArray) -> QRectF:
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

    def show_image(
        self, shape: ChartShape, scale: float, live: LiveImage, tile: AtlasTile, corner: tuple[int, int]
    ) -> None:
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

    def show_wireframe(self, shape: ChartShape, scale: float, net: Wireframe) -> None:
        """Draw a chart by the lines of a ``net``, on a plain ground. Cost: 2 ms for 3000."""
        self._outline(shape, scale)
        self._net = to_lines(scale * shape.lines(net))
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
            painter.setPen(cosmetic_pen(painter, self._border_ink, 1.2))
            for border in self._borders:
                painter.drawPolyline(border)
        if self._show_seams:
            self._paint_seams(painter)

    def _outline(self, shape: ChartShape, scale: float) -> None:
        self.prepareGeometryChange()
        self._bounds = padded_bounds(scale * shape.outline)
        self._area = QPainterPath()
        self._area.addPolygon(to_polygon(scale * shape.outline))
        self._area.closeSubpath()
        self._area.setFillRule(Qt.FillRule.WindingFill)
        self._borders = [to_polygon(scale * line) for line in shape.border]
        self._seams = [to_polygon(scale * line) for line in shape.seam]

    def _paint_net(self, painter: QPainter) -> None:
        painter.setRenderHint(QPainter.RenderHint.Antialiasing, False)  # of thousands of lines half the time
        painter.setPen(cosmetic_pen(painter, QColor(29, 33, 38, 70), 1.0))
        painter.drawLines(self._net)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)

    def _paint_seams(self, painter: QPainter) -> None:
        painter.setPen(cosmetic_pen(painter, self._ground, 4.0))
        for seam in self._seams:
            painter.drawPolyline(seam)
        dashes = cosmetic_pen(painter, self._border_ink, 1.6)
        dashes.setCapStyle(Qt.PenCapStyle.FlatCap)
        dashes.setDashPattern([4.0, 3.0])
        painter.setPen(dashes)
        for seam in self._seams:
            painter.drawPolyline(seam)


TAXELS_FROM_PITCH_PX = 20.0
"""Taxels are drawn once their distance on the screen reaches this: below, dots would hide the image."""
COLOUR_BUCKETS = 32
"""Colours in which taxels are drawn; one call of Qt for each."""
_DARK = QColor(29, 33, 38, 120)
_ID_PX = 10


class TaxelsItem(QGraphicsItem):
    """The taxels as dots, ringed to stand out of the image; only when zoomed in enough, or asked for.

    Attributes:
        dots: Whether dots are the picture: shown at every zoom, as large as their distance allows.
        numbered: Whether their numbers are written, as many as have room.
    """

    def __init__(self, font: QFont) -> None:
        super().__init__()
        self.dots = self.numbered = False
        self._places: FloatArray = np.zeros((0, 2))
        self._pitch = 0.0
        self._drawn = self._held = np.zeros(0, int)
        self._kilopascals: FloatArray = np.zeros(0)
        self._scale: PressureScale | None = None
        self._colours: list[tuple[QColor, QPolygonF]] = []
        self._selected: IntArray = np.zeros(0, int)
        self._inks: tuple[str, ...] = ()
        self._rings: list[tuple[QColor, QPolygonF]] = []
        self._font = QFont(font)
        self._font.setPixelSize(_ID_PX)
        self._bounds = QRectF()

    def place(self, shapes: MapShapes, held: Sequence[int] = ()) -> None:
        """Put them where the map has them now; those of the patches that are ``held`` are dots at every zoom."""
        self.prepareGeometryChange()
        self._places, self._pitch = shapes.taxels, shapes.pitch
        self._drawn, self._bounds = np.flatnonzero(shapes.on_shown()), padded_bounds(shapes.taxels)
        first = np.cumsum([0, *(len(patch.chart.taxels) for patch in shapes.patches)])
        held = [k for k in held if shapes.patches[k].shown]
        self._held = np.concatenate([np.zeros(0, int), *(np.arange(first[k], first[k + 1]) for k in held)])
        self._colours = []
        self.select(self._selected, self._inks)

    def colour(self, kilopascals: FloatArray, scale: PressureScale) -> None:
        """Take the pressures (n,) [kPa]; they are sorted into colours when next drawn."""
        self._kilopascals, self._scale, self._colours = kilopascals, scale, []

    def select(self, taxels: IntArray, inks: tuple[str, ...]) -> None:
        """Ring these (k,), each in its colour."""
        self._selected, self._inks = taxels, inks
        seen, by_ink = np.isin(taxels, self._drawn), np.array(inks, dtype=str)
        self._rings = [
            (QColor(str(ink)), to_polygon(self._places[taxels[seen & (by_ink == ink)]])) for ink in dict.fromkeys(inks)
        ]
        self.update()

    def visible_at(self, pixels_per_unit: float) -> bool:
        """Whether all dots are drawn at this zoom."""
        return self.dots or self._pitch * pixels_per_unit >= TAXELS_FROM_PITCH_PX

    def boundingRect(self) -> QRectF:
        """Qt: around all taxels."""
        return self._bounds

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        """Qt: draw dots, rings and numbers."""
        pixels_per_unit = option.levelOfDetailFromTransform(painter.worldTransform())
        pitch = self._pitch * pixels_per_unit
        if self._scale is None:
            return
        if self.visible_at(pixels_per_unit):
            size = min(max(0.62 * pitch, 3.0), 24.0) if self.dots else min(2.0 + 0.1 * pitch, 9.0)
            self._paint_dots(painter, size, self._scale)
        elif len(self._held):
            self._paint_held(painter, min(max(0.36 * pitch, 2.5), 9.0), self._scale)
        if self._rings:
            least = 2.0 if len(self._selected) > len(TAXEL_COLOURS) else 6.0
            self._paint_selected(painter, min(max(0.36 * pitch, least), 9.0), self._scale)
        if self.numbered:
            self._paint_numbers(painter, 10.0 if self.visible_at(pixels_per_unit) or self._rings else 0.0)

    def _paint_dots(self, painter: QPainter, size: float, scale: PressureScale) -> None:
        self._colours = self._colours or self._sorted(self._drawn, scale)
        if not self.dots:  # over the picture they need a rim; as the picture they stand on a darker ground
            painter.setPen(cosmetic_pen(painter, _DARK, size + 1.6))
            painter.drawPoints(to_polygon(self._places[self._drawn]))
        for colour, dots in self._colours:
            painter.setPen(cosmetic_pen(painter, colour, size))
            painter.drawPoints(dots)

    def _paint_held(self, painter: QPainter, size: float, scale: PressureScale) -> None:
        for colour, dots in self._sorted(self._held, scale):
            painter.setPen(cosmetic_pen(painter, colour, size))
            painter.drawPoints(dots)

    def _paint_selected(self, painter: QPainter, size: float, scale: PressureScale) -> None:
        for colour, places in self._rings:
            for ink, rim in ((_DARK, 0.9 * size + 1.6), (colour, 0.9 * size)):
                painter.setPen(cosmetic_pen(painter, ink, size + min(rim, 5.0)))
                painter.drawPoints(places)
        for colour, places in self._sorted(np.intersect1d(self._selected, self._drawn), scale):
            painter.setPen(cosmetic_pen(painter, colour, size))
            painter.drawPoints(places)

    def _paint_numbers(self, painter: QPainter, above: float) -> None:
        """So many pixels above the taxels; where there is no room for all, those that are selected go first."""
        view = painter.worldTransform()
        room = QRectF(painter.viewport()).adjusted(-20, -10, 20, 10)
        painter.save()
        painter.setWorldTransform(QTransform())
        painter.setFont(self._font)
        painter.setPen(QColor(29, 33, 38))
        metrics = QFontMetricsF(self._font)
        width, height = metrics.horizontalAdvance(str(len(self._places))) + 6, metrics.height() + 1
        for taxel, at in self._with_room(view, room, width, height):
            text = str(taxel)
            tight = metrics.horizontalAdvance(text) + 4
            box = QRectF(at.x() - tight / 2, at.y() - above - height / 2, tight, height)
            painter.fillRect(box, QColor(255, 255, 255, 130))
            painter.drawText(box, Qt.AlignmentFlag.AlignCenter, text)
        painter.restore()

    def _with_room(self, view: QTransform, room: QRectF, width: float, height: float) -> list[tuple[int, QPointF]]:
        """Taxels and their pixels, such that no two numbers of this size overlap."""
        others = np.setdiff1d(self._drawn, self._selected)
        taken: dict[tuple[int, int], QPointF] = {}
        found = []
        for taxel in np.concatenate([np.intersect1d(self._selected, self._drawn), others]).tolist():
            at = view.map(QPointF(*self._places[taxel].tolist()))
            column, row = int(at.x() // width), int(at.y() // height)
            around = [taken.get((column + dx, row + dy)) for dx in (-1, 0, 1) for dy in (-1, 0, 1)]
            if room.contains(at) and all(
                other is None or abs(other.x() - at.x()) >= width or abs(other.y() - at.y()) >= height
                for other in around
            ):
                taken[column, row] = at
                found.append((taxel, at))
        return found

    def _sorted(self, taxels: IntArray, scale: PressureScale) -> list[tuple[QColor, QPolygonF]]:
        """Places of these taxels by the colour of their pressure."""
        share = np.clip(self._kilopascals[taxels] / scale.maximum, 0, 1)
        bucket = np.ceil(share * (COLOUR_BUCKETS - 1)).astype(int)
        entry = np.arange(COLOUR_BUCKETS) * (len(scale.lut) - 1) // (COLOUR_BUCKETS - 1)
        return [
            (QColor.fromRgb(int(scale.lut[entry[k]])), to_polygon(self._places[taxels[bucket == k]]))
            for k in np.unique(bucket)
        ]
