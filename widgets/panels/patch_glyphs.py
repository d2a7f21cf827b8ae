"""The small signs in a row of the patch tree, drawn in the text's colours."""

from __future__ import annotations

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QPainter, QPainterPath, QPen

SIZE = 16


def draw_eye(painter: QPainter, box: QRectF, colour: QColor, *, open_: bool) -> None:
    """An eye in the middle of ``box``: open, or a closed lid with lashes."""
    painter.save()
    painter.translate(box.center())
    painter.setPen(QPen(colour, 1.4, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap))
    painter.setBrush(Qt.BrushStyle.NoBrush)
    lids = QPainterPath(QPointF(-6.5, 0))
    if open_:
        lids.quadTo(QPointF(0, -7), QPointF(6.5, 0))
        lids.quadTo(QPointF(0, 7), QPointF(-6.5, 0))
        painter.drawPath(lids)
        painter.setBrush(colour)
        painter.drawEllipse(QPointF(0, 0), 1.6, 1.6)
    else:
        lids.quadTo(QPointF(0, 7), QPointF(6.5, 0))
        painter.drawPath(lids)
        for x, y, dx, dy in ((-4.2, 2.3, -1.3, 2.0), (0.0, 3.5, 0.0, 2.2), (4.2, 2.3, 1.3, 2.0)):
            painter.drawLine(QPointF(x, y), QPointF(x + dx, y + dy))
    painter.restore()


def draw_pin(painter: QPainter, box: QRectF, colour: QColor) -> None:
    """A pin, head up."""
    painter.save()
    painter.translate(box.center())
    painter.setPen(QPen(colour, 1.4, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap))
    painter.drawLine(QPointF(0, -1), QPointF(0, 6))
    painter.setBrush(colour)
    painter.drawEllipse(QPointF(0, -3), 2.6, 2.6)
    painter.restore()


def draw_seam(painter: QPainter, box: QRectF, colour: QColor) -> None:
    """A dashed line, as seams are on the map."""
    painter.save()
    painter.translate(box.center())
    pen = QPen(colour, 1.4, Qt.PenStyle.CustomDashLine, Qt.PenCapStyle.FlatCap)
    pen.setDashPattern([2.4, 1.8])
    painter.setPen(pen)
    painter.setBrush(Qt.BrushStyle.NoBrush)
    line = QPainterPath(QPointF(-6, 4))
    line.cubicTo(QPointF(-2, -5), QPointF(2, 5), QPointF(6, -4))
    painter.drawPath(line)
    painter.restore()
