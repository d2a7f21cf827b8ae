"""Readings of a real skin instead of a simulation: settings, connection and runners."""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Protocol, TypeVar

import numpy as np
from PySide6.QtCore import QObject, Signal

from tactile_maps.control.controller_registry import scene_values
from tactile_maps.core.arrays import IntArray
from tactile_maps.core.errors import LiveError, SimulationError, UsageError, describe_unexpected_error
from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.live.calibration.calibration import ValueMode, load_calibration, save_calibration
from tactile_maps.live.channels.matching import load_matching
from tactile_maps.live.checking.skin_check import SkinCheck
from tactile_maps.live.motion.command_loop import CommandLoop
from tactile_maps.live.motion.driver_channel import check_not_source, check_readings
from tactile_maps.live.motion.motion_output import MotionOutput
from tactile_maps.live.motion.motion_sender import MotionLimits, StopReason
from tactile_maps.live.prepare import as_measured
from tactile_maps.live.session.connection import Connection, ConnectionStatus
from tactile_maps.live.session.facts import MeasuredFacts, silent_text, swapped_texts, taxel_names
from tactile_maps.live.session.measured_session import MeasuredSession, ReadingLevels
from tactile_maps.live.session.reading_gap import GapWatch, PacketProblem, ProblemWatch, ReadingGap
from tactile_maps.live.sources.open import SourceOptions, open_source
from tactile_maps.session.frame import Frame
from tactile_maps.session.inputs import MapEdited
from tactile_maps.session.prepare import PreparedScene
from tactile_maps.session.runtime_settings import RuntimeSettings
from tactile_widgets.session.live_motion import LiveMotion, MotionFacts
from tactile_widgets.session.session_run import SessionRun, Source
from tactile_widgets.session.session_runner import InlineRunner, SessionRunner

T = TypeVar("T")
_CHECK_TARE = 20
"""Number of readings of the tare at the start of a check."""
_POLL_SECONDS = 0.05
"""Seconds of the source's time that one pass of the inline runner covers."""


@dataclass(frozen=True)
class LiveInputSettings:
    """Choices of the connection dialog.

    Attributes:
        address: Address of the source.
        options: Token, mapping and speed of the source.
        ids: Table that maps ids of the stream to taxels; None to use the ids of the skin.
        calibration: File of gains and offsets; None if there is none.
        tare: Number of initial readings to tare with; None for no tare.
        inverted: Whether the values fall under pressure; only without a calibration, which states signs itself.
    """

    address: str
    options: SourceOptions = field(default_factory=SourceOptions)
    ids: Path | None = None
    calibration: Path | None = None
    tare: int | None = None
    inverted: bool = False


class LiveInput:
    """A connection and the session that receives its readings. Mutable.

    Args:
        settings: Source and its options.
        origin: Scene that was shown before; ``Disconnect`` returns to it.
        simulated: Settings of that scene, which ``Disconnect`` restores. Contacts are located on its map, and its
            controller computes the motion that may be sent.

    Attributes:
        settings: Source and its options.
        origin: Scene that was shown before.
        simulated: Settings of that scene.
        connection: Connection to the source.
        session: Session that turns readings into frames.

    Raises:
        TactileMapsError: The source, or a file named with it, cannot be used.
    """

    def __init__(self, settings: LiveInputSettings, origin: PreparedScene, simulated: RuntimeSettings) -> None:
        self.settings = settings
        self.origin = origin
        self.simulated = simulated
        source = open_source(settings.address, settings.options)
        controlled = replace(origin.scene, control=scene_values(simulated.settings))
        prepared = as_measured(replace(origin, scene=controlled))
        skin = origin.skin
        if settings.inverted and settings.calibration is not None:
            remedy = "Negate the gains in the file instead"
            raise UsageError("a calibration states the sign of its gains", value="Inverted", remedy=remedy)
        table = None if settings.ids is None else load_matching(settings.ids, skin)
        calibration = None if settings.calibration is None else load_calibration(settings.calibration, skin)
        self.connection = Connection(source, clock=settings.options.clock)
        self.session = MeasuredSession(
            prepared,
            self.connection.take,
            table=table,
            calibration=calibration,
            finite=source.finite,
            tare_first=True,
            inverted=settings.inverted,
        )
        if simulated.map is not origin.map:
            self.session.submit(MapEdited("Earlier edits", simulated.map))
        if settings.tare is not None:
            self.session.tare(settings.tare)
        if not source.slow:
            self.connection.open()  # a slow source is opened on the thread, which reports failures
        self._runner: SessionRunner | None = None
        self._gaps = GapWatch()
        self._problems = ProblemWatch()
        self._check: SkinCheck | None = None
        self._watching = ExitStack()
        clock = settings.options.clock
        self._motion = LiveMotion(
            simulated.settings, lambda settings: MotionOutput(self.session, settings, self.connection.ages, clock=clock)
        )

    def run(self, make: Callable[..., SessionRunner], each: Callable[[Frame], None]) -> SessionRunner:
        """Make the runner that takes the readings; ``each`` receives every new frame."""
        self._runner = make(self.session, each, self.connection, self._motion)
        return self._runner

    @property
    def status(self) -> ConnectionStatus:
        """Status of the connection."""
        return self.connection.status

    def swapped(self, facts: MeasuredFacts) -> tuple[str, ...]:
        """Describe the swapped channels among ``facts``, one text per module."""
        return swapped_texts(self.session.prepared.skin, facts.swapped)

    def facts(self) -> tuple[MeasuredFacts, tuple[str, ...]]:
        """Return the state of the readings, and a description of each silent channel."""
        assert self._runner is not None
        with self._runner.lock:
            facts = self.session.facts
        return facts, tuple(silent_text(self.session.prepared.skin, one) for one in facts.silent)

    def unheard(self) -> tuple[str, ...]:
        """Return the names of the taxels for which no value has arrived."""
        assert self._runner is not None
        with self._runner.lock:
            heard = self.session.readings.matcher.heard.copy()
        return taxel_names(self.session.prepared.skin, np.flatnonzero(~heard))

    @property
    def age(self) -> float:
        """Time since the newest used reading arrived [s]; infinite before the first."""
        return self.settings.options.clock() - self.session.heard.arrived

    def gap(self, status: ConnectionStatus, facts: MeasuredFacts) -> ReadingGap | None:
        """Return the current gap in the readings; None while readings are used."""
        return self._gaps.find(status, facts, self.age)

    def problems(self, status: ConnectionStatus, facts: MeasuredFacts) -> tuple[PacketProblem, ...]:
        """Return the problems of the packets so far."""
        return self._problems.find(status, facts, self.settings.options.clock())

    def levels(self) -> tuple[ReadingLevels, ReadingUnits]:
        """Return the newest readings with the thresholds and noise of the taxels, and their units."""
        assert self._runner is not None
        with self._runner.lock:
            return self.session.levels, self.session.readings.units

    def motion(self) -> MotionFacts:
        """Return the motion that the controller requests, while it is displayed or sent."""
        assert self._runner is not None
        with self._runner.lock:
            return self._motion.facts

    def watch_motion(self, *, watched: bool) -> None:
        """Compute the requested motion always, or only while it is sent."""
        assert self._runner is not None
        with self._runner.lock:
            self._motion.watch(watched=watched)

    def use_controller(self, name: str) -> None:
        """Use another controller; sending stops. Raises SceneError."""
        assert self._runner is not None
        with self._runner.lock:
            self._motion.use_controller(name)

    def send_motion(self, address: str, limits: MotionLimits, *, accepted: str = "") -> None:
        """Send the requested motion. Call it only for a user's action; raises the errors of ``LiveMotion.start``.

        Args:
            address: Address of the driver.
            limits: Limits of the motion.
            accepted: Doubt about the tare that the user has accepted, see ``tare_doubt``.

        Raises:
            UsageError: Readings lack a required token, or are received at the same address.
            LiveError: The readings are paused: the robot would move without the user's action when they continue.
        """
        assert self._runner is not None
        if self._runner.paused:
            raise LiveError("the readings are paused", remedy="Press Play, or return from the recording to live")
        token = self.settings.options.token
        try:
            check_readings(self.settings.address, token)
        except UsageError as error:
            raise error.at(remedy="Disconnect, and let File > Connect make a token for the sender") from error
        check_not_source(address, self.settings.address)
        with self._runner.lock:
            self._motion.start(address, limits, token=token, accepted=accepted)

    def stop_motion(self, reason: StopReason = StopReason.BY_HAND) -> None:
        """Send a stop command as the last one, at once, without waiting for the thread of the readings."""
        assert self._runner is not None
        self._motion.halt(reason)
        with self._runner.lock:
            self._motion.stop(reason)

    def begin_check(self) -> None:
        """Begin a guided check of the skin with the next readings, which also tare a skin that waits for it."""
        assert self._runner is not None
        with self._runner.lock:
            self._watching.close()
            if self.session.readings.awaits_tare or not self.session.facts.readings:
                self.session.tare(_CHECK_TARE)
            check = self._check = SkinCheck(self.session.prepared.skin)

            def each(frame: Frame) -> None:
                assert frame.measured is not None
                check.add(frame.measured.raw, frame.time)

            self._watching.enter_context(self.session.watched(each))

    def with_check(self, act: Callable[[SkinCheck], T]) -> T | None:
        """Call ``act`` with the check while no reading is processed; return its result, None without a check."""
        assert self._runner is not None
        with self._runner.lock:
            return None if self._check is None else act(self._check)

    def tare(self, frames: int = 50) -> None:
        """Use the next readings as those of the untouched skin."""
        assert self._runner is not None
        with self._runner.lock:
            self.session.tare(frames)

    def invert(self) -> None:
        """Use gains of the opposite sign, for values that fall under pressure."""
        assert self._runner is not None
        with self._runner.lock:
            self.session.readings.invert()

    def begin_weighing(self, mass: float, seconds: float, taxels: IntArray | None) -> None:
        """Calibrate with a weight [kg] placed on the skin, see ``MeasuredSession``; raises LiveError."""
        assert self._runner is not None
        with self._runner.lock:
            self.session.weights.begin(mass, seconds, taxels=taxels)

    def undo_weighing(self) -> None:
        """Restore the calibration before the last weight."""
        assert self._runner is not None
        with self._runner.lock:
            self.session.weights.undo()

    def forget_weighing(self) -> None:
        """Forget the outcome of the last weight."""
        assert self._runner is not None
        with self._runner.lock:
            self.session.weights.forget()

    def apply_negative_gain(self) -> None:
        """Use the negative gains of a weight under which the readings fell."""
        assert self._runner is not None
        with self._runner.lock:
            self.session.weights.apply_negative_gain()

    def save_calibration(self, path: str) -> None:
        """Write gains and offsets as CSV; raises LiveError."""
        assert self._runner is not None
        with self._runner.lock:
            calibration = self.session.readings.calibration
        save_calibration(calibration, path)

    def request_mode(self, mode: ValueMode) -> None:
        """Choose the values that are shown; raises LiveError if the readings do not provide them."""
        assert self._runner is not None
        with self._runner.lock:
            self.session.readings.request_mode(mode)


class ConnectionHost(Protocol):
    """Part of the session host that a connection uses."""

    @property
    def source(self) -> Source | None:
        """The replayed recording, or the running session; None before the first."""

    @property
    def shown_run(self) -> SessionRun | None:
        """The running session if it is shown; None during a replay."""

    @property
    def run(self) -> SessionRun | None:
        """The running session, or the one paused behind a recording; None before the first."""

    def show_prepared(self, prepared: PreparedScene, settings: RuntimeSettings | None = None) -> bool:
        """Simulate a scene from its start."""

    def run_readings(self, live: LiveInput) -> None:
        """Show readings instead of what is shown."""


class LiveConnection(QObject):
    """Opens and closes the source of readings that are shown instead of a simulation.

    Args:
        host: The window's session.
        parent: Qt parent.

    Attributes:
        input: The readings that are shown; None for a simulation.
    """

    changed = Signal(object)
    """The LiveInput whose readings are shown instead of a simulation, or None."""

    def __init__(self, host: ConnectionHost, parent: QObject) -> None:
        super().__init__(parent)
        self._host = host
        self.input: LiveInput | None = None

    def open(self, settings: LiveInputSettings) -> None:
        """Show readings of a real skin on the robot and the map that are shown.

        Raises:
            TactileMapsError: The source, or a file named with it, cannot be used; nothing changes.
        """
        if (source := self._host.source) is None:
            raise LiveError("no skin is open to show readings on", remedy="Open a robot, scene or skin first")
        before = self.input if self._host.shown_run is source else None
        origin = source.prepared if before is None else before.origin
        live = LiveInput(settings, origin, _simulated_settings(source.settings, before))
        self._host.run_readings(live)
        self.changed.emit(live)

    def close(self) -> None:
        """Close the source and simulate again, with the previous settings and the current map."""
        if (live := self.input) is None or (run := self._host.run) is None:
            return
        self._host.show_prepared(live.origin, _simulated_settings(run.settings, live))

    def discard(self) -> None:
        """Forget the source, because something else will be shown."""
        if self.input is not None:
            self.input = None
            self.changed.emit(None)


def _simulated_settings(shown: RuntimeSettings, live: LiveInput | None) -> RuntimeSettings:
    """Return settings for a simulation of what is shown; ``live`` provides those that readings do not have."""
    return shown if live is None else replace(live.simulated, map=shown.map)


class _TakesReadings(SessionRunner):
    """Runner that produces one frame per reading."""

    session: MeasuredSession

    def __init__(
        self, session: MeasuredSession, each: Callable[[Frame], None], connection: Connection, motion: LiveMotion
    ) -> None:
        super().__init__(session, each)
        self._connection = connection
        self._motion = motion
        self._commands = CommandLoop(
            connection, session, motion, self._keep, lock=self.lock, paused=lambda: self.paused, shares=True
        )

    def _tick(self) -> None:
        self._commands.step()


class InlineReadingsRunner(_TakesReadings, InlineRunner):
    """Processes arrived readings on request: deterministic, for tests and pictures."""

    def run_for(self, seconds: float) -> None:
        """Receive and process readings for a number of seconds of the source's time."""
        for _ in range(max(round(seconds / _POLL_SECONDS), 1)):
            self._connection.step(0.0)
            if not self.paused:
                with self.lock:
                    self._tick()
            self._motion.check()

    def stop(self) -> None:
        """End the connection."""
        self._motion.stop()
        self._connection.close()


class ThreadReadingsRunner(_TakesReadings):
    """Processes readings when they arrive, on its own thread; the connection receives on another."""

    def __init__(
        self, session: MeasuredSession, each: Callable[[Frame], None], connection: Connection, motion: LiveMotion
    ) -> None:
        super().__init__(session, each, connection, motion)
        self.real_time_factor = 1.0
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._loop, name="readings", daemon=True)

    def start(self) -> None:
        """Start both threads; called once."""
        self._connection.start()
        self._thread.start()

    def stop(self) -> None:
        """End both threads and wait for them."""
        self._motion.halt()
        self._ended.set()
        if self._thread.is_alive():
            self._thread.join()
        self._connection.close()
        self._motion.stop()

    def _loop(self) -> None:
        try:
            self._commands.run(self._ended)
        except Exception as error:  # an error that ended the thread would freeze the session without notice
            self.failure = SimulationError(describe_unexpected_error(error), remedy="Disconnect and connect again")
            self._halt()
