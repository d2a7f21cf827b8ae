"""The legend of an overlay: what its colours mean, and how bad it is in numbers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from PySide6.QtCore import QPointF, QRectF, QSizeF, Qt
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QImage, QPainter, QPen

from app.maps.overlay import Flaws
from widgets.colours import Theme, words32
from widgets.map_view.ground import SCALE, GroundPicture

_PAD, _STRIP = 8.0, 10.0
_LEAST_WIDTH = 150.0


@dataclass(frozen=True)
class Legend:
    """What it says.

    Attributes:
        title: What is shown.
        lines: Facts below it.
        strip: Whether the stretch scale is drawn.
        one_sided: Whether only its upper half can occur.
        faulty: Whether the last line tells of flaws.
    """

    title: str
    lines: tuple[str, ...]
    strip: bool = False
    one_sided: bool = False
    faulty: bool = False


def legend_of(ground: GroundPicture | None, flaws: Flaws) -> Legend | None:
    """The legend of a ground; None where there is nothing to say: bare pressure, and no flaws."""
    flips, overlaps = len(flaws.flips), len(flaws.overlaps)
    faulty = bool(flips or overlaps)
    counts = f"{flips} {'triangle' if flips == 1 else 'triangles'} flipped, {overlaps} overlapping"
    if ground is None:
        return Legend("Not one-to-one", (counts,), faulty=True) if faulty else None
    strip = ground.stretch is not None
    lines = (ground.note, counts) if strip or faulty else (ground.note,)
    one_sided = ground.stretch is not None and ground.stretch.measure != "area"
    return Legend(ground.kind.title, lines, strip, one_sided, faulty)


def paint_plate(painter: QPainter, box: QRectF, theme: Theme) -> None:
    """What a legend stands on: nearly opaque, so that the map behind does not mix with its words."""
    panel = QColor(theme.panel)
    panel.setAlpha(225)
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(panel)
    painter.drawRoundedRect(box, 4, 4)
    painter.setBrush(Qt.BrushStyle.NoBrush)


def paint_legend(painter: QPainter, legend: Legend, corner: QPointF, font: QFont, theme: Theme) -> QRectF:
    """Draw it with its upper right corner at ``corner``; ``font`` is the caption's. Returns where it is."""
    metrics = QFontMetricsF(font)
    line = metrics.height() + 2
    width = max(_LEAST_WIDTH, *(metrics.horizontalAdvance(text) for text in (legend.title, *legend.lines)))
    tall = line * (1 + len(legend.lines)) + (_STRIP + line + 4 if legend.strip else 0)
    box = QRectF(QPointF(corner.x() - width - 2 * _PAD, corner.y()), QSizeF(width + 2 * _PAD, tall + 2 * _PAD - 2))
    paint_plate(painter, box, theme)
    painter.setFont(font)
    row = QRectF(box.left() + _PAD, box.top() + _PAD - 1, width, line)
    painter.setPen(QColor(theme.text))
    painter.drawText(row, Qt.AlignmentFlag.AlignLeft, legend.title)
    if legend.strip:
        row.translate(0, line + 2)
        _paint_strip(painter, legend, row, line, theme)
        row.translate(0, _STRIP + line + 2)
    else:
        row.translate(0, line)
    for number, text in enumerate(legend.lines, start=1):
        loud = legend.faulty and number == len(legend.lines)
        painter.setPen(QColor(theme.fault if loud else theme.quiet))
        painter.drawText(row, Qt.AlignmentFlag.AlignLeft, text)
        row.translate(0, line)
    return box


def _paint_strip(painter: QPainter, legend: Legend, row: QRectF, line: float, theme: Theme) -> None:
    table = SCALE.table[127:] if legend.one_sided else SCALE.table
    words = np.ascontiguousarray(words32(table)[None])
    strip = QRectF(row.left(), row.top(), row.width(), _STRIP)
    painter.drawImage(strip, QImage(words.data, len(table), 1, 4 * len(table), QImage.Format.Format_RGB32))
    painter.setPen(QPen(QColor(theme.line), 1))
    painter.drawRect(strip)
    painter.setPen(QColor(theme.quiet))
    below = QRectF(row.left(), strip.bottom() + 1, row.width(), line)
    most = f"×{SCALE.most:g} or more"
    ends = ("kept", "", most) if legend.one_sided else (f"×{1 / SCALE.most:g}", "kept", most)
    sides = (Qt.AlignmentFlag.AlignLeft, Qt.AlignmentFlag.AlignHCenter, Qt.AlignmentFlag.AlignRight)
    for text, side in zip(ends, sides, strict=True):
        painter.drawText(below, side, text)
