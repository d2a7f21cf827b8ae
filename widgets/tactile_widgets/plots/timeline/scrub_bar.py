"""Bar of the timeline: position in the recording, events and notes, with mouse interaction."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import ceil

from PySide6.QtCore import QEvent, QPoint, QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import (
    QColor,
    QContextMenuEvent,
    QFontMetricsF,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QPen,
    QPolygonF,
    QResizeEvent,
)
from PySide6.QtWidgets import QWidget

from tactile_widgets.common.colours import Theme
from tactile_widgets.common.make import small_font
from tactile_widgets.plots.timeline.playhead import Span, clock_text, nice_step

SIDE = 10.0
TRACK_Y = 19.0
TRACK_HEIGHT = 4.0
MARK_Y = 9.0
MARK_HEIGHT = 4.0
LABEL_Y = 40.0
HANDLE = 7.0
_EPISODE_Y = TRACK_Y + TRACK_HEIGHT + 1.5
_EPISODE_HEIGHT = 3.0
_SLIP_HEIGHT = 3.0
_SLIP_Y = TRACK_Y - _SLIP_HEIGHT - 1.5
_RANGE_TOP = MARK_Y - 2
_RANGE_BOTTOM = _EPISODE_Y + _EPISODE_HEIGHT + 1
_LABEL_ROOM_PX = 72
_EDIT_REACH_PX = 5.0
"""Maximum distance from the pointer at which a mark or a map edit shows its name."""

_LEAST_DAMAGE_PX = 3.0


@dataclass(frozen=True)
class DamagedSpan:
    """Part of a recording in which data were lost.

    Attributes:
        start: Start [s from the first frame].
        end: End [s from the first frame].
        text: Description for the user.
    """

    start: float
    end: float
    text: str


@dataclass(frozen=True)
class TimelineNotes:
    """Notes of the user on a recording, and slip in it.

    Attributes:
        marks: Time [s] and name of each mark.
        episodes: Start [s], end [s] and name of each episode.
        slips: Start [s], end [s] and text of each slip of a contact; incipient slip has no duration.
    """

    marks: tuple[tuple[float, str], ...] = ()
    episodes: tuple[tuple[float, float, str], ...] = ()
    slips: tuple[tuple[float, float, str], ...] = ()


def paint_times(
    painter: QPainter,
    theme: Theme,
    view: Span,
    room: float,
    x_of: Callable[[float], float],
    heights: tuple[float, float],
) -> None:
    """Paint ticks and times below an axis.

    Args:
        painter: Paints on a widget.
        theme: Colours.
        view: Part of the recording that is shown [s].
        room: Width of the axis [px].
        x_of: Returns the horizontal position of a time [px].
        heights: Vertical positions of the ticks and of the text [px].
    """
    tick, baseline = heights
    step = nice_step(view.length, max(int(room / _LABEL_ROOM_PX), 1))
    metrics = QFontMetricsF(painter.font())
    for index in range(ceil(view.start / step), int(view.end / step + 1e-9) + 1):
        x = x_of(index * step)
        text = clock_text(index * step, decimals=1 if step < 1 else 0)
        width = metrics.horizontalAdvance(text)
        painter.setPen(QColor(theme.line))
        painter.drawLine(QPointF(x, tick), QPointF(x, tick + 3))
        painter.setPen(QColor(theme.quiet))
        right = painter.device().width() - width
        painter.drawText(QPointF(min(max(x - width / 2, 0.0), right), baseline), text)


class ScrubBar(QWidget):
    """Bar with the recording from left to right. Emits ``scrubbed`` [s] during drags; the timeline handles keys."""

    scrubbed = Signal(float)
    range_dragged = Signal(Span)
    """A time span was selected by dragging with Shift; None if it is too short."""
    resized = Signal()
    """The bar has another size or place."""
    menu_requested = Signal(float, QPoint)
    """A context menu is requested at a time [s] and screen position."""

    def __init__(self, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._theme = theme
        self._duration = self._time = 0.0
        self._spans: tuple[tuple[float, float], ...] = ()
        self._edits: tuple[tuple[float, str], ...] = ()
        self._damage: tuple[DamagedSpan, ...] = ()
        self._zoomed: Span | None = None
        self._notes = TimelineNotes()
        self._range: Span | None = None
        self._dragged_from: float | None = None
        self._hover: float | None = None
        self.held = False
        self.setObjectName("timeline-bar")
        self.setAccessibleName("Position in the recording")
        self.setMouseTracking(True)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setFixedHeight(48)
        self.setMinimumWidth(160)

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self.resized.emit()

    def sizeHint(self) -> QSize:
        """Return the preferred size; the width adapts to the layout."""
        return QSize(600, 48)

    def set_theme(self, theme: Theme) -> None:
        """Apply a theme."""
        self._theme = theme
        self.update()

    def show_recording(
        self,
        duration: float,
        spans: Sequence[tuple[float, float]],
        edits: Sequence[tuple[float, str]] = (),
        damage: Sequence[DamagedSpan] = (),
    ) -> None:
        """Show a recording of ``duration`` [s].

        Args:
            duration: Duration of the recording [s].
            spans: Start and end of each time a finger was on the skin [s].
            edits: Time [s] and name of each map edit.
            damage: Spans in which data were lost.
        """
        self._duration = duration
        self._time = 0.0
        self._spans = tuple(spans)
        self._edits = tuple(edits)
        self._damage = tuple(damage)
        self.show_view(None)

    def show_notes(self, notes: TimelineNotes) -> None:
        """Show marks and episodes."""
        self._notes = notes
        self.update()

    def show_range(self, span: Span | None) -> None:
        """Show the range selected to be looped, cut out or labelled; None if there is none."""
        self._range = span
        self.update()

    def show_view(self, view: Span | None) -> None:
        """Show a part of the recording; None for the whole."""
        self._zoomed = view
        self.update()

    @property
    def _view(self) -> Span:
        return self._zoomed or Span(0.0, max(self._duration, 1e-9))

    def show_time(self, time: float) -> None:
        """Move the handle to ``time`` [s]."""
        self._time = time
        self.setAccessibleDescription(f"{clock_text(time)} of {clock_text(self._duration)}")
        self.update()

    def x_of(self, time: float) -> float:
        """Return the x of ``time`` [s] in pixels."""
        return SIDE + (time - self._view.start) / self._view.length * self._room

    def time_at(self, x: float) -> float:
        """Return the time [s] at ``x`` [px], clamped to the part of the recording that is shown."""
        share = min(max((x - SIDE) / self._room, 0.0), 1.0)
        return min(self._view.start + share * self._view.length, self._duration)

    @property
    def _room(self) -> float:
        return max(self.width() - 2 * SIDE, 1.0)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Move the handle to the pointer, or with Shift start a range."""
        if event.button() != Qt.MouseButton.LeftButton:
            return
        if event.modifiers() & Qt.KeyboardModifier.ShiftModifier:
            self._dragged_from = self.time_at(event.position().x())
            return
        self.held = True
        self._scrub(event.position().x())

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Drag the handle or a range, or show the time under the pointer."""
        self._hover = event.position().x()
        if self.held:
            self._scrub(event.position().x())
        if self._dragged_from is not None:
            self.range_dragged.emit(Span.between(self._dragged_from, self.time_at(self._hover)))
        self.update()

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """End the drag."""
        if event.button() == Qt.MouseButton.LeftButton:
            self.held = False
            self._dragged_from = None
            self.update()

    def contextMenuEvent(self, event: QContextMenuEvent) -> None:
        """Request the menu of the time under the pointer."""
        self.menu_requested.emit(self.time_at(event.pos().x()), event.globalPos())

    def leaveEvent(self, event: QEvent) -> None:
        """Hide the time under the pointer."""
        self._hover = None
        self.update()

    def _scrub(self, x: float) -> None:
        time = self.time_at(x)
        self.show_time(time)
        self.scrubbed.emit(time)

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw times, range, track, handle and notes."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setFont(small_font(self.font()))
        self._paint_labels(painter)
        painter.setClipRect(QRectF(SIDE - HANDLE, 0, self._room + 2 * HANDLE, self.height()))
        self._paint_range(painter)
        self._paint_track(painter)
        self._paint_notes(painter)
        painter.setClipping(False)
        if self._hover is not None and self._duration > 0:
            self._paint_hover(painter, self._hover)
        painter.end()

    def _paint_track(self, painter: QPainter) -> None:
        at = self.x_of(self._time)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(QColor(self._theme.line))
        painter.drawRoundedRect(QRectF(SIDE, TRACK_Y, self._room, TRACK_HEIGHT), 2, 2)
        painter.setBrush(QColor(self._theme.accent))
        played = min(max(at - SIDE, 0.0), self._room)
        painter.drawRoundedRect(QRectF(SIDE, TRACK_Y, played, TRACK_HEIGHT), 2, 2)
        painter.setBrush(QColor(self._theme.fault))
        for span in self._damage:
            left, right = self._x_range(span)
            painter.drawRect(QRectF(left, TRACK_Y - 2, right - left, TRACK_HEIGHT + 4))
        painter.setBrush(QColor(self._theme.quiet))
        for start, end in self._spans:
            left = self.x_of(start)
            right = self.x_of(end)
            painter.drawRoundedRect(QRectF(left, MARK_Y, max(right - left, 2.0), MARK_HEIGHT), 1, 1)
        painter.setBrush(QColor(self._theme.accent))
        for time, _ in self._edits:
            x = self.x_of(time)
            y = MARK_Y + MARK_HEIGHT / 2
            painter.drawPolygon(QPolygonF([QPointF(x - 4, y), QPointF(x, y - 4), QPointF(x + 4, y), QPointF(x, y + 4)]))
        self._paint_handle(painter, at)

    def _paint_handle(self, painter: QPainter, at: float) -> None:
        ring = QColor(self._theme.text if self.hasFocus() or self.held else self._theme.panel)
        painter.setBrush(ring)
        centre = QPointF(at, TRACK_Y + TRACK_HEIGHT / 2)
        painter.drawEllipse(centre, HANDLE + 1.5, HANDLE + 1.5)
        painter.setBrush(QColor(self._theme.accent))
        painter.drawEllipse(centre, HANDLE, HANDLE)

    def _paint_range(self, painter: QPainter) -> None:
        if self._range is None:
            return
        left = self.x_of(self._range.start)
        right = self.x_of(self._range.end)
        shade = QColor(self._theme.accent)
        shade.setAlphaF(0.22)
        painter.fillRect(QRectF(left, _RANGE_TOP, right - left, _RANGE_BOTTOM - _RANGE_TOP), shade)
        painter.setPen(QPen(QColor(self._theme.accent), 1.5))
        for x in (left, right):
            painter.drawLine(QPointF(x, _RANGE_TOP), QPointF(x, _RANGE_BOTTOM))

    def _paint_notes(self, painter: QPainter) -> None:
        """Draw episodes as bars under the track with gaps between them, slips and flags of marks above it."""
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(QColor(self._theme.quiet))
        for start, end, _ in self._notes.episodes:
            left = self.x_of(start) + 1
            right = self.x_of(end) - 1
            painter.drawRect(QRectF(left, _EPISODE_Y, max(right - left, 2.0), _EPISODE_HEIGHT))
        painter.setBrush(QColor(self._theme.warning))
        for start, end, _ in self._notes.slips:
            left = self.x_of(start)
            painter.drawRect(QRectF(left, _SLIP_Y, max(self.x_of(end) - left, 2.0), _SLIP_HEIGHT))
        painter.setBrush(QColor(self._theme.text))
        for time, _ in self._notes.marks:
            x = self.x_of(time)
            painter.drawRect(QRectF(x - 0.5, 1, 1, TRACK_Y - 1))
            painter.drawPolygon(QPolygonF([QPointF(x, 0.5), QPointF(x + 7, 3.5), QPointF(x, 6.5)]))

    def _x_range(self, span: DamagedSpan) -> tuple[float, float]:
        """Return the ends of a damaged span [px], at least ``_LEAST_DAMAGE_PX`` apart."""
        left = self.x_of(max(span.start, 0.0))
        right = self.x_of(min(span.end, self._duration))
        middle = (left + right) / 2
        half = max(right - left, _LEAST_DAMAGE_PX) / 2
        return middle - half, middle + half

    def _paint_labels(self, painter: QPainter) -> None:
        if self._duration > 0:
            paint_times(painter, self._theme, self._view, self._room, self.x_of, (TRACK_Y + 8, LABEL_Y + 2))

    def _paint_hover(self, painter: QPainter, x: float) -> None:
        moments = (*self._notes.marks, *self._edits)
        near = [name for time, name in moments if abs(self.x_of(time) - x) <= _EDIT_REACH_PX]
        near += [name for start, end, name in self._notes.episodes if start <= self.time_at(x) <= end]
        edge = _EDIT_REACH_PX
        slips = (
            text for start, end, text in self._notes.slips if self.x_of(start) - edge <= x <= self.x_of(end) + edge
        )
        near += list(dict.fromkeys(slips))
        lost = [span.text for span in self._damage if self._x_range(span)[0] <= x <= self._x_range(span)[1]]
        text = "  ".join([clock_text(self.time_at(x), decimals=2), *near[:2], *lost[:1]])
        text = painter.fontMetrics().elidedText(text, Qt.TextElideMode.ElideRight, self.width() - 12)
        metrics = QFontMetricsF(painter.font())
        width = metrics.horizontalAdvance(text) + 12
        x = self.x_of(self.time_at(x))
        painter.setPen(QColor(self._theme.text))
        painter.drawLine(QPointF(x, TRACK_Y - 4), QPointF(x, TRACK_Y + TRACK_HEIGHT + 4))
        left = min(max(x - width / 2, 0.0), self.width() - width)
        box = QRectF(left, LABEL_Y - metrics.ascent() - 1, width, metrics.height() + 3)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(QColor(self._theme.text))
        painter.drawRoundedRect(box, 4, 4)
        painter.setPen(QColor(self._theme.window))
        painter.drawText(box, Qt.AlignmentFlag.AlignCenter, text)
