"""Study results against a factor: each point is the median over seeds with its interval; a click selects it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import pyqtgraph as pg
from PySide6.QtCore import QPointF, Qt, Signal
from PySide6.QtGui import QColor, QFontMetrics, QPainterPath
from PySide6.QtWidgets import QWidget

from tactile_maps.studies.base.rows import Cell, number
from tactile_maps.studies.running.study_table import TablePoint, TheoryColumn
from tactile_widgets.common.colours import Theme
from tactile_widgets.common.make import STYLE_SPACING, column_layout
from tactile_widgets.plots.curve_legend import (
    LINE_STYLES,
    MARKER_SIZE,
    RING_SIZE,
    CurveLegend,
    curve_colour,
    curve_symbol,
)
from tactile_widgets.plots.traces.plot_canvas import PlotCanvas

_APART = 0.08
"""Offset between points of two curves at one named value, as a share of the distance to the next value."""
_LABEL_GAP = 10
"""Gap between two labels [px]."""
_THEORY_WIDTH = 0.6
"""Width of a theory line at a named value, as a share of the distance to the next value."""
_PADDING = 0.06
"""Space around the drawn values, as a share of their range."""
_CAP = 5
"""Half the width of the caps of an interval [px]."""


_FLAT = QPainterPath(QPointF(-0.5, 0.0))
_FLAT.lineTo(0.5, 0.0)


def cell_text(cell: Cell) -> str:
    """Return the text of a table cell; an empty cell is a dash."""
    if cell is None:
        return "–"
    return f"{cell:.4g}" if isinstance(cell, float) else str(cell)


class StudyPlot(QWidget):
    """Points with vertical intervals, one colour and marker per curve, and the legend below.

    Args:
        theme: Colours.
    """

    chosen = Signal(TablePoint)
    """The point that was clicked."""

    def __init__(self, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._theme = theme
        self._points: tuple[TablePoint, ...] = ()
        self._marked: TablePoint | None = None
        self._theory: tuple[TheoryColumn, ...] = ()
        self._names = ("", "")
        self._series = list[Cell]()
        self._values: Mapping[Cell, int] | None = None
        self.canvas = PlotCanvas(self)
        self.canvas.setObjectName("study-canvas")
        for side in ("bottom", "left"):
            self.canvas.getAxis(side).enableAutoSIPrefix(False)  # columns have units of their own
        self.canvas.getPlotItem().getViewBox().sigResized.connect(self._label_values)
        self._legend = CurveLegend(self)
        column_layout(self.canvas, self._legend, parent=self, spacing=STYLE_SPACING, stretch=self.canvas)
        self._draw()

    def set_theme(self, theme: Theme) -> None:
        """Apply a theme."""
        self._theme = theme
        self._draw()

    def show_points(self, points: Sequence[TablePoint], x: str, y: str, theory: Sequence[TheoryColumn] = ()) -> None:
        """Draw these points, with theory as dashed lines below them; ``x`` and ``y`` name the axes."""
        self._points = tuple(points)
        self._names = (x, y)
        self._marked = None
        self._theory = tuple(theory)
        self._legend.setToolTip("\n".join(f"{one.name}: {one.source}." for one in theory))
        self._series = list(dict.fromkeys(point.series for point in points))
        cells = list(dict.fromkeys(point.x for point in points))
        numbered = all(number(cell) is not None and not isinstance(cell, bool) for cell in cells)
        self._values = None if numbered else {cell: place for place, cell in enumerate(cells)}
        self._draw()

    def mark(self, point: TablePoint | None) -> None:
        """Draw a ring around a point; None removes it."""
        self._marked = point
        self._draw()

    def place(self, point: TablePoint) -> tuple[float, float] | None:
        """Return the position of a point in axis units; None if most seeds have no value."""
        if not math.isfinite(point.interval.middle):
            return None
        if self._values is None:
            return float(number(point.x) or 0.0), point.interval.middle
        aside = _APART * (self._series.index(point.series) - 0.5 * (len(self._series) - 1))
        return self._values[point.x] + max(min(aside, 0.4), -0.4), point.interval.middle

    def _draw(self) -> None:
        plot = self.canvas.getPlotItem()
        theme = self._theme
        plot.clear()
        for side, name in zip(("bottom", "left"), self._names, strict=True):
            self.canvas.getAxis(side).setLabel(name, color=theme.quiet, **{"font-size": "11px"})
        self.canvas.colour_axes(theme)
        plot.showGrid(x=True, y=True, alpha=0.4)
        for order, series in enumerate(self._series):
            self._draw_series([point for point in self._points if point.series == series], order)
        if self._marked is not None and (at := self.place(self._marked)) is not None:
            pen = pg.mkPen(theme.accent, width=2.5)
            plot.addItem(pg.ScatterPlotItem(pos=[at], size=RING_SIZE, brush=None, pen=pen, antialias=True))
        entries: list[tuple[int | str, str]] = [
            (order, cell_text(series)) for order, series in enumerate(self._series) if series is not None
        ]
        entries += zip(LINE_STYLES, (one.name for one in self._theory), strict=False)
        self._legend.show_entries(entries, theme)
        self._show_all()
        self._label_values()
        self.canvas.setAccessibleName(f"{self._names[1]} against {self._names[0]}")

    def _show_all(self) -> None:
        """Show all values and intervals; an axis of positive values begins at zero."""
        drawn = [(point, at) for point in self._points if (at := self.place(point)) is not None]
        if not drawn:
            return
        x = [at[0] for _, at in drawn]
        y = [at[1] for _, at in drawn]
        for point, _ in drawn:
            predicted = [value for one in self._theory if (value := point.predicted(one.column)) is not None]
            y += filter(math.isfinite, (point.interval.low, point.interval.high, *predicted))
        left, right = (min(x), max(x)) if self._values is None else (-0.5, len(self._values) - 0.5)
        low = min(*y, 0.0)
        high = max(*y, low)
        plot = self.canvas.getPlotItem()
        plot.setXRange(left, right, padding=_PADDING if right > left else None)
        plot.setYRange(low, high if high > low else low + 1.0, padding=_PADDING)

    def _label_values(self) -> None:
        """Label named values as densely as the axis has room, from the left."""
        if self._values is None:
            self.canvas.getAxis("bottom").setTicks(None)
            return
        box = self.canvas.getPlotItem().getViewBox()
        first, last = box.viewRange()[0]
        pixels = box.width() / (last - first)
        measure = QFontMetrics(self.canvas.small).horizontalAdvance
        ticks = list[tuple[int, str]]()
        free = 0.0
        for cell, place in self._values.items():
            text = cell_text(cell)
            half = measure(text) / 2
            middle = (place - first) * pixels
            if middle - half >= free and middle + half <= box.width():
                ticks.append((place, text))
                free = middle + half + _LABEL_GAP
        self.canvas.getAxis("bottom").setTicks([ticks])

    def _draw_series(self, points: Sequence[TablePoint], order: int) -> None:
        plot = self.canvas.getPlotItem()
        colour = curve_colour(self._theme, order)
        drawn = [(point, at) for point in points if (at := self.place(point)) is not None]
        if not drawn:
            return
        if self._values is None:
            x, y = zip(*(at for _, at in drawn), strict=True)
            plot.addItem(pg.PlotDataItem(x, y, pen=pg.mkPen(colour, width=1.2), antialias=True))
        for theory, style in zip(self._theory, LINE_STYLES.values(), strict=False):
            self._draw_theory(drawn, theory.column, style)
        for point, (x_at, _) in drawn:
            self._draw_interval(point, x_at, colour)
        marks: list[dict[str, Any]] = [{"pos": at, "data": point} for point, at in drawn]
        scatter = pg.ScatterPlotItem(
            marks,
            size=MARKER_SIZE,
            symbol=curve_symbol(order),
            brush=colour,
            pen=pg.mkPen(self._theme.panel),
            antialias=True,
        )
        scatter.setZValue(10)
        scatter.sigClicked.connect(self._on_clicked)
        plot.addItem(scatter)

    def _draw_theory(
        self, drawn: Sequence[tuple[TablePoint, tuple[float, float]]], column: str, style: Qt.PenStyle
    ) -> None:
        """Draw a line if the factor is a number, else a short line at each point."""
        pen = pg.mkPen(self._theme.quiet, width=1.2, style=style)
        predicted = [(x, value) for point, (x, _) in drawn if (value := point.predicted(column)) is not None]
        half = _THEORY_WIDTH / 2
        lines = [predicted] if self._values is None else [[(x - half, y), (x + half, y)] for x, y in predicted]
        for line in filter(None, lines):
            self.canvas.addItem(pg.PlotDataItem(*zip(*line, strict=True), pen=pen, antialias=True))

    def _draw_interval(self, point: TablePoint, x: float, colour: QColor) -> None:
        """Draw a vertical line with caps; an interval whose upper end has no value gets no upper cap."""
        low = point.interval.low
        high = point.interval.high
        top = high if math.isfinite(high) else point.interval.middle
        plot = self.canvas.getPlotItem()
        plot.addItem(pg.PlotDataItem([x, x], [low, top], pen=pg.mkPen(colour, width=1.5), antialias=True))
        for y in (low, high) if math.isfinite(high) else (low,):
            cap = pg.ScatterPlotItem(pos=[(x, y)], symbol=_FLAT, size=2 * _CAP, pen=pg.mkPen(colour, width=1.5))
            plot.addItem(cap)

    def _on_clicked(self, _plot: object, marks: Sequence[Any], _event: object = None) -> None:
        if len(marks):
            self.chosen.emit(marks[0].data())

    def on_canvas(self, point: TablePoint) -> QPointF:
        """Return the position of a point on the canvas [px].

        Raises:
            ValueError: The point is not drawn.
        """
        at = self.place(point)
        if at is None:
            raise ValueError("the point is not drawn")
        box = self.canvas.getPlotItem().getViewBox()
        return QPointF(self.canvas.mapFromScene(box.mapViewToScene(QPointF(*at))))
