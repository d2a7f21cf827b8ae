"""Sources that the window can show: a running session, or a replayed recording."""

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
from tactile_widgets.session.comparison_stimulus import ComparisonStimulus
from tactile_widgets.session.session_runner import SessionRunner

_LONGEST_WAIT = 0.05
"""Longest wall time for which the window waits for a tick [s]."""
_MOST_PLAYED = 100
"""Maximum number of frames in one step while a recording is played; a longer step is a jump."""


class Source(Protocol):
    """A source of frames that can be shown."""

    @property
    def mode(self) -> Mode:
        """Running, paused or replaying."""

    @property
    def prepared(self) -> PreparedScene:
        """The scene."""

    @property
    def settings(self) -> RuntimeSettings:
        """Current settings; those of a running session include changes that are not applied yet."""

    def record(self) -> ComparisonStimulus:
        """Return its inputs as a stimulus for comparisons."""


@dataclass(frozen=True, eq=False)
class RunUpdate:
    """Changes of a running session since the previous update.

    Attributes:
        frame: The newest frame.
        failure: Reason why it stopped or rejected an input; None otherwise.
        behaved: Change of the controller by a behaviour, if it is the latest change.
        passed: All frames since the previous update, the oldest first.
    """

    frame: Frame
    failure: TactileMapsError | None
    behaved: ControlChanged | None
    passed: tuple[Frame, ...] = ()


class SessionRun:
    """A running session and the settings requested for it. Mutable.

    Args:
        runner: Advances the session.

    Attributes:
        runner: The runner.
        settings: Settings requested last, whether they are applied yet or not.
        made: The same without the changes by behaviours: the settings that the user made.
    """

    def __init__(self, runner: SessionRunner) -> None:
        self.runner = runner
        self._inputs: Sequence[tuple[int, SessionInput]] = ()
        self._seen = 0
        with runner.lock:
            self.settings = runner.session.runtime_settings
            self._frame = runner.session.frame
        self.made = self.settings

    @property
    def mode(self) -> Mode:
        """Running or paused."""
        return Mode.PAUSED if self.runner.paused else Mode.RUNNING

    @property
    def prepared(self) -> PreparedScene:
        """The running scene."""
        return self.runner.session.prepared

    @property
    def map(self) -> TactileMap:
        """Map on which contacts are located and controlled from the next tick on."""
        return self.settings.map

    def submit(self, *session_inputs: SessionInput) -> None:
        """Apply inputs of the user at the same next tick."""
        self.runner.submit(*session_inputs)
        for session_input in session_inputs:
            self.settings = self.settings.after(session_input)
            self.made = self.made.after(session_input)

    def reset(self) -> bool:
        """Start again with all requested settings; return True if the session had stopped by itself."""
        halted = self.runner.halted
        self.runner.reset()
        for session_input in self.waiting():
            self.runner.submit(session_input)
        return halted

    def waiting(self) -> list[SessionInput]:
        """Return inputs for the settings that are not applied yet, as in a paused session."""
        with self.runner.lock:
            now = self.runner.session.runtime_settings
        return self.settings.since(now)

    def update(self) -> RunUpdate:
        """Return the changes since the previous update, and update ``settings`` by rejections and behaviours.

        During a long tick, such as one that compiles other effects, the update contains no changes.
        """
        runner = self.runner
        with runner.lock.taken_within(_LONGEST_WAIT) as taken:
            if not taken:
                return RunUpdate(self._frame, None, None)
            failure = runner.failure
            runner.failure = None
            if failure is not None and not runner.halted:
                self.settings = runner.session.runtime_settings
                self.made = self.settings
            behaved = self._behaved()
            if behaved is not None:
                self.settings = self.settings.after(behaved)
            self._frame = runner.session.frame
            return RunUpdate(self._frame, failure, behaved, runner.take_recent())

    def record(self) -> ComparisonStimulus:
        """Return the inputs since the last reset as a stimulus for comparisons."""
        with self.runner.lock:
            session = self.runner.session
            return ComparisonStimulus(session.prepared, tuple(session.inputs), session.frame.time)

    def _behaved(self) -> ControlChanged | None:
        session = self.runner.session
        if session.inputs is not self._inputs:  # the session was reset
            self._inputs = session.inputs
            self._seen = 0
        new = session.inputs[self._seen :]
        self._seen = len(session.inputs)
        changes = [act for _tick, act in new if isinstance(act, ControlChanged)]
        return changes[-1] if changes and changes[-1].by is not None else None


class Replay:
    """A recording and the current position in it. Mutable.

    Args:
        player: Player of the recording.

    Attributes:
        player: Player of the recording.
        frame: The frame that is shown; None before the first ``seek``.
        settings: Settings at that frame.
        number: Number of that frame in the recording.
        passed: Frames between the previous one shown and this one; None after a jump.
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
        """The scene of the recording."""
        return self.player.prepared

    def seek(self, seconds: float) -> Frame | None:
        """Return the frame at ``seconds`` from the start; None if it is shown already.

        Raises:
            RecordingError: The frame is damaged; the position does not change.
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
        """Return the frames with these numbers, without damaged ones. Cost: 0.2 ms per frame."""
        found = []
        for number in numbers:
            with suppress(RecordingError):  # the timeline marks damaged frames
                found.append(self.player.frame(number))
        return tuple(found)

    def before(self, seconds: float) -> range:
        """Return the numbers of the frames in the ``seconds`` before the one that is shown."""
        player = self.player
        start = float(player.times[self.number] - player.times[0]) - seconds
        return range(player.number_at(max(start, 0.0)), self.number)

    def record(self) -> ComparisonStimulus:
        """Return the inputs of the recording as a stimulus for comparisons."""
        player = self.player
        return ComparisonStimulus(player.prepared, tuple(player.inputs), float(player.times[-1]))


class ShownSession(Protocol):
    """The run or replay that is shown."""

    @property
    def source(self) -> Source | None:
        """The replayed recording, or the running session; None before the first."""

    @property
    def shown_run(self) -> SessionRun | None:
        """The running session if it is shown; None during a replay."""

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
        report: Function that receives the value, by field of ``RuntimeSettings``.
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
