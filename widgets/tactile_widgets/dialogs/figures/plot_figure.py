"""Figures of the current plots, at another size and in other colours."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from PySide6.QtCore import QPoint, QSize, Qt
from PySide6.QtGui import QColor, QPainter
from PySide6.QtWidgets import QApplication, QGraphicsView, QLayout, QWidget

from tactile_widgets.dialogs.figures.figure_file import FigureSpec, write_figure
from tactile_widgets.dialogs.figures.view_figure import theme_of
from tactile_widgets.plots.choice.plot_choice import PlotKey
from tactile_widgets.plots.live_plots import LivePlots

_MARGIN = 6
_GAP = 12
_NARROWEST = 150
"""Minimum width of a plot [units]; further plots start another row."""


def write_plot_figure(plots: LivePlots, keys: Sequence[PlotKey], path: str | Path, spec: FigureSpec) -> None:
    """Write visible plots side by side, in several rows if the figure is narrow, all as vectors.

    The plots are laid out again for the figure and restored before Qt paints the next time.

    Raises:
        DisplayError: The file cannot be written.
    """
    theme = theme_of(spec.colours)
    before = plots.theme
    contents = [content for key in keys if (content := plots.content(key)) is not None]
    sizes = [content.size() for content in contents]
    columns = max(min(len(contents), (spec.units[0] - 2 * _MARGIN + _GAP) // (_NARROWEST + _GAP)), 1)
    rows = -(-len(contents) // columns)
    cell = QSize(
        (spec.units[0] - 2 * _MARGIN - (columns - 1) * _GAP) // columns,
        (spec.units[1] - 2 * _MARGIN - (rows - 1) * _GAP) // max(rows, 1),
    )

    def paint(painter: QPainter) -> None:
        for number, content in enumerate(contents):
            row, column = divmod(number, columns)
            _resize(content, cell)
            place = QPoint(_MARGIN + column * (cell.width() + _GAP), _MARGIN + row * (cell.height() + _GAP))
            painter.save()
            painter.translate(place)
            content.render(painter, QPoint(0, 0), renderFlags=QWidget.RenderFlag.DrawChildren)
            painter.restore()

    canvases = [view for content in contents for view in content.findChildren(QGraphicsView)]
    try:
        for canvas in canvases:  # the default is that of the application's theme
            canvas.setBackgroundBrush(QColor(theme.panel))
        plots.set_theme(theme)
        plots.draw()
        write_figure(path, spec, theme.panel, paint)
    finally:
        plots.set_theme(before)
        for canvas in canvases:
            canvas.setBackgroundBrush(Qt.BrushStyle.NoBrush)
        for content, size in zip(contents, sizes, strict=True):
            _resize(content, size)


def _resize(content: QWidget, size: QSize) -> None:
    """Resize a widget, and lay out all widgets in it."""
    content.resize(size)
    layout = content.layout()
    if isinstance(layout, QLayout):
        layout.activate()
    for child in content.findChildren(QWidget):
        QApplication.sendPostedEvents(child)
