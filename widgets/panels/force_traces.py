"""The forces of the last seconds: all contacts together, each contact region in its own colour, and the goal."""

from __future__ import annotations

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import Qt
from PySide6.QtGui import QColor

from app.contacts.region import ContactRegion
from widgets.colours import Theme
from widgets.panels.live_history import LiveHistory
from widgets.panels.trace_plot import SECONDS, TracePlot, highest, legend_entry
from widgets.selection import region_ink

MOST_REGIONS = 16
"""Regions that get a trace at once; of more the strongest."""
_NAMED = 3
"""Regions that the legend names; the panel of contacts names them too."""


class ForceTraces:
    """Draws on one plot. Mutable: ``add`` samples, then ``draw``.

    Args:
        plot: Its own.
        theme: Colours of everything that is no region.
    """

    def __init__(self, plot: TracePlot, theme: Theme) -> None:
        self._plot, self._theme = plot, theme
        self._total, self._regions = LiveHistory(seconds=SECONDS), LiveHistory(seconds=SECONDS)
        self._line = plot.plot.plot()
        self._lines: dict[str, pg.PlotDataItem] = {}
        self._living: tuple[tuple[int, str], ...] = ()
        self._selected: int | None = None
        self._goal = plot.plot.plot(connect="finite")
        self._goal.hide()
        self._goal_force: float | None = None

    def set_theme(self, theme: Theme) -> None:
        """Take another theme."""
        self._theme = theme
        self._line.setPen(pg.mkPen(QColor(theme.text), width=1.5))
        self._goal.setPen(pg.mkPen(QColor(theme.intent), width=1.5, style=Qt.PenStyle.DashLine))
        self._dress()

    def set_goal(self, newtons: float | None) -> None:
        """The wanted force [N] from now on, unless a frame says otherwise; None while no law holds one."""
        self._goal_force = newtons
        self._dress()

    def select(self, region: int | None) -> None:
        """Highlight this region's trace; None for none."""
        self._selected = region
        for name, line in self._lines.items():
            self._ink(name, line)
        self._dress()

    def clear(self) -> None:
        """Forget everything."""
        self._total.clear()
        self._regions.clear()
        self._living = ()

    def add(self, time: float, regions: tuple[ContactRegion, ...], goal: float | None = None) -> tuple[int, ...]:
        """Keep the forces at ``time`` [s], and the goal that the task says; ids of regions whose last sample went."""
        before, goal = self._regions.names, self._goal_force if goal is None else goal
        total = {"force": sum(region.force for region in regions), "goal": np.nan if goal is None else goal}
        self._total.add(time, total)
        kept = regions[:MOST_REGIONS]
        self._regions.add(time, {str(region.id): region.force for region in kept})
        self._regions.forget_silent()
        self._living = tuple((region.id, region.link) for region in kept)
        return tuple(int(name) for name in before if name not in self._regions.names)

    def draw(self) -> None:
        """Show the samples kept."""
        ages, force = self._total.series("force")
        self._line.setData(ages, force)
        goals = self._total.series("goal")[1]
        self._goal.setData(ages, goals)
        self._goal.setVisible(bool(np.isfinite(goals).any()))
        for name in set(self._lines) - set(self._regions.names):
            self._plot.plot.removeItem(self._lines.pop(name))
        for name in self._regions.names:
            if name not in self._lines:
                self._lines[name] = self._plot.plot.plot(connect="finite")
                self._ink(name, self._lines[name])
            self._lines[name].setData(*self._regions.series(name))
        self._plot.reach(max(highest(force), highest(goals[np.isfinite(goals)])))
        self._dress()

    def _ink(self, name: str, line: pg.PlotDataItem) -> None:
        """The selected one is thick; the others step back while there is one."""
        chosen = int(name) == self._selected
        colour = QColor(region_ink(int(name)))
        colour.setAlphaF(1.0 if chosen or self._selected is None else 0.45)
        line.setPen(pg.mkPen(colour, width=3.0 if chosen else 1.5))
        line.setZValue(2 if chosen else 1)

    def _dress(self) -> None:
        legend = ""
        if self._goal_force is not None:
            legend += legend_entry("– –", self._theme.intent, f"goal {self._goal_force:.1f}")
        if self._living:
            legend += legend_entry("—", self._theme.text, "all")
        for region, link in self._living[:_NAMED]:
            legend += legend_entry("●", region_ink(region), link, strong=region == self._selected)
        if len(self._living) > _NAMED:
            legend += f" &nbsp;+{len(self._living) - _NAMED}"
        self._plot.dress(self._theme, after_title=legend)
