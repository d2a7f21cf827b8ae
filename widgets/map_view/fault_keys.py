"""The key to the marks of faulty taxels: as many lines as there are kinds of faults, none where there are none."""

from __future__ import annotations

from collections.abc import Mapping

from PySide6.QtCore import QPointF, QRectF, QSizeF, Qt
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QPainter, QPen

from app.arrays import BoolArray
from widgets.colours import Theme
from widgets.map_view.map_items import lines
from widgets.map_view.map_legend import paint_plate
from widgets.map_view.taxel_faults import STROKES, Fault

_PAD, _GLYPH = 8.0, 4.0
Keys = tuple[tuple[Fault, str], ...]
"""What each mark means, in words."""


def keys_of(faults: Mapping[Fault, BoolArray]) -> Keys:
    """A line for each kind that there is."""
    counts = ((fault, int(those.sum())) for fault, those in faults.items())
    return tuple(
        (fault, f"{count} {'taxel' if count == 1 else 'taxels'} {fault.value}") for fault, count in counts if count
    )


def paint_keys(painter: QPainter, keys: Keys, corner: QPointF, font: QFont, theme: Theme) -> None:
    """Draw them with their upper right corner at ``corner``; ``font`` is the caption's."""
    metrics = QFontMetricsF(font)
    line, indent = metrics.height() + 2, 2 * _GLYPH + 8
    width = max(metrics.horizontalAdvance(text) for _, text in keys) + indent
    size = QSizeF(width + 2 * _PAD, line * len(keys) + 2 * _PAD - 2)
    box = QRectF(QPointF(corner.x() - size.width(), corner.y()), size)
    paint_plate(painter, box, theme)
    painter.setFont(font)
    row = QRectF(box.left() + _PAD, box.top() + _PAD - 1, width, line)
    for fault, text in keys:
        painter.setPen(QPen(QColor(theme.text), 1.4, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap))
        middle = (row.left() + _GLYPH, row.center().y())
        painter.drawLines(lines(STROKES[fault] * _GLYPH + middle))
        painter.setPen(QColor(theme.quiet))
        painter.drawText(
            row.adjusted(indent, 0, 0, 0), Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter, text
        )
        row.translate(0, line)
