"""Colours and markers that distinguish curves, and the legend that names them."""

from __future__ import annotations

from collections.abc import Sequence

from pyqtgraph.graphicsItems.ScatterPlotItem import Symbols
from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QPainter, QPaintEvent, QPen, QResizeEvent
from PySide6.QtWidgets import QGridLayout, QLabel, QWidget

from tactile_widgets.common.colours import Theme

SYMBOLS = ("o", "s", "t1", "d", "t", "star", "+", "x")
_CURVE_COLOURS = {
    # After Okabe and Ito, with lightness adapted to the background; distinct from the accents and the touch colours.
    "dark": ("#5aa9e6", "#e0a63c", "#3fbf9a", "#d98cc0", "#d97b4f", "#c9c25a", "#a9b3bd", "#8f9de0"),
    "light": ("#0b6bb0", "#9a6700", "#00795a", "#a83f86", "#b64a12", "#6f6a00", "#5b6570", "#4a55a8"),
}
MARKER_SIZE = 11
ITERATION_MARKER_SIZE = 5
RING_SIZE = 22
"""Marker sizes [px]: of a setting, of an intermediate iteration, of the ring around the current setting."""
_CELL = 132
LINE_STYLES = {
    "best": Qt.PenStyle.DashLine,
    "dotted": Qt.PenStyle.DotLine,
    "upright": Qt.PenStyle.DashDotLine,
}
"""Styles of lines that are not measured; the last one is vertical."""


def curve_colour(theme: Theme, number: int) -> QColor:
    """Return the colour of a method by its number."""
    inks = _CURVE_COLOURS[theme.name]
    return QColor(inks[number % len(inks)])


def curve_symbol(number: int) -> str:
    """Return the marker of a method by its number, as pyqtgraph names it."""
    return SYMBOLS[number % len(SYMBOLS)]


class LegendSwatch(QWidget):
    """Sample of a curve (line and marker), of the ring, or of a line without marker (best results or theory)."""

    def __init__(self, kind: int | str, theme: Theme, parent: QWidget) -> None:
        super().__init__(parent)
        self._kind = kind
        self._theme = theme
        self.setFixedSize(QSize(22, 16))

    def paintEvent(self, event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        middle = QPointF(self.rect().center()) + QPointF(0.5, 0.5)
        ends = QPointF(1, middle.y()), QPointF(self.width() - 1, middle.y())
        if self._kind == "ring":
            painter.setPen(QPen(QColor(self._theme.accent), 2))
            painter.drawEllipse(QRectF(middle.x() - 6, middle.y() - 6, 12, 12))
        elif self._kind in LINE_STYLES:
            painter.setPen(QPen(QColor(self._theme.quiet), 1, LINE_STYLES[str(self._kind)]))
            if self._kind == "upright":
                ends = QPointF(middle.x(), 0), QPointF(middle.x(), self.height())
            painter.drawLine(*ends)
        else:
            colour = curve_colour(self._theme, int(self._kind))
            painter.setPen(QPen(colour, 1.5))
            painter.drawLine(*ends)
            painter.translate(middle)
            painter.scale(MARKER_SIZE - 2, MARKER_SIZE - 2)
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(colour)
            painter.drawPath(Symbols[curve_symbol(int(self._kind))])


class CurveLegend(QWidget):
    """Names of curves under a diagram, in as many columns as fit."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("curve-legend")
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(0, 0, 0, 0)
        self._grid.setHorizontalSpacing(3)
        self._grid.setVerticalSpacing(0)
        self._entries: list[tuple[LegendSwatch, QLabel]] = []
        self._content: tuple[object, ...] = ()
        self._columns = 0

    def show_entries(self, entries: Sequence[tuple[int | str, str]], theme: Theme) -> None:
        """Name curves by their numbers; other kinds are ``ring`` and the keys of ``LINE_STYLES``."""
        if (content := (tuple(entries), theme)) == self._content:
            return
        self._content = content
        for widget in (widget for entry in self._entries for widget in entry):
            self._grid.removeWidget(widget)
            widget.hide()
            widget.deleteLater()
        self._entries = []
        for kind, name in entries:
            label = QLabel(name, self)
            label.setProperty("role", "caption")
            self._entries.append((LegendSwatch(kind, theme, self), label))
        self._columns = 0
        self._arrange()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._arrange()

    def _arrange(self) -> None:
        columns = max(self.width() // _CELL, 1)
        if columns == self._columns:
            return
        self._columns = columns
        for number, (swatch, label) in enumerate(self._entries):
            row, column = divmod(number, columns)
            self._grid.addWidget(swatch, row, 2 * column)
            self._grid.addWidget(label, row, 2 * column + 1)
        for column in range(2 * max(columns, self._grid.columnCount() // 2)):
            self._grid.setColumnStretch(column, column % 2 if column < 2 * columns else 0)
