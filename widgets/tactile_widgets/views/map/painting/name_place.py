"""Places of the patches' names: next to each patch, over no legend, no other name, and as little skin as possible."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product

from PySide6.QtCore import QPointF, QRectF, QSizeF, Qt
from PySide6.QtGui import QFont, QFontMetricsF, QPainterPath, QTransform

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
        skin = [_area(patch, view) for patch in shapes.patches if patch.shown]
        taken = [*legends, scale]
        above = QRectF(room.topLeft(), QPointF(room.right(), scale.top()))  # the readout is next to the scale bar
        found = list[Name]()
        for patch in shapes.patches:
            low, high = patch.box
            box = view.mapRect(QRectF(*low, *(high - low)))
            if not (patch.shown and box.intersects(room)) or box.width() < _NARROWEST:
                continue
            metrics = QFontMetricsF(self._font)
            text = metrics.elidedText(patch.name, Qt.TextElideMode.ElideMiddle, max(box.width() + 16, 40))
            best = _usual(box, chip_size(text, self._font), room, legends)
            if box.top() >= MARGIN_PX - 1:  # above a patch that extends beyond the viewport is no place
                best = _least_hiding(best, box, above, skin, taken)
            taken.append(best)
            found.append((best, text))
        return found


@dataclass(frozen=True)
class _Area:
    """Outline of a patch [px], and its bounds."""

    outline: QPainterPath
    bounds: QRectF


def _area(patch: PatchShape, view: QTransform) -> _Area:
    outline = patch.chart.outline
    path = QPainterPath()
    path.addPolygon(view.map(polygon(patch.to_scene(outline[:: 1 + len(outline) // _MOST_CORNERS]))))
    path.setFillRule(Qt.FillRule.WindingFill)
    return _Area(path, path.boundingRect())


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


def _least_hiding(usual: QRectF, box: QRectF, room: QRectF, skin: Sequence[_Area], taken: Sequence[QRectF]) -> QRectF:
    """Return the first place that hides nothing, or else the one that hides least skin."""
    around = [place for place in _around(box, usual.size()) if room.contains(place)]
    places = [place for place in (usual, *around) if not any(map(place.intersects, taken))]
    free = (place for place in places if not any(_hits(place, skin)))
    return next(free, None) or min(places, key=lambda place: sum(_hits(place, skin)), default=usual)


def _around(box: QRectF, size: QSizeF) -> Iterator[QRectF]:
    """Yield places next to the box of a patch, and in its corners, which the patch may leave free."""
    width = size.width()
    height = size.height()
    span = box.width() - width
    above = box.top() - height - _GAP
    below = box.bottom() + _GAP
    beside = (box.left() - width - _GAP, box.right() + _GAP)
    inside = (box.left(), box.right() - width)
    for share in (0.25, 0.75, 0.0, 1.0):
        yield QRectF(QPointF(box.left() + share * span, above), size)
    for down, left in product((0.0, 0.5 * height, height), inside):
        yield QRectF(QPointF(left, box.top() + down), size)
    for share in (0.5, 0.25, 0.75, 0.0, 1.0):
        yield QRectF(QPointF(box.left() + share * span, below), size)
    for down, left in product((0.5, 0.25, 0.75), beside):
        yield QRectF(QPointF(left, box.top() + down * (box.height() - height)), size)


def _hits(place: QRectF, skin: Sequence[_Area]) -> Iterator[bool]:
    """Yield for sample points of a place whether they are on skin."""
    near = [area.outline for area in skin if area.bounds.intersects(place)]
    for i, j in product(range(_ACROSS), range(_DOWN)) if near else ():
        x = place.left() + i / (_ACROSS - 1) * place.width()
        point = QPointF(x, place.top() + j / (_DOWN - 1) * place.height())
        yield any(outline.contains(point) for outline in near)
