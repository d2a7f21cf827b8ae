"""Which limit bounded the controller when: a row a limit, over the same time axis as the plots beside it."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QLabel, QVBoxLayout, QWidget

from widgets.colours import Theme, mixed
from widgets.panels.limit_memory import LimitMemory
from widgets.panels.trace_plot import FIRST, LAST, SECONDS, TIMES

_ROW, _BAR, _THINNEST = 21.0, 4.0, 2.0
_AXIS = 16.0
"""Room of the time axis below the rows [px]."""

Row = tuple[str, tuple[tuple[float, float], ...]]


class LimitStrip(QWidget):
    """Heading, rows and axis. Mutable: ``draw`` what a memory holds."""

    def __init__(self, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("limit-strip")
        caption = QFont(self.font())
        caption.setPixelSize(11)
        self._heading, self._rows = QLabel(self), _Rows(theme, caption, self)
        self._heading.setFont(caption)
        self._heading.setWordWrap(True)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(4)
        layout.addWidget(self._heading)
        layout.addWidget(self._rows, 1)
        self.set_theme(theme)

    @property
    def heading(self) -> str:
        """What the heading says."""
        return self._heading.text()

    def set_theme(self, theme: Theme) -> None:
        """Take another theme."""
        self._heading.setStyleSheet(f"color: {theme.quiet}")
        self._rows.theme = theme
        self._rows.update()

    def draw(self, memory: LimitMemory, marks: Sequence[float]) -> None:
        """Show the limits remembered, and settings changed at these ages [s]."""
        rows, active = memory.rows, [limit for limit in memory.told if limit.active]
        words = "Limits" if rows else f"Limits: none in the last {SECONDS:g}\u2009s"
        self._heading.setText(f"{words}, {len(active)} now" if active else words)
        said = ", ".join(name for name, _ in rows)
        self.setAccessibleName(f"Limits in the last {SECONDS:g} seconds: {said or 'none'}")
        self.setToolTip("\n".join(name[:1].upper() + name[1:] for name, _ in rows))
        self._rows.show_rows(rows, marks)


class _Rows(QWidget):
    """A name over a bar each; what has no room is counted."""

    def __init__(self, theme: Theme, caption: QFont, parent: QWidget) -> None:
        super().__init__(parent)
        self.theme, self._caption = theme, caption
        self._shown: tuple[Row, ...] = ()
        self._marks: tuple[float, ...] = ()

    def show_rows(self, rows: tuple[Row, ...], marks: Sequence[float]) -> None:
        """Draw these."""
        self._shown, self._marks = rows, tuple(marks)
        self.update()

    def paintEvent(self, _event: QPaintEvent) -> None:
        """Qt."""
        painter = QPainter(self)
        painter.setFont(self._caption)
        floor = self.height() - _AXIS
        painter.setPen(QPen(QColor(self.theme.line), 1))
        painter.drawLine(QPointF(0, floor), QPointF(self.width(), floor))
        self._draw_times(painter, floor)
        painter.setPen(QPen(QColor(self.theme.quiet), 1, Qt.PenStyle.DotLine))
        for age in self._marks:
            painter.drawLine(QPointF(self._x(age), 0), QPointF(self._x(age), floor))
        room = max(int(floor // _ROW), 1)
        shown = self._shown if len(self._shown) <= room else self._shown[: room - 1]
        for number, row in enumerate(shown):
            self._draw_row(painter, number * _ROW, row)
        if len(shown) < len(self._shown):
            painter.setPen(QColor(self.theme.quiet))
            painter.drawText(QPointF(2, len(shown) * _ROW + 12), f"and {len(self._shown) - len(shown)} more")

    def _draw_row(self, painter: QPainter, top: float, row: Row) -> None:
        name, spans = row
        now = spans[-1][1] >= 0
        painter.setPen(QColor(self.theme.text if now else self.theme.quiet))
        words = QFontMetricsF(self._caption).elidedText(name, Qt.TextElideMode.ElideRight, self.width() - 4)
        painter.drawText(QPointF(2, top + 12), words)
        painter.fillRect(QRectF(0, top + 15, self.width(), _BAR), QColor(mixed(self.theme.panel, self.theme.line, 0.5)))
        for start, end in spans:
            left = self._x(start)
            width = max(self._x(end) - left, _THINNEST)
            painter.fillRect(QRectF(left, top + 15, width, _BAR), QColor(self.theme.warning))

    def _draw_times(self, painter: QPainter, floor: float) -> None:
        painter.setPen(QColor(self.theme.quiet))
        for age, words in TIMES:
            wide = QFontMetricsF(self._caption).horizontalAdvance(words)
            left = min(max(self._x(age) - wide / 2, 0.0), self.width() - wide)
            painter.drawText(QPointF(left, floor + 13), words)

    def _x(self, age: float) -> float:
        """Where that age [s] is: now near the right edge, as in the plots."""
        return self.width() * (age - FIRST) / (LAST - FIRST)
