"""The few icons of the toolbar, drawn as one set: filled shapes on a 16 px grid, in the text's colour."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QIcon, QPainter, QPainterPath, QPen, QPixmap, QPolygonF

_SIZE = 16


def icon(name: str, colour: str, *, disabled: str) -> QIcon:
    """The icon ``name``, of the session's acts or of a tool; ``disabled`` is its colour while it does nothing.

    A name for which nothing is drawn has its first letter for an icon.
    """
    result = QIcon()
    for scale in (1, 2):
        result.addPixmap(_pixmap(name, colour, scale), QIcon.Mode.Normal)
        result.addPixmap(_pixmap(name, disabled, scale), QIcon.Mode.Disabled)
    return result


def _pixmap(name: str, colour: str, scale: int) -> QPixmap:
    pixmap = QPixmap(_SIZE * scale, _SIZE * scale)
    pixmap.fill(Qt.GlobalColor.transparent)
    painter = QPainter(pixmap)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.scale(scale, scale)
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(QColor(colour))
    if name in _SHAPES:
        _SHAPES[name](painter, colour)
    else:
        _letter(painter, colour, name)
    painter.end()
    pixmap.setDevicePixelRatio(scale)
    return pixmap


def _letter(painter: QPainter, colour: str, name: str) -> None:
    painter.setPen(QColor(colour))
    painter.drawText(QRectF(0, 0, _SIZE, _SIZE), Qt.AlignmentFlag.AlignCenter, name[:1].upper())


def _triangle(painter: QPainter, left: float, right: float) -> None:
    painter.drawPolygon(QPolygonF([QPointF(left, 3), QPointF(right, 8), QPointF(left, 13)]))


def _play(painter: QPainter, _colour: str) -> None:
    _triangle(painter, 4, 13)


def _pause(painter: QPainter, _colour: str) -> None:
    painter.drawRect(QRectF(4, 3, 3, 10))
    painter.drawRect(QRectF(9, 3, 3, 10))


def _step(painter: QPainter, _colour: str) -> None:
    _triangle(painter, 3, 10)
    painter.drawRect(QRectF(11, 3, 2, 10))


def _reset(painter: QPainter, colour: str) -> None:
    arc = QPainterPath()
    arc.arcMoveTo(QRectF(3, 3, 10, 10), 60)
    arc.arcTo(QRectF(3, 3, 10, 10), 60, 290)
    painter.strokePath(arc, QPen(QColor(colour), 1.8))
    painter.drawPolygon(QPolygonF([QPointF(9, 0.5), QPointF(14, 3.4), QPointF(9, 6.5)]))


def _record(painter: QPainter, _colour: str) -> None:
    painter.drawEllipse(QRectF(3, 3, 10, 10))


def _stop(painter: QPainter, _colour: str) -> None:
    painter.drawRect(QRectF(3.5, 3.5, 9, 9))


def _poke(painter: QPainter, colour: str) -> None:
    """A fingertip on the skin."""
    finger = QPainterPath()
    finger.addRoundedRect(QRectF(5.2, 1, 5.6, 10.5), 2.8, 2.8)
    painter.drawPath(finger)
    painter.setPen(QPen(QColor(colour), 1.6, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap))
    painter.drawLine(QPointF(1.5, 14), QPointF(14.5, 14))


def _select_box(painter: QPainter, colour: str) -> None:
    painter.setBrush(Qt.BrushStyle.NoBrush)
    pen = QPen(QColor(colour), 1.5, Qt.PenStyle.CustomDashLine, Qt.PenCapStyle.FlatCap)
    pen.setDashPattern([2.0, 1.4])
    painter.setPen(pen)
    painter.drawRect(QRectF(2, 3, 12, 10))


def _select_lasso(painter: QPainter, colour: str) -> None:
    loop = QPainterPath(QPointF(5, 10.5))
    loop.cubicTo(QPointF(-1, 8), QPointF(2, 2), QPointF(8, 2))
    loop.cubicTo(QPointF(15, 2), QPointF(16, 9), QPointF(9, 10))
    loop.cubicTo(QPointF(5, 10.5), QPointF(3, 8.5), QPointF(4.5, 14.5))
    painter.strokePath(loop, QPen(QColor(colour), 1.6))


def _select_brush(painter: QPainter, colour: str) -> None:
    painter.setBrush(Qt.BrushStyle.NoBrush)
    painter.setPen(QPen(QColor(colour), 1.5))
    painter.drawEllipse(QRectF(2, 2, 12, 12))
    painter.setBrush(QColor(colour))
    painter.drawEllipse(QRectF(6.5, 6.5, 3, 3))


def _arrange(painter: QPainter, _colour: str) -> None:
    """A patch with arrows to all sides."""
    painter.drawRect(QRectF(5.8, 5.8, 4.4, 4.4))
    for turn in range(4):
        painter.save()
        painter.translate(8, 8)
        painter.rotate(90 * turn)
        painter.drawPolygon(QPolygonF([QPointF(-2.4, -4.4), QPointF(2.4, -4.4), QPointF(0, -7.6)]))
        painter.restore()


def _pins(painter: QPainter, colour: str) -> None:
    painter.drawEllipse(QRectF(4.2, 1, 7.6, 7.6))
    painter.setPen(QPen(QColor(colour), 1.6, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap))
    painter.drawLine(QPointF(8, 8), QPointF(8, 14.5))


def _grid(painter: QPainter, colour: str) -> None:
    """Rows and columns of taxels."""
    painter.setBrush(QColor(colour))
    for x in (3.0, 8.0, 13.0):
        for y in (3.0, 8.0, 13.0):
            painter.drawEllipse(QPointF(x, y), 1.1, 1.1)


def _seams(painter: QPainter, colour: str) -> None:
    """Two pieces and the stitches between them."""
    pen = QPen(QColor(colour), 1.5)
    painter.setPen(pen)
    for y in (3.0, 8.0, 13.0):
        painter.drawLine(QPointF(4.5, y), QPointF(11.5, y))
    pen.setDashPattern([1.6, 1.4])
    painter.setPen(pen)
    painter.drawLine(QPointF(8, 0.8), QPointF(8, 15.2))


def _interest(painter: QPainter, colour: str) -> None:
    """A place fenced in."""
    painter.drawEllipse(QRectF(5.4, 5.4, 5.2, 5.2))
    pen = QPen(QColor(colour), 1.4)
    pen.setDashPattern([2.2, 1.6])
    painter.setBrush(Qt.BrushStyle.NoBrush)
    painter.setPen(pen)
    painter.drawEllipse(QRectF(1.6, 1.6, 12.8, 12.8))


def _draw_path(painter: QPainter, colour: str) -> None:
    """A line that winds from a corner to an arrowhead."""
    line = QPainterPath(QPointF(3, 12.5))
    line.cubicTo(QPointF(5.5, 2), QPointF(9, 14), QPointF(11.6, 5.6))
    painter.strokePath(line, QPen(QColor(colour), 1.6))
    painter.drawRect(QRectF(1.2, 10.8, 3.6, 3.6))
    painter.drawPolygon(QPolygonF([QPointF(13.4, 0.8), QPointF(14.6, 7.2), QPointF(8.6, 5.4)]))


def _set_target(painter: QPainter, colour: str) -> None:
    """A ring with a cross hair."""
    painter.setBrush(Qt.BrushStyle.NoBrush)
    painter.setPen(QPen(QColor(colour), 1.5))
    painter.drawEllipse(QRectF(3.5, 3.5, 9, 9))
    for x, y in ((1, 0), (-1, 0), (0, 1), (0, -1)):
        painter.drawLine(QPointF(8 + 2.6 * x, 8 + 2.6 * y), QPointF(8 + 7.2 * x, 8 + 7.2 * y))


def _posture(painter: QPainter, colour: str) -> None:
    """Two links, the joint between them, and the hand that leads."""
    pen = QPen(QColor(colour), 2.2, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap)
    painter.setPen(pen)
    painter.drawLine(QPointF(3, 14), QPointF(5.2, 6.2))
    painter.drawLine(QPointF(5.2, 6.2), QPointF(12.4, 9.6))
    painter.setPen(QPen(QColor(colour), 1.4))
    painter.setBrush(Qt.BrushStyle.NoBrush)
    painter.drawEllipse(QPointF(5.2, 4.2), 2.2, 2.2)
    painter.drawEllipse(QPointF(13.2, 12.4), 1.8, 1.8)


def _undo(painter: QPainter, colour: str) -> None:
    bow = QPainterPath(QPointF(4, 5.5))
    bow.lineTo(10, 5.5)
    bow.arcTo(QRectF(6.2, 5.5, 7.6, 7.6), 90, -180)
    bow.lineTo(6, 13.1)
    painter.strokePath(bow, QPen(QColor(colour), 1.6))
    painter.drawPolygon(QPolygonF([QPointF(5.2, 1.6), QPointF(5.2, 9.4), QPointF(0.8, 5.5)]))


def _redo(painter: QPainter, colour: str) -> None:
    painter.translate(16, 0)
    painter.scale(-1, 1)
    _undo(painter, colour)


_SHAPES: dict[str, Callable[[QPainter, str], None]] = {
    "play": _play,
    "pause": _pause,
    "step": _step,
    "reset": _reset,
    "record": _record,
    "stop": _stop,
    "poke": _poke,
    "select_box": _select_box,
    "select_lasso": _select_lasso,
    "select_brush": _select_brush,
    "arrange": _arrange,
    "pins": _pins,
    "seams": _seams,
    "interest": _interest,
    "grid": _grid,
    "draw_path": _draw_path,
    "set_target": _set_target,
    "posture": _posture,
    "undo": _undo,
    "redo": _redo,
}
