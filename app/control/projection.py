"""Tactile servoing with a projection matrix (Li, Schürmann, Haschke and Ritter 2013): the simplest law with a task.

Errors in the frame of the touch, two of place and one of force, are weighted by gains, chosen by a projection matrix
and turned into a velocity of the point. It takes the map for a turned copy of the skin and knows no stretch.
"""

from __future__ import annotations

from app.arrays import FloatArray
from app.control.command import ControlSettings
from app.control.point_rule import PointRule, bounded
from app.control.task_contact import TaskContact


class Projection(PointRule):
    """Which of the three errors count is the task's matter: those of place only where the contact may not slide."""

    def velocity(self, settings: ControlSettings, contact: TaskContact, dt: float, limits: list[str]) -> FloatArray:
        """The chosen errors, turned from the frame of the touch into space."""
        push = self.push(settings, contact, dt, limits) * contact.normal
        if contact.error is None:
            return bounded(push, limits)
        place = settings.position_gain * contact.error + contact.velocity
        return bounded(push - place.dot(contact.map_axes), limits)
