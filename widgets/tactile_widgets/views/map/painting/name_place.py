"""Places of the patches' names: next to each patch, over no legend, no other name, and as little skin as possible."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np
from PySide6.QtCore import QPointF, QRectF, QSizeF, Qt
from PySide6.QtGui import QFont, QFontMetricsF, QPainterPath, QTransform

from tactile_maps.core.arrays import FloatArray
from tactile_widgets.views.map.items.map_coordinates import MARGIN_PX
from tactile_widgets.views.map.items.map_shapes import MapShapes, PatchShape
from tactile_widgets.views.overlays.painting import EDGE, chip_size, polygon

_NARROWEST = 24.0
"""Width of a patch from which it has a name [px]."""
_GAP = 2.0
"""Between a patch and its name [px]."""
_MOST_CORNERS = 80
"""Corners of an outline from which not all are used."""
_ACROSS = 9
_DOWN = 3
"""Sample points of a name, by which the skin under it is estimated."""

Name = tuple[QRectF, str]
"""Box and text of a name."""


class NamePlace:
    """Keeps the places until map, viewport or legends change, because finding them takes longer than painting.

    Args:
        font: Font of the names.
    """

    def __init__(self, font: QFont) -> None:
        self._font = font
        self._of: tuple[object, ...] = ()
        self._names: list[Name] = []

    def names(
        self, shapes: MapShapes, view: QTransform, room: QRectF, legends: Sequence[QRectF], scale: QRectF
    ) -> list[Name]:
        """Return the names of all patches that are shown and wide enough.

        Args:
            shapes: Shapes of the map.
            view: Conversion of scene units to pixels.
            room: The viewport.
            legends: Boxes of legends.
            scale: Box of the scale bar.
        """
        of = (shapes, QTransform(view), QRectF(room), list(legends), QRectF(scale))
        if of != self._of:
            self._of = of
            self._names = self._place(shapes, view, room, legends, scale)
        return self._names

    def _place(
        self, shapes: MapShapes, view: QTransform, room: QRectF, legends: Sequence[QRectF], scale: QRectF
    ) -> list[Name]:
        skin = [_Area.of(patch, view) for patch in shapes.patches if patch.shown]
        taken = [*legends, scale]
        found = list[Name]()
        for patch, own in zip([patch for patch in shapes.patches if patch.shown], skin, strict=True):
            box = own.bounds
            if not box.intersects(room) or box.width() < _NARROWEST:
                continue
            metrics = QFontMetricsF(self._font)
            text = metrics.elidedText(patch.name, Qt.TextElideMode.ElideMiddle, max(box.width() + 16, 40))
            best = _usual(box, chip_size(text, self._font), room, legends)
            if box.top() >= MARGIN_PX - 1:  # above a patch that extends beyond the viewport is no place
                best = _least_hiding(best, own, room, skin, taken)
            taken.append(best)
            found.append((best, text))
        return found


@dataclass(frozen=True, eq=False)
class _Area:
    """A patch [px]: its outline (b, 2), corners (k, 2) of it, paths through these and through all, and its box."""

    pixels: FloatArray
    corners: FloatArray
    bounds: QRectF

    @classmethod
    def of(cls, patch: PatchShape, view: QTransform) -> _Area:
        pixels = patch.outline * [view.m11(), view.m22()] + [view.dx(), view.dy()]
        low, high = patch.box
        bounds = view.mapRect(QRectF(*low, *(high - low)))
        return cls(pixels, pixels[:: 1 + len(pixels) // _MOST_CORNERS], bounds)

    @cached_property
    def outline(self) -> QPainterPath:
        return _path(self.corners)

    @cached_property
    def exact(self) -> QPainterPath:
        return _path(self.pixels)

    def distance(self, place: QRectF) -> float:
        """Return the distance from a box to the nearest corner of the outline."""
        low = np.array([place.left(), place.top()])
        high = np.array([place.right(), place.bottom()])
        away = np.maximum(np.maximum(low - self.corners, self.corners - high), 0.0)
        return float(np.linalg.norm(away, axis=1).min())


def _path(corners: FloatArray) -> QPainterPath:
    path = QPainterPath()
    path.addPolygon(polygon(corners))
    path.setFillRule(Qt.FillRule.WindingFill)
    return path


def _usual(box: QRectF, size: QSizeF, room: QRectF, legends: Sequence[QRectF]) -> QRectF:
    """Return the place above the middle of a patch, or next to a legend that is there.

    It is at the viewport's upper edge if the patch extends beyond that.
    """
    middle = box.intersected(room).center().x()
    left = min(max(middle - size.width() / 2, EDGE), room.right() - EDGE - size.width())
    top = max(box.top() - size.height() - _GAP, EDGE if box.top() < MARGIN_PX - 1 else 0.0)
    found = QRectF(QPointF(left, top), size)
    for legend in legends:
        if found.intersects(legend):
            lefts = (legend.left() - found.width() - 4, legend.right() + 4)
            moved = [found.translated(left - found.left(), 0) for left in lefts]
            free = [one for one in moved if one.left() >= EDGE and one.right() <= room.right() - EDGE]
            return min(free, key=lambda one: abs(one.left() - found.left()), default=found)
    return found


def _least_hiding(usual: QRectF, own: _Area, room: QRectF, skin: Sequence[_Area], taken: Sequence[QRectF]) -> QRectF:
    """Return the first place that hides nothing, or else the one that hides least skin.

    Places above a patch belong to it. Others must be nearer to it than to any other patch, or the name would be taken
    for that one's.
    """

    def possible(places: Iterable[QRectF]) -> list[QRectF]:
        return [place for place in places if room.contains(place) and not any(map(place.intersects, taken))]

    def is_free(place: QRectF) -> bool:
        return not any(_hits(place, skin)) and not _meets(place, skin)

    above = possible([usual, *_above(own.bounds, usual.size())])
    for place in above:
        if is_free(place):
            return place
    around = [place for place in possible(_around(own.bounds, usual.size())) if _belongs(place, own, skin)]
    best = min([*above, *around], key=lambda place: sum(_hits(place, skin)), default=usual)
    return next(filter(is_free, around), best)


def _above(box: QRectF, size: QSizeF) -> Iterator[QRectF]:
    for share in (0.25, 0.75, 0.0, 1.0):
        left = box.left() + share * (box.width() - size.width())
        yield QRectF(QPointF(left, box.top() - size.height() - _GAP), size)


def _around(box: QRectF, size: QSizeF) -> Iterator[QRectF]:
    """Yield places in the corners of the box of a patch, which the patch may leave free, and next to it."""
    width = size.width()
    height = size.height()
    for down, left in product((0.0, 0.5 * height, height), (box.left(), box.right() - width)):
        yield QRectF(QPointF(left, box.top() + down), size)
    for share in (0.5, 0.25, 0.75, 0.0, 1.0):
        yield QRectF(QPointF(box.left() + share * (box.width() - width), box.bottom() + _GAP), size)
    for down, left in product((0.5, 0.25, 0.75), (box.left() - width - _GAP, box.right() + _GAP)):
        yield QRectF(QPointF(left, box.top() + down * (box.height() - height)), size)


def _belongs(place: QRectF, own: _Area, skin: Sequence[_Area]) -> bool:
    """Whether a place is nearer to the outline of its own patch than to those of the others."""
    distance = own.distance(place)
    near = place.adjusted(-distance, -distance, distance, distance)
    others = (area for area in skin if area is not own and area.bounds.intersects(near))
    return all(other.distance(place) > distance for other in others)


def _meets(place: QRectF, skin: Sequence[_Area]) -> bool:
    """Whether a place hides any skin, also less than between two sample points."""
    return any(area.exact.intersects(place) for area in skin if area.bounds.intersects(place))


def _hits(place: QRectF, skin: Sequence[_Area]) -> Iterator[bool]:
    """Yield for sample points of a place whether they are on skin."""
    near = [area.outline for area in skin if area.bounds.intersects(place)]
    for i, j in product(range(_ACROSS), range(_DOWN)) if near else ():
        x = place.left() + i / (_ACROSS - 1) * place.width()
        point = QPointF(x, place.top() + j / (_DOWN - 1) * place.height())
        yield any(outline.contains(point) for outline in near)
