"""One small plot over the last seconds, as every live plot is: a heading that is also the legend, quiet axes."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import Qt
from PySide6.QtGui import QColor, QFont
from PySide6.QtWidgets import QLabel, QVBoxLayout, QWidget

from app.arrays import FloatArray
from widgets.colours import Theme

SECONDS = 10.0
"""What the time axis shows [s]."""
TIMES = ((-SECONDS, f"−{SECONDS:g}\u2009s"), (-SECONDS / 2, f"−{SECONDS / 2:g}\u2009s"), (0.0, "now"))
"""What is written on it: age [s] and words."""
FIRST, LAST = -1.04 * SECONDS, 0.09 * SECONDS
"""Its ends [s]: a little more than is shown, so that what is written at the ends has room."""


class TracePlot(QWidget):
    """From zero to a round top that rarely changes; now at the right, ten seconds ago at the left.

    Args:
        title: What is drawn, with its unit.
        floor: The top is never lower, so that noise does not fill the plot.
    """

    def __init__(self, title: str, floor: float, parent: QWidget) -> None:
        super().__init__(parent)
        self._title, self._floor, self._top = title, floor, 0.0
        self._marks: list[pg.InfiniteLine] = []
        self._mark_pen = pg.mkPen(None)
        self.setAccessibleName(title)
        self._caption = QFont(self.font())
        self._caption.setPixelSize(11)
        self._heading = QLabel(title, self)
        self._heading.setFont(self._caption)
        self._heading.setWordWrap(True)
        self.plot = pg.PlotWidget(self, background=None)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(4)
        layout.addWidget(self._heading)
        layout.addWidget(self.plot, 1)
        self._set_up_axes()
        self.reach(0.0)

    def _set_up_axes(self) -> None:
        self.plot.setAcceptDrops(False)  # a file dropped here is the window's
        self.plot.setMenuEnabled(False)
        self.plot.setMouseEnabled(x=False, y=False)
        self.plot.hideButtons()
        menu = self.plot.getPlotItem().ctrlMenu  # made without a parent, it would outlive the plot
        menu.setParent(self.plot, menu.windowFlags())
        self.plot.setXRange(FIRST, LAST, padding=0)
        left, bottom = self.plot.getAxis("left"), self.plot.getAxis("bottom")
        bottom.setTicks([list(TIMES)])
        bottom.setStyle(hideOverlappingLabels=False, tickLength=3)
        left.setStyle(tickLength=3)
        left.setWidth(34)
        for axis in (left, bottom):
            axis.setTickFont(self._caption)

    @property
    def heading(self) -> str:
        """Title and legend as rich text."""
        return self._heading.text()

    def dress(self, theme: Theme, *, after_title: str = "", title: str = "") -> None:
        """Take a theme; ``after_title`` is rich text that follows the title, or another ``title`` for now."""
        words = f'<span style="color:{QColor(theme.quiet).name()}">{title or self._title}{after_title}</span>'
        if words != self._heading.text():
            self._heading.setText(words)
        self._mark_pen = pg.mkPen(QColor(theme.quiet), width=1, style=Qt.PenStyle.DotLine)
        for line in self._marks:
            line.setPen(self._mark_pen)
        for side in ("left", "bottom"):
            axis = self.plot.getAxis(side)
            axis.setPen(pg.mkPen(QColor(theme.line)))
            axis.setTextPen(pg.mkPen(QColor(theme.quiet)))

    def mark(self, ages: Sequence[float]) -> None:
        """Draw a thin line at each of these ages [s], and none elsewhere."""
        while len(self._marks) < len(ages):
            self._marks.append(pg.InfiniteLine(angle=90, movable=False, pen=self._mark_pen))
            self._marks[-1].setZValue(-1)
            self.plot.addItem(self._marks[-1], ignoreBounds=True)
        for number, line in enumerate(self._marks):
            line.setVisible(number < len(ages))
            if number < len(ages):
                line.setValue(ages[number])

    def reach(self, highest: float) -> None:
        """Make room for values up to ``highest``."""
        top = round_up(max(highest, self._floor))
        if top != self._top:
            self._top = top
            self.plot.setYRange(-0.02 * top, 1.1 * top, padding=0)  # the top's own label needs room


def legend_entry(mark: str, ink: str, words: str, *, strong: bool = False) -> str:
    """Rich text of one entry of a legend: a mark in its colour, then words that stay together."""
    said = escape(words).replace(" ", "&nbsp;")
    said = f"<b>{said}</b>" if strong else said
    joined = mark.replace(" ", "&nbsp;").replace("–", "\u2060–\u2060")  # a line may end after a dash, but for this
    return f' &nbsp;<span style="color:{QColor(ink).name()}">{joined}</span>&nbsp;{said}'


def round_up(value: float) -> float:
    """The smallest of 1, 2, 5 times a power of ten that is at least ``value`` > 0."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(next(power * step for step in (1, 2, 5, 10) if power * step >= value * (1 - 1e-9)))


def highest(values: FloatArray) -> float:
    """The highest of them, 0 for none."""
    return float(np.nanmax(values)) if values.size else 0.0
