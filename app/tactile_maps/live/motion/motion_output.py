"""The controller on a measured skin: its motion is displayed, and sent while the user allows it.

Before a velocity is computed, the force on the skin and all inputs are checked, so that a slow controller cannot delay
a stop.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.core.errors import LiveError, names_text
from tactile_maps.live.motion.command_latency import CommandLatency
from tactile_maps.live.motion.input_monitor import InputMonitor
from tactile_maps.live.motion.measured_controller import (
    MeasuredController,
    RequestedMotion,
    strongest_force,
    strongest_patch,
)
from tactile_maps.live.motion.motion_sender import MotionLimits, MotionSender, SendingState, StopReason
from tactile_maps.live.readings.data_age import DataAge
from tactile_maps.live.session.measured_session import MeasuredSession
from tactile_maps.session.frame import Frame

_NOT_SENT = SendingState()


class MotionOutput:
    """A controller on a measured skin, and the output of its motion. Mutable.

    ``take`` and ``check`` are for the thread that processes readings; ``halt`` and ``check_deadline`` are thread-safe.

    Args:
        session: Session that uses the readings.
        settings: Settings of the controller.
        ages: Ages of the readings of the session's connection.
        clock: Receiver's clock [s], the same as that of the connection.

    Attributes:
        requested: Motion requested for the newest frame; None if there is none.
        problem: Reason why no motion is requested; None if there is no problem.
        latency: Delays from readings to commands.

    Raises:
        SceneError: A setting is out of range.
    """

    def __init__(
        self,
        session: MeasuredSession,
        settings: ControlSettings,
        ages: DataAge,
        *,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._session = session
        self._clock = clock
        self._joints = session.prepared.robot.joints
        self._controller = MeasuredController(session.prepared.robot, session.map, settings)
        self._monitor = InputMonitor(session, ages)
        self._sender: MotionSender | None = None
        self.requested: RequestedMotion | None = None
        self.problem: str | None = None
        self.latency = CommandLatency()

    @property
    def settings(self) -> ControlSettings:
        """Current settings of the controller."""
        return self._controller.settings

    @property
    def sending(self) -> SendingState:
        """State of sending."""
        return _NOT_SENT if self._sender is None else self._sender.state

    @property
    def active(self) -> bool:
        """True while motion is sent, or while readings are awaited to send it."""
        return self.sending.active

    @property
    def speed_limits(self) -> str:
        """Maximum speeds that are sent, in words; empty before ``start_sending``."""
        if self._sender is None:
            return ""
        most = self._sender.limits.speed
        slower = [
            f"{joint.name} {speed:.3g} {'m/s' if joint.slide else 'rad/s'}"
            for joint, speed in zip(self._joints, self._sender.most, strict=True)
            if speed < most
        ]
        by_model = f"; limited further by the robot's model: {names_text(slower)}" if slower else ""
        return f"at most {most:g} rad/s (m/s for slides) in each joint{by_model}"

    def use(self, settings: ControlSettings) -> None:
        """Change the settings; raises SceneError and keeps the previous ones if they are invalid."""
        self._controller.use(settings)

    def start_sending(
        self,
        put: Callable[[bytes], Any],
        limits: MotionLimits,
        *,
        token: str | None = None,
        accepted: str | None = "",
    ) -> None:
        """Send the desired motion once all readings are available, starting from the posture measured then.

        Call it only on a user's action.

        Args:
            put: Sends a packet.
            limits: Limits of the motion.
            token: Token in every packet.
            accepted: Doubt about the tare that the user has accepted, see ``tare_doubt``; None to accept any.

        Raises:
            LiveError: No program receives the packets, or they cannot be sent.
        """
        self.halt()
        self._monitor.reset(accepted=accepted)
        self.latency = CommandLatency()
        names = [joint.name for joint in self._joints]
        speeds = [joint.max_speed for joint in self._joints]
        self._sender = MotionSender(names, put, limits, model_speeds=speeds, token=token)
        self._sender.start(self._clock())

    def halt(self, reason: StopReason = StopReason.BY_HAND, detail: str = "") -> None:
        """Send a stop, and nothing after it. Thread-safe."""
        if self._sender is not None:
            self._sender.stop(self._clock(), reason, detail)

    def check_deadline(self) -> None:
        """Send a stop if the thread that processes readings is late. Call it from another thread, several times in 0.05
        s.
        """
        if self._sender is not None:
            now = self._clock()
            problem = self._monitor.old(now)
            if problem is None or problem.reason is StopReason.STALE:  # no reading was processed: that thread is stuck
                self._sender.check(now, StopReason.OVERRUN, "")
            else:
                self._sender.check(now, problem.reason, problem.detail)

    def check(self) -> None:
        """Stop sending if readings have ceased or are too old. For times without a new frame."""
        self._inputs_good(self._clock())

    def take(self) -> None:
        """Compute the motion that follows from the session's newest frame, and send it or a stop.

        Cost: 1 to 3 ms for 1,000 taxels.
        """
        frame = self._session.frame
        now = self._clock()
        sender = self._sender
        inputs_good = self._inputs_good(now)
        if sender is not None and self.active and frame.units.force is not None:
            self._check_force(sender, frame, now)
        good = inputs_good and self.active
        starting = good and self.sending.waiting is not None
        if starting:
            self._controller.reset()
        self._controller.use_map(self._session.map)
        try:
            self.requested = self._controller.command(frame, self._session.facts)
            self.problem = None
        except LiveError as error:
            self.requested = None
            self.problem = str(error)
            self._controller.reset()
            if good:
                self.halt(StopReason.UNKNOWN, str(error))
            return
        if sender is None or not good:
            return
        measured = self._monitor.measured
        if starting:
            sender.begin(measured)
        if sender.show(self.requested, self._clock(), measured=measured):
            self.latency.add(self._clock() - self._session.heard.arrived)

    def _check_force(self, sender: MotionSender, frame: Frame, now: float) -> None:
        """Stop if a contact or a patch bears too much. The second check does not depend on the contact threshold."""
        sender.check_force(strongest_force(frame), now)
        patch, total, below = strongest_patch(frame, self._session.prepared.skin, self._session.readings.noise)
        place = f"{below:.1f} N below the contact threshold on patch {patch}"
        sender.check_force(total, now, f"{place}: tare again or lower the threshold")

    def _inputs_good(self, now: float) -> bool:
        """Return whether motion may be sent. If not, stop it, or keep waiting if sending has not begun."""
        sender = self._sender
        if sender is None or not sender.state.active:
            return False
        problem = self._monitor.check(now, starting=sender.state.waiting is not None)
        if problem is None:
            return True
        if sender.state.waiting is not None and problem.awaited is not None:
            sender.wait(problem.awaited)
        else:
            sender.stop(now, problem.reason, problem.detail)
        return False
