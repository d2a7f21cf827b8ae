"""The bar of the timeline: where a recording stands, where pokes are in it, and a hand to move through it."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QEvent, QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QMouseEvent, QPainter, QPaintEvent, QPolygonF
from PySide6.QtWidgets import QWidget

from widgets.colours import Theme
from widgets.timeline.playhead import clock_text, nice_step

SIDE = 10.0
TRACK_Y, TRACK_HEIGHT, MARK_Y, MARK_HEIGHT, LABEL_Y = 19.0, 4.0, 9.0, 4.0, 40.0
HANDLE = 7.0
LABEL_ROOM_PX = 72
_EDIT_REACH_PX = 5.0
"""An edit of the map is named while the pointer is as near to its mark."""


class ScrubBar(QWidget):
    """A recording from left to right. Emits ``scrubbed`` [s] while the hand drags; keys are the timeline's."""

    scrubbed = Signal(float)

    def __init__(self, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._theme = theme
        self._duration = self._time = 0.0
        self._spans: tuple[tuple[float, float], ...] = ()
        self._edits: tuple[tuple[float, str], ...] = ()
        self._hover: float | None = None
        self.held = False
        self.setObjectName("timeline-bar")
        self.setAccessibleName("Position in the recording")
        self.setMouseTracking(True)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setFixedHeight(48)
        self.setMinimumWidth(160)

    def sizeHint(self) -> QSize:
        """Qt: as wide as there is room."""
        return QSize(600, 48)

    def set_theme(self, theme: Theme) -> None:
        """Take another theme."""
        self._theme = theme
        self.update()

    def show_recording(
        self, duration: float, spans: Sequence[tuple[float, float]], edits: Sequence[tuple[float, str]] = ()
    ) -> None:
        """Show a recording of ``duration`` [s] with pokes from and to these times [s], and when the map was edited."""
        self._duration, self._spans, self._edits, self._time = duration, tuple(spans), tuple(edits), 0.0
        self.update()

    def show_time(self, time: float) -> None:
        """Put the handle at ``time`` [s]."""
        self._time = time
        self.setAccessibleDescription(f"{clock_text(time)} of {clock_text(self._duration)}")
        self.update()

    def x_of(self, time: float) -> float:
        """Where ``time`` [s] lies [px]."""
        share = time / self._duration if self._duration > 0 else 0.0
        return SIDE + share * self._room

    def time_at(self, x: float) -> float:
        """The time [s] at ``x`` [px], within the recording."""
        return min(max((x - SIDE) / self._room, 0.0), 1.0) * self._duration

    @property
    def _room(self) -> float:
        return max(self.width() - 2 * SIDE, 1.0)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Qt: take the handle to the pointer."""
        if event.button() == Qt.MouseButton.LeftButton:
            self.held = True
            self._scrub(event.position().x())

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Qt: drag the handle, or show the time under the pointer."""
        self._hover = event.position().x()
        if self.held:
            self._scrub(event.position().x())
        self.update()

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """Qt: let go."""
        if event.button() == Qt.MouseButton.LeftButton:
            self.held = False
            self.update()

    def leaveEvent(self, event: QEvent) -> None:
        """Qt: no time under the pointer."""
        self._hover = None
        self.update()

    def _scrub(self, x: float) -> None:
        time = self.time_at(x)
        self.show_time(time)
        self.scrubbed.emit(time)

    def paintEvent(self, event: QPaintEvent) -> None:
        """Qt: draw marks, track, handle and times."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setFont(self._caption())
        self._paint_labels(painter)
        self._paint_track(painter)
        if self._hover is not None and self._duration > 0:
            self._paint_hover(painter, self._hover)
        painter.end()

    def _caption(self) -> QFont:
        font = QFont(self.font())
        font.setPixelSize(11)
        return font

    def _paint_track(self, painter: QPainter) -> None:
        at = self.x_of(self._time)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(QColor(self._theme.line))
        painter.drawRoundedRect(QRectF(SIDE, TRACK_Y, self._room, TRACK_HEIGHT), 2, 2)
        painter.setBrush(QColor(self._theme.accent))
        painter.drawRoundedRect(QRectF(SIDE, TRACK_Y, at - SIDE, TRACK_HEIGHT), 2, 2)
        painter.setBrush(QColor(self._theme.quiet))
        for start, end in self._spans:
            left, right = self.x_of(start), self.x_of(end)
            painter.drawRoundedRect(QRectF(left, MARK_Y, max(right - left, 2.0), MARK_HEIGHT), 1, 1)
        painter.setBrush(QColor(self._theme.accent))
        for time, _ in self._edits:
            x, y = self.x_of(time), MARK_Y + MARK_HEIGHT / 2
            painter.drawPolygon(QPolygonF([QPointF(x - 4, y), QPointF(x, y - 4), QPointF(x + 4, y), QPointF(x, y + 4)]))
        ring = QColor(self._theme.text if self.hasFocus() or self.held else self._theme.panel)
        painter.setBrush(ring)
        centre = QPointF(at, TRACK_Y + TRACK_HEIGHT / 2)
        painter.drawEllipse(centre, HANDLE + 1.5, HANDLE + 1.5)
        painter.setBrush(QColor(self._theme.accent))
        painter.drawEllipse(centre, HANDLE, HANDLE)

    def _paint_labels(self, painter: QPainter) -> None:
        if self._duration <= 0:
            return
        step = nice_step(self._duration, max(int(self._room / LABEL_ROOM_PX), 1))
        decimals = 1 if step < 1 else 0
        metrics = QFontMetricsF(painter.font())
        for index in range(int(self._duration / step + 1e-9) + 1):
            x, text = self.x_of(index * step), clock_text(index * step, decimals=decimals)
            width = metrics.horizontalAdvance(text)
            painter.setPen(QColor(self._theme.line))
            painter.drawLine(QPointF(x, TRACK_Y + 8), QPointF(x, TRACK_Y + 11))
            painter.setPen(QColor(self._theme.quiet))
            painter.drawText(QPointF(min(max(x - width / 2, 0.0), self.width() - width), LABEL_Y + 2), text)

    def _paint_hover(self, painter: QPainter, x: float) -> None:
        near = [name for time, name in self._edits if abs(self.x_of(time) - x) <= _EDIT_REACH_PX]
        text = "  ".join([clock_text(self.time_at(x), decimals=2), *near[:1]])
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
