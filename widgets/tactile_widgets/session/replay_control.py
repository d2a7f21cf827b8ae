"""Replay of a recording in the window: show, seek, leave, or continue the simulation from one of its frames."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from typing import Protocol

from PySide6.QtCore import QObject, QTimer, Signal

from tactile_maps.core.errors import RecordingError, TactileMapsError
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.recording.verify import Resimulation
from tactile_maps.scene.scene import Scene
from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.session.runtime_settings import RuntimeSettings
from tactile_maps.session.session import Session
from tactile_widgets.session.session_run import Replay, SessionRun

_SLICE = 0.03
"""Wall time of work [s] after which events of the window are handled."""


class ReplayHost(Protocol):
    """Part of the session host that a replay uses."""

    @property
    def run(self) -> SessionRun | None:
        """The running session, or the one paused behind a recording; None before the first."""

    def begin_replay(self, prepared: PreparedScene) -> None:
        """Show the scene of a recording instead of the running session."""

    def end_replay(self, *, paused: bool) -> None:
        """Show the running session again, paused or not."""

    def set_replayed(self, frame: Frame, settings: RuntimeSettings) -> None:
        """Show a frame of the recording, with its settings."""

    def report_frame(self, frame: Frame, passed: tuple[Frame, ...] | None) -> None:
        """Report the frame that is shown, and the frames since the previous one; None if it does not follow that."""

    @property
    def admit(self) -> Callable[[Callable[[], None], Scene | None], None]:
        """Calls a function that replaces what is shown, at once or later."""

    def run_session(self, session: Session) -> None:
        """Run a session instead of the previous one."""

    def report_progress(self, stage: str, fraction: float) -> None:
        """Show the progress of a long operation."""

    def end_progress(self) -> None:
        """Hide the progress."""

    def report_failure(self, text: str) -> None:
        """Show the user that something failed."""


class ReplayControl(QObject):
    """Shows a recording instead of the running session.

    Args:
        host: The window's session.
        parent: Qt parent.

    Attributes:
        current: The recording that is shown, and the position in it; None while the running session is shown.
    """

    player_changed = Signal(object)
    """The RecordingPlayer being replayed, or None."""
    map_changed = Signal(TactileMap)
    """The current map of the replay, after a recorded edit."""
    jumped = Signal()
    """The next frame does not follow the one shown before."""
    taken_over = Signal(float, bool)
    """The simulation continues from this time of a recording [s since its first frame].

    True if its state is the recorded one bit for bit.
    """

    def __init__(self, host: ReplayHost, parent: QObject) -> None:
        super().__init__(parent)
        self._host = host
        self.current: Replay | None = None
        self._was_paused = False  # the running session, before the replay
        self._take_over: TakeOver | None = None

    @property
    def player(self) -> RecordingPlayer | None:
        """The player of the recording that is shown; None while the running session is shown."""
        return None if self.current is None else self.current.player

    @property
    def taking_over(self) -> bool:
        """Whether the recording is simulated up to the frame that is shown."""
        return self._take_over is not None

    def show(self, player: RecordingPlayer) -> None:
        """Replay a recording from its start; the running session is paused."""
        if self.current is None and (run := self._host.run) is not None:
            self._was_paused = run.runner.paused
            run.runner.paused = True
        self.current = Replay(player)
        self._host.begin_replay(player.prepared)
        self.player_changed.emit(player)
        self.seek(0.0)

    def seek(self, seconds: float) -> None:
        """Show the frame at ``seconds`` from the start of the recording."""
        if (replay := self.current) is None:
            return
        before = replay.settings.map
        try:
            frame = replay.seek(seconds)
        except TactileMapsError as error:
            self._host.report_failure(str(error))
            return
        if frame is None:
            return
        self._host.set_replayed(frame, replay.settings)
        if replay.settings.map is not before:
            self.map_changed.emit(replay.settings.map)
        if replay.passed is None:
            self.jumped.emit()
        self._host.report_frame(frame, replay.passed)

    def leave(self) -> None:
        """Return to the running session, paused or not as before the replay."""
        if self.current is None:
            return
        self.discard()
        self._host.end_replay(paused=self._was_paused)

    def discard(self) -> None:
        """End the replay for something else that will be shown."""
        self.cancel_take_over()
        if self.current is not None:
            self.current = None
            self.player_changed.emit(None)

    def take_over(self) -> None:
        """Continue the simulation from the frame that is shown; this ends the previous session."""
        replay = self.current
        if replay is None or replay.frame is None or self._take_over is not None:
            return
        try:
            take_over = TakeOver(replay.player, replay.frame, self)
        except TactileMapsError as error:
            self._host.report_failure(str(error))
            return
        self._take_over = take_over
        take_over.progressed.connect(self._on_progressed)
        take_over.done.connect(self._on_done)
        take_over.failed.connect(self._on_failed)

    def cancel_take_over(self) -> None:
        """Stop simulating up to the frame that is shown."""
        take_over = self._take_over
        self._take_over = None
        if take_over is not None:
            take_over.close()
            self._host.end_progress()

    def _on_progressed(self, fraction: float) -> None:
        self._host.report_progress("Simulating up to here", fraction)

    def _on_failed(self, text: str) -> None:
        self._take_over = None
        self._host.end_progress()
        self._host.report_failure(text)

    def _on_done(self, session: Session, seconds: float, same: bool) -> None:
        self._host.admit(partial(self._continue, session, seconds, same), None)

    def _continue(self, session: Session, seconds: float, same: bool) -> None:
        self._take_over = None
        self._host.end_progress()
        self._host.run_session(session)
        self.taken_over.emit(seconds, same)


class TakeOver(QObject):
    """Simulates a recording again up to one of its frames. Mutable; ``close`` stops it.

    Args:
        player: The player of the recording.
        frame: The frame from which the simulation continues.
        parent: Qt parent.

    Raises:
        RecordingError: The readings were measured, so there is nothing to simulate.

    Cost: about a tenth of the recorded time, in slices between which the window handles events.
    """

    progressed = Signal(float)
    """Fraction done, 0 to 1."""
    done = Signal(object, float, bool)
    """The Session at that frame, the time of the frame [s since the first], and whether both are equal bit for bit."""
    failed = Signal(str)
    """Reason why the frame cannot be reached."""

    def __init__(self, player: RecordingPlayer, frame: Frame, parent: QObject) -> None:
        super().__init__(parent)
        if player.measured is not None:
            raise RecordingError(
                "measured readings cannot be continued by a simulation",
                file=player.path,
                value=player.measured,
                remedy="Open its robot and connect the skin again",
            )
        self._seconds = player.seconds_at(frame.tick)
        self._again = Resimulation(player)
        self._frame = frame
        self._timer = QTimer(self)
        self._timer.timeout.connect(self._on_timer)
        self._timer.start(0)

    def close(self) -> None:
        """Stop the simulation."""
        self._timer.stop()
        self.deleteLater()

    def _on_timer(self) -> None:
        until = time.perf_counter() + _SLICE
        last = self._frame.tick
        try:
            while time.perf_counter() < until:
                now = self._again.session.frame.tick
                if now >= last:
                    self._finish()
                    return
                if self._again.frame(now + 1).tick == now:
                    raise RecordingError("the session stopped before this frame", value=f"tick {now}")
        except TactileMapsError as error:
            self.close()
            self.failed.emit(str(error))
            return
        self.progressed.emit(self._again.session.frame.tick / max(last, 1))

    def _finish(self) -> None:
        self.close()
        frame = self._again.session.frame
        recorded = self._frame
        same = all(
            getattr(frame, name).tobytes() == getattr(recorded, name).tobytes() for name in ("posture", "velocity")
        )
        self._again.session.continue_script()
        self.done.emit(self._again.session, self._seconds, same)
