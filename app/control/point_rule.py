"""What most laws with a task have in common: they tell for every contact how its point should move in space."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np

from app.arrays import FloatArray, length
from app.control.command import ControlSettings
from app.control.force_servo import ForceServo
from app.control.levels import Level
from app.control.reference import MAX_SPEED
from app.control.rule import ArmState, in_space, one_level, solve_freely
from app.control.task_contact import TaskContact


class PointRule(ABC):
    """A ``Rule`` that gives each contact's point a velocity, all wanted alike. Mutable; ``reset`` forgets the past.

    It remembers by contact, and forgets with the contact: the force servo's integral and the velocity last wanted.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """At rest, no integral."""
        self._servo = ForceServo(MAX_SPEED)
        self._wanted: dict[int, FloatArray] = {}

    @abstractmethod
    def velocity(self, settings: ControlSettings, contact: TaskContact, dt: float, limits: list[str]) -> FloatArray:
        """(3,) wanted of the point of the skin under a contact [m/s], world frame; asked once a tick."""

    def levels(
        self, settings: ControlSettings, contacts: Sequence[TaskContact], arm: ArmState, limits: list[str]
    ) -> list[Level]:
        """Velocities of all contacts' points."""
        self.keep(contacts)
        self._wanted = {contact.id: self.velocity(settings, contact, arm.dt, limits) for contact in contacts}
        return one_level([in_space(contact, self._wanted[contact.id]) for contact in contacts])

    def solve(
        self, levels: Sequence[Level], settings: ControlSettings, contacts: Sequence[TaskContact], arm: ArmState,
        limits: list[str],
    ) -> FloatArray:  # fmt: skip
        """Damped least squares."""
        return solve_freely(levels, arm.reference, arm.start, limits)

    def keep(self, contacts: Sequence[TaskContact]) -> None:
        """Forget all contacts but these."""
        self._servo.keep(contact.id for contact in contacts)

    def push(self, settings: ControlSettings, contact: TaskContact, dt: float, limits: list[str]) -> float:
        """Outward speed [m/s] for the force error, proportional and integral."""
        return self._servo.push(settings, contact.id, contact.force_error, dt, limits)

    def lagged(self, contact: TaskContact, aim: FloatArray, time: float, dt: float) -> FloatArray:
        """The velocity (3,) wanted a tick ago, nearer to ``aim`` with a time constant [s]; at once if a tick is more.

        A contact starts at rest.
        """
        before = self._wanted.get(contact.id)
        before = np.zeros(3) if before is None else before
        return before + min(dt / time, 1.0) * (aim - before) if time > dt else aim


def bounded(velocity: FloatArray, limits: list[str]) -> FloatArray:
    """The velocity (3,) of a touched point, slower if it is too fast."""
    speed = length(velocity)
    if speed <= MAX_SPEED:
        return velocity
    limits.append("speed of the touched point")
    return velocity * (MAX_SPEED / speed)
