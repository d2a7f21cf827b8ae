"""The motion that a controller wants of the robot whose readings are shown, while somebody looks or it is sent."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, replace

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.live.motion.command_latency import LatencyFigures
from tactile_maps.live.motion.driver_channel import check_sending, driver_channel
from tactile_maps.live.motion.measured_controller import RequestedMotion
from tactile_maps.live.motion.motion_output import MotionOutput
from tactile_maps.live.motion.motion_sender import MotionLimits, SendingState


@dataclass(frozen=True, eq=False)
class MotionFacts:
    """What a person should know of it.

    Attributes:
        settings: Of the controller.
        wanted: By the newest frame; None where nothing is wanted, or nobody looks.
        problem: Why nothing can be wanted; None where it can.
        sending: How sending goes.
        latency: Times from readings to commands; None before the first command.
    """

    settings: ControlSettings
    wanted: RequestedMotion | None
    problem: str | None
    sending: SendingState
    latency: LatencyFigures | None = None


class LiveMotion:
    """A controller on the readings of a session. Mutable; used under the lock of the runner that takes the readings.

    Args:
        settings: Initial settings of the controller.
        make_output: Returns the controller's output with these settings; called once, when it is first needed.
    """

    def __init__(self, settings: ControlSettings, make_output: Callable[[ControlSettings], MotionOutput]) -> None:
        self._settings = settings
        self._make_output = make_output
        self._output: MotionOutput | None = None  # made when it is first needed: it builds a model of the robot
        self._watched = False
        self._open = ExitStack()

    @property
    def facts(self) -> MotionFacts:
        """How it is now."""
        output = self._output
        if output is None:
            return MotionFacts(self._settings, None, None, SendingState())
        shown = self._watched or output.active
        wanted = output.wanted if shown else None
        problem = output.problem if shown else None
        return MotionFacts(output.settings, wanted, problem, output.sending, output.latency.figures)

    @property
    def active(self) -> bool:
        """True while motion is sent, or readings are waited for to send it."""
        return self._output is not None and self._output.active

    def watch(self, *, watched: bool) -> None:
        """Work out what is wanted of each frame, or only while it is sent."""
        self._watched = watched

    def use_controller(self, name: str) -> None:
        """Take another controller; what is sent ends first, for another one wants other motion.

        Raises:
            SceneError: There is no such controller.
        """
        self.stop()
        settings = replace(self._settings, controller=name)
        if self._output is not None:
            self._output.use(settings)
        self._settings = settings

    def start(self, address: str, limits: MotionLimits, *, token: str | None = None) -> None:
        """Send the requested motion from the next frame on. Call it only for a user's action.

        Raises:
            UsageError: There is no such address, or it is another machine's.
            LiveError: It cannot be sent to, or no program receives there.
            RobotError: The controller cannot be built.
        """
        self.stop()
        check_sending(address, remote=False)
        output = self._made()  # what can fail comes before anything is opened
        output.start_sending(self._open.enter_context(driver_channel(address)), limits, token=token)

    def stop(self) -> None:
        """Send a stop, and nothing after it; close the socket."""
        self.halt()
        self._open.close()

    def halt(self) -> None:
        """Send a stop, and nothing after it. Needs no lock."""
        if self._output is not None:
            self._output.halt()

    def take(self) -> None:
        """Take a new frame of the session. Cost: 1 to 3 ms while watched or sent, else none."""
        if self._watched or self.active:
            self._made().take()

    def check(self) -> None:
        """Stop sending where readings have ceased."""
        if self._output is not None:
            self._output.check()

    def check_deadline(self) -> None:
        """Stop sending where the thread that takes readings is stuck. Needs no lock."""
        if self._output is not None:
            self._output.check_deadline()

    def _made(self) -> MotionOutput:
        if self._output is None:
            self._output = self._make_output(self._settings)
        return self._output
