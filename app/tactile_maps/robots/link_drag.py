"""Dragging a point of a link: the posture that moves the point to its target, as far as joints and limits allow."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactile_maps.core.arrays import ArrayFields, FloatArray
from tactile_maps.robots.kinematics import Configuration

ROUNDS = 40
"""Largest number of iterations."""
CLOSE = 1e-4
"""Distance from the target [m] at which it counts as reached."""
_DAMPING = 0.02
"""Damping of the least squares [m/rad]: joints that hardly move the point hardly move."""
_LONGEST = 0.2
"""Largest step of a joint in one iteration [rad]."""
_LEAST = 1e-6
"""Step below which the iteration ends [rad]."""


@dataclass(frozen=True, eq=False)
class LinkDrag(ArrayFields):
    """Result of a drag.

    Attributes:
        posture: (n,) the posture, within the limits.
        away: Remaining distance of the point from its target [m].
        stuck: Numbers of the joints that a limit stops, ascending.
    """

    posture: FloatArray
    away: float
    stuck: tuple[int, ...]

    @property
    def reached(self) -> bool:
        """Whether the point is at its target."""
        return self.away <= CLOSE


def drag_link(
    configuration: Configuration,
    link: str,
    point: FloatArray,
    goal: FloatArray,
    start: FloatArray,
    lower: FloatArray,
    upper: FloatArray,
) -> LinkDrag:
    """Return the posture near ``start`` that moves a point of a link to a target, or as near as possible.

    Damped least squares; a joint that would exceed its range stays at its limit, and the others compensate.

    Args:
        configuration: Kinematics of the robot, which is moved.
        link: Name of the link.
        point: (3,) the point, link frame [m].
        goal: (3,) the target, world frame [m].
        start: (n,) initial posture; clipped to the limits.
        lower: (n,) lower limits of the joints.
        upper: (n,) upper limits.

    Raises:
        RobotError: The link is unknown.

    Cost: 30 µs an iteration; a mouse move by a few pixels takes three or four.
    """
    posture = np.clip(start, lower, upper)
    stuck = np.zeros(len(posture), dtype=bool)
    for _ in range(ROUNDS):
        configuration.update(posture)
        off = goal - configuration.pose(link).points(point)
        if np.linalg.norm(off) <= CLOSE:
            break
        step, stuck = _step(configuration.jacobian(link, point), off, posture, lower, upper)
        if np.abs(step).max(initial=0.0) < _LEAST:
            break
        posture = np.clip(posture + step, lower, upper)
    configuration.update(posture)
    away = float(np.linalg.norm(goal - configuration.pose(link).points(point)))
    held = np.flatnonzero(stuck).tolist() if away > CLOSE else []
    return LinkDrag(posture, away, tuple(held))


def _step(
    rows: FloatArray, off: FloatArray, posture: FloatArray, lower: FloatArray, upper: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the step (n,) towards the goal, and the joints (n,) that a limit stops."""
    free = np.ones(len(posture), dtype=bool)
    for _ in range(len(posture) + 1):
        moved = rows * free
        step = moved.T @ np.linalg.solve(moved @ moved.T + _DAMPING**2 * np.eye(3), off)
        stuck = free & (((posture <= lower) & (step < 0)) | ((posture >= upper) & (step > 0)))
        if not stuck.any():
            break
        free &= ~stuck
    fastest = float(np.abs(step).max(initial=0.0))
    return step * min(1.0, _LONGEST / max(fastest, 1e-12)), ~free
