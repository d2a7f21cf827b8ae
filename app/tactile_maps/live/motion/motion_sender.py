"""Joint velocities to a robot's own driver, and all reasons not to send them.

Sending begins only with ``start``, which is called only on a user's action. It sends two packets with the state
*stopped*, waits until all required readings are available (state *waiting*), sends velocities (*moving*), and ends with
three packets with the state *stopped*, because a packet can be lost. Only a user's action starts it again. Any thread
may stop it: nothing is sent after a stop.

A velocity is valid for ``VALID_SECONDS``: a driver that receives nothing for longer must stop by itself. The data
behind a command are never older than ``OLDEST_SECONDS``. The difference is the ``DEADLINE`` of the command loop: the
response to an excessive contact force always takes less than ``VALID_SECONDS``.

A packet is one JSON object: ``v`` 1, ``seq``, ``t`` (the sender's clock [s]), ``state`` (``moving`` or ``stopped``),
``valid_s``, ``velocities`` by joint [rad/s, or m/s for a slide], and ``token`` if one is set; stopped also ``why``.
"""

from __future__ import annotations

import json
import math
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any

import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import LiveError, check_range, system_message
from tactile_maps.live.motion.measured_controller import RequestedMotion

VALID_SECONDS = 0.2
"""Time for which a driver may follow a velocity [s]."""
OLDEST_SECONDS = 0.15
"""Maximum age of the data behind a velocity [s]; older data stop sending."""
DEADLINE = VALID_SECONDS - OLDEST_SECONDS
"""Maximum time between receiving the newest reading and sending its command [s]; later commands are counted."""
WATCHDOG_SECONDS = OLDEST_SECONDS + 0.02
"""Age of the data behind the last velocity at which the watchdog stops sending [s]: the command loop is stuck."""
_STOP_PACKETS = 3
SPEEDS = (0.001, 1.0)
"""Range of the maximum joint speed [rad/s, or m/s]."""
FORCES = (1.0, 200.0)
"""Range of the maximum contact force [N]."""


@dataclass(frozen=True)
class MotionLimits:
    """Limits of the motion that is sent.

    Attributes:
        speed: Maximum speed of every joint [rad/s, or m/s for a slide]; faster motion is scaled as a whole, so that its
            direction stays. The speed limits of the robot's model apply as well.
        force: A stronger contact [N] ends sending.

    Raises:
        LiveError: A limit is out of range.
    """

    speed: float = 0.2
    force: float = 15.0

    def __post_init__(self) -> None:
        for name, unit, value, limits in (
            ("speed", "rad/s", self.speed, SPEEDS),
            ("force", "N", self.force, FORCES),
        ):
            check_range(f"the {name} limit", value, *limits, error=LiveError, place=name, unit=unit)


class StopReason(StrEnum):
    """Reason why sending stopped; the value is the field ``why`` of the packets."""

    BY_HAND = "switched off"
    PAUSED = "the readings were paused"
    FORCE = "a contact passed the limit of force"
    STALE = "no reading came in time"
    BACKLOG = "the readings are too old"
    CLOCK = "the clock of the readings was set"
    NOT_HEARD = "a part of the robot is not heard any more"
    IMPLAUSIBLE = "a reading is impossible"
    FROZEN = "a part of the skin repeats the same values"
    OVERRUN = "the command loop missed its deadline"
    DOUBTFUL_TARE = "the tare is doubtful"
    CONTROLLER = "the controller's safety monitor stopped the arm"
    UNKNOWN = "posture or forces are not known any more"
    RECORDING = "the recording failed"
    FAILED = "the address cannot be sent to"
    REFUSED = "no program receives at the driver's address"


@dataclass(frozen=True)
class SendingState:
    """State of sending.

    Attributes:
        sending: True while velocities are sent.
        waiting: Reason for waiting before sending; None if it does not wait.
        stopped: Reason why it stopped; None before that.
        detail: Figures or the system's error message; may be empty.
        sent: Number of packets with velocities so far.
        slowed: Number of those whose motion was scaled to the limit.
    """

    sending: bool = False
    waiting: str | None = None
    stopped: StopReason | None = None
    detail: str = ""
    sent: int = 0
    slowed: int = 0

    @property
    def active(self) -> bool:
        """True from the start to the stop."""
        return self.sending or self.waiting is not None


class MotionSender:
    """Sends velocities within limits, and stops. Mutable; thread-safe.

    Args:
        joints: Joint names, in the order of the posture.
        put: Sends a packet.
        limits: Limits of the motion.
        model_speeds: Maximum speed of each joint by the robot's model [rad/s, or m/s for a slide]; None without limits.
        token: Token in every packet; None if there is none.

    Attributes:
        limits: Value of the argument.
        most: (joints,) maximum speed that is sent [rad/s, or m/s for a slide].
        state: State of sending.
    """

    def __init__(
        self,
        joints: Sequence[str],
        put: Callable[[bytes], Any],
        limits: MotionLimits,
        *,
        model_speeds: Sequence[float] | None = None,
        token: str | None = None,
    ) -> None:
        self._joints = tuple(joints)
        self._put = put
        self._token = token
        self._lock = threading.RLock()
        self.limits = limits
        self.state = SendingState()
        model = np.full(len(self._joints), np.inf) if model_speeds is None else np.asarray(model_speeds)
        self.most = np.minimum(limits.speed, model)
        self._sequence = 0
        self._measured = -math.inf

    def start(self, now: float) -> None:
        """Wait for the required readings; ``begin`` ends the waiting.

        Two packets with the state *stopped* are sent first: the second fails if no program on this computer received
        the first.

        Raises:
            LiveError: They cannot be sent, or no program receives them.
        """
        with self._lock:
            still = np.zeros(len(self._joints))
            try:
                for _ in range(2):
                    self._put(self._packet(now, still, why="nothing is sent yet"))
            except OSError as error:
                remedy = "Start the robot's driver first, and check the address"
                raise LiveError(_reason(error).value, value=error, remedy=remedy) from error
            self.state = SendingState(waiting="the first reading")

    def wait(self, text: str) -> None:
        """State what is awaited; no effect if it does not wait."""
        with self._lock:
            if self.state.waiting is not None:
                self.state = replace(self.state, waiting=text)

    def begin(self, measured: float) -> None:
        """Send velocities from now on, if it waits. ``measured`` as in ``show``."""
        with self._lock:
            if self.state.waiting is not None:
                self.state = replace(self.state, waiting=None, sending=True)
                self._measured = measured

    def stop(self, now: float, reason: StopReason = StopReason.BY_HAND, detail: str = "") -> None:
        """Send a stop, and nothing after it until ``start``; no effect if it is not active."""
        with self._lock:
            if not self.state.active:
                return
            self.state = replace(self.state, sending=False, waiting=None, stopped=reason, detail=detail)
            still = np.zeros(len(self._joints))
            failed = None
            for _ in range(_STOP_PACKETS):  # each is tried: a socket reports a refused packet with the next one
                try:
                    self._put(self._packet(now, still, why=reason.value))
                except (OSError, LiveError) as error:
                    failed = error
            if failed is not None:
                cause = system_message(failed)
                unsent = "the stop was not sent" + ("" if cause == detail else f": {cause}")
                self.state = replace(self.state, detail="; ".join(filter(None, (detail, unsent))))

    def check_force(self, force: float, now: float, note: str = "") -> None:
        """Stop if a force [N] exceeds the limit or is not a number; ``note`` is added to the detail."""
        if not force <= self.limits.force:
            figures = f"{force:.1f} N, {self.limits.force:g} N allowed"
            self.stop(now, StopReason.FORCE, "; ".join(filter(None, (figures, note))))

    def show(self, requested: RequestedMotion, now: float, *, measured: float) -> bool:
        """Send a velocity, scaled if it is too fast; or stop. Return whether it was sent.

        Args:
            requested: Motion that follows from the newest readings.
            now: Receiver's clock [s].
            measured: Time of the oldest value that it depends on, by the same clock [s].
        """
        with self._lock:
            self._measured = measured
            self.check_force(requested.force, now)
            if any(limit.kind.stops for limit in requested.limits):
                self.stop(now, StopReason.CONTROLLER)
            if not np.isfinite(requested.velocity).all():
                self.stop(now, StopReason.CONTROLLER, "a velocity is not finite")
            if now - measured > VALID_SECONDS:
                self.stop(now, StopReason.OVERRUN, f"the command is {now - measured:.2f} s late")
            return self.state.sending and self._send(requested.velocity, now)

    def check(self, now: float, reason: StopReason, detail: str) -> None:
        """Stop for ``reason`` if the data behind the last velocity are older than ``WATCHDOG_SECONDS``."""
        with self._lock:
            if self.state.sending and now - self._measured > WATCHDOG_SECONDS:
                self.stop(now, reason, detail or f"{now - self._measured:.2f} s without a command")

    def _send(self, velocity: FloatArray, now: float) -> bool:
        too_fast = np.abs(velocity) > self.most
        slowed = bool(too_fast.any())
        share = float((self.most[too_fast] / np.abs(velocity[too_fast])).min(initial=1.0))
        try:
            self._put(self._packet(now, velocity * share))
        except (OSError, LiveError) as error:
            self.stop(now, _reason(error), system_message(error))
            return False
        self.state = replace(self.state, sent=self.state.sent + 1, slowed=self.state.slowed + slowed)
        return True

    def _packet(self, now: float, velocity: FloatArray, *, why: str | None = None) -> bytes:
        fields: dict[str, Any] = {"v": 1, "seq": self._sequence, "t": now, "valid_s": VALID_SECONDS}
        fields["state"] = "moving" if why is None else "stopped"
        fields["velocities"] = dict(zip(self._joints, velocity.tolist(), strict=True))
        if why is not None:
            fields["why"] = why
        if self._token is not None:
            fields["token"] = self._token
        self._sequence += 1
        return json.dumps(fields, separators=(",", ":")).encode()


def _reason(error: Exception) -> StopReason:
    return StopReason.REFUSED if isinstance(error, ConnectionRefusedError) else StopReason.FAILED
