"""The arm follows or retreats from a touch so that the contact force stays at a goal, and goes back to rest afterwards.

An admittance along the contact's normal: force error makes velocity, proportional and integral, so that a finger that
keeps advancing is held at the goal without lasting error. (Against a spring k this is second order: natural frequency
sqrt(gain k / integral_time), damping ratio half of sqrt(gain k integral_time).) The velocity of the touched point
becomes joint velocity by damped least squares; the wanted posture is its integral, held by a stiff joint impedance.
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
"""How fast the wanted posture returns to rest once nothing touches [1/s]."""
HOME_SPEED = 0.6
"""And never faster than this [rad/s]."""
MAX_LEAD = 0.3
"""How far the wanted posture may run ahead of an arm that something holds back [rad]."""
DAMPING = MAX_SPEED / (2 * MAX_JOINT_SPEED)
"""Of the least squares [m/rad]: its gain is at most 1 / (2 damping), so MAX_SPEED asks for MAX_JOINT_SPEED."""
_WEAK = 2 * DAMPING


class HoldForce:
    """Keeps the strongest contact at the goal force. Mutable: integral of the force error, wanted posture.

    Args:
        robot: Whose joints; it may have none.

    Cost: about 40 µs a command in contact.
    """

    def __init__(self, robot: Robot) -> None:
        self.rest, self._configuration = robot.home, Configuration(robot)
        self._inertia = self._configuration.inertia()
        self._lower, self._upper = joint_limits(robot)
        self.reset()

    def reset(self) -> None:
        """No contact known; the posture found at the next command is where it starts from."""
        self.why_limited: tuple[str, ...] = ()
        self._wanted: FloatArray | None = None
        self._forget_contact()
        self._homing = np.zeros_like(self.rest)

    def _forget_contact(self, new: int = 0) -> None:
        self._contact, self._integral, self._reached = new, 0.0, False

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
        start = posture if self._wanted is None else self._wanted
        if regions:
            speed = self._follow(settings, posture, start, regions[0], dt, limits)
        else:
            self._forget_contact()
            speed = self._go_home(start, dt)
        self._wanted = self._bounded(start + dt * speed, posture, limits)
        self.why_limited = tuple(limits)
        return joint_impedance(self._inertia, self._wanted, frequency=INNER_FREQUENCY, damping_ratio=1.0)

    def _bounded(self, wanted: FloatArray, posture: FloatArray, limits: list[str]) -> FloatArray:
        near = np.clip(wanted, posture - MAX_LEAD, posture + MAX_LEAD)
        if (near != wanted).any():
            limits.append("something holds the arm back")
        bounded = np.clip(near, self._lower, self._upper)
        if (bounded != near).any() and "joint limit" not in limits:
            limits.append("joint limit")
        return bounded

    def _follow(
        self,
        settings: ControlSettings,
        posture: FloatArray,
        start: FloatArray,
        region: ContactRegion,
        dt: float,
        limits: list[str],
    ) -> FloatArray:
        if region.id != self._contact:
            self._forget_contact(region.id)
        self._homing[:] = 0.0
        error = region.force - settings.force_goal
        # Integrating while the force first rises would push the arm into the finger: wait until the goal is reached.
        self._reached = self._reached or error >= 0
        integral = self._integral + error * dt if self._reached else 0.0
        wanted = settings.force_gain * (error + integral / settings.integral_time)
        retreat = min(max(wanted, -MAX_SPEED), MAX_SPEED)
        if retreat == wanted:
            self._integral = integral  # anti-windup: the integral stands while the speed is at its limit
        else:
            limits.append("speed of the touched point")
        self._configuration.update(posture)
        normal = self._configuration.pose(region.link).rotation @ region.normal
        row = normal @ self._configuration.jacobian(region.link, region.point)
        return self._joint_speed(row, -retreat, start, limits)

    def _joint_speed(self, row: FloatArray, outward: float, start: FloatArray, limits: list[str]) -> FloatArray:
        """Joint velocity that moves the point at ``outward`` [m/s]; joints at a limit leave it to the others."""
        for _ in range(len(row)):
            speed, weak = _damped_answer(row, outward)
            stuck = ((start <= self._lower) & (speed < 0)) | ((start >= self._upper) & (speed > 0))
            if not stuck.any():
                break
            row = np.where(stuck, 0.0, row)
            limits += [] if "joint limit" in limits else ["joint limit"]
        else:
            return np.zeros_like(row)
        limits += ["the arm can hardly move along this contact"] if weak else []
        fastest = float(np.abs(speed).max())
        if fastest > MAX_JOINT_SPEED:
            limits.append("joint speed")
            speed = speed * (MAX_JOINT_SPEED / fastest)
        return speed

    def _go_home(self, start: FloatArray, dt: float) -> FloatArray:
        """Towards rest, exponentially, speed-limited, starting gently (first-order lag of 0.2 s)."""
        aim = np.clip(HOME_RATE * (self.rest - start), -HOME_SPEED, HOME_SPEED)
        self._homing = self._homing + min(dt / 0.2, 1.0) * (aim - self._homing)
        return self._homing


def _damped_answer(row: FloatArray, outward: float) -> tuple[FloatArray, bool]:
    """Least joint velocity (n,) with ``row @ speed = outward``, and whether it is damped, near a singularity only.

    Damping grows from zero at ``_WEAK`` (Nakamura and Hanafusa 1986): elsewhere the answer is exact.
    """
    strength = float(np.linalg.norm(row))
    if strength >= _WEAK:
        return row * (outward / strength**2), False
    damping = DAMPING**2 * (1 - (strength / _WEAK) ** 2)
    return row * (outward / (strength**2 + damping)), True
