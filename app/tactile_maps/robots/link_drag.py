"""A point of a link led by hand: the posture that brings it where it is wanted, as far as joints and limits let it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactile_maps.core.arrays import FloatArray, freeze_arrays
from tactile_maps.robots.kinematics import Configuration

ROUNDS = 40
"""Of one answer, at most."""
CLOSE = 1e-4
"""To the place wanted [m], at which it is reached."""
_DAMPING = 0.02
"""Of least squares [m/rad]: a joint that hardly moves the point is hardly asked to."""
_LONGEST = 0.2
"""Step of any joint in one round [rad]."""
_LEAST = 1e-6
"""Step after which no more is to be had [rad]."""


@dataclass(frozen=True, eq=False)
class LinkDrag:
    """Where a drag has come.

    Attributes:
        posture: (n,) within the limits.
        away: How far the point still is from where it is wanted [m].
        stuck: Numbers of the joints that would have gone on beyond a limit, rising.
    """

    posture: FloatArray
    away: float
    stuck: tuple[int, ...]

    def __post_init__(self) -> None:
        freeze_arrays(self, "posture")

    @property
    def reached(self) -> bool:
        """Whether the point is where it is wanted."""
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
    """The posture near ``start`` that brings a point of a link to a place, or as near as it goes.

    Damped least squares; a joint that would leave its range stays at its limit, and the others do its part.

    Args:
        configuration: Moved as it likes.
        link: Name of the link.
        point: (3,) of it, link frame [m].
        goal: (3,) where it is wanted, world [m].
        start: (n,) where to begin; brought within the limits.
        lower: (n,) limits of the joints.
        upper: (n,).

    Raises:
        RobotError: There is no such link.

    Cost: 30 µs a round; a mouse that moves on by a few pixels takes three or four.
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
    """(n,) towards the goal without the joints that would leave their range, and which those are."""
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
