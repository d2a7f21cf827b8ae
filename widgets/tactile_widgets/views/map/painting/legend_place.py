"""Places of the legends: the corner of the viewport in which they hide the least of the map.

While the whole map is in view, a map that would be hidden in every corner is drawn smaller instead.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from PySide6.QtCore import QPointF, QRectF, QSizeF, Qt

from tactile_maps.core.arrays import FloatArray
from tactile_widgets.views.map.items.map_coordinates import MARGIN_PX, MapCamera
from tactile_widgets.views.map.items.map_shapes import MapShapes
from tactile_widgets.views.overlays.painting import polygon

_ACROSS = 8
_DOWN = 6
"""Sample points of a legend."""
_CAPTION = 34.0
"""Height of other captions with their gap [px]: the chip upper left, the scale below."""
_GAP = 8.0
"""Between two legends, and between a legend and the map [px]."""
_NAME = 16.0
"""Height of the name above a patch [px]."""
_SMALLEST = 0.4
"""Smallest scale of the map next to legends, relative to that without legends; they may hide a part of it below."""


class LegendPlace:
    """Keeps the corner of the legends until map, viewport or legends change.

    It is the corner with most room while the whole map is in view: legends that change corners while the map is panned
    and zoomed below them would be worse than a map that is hidden in part.

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
        if not _hidden(_freest(whole, shapes, room, self._edge, camera), _framed(shapes, room, camera)):
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

    def boxes(self, sizes: Sequence[QSizeF], shapes: MapShapes, room: QRectF) -> list[QRectF]:
        """Place legends one below the other in the corner where they hide the least of the map.

        Args:
            sizes: Size of each legend [px].
            shapes: Shapes of the map.
            room: The viewport.

        Returns:
            Box of each legend [px]. Among equal corners, the first of upper right, lower right, upper left, lower left.
        """
        if not sizes:
            return []
        whole = _whole(sizes)
        of = (shapes, whole.width(), whole.height(), room.width(), room.height())
        if self._of != of:
            self._of = of
            self._box = _freest(whole, shapes, room, self._edge, self._framed or _framing(shapes))
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


def _freest(size: QSizeF, shapes: MapShapes, room: QRectF, edge: float, framed: MapCamera | None) -> QRectF:
    inner = room.adjusted(edge, edge, -edge, -edge)
    right = inner.right() - size.width()
    bottom = inner.bottom() - size.height() - _CAPTION
    corners = (
        QPointF(right, inner.top()),
        QPointF(right, bottom),
        QPointF(inner.left(), inner.top() + _CAPTION),
        QPointF(inner.left(), bottom),
    )
    outlines = _framed(shapes, room, framed)
    return min((QRectF(corner, size) for corner in corners), key=lambda box: _hidden(box, outlines))


def _framed(shapes: MapShapes, room: QRectF, camera: MapCamera | None) -> list[FloatArray]:
    """Outlines of the shown patches when the whole map is in view [px]."""
    if camera is None:
        return []
    viewport = (room.width(), room.height())
    scale = camera.scale(viewport)
    middle = np.array(viewport) / 2
    return [
        (patch.to_scene(patch.chart.outline) - camera.centre) * scale + middle
        for patch in shapes.patches
        if patch.shown
    ]


def _hidden(box: QRectF, outlines: list[FloatArray]) -> int:
    """Number of the box's sample points that are on the map."""
    columns = np.linspace(box.left(), box.right(), _ACROSS)
    rows = np.linspace(box.top(), box.bottom(), _DOWN)
    points = [QPointF(x, y) for x in columns for y in rows]
    near = [outline for outline in map(polygon, outlines) if outline.boundingRect().intersects(box)]
    return sum(any(outline.containsPoint(point, Qt.FillRule.OddEvenFill) for outline in near) for point in points)
