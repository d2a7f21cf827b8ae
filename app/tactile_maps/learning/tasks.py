"""The three environments: what touches the arm, what is wanted, what is rewarded and when an episode ends."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium import spaces

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.core.arrays import BoolArray, FloatArray
from tactile_maps.core.errors import LearningError
from tactile_maps.learning.environment import SkinEnvironment
from tactile_maps.learning.observation import Observation
from tactile_maps.learning.touched_arm import session_beside_ball
from tactile_maps.session.session import Session

LOST_STEPS = 25
"""Steps without a contact after which it counts as lost."""


def _random_taxel(environment: SkinEnvironment) -> int:
    return int(environment.np_random.integers(len(environment.prepared.skin)))


class FollowEnvironment(SkinEnvironment):
    """A ball that stands still touches the skin; the arm is to move so that the contact follows a straight path.

    The path leads from a random taxel 3 cm over the map in a random direction, on the skin throughout, at 1 cm/s.
    ``goal`` (2,) in the observation is where on the map the contact is wanted now [m]. The reward is 1 for a contact
    there and falls by 1 for each centimetre, to -1 at least, which is also that of no contact. It terminates when the
    contact has been lost for half a second.
    """

    length = 0.03
    speed = 0.01
    metre_per_reward = 0.01

    def goal_spaces(self) -> dict[str, Any]:
        """The place where the contact is wanted."""
        return {"goal": spaces.Box(-1e3, 1e3, (2,), np.float32)}

    def goal(self) -> Observation:
        """The place where the contact is wanted."""
        return {"goal": self._wanted().astype(np.float32)}

    def begin(self, settings: ControlSettings, seed: int) -> Session:
        """A ball at the start of a path that fits on the skin."""
        taxel, self._direction = self._fitting_path()
        self._start = self.prepared.map.taxel_points[taxel]
        self._lost = 0
        return session_beside_ball(self.prepared, self.prepared.skin.taxel_point(taxel), settings, seed=seed)

    def judge(self) -> tuple[float, bool]:
        """See the class."""
        contact = self.contact
        if contact is None:
            self._lost += 1
            return -1.0, self._lost >= LOST_STEPS
        self._lost = 0
        error = float(np.linalg.norm(contact - self._wanted()))
        return max(1.0 - error / self.metre_per_reward, -1.0), False

    def _wanted(self) -> FloatArray:
        return self._start + min(self.speed * self.session.frame.time, self.length) * self._direction

    def _fitting_path(self) -> tuple[int, FloatArray]:
        for _ in range(1000):
            taxel = _random_taxel(self)
            angle = self.np_random.uniform(0, 2 * np.pi)
            direction = np.array([np.cos(angle), np.sin(angle)])
            ways = np.linspace(0, self.length, 16)[:, None] * direction
            patch, _, _ = self.prepared.map.to_body_many(self.prepared.map.taxel_points[taxel] + ways)
            if (patch == patch[0]).all() and patch[0] >= 0:
                return taxel, direction
        remedy = "Choose a larger skin"
        raise LearningError("no path fits on the map", value=f"{self.length} m", remedy=remedy)


class RetreatEnvironment(SkinEnvironment):
    """A ball comes at a random place of the skin, 1.5 cm into where it is, in a random time; the arm is to yield.

    The reward is minus the force of all contacts, in units of 5 N. It terminates when the arm, once touched, has been
    free for half a second.
    """

    depth = 0.015
    force_per_reward = 5.0
    force_goal = 0.5

    def begin(self, settings: ControlSettings, seed: int) -> Session:
        """A ball on its way in."""
        seconds = self.np_random.uniform(0.3, 1.0)
        way = np.array([[0.0, 0.002], [seconds, -self.depth], [600.0, -self.depth]])
        self._touched = False
        self._free = 0
        at = self.prepared.skin.taxel_point(_random_taxel(self))
        return session_beside_ball(self.prepared, at, settings, seed=seed, way=way)

    def judge(self) -> tuple[float, bool]:
        """See the class."""
        regions = self.session.frame.regions
        self._touched = self._touched or bool(regions)
        self._free = 0 if regions or not self._touched else self._free + 1
        return -sum(region.force for region in regions) / self.force_per_reward, self._free >= LOST_STEPS


class ExploreEnvironment(SkinEnvironment):
    """A ball that stands still touches a random place; the arm is to bring the contact to as many places as it can.

    Places are the cells of 8 by 8 over the map in which there are taxels. ``visited`` (8, 8) in the observation is 1
    for those where a contact has been. The reward is the number of cells a step adds. It terminates when all have been
    visited, or the contact has been lost for half a second.
    """

    cells = 8

    def goal_spaces(self) -> dict[str, Any]:
        """The cells visited."""
        return {"visited": spaces.MultiBinary((self.cells, self.cells))}

    def goal(self) -> Observation:
        """The cells visited."""
        return {"visited": self._visited.astype(np.int8)}

    def begin(self, settings: ControlSettings, seed: int) -> Session:
        """A ball somewhere."""
        self._visited = np.zeros((self.cells, self.cells), dtype=bool)
        self._lost = 0
        at = self.prepared.skin.taxel_point(_random_taxel(self))
        return session_beside_ball(self.prepared, at, settings, seed=seed)

    def judge(self) -> tuple[float, bool]:
        """See the class."""
        contact = self.contact
        self._lost = self._lost + 1 if contact is None else 0
        before = int(self._visited.sum())
        if contact is not None:
            self._visited |= self._cells_at(contact[None]) & self._cells_at(self.prepared.map.taxel_points)
        now = int(self._visited.sum())
        all_ = int(self._cells_at(self.prepared.map.taxel_points).sum())
        return float(now - before), now == all_ or self._lost >= LOST_STEPS

    def _cells_at(self, points: FloatArray) -> BoolArray:
        """(8, 8) the cells in which points (k, 2) of the map lie."""
        low, high = self.prepared.map.bounds
        found = np.clip(((points - low) / (high - low) * self.cells).astype(int), 0, self.cells - 1)
        cells = np.zeros((self.cells, self.cells), dtype=bool)
        cells[found[:, 1], found[:, 0]] = True
        return cells
