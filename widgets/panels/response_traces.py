"""The response of a law with a task: how far the contact is from where it is wanted, and how fast the joints go."""

from __future__ import annotations

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import Qt
from PySide6.QtGui import QColor

from app.control.reference import MAX_JOINT_SPEED
from app.session.frame import Frame
from widgets.colours import Theme
from widgets.panels.live_history import LiveHistory
from widgets.panels.trace_plot import SECONDS, TracePlot, highest, legend_entry

TOLERANCE = 0.005
"""Of the error [m]: what the experiments call on the path."""


class BoundedTrace:
    """One quantity, and the line it should stay below. Mutable: ``add`` samples, then ``draw``.

    Args:
        plot: Its own.
        theme: Colours.
        bound: What it should stay below.
        words: Of the bound, for the legend.
        hard: Whether the bound is a limit that is kept, or a wish.
    """

    def __init__(self, plot: TracePlot, theme: Theme, *, bound: float, words: str, hard: bool) -> None:
        self._plot, self._theme, self._bound, self._words, self._hard = plot, theme, bound, words, hard
        self._history = LiveHistory(seconds=SECONDS)
        self._line = plot.plot.plot(connect="finite")
        self._limit = pg.InfiniteLine(bound, angle=0, movable=False)
        plot.plot.addItem(self._limit)

    def set_theme(self, theme: Theme) -> None:
        """Take another theme."""
        self._theme = theme
        self._line.setPen(pg.mkPen(QColor(theme.text), width=1.5))
        self._limit.setPen(pg.mkPen(self._ink, width=1.2, style=Qt.PenStyle.DashLine))
        self._dress()

    def clear(self) -> None:
        """Forget everything."""
        self._history.clear()

    def add(self, time: float, value: float | None) -> None:
        """Keep the value at ``time`` [s]; None where there is none."""
        self._history.add(time, {"value": np.nan if value is None else value})

    def draw(self) -> None:
        """Show the samples kept."""
        ages, values = self._history.series("value")
        self._line.setData(ages, values)
        known = values[np.isfinite(values)]
        self._plot.reach(max(highest(known), self._bound))

    @property
    def _ink(self) -> QColor:
        return QColor(self._theme.warning if self._hard else self._theme.intent)

    def _dress(self) -> None:
        self._plot.dress(self._theme, after_title=legend_entry("– –", self._ink.name(), self._words))


def error_trace(plot: TracePlot, theme: Theme) -> BoundedTrace:
    """Of the error on the map [mm]."""
    return BoundedTrace(plot, theme, bound=1e3 * TOLERANCE, words=f"tolerance {1e3 * TOLERANCE:g}", hard=False)


def speed_trace(plot: TracePlot, theme: Theme) -> BoundedTrace:
    """Of the fastest joint [rad/s]."""
    return BoundedTrace(plot, theme, bound=MAX_JOINT_SPEED, words=f"limit {MAX_JOINT_SPEED:g}", hard=True)


def error_of(frame: Frame) -> float | None:
    """The error on the map [mm], where the task has one."""
    return None if frame.task is None or frame.task.error is None else 1e3 * frame.task.error


def speed_of(frame: Frame) -> float:
    """Of the fastest joint [rad/s], or slide [m/s]."""
    return float(np.abs(frame.velocity).max(initial=0.0))
