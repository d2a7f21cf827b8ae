"""Legends over a view: boxes with lines of text, and marks explained one per line."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

from PySide6.QtCore import QPointF, QRectF, QSizeF, Qt
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QPainter

from tactile_widgets.common.colours import Theme
from tactile_widgets.views.overlays.painting import paint_box

PAD = 8.0
"""Distance of the texts from the edge of the box [px]."""
_GLYPH_GAP = 8.0
Glyph = Callable[[QPainter, QPointF, Theme], None]
"""Draws a mark around a point [px]."""


class Legend(ABC):
    """Box of text lines."""

    spacing: float = 2.0
    least_width: ClassVar[float] = 0.0

    @property
    @abstractmethod
    def texts(self) -> tuple[str, ...]:
        """Lines of text; at least one."""

    @property
    def indent(self) -> float:
        """Width left of the texts [px]."""
        return 0.0

    def extra_height(self, line: float) -> float:
        """Height below the first text, whose line has this height [px]."""
        return 0.0

    @abstractmethod
    def paint_row(self, painter: QPainter, row: QRectF, number: int, theme: Theme) -> None:
        """Paint the text of this number, and what belongs to it."""

    def fitted(self, width: float, font: QFont) -> Legend:
        """Return the legend with its lines wrapped, if it can be, where it is wider than ``width`` [px]."""
        return self

    def size(self, font: QFont) -> QSizeF:
        """Size with texts in ``font`` [px]."""
        metrics = QFontMetricsF(font)
        line = metrics.height() + self.spacing
        width = max(self.least_width, *map(metrics.horizontalAdvance, self.texts)) + self.indent
        height = line * len(self.texts) + self.extra_height(line)
        return QSizeF(width + 2 * PAD, height + 2 * PAD - self.spacing)

    def paint(self, painter: QPainter, box: QRectF, font: QFont, theme: Theme) -> None:
        """Paint the legend in a box of its ``size``."""
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        line = QFontMetricsF(font).height() + self.spacing
        paint_box(painter, box, theme.panel)
        painter.setFont(font)
        row = QRectF(box.left() + PAD, box.top() + PAD - 1, box.width() - 2 * PAD, line)
        for number in range(len(self.texts)):
            self.paint_row(painter, row, number, theme)
            row.translate(0, line if number else line + self.extra_height(line))


@dataclass(frozen=True)
class MarkLegend(Legend):
    """Explains one mark per line.

    Attributes:
        entries: Glyph and text of each.
        glyph_width: Width of the glyphs [px].
        spacing: Distance between lines [px].
    """

    entries: tuple[tuple[Glyph, str], ...]
    glyph_width: float
    spacing: float = 2.0

    @property
    def indent(self) -> float:
        return self.glyph_width + _GLYPH_GAP

    @property
    def texts(self) -> tuple[str, ...]:
        return tuple(text for _, text in self.entries)

    def paint_row(self, painter: QPainter, row: QRectF, number: int, theme: Theme) -> None:
        glyph, text = self.entries[number]
        glyph(painter, QPointF(row.left() + self.glyph_width / 2, row.center().y()), theme)
        painter.setPen(QColor(theme.quiet))
        side = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter
        painter.drawText(row.adjusted(self.indent, 0, 0, 0), side, text)
