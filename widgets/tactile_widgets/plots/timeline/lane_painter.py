"""Painting of the lanes over a whole recording.

Each pixel column shows the minimum and maximum of its samples, however long the recording is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from PySide6.QtCore import QLineF, QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QPainter, QPen, QPolygonF

from tactile_maps.core.arrays import FloatArray
from tactile_maps.recording.overview.curves import CURVES, Curves, envelope
from tactile_widgets.common.colours import Theme
from tactile_widgets.plots.timeline.lanes import Lane
from tactile_widgets.plots.timeline.playhead import Span
from tactile_widgets.plots.traces.trace_plots import nice_ceiling

LEFT = 52.0
"""Minimum space left of the lanes, for the numbers of their axes [px]."""
_LEAST_SPAN = 0.02
"""Minimum range of an axis that need not include zero [unit]."""
_TITLE_PX = 14.0
"""Height of the title above the curve [px]."""


@dataclass(frozen=True, eq=False)
class Overlaid:
    """Second recording drawn over the first.

    Attributes:
        curves: Its curves.
        first_tick: Tick of its first frame.
        tick: Tick duration of its scene [s].
        offset: Time by which it starts after the first recording [s].
        name: Name shown to the user.
    """

    curves: Curves
    first_tick: int
    tick: float
    offset: float
    name: str

    def times(self) -> FloatArray:
        """Return the times of its frames [s from the first frame of the first recording]."""
        return self.offset + self.tick * (self.curves.ticks - self.first_tick).astype(np.float64)


@dataclass(frozen=True)
class _Axis:
    """Axis of a lane: ends in its unit, position of zero [px] (possibly outside the lane), and pixels per unit."""

    low: float
    high: float
    zero: float
    scale: float


def _axis(lane: Lane, values: FloatArray, box: QRectF) -> _Axis:
    known = values[np.isfinite(values)]
    least, most = (float(known.min()), float(known.max())) if len(known) else (0.0, 0.0)
    if lane.floor is None:
        step = nice_ceiling(max(most - least, _LEAST_SPAN) / 2)
        low = step * np.floor(least / step)
        high = step * np.ceil(most / step)
        high = max(high, low + step)
    else:
        low = 0.0
        high = nice_ceiling(max(most, lane.floor))
    scale = (box.height() - _TITLE_PX) / (high - low)
    return _Axis(float(low), float(high), box.bottom() + scale * float(low), scale)


@dataclass(frozen=True, eq=False)
class LanePainter:
    """Painter of the lanes of one recording.

    Attributes:
        theme: Colours.
        view: Shown part of the recording.
        left: Space left of a lane [px].
        room: Width of a lane [px].
        times: (n,) times of the frames [s from the first].
        values: (n, columns) values of the frames, SI.
        other: Second recording drawn over it; None if there is none.
    """

    theme: Theme
    view: Span
    left: float
    room: float
    times: FloatArray
    values: FloatArray
    other: Overlaid | None

    def paint(self, painter: QPainter, lane: Lane, box: QRectF) -> None:
        """Draw a lane in ``box``."""
        own, other = self._columns(lane)
        axis = _axis(lane, np.concatenate([own, other]), box)
        self._paint_axis(painter, axis, box)
        painter.save()
        painter.setClipRect(box.adjusted(0, -2, 0, 2))
        if self.other is not None:
            dashes = QPen(QColor(self.theme.quiet), 1.5, Qt.PenStyle.DashLine)
            self._paint_curve(painter, dashes, self.other.times(), other, axis.zero, axis.scale)
        self._paint_curve(painter, QPen(QColor(self.theme.text), 1.25), self.times, own, axis.zero, axis.scale)
        painter.restore()
        legend = "" if self.other is None or lane.column else f"    – –  {self.other.name}"
        painter.setPen(QColor(self.theme.quiet))
        painter.drawText(QPointF(box.left() + 4, box.top() + 9), f"{lane.title}{legend}")

    def _columns(self, lane: Lane) -> tuple[FloatArray, FloatArray]:
        """Return the curve, and that of the second recording, which has only the standard curves."""
        own = lane.factor * self.values[:, lane.column]
        if self.other is None or lane.column >= len(CURVES):
            return own, np.full(0 if self.other is None else len(self.other.curves.ticks), np.nan)
        return own, lane.factor * self.other.curves.values[:, lane.column]

    def _paint_axis(self, painter: QPainter, axis: _Axis, box: QRectF) -> None:
        painter.setPen(QColor(self.theme.line))
        painter.drawLine(box.bottomLeft(), box.bottomRight())
        painter.setPen(QColor(self.theme.quiet))
        flags = Qt.AlignmentFlag
        edge = QRectF(0, box.top() - 2, self.left - 6, box.height() + 4)
        painter.drawText(edge, flags.AlignRight | flags.AlignBottom, f"{axis.low:.4g}")
        tick = axis.zero - axis.scale * axis.high
        painter.drawText(
            QRectF(0, tick - 8, self.left - 6, 16), flags.AlignRight | flags.AlignVCenter, f"{axis.high:.4g}"
        )

    def _paint_curve(
        self, painter: QPainter, pen: QPen, times: FloatArray, values: FloatArray, floor: float, scale: float
    ) -> None:
        """Draw single samples if they fit, else the extremes of each pixel column; gaps stay open."""
        painter.setPen(pen)
        first, last = np.searchsorted(times, (self.view.start, self.view.end)).tolist()
        part = slice(max(first - 1, 0), last + 1)
        times = times[part]
        values = values[part]
        width = int(self.room)
        if len(times) <= 2 * width:
            self._draw(painter, times, values, floor, scale)
            return
        edges = self.view.start + np.arange(width + 1) / width * self.view.length
        low, high = envelope(times, values, edges)
        middle = (edges[1:] + edges[:-1]) / 2
        if pen.style() is Qt.PenStyle.SolidLine:
            self._draw_extremes(painter, low, high, floor, scale)
        else:  # a dashed line between extremes would be unreadable
            self._draw(painter, middle, high, floor, scale)

    def _draw_extremes(self, painter: QPainter, low: FloatArray, high: FloatArray, floor: float, scale: float) -> None:
        """Draw a vertical line per pixel that meets the previous one; a zigzag polyline takes twenty times as long."""
        before_low = np.r_[np.nan, low[:-1]]
        before_high = np.r_[np.nan, high[:-1]]
        bottom = np.fmin(low, before_high)
        top = np.fmax(high, before_low)
        there = np.flatnonzero(np.isfinite(low))
        lines = [
            QLineF(x, y, x, above)
            for x, y, above in zip(
                (self.left + there + 0.5).tolist(),
                (floor - scale * bottom[there] + 0.5).tolist(),
                (floor - scale * top[there] - 0.5).tolist(),
                strict=True,
            )
        ]
        painter.save()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing, on=False)
        painter.setPen(QPen(painter.pen().color(), 1.0))
        painter.drawLines(lines)
        painter.restore()

    def _draw(self, painter: QPainter, times: FloatArray, values: FloatArray, floor: float, scale: float) -> None:
        xs = self.left + (times - self.view.start) / self.view.length * self.room
        ys = floor - scale * values
        there = np.isfinite(ys)
        for run in np.split(np.flatnonzero(there), np.flatnonzero(np.diff(np.flatnonzero(there)) > 1) + 1):
            points = [QPointF(x, y) for x, y in zip(xs[run].tolist(), ys[run].tolist(), strict=True)]
            painter.drawPolyline(QPolygonF(points))
