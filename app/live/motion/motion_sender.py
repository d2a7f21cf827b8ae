"""Wanted motion out of the program: joint velocities to a robot's own driver, and every reason not to send them.

Nothing is sent before ``start``, which only a person's hand calls. Velocities hold for ``VALID_SECONDS``: a driver that
hears nothing for longer must stop by itself. Whatever ends sending sends a stop first, three times, since a packet can
be lost; only a hand starts it again.

A packet is one JSON object: ``v`` 1, ``seq``, ``t`` (the sender's clock [s]), ``state`` (``moving`` or ``stopped``),
``valid_s``, ``velocities`` by joint [rad/s, or m/s for a slide], and ``token`` where one is set; stopped also ``why``.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any
from urllib.parse import urlsplit

import numpy as np

from app.core.arrays import FloatArray
from app.core.errors import LiveError, UsageError
from app.live.motion.measured_controller import WantedMotion
from app.live.sources.network import is_this_machine

VALID_SECONDS = 0.2
"""For so long a velocity holds; without a reading for as long, sending stops."""
_STOP_PACKETS = 3
SPEEDS = (0.001, 1.0)
"""Fastest joint that may be allowed, lowest and highest [rad/s, or m/s]."""
FORCES = (1.0, 200.0)
"""Strongest contact that may be allowed [N]."""


@dataclass(frozen=True)
class MotionLimits:
    """What is sent at most.

    Attributes:
        speed: Of the fastest joint [rad/s, or m/s]; faster motion is slowed as a whole, so that its direction stays.
        force: A stronger contact [N] ends sending.

    Raises:
        LiveError: One is out of range.
    """

    speed: float = 0.2
    force: float = 15.0

    def __post_init__(self) -> None:
        for name, value, (low, high) in (("speed", self.speed, SPEEDS), ("force", self.force, FORCES)):
            if not (math.isfinite(value) and low <= value <= high):
                remedy = f"Choose {low:g} to {high:g}"
                raise LiveError(f"the limit of {name} is out of range", value=value, remedy=remedy)


class StopReason(StrEnum):
    """Why nothing is sent any more."""

    BY_HAND = "switched off"
    FORCE = "a contact passed the limit of force"
    STALE = "no reading came in time"
    CONTROLLER = "the controller's safety monitor stopped the arm"
    UNKNOWN = "posture or forces are not known any more"
    FAILED = "the address cannot be sent to"


@dataclass(frozen=True)
class SendingState:
    """How sending goes.

    Attributes:
        sending: Whether velocities are sent.
        stopped: Why it ended; None before it did.
        detail: Figures or the system's words; empty for none.
        sent: Packets with velocities so far.
        slowed: Of them, those whose motion was slowed to the limit.
    """

    sending: bool = False
    stopped: StopReason | None = None
    detail: str = ""
    sent: int = 0
    slowed: int = 0


def check_sending(address: str, *, remote: bool) -> None:
    """Refuse to move a robot on another machine unless it is asked for.

    Raises:
        UsageError: It is not.
    """
    host = urlsplit(address).hostname or "127.0.0.1"
    if not (remote or is_this_machine(host)):
        remedy = "Send to 127.0.0.1, or add --remote"
        raise UsageError("motion for other machines is not asked for", value=host, remedy=remedy)


class MotionSender:
    """Sends wanted motion within limits, and stops. Mutable; of one thread.

    Args:
        joints: Their names, in the order of the posture.
        put: Sends a packet.
        limits: See there.
        token: That every packet carries; None for none.

    Attributes:
        limits: As above.
        state: How it goes.
    """

    def __init__(
        self, joints: Sequence[str], put: Callable[[bytes], Any], limits: MotionLimits, *, token: str | None = None
    ) -> None:
        self._joints, self._put, self._token = tuple(joints), put, token
        self.limits, self.state = limits, SendingState()
        self._sequence = 0
        self._heard: float | None = None

    def start(self, now: float) -> None:
        """Send from the next motion on. ``now`` is the receiver's clock [s], as in ``show`` and ``check``."""
        self.state = SendingState(sending=True)
        self._heard = now

    def stop(self, now: float, reason: StopReason = StopReason.BY_HAND, detail: str = "") -> None:
        """Send a stop, and nothing after it until ``start``; nothing where nothing is sent."""
        if not self.state.sending:
            return
        self.state = replace(self.state, sending=False, stopped=reason, detail=detail)
        still = np.zeros(len(self._joints))
        try:
            for _ in range(_STOP_PACKETS):
                self._put(self._packet(now, still, why=reason.value))
        except (OSError, LiveError) as error:
            said = (detail, f"the stop was not sent: {error}")
            self.state = replace(self.state, detail="; ".join(filter(None, said)))

    def show(self, wanted: WantedMotion, now: float) -> None:
        """Send what is wanted, slowed where it is too fast; or stop."""
        if not self.state.sending:
            return
        if any(limit.kind.stops for limit in wanted.limits):
            self.stop(now, StopReason.CONTROLLER)
        elif wanted.force > self.limits.force:
            self.stop(now, StopReason.FORCE, f"{wanted.force:.1f} N, {self.limits.force:g} N allowed")
        elif not self.check(now):
            return
        else:
            self._heard = now
            self._send(wanted.velocity, now)

    def check(self, now: float) -> bool:
        """Whether sending goes on: it stops where no motion was shown for ``VALID_SECONDS``."""
        if self.state.sending and self._heard is not None and now - self._heard > VALID_SECONDS:
            self.stop(now, StopReason.STALE, f"{now - self._heard:.2f} s")
        return self.state.sending

    def _send(self, velocity: FloatArray, now: float) -> None:
        fastest = float(np.abs(velocity).max(initial=0.0))
        slowed = fastest > self.limits.speed
        sent = velocity * (self.limits.speed / fastest) if slowed else velocity
        try:
            self._put(self._packet(now, sent))
        except (OSError, LiveError) as error:
            self.stop(now, StopReason.FAILED, str(error))
        else:
            self.state = replace(self.state, sent=self.state.sent + 1, slowed=self.state.slowed + slowed)

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
