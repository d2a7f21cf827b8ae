"""The arm follows or retreats from a touch so that the contact force stays at a goal, and goes back to rest afterwards.

An admittance along the contact's normal: force error makes velocity, proportional and integral, so that a finger that
keeps advancing is held at the goal without lasting error. (Against a spring k this is second order: natural frequency
sqrt(gain k / integral_time), damping ratio half of sqrt(gain k integral_time).) The velocity of the touched point
becomes joint velocity by damped least squares; the wanted posture is its integral, held by a stiff joint impedance.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite

import numpy as np

from app.arrays import FloatArray
from app.contacts.region import ContactRegion
from app.control.command import ControlSettings, JointCommand
from app.control.force_servo import ForceServo
from app.control.levels import Level
from app.control.reference import MAX_SPEED, PostureReference
from app.control.rule import solve_freely
from app.robots.configuration import Configuration
from app.robots.robot import Robot


class HoldForce:
    """Keeps the strongest contact at the goal force. Mutable: integral of the force error, wanted posture.

    Args:
        robot: Whose joints; it may have none.

    Cost: 50 µs a command in contact.
    """

    def __init__(self, robot: Robot) -> None:
        self.rest, self._configuration = robot.home, Configuration(robot)
        self._reference = PostureReference(robot, self._configuration.inertia())
        self.reset()

    def reset(self) -> None:
        """No contact known; the posture found at the next command is where it starts from."""
        self.why_limited: tuple[str, ...] = ()
        self._servo = ForceServo(MAX_SPEED)
        self._reference.reset()

    def start(self, posture: FloatArray, torque: FloatArray) -> None:
        """Without history, from the posture at which this law asks for ``torque`` (n,) of an arm at rest."""
        self.reset()
        self._reference.start(posture, torque)

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
        start = self._reference.from_where(posture)
        self._servo.keep(region.id for region in regions[:1])
        if regions and not isfinite(regions[0].force):
            limits.append("the skin reads what is no number")
            speed = np.zeros_like(start)
        elif regions:
            self._reference.stand()
            speed = self._follow(settings, posture, start, regions[0], dt, limits)
        else:
            speed = self._reference.home_speed(start, self.rest, dt)
        command = self._reference.move(posture, speed, dt, limits)
        self.why_limited = tuple(limits)
        return command

    def _follow(
        self,
        settings: ControlSettings,
        posture: FloatArray,
        start: FloatArray,
        region: ContactRegion,
        dt: float,
        limits: list[str],
    ) -> FloatArray:
        push = self._servo.push(settings, region.id, settings.force_goal - region.force, dt, limits)
        self._configuration.update(posture)
        normal = self._configuration.pose(region.link).rotation.dot(region.normal)
        row = normal.dot(self._configuration.jacobian(region.link, region.point))
        return solve_freely([Level(row[None], np.array((push,)))], self._reference, start, limits)
