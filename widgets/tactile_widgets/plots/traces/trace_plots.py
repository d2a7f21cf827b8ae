"""Plots of the last seconds: a heading that is also the legend, muted axes, now at the right.

``TracePlot`` is the empty plot. It shows the total force, the force of each region and the goal; the peak pressure, and
the selected taxels one by one or as mean and maximum; or the error on the map or the fastest joint, with their bounds.
"""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from math import ceil
from typing import Any, NamedTuple, Protocol

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import Qt
from PySide6.QtGui import QColor, QFontMetricsF
from PySide6.QtWidgets import QLabel, QWidget

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.control.motion.joint_impedance import MAX_JOINT_SPEED
from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.session.frame import Frame
from tactile_widgets.common.colours import Theme, mixed
from tactile_widgets.common.make import column_layout
from tactile_widgets.document.taxel_selection import REGION_COLOURS, TAXEL_COLOURS, region_colour
from tactile_widgets.plots.traces.history import ContactHistory, SampleHistory, TaxelHistory
from tactile_widgets.plots.traces.plot_canvas import PlotCanvas, dashed_pen

PLOT_SECONDS = 10.0
"""Duration shown on the time axis [s]."""
TIME_TICKS = (
    (-PLOT_SECONDS, f"−{PLOT_SECONDS:g}\u202fs"),
    (-PLOT_SECONDS / 2, f"−{PLOT_SECONDS / 2:g}\u202fs"),
    (0.0, "now"),
)
"""Ticks of the time axis: age [s] and text."""
AXIS_START = -1.04 * PLOT_SECONDS
AXIS_END = 0.15 * PLOT_SECONDS
"""Ends of the time axis [s]: more than the shown duration, so that the labels at the ends fit into a narrow plot."""
AXIS_HEIGHT = 23
"""Height of the time axis with its labels [px]."""
_ALL_TICKS_PX = 90
"""Height of a plot below which its left axis has fewer ticks [px]."""
_ALL_TICKS_RANGE = 0.05
"""Range of the left axis below which it has fewer ticks: more would need numbers of three decimals."""
_LABELS_FOR_THREE = 2.3
"""Height of a left axis with three ticks, as a multiple of that of their labels."""
_LEFT_WIDTH = 34
_LEFT_MARGIN = 10
"""Width of the left axis, and of its tick and margins next to a number [px]."""


class PlotSeries(NamedTuple):
    """Samples of one curve, for files.

    Attributes:
        name: Name of the curve.
        unit: Unit of the values; empty if there is none.
        ages: (k,) [s]: 0 for now and negative before.
        values: (k,) NaN where there is no value.
    """

    name: str
    unit: str
    ages: FloatArray
    values: FloatArray

    @classmethod
    def of_spans(cls, name: str, spans: Sequence[tuple[float, float]]) -> PlotSeries:
        """Return a series that is 1 at the beginning and at the end of each span and 0 right after."""
        ages = [age for start, end in spans for age in (start, end, end)]
        return cls(name, "", np.array(ages), np.tile([1.0, 1.0, 0.0], len(spans)))


class PlotPart(Protocol):
    """Content of a plot."""

    def draw(self) -> None:
        """Draw the stored samples."""

    def set_theme(self, theme: Theme) -> None:
        """Apply a theme."""

    def series(self) -> list[PlotSeries]:
        """Return the drawn curves, for files."""


class TracePlot(QWidget):
    """Empty plot from zero to a round maximum that rarely changes; now at the right, ten seconds ago at the left.

    Args:
        title: Quantity and unit.
        floor: Lower bound of the maximum, so that noise does not fill the plot.
    """

    def __init__(self, title: str, floor: float, parent: QWidget) -> None:
        super().__init__(parent)
        self._title = title
        self._floor = floor
        self._top = 0.0
        self._ends = 0.0, 0.0
        self._styled: Theme | None = None
        self._marks: list[pg.InfiniteLine] = []
        self._mark_pen = pg.mkPen(None)
        self.setAccessibleName(title)
        self._heading = QLabel(title, self)
        self._heading.setWordWrap(True)
        self.plot = PlotCanvas(self)
        self._heading.setFont(self.plot.small)
        column_layout(self._heading, self.plot, parent=self, spacing=4, stretch=self.plot)
        self._set_up_axes()
        self.reach(0.0)
        self.plot.getViewBox().sigResized.connect(self._show_ticks)  # also if the heading gets another line

    def _set_up_axes(self) -> None:
        self.plot.setXRange(AXIS_START, AXIS_END, padding=0)
        left = self.plot.getAxis("left")
        bottom = self.plot.getAxis("bottom")
        bottom.setTicks([list(TIME_TICKS)])
        bottom.setStyle(hideOverlappingLabels=False, tickLength=3)
        bottom.setHeight(AXIS_HEIGHT)
        left.setStyle(tickLength=3)
        left.setWidth(_LEFT_WIDTH)

    def _show_ticks(self) -> None:
        """Draw three ticks only in a low plot or a small range, where the labels of more would not fit, or two.

        The axis is as wide as its labels, because labels that do not fit are not drawn.
        """
        left = self.plot.getAxis("left")
        metrics = QFontMetricsF(self.plot.small)
        height = self.plot.getViewBox().height()
        bottom, top = ends = self._ends if any(self._ends) else (0.0, self._top)
        if self.plot.height() >= _ALL_TICKS_PX and top - bottom >= _ALL_TICKS_RANGE:
            left.setTicks(None)
            step, values = left.tickValues(bottom, top, max(height, 1.0))[0]
            texts = left.tickStrings(values, 1.0, step)
        else:
            ticks = ends if height < _LABELS_FOR_THREE * metrics.height() else (*ends, sum(ends) / 2)
            texts = [f"{value:.6g}" for value in ticks]
            left.setTicks([list(zip(ticks, texts, strict=True))])
        left.setWidth(max(_LEFT_WIDTH, ceil(max(map(metrics.horizontalAdvance, texts))) + _LEFT_MARGIN))

    @property
    def heading(self) -> str:
        """Title and legend as rich text."""
        return self._heading.text()

    def set_title(self, title: str) -> None:
        """Set the quantity and unit; call ``update_style`` afterwards."""
        self._title = title
        self.setAccessibleName(title)

    def update_style(self, theme: Theme, *, after_title: str = "", title: str = "") -> None:
        """Apply a theme; ``after_title`` is rich text after the title, ``title`` temporarily replaces the title."""
        words = f'<span style="color:{QColor(theme.quiet).name()}">{title or self._title}{after_title}</span>'
        if words != self._heading.text():
            self._heading.setText(words)
        if theme is self._styled:
            return  # other pens, even equal ones, draw the ticks again: 2 ms an axis
        self._styled = theme
        self._mark_pen = pg.mkPen(theme.quiet, width=1, style=Qt.PenStyle.DotLine)
        for line in self._marks:
            line.setPen(self._mark_pen)
        self.plot.colour_axes(theme)

    def add_curve(self, **style: Any) -> pg.PlotCurveItem:
        """Add a curve without samples; a ``PlotDataItem`` takes six times as long to make and to update."""
        curve = pg.PlotCurveItem(**style)
        self.plot.addItem(curve)
        return curve

    def mark(self, ages: Sequence[float]) -> None:
        """Draw a thin line at each of these ages [s] and nowhere else."""
        while len(self._marks) < len(ages):
            self._marks.append(pg.InfiniteLine(angle=90, movable=False, pen=self._mark_pen))
            self._marks[-1].setZValue(-1)
            self.plot.addItem(self._marks[-1], ignoreBounds=True)
        for number, line in enumerate(self._marks):
            line.setVisible(number < len(ages))
            if number < len(ages):
                line.setValue(ages[number])

    def reach(self, highest: float) -> None:
        """Extend the axis to ``highest``."""
        top = nice_ceiling(max(highest, self._floor))
        if top != self._top:
            self._top = top
            self.plot.setYRange(-0.02 * top, 1.1 * top, padding=0)  # room for the label of the maximum
            self._show_ticks()

    def reach_between(self, lowest: float, highest: float) -> None:
        """Fit the axis to values of either sign: from a round minimum to a round maximum, at least ``floor`` apart."""
        middle = (lowest + highest) / 2
        half = max(highest - lowest, self._floor) / 2
        step = nice_ceiling(half) / 5
        bottom = step * np.floor((middle - half) / step)
        top = step * np.ceil((middle + half) / step)
        if (bottom, top) != self._ends:
            self._ends = bottom, top
            self.plot.setYRange(bottom, top, padding=0.06)
            self._show_ticks()


def legend_entry(mark: str, ink: str, words: str, *, strong: bool = False) -> str:
    """Return the rich text of a legend entry: a mark in its colour, then text without line breaks."""
    label = escape(words).replace(" ", "&nbsp;")
    label = f"<b>{label}</b>" if strong else label
    joined = mark.replace(" ", "&nbsp;").replace("–", "\u2060–\u2060")  # word joiners prevent a line break after a dash
    return f' &nbsp;<span style="color:{QColor(ink).name()}">{joined}</span>&nbsp;{label}'


def nice_ceiling(value: float) -> float:
    """Return the smallest of 1, 2, 5 times a power of ten that is at least ``value`` > 0."""
    power = 10.0 ** np.floor(np.log10(value))
    return float(next(power * step for step in (1, 2, 5, 10) if power * step >= value * (1 - 1e-9)))


def max_or_zero(values: FloatArray) -> float:
    """Return the maximum, 0 for an empty array."""
    return float(np.nanmax(values)) if values.size else 0.0


MAX_REGIONS = 16
"""Maximum number of regions with a trace; of more, the strongest."""
_MAX_LEGEND_REGIONS = 3
"""Maximum number of regions in the legend; the contacts panel lists all."""
_LEGEND_REGION_PX = 90
"""Width of a plot for each of these regions [px]: a legend of more than two lines would push the axis out of view."""


class ForceTraces:
    """Force curves: total, each region, and the goal. Mutable: ``add`` samples, then ``draw``.

    Args:
        plot: Plot that shows the curves.
        theme: Colours of everything except the regions.
    """

    def __init__(self, plot: TracePlot, theme: Theme) -> None:
        self._plot = plot
        self._theme = theme
        self._total = SampleHistory(seconds=PLOT_SECONDS)
        self._regions = ContactHistory(seconds=PLOT_SECONDS)
        self._line = plot.add_curve()
        self._lines = {colour: plot.add_curve(connect="finite") for colour in REGION_COLOURS}
        self._selected_line = plot.add_curve(connect="finite")
        self._selected_line.setZValue(2)
        self._living: tuple[tuple[int, str], ...] = ()
        self._selected: int | None = None
        self._ink_regions()
        self._draw_regions()
        self._goal = plot.add_curve(connect="finite")
        self._goal.hide()
        self._goal_force: float | None = None
        self._units = ReadingUnits.CALIBRATED

    def set_theme(self, theme: Theme) -> None:
        """Apply a theme."""
        self._theme = theme
        self._line.setPen(pg.mkPen(theme.text, width=1.5))
        self._goal.setPen(dashed_pen(theme.intent))
        self._update_legend()

    def set_goal(self, newtons: float | None) -> None:
        """Set the force goal [N] used for frames without one; None while no controller holds a force."""
        self._goal_force = newtons
        self._update_legend()

    def set_units(self, units: ReadingUnits) -> None:
        """Set the units of forces; samples in other units are discarded."""
        self._units = units
        self._plot.set_title(units.strength_title)
        self.clear()
        self._update_legend()

    def select(self, region: int | None) -> None:
        """Highlight the trace of a region; None if there is none."""
        self._selected = region
        self._ink_regions()
        self._draw_regions()
        self._update_legend()

    def clear(self) -> None:
        """Discard all samples."""
        self._total.clear()
        self._regions.clear()
        self._living = ()

    def add(self, time: float, regions: tuple[ContactRegion, ...], goal: float | None = None) -> tuple[int, ...]:
        """Store the forces and the task's goal at ``time`` [s]; return ids of regions whose last sample was dropped."""
        before = self._regions.names
        goal = self._goal_force if goal is None else goal
        goal = None if self._units.force is None else goal  # newtons have no place among relative strengths
        total = {"force": sum(region.force for region in regions), "goal": np.nan if goal is None else goal}
        self._total.add(time, total)
        kept = regions[:MAX_REGIONS]
        self._regions.add(time, {str(region.id): region.force for region in kept})
        self._living = tuple((region.id, region.link) for region in kept)
        after = set(self._regions.names)
        return tuple(int(name) for name in before if name not in after)

    def draw(self) -> None:
        """Draw the stored samples."""
        ages, force = self._total.series("force")
        self._line.setData(ages, force)
        goals = self._total.series("goal")[1]
        self._goal.setData(ages, goals)
        self._goal.setVisible(bool(np.isfinite(goals).any()))
        self._draw_regions()
        self._plot.reach(max(max_or_zero(force), max_or_zero(goals[np.isfinite(goals)])))
        self._update_legend()

    def series(self) -> list[PlotSeries]:
        """Return the total force, the goal, and the force of each contact."""
        unit = self._units.force or "relative"
        series = [PlotSeries("all contacts", unit, *self._total.series("force"))]
        if np.isfinite(self._total.series("goal")[1]).any():
            series.append(PlotSeries("goal", unit, *self._total.series("goal")))
        return series + [PlotSeries(f"contact {name}", unit, *self.contact(name)) for name in self._regions.names]

    def contact(self, name: str) -> tuple[FloatArray, FloatArray]:
        """Return ages (k,) [s] and forces (k,) of the contact with this id."""
        return self._regions.series(name)

    def _ink_regions(self) -> None:
        """Draw the selected region thick, and the others faint while one is selected."""
        for colour, line in self._lines.items():
            ink = QColor(colour)
            ink.setAlphaF(1.0 if self._selected is None else 0.45)
            line.setPen(pg.mkPen(ink, width=1.5))
        if self._selected is not None:
            self._selected_line.setPen(pg.mkPen(region_colour(self._selected), width=3.0))

    def _draw_regions(self) -> None:
        """Draw all regions of a colour as one curve: painting hundreds of curves of short touches takes 0.1 s."""
        names: dict[pg.PlotCurveItem, list[str]] = {line: [] for line in (*self._lines.values(), self._selected_line)}
        for name in self._regions.names:
            region = int(name)
            names[self._selected_line if region == self._selected else self._lines[region_colour(region)]].append(name)
        for line, shown in names.items():
            line.setData(*_joined([self._regions.series(name) for name in shown]))
            line.setVisible(bool(shown))

    def _update_legend(self) -> None:
        legend = ""
        if self._goal_force is not None and self._units.force is not None:
            legend += legend_entry("– –", self._theme.intent, f"goal {self._goal_force:.1f}")
        if self._living:
            legend += legend_entry("—", self._theme.text, "all")
        shown = max(min(self._plot.width() // _LEGEND_REGION_PX - 1, _MAX_LEGEND_REGIONS), 1)
        for region, link in self._living[:shown]:
            legend += legend_entry("●", region_colour(region), link, strong=region == self._selected)
        if len(self._living) > shown:
            legend += f" &nbsp;+{len(self._living) - shown}"
        self._plot.update_style(self._theme, after_title=legend)


def _joined(series: Sequence[tuple[FloatArray, FloatArray]]) -> tuple[FloatArray, FloatArray]:
    """Return the ages and values of several series as one series with gaps between them."""
    gap = np.array([[0.0], [np.nan]])
    parts = [part for one in series for part in (np.stack(one), gap)][:-1]
    ages, values = np.concatenate(parts, axis=1) if parts else np.zeros((2, 0))
    return ages, values


def peak_title(units: ReadingUnits) -> str:
    """Return the title of the peak plot, for example "Peak pressure (kPa)"."""
    return f"Peak {units.title[0].lower()}{units.title[1:]}"


class PressureTraces:
    """Pressure curves: the peak, and the selected taxels one by one, or many as mean and maximum with a band between.

    Mutable: ``add`` samples, then ``draw``.

    Args:
        plot: Plot that shows the curves.
        theme: Colours of everything except the taxels.

    Attributes:
        taxels: Pressures of all taxels.
    """

    def __init__(self, plot: TracePlot, theme: Theme) -> None:
        self._plot = plot
        self._theme = theme
        self._peak = SampleHistory(seconds=PLOT_SECONDS)
        self.taxels = TaxelHistory(seconds=PLOT_SECONDS)
        self._together = SampleHistory(seconds=PLOT_SECONDS)
        self._latest = 0.0
        self._line = plot.add_curve()
        self._lines = [plot.add_curve() for _ in TAXEL_COLOURS]
        self._top = plot.add_curve(pen=pg.mkPen(TAXEL_COLOURS[0], width=1.0))
        shade = QColor(TAXEL_COLOURS[0])
        shade.setAlphaF(0.28)
        self._band = pg.FillBetweenItem(self._top, self._lines[0], brush=shade)
        plot.plot.addItem(self._band)
        self._selected: IntArray = np.zeros(0, int)
        self._inks: tuple[str, ...] = ()
        self._units = ReadingUnits.CALIBRATED

    def set_units(self, units: ReadingUnits) -> None:
        """Set the units of readings; samples in other units are discarded."""
        self._units = units
        self._plot.set_title(peak_title(units))
        self.clear()
        self._update_legend()

    def set_theme(self, theme: Theme) -> None:
        """Apply a theme."""
        self._theme = theme
        self._update_legend()

    def select(self, taxels: IntArray, inks: tuple[str, ...]) -> None:
        """Trace these taxels (k,), each in its colour, or many as one mean curve."""
        self._selected = taxels
        self._inks = inks
        for line, ink in zip(self._lines, inks, strict=False):
            line.setPen(pg.mkPen(ink, width=1.75))
        self._together.clear()
        if self._many:
            ages, traces = self.taxels.traces(taxels)
            for age, pressures in zip(ages.tolist(), traces, strict=True):
                self._add_together(self._latest + age, pressures)
        self._update_legend()
        self.draw()

    def clear(self) -> None:
        """Discard all samples."""
        for history in (self._peak, self.taxels, self._together):
            history.clear()

    def add(self, time: float, pressures: FloatArray) -> None:
        """Store pressures (taxels,) [Pa] at ``time`` [s]."""
        self._peak.add(time, {"peak": 1e-3 * float(pressures.max(initial=0.0))})
        self.taxels.add(time, pressures)
        self._latest = time
        if self._many:
            self._add_together(time, 1e-3 * pressures[self._selected])

    def _add_together(self, time: float, kilopascals: FloatArray) -> None:
        self._together.add(time, {"mean": float(kilopascals.mean()), "max": float(kilopascals.max())})

    def draw(self) -> None:
        """Draw the stored samples."""
        ages, peak = self._peak.series("peak")
        self._line.setData(ages, peak)
        self._top.setData(*self._together.series("max"))
        self._plot.reach(max_or_zero(peak))
        if self._many:
            ages, shown = self._together.series("mean")
            shown = shown[:, None]
        else:
            ages, shown = self.taxels.traces(self._selected)
        for number, line in enumerate(self._lines):
            there = number < shown.shape[1]
            line.setData(ages if there else [], shown[:, number] if there else [])

    def series(self) -> list[PlotSeries]:
        """Return the peak, and the selected taxels one by one or as mean and maximum."""
        unit = self._units.unit
        series = [PlotSeries("max of all", unit, *self._peak.series("peak"))]
        if self._many:
            together = {"mean": f"mean of {len(self._selected)}", "max": f"max of {len(self._selected)}"}
            return series + [PlotSeries(words, unit, *self._together.series(name)) for name, words in together.items()]
        return series + [PlotSeries(f"taxel {one}", unit, *self.taxel(one)) for one in self._selected.tolist()]

    def taxel(self, taxel: int) -> tuple[FloatArray, FloatArray]:
        """Return ages (k,) [s] and pressures (k,) [kPa] of a taxel; empty if the skin has no such taxel."""
        if taxel >= self.taxels.count:
            return np.zeros(0), np.zeros(0)
        ages, traces = self.taxels.traces(np.array([taxel]))
        return ages, traces[:, 0]

    def group(self, taxels: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return ages (k,) [s] and pressures (k, n) [kPa] of taxels (n,); empty if the skin lacks one of them."""
        if not len(taxels) or int(taxels.max()) >= self.taxels.count:
            return np.zeros(0), np.zeros((0, max(len(taxels), 1)))
        return self.taxels.traces(taxels)

    @property
    def _many(self) -> bool:
        return len(self._selected) > len(TAXEL_COLOURS)

    def _update_legend(self) -> None:
        theme = self._theme
        count = len(self._selected)
        quiet = mixed(theme.window, theme.quiet, 0.7)
        self._line.setPen(pg.mkPen(QColor(quiet if count else theme.text), width=1.0 if count else 1.5))
        self._band.setVisible(self._many)
        if not count:
            self._plot.update_style(theme)
            return
        if self._many:
            legend = legend_entry("—", TAXEL_COLOURS[0], f"mean of {count}") + legend_entry(
                "■", TAXEL_COLOURS[0], "max"
            )
        else:
            pairs = zip(self._selected.tolist(), self._inks, strict=True)
            legend = "".join(legend_entry("○", ink, str(taxel)) for taxel, ink in pairs)
        self._plot.update_style(
            theme, title=self._units.title, after_title=legend + legend_entry("—", quiet, "max of all")
        )


TOLERANCE = 0.005
"""Maximum error [m] that the experiments count as on the path."""


class BoundedTrace:
    """Curve of one quantity with an upper bound. Mutable: ``add`` samples, then ``draw``.

    Args:
        plot: Plot that shows the curve.
        theme: Colours.
        bound: Value that the quantity should stay below.
        words: Legend text of the bound.
        hard: Whether the bound is an enforced limit or a desired value.
        quantity: Name and unit.
    """

    def __init__(
        self, plot: TracePlot, theme: Theme, *, bound: float, words: str, hard: bool, quantity: tuple[str, str]
    ) -> None:
        self._quantity, self._unit = quantity
        self._title = ""  # the title of the plot
        self._plot = plot
        self._theme = theme
        self._bound = bound
        self._words = words
        self._hard = hard
        self._history = SampleHistory(seconds=PLOT_SECONDS)
        self._line = plot.add_curve(connect="finite")
        self._limit = pg.InfiniteLine(bound, angle=0, movable=False)
        plot.plot.addItem(self._limit)

    def set_theme(self, theme: Theme) -> None:
        """Apply a theme."""
        self._theme = theme
        self._line.setPen(pg.mkPen(theme.text, width=1.5))
        self._limit.setPen(dashed_pen(self._ink, 1.2))
        self._update_legend()

    def use(self, title: str, *, unit: str, bound: float) -> None:
        """Set title, unit and bound, and discard the samples."""
        self._history.clear()
        self._title = title
        self._unit = unit
        self._bound = bound
        self._words = f"limit {bound:g}"
        self._limit.setValue(bound)
        self._update_legend()

    def clear(self) -> None:
        """Discard all samples."""
        self._history.clear()

    def add(self, time: float, value: float | None) -> None:
        """Store the value at ``time`` [s]; None for no value."""
        self._history.add(time, {"value": np.nan if value is None else value})

    def draw(self) -> None:
        """Draw the stored samples."""
        ages, values = self._history.series("value")
        self._line.setData(ages, values)
        known = values[np.isfinite(values)]
        self._plot.reach(max(max_or_zero(known), self._bound))

    def series(self) -> list[PlotSeries]:
        """Return the curve."""
        return [PlotSeries(self._quantity, self._unit, *self._history.series("value"))]

    @property
    def _ink(self) -> QColor:
        return QColor(self._theme.warning if self._hard else self._theme.intent)

    def _update_legend(self) -> None:
        legend = legend_entry("– –", self._ink.name(), self._words)
        self._plot.update_style(self._theme, after_title=legend, title=self._title)


def error_trace(plot: TracePlot, theme: Theme) -> BoundedTrace:
    """Return the trace of the error on the map [mm]."""
    words = f"tolerance {1e3 * TOLERANCE:g}"
    return BoundedTrace(plot, theme, bound=1e3 * TOLERANCE, words=words, hard=False, quantity=("error", "mm"))


def speed_trace(plot: TracePlot, theme: Theme) -> BoundedTrace:
    """Return the trace of the fastest joint; ``use`` sets its scale for a robot."""
    words = f"limit {MAX_JOINT_SPEED:g}"
    quantity = ("max joint speed", "rad/s")
    return BoundedTrace(plot, theme, bound=MAX_JOINT_SPEED, words=words, hard=True, quantity=quantity)


def error_of(frame: Frame) -> float | None:
    """Return the error on the map [mm]; None if the task has none."""
    return None if frame.task is None or frame.task.error is None else 1e3 * frame.task.error
