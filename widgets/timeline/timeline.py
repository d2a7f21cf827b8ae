"""The timeline: what is being recorded, or a recording to play, pause, scrub and step through.

``ScrubBar`` shows where a recording stands and where pokes and edits are in it, and follows the mouse; ``Timeline``
puts buttons, keys and the bar together.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from PySide6.QtCore import QEvent, QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import (
    QColor,
    QFont,
    QFontMetricsF,
    QKeyEvent,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QPalette,
    QPolygonF,
)
from PySide6.QtWidgets import QComboBox, QHBoxLayout, QLabel, QPushButton, QStackedWidget, QWidget

from widgets.common.colours import Theme
from widgets.timeline.playhead import SPEEDS, Playhead, clock_text, nice_step

SIDE = 10.0
TRACK_Y, TRACK_HEIGHT, MARK_Y, MARK_HEIGHT, LABEL_Y = 19.0, 4.0, 9.0, 4.0, 40.0
HANDLE = 7.0
LABEL_ROOM_PX = 72
_EDIT_REACH_PX = 5.0
"""An edit of the map is named while the pointer is as near to its mark."""


_LEAST_DAMAGE_PX = 3.0


@dataclass(frozen=True)
class DamagedSpan:
    """Where a recording has lost something.

    Attributes:
        start: Seconds from its first frame.
        end: The same.
        text: What, for people.
    """

    start: float
    end: float
    text: str


class ScrubBar(QWidget):
    """A recording from left to right. Emits ``scrubbed`` [s] while the user drags; keys are the timeline's."""

    scrubbed = Signal(float)

    def __init__(self, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._theme = theme
        self._duration = self._time = 0.0
        self._spans: tuple[tuple[float, float], ...] = ()
        self._edits: tuple[tuple[float, str], ...] = ()
        self._damage: tuple[DamagedSpan, ...] = ()
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
        self,
        duration: float,
        spans: Sequence[tuple[float, float]],
        edits: Sequence[tuple[float, str]] = (),
        damage: Sequence[DamagedSpan] = (),
    ) -> None:
        """Show a recording of ``duration`` [s].

        Args:
            duration: Of the recording [s].
            spans: From and to which second a finger was on the skin.
            edits: When the map was edited [s], and what each edit was called.
            damage: Where something was lost.
        """
        self._duration, self._time = duration, 0.0
        self._spans, self._edits, self._damage = tuple(spans), tuple(edits), tuple(damage)
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
        painter.setBrush(QColor(self._theme.fault))
        for span in self._damage:
            left, right = self._x_range(span)
            painter.drawRect(QRectF(left, TRACK_Y - 2, right - left, TRACK_HEIGHT + 4))
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

    def _x_range(self, span: DamagedSpan) -> tuple[float, float]:
        """From and to where damage is drawn [px], wide enough to be seen."""
        left, right = self.x_of(max(span.start, 0.0)), self.x_of(min(span.end, self._duration))
        middle, half = (left + right) / 2, max(right - left, _LEAST_DAMAGE_PX) / 2
        return middle - half, middle + half

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
        lost = [span.text for span in self._damage if self._x_range(span)[0] <= x <= self._x_range(span)[1]]
        text = "  ".join([clock_text(self.time_at(x), decimals=2), *near[:1], *lost[:1]])
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


EMPTY = "Press Record to record the session; open a recording to replay it."


class Timeline(QWidget):
    """Shows time and emits what the user asks of it; whoever owns the clock calls ``advance`` or ``set_time``."""

    scrubbed = Signal(float)
    """The position changed, by hand or by playing: seconds from the recording's start."""
    play_toggled = Signal(bool)
    """Playing began or ended."""
    speed_changed = Signal(float)
    """Another speed was chosen, as a multiple of real time."""
    live_requested = Signal()
    """The user wants to leave the recording."""

    def __init__(self, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("timeline")
        self.setAccessibleName("Timeline")
        self._theme = theme
        self._playhead = Playhead(0.0)
        self._replaying = False
        self._recorded: float | None = None
        self._play, self._live = QPushButton("Play", self), QPushButton("Back to live", self)
        self._clock, self._note = QLabel(self), QLabel(self)
        self._bar, self._speed = ScrubBar(theme, self), QComboBox(self)
        self._middle = QStackedWidget(self)
        self._set_up()
        self._lay_out()
        self.set_theme(theme)

    def _set_up(self) -> None:
        self._play.setObjectName("timeline-play")
        self._play.setToolTip("Play or pause the recording (Space)")
        self._play.clicked.connect(self.toggle_play)
        self._live.setObjectName("timeline-live")
        self._live.setToolTip("Leave the recording and go back to the running simulation")
        self._live.clicked.connect(self.live_requested)
        self._clock.setAccessibleName("Time")
        self._clock.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        self._clock.setMinimumWidth(self._clock.fontMetrics().horizontalAdvance("00:00.0 / 00:00.0") + 8)
        self._speed.setObjectName("timeline-speed")
        self._speed.setAccessibleName("Speed")
        self._speed.setToolTip("How fast the recording plays, as a multiple of real time")
        for speed in SPEEDS:
            self._speed.addItem(f"{speed:g}×", speed)
        self._speed.setCurrentIndex(SPEEDS.index(1.0))
        self._speed.currentIndexChanged.connect(self._on_speed_chosen)
        self._bar.scrubbed.connect(self._on_bar_scrubbed)
        self.setFocusProxy(self._bar)

    def _lay_out(self) -> None:
        self._middle.addWidget(self._note)
        self._middle.addWidget(self._bar)
        row = QHBoxLayout(self)
        row.setContentsMargins(12, 4, 12, 4)
        row.setSpacing(8)
        row.addWidget(self._play)
        row.addWidget(self._clock)
        row.addWidget(self._middle, 1)
        row.addWidget(self._speed)
        row.addWidget(self._live)
        self.setFixedHeight(56)

    @property
    def playhead(self) -> Playhead:
        """Where the replay stands."""
        return self._playhead

    def set_theme(self, theme: Theme) -> None:
        """Take another theme."""
        self._theme = theme
        self._bar.set_theme(theme)
        self._show()
        if not self._replaying:
            self.set_live(self._recorded)

    def set_live(self, recording_seconds: float | None) -> None:
        """Show the running session; ``recording_seconds`` of it are kept so far, None when it is not recorded."""
        self._stop()
        self._replaying, self._recorded = False, recording_seconds
        roles = QPalette.ColorRole
        self._note.setForegroundRole(roles.PlaceholderText if recording_seconds is None else roles.WindowText)
        if recording_seconds is None:
            self._note.setText(EMPTY)
        else:
            dot = f'<span style="color:{QColor(self._theme.fault).name()}">●</span>'
            self._note.setText(f"{dot}&nbsp; Recording &nbsp;{clock_text(recording_seconds)}")
        self._show()

    def set_recording(
        self,
        duration: float,
        poke_spans: Sequence[tuple[float, float]],
        *,
        edits: Sequence[tuple[float, str]] = (),
        damage: Sequence[DamagedSpan] = (),
        frame_seconds: float = 1 / 30,
    ) -> None:
        """Show a recording from its start, paused.

        Args:
            duration: Of the recording [s].
            poke_spans: From and to which second each poke lasted.
            edits: When the map was edited [s], and what each edit was called.
            damage: Where something was lost.
            frame_seconds: Time between two frames [s]; what Left and Right step.
        """
        self._stop()
        self._replaying = True
        self._playhead = Playhead(duration, frame_seconds, speed=self._playhead.speed)
        self._bar.show_recording(duration, poke_spans, edits, damage)
        self._show()

    def set_time(self, time: float) -> None:
        """Stand at ``time`` [s] without emitting anything."""
        self._playhead = self._playhead.at(time)
        self._show()

    def advance(self, elapsed: float) -> None:
        """Let ``elapsed`` wall seconds pass: while playing, moves and emits ``scrubbed``; a held bar does not move."""
        if self._playhead.playing and not self._bar.held:
            self._become(self._playhead.advanced(elapsed))

    def toggle_play(self) -> None:
        """Play or pause; from the end, start over."""
        if self._replaying:
            self._become(self._playhead.toggled())

    def _become(self, playhead: Playhead) -> None:
        before, self._playhead = self._playhead, playhead
        self._show()
        if playhead.time != before.time:
            self.scrubbed.emit(playhead.time)
        if playhead.playing != before.playing:
            self.play_toggled.emit(playhead.playing)

    def _stop(self) -> None:
        if self._playhead.playing:
            self._become(replace(self._playhead, playing=False))

    def _on_bar_scrubbed(self, time: float) -> None:
        self._become(self._playhead.at(time))

    def _on_speed_chosen(self, index: int) -> None:
        self._playhead = replace(self._playhead, speed=SPEEDS[index])
        self.speed_changed.emit(self._playhead.speed)

    def _show(self) -> None:
        head = self._playhead
        self._middle.setCurrentWidget(self._bar if self._replaying else self._note)
        for widget in (self._play, self._clock, self._speed, self._live):
            widget.setVisible(self._replaying)
        self._play.setText("Pause" if head.playing else "Play")
        self._clock.setText(f"{clock_text(head.time)} / {clock_text(head.duration)}")
        self._bar.show_time(head.time)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Qt: Left and Right step (Shift: ten frames), Home and End jump, Space plays and pauses."""
        frames = 10 if event.modifiers() & Qt.KeyboardModifier.ShiftModifier else 1
        moves = {
            Qt.Key.Key_Left: lambda head: head.stepped(-frames),
            Qt.Key.Key_Right: lambda head: head.stepped(frames),
            Qt.Key.Key_Home: lambda head: head.at(0.0),
            Qt.Key.Key_End: lambda head: head.at(head.duration),
            Qt.Key.Key_Space: Playhead.toggled,
        }
        move = moves.get(Qt.Key(event.key()))
        if move is None or not self._replaying:
            super().keyPressEvent(event)
        else:
            self._become(move(self._playhead))
