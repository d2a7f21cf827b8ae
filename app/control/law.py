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

    def command(
        self,
        settings: ControlSettings,
        posture: FloatArray,
        velocity: FloatArray,
        regions: Sequence[ContactRegion],
        dt: float,
    ) -> JointCommand:
        """What the joints should do for the next ``dt`` seconds."""
