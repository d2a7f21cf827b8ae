"""Force goal that keeps contacts from slipping, for skins that measure shear."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf

import numpy as np

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.control.motion.command import RANGES, ControlSettings
from tactile_maps.control.motion.limits import Limit, LimitKind

FALL = 2.0
"""Time constant with which a raised goal falls [s]."""
_SHARE_OF_LIMIT = 0.8
"""Largest goal as a share of the force limit, above which the arm stops."""


class GripGoal:
    """Force goal that rises while a contact uses too much of its friction, and falls slowly afterwards. Mutable.

    A contact with the force Q along the skin needs the normal force Q / (mu s) to use the share s of its friction. The
    goal is the largest of these forces, so that it rises at once, and by 1 / s in each tick in which a contact slides.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget a raised goal."""
        self._goal = 0.0

    def raised(
        self, settings: ControlSettings, contacts: Sequence[ContactRegion], dt: float
    ) -> tuple[float, tuple[Limit, ...]]:
        """Return the force goal for this tick [N], and the limits that state it.

        Args:
            settings: Settings with ``force_goal``, ``friction_use`` and ``max_force``.
            contacts: Contact regions; only those with shear count.
            dt: Time since the last tick [s].
        """
        goal = settings.force_goal
        if settings.friction_use == inf:
            self._goal = goal
            return goal, ()
        needed = {
            region.link: float(np.linalg.norm(region.shear.force)) / (region.shear.friction * settings.friction_use)
            for region in contacts
            if region.shear is not None
        }
        link = max(needed, key=needed.__getitem__, default="")
        falling = goal + max(self._goal - goal, 0.0) * max(1.0 - dt / FALL, 0.0)
        most = max(min(RANGES["force_goal"][1], _SHARE_OF_LIMIT * settings.max_force), goal)
        required = max(goal, falling, needed.get(link, 0.0))
        self._goal = min(required, most)
        if required > most:
            return most, (Limit(LimitKind.GRIP_LIMITED, (link,), value=required, bound=most),)
        if self._goal > goal:
            return self._goal, (Limit(LimitKind.FORCE_GOAL_RAISED, (link,) if link else (), value=self._goal),)
        return goal, ()
