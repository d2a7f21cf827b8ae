"""Places of the legends: at the side of the viewport where they hide the least of the map, in a corner if one is free.

While the whole map is in view, a map that would be hidden in every corner is drawn smaller instead.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from PySide6.QtCore import QPointF, QRectF, QSizeF, Qt
from PySide6.QtGui import QColor, QImage, QPainter, QPolygonF, QTransform

from tactile_maps.core.arrays import FloatArray
from tactile_widgets.views.map.items.map_coordinates import MARGIN_PX, MapCamera
from tactile_widgets.views.map.items.map_shapes import MapShapes
from tactile_widgets.views.overlays.painting import polygon

_STEP = 4
"""Resolution at which hidden parts of the map are found [px]."""
_CAPTION = 34.0
"""Height of other captions with their gap [px]: the chip upper left, the scale below."""
_MESSAGE = 84.0
"""Height that the lower corners leave for a message over the views [px]."""
_GAP = 8.0
"""Between two legends, and between a legend and the map [px]."""
_NAME = 16.0
"""Height of the name above a patch [px]."""
_SMALLEST = 0.4
"""Smallest scale of the map next to legends, relative to that without legends; they may hide a part of it below."""


class LegendPlace:
    """Keeps the place of the legends until map, viewport or legends change.

    It is the place with most room in the current view or, if that shows only a part of the map, with all of it in view:
    legends that move while the map is panned and zoomed below them would be worse than a map that is hidden in part.
    Where they hide nothing, legends stay also when the map changes.

    Args:
        edge: Distance from the viewport's edge [px].
    """

    def __init__(self, edge: float) -> None:
        self._edge = edge
        self._of: tuple[object, ...] = ()
        self._box = QRectF()
        self._framed: MapCamera | None = None

    def framing(self, sizes: Sequence[QSizeF], shapes: MapShapes, room: QRectF) -> MapCamera | None:
        """Return the camera with the whole map in view, none of it hidden by legends where there is room for both.

        The same camera places the legends until the next call.

        Args:
            sizes: Size of each legend that the map must clear [px].
            shapes: Shapes of the map.
            room: The viewport.

        Returns:
            None if no patch is shown.
        """
        self._framed = camera = _framing(shapes)
        self._of = ()
        if camera is None or not sizes:
            return camera
        whole = _whole(sizes)
        cover = _CoveredRoom(_framed(shapes, room, camera), room)
        if not cover.hides(_freest(whole, room, self._edge, cover)):
            return camera
        down = whole.height() + self._edge + _GAP + _NAME - MARGIN_PX
        across = whole.width() + self._edge + _GAP - MARGIN_PX
        viewport = (room.width(), room.height())
        narrower = camera.with_margins(across, 0.0, viewport)
        lower = camera.with_margins(0.0, down, viewport)
        smaller = max(narrower, lower, key=lambda one: one.scale(viewport))
        if smaller.scale(viewport) >= _SMALLEST * camera.scale(viewport):
            self._framed = smaller
        return self._framed

    def boxes(
        self, sizes: Sequence[QSizeF], shapes: MapShapes, room: QRectF, view: QTransform | None = None
    ) -> list[QRectF]:
        """Place legends one below the other at a side, where they hide the least of the map.

        Args:
            sizes: Size of each legend [px].
            shapes: Shapes of the map.
            room: The viewport.
            view: Conversion of scene units to pixels; None for the whole map in view.

        Returns:
            Box of each legend [px]. Among equal places, the first of upper right, lower right, upper left, lower left
            and the rest of the right and left side.
        """
        if not sizes:
            return []
        whole = _whole(sizes)
        of = (shapes, whole.width(), whole.height(), room.width(), room.height())
        if self._of != of:
            self._of = of
            outlines = [] if view is None else [view.map(polygon(outline)) for outline in _outlines(shapes)]
            if not all(room.contains(outline.boundingRect()) for outline in outlines) or not outlines:
                outlines = _framed(shapes, room, self._framed or _framing(shapes))
            cover = _CoveredRoom(outlines, room)
            if self._box.size() != whole or not room.contains(self._box) or cover.hides(self._box):
                self._box = _freest(whole, room, self._edge, cover)
        return list(_stacked(sizes, self._box, to_right=self._box.center().x() > room.center().x()))


def _whole(sizes: Sequence[QSizeF]) -> QSizeF:
    """Return the size of legends one below the other."""
    return QSizeF(max(size.width() for size in sizes), sum(size.height() + _GAP for size in sizes) - _GAP)


def _framing(shapes: MapShapes) -> MapCamera | None:
    """Return the camera with the whole map in view; None if no patch is shown."""
    if shapes.bounds is None:
        return None
    low, high = shapes.bounds
    return MapCamera.framing((float(high[0] - low[0]), float(high[1] - low[1])), (float(low[0]), float(low[1])))


def _stacked(sizes: Sequence[QSizeF], whole: QRectF, *, to_right: bool) -> Iterator[QRectF]:
    top = whole.top()
    for size in sizes:
        yield QRectF(QPointF(whole.right() - size.width() if to_right else whole.left(), top), size)
        top += size.height() + _GAP


class _CoveredRoom:
    """The part of the viewport that patches cover.

    Args:
        outlines: Outlines of the patches [px].
        room: The viewport.
    """

    def __init__(self, outlines: Sequence[QPolygonF], room: QRectF) -> None:
        columns = max(math.ceil(room.width() / _STEP), 1)
        rows = max(math.ceil(room.height() / _STEP), 1)
        picture = QImage(columns, rows, QImage.Format.Format_Grayscale8)
        picture.fill(0)
        painter = QPainter(picture)
        painter.scale(1 / _STEP, 1 / _STEP)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(QColor(255, 255, 255))
        for outline in outlines:
            painter.drawPolygon(outline)
        painter.end()
        pixels = np.frombuffer(picture.constBits(), np.uint8).reshape(rows, picture.bytesPerLine())[:, :columns]
        self._sums = np.zeros((rows + 1, columns + 1))
        self._sums[1:, 1:] = (pixels > 0).cumsum(axis=0).cumsum(axis=1)

    def hidden(self, places: FloatArray, size: QSizeF) -> FloatArray:
        """Return the covered area of boxes at these upper left corners (k, 2) and of the gap around each (k,) [px²]."""
        ends = np.array([places - _GAP, places + (size.width() + _GAP, size.height() + _GAP)])
        rows, columns = self._sums.shape
        (left, top), (right, bottom) = np.clip(np.round(ends / _STEP), 0, (columns - 1, rows - 1)).astype(int).mT
        sums = self._sums
        return _STEP**2 * (sums[bottom, right] - sums[top, right] - sums[bottom, left] + sums[top, left])

    def hides(self, box: QRectF) -> bool:
        """Whether a part of a box or of the gap around it is covered."""
        return bool(self.hidden(np.array([box.topLeft().toTuple()]), box.size())[0])


def _freest(size: QSizeF, room: QRectF, edge: float, cover: _CoveredRoom) -> QRectF:
    inner = room.adjusted(edge, edge, -edge, -edge)
    right = inner.right() - size.width()
    bottom = inner.bottom() - size.height() - _CAPTION
    lower = max(inner.bottom() - size.height() - _MESSAGE, inner.top() + _CAPTION)
    left = inner.left()
    lowered = inner.top() + _CAPTION
    corners = np.array([(right, inner.top()), (right, lower), (left, lowered), (left, lower)])
    hidden = cover.hidden(corners, size)
    if hidden.all():
        sides = [(x, y) for x, top in ((right, inner.top()), (left, lowered)) for y in np.arange(top, bottom, _GAP)]
        corners = np.array([corners[hidden.argmin()], *sides])
        hidden = cover.hidden(corners, size)
    return QRectF(QPointF(*corners[hidden.argmin()].tolist()), size)


def _outlines(shapes: MapShapes) -> list[FloatArray]:
    """Outlines of the shown patches [scene units]."""
    return [patch.outline for patch in shapes.patches if patch.shown]


def _framed(shapes: MapShapes, room: QRectF, camera: MapCamera | None) -> list[QPolygonF]:
    """Outlines of the shown patches when the whole map is in view [px]."""
    if camera is None:
        return []
    viewport = (room.width(), room.height())
    scale = camera.scale(viewport)
    middle = np.array(viewport) / 2
    return [polygon((outline - camera.centre) * scale + middle) for outline in _outlines(shapes)]
