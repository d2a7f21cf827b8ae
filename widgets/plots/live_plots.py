"""Live plots of the last seconds: forces, pressures, milliseconds by stage, the controller's response and its limits.

Which of them are shown follows from what the controller does, so that they stay few: pressure gives way to the response
of a controller with a task, unless taxels are selected. Where there is no room, the milliseconds give way, which have a
panel. ``LimitTimeline`` shows which limit bounded the controller when, a row a limit, over the same time axis.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QElapsedTimer, QPointF, QRectF, Qt, QTimer, Signal
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QPainter, QPaintEvent, QPen, QResizeEvent, QShowEvent
from PySide6.QtWidgets import QBoxLayout, QLabel, QVBoxLayout, QWidget

from app.control.command import ControlSettings
from app.control.controller_registry import TASKS_AT_A_PLACE, effective_settings, has_task
from app.control.limit_texts import limit_name
from app.control.limits import LimitKind
from app.core.reading_units import ReadingUnits
from app.session.frame import Frame
from widgets.common.colours import Theme, mixed
from widgets.document.taxel_selection import TaxelSelection
from widgets.plots.history import LimitHistory, SampleHistory, SettingChanges, stage_times
from widgets.plots.trace_plots import (
    AXIS_END,
    AXIS_START,
    PLOT_SECONDS,
    TIME_TICKS,
    ForceTraces,
    PressureTraces,
    TracePlot,
    error_of,
    error_trace,
    legend_entry,
    max_or_zero,
    peak_title,
    speed_of,
    speed_trace,
)

_ROW, _BAR, _THINNEST = 21.0, 4.0, 2.0
_AXIS = 16.0
"""Room of the time axis below the rows [px]."""

LimitRow = tuple[LimitKind, tuple[tuple[float, float], ...]]


class LimitTimeline(QWidget):
    """Heading, rows and axis. Mutable: ``draw`` what a memory holds."""

    def __init__(self, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("limit-strip")
        caption = QFont(self.font())
        caption.setPixelSize(11)
        self._heading, self._rows = QLabel(self), _LimitRows(theme, caption, self)
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

    def draw(self, memory: LimitHistory, marks: Sequence[float]) -> None:
        """Show the limits remembered, and settings changed at these ages [s]."""
        rows, active = memory.rows, [limit for limit in memory.told if limit.active]
        words = "Limits" if rows else f"Limits: none in the last {PLOT_SECONDS:g}\u2009s"
        self._heading.setText(f"{words}, {len(active)} now" if active else words)
        said = ", ".join(limit_name(kind) for kind, _ in rows)
        self.setAccessibleName(f"Limits in the last {PLOT_SECONDS:g} seconds: {said or 'none'}")
        self.setToolTip("\n".join(limit_name(kind).capitalize() for kind, _ in rows))
        self._rows.show_rows(rows, marks)


class _LimitRows(QWidget):
    """A name over a bar each; what has no room is counted."""

    def __init__(self, theme: Theme, caption: QFont, parent: QWidget) -> None:
        super().__init__(parent)
        self.theme, self._caption = theme, caption
        self._shown: tuple[LimitRow, ...] = ()
        self._marks: tuple[float, ...] = ()

    def show_rows(self, rows: tuple[LimitRow, ...], marks: Sequence[float]) -> None:
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

    def _draw_row(self, painter: QPainter, top: float, row: LimitRow) -> None:
        kind, spans = row
        now = spans[-1][1] >= 0
        painter.setPen(QColor(self.theme.text if now else self.theme.quiet))
        words = QFontMetricsF(self._caption).elidedText(limit_name(kind), Qt.TextElideMode.ElideRight, self.width() - 4)
        painter.drawText(QPointF(2, top + 12), words)
        painter.fillRect(QRectF(0, top + 15, self.width(), _BAR), QColor(mixed(self.theme.panel, self.theme.line, 0.5)))
        for start, end in spans:
            left = self._x(start)
            width = max(self._x(end) - left, _THINNEST)
            painter.fillRect(QRectF(left, top + 15, width, _BAR), QColor(self.theme.warning))

    def _draw_times(self, painter: QPainter, floor: float) -> None:
        painter.setPen(QColor(self.theme.quiet))
        for age, words in TIME_TICKS:
            wide = QFontMetricsF(self._caption).horizontalAdvance(words)
            left = min(max(self._x(age) - wide / 2, 0.0), self.width() - wide)
            painter.drawText(QPointF(left, floor + 13), words)

    def _x(self, age: float) -> float:
        """Where that age [s] is: now near the right edge, as in the plots."""
        return self.width() * (age - AXIS_START) / (AXIS_END - AXIS_START)


REDRAW_MS = 50
"""Plots are redrawn at most this often; samples in between are kept, not drawn."""
STAGE_COLOURS = ("#4c6a92", "#6f8fb5", "#93b1cf", "#b9cfe2", "#8d99a6", "#6b7683", "#505a66", "#adb8c4")
"""From the bottom of the stack upwards: quiet, ordered by lightness, and never mistaken for touch."""
SIDE_BY_SIDE_ASPECT = 1.6
LOWEST, USUAL_HEIGHT = 84, 140
"""Of the plots side by side [px]."""
MIN_PLOT_WIDTH = 190
"""What a plot beside others needs [px]."""
_STRETCH_FACTORS = {"force": 3, "pressure": 3, "error": 3, "speed": 3, "limits": 3, "ms": 4}


class LivePlots(QWidget):
    """Small plots with one time axis: now at the right, ten seconds ago at the left; changed settings are marked."""

    region_forgotten = Signal(int)
    """The last sample of a contact region has gone: its id."""

    def __init__(self, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("live-plots")
        self.setAccessibleName("Live plots")
        self._theme, self._settings = theme, ControlSettings()
        self._stages = SampleHistory(seconds=PLOT_SECONDS)
        self._limits, self._changes = LimitHistory(seconds=PLOT_SECONDS), SettingChanges(seconds=PLOT_SECONDS)
        self._since_drawn, self._dirty, self._late = QElapsedTimer(), False, QTimer(self)
        self._late.setSingleShot(True)
        self._late.setInterval(REDRAW_MS)
        self._late.timeout.connect(self._on_late)
        self._units = ReadingUnits.CALIBRATED
        self._make_plots(theme)
        self._stage_areas: dict[str, pg.PlotDataItem] = {}
        self._selection: TaxelSelection | None = None
        self._layout = QBoxLayout(QBoxLayout.Direction.LeftToRight, self)
        self._layout.setContentsMargins(12, 8, 12, 8)
        self._layout.setSpacing(16)
        for name, cell in self._cells.items():
            self._layout.addWidget(cell, _STRETCH_FACTORS[name])
        self.setMinimumSize(200, LOWEST)
        self.set_theme(theme)
        self._arrange()

    def _make_plots(self, theme: Theme) -> None:
        plots = {
            "force": TracePlot(ReadingUnits.CALIBRATED.strength_title, 5.0, self),
            "pressure": TracePlot(peak_title(ReadingUnits.CALIBRATED), 5.0, self),
            "ms": TracePlot("Time per tick (ms)", 1.0, self),
            "error": TracePlot("Error on the map (mm)", 10.0, self),
            "speed": TracePlot("Max joint speed (rad/s)", 2.0, self),
        }
        self._plots, self._ms, self._strip = plots, plots["ms"], LimitTimeline(theme, self)
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
        self._update_stage_legend()

    def show_settings(self, settings: ControlSettings) -> None:
        """The controller's settings in force: what they ask for is drawn, and when they changed is marked."""
        if settings != self._settings:
            self._changes.change()
        self._settings = settings
        has_force_goal = settings.controller == "hold_force" or (
            has_task(settings.controller) and "force_goal" in effective_settings(settings)
        )
        self._force.set_goal(settings.force_goal if has_force_goal else None)
        self._arrange()
        self._redraw_if_seen()

    def _arrange(self) -> None:
        """Show those that matter now, and no more than have room."""
        settings, selected = self._settings, self._selection is not None and bool(len(self._selection.taxels))
        wanted = ["force"]
        if has_task(settings.controller):
            at_a_place = settings.task in TASKS_AT_A_PLACE
            wanted += ["error", "speed", "limits"] if at_a_place else ["speed", "limits"]
            wanted += ["pressure"] if selected or not at_a_place else []
        else:
            wanted += ["limits", "pressure"] if settings.controller == "hold_force" else ["pressure"]
        if not self._beside or (len(wanted) + 1) * MIN_PLOT_WIDTH <= self.width():
            wanted.append("ms")
        for name, cell in self._cells.items():
            cell.setVisible(name in wanted)

    @property
    def _beside(self) -> bool:
        """Whether the plots stand side by side."""
        return self.width() >= SIDE_BY_SIDE_ASPECT * self.height()

    def follow(self, selection: TaxelSelection) -> None:
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
        gone = self._keep(frame)
        if not self._since_drawn.isValid() or self._since_drawn.elapsed() >= REDRAW_MS:
            self._redraw_if_seen()
        elif not self._late.isActive():
            self._late.start()
        for region in gone:
            self.region_forgotten.emit(region)

    def keep(self, frames: Sequence[Frame]) -> None:
        """Keep the numbers of frames that no view shows; drawn with the next one that is. Cost: 0.1 ms each."""
        for frame in frames:
            for region in self._keep(frame):
                self.region_forgotten.emit(region)

    def show_past(self, frames: Sequence[Frame]) -> None:
        """Show these frames and nothing of before."""
        self.clear()
        self.keep(frames)
        self._redraw_if_seen()

    def _keep(self, frame: Frame) -> tuple[int, ...]:
        """Ids of the regions whose last sample went."""
        time = frame.time
        if frame.units is not self._units:
            self._units = frame.units
            self._force.set_units(frame.units)
            self._pressure.set_units(frame.units)
        gone = self._force.add(time, frame.regions, frame.task.force_goal if frame.task else None)
        self._pressure.add(time, frame.pressures)
        self._error.add(time, error_of(frame))
        self._speed.add(time, speed_of(frame))
        self._limits.take(time, frame.why_limited)
        self._changes.at(time)
        self._stages.add(time, stage_times(frame.timings))
        self._dirty = True
        return gone

    def _on_late(self) -> None:
        """No frame came that would have shown the last one: time stands still."""
        if self._dirty:
            self._redraw_if_seen()

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
        self._ms.reach(max_or_zero(total))
        if len(self._stage_areas) != known:
            self._update_stage_legend()

    def _update_stage_legend(self) -> None:
        keys = [legend_entry("■", _stage_colour(index), name) for index, name in enumerate(self._stage_areas)]
        self._ms.update_style(self._theme, after_title="".join(keys))

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
