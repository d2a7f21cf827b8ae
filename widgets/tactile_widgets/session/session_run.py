"""What the window can show: a scene that runs, or a recording. Both have a mode, a scene and settings in force."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, Protocol

from tactile_maps.core.errors import RecordingError, TactileMapsError
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.recording.player import RecordingPlayer
from tactile_maps.session.frame import Frame
from tactile_maps.session.inputs import ControlChanged, SessionInput
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.session.runtime_settings import RuntimeSettings
from tactile_widgets.common.mode import Mode
from tactile_widgets.session.comparison import ComparisonStimulus
from tactile_widgets.session.session_runner import SessionRunner

_LONGEST_WAIT = 0.05
"""Wall seconds for which the window stands still for a tick."""
_MOST_PLAYED = 100
"""Frames that are passed in one step while a recording is played; a longer step is a jump."""


class Source(Protocol):
    """What is shown."""

    @property
    def mode(self) -> Mode:
        """Running, paused or replaying."""

    @property
    def prepared(self) -> PreparedScene:
        """The scene it is of."""

    @property
    def settings(self) -> RuntimeSettings:
        """In force, or asked for where it runs."""

    def record(self) -> ComparisonStimulus:
        """All that was done in it."""


@dataclass(frozen=True, eq=False)
class RunUpdate:
    """What has become of a run since the last look.

    Attributes:
        frame: The newest.
        failure: Why it stopped or refused an input; None if it did not.
        behaved: What a behaviour has made of the controller, if that is still in force.
        passed: Every frame since the last look, the oldest first.
    """

    frame: Frame
    failure: TactileMapsError | None
    behaved: ControlChanged | None
    passed: tuple[Frame, ...] = ()


class SessionRun:
    """A scene that runs, and what was asked of it. Mutable.

    Args:
        runner: Drives its session.

    Attributes:
        runner: As above.
        settings: What was asked for last, whether it has taken effect yet or not.
    """

    def __init__(self, runner: SessionRunner) -> None:
        self.runner = runner
        self._inputs: Sequence[tuple[int, SessionInput]] = ()
        self._seen = 0
        with runner.lock:
            self.settings = runner.session.runtime_settings
            self._frame = runner.session.frame

    @property
    def mode(self) -> Mode:
        """Running or paused."""
        return Mode.PAUSED if self.runner.paused else Mode.RUNNING

    @property
    def prepared(self) -> PreparedScene:
        """The scene that runs."""
        return self.runner.session.prepared

    @property
    def map(self) -> TactileMap:
        """By which contacts are placed and controlled from the next tick on."""
        return self.settings.map

    def submit(self, session_input: SessionInput) -> None:
        """Let a person act at the next tick."""
        self.runner.submit(session_input)
        self.settings = self.settings.after(session_input)

    def reset(self) -> bool:
        """Start again, by all that was asked for, also while paused. Whether it had stopped by itself."""
        halted = self.runner.halted
        self.runner.reset()
        for session_input in self.waiting():
            self.runner.submit(session_input)
        return halted

    def waiting(self) -> list[SessionInput]:
        """What was asked for and has not taken effect yet, as in a session that is paused."""
        with self.runner.lock:
            now = self.runner.session.runtime_settings
        return self.settings.since(now)

    def update(self) -> RunUpdate:
        """Look what has become of it. What it refused is no longer asked for, and what a behaviour did is.

        While a tick takes long, as one that compiles other effects does, nothing has become of it yet.
        """
        runner = self.runner
        with runner.lock.taken_within(_LONGEST_WAIT) as taken:
            if not taken:
                return RunUpdate(self._frame, None, None)
            failure = runner.failure
            runner.failure = None
            if failure is not None and not runner.halted:
                self.settings = runner.session.runtime_settings
            behaved = self._behaved()
            if behaved is not None:
                self.settings = self.settings.after(behaved)
            self._frame = runner.session.frame
            return RunUpdate(self._frame, failure, behaved, runner.take_recent())

    def record(self) -> ComparisonStimulus:
        """All that was done since the last reset."""
        with self.runner.lock:
            session = self.runner.session
            return ComparisonStimulus(session.prepared, tuple(session.inputs), session.frame.time)

    def _behaved(self) -> ControlChanged | None:
        session = self.runner.session
        if session.inputs is not self._inputs:  # it started again
            self._inputs = session.inputs
            self._seen = 0
        new = session.inputs[self._seen :]
        self._seen = len(session.inputs)
        changes = [act for _tick, act in new if isinstance(act, ControlChanged)]
        return changes[-1] if changes and changes[-1].by is not None else None


class Replay:
    """A recording and where in it we are. Mutable.

    Args:
        player: Of the recording.

    Attributes:
        player: As above.
        frame: That is shown; None before the first ``seek``.
        settings: In force at that frame.
        number: Of that frame in the recording.
        passed: The frames between the one shown before and this; None where it was not played on, but a jump.
    """

    mode = Mode.REPLAYING

    def __init__(self, player: RecordingPlayer) -> None:
        self.player = player
        self.frame: Frame | None = None
        self.passed: tuple[Frame, ...] | None = None
        self.number = 0
        self.settings = RuntimeSettings.of_scene(player.prepared)

    @property
    def prepared(self) -> PreparedScene:
        """The scene it was made with."""
        return self.player.prepared

    def seek(self, seconds: float) -> Frame | None:
        """Return the frame at ``seconds`` from the start; None if it is shown already.

        Raises:
            RecordingError: That frame is damaged; the one before stays.
        """
        number = self.player.number_at(seconds)
        frame = self.player.frame(number)
        if self.frame is not None and frame.tick == self.frame.tick:
            return None
        played = self.frame is not None and 0 < number - self.number <= _MOST_PLAYED
        self.passed = self.frames(range(self.number + 1, number)) if played else None
        self.number = number
        self.frame = frame
        self.settings = self.player.runtime_settings_at(frame.tick)
        return frame

    def frames(self, numbers: Iterable[int]) -> tuple[Frame, ...]:
        """Those of these numbers that are not damaged. Cost: 0.2 ms each."""
        found = []
        for number in numbers:
            with suppress(RecordingError):  # the timeline marks what is damaged
                found.append(self.player.frame(number))
        return tuple(found)

    def before(self, seconds: float) -> range:
        """Numbers of the frames in the ``seconds`` before the one that is shown."""
        player = self.player
        start = float(player.times[self.number] - player.times[0]) - seconds
        return range(player.number_at(max(start, 0.0)), self.number)

    def record(self) -> ComparisonStimulus:
        """All that was done in it."""
        player = self.player
        return ComparisonStimulus(player.prepared, tuple(player.inputs), float(player.times[-1]))


class ShownSession(Protocol):
    """The run or replay that is shown."""

    @property
    def source(self) -> Source | None:
        """The recording that is replayed, or the session that runs; None before there is either."""

    @property
    def shown_run(self) -> SessionRun | None:
        """The session that runs, if it is shown; None during a replay."""

    @property
    def shown(self) -> Frame | None:
        """The frame that is shown; None before the first."""

    @property
    def measured_from(self) -> str | None:
        """Address of the readings of a real skin that are shown; None for a simulation."""

    def report_failure(self, text: str) -> None:
        """Show the user that something failed."""


class ActiveSettings:
    """Reports each part of the current settings only when it has changed. Mutable.

    Args:
        report: By field of ``RuntimeSettings``, the function that gets its value.
    """

    def __init__(self, **report: Callable[[Any], None]) -> None:
        self._report = report
        self._reported: RuntimeSettings | None = None

    def show(self, now: RuntimeSettings) -> None:
        """Report the parts that differ from the settings of the previous call."""
        before = self._reported
        self._reported = now
        if now is before:
            return
        for field, report in self._report.items():
            if before is None or getattr(before, field) != getattr(now, field):
                report(getattr(now, field))

    def forget(self) -> None:
        """Report all parts at the next call, for another scene or recording."""
        self._reported = None
