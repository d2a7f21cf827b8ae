"""Joint velocities to a robot's own driver, and every reason not to send them.

Sending begins only with ``start``, which only a user's action calls. It sends two packets that say *stopped*, waits
until all readings that it needs are there (state *waiting*), sends velocities (*moving*), and ends with three packets
that say *stopped*, since a packet can be lost. Only a user's action starts it again. Any thread may stop it: nothing is
sent after a stop.

A velocity is valid for ``VALID_SECONDS``: a driver that receives nothing for longer must stop by itself. The data
behind a command are never older than ``OLDEST_SECONDS``. The difference is the ``DEADLINE`` of the command loop: a
contact that became too strong is answered within ``VALID_SECONDS`` in any case.

A packet is one JSON object: ``v`` 1, ``seq``, ``t`` (the sender's clock [s]), ``state`` (``moving`` or ``stopped``),
``valid_s``, ``velocities`` by joint [rad/s, or m/s for a slide], and ``token`` where one is set; stopped also ``why``.
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
from tactile_maps.core.errors import LiveError
from tactile_maps.live.motion.measured_controller import WantedMotion

VALID_SECONDS = 0.2
"""A driver may follow a velocity for so long [s]."""
OLDEST_SECONDS = 0.15
"""Largest age [s] of the data behind a velocity; older data stop sending."""
DEADLINE = VALID_SECONDS - OLDEST_SECONDS
"""A command must be sent within so long [s] after its newest reading was received; later ones are counted."""
WATCHDOG_SECONDS = OLDEST_SECONDS + 0.02
"""The watchdog stops sending when the data behind the last velocity are older [s]: the command loop is stuck."""
_STOP_PACKETS = 3
SPEEDS = (0.001, 1.0)
"""Fastest joint that may be allowed, lowest and highest [rad/s, or m/s]."""
FORCES = (1.0, 200.0)
"""Strongest contact that may be allowed [N]."""


@dataclass(frozen=True)
class MotionLimits:
    """What is sent at most.

    Attributes:
        speed: Of every joint [rad/s, or m/s for a slide]; faster motion is slowed as a whole, so that its direction
            stays. The speed limits of the robot's model apply as well.
        force: A stronger contact [N] ends sending.

    Raises:
        LiveError: One is out of range.
    """

    speed: float = 0.2
    force: float = 15.0

    def __post_init__(self) -> None:
        for name, unit, value, (low, high) in (
            ("speed", "rad/s", self.speed, SPEEDS),
            ("force", "N", self.force, FORCES),
        ):
            if not (math.isfinite(value) and low <= value <= high):
                remedy = f"Choose {low:g} to {high:g} {unit}"
                problem = f"the {name} limit is out of range"
                raise LiveError(problem, place=name, value=f"{value:g} {unit}", remedy=remedy)


class StopReason(StrEnum):
    """Why nothing is sent any more."""

    BY_HAND = "switched off"
    FORCE = "a contact passed the limit of force"
    STALE = "no reading came in time"
    BACKLOG = "the readings are too old"
    CLOCK = "the clock of the readings was set"
    NOT_HEARD = "a part of the robot is not heard any more"
    IMPLAUSIBLE = "a reading is impossible"
    FROZEN = "a part of the skin repeats the same values"
    OVERRUN = "the command loop missed its deadline"
    CONTROLLER = "the controller's safety monitor stopped the arm"
    UNKNOWN = "posture or forces are not known any more"
    RECORDING = "the recording failed"
    FAILED = "the address cannot be sent to"
    REFUSED = "no program receives at the driver's address"


@dataclass(frozen=True)
class SendingState:
    """How sending goes.

    Attributes:
        sending: True while velocities are sent.
        waiting: What it waits for before it sends; None where it does not wait.
        stopped: Why it ended; None before it did.
        detail: Figures or the system's words; empty for none.
        sent: Packets with velocities so far.
        slowed: Of them, those whose motion was slowed to the limit.
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
    """Sends velocities within limits, and stops. Mutable; any thread may call it.

    Args:
        joints: Their names, in the order of the posture.
        put: Sends a packet.
        limits: See there.
        model_speeds: Largest speed of each joint by the robot's model [rad/s, or m/s for a slide]; None without limits.
        token: That every packet carries; None for none.

    Attributes:
        limits: As above.
        most: (joints,) largest speed that is sent [rad/s, or m/s for a slide].
        state: How it goes.
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
        """Wait for the readings that are needed; ``begin`` ends the waiting.

        Two packets with *stopped* are sent first: the second fails where no program on this computer received the
        first.

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
        """Say what is waited for; nothing where it does not wait."""
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
        """Send a stop, and nothing after it until ``start``; nothing where it is not active."""
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
                said = (detail, f"the stop was not sent: {failed}")
                self.state = replace(self.state, detail="; ".join(filter(None, said)))

    def check_force(self, force: float, now: float, note: str = "") -> None:
        """Stop where a force [N] is beyond the limit, or not a number; ``note`` goes into the detail."""
        if not force <= self.limits.force:
            figures = f"{force:.1f} N, {self.limits.force:g} N allowed"
            self.stop(now, StopReason.FORCE, "; ".join(filter(None, (figures, note))))

    def show(self, wanted: WantedMotion, now: float, *, measured: float) -> bool:
        """Send a velocity, slowed where it is too fast; or stop. True if it was sent.

        Args:
            wanted: By the newest readings.
            now: Receiver's clock [s].
            measured: Time of the oldest value that it depends on, by the same clock [s].
        """
        with self._lock:
            self._measured = measured
            self.check_force(wanted.force, now)
            if any(limit.kind.stops for limit in wanted.limits):
                self.stop(now, StopReason.CONTROLLER)
            if not np.isfinite(wanted.velocity).all():
                self.stop(now, StopReason.CONTROLLER, "a velocity is not finite")
            if now - measured > VALID_SECONDS:
                self.stop(now, StopReason.OVERRUN, f"the command is {now - measured:.2f} s late")
            return self.state.sending and self._send(wanted.velocity, now)

    def check(self, now: float, reason: StopReason, detail: str) -> None:
        """Stop for ``reason`` where the data behind the last velocity are older than ``WATCHDOG_SECONDS``."""
        with self._lock:
            if self.state.sending and now - self._measured > WATCHDOG_SECONDS:
                self.stop(now, reason, detail or f"{now - self._measured:.2f} s without a command")

    def _send(self, velocity: FloatArray, now: float) -> bool:
        too_fast = np.abs(velocity) > self.most
        slowed = bool(too_fast.any())
        share = float((self.most[too_fast] / np.abs(velocity[too_fast])).min(initial=1.0))
        sent = velocity * share if slowed else velocity
        try:
            self._put(self._packet(now, sent))
        except (OSError, LiveError) as error:
            self.stop(now, _reason(error), str(error))
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
