"""Tactile servoing with a projection matrix (Li, Schürmann, Haschke and Ritter 2013): the simplest law with a task.

Errors in the frame of the touch, two of place and one of force, are weighted by gains, chosen by a projection matrix
and turned into a velocity of the point. It takes the map for a turned copy of the skin and knows no stretch.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from app.arrays import FloatArray
from app.control.admittance import bounded
from app.control.command import ControlSettings
from app.control.force_servo import ForceServo
from app.control.levels import Level
from app.control.reference import MAX_SPEED
from app.control.rule import ArmState, in_space, one_level, solve_freely
from app.control.task_contact import TaskContact

_NO_ERROR = np.zeros(2)


class Projection:
    """Which of the three errors count is the task's matter: those of place only where the contact may not slide."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """No integral."""
        self._servo = ForceServo(MAX_SPEED)

    def levels(
        self, settings: ControlSettings, contacts: Sequence[TaskContact], arm: ArmState, limits: list[str]
    ) -> list[Level]:
        """Velocities of all contacts, wanted alike."""
        self._servo.keep(contact.id for contact in contacts)
        return one_level([in_space(c, self._velocity(settings, c, arm.dt, limits)) for c in contacts])

    def solve(
        self, levels: Sequence[Level], settings: ControlSettings, contacts: Sequence[TaskContact], arm: ArmState,
        limits: list[str],
    ) -> FloatArray:  # fmt: skip
        """Damped least squares."""
        return solve_freely(levels, arm, limits)

    def _velocity(self, settings: ControlSettings, contact: TaskContact, dt: float, limits: list[str]) -> FloatArray:
        left, _, right = np.linalg.svd(contact.to_map, full_matrices=False)
        frame = np.concatenate([-left @ right, contact.normal[None]])  # of the touch: two ways on the map, and out
        free = contact.error is None
        chosen = np.array([0.0, 0.0, 1.0]) if free else np.ones(3)
        place = _NO_ERROR if contact.error is None else settings.position_gain * contact.error + contact.velocity
        push = self._servo.push(settings, contact.id, contact.force_error, dt, limits)
        return bounded(frame.T @ (chosen * np.array([*place, push])), limits)
