"""Admittance: force and map errors move a mass in a viscous liquid, and the arm goes where it goes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from app.arrays import FloatArray
from app.control.command import ControlSettings
from app.control.levels import Level
from app.control.reference import MAX_SPEED
from app.control.rule import ArmState, in_space, one_level, solve_freely
from app.control.task_contact import TaskContact


class Admittance:
    """Mobility ``force_gain`` and time constant ``inertia_time``: M v' + v / gain = force error, M = time / gain.

    Without integral: what comes at a speed v is met with an error v / gain.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """At rest."""
        self._velocity: dict[int, FloatArray] = {}

    def levels(
        self, settings: ControlSettings, contacts: Sequence[TaskContact], arm: ArmState, limits: list[str]
    ) -> list[Level]:
        """Velocities of the masses at all contacts, wanted alike."""
        self._velocity = {c.id: self._moved(settings, c, arm.dt, limits) for c in contacts}
        return one_level([in_space(c, self._velocity[c.id]) for c in contacts])

    def solve(
        self, levels: Sequence[Level], settings: ControlSettings, contacts: Sequence[TaskContact], arm: ArmState,
        limits: list[str],
    ) -> FloatArray:  # fmt: skip
        """Damped least squares."""
        return solve_freely(levels, arm, limits)

    def _moved(self, settings: ControlSettings, contact: TaskContact, dt: float, limits: list[str]) -> FloatArray:
        aim = contact.along(settings.position_gain, MAX_SPEED)
        aim = bounded(aim + settings.force_gain * contact.force_error * contact.normal, limits)
        return lagged(self._velocity.get(contact.id, np.zeros(3)), aim, settings.inertia_time, dt)


def bounded(velocity: FloatArray, limits: list[str]) -> FloatArray:
    """The velocity (3,) of a touched point, slower if it is too fast."""
    speed = float(np.linalg.norm(velocity))
    if speed <= MAX_SPEED:
        return velocity
    limits.append("speed of the touched point")
    return velocity * (MAX_SPEED / speed)


def lagged(now: FloatArray, aim: FloatArray, time: float, dt: float) -> FloatArray:
    """``now`` a tick nearer to ``aim``, with a time constant [s]; at once if that is shorter than a tick."""
    return now + min(dt / time, 1.0) * (aim - now) if time > dt else aim
