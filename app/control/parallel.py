"""Parallel force-position control (Chiaverini and Sciavicco 1993): both act along all directions, and force wins.

In acceleration form with k_D = 1 / inertia_time, and the other gains times k_D so that they keep their meaning:
v' = k_D (K_P e_x + (k_F e_f + k_I integral of e_f) n - v). Position along the normal gives way to
the integral of force.
Against a spring k_e it is stable while k_I k_e < k_D (K_P + k_F k_e) (Routh).
"""

from __future__ import annotations

from collections.abc import Sequence

from app.arrays import FloatArray
from app.control.command import ControlSettings
from app.control.point_rule import PointRule, bounded
from app.control.reference import MAX_SPEED
from app.control.task_contact import TaskContact


class Parallel(PointRule):
    """No selection: a wrong normal leaks less than in hybrid control, since the integral of force has the last word.

    Where a contact began is its wanted place along the normal.
    """

    def reset(self) -> None:
        """At rest, no integral, no place known."""
        super().reset()
        self._begun: dict[int, FloatArray] = {}

    def keep(self, contacts: Sequence[TaskContact]) -> None:
        """Where the others began is forgotten too."""
        super().keep(contacts)
        self._begun = {contact.id: self._begun.get(contact.id, contact.point) for contact in contacts}

    def velocity(self, settings: ControlSettings, contact: TaskContact, dt: float, limits: list[str]) -> FloatArray:
        """Both errors' answers added up, taken up slowly."""
        normal = contact.normal
        away = normal.dot(self._begun[contact.id] - contact.point)
        push = self.push(settings, contact, dt, limits) + settings.position_gain * away
        aim = bounded(contact.along(settings.position_gain, MAX_SPEED) + push * normal, limits)
        return self.lagged(contact, aim, settings.inertia_time, dt)
