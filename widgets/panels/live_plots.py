"""Live plots of the last seconds: forces, pressures, milliseconds by stage; what is selected in its own colour."""

from __future__ import annotations

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QElapsedTimer, Signal
from PySide6.QtGui import QResizeEvent, QShowEvent
from PySide6.QtWidgets import QBoxLayout, QWidget

from app.session.frame import Frame
from widgets.colours import Theme
from widgets.panels.force_traces import ForceTraces
from widgets.panels.live_history import LiveHistory
from widgets.panels.pressure_traces import PressureTraces
from widgets.panels.stage_times import stage_times
from widgets.panels.trace_plot import SECONDS, TracePlot, highest, legend_entry
from widgets.selection import Selection

REDRAW_MS = 50
"""Plots are redrawn at most this often; samples in between are kept, not drawn."""
STAGE_COLOURS = ("#4c6a92", "#6f8fb5", "#93b1cf", "#b9cfe2", "#8d99a6", "#6b7683", "#505a66", "#adb8c4")
"""From the bottom of the stack upwards: quiet, ordered by lightness, and never mistaken for touch."""
ROW_FROM_ASPECT = 1.6


class LivePlots(QWidget):
    """Three small plots with one time axis: now at the right, ten seconds ago at the left."""

    region_forgotten = Signal(int)
    """The last sample of a contact region has gone: its id."""

    def __init__(self, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("live-plots")
        self.setAccessibleName("Live plots")
        self._theme = theme
        self._stages = LiveHistory(seconds=SECONDS)
        self._since_drawn, self._dirty = QElapsedTimer(), False
        force, pressure = TracePlot("Contact force (N)", 5.0, self), TracePlot("Peak pressure (kPa)", 5.0, self)
        self._force, self._pressure = ForceTraces(force, theme), PressureTraces(pressure, theme)
        self._ms = TracePlot("Time per tick (ms)", 1.0, self)
        self._stage_areas: dict[str, pg.PlotDataItem] = {}
        self._selection: Selection | None = None
        self._layout = QBoxLayout(QBoxLayout.Direction.LeftToRight, self)
        self._layout.setContentsMargins(12, 8, 12, 8)
        self._layout.setSpacing(16)
        for plot, share in ((force, 3), (pressure, 3), (self._ms, 4)):
            self._layout.addWidget(plot, share)
        self.setMinimumSize(200, 120)
        self.set_theme(theme)

    def set_theme(self, theme: Theme) -> None:
        """Take another theme."""
        self._theme = theme
        self._force.set_theme(theme)
        self._pressure.set_theme(theme)
        self._dress_stages()

    def set_force_goal(self, newtons: float | None) -> None:
        """Show the wanted contact force [N]; None while no law holds one."""
        self._force.set_goal(newtons)

    def follow(self, selection: Selection) -> None:
        """Trace what is selected there from now on, its past included."""
        self._selection = selection
        selection.changed.connect(self._on_selection_changed)
        selection.region_changed.connect(self._force.select)
        self.region_forgotten.connect(selection.forget_region)
        self._on_selection_changed()
        self._force.select(selection.region)

    def _on_selection_changed(self) -> None:
        if self._selection is not None:
            self._pressure.select(self._selection.taxels, self._selection.inks)

    def clear(self) -> None:
        """Forget everything, for another session."""
        for history in (self._force, self._pressure, self._stages):
            history.clear()
        for name in tuple(self._stage_areas):
            self._ms.plot.removeItem(self._stage_areas.pop(name))
        self._redraw()

    def show_frame(self, frame: Frame) -> None:
        """Keep the numbers of ``frame``, and draw them if it is time and someone can see it."""
        gone = self._force.add(frame.time, frame.regions)
        self._pressure.add(frame.time, frame.pressures)
        self._stages.add(frame.time, stage_times(frame.timings))
        self._dirty = True
        if self.isVisible() and (not self._since_drawn.isValid() or self._since_drawn.elapsed() >= REDRAW_MS):
            self._redraw()
        for region in gone:
            self.region_forgotten.emit(region)

    def _redraw(self) -> None:
        self._since_drawn.start()
        self._dirty = False
        self._force.draw()
        self._pressure.draw()
        self._draw_stages()

    def _draw_stages(self) -> None:
        """Stack the stages: each area reaches from zero to the sum so far, later ones lie behind earlier ones."""
        known, total = len(self._stage_areas), np.zeros(1)
        for index, name in enumerate(self._stages.names):
            if name not in self._stage_areas:
                self._stage_areas[name] = self._ms.plot.plot(pen=None, fillLevel=0, brush=_stage_colour(index))
                self._stage_areas[name].setZValue(-index)
            ages, ms = self._stages.series(name)
            total = total + np.nan_to_num(ms)
            self._stage_areas[name].setData(ages, total)
        self._ms.reach(highest(total))
        if len(self._stage_areas) != known:
            self._dress_stages()

    def _dress_stages(self) -> None:
        keys = [legend_entry("■", _stage_colour(index), name) for index, name in enumerate(self._stage_areas)]
        self._ms.dress(self._theme, after_title="".join(keys))

    def showEvent(self, event: QShowEvent) -> None:
        """Qt: catch up with what came while hidden."""
        super().showEvent(event)
        if self._dirty:
            self._redraw()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Qt: side by side where it is wide, one under the other where it is tall."""
        super().resizeEvent(event)
        wide = self.width() >= ROW_FROM_ASPECT * self.height()
        self._layout.setDirection(QBoxLayout.Direction.LeftToRight if wide else QBoxLayout.Direction.TopToBottom)


def _stage_colour(index: int) -> str:
    return STAGE_COLOURS[index % len(STAGE_COLOURS)]
