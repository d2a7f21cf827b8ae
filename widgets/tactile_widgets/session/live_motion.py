"""The motion that a controller requests of the real robot, computed while it is displayed or sent."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, replace

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.live.motion.command_latency import LatencyFigures
from tactile_maps.live.motion.driver_channel import check_sending, driver_channel
from tactile_maps.live.motion.measured_controller import RequestedMotion
from tactile_maps.live.motion.motion_output import MotionOutput
from tactile_maps.live.motion.motion_sender import MotionLimits, SendingState, StopReason


@dataclass(frozen=True, eq=False)
class MotionFacts:
    """State of the requested motion for display.

    Attributes:
        settings: Settings of the controller.
        requested: Motion requested for the newest frame; None if there is none, or if it is not computed.
        problem: Reason why no motion can be requested; None if there is no problem.
        sending: State of sending.
        latency: Times from readings to commands; None before the first command.
    """

    settings: ControlSettings
    requested: RequestedMotion | None
    problem: str | None
    sending: SendingState
    latency: LatencyFigures | None = None


class LiveMotion:
    """A controller that runs on measured readings. Mutable; guarded by the lock of the runner that takes the readings.

    Args:
        settings: Initial settings of the controller.
        make_output: Builds the controller's output with these settings; called once, at first use.
    """

    def __init__(self, settings: ControlSettings, make_output: Callable[[ControlSettings], MotionOutput]) -> None:
        self._settings = settings
        self._make_output = make_output
        self._output: MotionOutput | None = None  # built at first use, because it builds a model of the robot
        self._watched = False
        self._open = ExitStack()

    @property
    def facts(self) -> MotionFacts:
        """Current state."""
        output = self._output
        if output is None:
            return MotionFacts(self._settings, None, None, SendingState())
        shown = self._watched or output.active
        requested = output.requested if shown else None
        problem = output.problem if shown else None
        return MotionFacts(output.settings, requested, problem, output.sending, output.latency.figures)

    @property
    def active(self) -> bool:
        """True while motion is sent, or sending waits for readings."""
        return self._output is not None and self._output.active

    def watch(self, *, watched: bool) -> None:
        """Compute the requested motion for each frame, or only while it is sent."""
        self._watched = watched

    def use_controller(self, name: str) -> None:
        """Use another controller. Sending stops first, because the new controller requests different motion.

        Raises:
            SceneError: The controller is unknown.
        """
        self.stop()
        settings = replace(self._settings, controller=name)
        if self._output is not None:
            self._output.use(settings)
        self._settings = settings

    def start(self, address: str, limits: MotionLimits, *, token: str | None = None, accepted: str = "") -> None:
        """Send the requested motion from the next frame on. Call it only for a user's action.

        Arguments as those of ``MotionOutput.start_sending``.

        Raises:
            UsageError: The address is invalid, or on another machine.
            LiveError: The address cannot be reached, or no program receives there.
            RobotError: The controller cannot be built.
        """
        self.stop()
        check_sending(address, remote=False)
        output = self._made()  # may fail, so it precedes opening the channel
        output.start_sending(self._open.enter_context(driver_channel(address)), limits, token=token, accepted=accepted)

    def stop(self, reason: StopReason = StopReason.BY_HAND) -> None:
        """Send a stop command as the last one, and close the socket."""
        self.halt(reason)
        self._open.close()

    def halt(self, reason: StopReason = StopReason.BY_HAND) -> None:
        """Send a stop command as the last one. Needs no lock."""
        if self._output is not None:
            self._output.halt(reason)

    def take(self) -> None:
        """Process a new frame of the session. Cost: 1 to 3 ms while the motion is displayed or sent, else none."""
        if self._watched or self.active:
            self._made().take()

    def check(self) -> None:
        """Stop sending if readings have stopped."""
        if self._output is not None:
            self._output.check()

    def check_deadline(self) -> None:
        """Stop sending if the thread that processes readings is blocked. Needs no lock."""
        if self._output is not None:
            self._output.check_deadline()

    def _made(self) -> MotionOutput:
        if self._output is None:
            self._output = self._make_output(self._settings)
        return self._output
