"""Figures of the current plots or of a whole recording, at another size and in other colours."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import ceil, inf
from pathlib import Path

from PySide6.QtCore import QPoint, QSize, Qt
from PySide6.QtGui import QColor, QPainter
from PySide6.QtWidgets import QApplication, QGraphicsView, QLabel, QLayout, QWidget

from tactile_maps.core.errors import DisplayError
from tactile_widgets.dialogs.figures.figure_file import MM_PER_INCH, FigureSpec, write_figure
from tactile_widgets.dialogs.figures.view_figure import theme_of
from tactile_widgets.plots.choice.plot_choice import PlotKey
from tactile_widgets.plots.live_plots import LivePlots
from tactile_widgets.plots.timeline.recording_plots import RecordingPlots
from tactile_widgets.plots.traces.trace_plots import AXIS_HEIGHT

_MARGIN = 6
_GAP = 12
_NARROWEST = 150
"""Minimum width of a plot [units]; further plots start another row."""
_LOWEST_AXES = 48
"""Minimum height of the curves of a plot, or of two rows of spans [units]."""
_SCALES = (1.0, 1.1, 1.2, 1.35, 1.5)
"""Factors by which units shrink until all plots have room; captions have 5 points at the last one."""


def write_plot_figure(plots: LivePlots, keys: Sequence[PlotKey], path: str | Path, spec: FigureSpec) -> None:
    """Write visible plots side by side, in several rows if the figure is narrow, all as vectors.

    The plots are laid out again for the figure and restored before Qt paints the next time.

    Raises:
        DisplayError: The figure is too small, or the file cannot be written.
    """
    theme = theme_of(spec.colours)
    before = plots.theme
    contents = _contents(plots, keys)
    sizes = [content.size() for content in contents]
    canvases = [view for content in contents for view in content.findChildren(QGraphicsView)]

    def paint(painter: QPainter) -> None:
        top = _MARGIN
        for row, height in enumerate(layout.heights(fitted.units[1])):
            for column, content in enumerate(contents[row * layout.columns : (row + 1) * layout.columns]):
                _resize(content, QSize(layout.width, height))
                painter.save()
                painter.translate(QPoint(_MARGIN + column * (layout.width + _GAP), top))
                content.render(painter, QPoint(0, 0), renderFlags=QWidget.RenderFlag.DrawChildren)
                painter.restore()
            top += height + _GAP

    try:
        for canvas in canvases:  # the default is that of the application's theme
            canvas.setBackgroundBrush(QColor(theme.panel))
        plots.set_theme(theme)
        plots.draw()
        fitted = plots_spec(plots, keys, spec)
        layout = next(one for one in _layouts(contents, fitted.units[0]) if one.lowest <= fitted.units[1])
        write_figure(path, fitted, theme.panel, paint)
    finally:
        plots.set_theme(before)
        for canvas in canvases:
            canvas.setBackgroundBrush(Qt.BrushStyle.NoBrush)
        for content, size in zip(contents, sizes, strict=True):
            _resize(content, size)


def write_recording_figure(plots: RecordingPlots, path: str | Path, spec: FigureSpec) -> None:
    """Write the shown part of the curves over a recording, as vectors.

    Raises:
        DisplayError: The curves are not read yet, the figure is too small, or the file cannot be written.
    """
    if plots.missing:
        raise DisplayError("the plots are empty", value=plots.missing, remedy="Save the figure when they are shown")
    fitted = recording_spec(plots, spec)
    theme = theme_of(spec.colours)
    drawn = plots.twin(theme)
    try:
        drawn.resize(*fitted.units)
        write_figure(path, fitted, theme.panel, drawn.paint_figure)
    finally:
        drawn.deleteLater()


def plots_spec(plots: LivePlots, keys: Sequence[PlotKey], spec: FigureSpec) -> FigureSpec:
    """Return ``spec`` with the largest units at which these plots are readable.

    Raises:
        DisplayError: The figure is too small.
    """
    contents = _contents(plots, keys)

    def lowest(width: int) -> float:
        return min((layout.lowest for layout in _layouts(contents, width)), default=inf)

    return _fitted(spec, lowest, 2 * _MARGIN + _NARROWEST)


def recording_spec(plots: RecordingPlots, spec: FigureSpec) -> FigureSpec:
    """Return ``spec`` with the largest units at which the curves over a recording are readable.

    Raises:
        DisplayError: The figure is too small.
    """
    least = plots.smallest
    return _fitted(spec, lambda width: least.height() if width >= least.width() else inf, least.width())


def _fitted(spec: FigureSpec, lowest: Callable[[int], float], narrowest: int) -> FigureSpec:
    """Return ``spec`` with the largest units that give enough room.

    Args:
        spec: Size of the figure.
        lowest: Returns the minimum height at a width [units]; infinite if the width is too small.
        narrowest: Minimum width [units].
    """
    for scale in _SCALES:
        fitted = replace(spec, units_per_inch=round(scale * spec.units_per_inch))
        width, height = fitted.units
        if lowest(width) <= height:
            return fitted
    unit = MM_PER_INCH / fitted.units_per_inch
    least_width = max(ceil(narrowest * unit), spec.width)
    least_height = max(ceil(lowest(int(least_width / unit)) * unit), spec.height)
    raise DisplayError(
        "the figure is too small for these plots",
        value=f"{spec.width:g} × {spec.height:g} mm",
        remedy=f"Choose at least {least_width:g} × {least_height:g} mm",
    )


@dataclass(frozen=True)
class _Layout:
    """Rows of plots.

    Attributes:
        columns: Number of plots in a row.
        width: Width of a plot [units].
        rows: Minimum height of each row [units].
    """

    columns: int
    width: int
    rows: tuple[int, ...]

    @property
    def lowest(self) -> int:
        """Minimum height of the figure [units]."""
        return 2 * _MARGIN + sum(self.rows) + (len(self.rows) - 1) * _GAP

    def heights(self, height: int) -> list[int]:
        """Return the heights of the rows in a figure of a height [units]; their curves are equally high."""
        return [row + (height - self.lowest) // len(self.rows) for row in self.rows]


def _layouts(contents: Sequence[QWidget], width: int) -> Iterator[_Layout]:
    """Yield the layouts of plots in a figure of a width [units], those with most columns first."""
    for columns in range(min(len(contents), (width - 2 * _MARGIN + _GAP) // (_NARROWEST + _GAP)), 0, -1):
        cell = (width - 2 * _MARGIN - (columns - 1) * _GAP) // columns
        heights = [_lowest(content, cell) for content in contents]
        yield _Layout(
            columns, cell, tuple(max(heights[first : first + columns]) for first in range(0, len(heights), columns))
        )


def _lowest(content: QWidget, width: int) -> int:
    """Return the minimum height of a plot of a width: its heading, which may have several lines, curves and axis."""
    heading = content.findChild(QLabel)
    assert isinstance(heading, QLabel)
    lines = heading.heightForWidth(width) if heading.hasHeightForWidth() else heading.sizeHint().height()
    layout = content.layout()
    assert isinstance(layout, QLayout)
    return lines + layout.spacing() + _LOWEST_AXES + AXIS_HEIGHT


def _contents(plots: LivePlots, keys: Sequence[PlotKey]) -> list[QWidget]:
    return [content for key in keys if (content := plots.content(key)) is not None]


def _resize(content: QWidget, size: QSize) -> None:
    """Resize a widget, and lay out all widgets in it."""
    content.resize(size)
    layout = content.layout()
    if isinstance(layout, QLayout):
        layout.activate()
    for child in content.findChildren(QWidget):
        QApplication.sendPostedEvents(child)
