"""What the simulation asks of a controller."""

from __future__ import annotations

from typing import Protocol

from app.arrays import FloatArray


class Impedance(Protocol):
    """What the joints are asked for; ``app.control.command.JointCommand`` is one. (This folder knows no control.)"""

    @property
    def posture(self) -> FloatArray:
        """(n,) [rad]."""

    @property
    def stiffness(self) -> FloatArray:
        """(n,) [N m/rad]."""

    @property
    def damping(self) -> FloatArray:
        """(n,) [N m s/rad]."""

    @property
    def torque(self) -> FloatArray:
        """(n,) [N m]."""
