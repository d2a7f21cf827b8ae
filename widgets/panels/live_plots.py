"""Live plots of the last seconds: forces, pressures, milliseconds by stage, and how the law in force responds.

Which of them are shown follows from what the controller does, so that they stay few: pressure gives way to the response
of a law with a task, unless taxels are selected. Where there is no room, the milliseconds give way, which have a panel.
"""

from __future__ import annotations

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QElapsedTimer, Signal
from PySide6.QtGui import QResizeEvent, QShowEvent
from PySide6.QtWidgets import QBoxLayout, QWidget

from app.control.command import ControlSettings
from app.control.laws import AT_A_PLACE, RULES, heeded
from app.session.frame import Frame
from widgets.colours import Theme
from widgets.panels.change_marks import ChangeMarks
from widgets.panels.force_traces import ForceTraces
from widgets.panels.limit_memory import LimitMemory
from widgets.panels.limit_strip import LimitStrip
from widgets.panels.live_history import LiveHistory
from widgets.panels.pressure_traces import PressureTraces
from widgets.panels.response_traces import error_of, error_trace, speed_of, speed_trace
from widgets.panels.stage_times import stage_times
from widgets.panels.trace_plot import SECONDS, TracePlot, highest, legend_entry
from widgets.selection import Selection

REDRAW_MS = 50
"""Plots are redrawn at most this often; samples in between are kept, not drawn."""
STAGE_COLOURS = ("#4c6a92", "#6f8fb5", "#93b1cf", "#b9cfe2", "#8d99a6", "#6b7683", "#505a66", "#adb8c4")
"""From the bottom of the stack upwards: quiet, ordered by lightness, and never mistaken for touch."""
ROW_FROM_ASPECT = 1.6
NARROWEST = 190
"""What a plot beside others needs [px]."""
_SHARES = {"force": 3, "pressure": 3, "error": 3, "speed": 3, "limits": 3, "ms": 4}


class LivePlots(QWidget):
    """Small plots with one time axis: now at the right, ten seconds ago at the left; changed settings are marked."""

    region_forgotten = Signal(int)
    """The last sample of a contact region has gone: its id."""

    def __init__(self, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("live-plots")
        self.setAccessibleName("Live plots")
        self._theme, self._settings = theme, ControlSettings()
        self._stages = LiveHistory(seconds=SECONDS)
        self._limits, self._changes = LimitMemory(seconds=SECONDS), ChangeMarks(seconds=SECONDS)
        self._since_drawn, self._dirty = QElapsedTimer(), False
        self._make_plots(theme)
        self._stage_areas: dict[str, pg.PlotDataItem] = {}
        self._selection: Selection | None = None
        self._layout = QBoxLayout(QBoxLayout.Direction.LeftToRight, self)
        self._layout.setContentsMargins(12, 8, 12, 8)
        self._layout.setSpacing(16)
        for name, cell in self._cells.items():
            self._layout.addWidget(cell, _SHARES[name])
        self.setMinimumSize(200, 120)
        self.set_theme(theme)
        self._arrange()

    def _make_plots(self, theme: Theme) -> None:
        plots = {
            "force": TracePlot("Contact force (N)", 5.0, self),
            "pressure": TracePlot("Peak pressure (kPa)", 5.0, self),
            "ms": TracePlot("Time per tick (ms)", 1.0, self),
            "error": TracePlot("Error on the map (mm)", 10.0, self),
            "speed": TracePlot("Fastest joint (rad/s)", 2.0, self),
        }
        self._plots, self._ms, self._strip = plots, plots["ms"], LimitStrip(theme, self)
        self._cells: dict[str, QWidget] = {
            "force": plots["force"], "error": plots["error"], "speed": plots["speed"], "limits": self._strip,
            "pressure": plots["pressure"], "ms": plots["ms"],
        }  # fmt: skip
        self._force, self._pressure = ForceTraces(plots["force"], theme), PressureTraces(plots["pressure"], theme)
        self._error, self._speed = error_trace(plots["error"], theme), speed_trace(plots["speed"], theme)

    @property
    def shown(self) -> tuple[str, ...]:
        """The plots that are shown now, from left to right: ``force``, ``error``, ``speed``, ``limits``, …"""
        return tuple(name for name, cell in self._cells.items() if not cell.isHidden())

    def set_theme(self, theme: Theme) -> None:
        """Take another theme."""
        self._theme = theme
        for part in (self._force, self._pressure, self._error, self._speed, self._strip):
            part.set_theme(theme)
        self._dress_stages()

    def show_settings(self, settings: ControlSettings) -> None:
        """The controller's settings in force: what they ask for is drawn, and when they changed is marked."""
        if settings != self._settings:
            self._changes.change()
        self._settings = settings
        law_has_goal = settings.law == "hold_force" or (settings.law in RULES and "force_goal" in heeded(settings))
        self._force.set_goal(settings.force_goal if law_has_goal else None)
        self._arrange()
        self._redraw_if_seen()

    def _arrange(self) -> None:
        """Show those that matter now, and no more than have room."""
        settings, selected = self._settings, self._selection is not None and bool(len(self._selection.taxels))
        wanted = ["force"]
        if settings.law in RULES:
            at_a_place = settings.task in AT_A_PLACE
            wanted += ["error", "speed", "limits"] if at_a_place else ["speed", "limits"]
            wanted += ["pressure"] if selected or not at_a_place else []
        else:
            wanted += ["limits", "pressure"] if settings.law == "hold_force" else ["pressure"]
        if not self._beside or (len(wanted) + 1) * NARROWEST <= self.width():
            wanted.append("ms")
        for name, cell in self._cells.items():
            cell.setVisible(name in wanted)

    @property
    def _beside(self) -> bool:
        """Whether the plots stand side by side."""
        return self.width() >= ROW_FROM_ASPECT * self.height()

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
            self._arrange()

    def clear(self) -> None:
        """Forget everything, for another session."""
        for part in (self._force, self._pressure, self._error, self._speed, self._limits, self._changes, self._stages):
            part.clear()
        for name in tuple(self._stage_areas):
            self._ms.plot.removeItem(self._stage_areas.pop(name))
        self._redraw()

    def show_frame(self, frame: Frame) -> None:
        """Keep the numbers of ``frame``, and draw them if it is time and someone can see it."""
        time = frame.time
        gone = self._force.add(time, frame.regions, frame.task.force_goal if frame.task else None)
        self._pressure.add(time, frame.pressures)
        self._error.add(time, error_of(frame))
        self._speed.add(time, speed_of(frame))
        self._limits.take(time, frame.why_limited)
        self._changes.at(time)
        self._stages.add(time, stage_times(frame.timings))
        self._dirty = True
        if not self._since_drawn.isValid() or self._since_drawn.elapsed() >= REDRAW_MS:
            self._redraw_if_seen()
        for region in gone:
            self.region_forgotten.emit(region)

    def _redraw_if_seen(self) -> None:
        if self.isVisible():
            self._redraw()

    def _redraw(self) -> None:
        """Draw what is shown; the others keep their samples until they are."""
        self._since_drawn.start()
        self._dirty = False
        shown, ages = self.shown, self._changes.ages
        for name, part in (("force", self._force), ("error", self._error), ("speed", self._speed)):
            if name in shown:
                part.draw()
        if "pressure" in shown:
            self._pressure.draw()
        if "limits" in shown:
            self._strip.draw(self._limits, ages)
        if "ms" in shown:
            self._draw_stages()
        for plot in self._plots.values():
            plot.mark(ages)

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
        self._layout.setDirection(
            QBoxLayout.Direction.LeftToRight if self._beside else QBoxLayout.Direction.TopToBottom
        )
        self._arrange()


def _stage_colour(index: int) -> str:
    return STAGE_COLOURS[index % len(STAGE_COLOURS)]
