"""Timeline that shows the running recording, or plays, pauses, scrubs, loops and steps through a stored one.

``Timeline`` combines buttons, keys and the ``ScrubBar``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from PySide6.QtCore import QPoint, Qt, Signal
from PySide6.QtGui import QColor, QContextMenuEvent, QKeyEvent
from PySide6.QtWidgets import QComboBox, QLabel, QStackedWidget, QWidget

from tactile_maps.core.errors import counted
from tactile_widgets.common.colours import Theme
from tactile_widgets.common.make import add_items, make, push_button, row_layout, select_data, value_label
from tactile_widgets.plots.timeline.playhead import SPEEDS, Playhead, Span, clock_text
from tactile_widgets.plots.timeline.scrub_bar import SIDE, DamagedSpan, ScrubBar, TimelineNotes


class Timeline(QWidget):
    """Widget that shows time and emits the user's requests; the clock's owner calls ``advance`` or ``set_time``.

    It takes no space while nothing is recorded or replayed.
    """

    scrubbed = Signal(float)
    """The user or playback changed the position [s from the recording's start]."""
    play_toggled = Signal(bool)
    """Playback started or stopped."""
    live_requested = Signal()
    """The user requested to leave the recording."""
    range_changed = Signal(Span)
    """Selected time span of the recording; None without one."""
    notes_shown = Signal(TimelineNotes)
    """Other notes are shown."""
    loop_changed = Signal(bool)
    """Looping the range was switched on or off."""
    axis_changed = Signal(float, float)
    """The space left and right of the time axis [px] changed."""
    menu_requested = Signal(float, QPoint)
    """A context menu is requested on the bar: the time there [s], and the screen position."""

    def __init__(self, theme: Theme, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setObjectName("timeline")
        self.setAccessibleName("Timeline")
        self._theme = theme
        self._playhead = Playhead(0.0)
        self._replaying = False
        self._recorded: float | None = None
        self._range: Span | None = None
        self._marks = 0
        tip = "Play or pause the recording"
        self._play = push_button(self, "timeline-play", "Play", tip, self.toggle_play)
        tip = "Leave the recording and go back to the running simulation"
        self._live = push_button(self, "timeline-live", "Back to live", tip, self.live_requested)
        self._clock = value_label("", self, right=True, accessibleName="Time")
        self._clock.setMinimumWidth(self._clock.fontMetrics().horizontalAdvance("00:00.0 / 00:00.0") + 8)
        self._note = QLabel(self)
        self._bar = ScrubBar(theme, self)
        tip = "How fast the recording plays, as a multiple of real time"
        self._speed = make(QComboBox, self, objectName="timeline-speed", accessibleName="Speed", toolTip=tip)
        add_items(self._speed, ((f"{speed:g}×", speed, "") for speed in SPEEDS))
        select_data(self._speed, 1.0)
        self._speed.currentIndexChanged.connect(self._on_speed_chosen)
        self._middle = QStackedWidget(self)
        self._bar.scrubbed.connect(self._on_bar_scrubbed)
        self._bar.range_dragged.connect(self.set_range)
        self._bar.menu_requested.connect(self.menu_requested)
        self._bar.resized.connect(self._on_bar_resized)
        self._lay_out()
        self.set_theme(theme)

    def _lay_out(self) -> None:
        self._middle.addWidget(self._note)
        self._middle.addWidget(self._bar)
        parts = (self._play, self._clock, self._middle, self._speed, self._live)
        row_layout(*parts, parent=self, stretch=self._middle, margins=(12, 4, 12, 4))
        self.setFixedHeight(56)

    def _on_bar_resized(self) -> None:
        left = self._bar.mapTo(self, QPoint(0, 0)).x()
        self.axis_changed.emit(left + SIDE, self.width() - left - self._bar.width() + SIDE)

    @property
    def playhead(self) -> Playhead:
        """Position of the replay."""
        return self._playhead

    def set_theme(self, theme: Theme) -> None:
        """Apply a theme."""
        self._theme = theme
        self._bar.set_theme(theme)
        self._show()
        if not self._replaying:
            self.set_live(self._recorded, marks=self._marks)

    def set_live(self, recording_seconds: float | None, *, marks: int = 0) -> None:
        """Show the running session.

        Args:
            recording_seconds: Recorded duration so far [s]; None if the session is not being recorded.
            marks: Number of marks in the recording.
        """
        self._stop()
        self.set_range(None)
        self._replaying = False
        self._recorded = recording_seconds
        self._marks = marks
        if recording_seconds is not None:
            dot = f'<span style="color:{QColor(self._theme.fault).name()}">●</span>'
            count = f" &nbsp; {counted(marks, 'mark')}" if marks else ""
            self._note.setText(f"{dot}&nbsp; Recording &nbsp;{clock_text(recording_seconds)}{count}")
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
            duration: Duration of the recording [s].
            poke_spans: Start and end of each poke [s].
            edits: Time [s] and name of each map edit.
            damage: Spans in which data were lost.
            frame_seconds: Time between two frames [s], also the step of Left and Right.
        """
        self._stop()
        self._replaying = True
        self._playhead = Playhead(duration, frame_seconds, speed=self._playhead.speed)
        self._bar.show_recording(duration, poke_spans, edits, damage)
        self.show_notes(TimelineNotes())
        self.set_range(None)
        self._show()

    def show_view(self, view: Span | None) -> None:
        """Show a part of the recording on the bar; None for the whole."""
        self._bar.show_view(view)

    def show_notes(self, notes: TimelineNotes) -> None:
        """Show marks and episodes."""
        self._bar.show_notes(notes)
        self.notes_shown.emit(notes)

    @property
    def range(self) -> Span | None:
        """Selected part of the recording; None if there is none."""
        return self._range

    def set_range(self, span: Span | None) -> None:
        """Select a part of the recording, at least one frame long; None for no selection, which ends a loop."""
        if span is not None:
            span = Span.between(max(span.start, 0.0), min(span.end, self._playhead.duration))
        if span is not None and span.length < self._playhead.frame_seconds:
            span = None
        if span == self._range:
            return
        self._range = span
        if self._playhead.loop is not None:
            self._playhead = replace(self._playhead, loop=span)
        self._bar.show_range(span)
        self.range_changed.emit(span)

    def set_loop(self, *, on: bool) -> None:
        """Repeat the selected range, or play to the end."""
        self._playhead = replace(self._playhead, loop=self._range if on else None)
        self.loop_changed.emit(self._playhead.loop is not None)

    def go_to(self, time: float) -> None:
        """Move to ``time`` [s] as if the user had scrubbed there."""
        if self._replaying:
            self._become(self._playhead.at(time))

    def set_time(self, time: float) -> None:
        """Move to ``time`` [s] without emitting signals."""
        self._playhead = self._playhead.at(time)
        self._show()

    def advance(self, elapsed: float) -> None:
        """Advance by ``elapsed`` wall time [s] and emit ``scrubbed`` if playing and the bar is not held."""
        if self._playhead.playing and not self._bar.held:
            self._become(self._playhead.advanced(elapsed))

    def toggle_play(self) -> None:
        """Play or pause; playing from the end starts over."""
        if self._replaying:
            self._become(self._playhead.toggled())

    def _become(self, playhead: Playhead) -> None:
        before = self._playhead
        self._playhead = playhead
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

    def _show(self) -> None:
        head = self._playhead
        self.setHidden(not self._replaying and self._recorded is None)
        self._middle.setCurrentWidget(self._bar if self._replaying else self._note)
        for widget in (self._play, self._clock, self._speed, self._live):
            widget.setVisible(self._replaying)
        self._play.setText("Pause" if head.playing else "Play")
        self._clock.setText(f"{clock_text(head.time)} / {clock_text(head.duration)}")
        self._bar.show_time(head.time)

    def contextMenuEvent(self, event: QContextMenuEvent) -> None:
        """Request the menu of the moment being recorded; during a replay, the bar requests its own menu."""
        if not self._replaying:
            self.menu_requested.emit(0.0, event.globalPos())

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Step with Left and Right (Shift: ten frames), jump with Home and End, play and pause with Space."""
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
