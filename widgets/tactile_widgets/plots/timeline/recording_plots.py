"""Curves over a whole recording under the timeline, with a raster of all taxels if the user added it.

They have a cursor, zoom, a range, and a second recording dashed over them.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QEvent, QPoint, QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import (
    QAction,
    QColor,
    QContextMenuEvent,
    QFont,
    QFontMetricsF,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QPen,
    QPixmap,
    QResizeEvent,
    QWheelEvent,
)
from PySide6.QtWidgets import QToolButton, QWidget

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.recording.overview.curves import CURVES
from tactile_widgets.common.colours import PressureScale, Theme
from tactile_widgets.common.make import small_font
from tactile_widgets.plots.timeline.lane_painter import LEFT, LanePainter, Overlaid
from tactile_widgets.plots.timeline.lanes import AddedLane, Lane, standard_lanes
from tactile_widgets.plots.timeline.playhead import Span, clock_text
from tactile_widgets.plots.timeline.scrub_bar import TimelineNotes, paint_times
from tactile_widgets.plots.traces.raster import TaxelRows, columns, paint_ends, raster_image

_RIGHT = 12.0
_TOP = 6.0
_AXIS = 18.0
_GAP = 6.0
_DRAG_PX = 4.0
_ZOOM = 1.25
_LEAST_FRAMES = 20
"""Number of frames shown at maximum zoom."""
_USUAL_HEIGHT = 140
"""Height of the standard lanes to which that of the raster is in proportion [px]."""
_ADDED_HEIGHT = 34
"""Height of an added lane [px]."""
_RASTER_HEIGHT = 110
"""Height of the raster of all taxels [px]."""
_HEADING = 12.0
"""Height of the title above the raster [px]."""
_LOWEST_LANE = 40.0
"""Minimum height of a lane in a figure, with its title [px]."""
_EMPTY = "The curves of the whole recording are being read."


class RecordingPlots(QWidget):
    """Widget with curves over time. Click: go to a time; drag: select a range; wheel: zoom; double-click: show all."""

    time_chosen = Signal(float)
    """The user chose this time [s]."""
    taxel_chosen = Signal(int)
    """The row of this taxel was clicked."""
    range_dragged = Signal(Span)
    """A time span was selected by dragging."""
    view_changed = Signal(Span)
    """Another part of the recording is shown."""
    lanes_changed = Signal()
    """The number of lanes changed, and with it the preferred height."""
    menu_requested = Signal(float, QPoint)
    """A context menu is requested at a time [s] and screen position."""

    def __init__(self, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("recording-plots")
        self.setAccessibleName("Curves of the whole recording")
        self.setMouseTracking(True)
        self.setMinimumWidth(200)
        self._theme = theme
        self._empty = _EMPTY
        self._duration = self._time = 0.0
        self._frame_seconds = 1 / 30
        self._view = Span(0.0, 1.0)
        self._left = LEFT
        self._right = _RIGHT
        self._units = ReadingUnits.CALIBRATED
        self._added = tuple[AddedLane, ...]()
        self._times: FloatArray = np.zeros(0)
        self._values: FloatArray = np.zeros((0, len(CURVES)))
        self._other: Overlaid | None = None
        self._scale = PressureScale()
        self._rows: TaxelRows | None = None  # of the raster, where it is shown
        self._pressures: NDArray[np.float32] = np.zeros((0, 0), np.float32)
        self._range: Span | None = None
        self._notes = TimelineNotes()
        self._picture: QPixmap | None = None  # of the curves, as long as they are unchanged
        self._hover: QPointF | None = None
        self._pressed: float | None = None
        self._panned: float | None = None
        self._dragged = False
        self._choose = QToolButton(self)
        self._choose.setObjectName("recording-plots-choose")
        self._choose.setAutoRaise(True)
        self._choose.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextOnly)
        self._choose.hide()

    def sizeHint(self) -> QSize:
        """Return the preferred size; the width adapts to the layout."""
        return QSize(600, self.minimumHeight())

    def set_theme(self, theme: Theme) -> None:
        """Apply a theme."""
        self._theme = theme
        self._redraw()

    def set_axis(self, left: float, right: float) -> None:
        """Set the space left and right of the lanes [px], so that they share a time axis with the timeline."""
        self._left = max(left, LEFT)
        self._right = max(right, _RIGHT)
        self._redraw()

    def offer(self, choose: QAction) -> None:
        """Add a button for an action at the upper right."""
        self._choose.setDefaultAction(choose)
        self._choose.setText(choose.iconText().split()[0])
        self._choose.show()
        self._place_button()

    def _place_button(self) -> None:
        self._choose.resize(self._choose.sizeHint())
        self._choose.move(self.width() - self._choose.width() - 2, 0)

    # What is shown.

    def show_recording(self, duration: float, frame_seconds: float, units: ReadingUnits) -> None:
        """Show a recording of ``duration`` [s]; its curves follow by ``show_curves``."""
        self._duration = duration
        self._frame_seconds = frame_seconds
        self._time = 0.0
        self._show_view(0.0, self._whole.length)
        self._units = units
        self._notes = TimelineNotes()
        self._range = None
        self._other = None
        self._empty = _EMPTY
        self.show_added(())

    def show_added(self, added: Sequence[AddedLane]) -> None:
        """Draw these lanes below the standard ones, from the columns after ``CURVES``; the curves follow again."""
        self._added = tuple(added)
        self.show_curves(np.zeros(0), np.zeros((0, len(CURVES) + len(added))))
        self.lanes_changed.emit()

    @property
    def added(self) -> tuple[AddedLane, ...]:
        """Lanes that the user added."""
        return self._added

    def show_raster(self, rows: TaxelRows | None) -> None:
        """Draw the raster of these taxels below the lanes, whose pressures follow; None for none."""
        self._rows = rows
        self._pressures = np.zeros((0, 0), np.float32)
        self._redraw()
        self.lanes_changed.emit()

    def show_pressures(self, pressures: NDArray[np.float32]) -> None:
        """Show the highest pressures (spans, taxels) [Pa] in equal spans of the recording; NaN where unknown."""
        self._pressures = pressures
        self._redraw()

    @property
    def raster_shown(self) -> bool:
        """Whether the raster of all taxels is shown."""
        return self._rows is not None

    def set_scale(self, scale: PressureScale) -> None:
        """Set the colours of pressures."""
        self._scale = scale
        self._redraw()

    def preferred_height(self, usual: int) -> int:
        """Return the height of all lanes if the standard ones have ``usual`` [px]."""
        return usual + _ADDED_HEIGHT * len(self._added) + _RASTER_HEIGHT * self.raster_shown

    def set_units(self, units: ReadingUnits) -> None:
        """Set the units of readings and forces."""
        if units is not self._units:
            self._units = units
            self._redraw()

    def show_curves(self, times: FloatArray, values: FloatArray) -> None:
        """Show these curves.

        Args:
            times: (n,) times of frames [s from the first].
            values: (n, len(CURVES) + number of added lanes) values, SI.
        """
        self._times = times
        self._values = values
        self._redraw()

    def show_overlaid(self, other: Overlaid | None) -> None:
        """Draw a second recording dashed over the first; None if there is none."""
        self._other = other
        self._redraw()

    def _redraw(self) -> None:
        """Discard the picture of the curves and repaint."""
        self._picture = None
        self.update()

    def show_message(self, text: str) -> None:
        """Set the text shown in place of missing curves."""
        self._empty = text
        self.update()

    @property
    def missing(self) -> str:
        """Text shown in place of missing curves; empty if there are curves."""
        return "" if len(self._times) else self._empty

    def twin(self, theme: Theme) -> RecordingPlots:
        """Return another widget with the same curves, in another theme and without a button."""
        twin = RecordingPlots(theme)
        twin.show_recording(self._duration, self._frame_seconds, self._units)
        twin.show_added(self._added)
        twin.show_curves(self._times, self._values)
        twin.show_overlaid(self._other)
        twin.show_raster(self._rows)
        twin.show_pressures(self._pressures)
        twin.set_scale(self._scale)
        twin.show_notes(self._notes)
        twin._show_view(self._view.start, self._view.length)
        return twin

    @property
    def smallest(self) -> QSize:
        """Size below which a figure of the lanes is unreadable."""
        raster = _RASTER_HEIGHT * self.raster_shown / self.preferred_height(_USUAL_HEIGHT)
        lanes = len(self._shown_lanes()) * (_LOWEST_LANE + _GAP) / (1 - raster)
        return QSize(self.minimumWidth(), ceil(_TOP + lanes + _AXIS))

    def show_time(self, time: float) -> None:
        """Move the cursor to ``time`` [s]; a zoomed view follows it."""
        self._time = time
        if not self._view.start <= time <= self._view.end:
            length = self._view.length
            self._show_view(time - 0.1 * length, length)
        self.update()

    def show_range(self, span: Span | None) -> None:
        """Show the selected range."""
        self._range = span
        self.update()

    def show_notes(self, notes: TimelineNotes) -> None:
        """Show marks."""
        self._notes = notes
        self.update()

    @property
    def times(self) -> FloatArray:
        """Times (n,) of the frames with curves [s from the first]."""
        return self._times

    @property
    def values(self) -> FloatArray:
        """Values (n, len(CURVES) + number of added lanes) of the frames, SI."""
        return self._values

    @property
    def view(self) -> Span:
        """Shown part of the recording."""
        return self._view

    @property
    def lanes(self) -> tuple[str, ...]:
        """Titles of the drawn lanes, from top to bottom."""
        raster = (self._raster_title,) if self.raster_shown else ()
        return (*(lane.title for lane in self._shown_lanes()), *raster)

    @property
    def _raster_title(self) -> str:
        return f"All taxels ({self._units.unit})"

    # Places.

    @property
    def _whole(self) -> Span:
        return Span(0.0, max(self._duration, self._frame_seconds))

    @property
    def _room(self) -> float:
        button = 0 if self._choose.isHidden() else self._choose.width()
        return max(self.width() - self._left - max(self._right, _RIGHT + button), 1.0)

    def x_of(self, time: float) -> float:
        """Return the x of ``time`` [s] in pixels."""
        return self._left + (time - self._view.start) / self._view.length * self._room

    def time_at(self, x: float) -> float:
        """Return the time [s] at ``x`` [px], clamped to the recording."""
        time = self._view.start + (x - self._left) / self._room * self._view.length
        return min(max(time, 0.0), self._duration)

    @property
    def _raster_box(self) -> QRectF:
        """Place of the image of the raster."""
        bottom = self.height() - _AXIS
        share = _RASTER_HEIGHT / max(self.preferred_height(_USUAL_HEIGHT), 1)
        height = max(share * (bottom - _TOP) - _HEADING, 1.0)
        return QRectF(self._left, bottom - height, self._room, height)

    @property
    def _groups(self) -> int:
        """Number of rows of pixels of the raster, at most one for each taxel."""
        return max(min(int(self._raster_box.height()), self._pressures.shape[1]), 1)

    def taxel_at(self, place: QPointF) -> tuple[int, float, float] | None:
        """Return the taxel of the raster at a position, the time [s] and its pressure there [Pa]; None elsewhere.

        Of several taxels in one row of pixels it is the one with the highest pressure.
        """
        box = self._raster_box
        spans = len(self._pressures)
        if self._rows is None or not spans or not box.contains(place):
            return None
        time = self.time_at(place.x())
        span = min(int(time / self._whole.length * spans), spans - 1)
        taxels = self._rows.taxels((place.y() - box.top()) / box.height(), self._groups)
        values = self._pressures[span, taxels]
        best = int(np.argmax(np.nan_to_num(values, nan=-1.0)))
        return None if np.isnan(values[best]) else (int(taxels[best]), time, float(values[best]))

    def _show_view(self, start: float, length: float) -> None:
        """Show ``length`` seconds from ``start``, clamped to the recording."""
        whole = self._whole
        length = min(max(length, min(_LEAST_FRAMES * self._frame_seconds, whole.length)), whole.length)
        start = min(max(start, 0.0), whole.end - length)
        self._view = Span(start, start + length)
        self.view_changed.emit(self._view)
        self._redraw()

    # Mouse events.

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Start a click or a drag."""
        if event.button() == Qt.MouseButton.LeftButton:
            self._pressed = event.position().x()
            self._dragged = False
        elif event.button() == Qt.MouseButton.MiddleButton:
            self._panned = event.position().x()

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Select a range, pan the view, or show the values under the pointer."""
        self._hover = event.position()
        x = self._hover.x()
        if self._pressed is not None and (self._dragged or abs(x - self._pressed) >= _DRAG_PX):
            self._dragged = True
            self.range_dragged.emit(Span.between(self.time_at(self._pressed), self.time_at(x)))
        if self._panned is not None:
            moved = (self._panned - x) / self._room * self._view.length
            self._panned = x
            self._show_view(self._view.start + moved, self._view.length)
        self.update()

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """Go to the clicked time, or end a drag."""
        if event.button() == Qt.MouseButton.LeftButton and self._pressed is not None:
            if not self._dragged:
                if (found := self.taxel_at(event.position())) is not None:
                    self.taxel_chosen.emit(found[0])
                self.time_chosen.emit(self.time_at(self._pressed))
            self._pressed = None
        elif event.button() == Qt.MouseButton.MiddleButton:
            self._panned = None

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        """Show the whole recording."""
        if event.button() == Qt.MouseButton.LeftButton:
            self._show_view(0.0, self._whole.length)

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Zoom about the pointer."""
        turns = event.angleDelta().y() / 120
        if turns:
            at = self.time_at(event.position().x())
            length = self._view.length * _ZOOM**-turns
            share = (at - self._view.start) / self._view.length
            self._show_view(at - share * length, length)
        event.accept()

    def leaveEvent(self, event: QEvent) -> None:
        """Hide the values under the pointer."""
        self._hover = None
        self.update()

    def contextMenuEvent(self, event: QContextMenuEvent) -> None:
        """Request the menu of the time under the pointer."""
        self.menu_requested.emit(self.time_at(event.pos().x()), event.globalPos())

    # Drawing.

    def resizeEvent(self, _event: QResizeEvent) -> None:
        self._place_button()
        self._redraw()

    def paintEvent(self, _event: QPaintEvent) -> None:
        """Draw the cached picture of the curves, and over it cursor, marks and values."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        caption = small_font(self.font())
        painter.setFont(caption)
        if self.missing:
            painter.setPen(QColor(self._theme.quiet))
            painter.drawText(QRectF(self.rect()), Qt.AlignmentFlag.AlignCenter, self.missing)
            return
        lanes = self._shown_lanes()
        area = self._area
        self._paint_range(painter, area)
        self._paint_marks(painter, area)
        if self._picture is None or self._picture.devicePixelRatio() != self.devicePixelRatio():
            self._picture = self._curves_picture(lanes, caption)
        painter.drawPixmap(0, 0, self._picture)
        self._paint_times(painter, area)
        painter.setPen(QPen(QColor(self._theme.accent), 1.5))
        self._paint_moment(painter, self._time, area)
        if self._hover is not None:
            self._paint_hover(painter, area, lanes)

    def paint_figure(self, painter: QPainter) -> None:
        """Draw curves, marks and times as vectors; without the cursor and the selected range."""
        painter.setFont(small_font(self.font()))
        self._paint_marks(painter, self._area)
        self._paint_lanes(painter, self._shown_lanes())
        self._paint_times(painter, self._area)

    @property
    def _area(self) -> QRectF:
        """Place of all lanes."""
        return QRectF(self._left, _TOP, self._room, self.height() - _TOP - _AXIS)

    def _paint_times(self, painter: QPainter, area: QRectF) -> None:
        paint_times(painter, self._theme, self._view, self._room, self.x_of, (area.bottom(), self.height() - 4))

    def _curves_picture(self, lanes: list[Lane], caption: QFont) -> QPixmap:
        """Return a picture of the lanes with their curves. Cost: 15 ms for ten minutes."""
        ratio = self.devicePixelRatio()
        picture = QPixmap(self.size() * ratio)
        picture.setDevicePixelRatio(ratio)
        picture.fill(Qt.GlobalColor.transparent)
        painter = QPainter(picture)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setFont(caption)
        self._paint_lanes(painter, lanes)
        painter.end()
        return picture

    def _paint_lanes(self, painter: QPainter, lanes: list[Lane]) -> None:
        bottom = self._raster_box.top() - _HEADING - _GAP if self.raster_shown else self.height() - _AXIS
        height = (bottom - _TOP - _GAP * (len(lanes) - 1)) / len(lanes)
        lanes_painter = LanePainter(
            self._theme, self._view, self._left, self._room, self._times, self._values, self._other
        )
        for number, lane in enumerate(lanes):
            lanes_painter.paint(painter, lane, QRectF(self._left, _TOP + number * (height + _GAP), self._room, height))
        if self._rows is not None:
            self._paint_raster(painter, self._rows)

    def _paint_raster(self, painter: QPainter, rows: TaxelRows) -> None:
        """Draw the raster with its title and the ids at its ends. Cost: 20 ms for 4000 taxels."""
        box = self._raster_box
        painter.setPen(QColor(self._theme.quiet))
        painter.drawText(QPointF(box.left() + 4, box.top() - 3), self._raster_title)
        if not len(self._pressures):
            return
        paint_ends(painter, QRectF(0, box.top(), self._left - 6, box.height()), rows.ends)
        spans = len(self._pressures)
        highest = np.fmax.reduceat(self._pressures[:, rows.order], rows.starts(self._groups), axis=1)
        times = self._whole.length * np.arange(spans) / spans
        edges = np.linspace(self._view.start, self._view.end, max(int(box.width()), 1) + 1)
        known = ~np.isnan(highest).all(axis=1)
        picture = columns(times[known], 1e-3 * highest[known], edges)
        painter.drawImage(box, raster_image(picture, self._scale))

    def _shown_lanes(self) -> list[Lane]:
        """Return the lanes with values, and those that are always shown."""
        curves = [self._values] + ([] if self._other is None else [self._other.curves.values])
        standard = [
            lane
            for lane in standard_lanes(self._units)
            if lane.always or any(np.isfinite(part[:, lane.column]).any() for part in curves)
        ]
        return standard + [added.lane(column) for column, added in enumerate(self._added, len(CURVES))]

    def _paint_range(self, painter: QPainter, area: QRectF) -> None:
        if self._range is not None:
            left = self.x_of(self._range.start)
            right = self.x_of(self._range.end)
            shade = QColor(self._theme.accent)
            shade.setAlphaF(0.18)
            painter.fillRect(QRectF(left, area.top(), right - left, area.height()).intersected(area), shade)

    def _paint_marks(self, painter: QPainter, area: QRectF) -> None:
        painter.setPen(QPen(QColor(self._theme.quiet), 1, Qt.PenStyle.DotLine))
        for time, _ in self._notes.marks:
            self._paint_moment(painter, time, area)

    def _paint_moment(self, painter: QPainter, time: float, area: QRectF) -> None:
        x = self.x_of(time)
        if area.left() - 1 <= x <= area.right() + 1:
            painter.drawLine(QPointF(x, area.top()), QPointF(x, area.bottom()))

    @property
    def _taxel_words(self) -> str:
        """Id, time and value of the taxel under the pointer; empty off the raster."""
        found = None if self._hover is None else self.taxel_at(self._hover)
        return "" if found is None or self._rows is None else self._rows.words(*found, self._units)

    def _paint_hover(self, painter: QPainter, area: QRectF, lanes: list[Lane]) -> None:
        """Draw the time and the values under the pointer, and the name of a mark there."""
        assert self._hover is not None
        time = self.time_at(self._hover.x())
        number = int(np.clip(np.searchsorted(self._times, time + 1e-9, side="right") - 1, 0, len(self._times) - 1))
        words = [clock_text(time, decimals=2)]
        for lane in lanes:
            value = lane.factor * float(self._values[number, lane.column])
            if np.isfinite(value):
                words.append(f"{value:.2f}\u202f{lane.unit}")
        words += [name for at, name in self._notes.marks if abs(self.x_of(at) - self._hover.x()) <= _DRAG_PX][:1]
        text = self._taxel_words or "   ".join(words)
        painter.setPen(QColor(self._theme.text))
        self._paint_moment(painter, time, area)
        metrics = QFontMetricsF(painter.font())
        width = metrics.horizontalAdvance(text) + 12
        left = min(max(self.x_of(time) - width / 2, 0.0), self.width() - width)
        box = QRectF(left, self.height() - metrics.height() - 3, width, metrics.height() + 2)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(QColor(self._theme.text))
        painter.drawRoundedRect(box, 4, 4)
        painter.setPen(QColor(self._theme.window))
        painter.drawText(box, Qt.AlignmentFlag.AlignCenter, text)
