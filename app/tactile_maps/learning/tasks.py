"""The three environments: what touches the arm, the goal, the reward and the end of an episode."""

from __future__ import annotations

from typing import Any

import numpy as np
from gymnasium import spaces

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.core.arrays import BoolArray, FloatArray
from tactile_maps.core.errors import LearningError
from tactile_maps.learning.environment import SkinEnvironment
from tactile_maps.learning.observation import Observation
from tactile_maps.learning.touched_arm import touched_session
from tactile_maps.session.session import Session

LOST_STEPS = 25
"""Number of steps without a contact after which it is lost."""


def _random_taxel(environment: SkinEnvironment) -> int:
    return int(environment.np_random.integers(len(environment.prepared.skin)))


class FollowEnvironment(SkinEnvironment):
    """A fixed ball touches the skin; the arm has to move so that the contact follows a straight path.

    The path leads from a random taxel 3 cm over the map in a random direction, entirely on the skin, at 1 cm/s.
    ``goal`` (2,) in the observation is the current target of the contact on the map [m]. The reward is 1 for a contact
    there and decreases by 1 per centimetre, to at least -1, which is also the reward without a contact. An episode
    terminates when the contact has been lost for half a second.
    """

    length = 0.03
    speed = 0.01
    metre_per_reward = 0.01

    def goal_spaces(self) -> dict[str, Any]:
        return {"goal": spaces.Box(-1e3, 1e3, (2,), np.float32)}

    def goal(self) -> Observation:
        return {"goal": self._target().astype(np.float32)}

    def begin(self, settings: ControlSettings, seed: int) -> Session:
        taxel, self._direction = self._fitting_path()
        self._start = self.prepared.map.taxel_points[taxel]
        self._lost = 0
        return touched_session(self.prepared, self.prepared.skin.taxel_point(taxel), settings, seed=seed)

    def judge(self) -> tuple[float, bool]:
        contact = self.contact
        if contact is None:
            self._lost += 1
            return -1.0, self._lost >= LOST_STEPS
        self._lost = 0
        error = float(np.linalg.norm(contact - self._target()))
        return max(1.0 - error / self.metre_per_reward, -1.0), False

    def _target(self) -> FloatArray:
        return self._start + min(self.speed * self.session.frame.time, self.length) * self._direction

    def _fitting_path(self) -> tuple[int, FloatArray]:
        for _ in range(1000):
            taxel = _random_taxel(self)
            angle = self.np_random.uniform(0, 2 * np.pi)
            direction = np.array([np.cos(angle), np.sin(angle)])
            steps = np.linspace(0, self.length, 16)[:, None] * direction
            patch, _, _ = self.prepared.map.to_body_many(self.prepared.map.taxel_points[taxel] + steps)
            if (patch == patch[0]).all() and patch[0] >= 0:
                return taxel, direction
        remedy = "Choose a larger skin"
        raise LearningError("no path fits on the map", value=f"{self.length} m", remedy=remedy)


class RetreatEnvironment(SkinEnvironment):
    """A ball presses 1.5 cm into a random place of the skin within a random time; the arm has to retreat.

    The reward is minus the force of all contacts, in units of 5 N. An episode terminates when the arm, once touched,
    has been free for half a second.
    """

    depth = 0.015
    force_per_reward = 5.0
    force_goal = 0.5

    def begin(self, settings: ControlSettings, seed: int) -> Session:
        seconds = self.np_random.uniform(0.3, 1.0)
        track = np.array([[0.0, 0.002], [seconds, -self.depth], [600.0, -self.depth]])
        self._touched = False
        self._free = 0
        at = self.prepared.skin.taxel_point(_random_taxel(self))
        return touched_session(self.prepared, at, settings, seed=seed, track=track)

    def judge(self) -> tuple[float, bool]:
        regions = self.session.frame.regions
        self._touched = self._touched or bool(regions)
        self._free = 0 if regions or not self._touched else self._free + 1
        return -sum(region.force for region in regions) / self.force_per_reward, self._free >= LOST_STEPS


class ExploreEnvironment(SkinEnvironment):
    """A fixed ball touches a random place; the arm has to move the contact to as many places as possible.

    Places are the cells of 8 by 8 over the map that contain taxels. ``visited`` (8, 8) in the observation is 1 for
    cells where a contact has been. The reward is the number of new cells of a step. An episode terminates when all have
    been visited, or when the contact has been lost for half a second.
    """

    cells = 8

    def goal_spaces(self) -> dict[str, Any]:
        return {"visited": spaces.MultiBinary((self.cells, self.cells))}

    def goal(self) -> Observation:
        return {"visited": self._visited.astype(np.int8)}

    def begin(self, settings: ControlSettings, seed: int) -> Session:
        self._visited = np.zeros((self.cells, self.cells), dtype=bool)
        self._lost = 0
        at = self.prepared.skin.taxel_point(_random_taxel(self))
        return touched_session(self.prepared, at, settings, seed=seed)

    def judge(self) -> tuple[float, bool]:
        contact = self.contact
        self._lost = self._lost + 1 if contact is None else 0
        before = int(self._visited.sum())
        cells = self._cells_at(self.prepared.map.taxel_points)
        if contact is not None:
            self._visited |= self._cells_at(contact[None]) & cells
        now = int(self._visited.sum())
        return float(now - before), now == int(cells.sum()) or self._lost >= LOST_STEPS

    def _cells_at(self, points: FloatArray) -> BoolArray:
        """Return (8, 8) True for the cells that contain points (k, 2) of the map."""
        low, high = self.prepared.map.bounds
        found = np.clip(((points - low) / (high - low) * self.cells).astype(int), 0, self.cells - 1)
        cells = np.zeros((self.cells, self.cells), dtype=bool)
        cells[found[:, 1], found[:, 0]] = True
        return cells
