"""How a path under the hand looks: handles, the middles that corners are pulled from, and the line being drawn."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QPainter, QPen

from app.arrays import FloatArray
from widgets.colours import Theme
from widgets.edit_tools.drawing import polygon

HANDLE_PX, LARGE_HANDLE_PX = 9.0, 12.0
_LEAST_ROOM = 14.0
"""Between a corner and a middle [px]: nearer, the middle would be hidden by the corner's handle."""
_HALO = QColor(255, 255, 255, 210)
_RIM = QColor(29, 33, 38, 170)


def draw_handles(
    painter: QPainter, corners: FloatArray, theme: Theme, *, hovered: int | None, chosen: int | None
) -> None:
    """A square at each corner (h, 2) [px]; the one under the pointer larger, the chosen one filled."""
    for number, (x, y) in enumerate(corners.tolist()):
        size = LARGE_HANDLE_PX if number == hovered else HANDLE_PX
        box = QRectF(x - size / 2, y - size / 2, size, size)
        painter.setBrush(QColor(theme.intent) if number == chosen else QColor(255, 255, 255))
        for pen in (QPen(_RIM, 3.5), QPen(QColor(theme.intent), 1.8)):
            painter.setPen(pen)
            painter.drawRect(box)
    painter.setBrush(Qt.BrushStyle.NoBrush)


def draw_middles(
    painter: QPainter, middles: FloatArray, corners: FloatArray, theme: Theme, *, hovered: int | None
) -> None:
    """A small disc with a plus at each middle (s, 2) [px] that has room between the corners (h, 2) [px]."""
    room = np.linalg.norm(middles[:, None] - corners, axis=2).min(axis=1, initial=np.inf)
    for number in np.flatnonzero(room > _LEAST_ROOM).tolist():
        at = middles[number].tolist()
        centre, radius = QPointF(*at), 6.5 if number == hovered else 4.5
        painter.setPen(QPen(_RIM, 1.0))
        painter.setBrush(_HALO)
        painter.drawEllipse(centre, radius, radius)
        painter.setPen(QPen(QColor(theme.intent), 1.6))
        for step in (QPointF(radius - 2, 0), QPointF(0, radius - 2)):
            painter.drawLine(centre - step, centre + step)
    painter.setBrush(Qt.BrushStyle.NoBrush)


def draw_sketch(painter: QPainter, line: FloatArray, theme: Theme) -> None:
    """The path as it would be (k, 2) [px], dashed."""
    shape = polygon(line)
    dashes = QPen(QColor(theme.intent), 2.2, Qt.PenStyle.CustomDashLine, Qt.PenCapStyle.FlatCap)
    dashes.setDashPattern([4.0, 2.5])
    halo = QPen(_HALO, 4.6, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap)
    for pen in (halo, dashes):
        pen.setJoinStyle(Qt.PenJoinStyle.RoundJoin)
        painter.setPen(pen)
        painter.drawPolyline(shape)
