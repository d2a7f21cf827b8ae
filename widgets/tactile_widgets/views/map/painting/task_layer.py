"""The controller's task over the map: the wanted path violet, the target, the contact's own path white and fading.

With its legend: as many lines as there are kinds of marks. Path and legend seldom change, so they are kept in pixels
(``CachedPixmap``) and drawn again only when what they show is something else.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import pairwise

import numpy as np
from PySide6.QtCore import QPointF, QRectF, QSizeF, Qt
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QPainter, QPen, QPixmap, QTransform

from tactile_maps.core.arrays import FloatArray
from tactile_widgets.common.colours import Theme
from tactile_widgets.views.interaction.polyline import simplify_polyline
from tactile_widgets.views.map.items.background import paint_legend_box
from tactile_widgets.views.map.items.map_items import to_polygon
from tactile_widgets.views.map.items.map_shapes import MapShapes
from tactile_widgets.views.overlays.task_overlay import TRAIL_SECONDS, ReferencePath, TaskOverlay


class CachedPixmap:
    """Mutable; knows the last picture only."""

    def __init__(self) -> None:
        self._key: tuple[object, ...] = ()
        self._box = QRectF()
        self._pixmap = QPixmap()

    def paint(
        self, painter: QPainter, key: tuple[object, ...], draw: Callable[[QPainter], QRectF], room: QRectF
    ) -> QRectF:
        """Draw it, by ``draw`` where ``key`` or the display's scale is another one than the last time.

        Args:
            painter: Of the viewport.
            key: Compared by identity or value with the last one.
            draw: Draws on a painter in the viewport's pixels, and returns the box that holds all of it.
            room: The viewport; what lies outside is cut off.

        Returns:
            The box.
        """
        ratio = painter.device().devicePixelRatioF()
        now = (*key, ratio, room.width(), room.height())
        if len(now) != len(self._key) or any(a is not b and a != b for a, b in zip(now, self._key, strict=True)):
            self._key, (self._box, self._pixmap) = now, _drawn(draw, room, ratio)
        painter.drawPixmap(self._box.topLeft(), self._pixmap)
        return self._box


def _drawn(draw: Callable[[QPainter], QRectF], room: QRectF, ratio: float) -> tuple[QRectF, QPixmap]:
    whole = QPixmap((room.size() * ratio).toSize())
    whole.setDevicePixelRatio(ratio)
    whole.fill(Qt.GlobalColor.transparent)
    painter = QPainter(whole)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    box = draw(painter).intersected(room).toAlignedRect()
    painter.end()
    cut = QRectF(box.x() * ratio, box.y() * ratio, box.width() * ratio, box.height() * ratio).toRect()
    return QRectF(box), whole.copy(cut)


_HALO = QColor(255, 255, 255, 215)
_RIM = QColor(29, 33, 38)
_WHITE = QColor(255, 255, 255)
_FADES = 5
"""So many shades from now to gone."""
_ARROW_EVERY = 110.0
_FIRST_ARROW = 36.0
_ARROW = 7.0
"""Between two arrowheads along the path, before the first, and length of one [px]."""
_CROSS = ((1, 0), (-1, 0), (0, 1), (0, -1))
_CLEAR = 11.0
_REACH = 20.0
"""The target's strokes begin and end so far from it [px]."""
_ROOM = 16.0
"""Around the path, for its width and heads [px]."""
MapInView = tuple[QTransform, QRectF]
"""From scene units to pixels, and the viewport."""


class TaskPainter:
    """Draws a task. Mutable: it keeps the path in pixels until path, view or patches are others."""

    def __init__(self) -> None:
        self._stamp = CachedPixmap()

    def paint(
        self,
        painter: QPainter,
        task: TaskOverlay,
        target: QPointF | None,
        shapes: MapShapes,
        view: MapInView,
        theme: Theme,
    ) -> None:
        """Draw it.

        Args:
            painter: Of the viewport.
            task: What is wanted, and what was.
            target: Where that is [px]; None where it is not to be seen.
            shapes: Of the map that is shown.
            view: From scene units to pixels, and the viewport.
            theme: Its intent is the controller's.
        """
        if task.path:
            transform, room = view
            key = (task.path, shapes, transform.m11(), transform.dx(), transform.dy(), theme.intent)
            self._stamp.paint(
                painter, key, partial(_paint_path, task.path, shapes, transform, QColor(theme.intent)), room
            )
        for part in task.tail.lines:
            if shapes.patches[int(task.tail.patch[part.start])].shown:
                on_screen = _pixels(shapes.frame.to_scene(task.tail.on_map[part]), view[0])
                _paint_tail(painter, on_screen, task.tail.age[part])
        if target is not None:
            paint_target(painter, target, theme)


def _paint_path(path: ReferencePath, shapes: MapShapes, view: QTransform, ink: QColor, painter: QPainter) -> QRectF:
    """Draw all of it that is on patches shown; where that is [px]."""
    shown = [line for line in path.lines if shapes.patches[line.patch].shown]
    lines = [simplify_polyline(_pixels(shapes.frame.to_scene(line.on_map), view), 0.3) for line in shown]
    curves = [to_polygon(line) for line in lines]
    for colour, width in ((_HALO, 5.4), (ink, 2.6)):
        painter.setPen(QPen(colour, width, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap, Qt.PenJoinStyle.RoundJoin))
        for curve in curves:
            painter.drawPolyline(curve)
    hops = [to_polygon(_pixels(shapes.frame.to_scene(ends), view)) for ends in path.crossings]
    dots = QPen(ink, 2.0, Qt.PenStyle.CustomDashLine, Qt.PenCapStyle.RoundCap)
    dots.setDashPattern([0.1, 3.0])
    painter.setPen(dots)
    for hop in hops:
        painter.drawPolyline(hop)
    painter.setPen(QPen(_HALO, 1.2))
    painter.setBrush(ink)
    for line in lines:
        for arrow in _arrows(line):
            painter.drawPolygon(to_polygon(arrow))
    box = QRectF()
    for curve in (*curves, *hops):
        box = box.united(curve.boundingRect())
    return box.adjusted(-_ROOM, -_ROOM, _ROOM, _ROOM)


def paint_target(painter: QPainter, at: QPointF, theme: Theme) -> None:
    """Four strokes that point at it from outside: the touch is mostly there already, and is not to be hidden."""
    for colour, width in ((_HALO, 5.0), (QColor(theme.intent), 2.2)):
        painter.setPen(QPen(colour, width, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap))
        for dx, dy in _CROSS:
            painter.drawLine(at + QPointF(_CLEAR * dx, _CLEAR * dy), at + QPointF(_REACH * dx, _REACH * dy))


def _pixels(places: FloatArray, view: QTransform) -> FloatArray:
    return places * [view.m11(), view.m22()] + [view.dx(), view.dy()]


def _arrows(line: FloatArray) -> list[FloatArray]:
    """Each (3, 2) [px]: heads along a line (k, 2), none on one that is shorter than a head."""
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    found = []
    for at in np.arange(min(_FIRST_ARROW, way[-1] / 2), way[-1] - _ARROW, _ARROW_EVERY):
        back, tip = (np.array([np.interp(at + by, way, line[:, k]) for k in (0, 1)]) for by in (0, _ARROW))
        along = tip - back
        if np.linalg.norm(along) > _ARROW / 2:  # not where the line turns back
            along *= _ARROW / np.linalg.norm(along)
            aside = 0.75 * np.array([-along[1], along[0]])
            found.append(np.stack([back + 1.3 * along, back + aside, back - aside]))
    return found


def _paint_tail(painter: QPainter, places: FloatArray, age: FloatArray) -> None:
    """The newest part is widest and opaque."""
    shade = np.minimum((age * _FADES).astype(int), _FADES - 1)
    cuts = [0, *(np.flatnonzero(np.diff(shade)) + 1).tolist(), len(places) - 1]
    parts = [(to_polygon(places[a : b + 1]), 1 - int(shade[a]) / _FADES) for a, b in pairwise(cuts) if b > a]
    for base, extra in ((_RIM, 2.4), (_WHITE, 0.0)):
        for line, fresh in parts:
            colour = QColor(base)
            colour.setAlphaF(fresh)
            pen = QPen(colour, 1.6 + 1.8 * fresh + extra, Qt.PenStyle.SolidLine, Qt.PenCapStyle.FlatCap)
            pen.setJoinStyle(Qt.PenJoinStyle.BevelJoin)
            painter.setPen(pen)
            painter.drawPolyline(line)


WANTED = "Reference path"
TARGET = "Target"
ACTUAL = f"Contact path, last {TRAIL_SECONDS:g}\u202fs"
_PAD = 8.0
_GLYPH = 18.0
_INDENT = _GLYPH + 8
_LEGEND_RIM = QColor(29, 33, 38)
_LEGEND_WHITE = QColor(255, 255, 255)


def task_legend_entries(task: TaskOverlay) -> tuple[str, ...]:
    """What there is to explain, in words."""
    return tuple(
        words
        for words, there in (
            (WANTED, bool(task.path)),
            (TARGET, task.target is not None),
            (ACTUAL, bool(task.tail.lines)),
        )
        if there
    )


class TaskLegend:
    """Draws the key. Mutable: it keeps it in pixels until it says something else."""

    def __init__(self) -> None:
        self._stamp = CachedPixmap()

    def paint(
        self, painter: QPainter, keys: tuple[str, ...], box: QRectF, font: QFont, theme: Theme, room: QRectF
    ) -> None:
        """Draw it in ``box``, of its ``task_legend_size``; ``font`` is the caption's."""
        draw = partial(_paint_legend, keys, QRectF(box), QFont(font), theme)
        self._stamp.paint(painter, (keys, box.x(), box.y(), theme), draw, room)


def task_legend_size(keys: tuple[str, ...], font: QFont) -> QSizeF:
    """What it takes in ``font``, the caption's [px]; at least one key."""
    metrics = QFontMetricsF(font)
    width = max(metrics.horizontalAdvance(text) for text in keys) + _INDENT
    return QSizeF(width + 2 * _PAD, (metrics.height() + 3) * len(keys) + 2 * _PAD - 3)


def _paint_legend(keys: tuple[str, ...], box: QRectF, font: QFont, theme: Theme, painter: QPainter) -> QRectF:
    line = QFontMetricsF(font).height() + 3
    paint_legend_box(painter, box, theme)
    painter.setFont(font)
    row = QRectF(box.left() + _PAD, box.top() + _PAD - 1, box.width() - 2 * _PAD, line)
    for text in keys:
        middle = QPointF(row.left() + _GLYPH / 2, row.center().y())
        _paint_glyph(painter, text, middle, theme)
        painter.setPen(QColor(theme.quiet))
        painter.drawText(
            row.adjusted(_INDENT, 0, 0, 0), Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter, text
        )
        row.translate(0, line)
    return box


def _paint_glyph(painter: QPainter, key: str, middle: QPointF, theme: Theme) -> None:
    reach = QPointF(_GLYPH / 2, 0)
    ink = QColor(theme.intent)
    if key == TARGET:
        painter.setPen(QPen(ink, 2.0, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap))
        for dx, dy in _CROSS:
            painter.drawLine(middle + QPointF(3 * dx, 3 * dy), middle + QPointF(6.5 * dx, 6.5 * dy))
        return
    strokes = ((ink, 2.6),) if key == WANTED else ((_LEGEND_RIM, 5.0), (_LEGEND_WHITE, 2.8))
    for colour, width in strokes:
        painter.setPen(QPen(colour, width, Qt.PenStyle.SolidLine, Qt.PenCapStyle.FlatCap))
        painter.drawLine(middle - reach, middle + reach)
