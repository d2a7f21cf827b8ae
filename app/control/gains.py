"""Joint impedance from one frequency: the same slider suits a shoulder and a wrist."""

from __future__ import annotations

import numpy as np

from app.arrays import FloatArray, readonly
from app.control.command import JointCommand
from app.robots.robot import Robot

MIN_INERTIA = 1e-3
"""Floor of a joint's inertia [kg m²] for choosing its stiffness, so that a weightless joint still holds."""


class JointImpedance:
    """Second-order joints of one natural frequency about any posture; the gains are worked out once.

    Args:
        inertia: (n,) each joint's inertia at home [kg m²].
        frequency: [rad/s]; stiffness is inertia times its square.
        damping_ratio: Damping is 2 ratio frequency inertia; 1 is critical.

    Attributes:
        stiffness: (n,) [N m/rad].
        damping: (n,) [N m s/rad].
    """

    def __init__(self, inertia: FloatArray, *, frequency: float, damping_ratio: float) -> None:
        weight = np.maximum(inertia, MIN_INERTIA)
        self.stiffness = readonly(weight * frequency**2)
        self.damping = readonly(2 * damping_ratio * frequency * weight)
        self._no_torque = readonly(np.zeros(len(weight)))

    def about(self, posture: FloatArray) -> JointCommand:
        """The command that holds ``posture`` (n,)."""
        return JointCommand(posture, self.stiffness, self.damping, self._no_torque)


def joint_impedance(
    inertia: FloatArray, posture: FloatArray, *, frequency: float, damping_ratio: float
) -> JointCommand:
    """The same in one go, for gains that may be others at the next tick."""
    return JointImpedance(inertia, frequency=frequency, damping_ratio=damping_ratio).about(posture)


def joint_limits(robot: Robot) -> tuple[FloatArray, FloatArray]:
    """Lower and upper limits (n,) of all joints."""
    return np.array([j.lower for j in robot.joints]), np.array([j.upper for j in robot.joints])
