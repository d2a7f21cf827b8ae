"""The taxels in the map's scene: dots in the pressure's colour, rings around the selected ones, numbers on demand."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QPainter, QPolygonF, QTransform
from PySide6.QtWidgets import QGraphicsItem, QStyleOptionGraphicsItem, QWidget

from app.arrays import FloatArray, IntArray
from widgets.colours import PressureScale
from widgets.map_view.map_items import cosmetic, points, room_around
from widgets.map_view.map_shapes import MapShapes
from widgets.selection import INKS

TAXELS_FROM_PITCH_PX = 20.0
"""Taxels are drawn once their distance on the screen reaches this: below, dots would hide the image."""
BUCKETS = 32
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
        self._drawn, self._bounds = np.flatnonzero(shapes.on_shown()), room_around(shapes.taxels)
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
            (QColor(str(ink)), points(self._places[taxels[seen & (by_ink == ink)]])) for ink in dict.fromkeys(inks)
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
            least = 2.0 if len(self._selected) > len(INKS) else 6.0
            self._paint_selected(painter, min(max(0.36 * pitch, least), 9.0), self._scale)
        if self.numbered:
            self._paint_numbers(painter, 10.0 if self.visible_at(pixels_per_unit) or self._rings else 0.0)

    def _paint_dots(self, painter: QPainter, size: float, scale: PressureScale) -> None:
        self._colours = self._colours or self._sorted(self._drawn, scale)
        if not self.dots:  # over the picture they need a rim; as the picture they stand on a darker ground
            painter.setPen(cosmetic(painter, _DARK, size + 1.6))
            painter.drawPoints(points(self._places[self._drawn]))
        for colour, dots in self._colours:
            painter.setPen(cosmetic(painter, colour, size))
            painter.drawPoints(dots)

    def _paint_held(self, painter: QPainter, size: float, scale: PressureScale) -> None:
        for colour, dots in self._sorted(self._held, scale):
            painter.setPen(cosmetic(painter, colour, size))
            painter.drawPoints(dots)

    def _paint_selected(self, painter: QPainter, size: float, scale: PressureScale) -> None:
        for colour, places in self._rings:
            for ink, rim in ((_DARK, 0.9 * size + 1.6), (colour, 0.9 * size)):
                painter.setPen(cosmetic(painter, ink, size + min(rim, 5.0)))
                painter.drawPoints(places)
        for colour, places in self._sorted(np.intersect1d(self._selected, self._drawn), scale):
            painter.setPen(cosmetic(painter, colour, size))
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
        bucket = np.ceil(share * (BUCKETS - 1)).astype(int)
        entry = np.arange(BUCKETS) * (len(scale.lut) - 1) // (BUCKETS - 1)
        return [
            (QColor.fromRgb(int(scale.lut[entry[k]])), points(self._places[taxels[bucket == k]]))
            for k in np.unique(bucket)
        ]
