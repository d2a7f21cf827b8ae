"""The key to what a law's task draws: as many lines as there are kinds of marks, none where there are none."""

from __future__ import annotations

from functools import partial

from PySide6.QtCore import QPointF, QRectF, QSizeF, Qt
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QPainter, QPen

from widgets.colours import Theme
from widgets.map_view.map_legend import paint_plate
from widgets.map_view.stamp import Stamp
from widgets.task_shown import TAIL_SECONDS, TaskShown

WANTED, TARGET, ACTUAL = "Wanted path", "Target", f"Contact, last {TAIL_SECONDS:g}\u2009s"
_PAD, _GLYPH = 8.0, 18.0
_RIM, _WHITE = QColor(29, 33, 38), QColor(255, 255, 255)


def task_keys(task: TaskShown) -> tuple[str, ...]:
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


class TaskKeys:
    """Draws the key. Mutable: it keeps it in pixels until it says something else."""

    def __init__(self) -> None:
        self._stamp = Stamp()

    def paint(
        self, painter: QPainter, keys: tuple[str, ...], corner: QPointF, font: QFont, theme: Theme, room: QRectF
    ) -> QRectF:
        """Draw it with its upper right corner at ``corner``; ``font`` is the caption's. Returns where it is."""
        draw = partial(_paint_keys, keys, QPointF(corner), QFont(font), theme)
        return self._stamp.paint(painter, (keys, corner.x(), corner.y(), theme), draw, room)


def _paint_keys(keys: tuple[str, ...], corner: QPointF, font: QFont, theme: Theme, painter: QPainter) -> QRectF:
    metrics = QFontMetricsF(font)
    line, indent = metrics.height() + 3, _GLYPH + 8
    width = max(metrics.horizontalAdvance(text) for text in keys) + indent
    size = QSizeF(width + 2 * _PAD, line * len(keys) + 2 * _PAD - 3)
    box = QRectF(QPointF(corner.x() - size.width(), corner.y()), size)
    paint_plate(painter, box, theme)
    painter.setFont(font)
    row = QRectF(box.left() + _PAD, box.top() + _PAD - 1, width, line)
    for text in keys:
        middle = QPointF(row.left() + _GLYPH / 2, row.center().y())
        _paint_glyph(painter, text, middle, theme)
        painter.setPen(QColor(theme.quiet))
        painter.drawText(
            row.adjusted(indent, 0, 0, 0), Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter, text
        )
        row.translate(0, line)
    return box


def _paint_glyph(painter: QPainter, key: str, middle: QPointF, theme: Theme) -> None:
    reach, ink = QPointF(_GLYPH / 2, 0), QColor(theme.intent)
    if key == TARGET:
        painter.setPen(QPen(ink, 1.8))
        painter.drawEllipse(middle, 3.5, 3.5)
        for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1)):
            painter.drawLine(middle + QPointF(2.5 * dx, 2.5 * dy), middle + QPointF(6 * dx, 6 * dy))
        return
    strokes = ((ink, 2.6),) if key == WANTED else ((_RIM, 5.0), (_WHITE, 2.8))
    for colour, width in strokes:
        painter.setPen(QPen(colour, width, Qt.PenStyle.SolidLine, Qt.PenCapStyle.FlatCap))
        painter.drawLine(middle - reach, middle + reach)
