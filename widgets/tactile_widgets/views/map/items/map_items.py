"""Graphics items of the map: patches, each with its part of the live image, and taxels; and the order of all items.

Taxels are dots in the pressure's colour, with rings around the selected ones. Helpers turn arrays into Qt's lines and
pens.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from enum import IntEnum
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QLineF, QRectF, QSize, Qt
from PySide6.QtGui import QBrush, QColor, QImage, QPaintEngine, QPainter, QPainterPath, QPen, QPolygonF, QTransform
from PySide6.QtWidgets import QGraphicsItem, QStyleOptionGraphicsItem, QWidget
from shiboken6 import wrapInstance

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.maps.image_atlas import AtlasTile
from tactile_widgets.common.colours import BETWEEN_DOTS, PressureScale
from tactile_widgets.document.taxel_selection import TAXEL_COLOURS
from tactile_widgets.views.map.items.live_image import LiveImage
from tactile_widgets.views.map.items.map_shapes import ChartShape, MapShapes, PatchShape, Wireframe
from tactile_widgets.views.overlays.paint_cache import PaintCache
from tactile_widgets.views.overlays.painting import RIM, faint, polygon


class ZOrder(IntEnum):
    """Drawing order on the map, lowest first. A display layer uses one of these levels; the others are the map's own.

    Up to ``FAULTS`` they are items of the graphics scene: ``BORDER`` and ``SEAMS`` children of each patch, so that a
    patch covers those of the patches below it. The rest is painted over the scene, in pixels.
    """

    PATCHES = 0
    BORDER = 1
    SEAMS = 2
    FLAWS = 3
    DOTS = 4
    TAXELS = 5
    NUMBERS = 6
    FAULTS = 7
    CONTOURS = 8
    TASK = 9
    NAMES = 10
    PINS = 11
    FINGERS = 12
    SHAPES = 13
    CONTACTS = 14
    CAPTIONS = 15


_ROOM = 0.02
"""Margin around drawings as a fraction of their size: room for line widths, and no drawing has size zero."""


def to_lines(segments: FloatArray) -> list[QLineF]:
    """Return segments (s, 2, 2) as lines."""
    return [QLineF(x0, y0, x1, y1) for (x0, y0), (x1, y1) in segments.tolist()]


class LineBuffer:
    """Lines that change with every tick: Qt objects over one array, filled as a whole.

    Creating a thousand lines costs 1.4 ms, filling them 1 µs.
    """

    def __init__(self) -> None:
        self._numbers = np.zeros((0, 2, 2))
        self._lines = list[QLineF]()

    def fill(self, segments: FloatArray) -> list[QLineF]:
        """Return segments (s, 2, 2) as lines, valid until the next call."""
        if len(segments) > len(self._lines):
            self._numbers = np.zeros((2 * len(segments), 2, 2))
            # a QLineF is four numbers
            address = self._numbers.ctypes.data
            size = self._numbers[0].nbytes
            wrap: Any = wrapInstance  # its type stub returns a plain object
            self._lines = [wrap(address + size * k, QLineF) for k in range(len(self._numbers))]
        self._numbers[: len(segments)] = segments
        return self._lines[: len(segments)]


def cosmetic_pen(painter: QPainter, colour: QColor, width: float) -> QPen:
    """Return a round pen with this width in logical pixels, whatever the zoom and the display's scale."""
    device = painter.device()
    pen = QPen(colour, width * device.devicePixelRatio())  # cosmetic widths are in the device's own pixels
    pen.setCapStyle(Qt.PenCapStyle.RoundCap)
    pen.setJoinStyle(Qt.PenJoinStyle.RoundJoin)
    pen.setCosmetic(True)
    return pen


def padded_bounds(places: FloatArray) -> QRectF:
    """Return the rectangle around points (n, 2) with a margin; empty without points."""
    if not len(places):
        return QRectF()
    left, top = places.min(axis=0)
    right, bottom = places.max(axis=0)
    room = _ROOM * max(right - left, bottom - top) + _ROOM
    return QRectF(left, top, right - left, bottom - top).adjusted(-room, -room, room, room)


class MapItem(QGraphicsItem):
    """Graphics item with stored bounds."""

    def __init__(self, order: ZOrder, parent: QGraphicsItem | None = None) -> None:
        super().__init__(parent)
        self.bounds = QRectF()
        self.setZValue(order)

    def set_bounds(self, places: FloatArray) -> None:
        """Set the bounds to surround points (n, 2)."""
        self.prepareGeometryChange()
        self.bounds = padded_bounds(places)

    def boundingRect(self) -> QRectF:
        return self.bounds

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        self.draw(painter, option.levelOfDetailFromTransform(painter.worldTransform()))

    @abstractmethod
    def draw(self, painter: QPainter, pixels_per_unit: float) -> None:
        """Draw the item at a zoom of so many pixels per unit of its coordinates."""


_PICTURE_PIXELS = 4.0
"""Resolution of touch in an SVG [pixels per 1/96 inch]."""
_SMOOTH = QPainter.RenderHint.Antialiasing | QPainter.RenderHint.SmoothPixmapTransform


class PatchItem(MapItem):
    """Patch on the map: the live image clipped to its outline.

    It is drawn in its chart's frame at the map's scale; ``place`` moves, rotates, mirrors and scales it. While its
    chart is being dragged and has no image, it is drawn as a wireframe.
    """

    def __init__(self) -> None:
        super().__init__(ZOrder.PATCHES)
        self._area = QPainterPath()
        self._brush = QBrush()
        self._net: list[QLineF] = []
        self._lines = LineBuffer()
        self._live: LiveImage | None = None
        self._cache = PaintCache(at_once=True)
        self._tile = (slice(0), slice(0))
        self._painted = np.zeros((0, 0), np.uint32)
        self._paintings = 0

    def show_image(
        self, shape: ChartShape, scale: float, live: LiveImage, tile: AtlasTile, corner: tuple[int, int]
    ) -> None:
        """Draw a chart by its live image.

        Args:
            shape: Shape of the chart.
            scale: Scene units per metre.
            live: Image, read at each paint; it may change in place.
            tile: The chart's part of the image.
            corner: Row and column of the tile's first pixel in the image.
        """
        self._outline(shape, scale)
        self._net = []
        self._live = live  # keeps the memory of the brush alive
        row, column = corner
        height, width = tile.shape
        self._tile = slice(row, row + height), slice(column, column + width)
        self._painted = np.zeros((0, 0), np.uint32)  # earlier paintings had another place
        self._brush = QBrush(live.image)
        pixel = scale * tile.resolution
        x, y = scale * tile.corner - pixel * np.array([corner[1], -corner[0]])
        self._brush.setTransform(QTransform(pixel, 0, 0, -pixel, x, y))

    def show_wireframe(self, shape: ChartShape, scale: float, net: Wireframe) -> None:
        """Draw a chart by the lines of a wireframe on a plain background."""
        self._outline(shape, scale)
        self._live = None
        self._net = self._lines.fill(scale * shape.lines(net))
        self._brush = QBrush(QColor(*BETWEEN_DOTS))

    def place(self, shape: PatchShape, scale: float) -> None:
        """Move the item to its patch's place on the map, and hide or show it."""
        (a, b), (c, d) = (shape.placed[:2] / scale).tolist()
        x, y = shape.placed[2].tolist()
        self.setTransform(QTransform(a, b, c, d, x, y))
        self.setVisible(shape.shown)

    def draw(self, painter: QPainter, pixels_per_unit: float) -> None:
        painter.setRenderHints(_SMOOTH)
        if self._live is not None and painter.paintEngine().type() is QPaintEngine.Type.SVG:
            self._draw_picture(painter)
        elif self._live is not None:
            self._draw_image(painter, self._live.pixels[self._tile])
        else:
            painter.fillPath(self._area, self._brush)
        if self._net:
            self._draw_net(painter)

    def _draw_image(self, painter: QPainter, pixels: NDArray[np.uint32]) -> None:
        """Repaint only the part of the image that changed, unless the view changed too.

        Most of the skin is not touched, and comparing the pixels (h, w) takes a tenth of the time of smoothing them.
        """
        changed = None
        if pixels.shape != self._painted.shape:
            self._painted = pixels.copy()
            self._paintings += 1
        elif len(rows := np.flatnonzero((differs := pixels != self._painted).any(axis=1))):
            columns = np.flatnonzero(differs.any(axis=0))
            around = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
            self._painted[around] = pixels[around]
            self._paintings += 1
            changed = self._brush.transform().mapRect(self._on_image(around))
        self._cache.paint(painter, (self._paintings, self._area), self.bounds, self._fill, changed=changed)

    def _on_image(self, around: tuple[slice, slice]) -> QRectF:
        """Rectangle of rows and columns of the tile on the live image, with the pixels that smoothing mixes in."""
        (top, bottom), (left, right) = ((part.start - 1, part.stop + 1) for part in around)
        own_rows, own_columns = self._tile
        return QRectF(own_columns.start + left, own_rows.start + top, float(right - left), float(bottom - top))

    def _fill(self, painter: QPainter) -> None:
        painter.setRenderHints(_SMOOTH)
        painter.fillPath(self._area, self._brush)

    def _draw_picture(self, painter: QPainter) -> None:
        """Draw a separate picture: SVG has no transformed brushes."""
        bounds = self._area.boundingRect()
        view = painter.worldTransform()
        fine = _PICTURE_PIXELS * abs(view.determinant()) ** 0.5
        picture = QImage(bounds.size().toSize() * fine + QSize(1, 1), QImage.Format.Format_ARGB32_Premultiplied)
        picture.fill(Qt.GlobalColor.transparent)
        pen = QPainter(picture)
        pen.setRenderHints(_SMOOTH)
        pen.scale(picture.width() / bounds.width(), picture.height() / bounds.height())
        pen.translate(-bounds.topLeft())
        pen.fillPath(self._area, self._brush)
        pen.end()
        painter.drawImage(bounds, picture)

    def _outline(self, shape: ChartShape, scale: float) -> None:
        self.set_bounds(scale * shape.outline)
        self._area = QPainterPath()
        self._area.addPolygon(polygon(scale * shape.outline))
        self._area.closeSubpath()
        self._area.setFillRule(Qt.FillRule.WindingFill)

    def _draw_net(self, painter: QPainter) -> None:
        painter.setRenderHint(QPainter.RenderHint.Antialiasing, False)  # halves the time for thousands of lines
        painter.setPen(cosmetic_pen(painter, _FAINT, 1.0))
        painter.drawLines(self._net)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)


TAXELS_FROM_PITCH_PX = 20.0
"""Distance of taxels on the screen from which they are dots in their colour [px]; closer, such dots would hide the
image, and faint points mark the taxels."""
_FAINTEST_PITCH_PX = 2.5
"""Distance of taxels below which no points are drawn: they would merge to a grey veil [px]."""
_FAINT = faint(RIM, 70)
COLOUR_BUCKETS = 32
"""Number of colours in which taxels are drawn, with one call of Qt for each."""
_DARK = faint(RIM, 120)
Dots = list[tuple[QColor, QPolygonF]]


def draw_dots(painter: QPainter, dots: Dots, size: float) -> None:
    """Draw points of each colour, ``size`` wide [px]."""
    for colour, places in dots:
        painter.setPen(cosmetic_pen(painter, colour, size))
        painter.drawPoints(places)


class TaxelsItem(MapItem):
    """Taxels: faint points over the image, and when zoomed in, dots in the pressure's colour with a rim.

    Attributes:
        readings: Pressures (n,) [kPa] and their colour scale; None before the first.
        replaced: Whether a display layer draws all taxels in place of the image; only the selected are drawn here.
        places: (n, 2) [scene units].
        pitch: Typical distance of neighbours [scene units].
        drawn: (k,) taxels of patches that are shown.
        selected: (s,) taxels with a ring.
    """

    def __init__(self) -> None:
        super().__init__(ZOrder.TAXELS)
        self.readings: tuple[FloatArray, PressureScale] | None = None
        self.replaced = False
        self.places: FloatArray = np.zeros((0, 2))
        self.pitch = 0.0
        self.drawn: IntArray = np.zeros(0, int)
        self.selected: IntArray = np.zeros(0, int)
        self._held: IntArray = np.zeros(0, int)
        self._dots: Dots = []
        self._dots_of: object = None
        self._points = QPolygonF()
        self._points_cache = PaintCache()
        self._inks: tuple[str, ...] = ()
        self._rings: Dots = []

    def place(self, shapes: MapShapes, held: Sequence[int] = ()) -> None:
        """Move the taxels to their places on the map; those of ``held`` patches are dots at every zoom."""
        self.places = shapes.taxels
        self.pitch = shapes.pitch
        self.drawn = np.flatnonzero(shapes.on_shown())
        self.set_bounds(shapes.taxels)
        first = np.cumsum([0, *(len(patch.chart.taxels) for patch in shapes.patches)])
        held = [k for k in held if shapes.patches[k].shown]
        self._held = np.concatenate([np.zeros(0, int), *(np.arange(first[k], first[k + 1]) for k in held)])
        self._dots_of = None
        self._points = polygon(self.places[self.drawn])
        self.select(self.selected, self._inks)

    def select(self, taxels: IntArray, inks: tuple[str, ...]) -> None:
        """Draw a ring around each of these taxels (k,) in its colour."""
        self.selected = taxels
        self._inks = inks
        seen = np.isin(taxels, self.drawn)
        by_ink = np.array(inks, dtype=str)
        self._rings = [
            (QColor(str(ink)), polygon(self.places[taxels[seen & (by_ink == ink)]])) for ink in dict.fromkeys(inks)
        ]
        self.update()

    def marked_at(self, pixels_per_unit: float) -> bool:
        """Whether taxels are covered by dots or rings at this zoom."""
        return self.replaced or self.pitch * pixels_per_unit >= TAXELS_FROM_PITCH_PX or bool(self._rings)

    def dots(self) -> Dots:
        """Places of all drawn taxels by the colour of their pressure; empty before there are readings."""
        if self._dots_of is not self.readings:
            self._dots = self._sorted(self.drawn)
            self._dots_of = self.readings
        return self._dots

    def draw(self, painter: QPainter, pixels_per_unit: float) -> None:
        pitch = self.pitch * pixels_per_unit
        if self.readings is None:
            return
        if not self.replaced and pitch >= TAXELS_FROM_PITCH_PX:
            size = min(2.0 + 0.1 * pitch, 9.0)
            draw_dots(painter, [(_DARK, self._points)], size + 1.6)  # a rim, over the image
            draw_dots(painter, self.dots(), size)
        elif not self.replaced and len(self._held):
            draw_dots(painter, self._sorted(self._held), min(max(0.36 * pitch, 2.5), 9.0))
        elif not self.replaced and pitch >= _FAINTEST_PITCH_PX:
            self._points_cache.paint(painter, self._points, self.bounds, partial(self._draw_faint, pitch))
        if self._rings:
            least = 2.0 if len(self.selected) > len(TAXEL_COLOURS) else 6.0
            size = min(max(0.36 * pitch, least), 9.0)
            for ring in self._rings:
                draw_dots(painter, [(_DARK, ring[1])], size + min(0.9 * size + 1.6, 5.0))
                draw_dots(painter, [ring], size + min(0.9 * size, 5.0))
            draw_dots(painter, self._sorted(np.intersect1d(self.selected, self.drawn)), size)

    def _draw_faint(self, pitch: float, painter: QPainter) -> None:
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)  # or some would be two pixels wide and others one
        draw_dots(painter, [(_FAINT, self._points)], min(max(0.16 * pitch, 1.0), 2.2))

    def _sorted(self, taxels: IntArray) -> Dots:
        """Places of these taxels by the colour of their pressure."""
        if self.readings is None:
            return []
        kilopascals, scale = self.readings
        share = np.clip(kilopascals[taxels] / scale.maximum, 0, 1)
        bucket = np.ceil(share * (COLOUR_BUCKETS - 1)).astype(int)
        entry = np.arange(COLOUR_BUCKETS) * (len(scale.lut) - 1) // (COLOUR_BUCKETS - 1)
        return [
            (QColor.fromRgb(int(scale.lut[entry[k]])), polygon(self.places[taxels[bucket == k]]))
            for k in np.unique(bucket)
        ]
