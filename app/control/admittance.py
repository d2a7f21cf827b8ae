"""Admittance: force and map errors move a mass in a viscous liquid, and the arm goes where it goes."""

from __future__ import annotations

from app.arrays import FloatArray
from app.control.command import ControlSettings
from app.control.point_rule import PointRule, bounded
from app.control.reference import MAX_SPEED
from app.control.task_contact import TaskContact


class Admittance(PointRule):
    """Mobility ``force_gain`` and time constant ``inertia_time``: M v' + v / gain = force error, M = time / gain.

    Without integral: what comes at a speed v is met with an error v / gain.
    """

    def velocity(self, settings: ControlSettings, contact: TaskContact, dt: float, limits: list[str]) -> FloatArray:
        """That of the mass at the contact."""
        place = contact.along(settings.position_gain, MAX_SPEED)
        aim = bounded(place + settings.force_gain * contact.force_error * contact.normal, limits)
        return self.lagged(contact, aim, settings.inertia_time, dt)
