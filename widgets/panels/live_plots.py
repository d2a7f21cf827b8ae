"""Live plots of the last seconds: contact force against its goal, the highest pressure, milliseconds by stage."""

from __future__ import annotations

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QElapsedTimer, Qt
from PySide6.QtGui import QColor, QFont, QResizeEvent, QShowEvent
from PySide6.QtWidgets import QBoxLayout, QLabel, QVBoxLayout, QWidget

from app.arrays import FloatArray
from app.session.frame import Frame
from widgets.colours import Theme
from widgets.panels.live_history import LiveHistory

REDRAW_MS = 50
"""Plots are redrawn at most this often; samples in between are kept, not drawn."""
STAGE_COLOURS = ("#4c6a92", "#6f8fb5", "#93b1cf", "#b9cfe2", "#8d99a6", "#6b7683", "#505a66", "#adb8c4")
"""From the bottom of the stack upwards: quiet, ordered by lightness, and never mistaken for touch."""
ROW_FROM_ASPECT = 1.6
SECONDS = 10.0


class TracePlot(QWidget):
    """One small plot over the last seconds, from zero to a round top that rarely changes.

    Args:
        title: What is drawn, with its unit.
        floor: The top is never lower, so that noise does not fill the plot.
    """

    def __init__(self, title: str, floor: float, parent: QWidget) -> None:
        super().__init__(parent)
        self._title, self._floor, self._top = title, floor, 0.0
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
        self.plot.setXRange(-1.04 * SECONDS, 0.05 * SECONDS, padding=0)
        times = [(-SECONDS, f"−{SECONDS:g}\u2009s"), (-SECONDS / 2, f"−{SECONDS / 2:g}\u2009s"), (0, "now")]
        left, bottom = self.plot.getAxis("left"), self.plot.getAxis("bottom")
        bottom.setTicks([times])
        bottom.setStyle(hideOverlappingLabels=False, tickLength=3)
        left.setStyle(tickLength=3)
        left.setWidth(34)
        for axis in (left, bottom):
            axis.setTickFont(self._caption)

    def dress(self, theme: Theme, *, after_title: str = "") -> None:
        """Take a theme; ``after_title`` is rich text that follows the title."""
        self._heading.setText(f'<span style="color:{QColor(theme.quiet).name()}">{self._title}{after_title}</span>')
        for side in ("left", "bottom"):
            axis = self.plot.getAxis(side)
            axis.setPen(pg.mkPen(QColor(theme.line)))
            axis.setTextPen(pg.mkPen(QColor(theme.quiet)))

    def reach(self, highest: float) -> None:
        """Make room for values up to ``highest``."""
        top = round_up(max(highest, self._floor))
        if top != self._top:
            self._top = top
            self.plot.setYRange(-0.02 * top, 1.1 * top, padding=0)  # the top's own label needs room


class LivePlots(QWidget):
    """Three small plots with one time axis: now at the right, ten seconds ago at the left."""

    def __init__(self, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("live-plots")
        self.setAccessibleName("Live plots")
        self._theme = theme
        self._history, self._stages = LiveHistory(seconds=SECONDS), LiveHistory(seconds=SECONDS)
        self._since_drawn, self._dirty = QElapsedTimer(), False
        self._force = TracePlot("Contact force (N)", 5.0, self)
        self._peak = TracePlot("Peak pressure (kPa)", 5.0, self)
        self._ms = TracePlot("Time per tick (ms)", 1.0, self)
        self._force_line, self._peak_line = self._force.plot.plot(), self._peak.plot.plot()
        self._stage_areas: dict[str, pg.PlotDataItem] = {}
        self._goal, self._goal_force = pg.InfiniteLine(angle=0, movable=False), 0.0
        self._force.plot.addItem(self._goal)
        self._goal.hide()
        self._layout = QBoxLayout(QBoxLayout.Direction.LeftToRight, self)
        self._layout.setContentsMargins(12, 8, 12, 8)
        self._layout.setSpacing(16)
        for plot, share in ((self._force, 3), (self._peak, 3), (self._ms, 4)):
            self._layout.addWidget(plot, share)
        self.setMinimumSize(200, 120)
        self.set_theme(theme)

    def set_theme(self, theme: Theme) -> None:
        """Take another theme."""
        self._theme = theme
        self._peak.dress(theme)
        self._force_line.setPen(pg.mkPen(QColor(theme.text), width=1.5))
        self._peak_line.setPen(pg.mkPen(QColor(theme.text), width=1.5))
        self._goal.setPen(pg.mkPen(QColor(theme.intent), width=1.5, style=Qt.PenStyle.DashLine))
        self._dress_goal()
        self._dress_stages()

    def set_force_goal(self, newtons: float | None) -> None:
        """Show the wanted contact force [N]; None while no law holds one."""
        self._goal.setVisible(newtons is not None)
        self._goal_force = newtons or 0.0
        self._goal.setValue(self._goal_force)
        self._dress_goal()
        self._draw_force()

    def clear(self) -> None:
        """Forget everything, for another session."""
        self._history.clear()
        self._stages.clear()
        for name in tuple(self._stage_areas):
            self._ms.plot.removeItem(self._stage_areas.pop(name))
        self._redraw()

    def show_frame(self, frame: Frame) -> None:
        """Keep the numbers of ``frame``, and draw them if it is time and someone can see it."""
        force = sum(region.force for region in frame.regions)
        peak = float(frame.pressures.max()) / 1e3 if frame.pressures.size else 0.0
        self._history.add(frame.time, {"force": force, "peak": peak})
        self._stages.add(frame.time, dict(frame.timings.ms))
        self._dirty = True
        if self.isVisible() and (not self._since_drawn.isValid() or self._since_drawn.elapsed() >= REDRAW_MS):
            self._redraw()

    def _redraw(self) -> None:
        self._since_drawn.start()
        self._dirty = False
        self._draw_force()
        ages, peak = self._history.series("peak")
        self._peak_line.setData(ages, peak)
        self._peak.reach(_highest(peak))
        self._draw_stages()

    def _draw_force(self) -> None:
        ages, force = self._history.series("force")
        self._force_line.setData(ages, force)
        self._force.reach(max(_highest(force), self._goal_force))

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
        self._ms.reach(_highest(total))
        if len(self._stage_areas) != known:
            self._dress_stages()

    def _dress_goal(self) -> None:
        goal = f' &nbsp;<span style="color:{QColor(self._theme.intent).name()}">– –</span> goal {self._goal_force:.1f}'
        self._force.dress(self._theme, after_title=goal if self._goal.isVisible() else "")

    def _dress_stages(self) -> None:
        keys = [
            f'<span style="color:{_stage_colour(index)}">■</span>&nbsp;{name}'
            for index, name in enumerate(self._stage_areas)
        ]
        self._ms.dress(self._theme, after_title=" &nbsp; " + " &nbsp;".join(keys) if keys else "")

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


def round_up(value: float) -> float:
    """The smallest of 1, 2, 5 times a power of ten that is at least ``value`` > 0."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(next(power * step for step in (1, 2, 5, 10) if power * step >= value * (1 - 1e-9)))


def _highest(values: FloatArray) -> float:
    return float(np.nanmax(values)) if len(values) else 0.0


def _stage_colour(index: int) -> str:
    return STAGE_COLOURS[index % len(STAGE_COLOURS)]
