"""The pressures of the last seconds: the highest of all, and those of the selected taxels in their own colours."""

from __future__ import annotations

import numpy as np
import pyqtgraph as pg
from PySide6.QtGui import QColor

from app.arrays import FloatArray, IntArray
from widgets.colours import Theme, mixed
from widgets.panels.live_history import LiveHistory, TaxelHistory
from widgets.panels.trace_plot import SECONDS, TracePlot, highest, legend_entry
from widgets.selection import INKS

SELECTED = "Pressure (kPa)"


class PressureTraces:
    """Draws on one plot: a few taxels one by one, more as their mean, and a band up to their maximum. Mutable.

    Args:
        plot: Its own.
        theme: Colours of everything that is no taxel.
    """

    def __init__(self, plot: TracePlot, theme: Theme) -> None:
        self._plot, self._theme = plot, theme
        self._peak, self._taxels = LiveHistory(seconds=SECONDS), TaxelHistory(seconds=SECONDS)
        self._together, self._latest = LiveHistory(seconds=SECONDS), 0.0
        self._line = plot.plot.plot()
        self._lines = [plot.plot.plot() for _ in INKS]
        self._top = plot.plot.plot(pen=pg.mkPen(INKS[0], width=1.0))
        shade = QColor(INKS[0])
        shade.setAlphaF(0.28)
        self._band = pg.FillBetweenItem(self._top, self._lines[0], brush=shade)
        plot.plot.addItem(self._band)
        self._selected: IntArray = np.zeros(0, int)
        self._inks: tuple[str, ...] = ()

    def set_theme(self, theme: Theme) -> None:
        """Take another theme."""
        self._theme = theme
        self._dress()

    def select(self, taxels: IntArray, inks: tuple[str, ...]) -> None:
        """Trace these taxels (k,), each in its colour, or, if they are many, all together in one."""
        self._selected, self._inks = taxels, inks
        for line, ink in zip(self._lines, inks, strict=False):
            line.setPen(pg.mkPen(ink, width=1.75))
        self._together.clear()
        if self._many:
            ages, traces = self._taxels.traces(taxels)
            for age, pressures in zip(ages.tolist(), traces, strict=True):
                self._add_together(self._latest + age, pressures)
        self._dress()
        self.draw()

    def clear(self) -> None:
        """Forget everything."""
        for history in (self._peak, self._taxels, self._together):
            history.clear()

    def add(self, time: float, pressures: FloatArray) -> None:
        """Keep pressures (taxels,) [Pa] at ``time`` [s]."""
        self._peak.add(time, {"peak": 1e-3 * float(pressures.max(initial=0.0))})
        self._taxels.add(time, pressures)
        self._latest = time
        if self._many:
            self._add_together(time, 1e-3 * pressures[self._selected])

    def _add_together(self, time: float, kilopascals: FloatArray) -> None:
        self._together.add(time, {"mean": float(kilopascals.mean()), "max": float(kilopascals.max())})

    def draw(self) -> None:
        """Show the samples kept."""
        ages, peak = self._peak.series("peak")
        self._line.setData(ages, peak)
        self._top.setData(*self._together.series("max"))
        self._plot.reach(highest(peak))
        if self._many:
            ages, shown = self._together.series("mean")
            shown = shown[:, None]
        else:
            ages, shown = self._taxels.traces(self._selected)
        for number, line in enumerate(self._lines):
            there = number < shown.shape[1]
            line.setData(ages if there else [], shown[:, number] if there else [])

    @property
    def _many(self) -> bool:
        return len(self._selected) > len(INKS)

    def _dress(self) -> None:
        theme, count = self._theme, len(self._selected)
        quiet = mixed(theme.window, theme.quiet, 0.7)
        self._line.setPen(pg.mkPen(QColor(quiet if count else theme.text), width=1.0 if count else 1.5))
        self._band.setVisible(self._many)
        if not count:
            self._plot.dress(theme)
            return
        if self._many:
            legend = legend_entry("—", INKS[0], f"mean of {count}") + legend_entry("■", INKS[0], "max")
        else:
            pairs = zip(self._selected.tolist(), self._inks, strict=True)
            legend = "".join(legend_entry("○", ink, str(taxel)) for taxel, ink in pairs)
        self._plot.dress(theme, title=SELECTED, after_title=legend + legend_entry("—", quiet, "max of all"))
