"""The few icons of the toolbar, drawn as one set: filled shapes on a 16 px grid, in the text's colour."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QIcon, QPainter, QPainterPath, QPen, QPixmap, QPolygonF

_SIZE = 16


def icon(name: str, colour: str, *, disabled: str) -> QIcon:
    """The icon ``name``: play, pause, step, reset, record or stop; ``disabled`` is its colour while it does nothing."""
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
    _SHAPES[name](painter, colour)
    painter.end()
    pixmap.setDevicePixelRatio(scale)
    return pixmap


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


_SHAPES: dict[str, Callable[[QPainter, str], None]] = {
    "play": _play,
    "pause": _pause,
    "step": _step,
    "reset": _reset,
    "record": _record,
    "stop": _stop,
}
