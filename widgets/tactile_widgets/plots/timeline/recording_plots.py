"""Curves over a whole recording under the timeline: cursor, zoom, range, and a second recording dashed over it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
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
from tactile_widgets.common.colours import Theme
from tactile_widgets.plots.timeline.lane_painter import LEFT, LanePainter, Overlaid
from tactile_widgets.plots.timeline.lanes import AddedLane, Lane, standard_lanes
from tactile_widgets.plots.timeline.playhead import Span, clock_text, nice_step
from tactile_widgets.plots.timeline.scrub_bar import LABEL_ROOM_PX, TimelineNotes

_RIGHT = 12.0
_TOP = 6.0
_AXIS = 18.0
_GAP = 6.0
_DRAG_PX = 4.0
_ZOOM = 1.25
_LEAST_FRAMES = 20
"""Number of frames shown at maximum zoom."""
_ADDED_HEIGHT = 34
"""Height of an added lane [px]."""
_EMPTY = "The curves of the whole recording are being read."


class RecordingPlots(QWidget):
    """Widget with curves over time. Click: go to a time; drag: select a range; wheel: zoom; double-click: show all."""

    time_chosen = Signal(float)
    """The user chose this time [s]."""
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
        self._range: Span | None = None
        self._notes = TimelineNotes()
        self._picture: QPixmap | None = None  # of the curves, as long as they are unchanged
        self._hover: float | None = None
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

    def preferred_height(self, usual: int) -> int:
        """Return the height of all lanes if the standard ones have ``usual`` [px]."""
        return usual + _ADDED_HEIGHT * len(self._added)

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
        return tuple(lane.title for lane in self._shown_lanes())

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
        x = self._hover = event.position().x()
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
        caption = QFont(self.font())
        caption.setPixelSize(11)
        painter.setFont(caption)
        if not len(self._times):
            painter.setPen(QColor(self._theme.quiet))
            painter.drawText(QRectF(self.rect()), Qt.AlignmentFlag.AlignCenter, self._empty)
            return
        lanes = self._shown_lanes()
        area = QRectF(self._left, _TOP, self._room, self.height() - _TOP - _AXIS)
        self._paint_range(painter, area)
        if self._picture is None or self._picture.devicePixelRatio() != self.devicePixelRatio():
            self._picture = self._curves_picture(lanes, caption)
        painter.drawPixmap(0, 0, self._picture)
        self._paint_times(painter, area)
        painter.setPen(QPen(QColor(self._theme.accent), 1.5))
        self._paint_moment(painter, self._time, area)
        if self._hover is not None:
            self._paint_hover(painter, area, lanes)

    def _curves_picture(self, lanes: list[Lane], caption: QFont) -> QPixmap:
        """Return a picture of the lanes with their curves. Cost: 15 ms for ten minutes."""
        ratio = self.devicePixelRatio()
        picture = QPixmap(self.size() * ratio)
        picture.setDevicePixelRatio(ratio)
        picture.fill(Qt.GlobalColor.transparent)
        painter = QPainter(picture)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setFont(caption)
        height = (self.height() - _TOP - _AXIS - _GAP * (len(lanes) - 1)) / len(lanes)
        lanes_painter = LanePainter(
            self._theme, self._view, self._left, self._room, self._times, self._values, self._other
        )
        for number, lane in enumerate(lanes):
            lanes_painter.paint(painter, lane, QRectF(self._left, _TOP + number * (height + _GAP), self._room, height))
        painter.end()
        return picture

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
        painter.setPen(QPen(QColor(self._theme.quiet), 1, Qt.PenStyle.DotLine))
        for time, _ in self._notes.marks:
            self._paint_moment(painter, time, area)

    def _paint_moment(self, painter: QPainter, time: float, area: QRectF) -> None:
        x = self.x_of(time)
        if area.left() - 1 <= x <= area.right() + 1:
            painter.drawLine(QPointF(x, area.top()), QPointF(x, area.bottom()))

    def _paint_times(self, painter: QPainter, area: QRectF) -> None:
        step = nice_step(self._view.length, max(int(self._room / LABEL_ROOM_PX), 1))
        metrics = QFontMetricsF(painter.font())
        for index in range(int(np.ceil(self._view.start / step)), int(self._view.end / step + 1e-9) + 1):
            x = self.x_of(index * step)
            text = clock_text(index * step, decimals=1 if step < 1 else 0)
            width = metrics.horizontalAdvance(text)
            painter.setPen(QColor(self._theme.line))
            painter.drawLine(QPointF(x, area.bottom()), QPointF(x, area.bottom() + 3))
            painter.setPen(QColor(self._theme.quiet))
            painter.drawText(QPointF(min(max(x - width / 2, 0.0), self.width() - width), self.height() - 4), text)

    def _paint_hover(self, painter: QPainter, area: QRectF, lanes: list[Lane]) -> None:
        """Draw the time and the values under the pointer, and the name of a mark there."""
        assert self._hover is not None
        time = self.time_at(self._hover)
        number = int(np.clip(np.searchsorted(self._times, time + 1e-9, side="right") - 1, 0, len(self._times) - 1))
        words = [clock_text(time, decimals=2)]
        for lane in lanes:
            value = lane.factor * float(self._values[number, lane.column])
            if np.isfinite(value):
                words.append(f"{value:.2f}\u202f{lane.unit}")
        words += [name for at, name in self._notes.marks if abs(self.x_of(at) - self._hover) <= _DRAG_PX][:1]
        text = "   ".join(words)
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
