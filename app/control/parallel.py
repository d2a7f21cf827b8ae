"""Parallel force-position control (Chiaverini and Sciavicco 1993): both act along all directions, and force wins.

In acceleration form with k_D = 1 / inertia_time, and the other gains times k_D so that they keep their meaning:
v' = k_D (K_P e_x + (k_F e_f + k_I integral of e_f) n - v). Position along the normal gives way to
the integral of force.
Against a spring k_e it is stable while k_I k_e < k_D (K_P + k_F k_e) (Routh).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from app.arrays import FloatArray
from app.control.admittance import bounded, lagged
from app.control.command import ControlSettings
from app.control.force_servo import ForceServo
from app.control.levels import Level
from app.control.reference import MAX_SPEED
from app.control.rule import ArmState, in_space, one_level, solve_freely
from app.control.task_contact import TaskContact


class Parallel:
    """No selection: a wrong normal leaks less than in hybrid control, since the integral of force has the last word."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """At rest, no integral, no place known."""
        self._servo = ForceServo(MAX_SPEED)
        self._velocity: dict[int, FloatArray] = {}
        self._begun: dict[int, FloatArray] = {}

    def levels(
        self, settings: ControlSettings, contacts: Sequence[TaskContact], arm: ArmState, limits: list[str]
    ) -> list[Level]:
        """Velocities of all contacts, wanted alike."""
        self._servo.keep(contact.id for contact in contacts)
        self._begun = {c.id: self._begun.get(c.id, c.point) for c in contacts}
        self._velocity = {c.id: self._moved(settings, c, arm.dt, limits) for c in contacts}
        return one_level([in_space(c, self._velocity[c.id]) for c in contacts])

    def solve(
        self, levels: Sequence[Level], settings: ControlSettings, contacts: Sequence[TaskContact], arm: ArmState,
        limits: list[str],
    ) -> FloatArray:  # fmt: skip
        """Damped least squares."""
        return solve_freely(levels, arm, limits)

    def _moved(self, settings: ControlSettings, contact: TaskContact, dt: float, limits: list[str]) -> FloatArray:
        normal = contact.normal
        away = normal @ (self._begun[contact.id] - contact.point)
        place = contact.along(settings.position_gain, MAX_SPEED) + settings.position_gain * away * normal
        push = self._servo.push(settings, contact.id, contact.force_error, dt, limits)
        aim = bounded(place + push * normal, limits)
        return lagged(self._velocity.get(contact.id, np.zeros(3)), aim, settings.inertia_time, dt)
