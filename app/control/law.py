"""The one question every control law answers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from app.arrays import FloatArray
from app.contacts.region import ContactRegion
from app.control.command import ControlSettings, JointCommand


class Law(Protocol):
    """A control law. Mutable; ``reset`` forgets the past.

    Attributes:
        rest: (n,) the posture it keeps while nothing touches, and comes back to: home, until a scene moves it.
        why_limited: What bounds the answer now, in words; empty when nothing does.
    """

    rest: FloatArray
    why_limited: tuple[str, ...]

    def reset(self) -> None:
        """Start without history; ``rest`` stays."""

    def start(self, posture: FloatArray, torque: FloatArray) -> None:
        """Start without history in the middle of another law's work, as near as it can to what that one asks for.

        Args:
            posture: (n,) found.
            torque: (n,) asked for now, besides damping [N m].
        """

    def command(
        self,
        settings: ControlSettings,
        posture: FloatArray,
        velocity: FloatArray,
        regions: Sequence[ContactRegion],
        dt: float,
    ) -> JointCommand:
        """What the joints should do for the next ``dt`` seconds."""
