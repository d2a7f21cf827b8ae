"""Tasks in order (Nakamura 1987; Siciliano and Slotine 1991): force first, then the place, then the rest posture."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from app.arrays import FloatArray
from app.control.command import ControlSettings
from app.control.force_servo import ForceServo
from app.control.levels import Level
from app.control.reference import MAX_SPEED
from app.control.rule import ArmState, solve_freely
from app.control.task_contact import TaskContact


class Priority:
    """What the arm cannot do besides keeping the force, it leaves; near a singularity the weak direction is damped."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """No integral."""
        self._servo = ForceServo(MAX_SPEED)

    def levels(
        self, settings: ControlSettings, contacts: Sequence[TaskContact], arm: ArmState, limits: list[str]
    ) -> list[Level]:
        """Forces of all contacts, then places of those that may not slide."""
        self._servo.keep(contact.id for contact in contacts)
        push = [self._servo.push(settings, c.id, c.force_error, arm.dt, limits) for c in contacts]
        levels = [Level(np.stack([c.outward for c in contacts]), np.array(push))]
        held = [c for c in contacts if c.error is not None]
        if held:
            rows = np.concatenate([c.map_axes.dot(c.move) for c in held])
            speed = np.concatenate([c.map_axes.dot(c.along(settings.position_gain, MAX_SPEED)) for c in held])
            levels.append(Level(rows, speed))
        return levels

    def solve(
        self, levels: Sequence[Level], settings: ControlSettings, contacts: Sequence[TaskContact], arm: ArmState,
        limits: list[str],
    ) -> FloatArray:  # fmt: skip
        """Damped least squares, level after level; what they leave free goes to rest."""
        return solve_freely(levels, arm.reference, arm.start, limits, rest=arm.home)
