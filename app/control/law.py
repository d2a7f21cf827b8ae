"""The one question every control law answers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from app.arrays import FloatArray
from app.contacts.region import ContactRegion
from app.control.command import ControlSettings, JointCommand


class Law(Protocol):
    """A control law. Mutable; ``reset`` forgets the past."""

    why_limited: tuple[str, ...]

    def reset(self) -> None:
        """Start from the home posture, without history."""

    def command(
        self,
        settings: ControlSettings,
        posture: FloatArray,
        velocity: FloatArray,
        regions: Sequence[ContactRegion],
        dt: float,
    ) -> JointCommand:
        """What the joints should do for the next ``dt`` seconds."""
