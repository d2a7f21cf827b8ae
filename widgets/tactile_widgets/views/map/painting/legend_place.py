"""Where the legends stand over the map: in the corner in which they hide the least of it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from PySide6.QtCore import QPointF, QRectF, QSizeF, Qt

from tactile_maps.core.arrays import FloatArray
from tactile_widgets.views.map.items.map_coordinates import MapCamera
from tactile_widgets.views.map.items.map_items import to_polygon
from tactile_widgets.views.map.items.map_shapes import MapShapes

_ACROSS = 8
_DOWN = 6
"""Points of a legend that are looked at."""
_CAPTION = 34.0
"""Height of what else stands there, with its gap [px]: the chip upper left, scale and readout below."""
_GAP = 8.0
"""Between two legends [px]."""


class LegendPlace:
    """Mutable: it keeps the corner until map, viewport or legends are others.

    Panned and zoomed the map runs below the legends: one that went from corner to corner meanwhile would be worse. So
    the corner is the one that is freest while all of the map is framed.

    Args:
        edge: Distance from the viewport's edge [px].
    """

    def __init__(self, edge: float) -> None:
        self._edge = edge
        self._of: tuple[object, ...] = ()
        self._box = QRectF()

    def boxes(self, sizes: Sequence[QSizeF], shapes: MapShapes, room: QRectF) -> list[QRectF]:
        """One below the other, in the corner where they hide the least of the map.

        Args:
            sizes: Of each legend [px].
            shapes: The map.
            room: The viewport.

        Returns:
            Where each stands [px]. Of equal corners the first of upper right, lower right, upper left, lower left.
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
    """Outlines of the patches shown as they lie in the viewport when all is framed [px]."""
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
    """How many of the box's points lie on the map."""
    columns = np.linspace(box.left(), box.right(), _ACROSS)
    rows = np.linspace(box.top(), box.bottom(), _DOWN)
    points = [QPointF(x, y) for x in columns for y in rows]
    near = [polygon for polygon in map(to_polygon, outlines) if polygon.boundingRect().intersects(box)]
    return sum(any(polygon.containsPoint(point, Qt.FillRule.OddEvenFill) for polygon in near) for point in points)
