"""The arm follows or retreats from a touch so that the contact force stays at a goal, and goes home afterwards.

An admittance along the contact's normal: force error makes velocity, proportional and integral, so that a finger that
keeps advancing is held at the goal without lasting error. The velocity of the touched point becomes joint velocity by
damped least squares; the wanted posture is its integral, held by a stiff joint impedance.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from app.arrays import FloatArray
from app.contacts.region import ContactRegion
from app.control.command import ControlSettings, JointCommand
from app.control.gains import joint_impedance, joint_limits
from app.robots.configuration import Configuration
from app.robots.robot import Robot

MAX_SPEED = 0.25
"""Of the touched point [m/s]."""
MAX_JOINT_SPEED = 1.5
"""Of any joint [rad/s]."""
INNER_FREQUENCY = 40.0
"""Natural frequency of the inner posture loop [rad/s]; well above the force loop's."""
HOME_RATE = 1.5
"""How fast the wanted posture returns home once nothing touches [1/s]."""
HOME_SPEED = 0.6
"""And never faster than this [rad/s]."""
DAMPING = MAX_SPEED / (2 * MAX_JOINT_SPEED)
"""Of the least squares [m/rad]: its gain is at most 1 / (2 damping), so MAX_SPEED asks for MAX_JOINT_SPEED."""
_WEAK = 2 * DAMPING


class HoldForce:
    """Keeps the strongest contact at the goal force. Mutable: integral of the force error, wanted posture."""

    def __init__(self, robot: Robot) -> None:
        self._home, self._configuration = robot.home, Configuration(robot)
        self._inertia = self._configuration.inertia()
        self._lower, self._upper = joint_limits(robot)
        self.reset()

    def reset(self) -> None:
        """No contact known, the home posture wanted."""
        self.why_limited: tuple[str, ...] = ()
        self._integral, self._wanted, self._contact = 0.0, self._home.copy(), 0
        self._homing = np.zeros_like(self._home)

    def command(
        self,
        settings: ControlSettings,
        posture: FloatArray,
        velocity: FloatArray,
        regions: Sequence[ContactRegion],
        dt: float,
    ) -> JointCommand:
        """Retreat along the strongest contact's inward normal when it presses too hard, advance when too little."""
        limits: list[str] = []
        if regions:
            speed = self._follow(settings, posture, regions[0], dt, limits)
        else:
            self._integral, self._contact = 0.0, 0
            speed = self._go_home(dt)
        wanted = self._wanted + dt * speed
        bounded = np.clip(wanted, self._lower, self._upper)
        if (bounded != wanted).any():
            limits.append("joint limit")
        self._wanted, self.why_limited = bounded, tuple(limits)
        return joint_impedance(self._inertia, self._wanted, frequency=INNER_FREQUENCY, damping_ratio=1.0)

    def _follow(
        self, settings: ControlSettings, posture: FloatArray, region: ContactRegion, dt: float, limits: list[str]
    ) -> FloatArray:
        if region.id != self._contact:
            self._contact, self._integral = region.id, 0.0
        self._homing[:] = 0.0
        error = region.force - settings.force_goal
        integral = self._integral + error * dt
        wanted = settings.force_gain * (error + integral / settings.integral_time)
        retreat = min(max(wanted, -MAX_SPEED), MAX_SPEED)
        if retreat == wanted:
            self._integral = integral  # anti-windup: the integral stands while the speed is at its limit
        else:
            limits.append("speed of the touched point")
        self._configuration.update(posture)
        normal = self._configuration.pose(region.link).rotation @ region.normal
        row = normal @ self._configuration.jacobian(region.link, region.point)
        return self._joint_speed(row, -retreat, limits)

    def _joint_speed(self, row: FloatArray, outward: float, limits: list[str]) -> FloatArray:
        """Joint velocity that moves the point at ``outward`` [m/s] along its normal, damped where the arm is weak."""
        strength = float(np.linalg.norm(row))
        # Damp only near a singularity (Nakamura and Hanafusa 1986): elsewhere the answer is exact.
        damping = DAMPING**2 * (1 - (strength / _WEAK) ** 2) if strength < _WEAK else 0.0
        if damping:
            limits.append("the arm can hardly move along this contact")
        if strength == 0:
            return np.zeros_like(row)
        speed = row * (outward / (strength**2 + damping))
        fastest = float(np.abs(speed).max())
        if fastest > MAX_JOINT_SPEED:
            limits.append("joint speed")
            speed = speed * (MAX_JOINT_SPEED / fastest)
        return speed

    def _go_home(self, dt: float) -> FloatArray:
        """Towards home, exponentially, speed-limited, starting gently (first-order lag of 0.2 s)."""
        aim = np.clip(HOME_RATE * (self._home - self._wanted), -HOME_SPEED, HOME_SPEED)
        self._homing = self._homing + min(dt / 0.2, 1.0) * (aim - self._homing)
        return self._homing
