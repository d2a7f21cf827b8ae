"""Places of the legends: the corner of the viewport in which they hide the least of the map."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from PySide6.QtCore import QPointF, QRectF, QSizeF, Qt

from tactile_maps.core.arrays import FloatArray
from tactile_widgets.views.map.items.map_coordinates import MapCamera
from tactile_widgets.views.map.items.map_shapes import MapShapes
from tactile_widgets.views.overlays.painting import polygon

_ACROSS = 8
_DOWN = 6
"""Sample points of a legend."""
_CAPTION = 34.0
"""Height of other captions with their gap [px]: the chip upper left, scale and readout below."""
_GAP = 8.0
"""Between two legends [px]."""


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
        height = sum(size.height() + _GAP for size in sizes) - _GAP
        whole = QSizeF(max(size.width() for size in sizes), height)
        of = (shapes, whole.width(), whole.height(), room.width(), room.height())
        if self._of != of:
            self._of = of
            self._box = _freest(whole, shapes, room, self._edge)
        return list(_stacked(sizes, self._box, to_right=self._box.center().x() > room.center().x()))


def _stacked(sizes: Sequence[QSizeF], whole: QRectF, *, to_right: bool) -> Iterator[QRectF]:
    top = whole.top()
    for size in sizes:
        yield QRectF(QPointF(whole.right() - size.width() if to_right else whole.left(), top), size)
        top += size.height() + _GAP


def _freest(size: QSizeF, shapes: MapShapes, room: QRectF, edge: float) -> QRectF:
    inner = room.adjusted(edge, edge, -edge, -edge)
    right = inner.right() - size.width()
    bottom = inner.bottom() - size.height() - _CAPTION
    corners = (
        QPointF(right, inner.top()),
        QPointF(right, bottom),
        QPointF(inner.left(), inner.top() + _CAPTION),
        QPointF(inner.left(), bottom),
    )
    outlines = _framed(shapes, room)
    return min((QRectF(corner, size) for corner in corners), key=lambda box: _hidden(box, outlines))


def _framed(shapes: MapShapes, room: QRectF) -> list[FloatArray]:
    """Outlines of the shown patches when the whole map is in view [px]."""
    if shapes.bounds is None:
        return []
    low, high = shapes.bounds
    viewport = (room.width(), room.height())
    camera = MapCamera.framing((float(high[0] - low[0]), float(high[1] - low[1])), (float(low[0]), float(low[1])))
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
