"""Traces of all compared controllers: one plot per quantity with a common time axis.

Curves differ in colour, dash and letter.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QPointF, QSize, Qt
from PySide6.QtGui import QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QLabel, QWidget

from tactile_maps.core.arrays import FloatArray
from tactile_maps.studies.controller_comparison import ControllerTrace
from tactile_widgets.common.colours import Theme
from tactile_widgets.common.make import column_layout, small_font
from tactile_widgets.plots.curve_legend import curve_colour
from tactile_widgets.plots.traces.plot_canvas import PlotCanvas, dashed_pen

LETTERS = "ABCD"
"""Names of contenders; more could not be distinguished."""
_DASHES = ((), (7.0, 5.0), (1.5, 3.5), (9.0, 3.0, 1.5, 3.0))
"""Dash patterns in widths of the pen; empty for a solid line."""
_WIDE = 34


def contender_pen(theme: Theme, letter: str, *, width: float = 1.5) -> QPen:
    """Return the pen of a contender."""
    number = LETTERS.index(letter)
    pen = QPen(curve_colour(theme, number), width)
    if _DASHES[number]:
        pen.setDashPattern(_DASHES[number])
        pen.setCapStyle(Qt.PenCapStyle.FlatCap)
    pen.setCosmetic(True)
    return pen


class LineSample(QWidget):
    """Sample of a contender's curve."""

    def __init__(self, letter: str, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._letter = letter
        self._theme = theme
        self.setFixedSize(QSize(_WIDE, 16))

    def set_theme(self, theme: Theme) -> None:
        """Use another theme."""
        self._theme = theme
        self.update()

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setPen(contender_pen(self._theme, self._letter, width=2.0))
        middle = self.height() / 2
        painter.drawLine(QPointF(1, middle), QPointF(self.width() - 1, middle))


_AXIS = 44
_ROW = 16
_BELOW = 48
"""Height of the limits of a contender, and of the time axis below them [px]."""
_BAR = 0.3
"""Height of the bars of limits, as a share of the row."""


class Quantity(NamedTuple):
    """A plot: name of the trace, title, displayed units per SI unit, and share of the height."""

    name: str
    title: str
    scale: float
    share: int


QUANTITIES = (
    Quantity("force", "Contact force (N)", 1.0, 3),
    Quantity("map_error", "Error on the map (mm)", 1e3, 3),
    Quantity("joint_speed", "Max joint speed", 1.0, 2),
    Quantity("energy", "Net energy to contacts (J)", 1.0, 2),
)
LIMITED = "Limited"


class ComparisonPlots(QWidget):
    """Plots from the top: force with its goals, error, joint speed with its limit, energy, and times of limits.

    The wheel zooms time in all plots; a double click shows the whole time.
    """

    def __init__(self, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("overlaid-traces")
        self._theme = theme
        self._traces: tuple[ControllerTrace, ...] = ()
        self._caption = small_font(self.font())
        self.plots: dict[str, PlotCanvas] = {}
        self._titles: list[QLabel] = []
        self._column = column_layout(parent=self, spacing=2)
        for quantity in QUANTITIES:
            self._add(quantity.name, quantity.title, quantity.share)
        self._add("limits", LIMITED, 1)
        self._limits = self.plots["limits"]
        self._limits.setYRange(-len(LETTERS), 0, padding=0)
        self._limits.getAxis("bottom").setStyle(showValues=True)
        self._limits.setLabel("bottom", "Time", units="s", siPrefix=False)
        self.set_theme(theme)

    def set_theme(self, theme: Theme) -> None:
        """Use another theme."""
        self._theme = theme
        for title in self._titles:
            title.setStyleSheet(f"color: {theme.quiet}")
        for plot in self.plots.values():
            plot.colour_axes(theme)
        self.show_traces(self._traces)

    def show_traces(self, traces: Sequence[ControllerTrace]) -> None:
        """Draw these traces only. Cost: 5 ms for two of ten seconds."""
        self._traces = tuple(traces)
        for plot in self.plots.values():
            plot.clear()
        for quantity in QUANTITIES:
            self._draw(quantity)
        self._draw_limits()
        self.show_all()

    def show_all(self) -> None:
        """Show the whole time in all plots."""
        last = max((float(trace.time[-1]) for trace in self._traces if len(trace)), default=1.0)
        self._limits.setXRange(0.0, last, padding=0.01)

    def _add(self, name: str, title: str, share: int) -> None:
        label = QLabel(title, self)
        plot = PlotCanvas(self, viewBox=_TimeBox(self))
        label.setFont(self._caption)
        plot.setAccessibleName(title)
        plot.setMouseEnabled(x=True, y=False)
        plot.getPlotItem().setDownsampling(auto=True, mode="peak")
        plot.getPlotItem().setClipToView(True)
        for side in ("left", "bottom"):
            plot.getAxis(side).setStyle(tickLength=3)
        plot.getAxis("left").setWidth(_AXIS)
        plot.getAxis("bottom").setStyle(showValues=False)
        if self.plots:
            plot.setXLink(next(iter(self.plots.values())))
        self.plots[name] = plot
        self._titles.append(label)
        self._column.addWidget(label)
        self._column.addWidget(plot, share)

    def _draw(self, quantity: Quantity) -> None:
        plot = self.plots[quantity.name]
        reach = 0.0
        for trace in self._traces:
            values = quantity.scale * getattr(trace, quantity.name)
            pen = contender_pen(self._theme, trace.name)
            item = plot.plot(trace.time, values, pen=pen, connect="finite", name=trace.name, antialias=True)
            item.curve.setSegmentedLineMode("off")  # otherwise each segment starts the dash pattern again
            reach = max(reach, float(np.nanmax(values, initial=0.0)))
        if quantity.name == "force":
            reach = max(reach, self._draw_goals(plot))
        if quantity.name == "joint_speed" and self._traces:
            reach = self._draw_speed_limit(plot, reach)
        low = min((float(np.nanmin(getattr(t, quantity.name), initial=0.0)) for t in self._traces), default=0.0)
        plot.setYRange(quantity.scale * low, reach or 1.0, padding=0.1)

    def _draw_speed_limit(self, plot: PlotCanvas, reach: float) -> float:
        """Show the unit, draw the limit if the speeds come near it, and return the highest value of the plot."""
        trace = self._traces[0]
        self._titles[list(self.plots).index("joint_speed")].setText(f"Max joint speed ({trace.speed_unit})")
        if reach <= 0.5 * trace.speed_limit:
            return reach
        pen = dashed_pen(self._theme.warning, 1.2)
        plot.addItem(pg.InfiniteLine(trace.speed_limit, angle=0, pen=pen))
        return max(reach, trace.speed_limit)

    def _draw_goals(self, plot: PlotCanvas) -> float:
        """Draw the distinct goals as violet lines, and return the highest goal."""
        drawn: list[FloatArray] = []
        for trace in self._traces:
            goal = trace.force_goal
            if np.isfinite(goal).any() and not any(np.array_equal(goal, one, equal_nan=True) for one in drawn):
                drawn.append(goal)
                pen = dashed_pen(self._theme.intent, 1.2)
                plot.plot(trace.time, goal, pen=pen, connect="finite")
        return max((float(np.nanmax(goal)) for goal in drawn), default=0.0)

    def _draw_limits(self) -> None:
        """Draw a row per contender with a bar where it was limited.

        The bar of a tick begins at the previous tick, so that its share of the time is that of the metrics. It is at
        least one pixel wide; a downsampled curve would lose it.
        """
        rows = []
        for number, trace in enumerate(self._traces):
            row = -number - 0.5
            ends = np.flatnonzero(np.diff(trace.limited, prepend=False, append=False))
            times = np.concatenate([[0.0], trace.time])[ends]
            ink = contender_pen(self._theme, trace.name).color()
            bars = {"y0": row - _BAR / 2, "height": _BAR, "pen": pg.mkPen(ink), "brush": ink}
            self._limits.addItem(pg.BarGraphItem(x0=times[::2], x1=times[1::2], **bars))
            rows.append((row, trace.name))
        self._limits.getAxis("left").setTicks([rows])
        self._limits.setYRange(-max(len(rows), 1), 0, padding=0.05)
        self._limits.setFixedHeight(_BELOW + _ROW * max(len(rows), 1))


class _TimeBox(pg.ViewBox):
    """Shows the whole time on a double click."""

    def __init__(self, owner: ComparisonPlots) -> None:
        super().__init__()
        self._owner = owner

    def mouseClickEvent(self, event: object) -> None:
        """Handle a click of pyqtgraph."""
        if event.double():  # type: ignore[attr-defined]
            self._owner.show_all()
