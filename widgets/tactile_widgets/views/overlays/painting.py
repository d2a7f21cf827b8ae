"""Painting over a view: pins, lines, areas, brush, labels, path handles. A dark rim is under each, to be seen on any
ground.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QPainter, QPainterPath, QPen, QPolygonF

from tactile_maps.core.arrays import FloatArray
from tactile_widgets.common.colours import Theme
from tactile_widgets.views.overlays.body_overlays import MarkRole

RIM = QColor(29, 33, 38)
PIN_PX = 5.0
LARGE_PIN_PX = 7.0
"""Half a pin's diagonal."""
_EDGE = 12.0

_CAPTIONS = 52.0
"""Height of what stands along the lower edge: scale bar, readout, slider [px]."""


def polygon(points: FloatArray) -> QPolygonF:
    """Points (k, 2) [px] for Qt."""
    return QPolygonF([QPointF(x, y) for x, y in points.tolist()])


def draw_lines(painter: QPainter, lines: Iterable[FloatArray], role: MarkRole, theme: Theme) -> None:
    """Lines (k, 2) [px] of one meaning."""
    shapes = [polygon(line) for line in lines]
    style = Qt.PenStyle.CustomDashLine if role.dashed else Qt.PenStyle.SolidLine
    for colour, width, dash in ((_faint(RIM, 200), 4.5, Qt.PenStyle.SolidLine), (QColor(role.ink(theme)), 2.0, style)):
        pen = QPen(colour, width)
        pen.setCapStyle(Qt.PenCapStyle.FlatCap if dash is style and role.dashed else Qt.PenCapStyle.RoundCap)
        pen.setJoinStyle(Qt.PenJoinStyle.RoundJoin)
        if dash is Qt.PenStyle.CustomDashLine:
            pen.setDashPattern([4.0, 2.5])
        painter.setPen(pen)
        for shape in shapes:
            painter.drawPolyline(shape)


def draw_pin(painter: QPainter, at: QPointF, colour: QColor, *, large: bool) -> None:
    """A diamond."""
    half = LARGE_PIN_PX if large else PIN_PX
    corners = [QPointF(at.x() + x * half, at.y() + y * half) for x, y in ((0, -1), (1, 0), (0, 1), (-1, 0))]
    painter.setPen(QPen(RIM, 1.5))
    painter.setBrush(colour)
    painter.drawPolygon(QPolygonF(corners))
    painter.setBrush(Qt.BrushStyle.NoBrush)


def draw_vertex(painter: QPainter, at: FloatArray, theme: Theme, *, fixed: bool) -> None:
    """A small disc where a seam goes through, or a ring where it could."""
    painter.setPen(QPen(RIM, 1.5))
    painter.setBrush(QColor(theme.accent) if fixed else Qt.BrushStyle.NoBrush)
    painter.drawEllipse(QPointF(*at.tolist()), 4.5, 4.5)
    painter.setBrush(Qt.BrushStyle.NoBrush)
    if not fixed:
        painter.setPen(QPen(QColor(theme.accent), 1.5))
        painter.drawEllipse(QPointF(*at.tolist()), 6, 6)


def draw_area(painter: QPainter, loops: Iterable[FloatArray], theme: Theme) -> None:
    """An area inside loops (k, 2) [px], holes left out, seen through."""
    path = QPainterPath()
    path.setFillRule(Qt.FillRule.OddEvenFill)
    for loop in loops:
        path.addPolygon(polygon(loop))
        path.closeSubpath()
    painter.fillPath(path, _faint(QColor(theme.accent), 70))
    for colour, width in ((_faint(RIM, 150), 2.5), (QColor(theme.accent), 1.2)):
        painter.strokePath(path, QPen(colour, width))


def draw_brush(painter: QPainter, middle: QPointF, radius: float, theme: Theme, *, erases: bool) -> None:
    """The brush's circle, with a bar across while it erases."""
    painter.setBrush(Qt.BrushStyle.NoBrush)
    for colour, style in ((_faint(RIM, 170), Qt.PenStyle.SolidLine), (QColor(theme.accent), Qt.PenStyle.DashLine)):
        pen = QPen(colour, 1.5)
        pen.setStyle(style)
        painter.setPen(pen)
        painter.drawEllipse(middle, radius, radius)
        if erases:
            painter.drawLine(middle - QPointF(5, 0), middle + QPointF(5, 0))


def draw_label(painter: QPainter, text: str, theme: Theme, *, at: QPointF | None = None) -> None:
    """A chip with words beside a place [px], or in the middle above the view's captions; kept within the view."""
    font = QFont(painter.font())
    font.setPixelSize(13 if at is None else 11)
    metrics = QFontMetricsF(font)
    room = QRectF(painter.window())
    width = metrics.horizontalAdvance(text) + 16
    height = metrics.height() + 6
    foot = QPointF((room.width() - width) / 2, room.height() - height - _CAPTIONS)
    corner = foot if at is None else at + QPointF(12, -height - 4)
    left, top = (
        min(max(start, _EDGE), max(whole - own - _EDGE, _EDGE))
        for start, whole, own in ((corner.x(), room.width(), width), (corner.y(), room.height(), height))
    )
    box = QRectF(left, top, width, height)
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(_faint(QColor(theme.panel), 235))
    painter.drawRoundedRect(box, 4, 4)
    painter.setBrush(Qt.BrushStyle.NoBrush)
    painter.setFont(font)
    painter.setPen(QColor(theme.text))
    painter.drawText(box, Qt.AlignmentFlag.AlignCenter, text)


def _faint(colour: QColor, alpha: int) -> QColor:
    made = QColor(colour)
    made.setAlpha(alpha)
    return made


HANDLE_PX = 9.0
LARGE_HANDLE_PX = 12.0
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
        centre = QPointF(*at)
        radius = 6.5 if number == hovered else 4.5
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
