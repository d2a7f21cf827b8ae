"""Frames of a measured skin in; what the controller wants of each to be shown, and sent while a hand lets it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from app.control.command import ControlSettings
from app.core.errors import LiveError
from app.live.measured_session import MeasuredFacts
from app.live.motion.measured_controller import MeasuredController, WantedMotion
from app.live.motion.motion_sender import MotionLimits, MotionSender, SendingState, StopReason
from app.maps.tactile_map import TactileMap
from app.robots.robot import Robot
from app.session.frame import Frame

_NOT_SENT = SendingState()


class MotionOutput:
    """A controller on a measured skin, and where its motion goes. Mutable; of one thread.

    Args:
        robot: As it is measured.
        map_: Of the skin.
        settings: Of the controller.

    Attributes:
        wanted: By the newest frame; None where nothing could be wanted of it.
        problem: Why not; None where it could.

    Raises:
        SceneError: A setting is out of range.
    """

    def __init__(self, robot: Robot, map_: TactileMap, settings: ControlSettings) -> None:
        self._joints = tuple(joint.name for joint in robot.joints)
        self._controller = MeasuredController(robot, map_, settings)
        self._sender: MotionSender | None = None
        self.wanted: WantedMotion | None = None
        self.problem: str | None = None

    @property
    def settings(self) -> ControlSettings:
        """Of the controller, in force."""
        return self._controller.settings

    @property
    def sending(self) -> SendingState:
        """How sending goes."""
        return _NOT_SENT if self._sender is None else self._sender.state

    def use(self, settings: ControlSettings) -> None:
        """Take other settings; raises SceneError, and the last good ones stay."""
        self._controller.use(settings)

    def start_sending(
        self, put: Callable[[bytes], Any], limits: MotionLimits, now: float, *, token: str | None = None
    ) -> None:
        """Send what is wanted from the next frame on, from the posture that is found then: a hand said so.

        Args:
            put: Sends a packet.
            limits: See there.
            now: The receiver's clock [s], as in the others.
            token: That every packet carries.
        """
        self.stop_sending(now)
        self._controller.reset()
        self._sender = MotionSender(self._joints, put, limits, token=token)
        self._sender.start(now)

    def stop_sending(self, now: float) -> None:
        """Send a stop, and nothing after it."""
        if self._sender is not None:
            self._sender.stop(now)

    def take(self, frame: Frame, facts: MeasuredFacts, map_: TactileMap, now: float) -> None:
        """Work out what is wanted of a new frame, and send it or a stop.

        Cost: 1 to 3 ms for 1,000 taxels.
        """
        self._controller.use_map(map_)
        try:
            self.wanted, self.problem = self._controller.command(frame, facts), None
        except LiveError as error:
            self.wanted, self.problem = None, str(error)
            self._controller.reset()
            if self._sender is not None:
                self._sender.stop(now, StopReason.UNKNOWN, str(error))
        else:
            if self._sender is not None:
                self._sender.show(self.wanted, now)

    def check(self, now: float) -> None:
        """Stop sending where readings have ceased; to be asked a few times in ``VALID_SECONDS``."""
        if self._sender is not None:
            self._sender.check(now)
