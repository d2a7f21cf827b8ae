"""Mean and maximum pressure of a group of taxels."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pyqtgraph as pg

from tactile_maps.core.arrays import FloatArray
from tactile_widgets.common.colours import Theme
from tactile_widgets.plots.traces.plot_canvas import dashed_pen
from tactile_widgets.plots.traces.trace_plots import PlotSeries, TracePlot, legend_entry, max_or_zero


@dataclass(frozen=True, eq=False)
class GroupSamples:
    """Pressures of a group in the last seconds.

    Attributes:
        unit: Unit of the pressures.
        ages: (k,) ages [s], rising to 0.
        mean: (k,) mean over the taxels, in ``unit``.
        highest: (k,) maximum over the taxels, in ``unit``.
        missing: Reason why samples are unavailable, for the user; empty if they are available.
    """

    unit: str
    ages: FloatArray
    mean: FloatArray
    highest: FloatArray
    missing: str = ""


class GroupPressure:
    """Curves of the mean and maximum pressure of a group. Mutable: ``draw``.

    Args:
        plot: Plot that shows the curves.
        theme: Colours.
        name: Title of the plot.
        source: Returns the samples; called at every redraw, because the skin may change.
    """

    def __init__(self, plot: TracePlot, theme: Theme, *, name: str, source: Callable[[], GroupSamples]) -> None:
        self._plot = plot
        self._theme = theme
        self._name = name
        self._source = source
        self._mean, self._highest = (plot.plot.plot(connect="finite") for _ in range(2))
        self.set_theme(theme)

    def set_theme(self, theme: Theme) -> None:
        """Apply a theme."""
        self._theme = theme
        self._highest.setPen(pg.mkPen(theme.text, width=1.5))
        self._mean.setPen(dashed_pen(theme.accent))
        self._update_heading(self._source())

    def draw(self) -> None:
        """Draw the current samples."""
        samples = self._source()
        self._mean.setData(samples.ages, samples.mean)
        self._highest.setData(samples.ages, samples.highest)
        self._plot.reach(max_or_zero(samples.highest[np.isfinite(samples.highest)]))
        self._update_heading(samples)

    def series(self) -> list[PlotSeries]:
        """Return both curves."""
        samples = self._source()
        curves = (("mean", samples.mean), ("max", samples.highest))
        return [PlotSeries(name, samples.unit, samples.ages, values) for name, values in curves]

    def _update_heading(self, samples: GroupSamples) -> None:
        theme = self._theme
        keys = legend_entry("–", theme.text, "max") + legend_entry("– –", theme.accent, "mean")
        self._plot.set_title(f"{self._name} ({samples.unit})")
        self._plot.update_style(theme, after_title=f": {samples.missing}" if samples.missing else keys)
