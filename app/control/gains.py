"""Joint impedance from one frequency: the same slider suits a shoulder and a wrist."""

from __future__ import annotations

import numpy as np

from app.arrays import FloatArray
from app.control.command import JointCommand
from app.robots.robot import Robot

MIN_INERTIA = 1e-3
"""Floor of a joint's inertia [kg m²] for choosing its stiffness, so that a weightless joint still holds."""


def joint_impedance(
    inertia: FloatArray, posture: FloatArray, *, frequency: float, damping_ratio: float
) -> JointCommand:
    """Second-order joints of natural ``frequency`` [rad/s] about ``posture``.

    Args:
        inertia: (n,) each joint's inertia at home [kg m²].
        posture: (n,) where to hold.
        frequency: Stiffness is inertia times its square.
        damping_ratio: Damping is 2 ratio frequency inertia; 1 is critical.
    """
    weight = np.maximum(inertia, MIN_INERTIA)
    return JointCommand(posture, weight * frequency**2, 2 * damping_ratio * frequency * weight, np.zeros_like(posture))


def joint_limits(robot: Robot) -> tuple[FloatArray, FloatArray]:
    """Lower and upper limits (n,) of all joints."""
    return np.array([j.lower for j in robot.joints]), np.array([j.upper for j in robot.joints])
