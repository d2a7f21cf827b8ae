"""The graphics items of the map: patches, each with its part of the live image, and taxels; and what lies over what.

Taxels are dots in the pressure's colour, with rings around the selected ones. Above them, helpers that turn arrays into
Qt's polygons, lines and pens.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QLineF, QRectF, QSize, Qt
from PySide6.QtGui import QBrush, QColor, QImage, QPaintEngine, QPainter, QPainterPath, QPen, QPolygonF, QTransform
from PySide6.QtWidgets import QGraphicsItem, QStyleOptionGraphicsItem, QWidget
from shiboken6 import VoidPtr, wrapInstance

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.maps.image_atlas import AtlasTile
from tactile_widgets.common.colours import BETWEEN_DOTS, PressureScale
from tactile_widgets.document.taxel_selection import TAXEL_COLOURS
from tactile_widgets.views.map.items.live_image import LiveImage
from tactile_widgets.views.map.items.map_shapes import ChartShape, MapShapes, PatchShape, Wireframe
from tactile_widgets.views.overlays.paint_cache import PaintCache


class ZOrder(IntEnum):
    """What lies over what on the map, the lowest first. A layer is at one of these; the others are the map's own.

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


class LineBuffer:
    """Lines that change every frame, as Qt's objects over one array: made once, filled as a whole. Mutable.

    Making a thousand lines anew costs 1.4 ms, filling them 1 µs.
    """

    def __init__(self) -> None:
        self._numbers = np.zeros((0, 2, 2))
        self._lines = list[QLineF]()

    def fill(self, segments: FloatArray) -> list[QLineF]:
        """Lines of ``segments`` (s, 2, 2), good until the next filling."""
        if len(segments) > len(self._lines):
            self._numbers = np.zeros((2 * len(segments), 2, 2))
            # a QLineF is four numbers
            address = self._numbers.ctypes.data
            size = self._numbers[0].nbytes
            wrap: Any = wrapInstance  # its stub does not tell that it returns the type asked for
            self._lines = [wrap(address + size * k, QLineF) for k in range(len(self._numbers))]
        self._numbers[: len(segments)] = segments
        return self._lines[: len(segments)]


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


_PICTURE_PIXELS = 4.0
"""Of touch in an SVG, to a unit of 1/96 inch."""


class PatchItem(QGraphicsItem):
    """One patch: the live image cut out along its outline. Mutable.

    It is drawn in its chart's frame, as large as in the scene; ``place`` moves, turns, mirrors and scales it. While its
    chart is being dragged and has no image, it is drawn as a net.
    """

    def __init__(self) -> None:
        super().__init__()
        self._area = QPainterPath()
        self._brush = QBrush()
        self._net: list[QLineF] = []
        self._live: LiveImage | None = None
        self._cache = PaintCache(at_once=True)
        self._tile = (slice(0), slice(0))
        self._painted = np.zeros((0, 0), np.uint32)
        self._paintings = 0
        self._bounds = QRectF()
        self.setZValue(ZOrder.PATCHES)

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
        (row, column), (height, width) = corner, tile.shape
        self._tile = slice(row, row + height), slice(column, column + width)
        self._painted = np.zeros((0, 0), np.uint32)  # nothing painted before lies where this does
        self._brush = QBrush(live.image)
        pixel = scale * tile.resolution
        x, y = scale * tile.corner - pixel * np.array([corner[1], -corner[0]])
        self._brush.setTransform(QTransform(pixel, 0, 0, -pixel, x, y))

    def show_wireframe(self, shape: ChartShape, scale: float, net: Wireframe) -> None:
        """Draw a chart by the lines of a ``net``, on a plain ground. Cost: 2 ms for 3000."""
        self._outline(shape, scale)
        self._live = None
        self._net = to_lines(scale * shape.lines(net))
        self._brush = QBrush(QColor(*BETWEEN_DOTS))

    def place(self, shape: PatchShape, scale: float) -> None:
        """Put it where its patch lies, and hide or show it."""
        (a, b), (c, d) = (shape.placed[:2] / scale).tolist()
        x, y = shape.placed[2].tolist()
        self.setTransform(QTransform(a, b, c, d, x, y))
        self.setVisible(shape.shown)

    def boundingRect(self) -> QRectF:
        """Qt: the chart's rectangle."""
        return self._bounds

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        """Qt: draw the image, or the net."""
        painter.setRenderHints(QPainter.RenderHint.Antialiasing | QPainter.RenderHint.SmoothPixmapTransform)
        if self._live is not None and painter.paintEngine().type() is QPaintEngine.Type.SVG:
            self._paint_picture(painter)
        elif self._live is not None:
            self._paint_image(painter, self._live.pixels[self._tile])
        else:
            painter.fillPath(self._area, self._brush)
        if self._net:
            self._paint_net(painter)

    def _paint_image(self, painter: QPainter, pixels: NDArray[np.uint32]) -> None:
        """As it was painted last while the view stays, but where it changed: most of the skin is not touched, and to
        compare its ``pixels`` (h, w) takes a tenth of the time of smoothing them.
        """
        changed = None
        if pixels.shape != self._painted.shape:
            self._painted = pixels.copy()
            self._paintings = self._paintings + 1
        elif len(rows := np.flatnonzero((differs := pixels != self._painted).any(axis=1))):
            columns = np.flatnonzero(differs.any(axis=0))
            around = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
            self._painted[around] = pixels[around]
            self._paintings += 1
            changed = self._brush.transform().mapRect(self._on_image(around))
        self._cache.paint(painter, (self._paintings, self._area), self._bounds, self._fill, changed=changed)

    def _on_image(self, around: tuple[slice, slice]) -> QRectF:
        """Rows and columns of the tile on the live image, with the pixels into which they are smoothed."""
        (top, bottom), (left, right) = ((part.start - 1, part.stop + 1) for part in around)
        own_rows, own_columns = self._tile
        return QRectF(own_columns.start + left, own_rows.start + top, float(right - left), float(bottom - top))

    def _fill(self, painter: QPainter) -> None:
        painter.setRenderHints(QPainter.RenderHint.Antialiasing | QPainter.RenderHint.SmoothPixmapTransform)
        painter.fillPath(self._area, self._brush)

    def _paint_picture(self, painter: QPainter) -> None:
        """As a picture by itself: SVG has no brushes that are moved."""
        bounds = self._area.boundingRect()
        view = painter.worldTransform()
        fine = _PICTURE_PIXELS * abs(view.determinant()) ** 0.5
        picture = QImage(bounds.size().toSize() * fine + QSize(1, 1), QImage.Format.Format_ARGB32_Premultiplied)
        picture.fill(Qt.GlobalColor.transparent)
        pen = QPainter(picture)
        pen.setRenderHints(QPainter.RenderHint.Antialiasing | QPainter.RenderHint.SmoothPixmapTransform)
        pen.scale(picture.width() / bounds.width(), picture.height() / bounds.height())
        pen.translate(-bounds.topLeft())
        pen.fillPath(self._area, self._brush)
        pen.end()
        painter.drawImage(bounds, picture)

    def _outline(self, shape: ChartShape, scale: float) -> None:
        self.prepareGeometryChange()
        self._bounds = padded_bounds(scale * shape.outline)
        self._area = QPainterPath()
        self._area.addPolygon(to_polygon(scale * shape.outline))
        self._area.closeSubpath()
        self._area.setFillRule(Qt.FillRule.WindingFill)

    def _paint_net(self, painter: QPainter) -> None:
        painter.setRenderHint(QPainter.RenderHint.Antialiasing, False)  # of thousands of lines half the time
        painter.setPen(cosmetic_pen(painter, QColor(29, 33, 38, 70), 1.0))
        painter.drawLines(self._net)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)


TAXELS_FROM_PITCH_PX = 20.0
"""Taxels are dots in their colour once their distance on the screen reaches this; below, such dots would hide the
image, and a faint point says where each is."""
_FAINTEST_PITCH_PX = 2.5
"""Points nearer to each other than this are a grey veil that says nothing: none are drawn."""
_FAINT = QColor(29, 33, 38, 70)
COLOUR_BUCKETS = 32
"""Colours in which taxels are drawn; one call of Qt for each."""
_DARK = QColor(29, 33, 38, 120)


class TaxelsItem(QGraphicsItem):
    """The taxels: faint points over the image, from near dots in the pressure's colour with a rim. Mutable.

    Attributes:
        replaced: Whether a layer draws all of them in place of the image, so that only the selected are drawn here.
        places: (n, 2) where they lie [scene units].
        pitch: Typical distance of neighbours [scene units].
        drawn: (k,) those of patches that are shown.
        selected: (s,) those that are ringed.
        bounds: Around all of them.
    """

    def __init__(self) -> None:
        super().__init__()
        self.replaced = False
        self.places: FloatArray = np.zeros((0, 2))
        self.pitch = 0.0
        self.drawn: IntArray = np.zeros(0, int)
        self._held: IntArray = np.zeros(0, int)
        self._kilopascals: FloatArray = np.zeros(0)
        self._scale: PressureScale | None = None
        self._colours: list[tuple[QColor, QPolygonF]] = []
        self._points: QPolygonF | None = None
        self._faint = PaintCache()
        self.selected: IntArray = np.zeros(0, int)
        self._inks: tuple[str, ...] = ()
        self._rings: list[tuple[QColor, QPolygonF]] = []
        self.bounds = QRectF()
        self.setZValue(ZOrder.TAXELS)

    def place(self, shapes: MapShapes, held: Sequence[int] = ()) -> None:
        """Put them where the map has them now; those of the patches that are ``held`` are dots at every zoom."""
        self.prepareGeometryChange()
        self.places = shapes.taxels
        self.pitch = shapes.pitch
        self.drawn = np.flatnonzero(shapes.on_shown())
        self.bounds = padded_bounds(shapes.taxels)
        first = np.cumsum([0, *(len(patch.chart.taxels) for patch in shapes.patches)])
        held = [k for k in held if shapes.patches[k].shown]
        self._held = np.concatenate([np.zeros(0, int), *(np.arange(first[k], first[k + 1]) for k in held)])
        self._colours = []
        self._points = None
        self.select(self.selected, self._inks)

    def colour(self, kilopascals: FloatArray, scale: PressureScale) -> None:
        """Take the pressures (n,) [kPa]; they are sorted into colours when next drawn."""
        self._kilopascals = kilopascals
        self._scale = scale
        self._colours = []

    def select(self, taxels: IntArray, inks: tuple[str, ...]) -> None:
        """Ring these (k,), each in its colour."""
        self.selected = taxels
        self._inks = inks
        seen = np.isin(taxels, self.drawn)
        by_ink = np.array(inks, dtype=str)
        self._rings = [
            (QColor(str(ink)), to_polygon(self.places[taxels[seen & (by_ink == ink)]])) for ink in dict.fromkeys(inks)
        ]
        self.update()

    def marked_at(self, pixels_per_unit: float) -> bool:
        """Whether there is a mark at a taxel that is drawn, at this zoom: a dot, or rings around some."""
        return self.replaced or self.pitch * pixels_per_unit >= TAXELS_FROM_PITCH_PX or bool(self._rings)

    def by_colour(self) -> list[tuple[QColor, QPolygonF]]:
        """Places of all that are drawn, by the colour of their pressure; none before there is a scale."""
        if not self._colours and self._scale is not None:
            self._colours = self._sorted(self.drawn, self._scale)
        return self._colours

    def boundingRect(self) -> QRectF:
        """Qt: around all taxels."""
        return self.bounds

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        """Qt: draw dots and rings."""
        pitch = self.pitch * option.levelOfDetailFromTransform(painter.worldTransform())
        if self._scale is None:
            return
        if not self.replaced and pitch >= TAXELS_FROM_PITCH_PX:
            self._paint_dots(painter, min(2.0 + 0.1 * pitch, 9.0))
        elif not self.replaced and len(self._held):
            self._paint_held(painter, min(max(0.36 * pitch, 2.5), 9.0), self._scale)
        elif not self.replaced and pitch >= _FAINTEST_PITCH_PX:
            self._faint.paint(painter, self._all_drawn(), self.bounds, partial(self._paint_faint, pitch))
        if self._rings:
            least = 2.0 if len(self.selected) > len(TAXEL_COLOURS) else 6.0
            self._paint_selected(painter, min(max(0.36 * pitch, least), 9.0), self._scale)

    def _paint_faint(self, pitch: float, painter: QPainter) -> None:
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)  # or some would be two pixels wide and some one
        painter.setPen(cosmetic_pen(painter, _FAINT, min(max(0.16 * pitch, 1.0), 2.2)))
        painter.drawPoints(self._all_drawn())

    def _paint_dots(self, painter: QPainter, size: float) -> None:
        painter.setPen(cosmetic_pen(painter, _DARK, size + 1.6))  # a rim, over the picture
        painter.drawPoints(self._all_drawn())
        for colour, dots in self.by_colour():
            painter.setPen(cosmetic_pen(painter, colour, size))
            painter.drawPoints(dots)

    def _all_drawn(self) -> QPolygonF:
        if self._points is None:
            self._points = to_polygon(self.places[self.drawn])
        return self._points

    def _paint_held(self, painter: QPainter, size: float, scale: PressureScale) -> None:
        for colour, dots in self._sorted(self._held, scale):
            painter.setPen(cosmetic_pen(painter, colour, size))
            painter.drawPoints(dots)

    def _paint_selected(self, painter: QPainter, size: float, scale: PressureScale) -> None:
        for colour, places in self._rings:
            for ink, rim in ((_DARK, 0.9 * size + 1.6), (colour, 0.9 * size)):
                painter.setPen(cosmetic_pen(painter, ink, size + min(rim, 5.0)))
                painter.drawPoints(places)
        for colour, places in self._sorted(np.intersect1d(self.selected, self.drawn), scale):
            painter.setPen(cosmetic_pen(painter, colour, size))
            painter.drawPoints(places)

    def _sorted(self, taxels: IntArray, scale: PressureScale) -> list[tuple[QColor, QPolygonF]]:
        """Places of these taxels by the colour of their pressure."""
        share = np.clip(self._kilopascals[taxels] / scale.maximum, 0, 1)
        bucket = np.ceil(share * (COLOUR_BUCKETS - 1)).astype(int)
        entry = np.arange(COLOUR_BUCKETS) * (len(scale.lut) - 1) // (COLOUR_BUCKETS - 1)
        return [
            (QColor.fromRgb(int(scale.lut[entry[k]])), to_polygon(self.places[taxels[bucket == k]]))
            for k in np.unique(bucket)
        ]
