"""Raster of all taxels over time: a row for each taxel by its id, a column for each moment, the pressure as colour.

If there are more taxels or samples than pixels, a pixel shows the maximum of its own, so that no touch is lost.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from PySide6.QtCore import QEvent, QPoint, QPointF, QRectF, Qt, Signal
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QImage, QMouseEvent, QPainter, QPaintEvent, QPen
from PySide6.QtWidgets import QLabel, QToolTip, QWidget

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.skin.model.skin import Skin
from tactile_widgets.common.colours import PressureScale, Theme
from tactile_widgets.common.make import column_layout, small_font
from tactile_widgets.document.taxel_search import taxel_words
from tactile_widgets.plots.traces.history import TaxelHistory
from tactile_widgets.plots.traces.trace_plots import AXIS_END, AXIS_START, TIME_TICKS, PlotSeries

HELD = 1.0
"""Time for which the last sample is shown if no other follows [s]."""
_LEFT = 40.0
_AXIS = 16.0
_EDGE = 2.0


@dataclass(frozen=True, eq=False)
class TaxelRows:
    """Taxels of a skin from the first row of a raster to the last: by hardware id, or by number without ids.

    Attributes:
        skin: The skin.
    """

    skin: Skin

    @cached_property
    def order(self) -> IntArray:
        """(taxels,) numbers of the taxels."""
        return np.argsort(self._ids, kind="stable")

    @cached_property
    def _ids(self) -> IntArray:
        ids = self.skin.identity.ids
        return np.arange(len(self.skin)) if ids is None or len(ids) != len(self.skin) else ids

    @property
    def ends(self) -> tuple[str, str]:
        """Ids of the first and the last row."""
        return (str(self._ids[self.order[0]]), str(self._ids[self.order[-1]])) if len(self.order) else ("", "")

    def starts(self, count: int) -> IntArray:
        """Return the first row (count,) of each of ``count`` groups, at most as many as there are taxels."""
        return np.arange(count) * len(self.order) // count

    def taxels(self, share: float, count: int) -> IntArray:
        """Return the taxels of the group at a share of the height, 0 to 1, of ``count`` groups."""
        group = min(max(int(share * count), 0), count - 1)
        starts = np.append(self.starts(count), len(self.order))
        return self.order[starts[group] : starts[group + 1]]

    def words(self, taxel: int, seconds: float, pascals: float, units: ReadingUnits) -> str:
        """Return id, time and value of a taxel as text."""
        time = f"{seconds:.2f}".replace("-", "−")
        return f"{taxel_words(self.skin, taxel)}   {time}\u202fs   {units.reading(pascals)}"


def columns(times: FloatArray, values: FloatArray, edges: FloatArray) -> FloatArray:
    """Return the highest values (k, rows) in each of k columns of pixels.

    A column without a sample shows the one before, for at most ``HELD``, else NaN.

    Args:
        times: (n,) times, increasing [s].
        values: (n, rows) values.
        edges: (k + 1,) edges of the columns [s].
    """
    if not len(times):
        return np.full((len(edges) - 1, values.shape[1]), np.nan)
    at = np.searchsorted(times, edges, side="left")
    first = at[:-1]
    end = at[1:]
    latest = np.maximum(end - 1, 0)
    picture = values[latest].astype(float)
    several = np.flatnonzero(end - first > 1)
    if len(several):
        bounds = np.stack([first[several], end[several]], axis=1).ravel()
        bounds = bounds[:-1] if bounds[-1] == len(values) else bounds  # the last part reaches to the end
        picture[several] = np.fmax.reduceat(values, bounds, axis=0)[::2]
    picture[(end == 0) | (edges[:-1] - times[latest] > HELD)] = np.nan
    return picture


def raster_image(picture: FloatArray, scale: PressureScale) -> QImage:
    """Return the image of a raster (columns, rows) [kPa], the first row at the top; NaN is transparent."""
    known = ~np.isnan(picture)
    levels = np.clip(np.where(known, picture, 0.0) * (255.0 / scale.maximum), 0, 255).astype(np.uint8)
    words = np.ascontiguousarray(np.where(known, scale.lut[levels], np.uint32(0)).T)
    height, width = words.shape
    return QImage(words.data, width, height, 4 * width, QImage.Format.Format_ARGB32).copy()


class RasterPlot(QWidget):
    """Raster of the last seconds, with now at the right. Mutable: ``draw``.

    Args:
        history: Pressures of all taxels.
        theme: Colours.
        scale: Colours of pressures.
        parent: Qt parent.
    """

    taxel_clicked = Signal(int)
    """The row of this taxel was clicked."""

    def __init__(self, history: TaxelHistory, theme: Theme, scale: PressureScale, parent: QWidget) -> None:
        super().__init__(parent)
        self.setObjectName("raster-plot")
        caption = small_font(self.font())
        self._history = history
        self._units = ReadingUnits.CALIBRATED
        self._rows: TaxelRows | None = None
        self._heading = QLabel(self)
        self._heading.setFont(caption)
        self._canvas = _Canvas(self, theme, scale, caption)
        column_layout(self._heading, self._canvas, parent=self, spacing=4, stretch=self._canvas)
        self.set_theme(theme)

    def set_theme(self, theme: Theme) -> None:
        """Apply a theme."""
        self._heading.setStyleSheet(f"color: {theme.quiet}")
        self._canvas.theme = theme
        self._canvas.update()

    def set_scale(self, scale: PressureScale) -> None:
        """Set the colours of pressures."""
        self._canvas.scale = scale
        self.draw()

    def show_skin(self, skin: Skin | None) -> None:
        """Show the taxels of another skin."""
        self._rows = None if skin is None else TaxelRows(skin)

    def set_units(self, units: ReadingUnits) -> None:
        """Set the units of readings."""
        self._units = units

    def draw(self) -> None:
        """Draw the stored samples. Cost: about 10 ms for 1000 or 4000 taxels."""
        self._heading.setText(f"All taxels ({self._units.unit})")
        self.setAccessibleName(self._heading.text())
        rows = self._rows
        width = int(self._canvas.room.width())
        if rows is None or self._history.count != len(rows.order) or width < 1:
            self._canvas.show_image(None, ("", ""))
            return
        ages, values = self._history.highest(rows.order, rows.starts(self._groups))
        edges = np.linspace(AXIS_START, AXIS_END, width + 1)
        picture = columns(ages, values, edges)
        picture[edges[:-1] > 0] = np.nan
        self._canvas.show_image(raster_image(picture, self._canvas.scale), rows.ends)

    @property
    def _groups(self) -> int:
        """Number of rows of pixels, at most one for each taxel."""
        return max(min(int(self._canvas.room.height()), self._history.count), 1)

    def series(self) -> list[PlotSeries]:
        """Return the curves of the taxels that were touched, for files."""
        rows = self._rows
        if rows is None or self._history.count != len(rows.order):
            return []
        ages, values = self._history.traces(rows.order)
        touched = np.flatnonzero(np.nanmax(values, axis=0, initial=0.0) > 0)
        names = (taxel_words(rows.skin, int(rows.order[row])) for row in touched)
        return [
            PlotSeries(name, self._units.unit, ages, values[:, row]) for name, row in zip(names, touched, strict=True)
        ]

    def taxel_at(self, place: QPointF) -> tuple[int, float, float] | None:
        """Return the taxel at a position of this widget, the age [s] and its pressure there [Pa].

        Of several taxels in one row of pixels it is the one with the highest pressure. None off the raster.
        """
        room = self._canvas.room
        at = QPointF(self._canvas.mapFrom(self, place.toPoint()))
        rows = self._rows
        if rows is None or self._history.count != len(rows.order) or not room.contains(at):
            return None
        age = AXIS_START + (at.x() - room.left()) / room.width() * (AXIS_END - AXIS_START)
        taxels = rows.taxels((at.y() - room.top()) / room.height(), self._groups)
        found = self._history.at(age, taxels)
        if found is None or age > 0:
            return None
        best = int(np.argmax(np.nan_to_num(found, nan=-1.0)))
        return int(taxels[best]), age, float(found[best])

    def click(self, place: QPointF) -> None:
        """Emit ``taxel_clicked`` if there is a taxel at a position of this widget."""
        if (found := self.taxel_at(place)) is not None:
            self.taxel_clicked.emit(found[0])

    def words_at(self, place: QPointF) -> str:
        """Return id, age and value of the taxel at a position; empty off the raster."""
        found = self.taxel_at(place)
        return "" if found is None or self._rows is None else self._rows.words(*found, self._units)


class _Canvas(QWidget):
    """The image with its axes."""

    def __init__(self, plot: RasterPlot, theme: Theme, scale: PressureScale, caption: QFont) -> None:
        super().__init__(plot)
        self.theme = theme
        self.scale = scale
        self._plot = plot
        self._caption = caption
        self._image: QImage | None = None
        self._ends = ("", "")
        self.setMouseTracking(True)
        self.setMinimumHeight(48)

    @property
    def room(self) -> QRectF:
        """Place of the image."""
        return QRectF(_LEFT, _EDGE, max(self.width() - _LEFT, 1.0), max(self.height() - _AXIS - 2 * _EDGE, 1.0))

    def show_image(self, image: QImage | None, ends: tuple[str, str]) -> None:
        """Show an image, and the ids of its first and last row."""
        self._image = image
        self._ends = ends
        self.update()

    def paintEvent(self, _event: QPaintEvent) -> None:
        painter = QPainter(self)
        painter.setFont(self._caption)
        room = self.room
        if self._image is not None:
            painter.drawImage(room, self._image)
        painter.setPen(QPen(QColor(self.theme.line), 1))
        painter.drawLine(room.bottomLeft(), room.bottomRight())
        painter.setPen(QColor(self.theme.quiet))
        paint_ends(painter, QRectF(0, room.top(), _LEFT - 4, room.height()), self._ends)
        metrics = QFontMetricsF(self._caption)
        for age, words in TIME_TICKS:
            wide = metrics.horizontalAdvance(words)
            x = room.left() + room.width() * (age - AXIS_START) / (AXIS_END - AXIS_START)
            painter.drawText(QPointF(min(max(x - wide / 2, 0.0), self.width() - wide), self.height() - 3), words)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Show id, time and value under the pointer."""
        words = self._plot.words_at(QPointF(self.mapTo(self._plot, event.position().toPoint())))
        QToolTip.showText(event.globalPosition().toPoint() + QPoint(8, 8), words, self)

    def leaveEvent(self, _event: QEvent) -> None:
        QToolTip.hideText()


def paint_ends(painter: QPainter, margin: QRectF, ends: tuple[str, str]) -> None:
    """Draw the ids of the first and the last row at the upper and lower end of the margin left of a raster."""
    flags = Qt.AlignmentFlag
    painter.drawText(margin, flags.AlignRight | flags.AlignTop, ends[0])
    painter.drawText(margin, flags.AlignRight | flags.AlignBottom, ends[1])
