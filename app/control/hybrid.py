"""Hybrid force-position control (Raibert and Craig 1981): force along the normal, position across it."""

from __future__ import annotations

from collections.abc import Sequence

from app.arrays import FloatArray
from app.control.command import ControlSettings
from app.control.force_servo import ForceServo
from app.control.levels import Level
from app.control.reference import MAX_SPEED
from app.control.rule import ArmState, in_space, one_level, solve_freely
from app.control.task_contact import TaskContact


class Hybrid:
    """Selection by the normal that the skin tells; a normal that is wrong lets motion leak into force."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """No integral."""
        self._servo = ForceServo(MAX_SPEED)

    def levels(
        self, settings: ControlSettings, contacts: Sequence[TaskContact], arm: ArmState, limits: list[str]
    ) -> list[Level]:
        """Selected velocities of all contacts, wanted alike."""
        self._servo.keep(contact.id for contact in contacts)
        return one_level([in_space(c, self._velocity(settings, c, arm.dt, limits)) for c in contacts])

    def solve(
        self, levels: Sequence[Level], settings: ControlSettings, contacts: Sequence[TaskContact], arm: ArmState,
        limits: list[str],
    ) -> FloatArray:  # fmt: skip
        """Damped least squares."""
        return solve_freely(levels, arm, limits)

    def _velocity(self, settings: ControlSettings, contact: TaskContact, dt: float, limits: list[str]) -> FloatArray:
        along, normal = contact.along(settings.position_gain, MAX_SPEED), contact.normal
        push = self._servo.push(settings, contact.id, contact.force_error, dt, limits)
        return along - (along @ normal) * normal + push * normal
