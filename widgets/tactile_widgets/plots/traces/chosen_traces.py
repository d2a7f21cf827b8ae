"""Curves of plots that the user adds, each with one source, and the milliseconds by stage as areas."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pyqtgraph as pg

from tactile_maps.core.arrays import FloatArray
from tactile_widgets.common.colours import Theme
from tactile_widgets.plots.traces.history import SampleHistory
from tactile_widgets.plots.traces.plot_canvas import dashed_pen
from tactile_widgets.plots.traces.trace_plots import PlotSeries, TracePlot, legend_entry, max_or_zero


class TraceSource(NamedTuple):
    """Samples of an added plot.

    Attributes:
        unit: Unit of the values.
        samples: Ages (k,) [s] and values (k,).
        missing: Reason why samples are unavailable, for the user; empty if they are available.
        bounds: Marked values: the limits of a joint.
    """

    unit: str
    samples: Callable[[], tuple[FloatArray, FloatArray]]
    missing: str = ""
    bounds: tuple[float, ...] = ()


class SourcedTrace:
    """Single curve with one source. Mutable: ``draw``.

    Args:
        plot: Plot that shows the curve.
        theme: Colours.
        name: Name of the quantity.
        source: Returns the samples; called at every redraw, because the robot may change.
        signed: Whether values can be negative.
    """

    def __init__(
        self, plot: TracePlot, theme: Theme, *, name: str, source: Callable[[], TraceSource], signed: bool = False
    ) -> None:
        self._plot = plot
        self._theme = theme
        self._name = name
        self._source = source
        self._signed = signed
        self._line = plot.add_curve(connect="finite")
        self._bounds = [pg.InfiniteLine(angle=0, movable=False) for _ in range(2)]
        for bound in self._bounds:
            plot.plot.addItem(bound, ignoreBounds=True)
        self.set_theme(theme)

    def set_theme(self, theme: Theme) -> None:
        """Apply a theme."""
        self._theme = theme
        self._line.setPen(pg.mkPen(theme.text, width=1.5))
        for bound in self._bounds:
            bound.setPen(dashed_pen(theme.warning, 1.2))
        self._update_heading(self._source())

    def draw(self) -> None:
        """Draw the current samples."""
        source = self._source()
        ages, values = source.samples()
        self._line.setData(ages, values)
        known = values[np.isfinite(values)]
        if self._signed and known.size:
            self._plot.reach_between(float(known.min()), float(known.max()))
        elif not self._signed:
            self._plot.reach(max_or_zero(known))
        for number, line in enumerate(self._bounds):
            there = number < len(source.bounds) and bool(np.isfinite(source.bounds[number]))
            line.setVisible(there)
            if there:
                line.setValue(source.bounds[number])
        self._update_heading(source)

    def series(self) -> list[PlotSeries]:
        """Return the curve."""
        source = self._source()
        return [PlotSeries(self._name, source.unit, *source.samples())]

    def _update_heading(self, source: TraceSource) -> None:
        legend = f": {source.missing}" if source.missing else ""
        if source.bounds and not legend and any(np.isfinite(source.bounds)):
            legend = legend_entry("– –", self._theme.warning, "limits")
        self._plot.set_title(f"{self._name} ({source.unit})")
        self._plot.update_style(self._theme, after_title=legend)


STAGE_COLOURS = ("#4c6a92", "#6f8fb5", "#93b1cf", "#b9cfe2", "#8d99a6", "#6b7683", "#505a66", "#adb8c4")
"""Colours from the bottom of the stack upwards: muted, ordered by lightness, and distinct from colours of touch."""


class StageAreas:
    """Stacked areas of the milliseconds by stage. Mutable: ``draw`` and ``clear``.

    Args:
        plot: Plot that shows the areas.
        stages: Measured times [ms].
        theme: Colours.
    """

    def __init__(self, plot: TracePlot, stages: SampleHistory, theme: Theme) -> None:
        self._plot = plot
        self._stages = stages
        self._theme = theme
        self._areas: dict[str, pg.PlotCurveItem] = {}

    def set_theme(self, theme: Theme) -> None:
        """Apply a theme."""
        self._theme = theme
        keys = [legend_entry("■", _stage_colour(index), name) for index, name in enumerate(self._areas)]
        self._plot.update_style(theme, after_title="".join(keys))

    def clear(self) -> None:
        """Remove all stages."""
        for name in tuple(self._areas):
            self._plot.plot.removeItem(self._areas.pop(name))

    def draw(self) -> None:
        """Draw each area from zero to the cumulative sum, later ones behind earlier ones."""
        known = len(self._areas)
        total = np.zeros(1)
        for index, name in enumerate(self._stages.names):
            if name not in self._areas:
                self._areas[name] = self._plot.add_curve(pen=None, fillLevel=0, brush=_stage_colour(index))
                self._areas[name].setZValue(-index)
            ages, ms = self._stages.series(name)
            total = total + np.nan_to_num(ms)
            self._areas[name].setData(ages, total)
        self._plot.reach(max_or_zero(total))
        if len(self._areas) != known:
            self.set_theme(self._theme)

    def series(self) -> list[PlotSeries]:
        """Return one series per stage."""
        return [PlotSeries(name, "ms", *self._stages.series(name)) for name in self._stages.names]


def _stage_colour(index: int) -> str:
    return STAGE_COLOURS[index % len(STAGE_COLOURS)]
