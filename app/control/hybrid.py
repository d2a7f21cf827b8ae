"""Hybrid force-position control (Raibert and Craig 1981): force along the normal, position across it."""

from __future__ import annotations

from app.arrays import FloatArray
from app.control.command import ControlSettings
from app.control.point_rule import PointRule
from app.control.reference import MAX_SPEED
from app.control.task_contact import TaskContact


class Hybrid(PointRule):
    """Selection by the normal that the skin tells; a normal that is wrong lets motion leak into force."""

    def velocity(self, settings: ControlSettings, contact: TaskContact, dt: float, limits: list[str]) -> FloatArray:
        """What brings the contact on, without its part along the normal, where force is served."""
        along, normal = contact.along(settings.position_gain, MAX_SPEED), contact.normal
        return along + (self.push(settings, contact, dt, limits) - along.dot(normal)) * normal
