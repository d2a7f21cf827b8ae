"""How pins, lines, areas, the brush and words look over a view: a dark rim under each, to be seen on any ground."""

from __future__ import annotations

from collections.abc import Iterable

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QPainter, QPainterPath, QPen, QPolygonF

from app.arrays import FloatArray
from widgets.body_marks import Role
from widgets.colours import Theme

RIM = QColor(29, 33, 38)
PIN_PX, LARGE_PIN_PX = 5.0, 7.0
"""Half a pin's diagonal."""
_EDGE = 12.0

_CAPTIONS = 52.0
"""Height of what stands along the lower edge: scale bar, readout, slider [px]."""


def polygon(points: FloatArray) -> QPolygonF:
    """Points (k, 2) [px] for Qt."""
    return QPolygonF([QPointF(x, y) for x, y in points.tolist()])


def draw_lines(painter: QPainter, lines: Iterable[FloatArray], role: Role, theme: Theme) -> None:
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


def draw_words(painter: QPainter, text: str, theme: Theme, *, at: QPointF | None = None) -> None:
    """A chip with words beside a place [px], or in the middle above the view's captions; kept within the view."""
    font = QFont(painter.font())
    font.setPixelSize(13 if at is None else 11)
    metrics, room = QFontMetricsF(font), QRectF(painter.window())
    width, height = metrics.horizontalAdvance(text) + 16, metrics.height() + 6
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
