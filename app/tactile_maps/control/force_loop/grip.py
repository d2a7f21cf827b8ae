"""Force goal that keeps contacts from slipping, for skins that measure shear.

Opposing contacts hold an object between them. Their forces along the skin add up to the load of the object; what they
push against each other through it needs no friction of the whole grip. Contacts count as opposing where the line
between them is within the friction cones of both, as in a force-closure grasp with two fingers (Nguyen 1988).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import atan, cos, inf

import numpy as np

from tactile_maps.contacts.detection.contact_shear import ContactShear
from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.control.motion.command import RANGES, ControlSettings
from tactile_maps.control.motion.limits import Limit, LimitKind
from tactile_maps.core.arrays import ArrayFields, FloatArray, length
from tactile_maps.robots.kinematics import Configuration

FALL = 2.0
"""Time constant with which a raised goal falls [s]."""
_SHARE_OF_LIMIT = 0.8
"""Largest goal as a share of the force limit, above which the arm stops."""


@dataclass(frozen=True, eq=False)
class _Held(ArrayFields):
    """A contact with its shear; (3,) point [m], outward normal and force along the skin [N], world frame."""

    region: ContactRegion
    shear: ContactShear
    point: FloatArray
    normal: FloatArray
    along: FloatArray

    def faces(self, other: _Held) -> bool:
        """Whether the other contact is within the friction cone of this one."""
        apart = other.point - self.point
        return float(self.normal.dot(apart)) > cos(atan(self.shear.friction)) * length(apart)


class GripGoal:
    """Force goal that rises while contacts use too much of their friction, and falls slowly afterwards. Mutable.

    An object with the load Q along the skin, held by contacts with the friction coefficients mu, needs the normal force
    F = Q / (s sum mu) at each of them to use the share s of their friction. The goal is the largest of these forces, so
    that it rises at once, and by 1 / s in each tick in which all contacts of an object slide. A single one of several
    contacts may slide: it then bears less of the load and the others more. Pressing harder would not hold it, since the
    forces that opposing contacts exert on each other along the skin grow with the normal force.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget a raised goal."""
        self._goal = 0.0

    def raised(
        self, settings: ControlSettings, contacts: Sequence[ContactRegion], configuration: Configuration, dt: float
    ) -> tuple[float, tuple[Limit, ...]]:
        """Return the force goal for this tick [N], and the limits that state it.

        Args:
            settings: Settings with ``force_goal``, ``friction_use`` and ``max_force``.
            contacts: Contact regions; only those with shear count.
            configuration: The robot at its current posture.
            dt: Time since the last tick [s].
        """
        goal = settings.force_goal
        if settings.friction_use == inf:
            self._goal = goal
            return goal, ()
        held = max(_objects(contacts, configuration), key=_needed, default=[])
        links = tuple(dict.fromkeys(one.region.link for one in held))
        needed = _needed(held) / settings.friction_use if held else 0.0
        falling = goal + max(self._goal - goal, 0.0) * max(1.0 - dt / FALL, 0.0)
        most = max(min(RANGES["force_goal"][1], _SHARE_OF_LIMIT * settings.max_force), goal)
        required = max(goal, falling, needed)
        self._goal = min(required, most)
        if required > most:
            return most, (Limit(LimitKind.GRIP_LIMITED, links, value=required, bound=most),)
        if self._goal > goal:
            return self._goal, (Limit(LimitKind.FORCE_GOAL_RAISED, links, value=self._goal),)
        return goal, ()


def _needed(held: Sequence[_Held]) -> float:
    """Return the normal force of each contact at which an object uses all of its friction [N]."""
    load = length(np.sum([one.along for one in held], axis=0))
    return load / sum(one.shear.friction for one in held)


def _objects(contacts: Sequence[ContactRegion], configuration: Configuration) -> list[list[_Held]]:
    """Return the contacts with shear, those that oppose each other on one object together."""
    objects = list[list[_Held]]()
    for region in contacts:
        if region.shear is None:
            continue
        pose = configuration.pose(region.link)
        one = _Held(
            region,
            region.shear,
            pose.points(region.link_position),
            pose.rotation @ region.link_normal,
            pose.rotation @ region.shear.force,
        )
        joined = [held for held in objects if any(one.faces(other) and other.faces(one) for other in held)]
        objects = [held for held in objects if held not in joined]
        objects.append([one, *(other for held in joined for other in held)])
    return objects
