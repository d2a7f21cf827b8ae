"""Search from the current posture for the posture that brings a place of the skin nearest to a point in the world.

The distance is minimized within the joint limits by damped least squares (Levenberg and Marquardt), also from postures
around the current one, since a stretched arm is at a stationary point. Unlike ``ReachSearch`` it proves nothing about
postures far away, which a contact that slides on the skin cannot reach without being lost.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tactile_maps.control.motion.joint_impedance import joint_limits
from tactile_maps.control.path_following.inverse_kinematics import CLOSE
from tactile_maps.core.arrays import FloatArray, length
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.robots.model.robot import Robot

_STARTS = 4
"""Number of postures around the current one from which the search starts, too."""
_AROUND = 0.3
"""Largest distance of these from the current posture [rad, or m for a slide]."""
_ROUNDS = 30
_PER_TICK = 6
"""Steps of the search from one start, and steps in one tick."""
_SMALL = 1e-5
"""Gain of a step below which a search has converged [m]."""
_BEYOND = 2 * CLOSE
"""Distance above which a target counts as out of reach [m]; the point of contact moves as the skin turns."""


def nearest_distances(
    configuration: Configuration,
    link: str,
    place: FloatArray,
    goal: FloatArray,
    start: FloatArray,
    limits: tuple[FloatArray, FloatArray],
) -> Iterator[float]:
    """Yield the distance [m] to which the search has brought a place of the skin, step by step.

    Args:
        configuration: Configuration that may be changed.
        link: Link of the place.
        place: (3,) link frame [m].
        goal: (3,) point in the world [m].
        start: (n,) current posture.
        limits: Lower and upper limits (n,) of the joints.
    """
    lower, upper = limits
    lot = np.random.default_rng(0)
    nearest = np.inf
    for attempt in range(1 + _STARTS):
        posture = np.clip(start + (lot.uniform(-_AROUND, _AROUND, len(start)) if attempt else 0.0), lower, upper)
        damping = 1e-2
        configuration.update(posture)
        off = goal - configuration.pose(link).points(place)
        for _ in range(_ROUNDS):
            move = configuration.jacobian(link, place)
            slope = off.dot(move)
            stuck = ((posture <= lower) & (slope < 0)) | ((posture >= upper) & (slope > 0))
            free = move * ~stuck
            step = free.T.dot(np.linalg.solve(free.dot(free.T) + damping**2 * np.eye(3), off))
            tried = np.clip(posture + step, lower, upper)
            configuration.update(tried)
            left = goal - configuration.pose(link).points(place)
            gain = length(off) - length(left)
            if gain > 0:
                posture = tried
                off = left
                damping = damping / 3
            else:
                configuration.update(posture)
                damping = 4 * damping
            nearest = min(nearest, length(off))
            yield nearest
            if nearest < CLOSE:
                return
            if 0 < gain < _SMALL or damping > 1e2:
                break


class TargetReach:
    """Decides in small steps, tick by tick, whether the target of a contact is out of reach. Mutable.

    Args:
        robot: The robot.

    Cost: 0.4 ms a tick, for at most 25 ticks.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._configuration: Configuration | None = None
        self.reset()

    def reset(self) -> None:
        """Discard the result."""
        self._target: SurfacePoint | None = None
        self._goal: FloatArray = np.zeros(3)
        self._search: Iterator[float] = iter(())
        self._short_by = 0.0
        self._done = False

    def short_by(
        self, target: SurfacePoint, link: str, place: FloatArray, goal: FloatArray, posture: FloatArray
    ) -> float | None:
        """Return the distance [m] by which a target is out of reach; None while that is not known, or if it is not.

        Args:
            target: The target; another one starts a new search.
            link: Link of the target.
            place: (3,) the target, link frame [m].
            goal: (3,) point at which the skin is touched, world frame [m]; if it moves, a new search starts.
            posture: (n,) current posture.
        """
        if target != self._target or length(goal - self._goal) > CLOSE:
            self._configuration = self._configuration or Configuration(self._robot)
            limits = joint_limits(self._robot)
            self._search = nearest_distances(self._configuration, link, place, goal, posture, limits)
            self._target = target
            self._goal = goal
            self._done = False
        for _ in range(0 if self._done else _PER_TICK):
            found = next(self._search, None)
            if found is None:
                self._done = True
                break
            self._short_by = found
        return self._short_by if self._done and self._short_by > _BEYOND else None
