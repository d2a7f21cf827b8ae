"""How a law's task looks over the map: the wanted path violet, the target, the way of the contact white and fading."""

from __future__ import annotations

from functools import partial
from itertools import pairwise

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QPainter, QPen, QTransform

from app.arrays import FloatArray
from widgets.colours import Theme
from widgets.map_view.map_items import points
from widgets.map_view.map_shapes import MapShapes
from widgets.map_view.stamp import Stamp
from widgets.simplify import simplified
from widgets.task_shown import TaskShown, WantedPath

_HALO, _RIM = QColor(255, 255, 255, 215), QColor(29, 33, 38)
_WHITE = QColor(255, 255, 255)
_FADES = 5
"""So many shades from now to gone."""
_ARROW_EVERY, _FIRST_ARROW, _ARROW = 110.0, 36.0, 7.0
"""Between two arrowheads along the path, before the first, and length of one [px]."""
_ROOM = 16.0
"""Around the path, for its width and heads [px]."""
MapInView = tuple[QTransform, QRectF]
"""From scene units to pixels, and the viewport."""


class TaskPainter:
    """Draws a task. Mutable: it keeps the path in pixels until path, view or patches are others."""

    def __init__(self) -> None:
        self._stamp = Stamp()

    def paint(
        self,
        painter: QPainter,
        task: TaskShown,
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


def _paint_path(path: WantedPath, shapes: MapShapes, view: QTransform, ink: QColor, painter: QPainter) -> QRectF:
    """Draw all of it that is on patches shown; where that is [px]."""
    shown = [line for line in path.lines if shapes.patches[line.patch].shown]
    lines = [simplified(_pixels(shapes.frame.to_scene(line.on_map), view), 0.3) for line in shown]
    curves = [points(line) for line in lines]
    for colour, width in ((_HALO, 5.4), (ink, 2.6)):
        painter.setPen(QPen(colour, width, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap, Qt.PenJoinStyle.RoundJoin))
        for curve in curves:
            painter.drawPolyline(curve)
    hops = [points(_pixels(shapes.frame.to_scene(ends), view)) for ends in path.crossings]
    dots = QPen(ink, 2.0, Qt.PenStyle.CustomDashLine, Qt.PenCapStyle.RoundCap)
    dots.setDashPattern([0.1, 3.0])
    painter.setPen(dots)
    for hop in hops:
        painter.drawPolyline(hop)
    painter.setPen(QPen(_HALO, 1.2))
    painter.setBrush(ink)
    for line in lines:
        for arrow in _arrows(line):
            painter.drawPolygon(points(arrow))
    box = QRectF()
    for curve in (*curves, *hops):
        box = box.united(curve.boundingRect())
    return box.adjusted(-_ROOM, -_ROOM, _ROOM, _ROOM)


def paint_target(painter: QPainter, at: QPointF, theme: Theme) -> None:
    """A ring with a cross hair that leaves its middle free."""
    for colour, width in ((_HALO, 5.0), (QColor(theme.intent), 2.2)):
        painter.setPen(QPen(colour, width, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap))
        painter.drawEllipse(at, 9.0, 9.0)
        for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1)):
            painter.drawLine(at + QPointF(5 * dx, 5 * dy), at + QPointF(14 * dx, 14 * dy))


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
    parts = [(points(places[a : b + 1]), 1 - int(shade[a]) / _FADES) for a, b in pairwise(cuts) if b > a]
    for base, extra in ((_RIM, 2.4), (_WHITE, 0.0)):
        for line, fresh in parts:
            colour = QColor(base)
            colour.setAlphaF(fresh)
            pen = QPen(colour, 1.6 + 1.8 * fresh + extra, Qt.PenStyle.SolidLine, Qt.PenCapStyle.FlatCap)
            pen.setJoinStyle(Qt.PenJoinStyle.BevelJoin)
            painter.setPen(pen)
            painter.drawPolyline(line)
