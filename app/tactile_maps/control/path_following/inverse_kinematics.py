"""Posture in which a place of the skin reaches a point in the world with a given normal."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tactile_maps.core.arrays import FloatArray, largest
from tactile_maps.robots.kinematics import Configuration

ROUNDS = 60
"""Number of steps of one attempt."""
CLOSE = 0.002
"""Distance from the point [m] at which an attempt succeeds."""
TILT = np.deg2rad(35.0)
"""Largest angle between the normals [rad]: up to this angle the skin still presses the same object."""
_LONGEST = 0.3
"""Largest step of any joint in one iteration [rad]."""
_STRAIGHT = np.deg2rad(2.0)
_DAMPING = 0.02


@dataclass(frozen=True, eq=False)
class LinkPoint:
    """A place of the skin, fixed to its link.

    Attributes:
        link: Name of the link.
        point: (3,) link frame [m].
        normal: (3,) outward, link frame.
    """

    link: str
    point: FloatArray
    normal: FloatArray


@dataclass(frozen=True, eq=False)
class PointTarget:
    """Target of a place of the skin in the world.

    Attributes:
        point: (3,) [m].
        normal: (3,) desired direction of its normal.
    """

    point: FloatArray
    normal: FloatArray

    def raised(self, height: float) -> PointTarget:
        """Return the target moved along its normal by ``height`` [m]."""
        return PointTarget(self.point + height * self.normal, self.normal)


def solve_inverse_kinematics(
    configuration: Configuration,
    spot: LinkPoint,
    goal: PointTarget,
    start: FloatArray,
    lower: FloatArray,
    upper: FloatArray,
) -> Iterator[FloatArray | None]:
    """Yield the postures (n,) of the iteration; the last is the solution, or None if there is none near ``start``.

    The position has precedence, by least squares; the normal uses the remaining freedom; joints at a limit stay there.

    Args:
        configuration: Configuration that may be changed.
        spot: Place of the skin.
        goal: Target of the place.
        start: (n,) initial posture.
        lower: (n,) lower limits of the joints.
        upper: (n,) upper limits of the joints.

    Cost: 0.1 ms an iteration.
    """
    posture = np.clip(start, lower, upper)
    for _ in range(ROUNDS):
        configuration.update(posture)
        pose = configuration.pose(spot.link)
        normal = pose.rotation @ spot.normal
        off = goal.point - pose.points(spot.point)
        turn = goal.normal - normal
        angle = float(np.arccos(np.clip(normal @ goal.normal, -1, 1)))
        if np.linalg.norm(off) < CLOSE and angle < _STRAIGHT:
            yield posture
            return
        if angle > np.pi / 2:  # beyond 90 degrees the difference of the normals is a worse and worse direction
            turn = turn / max(float(np.linalg.norm(turn)), 1e-9)
        move = configuration.jacobian(spot.link, spot.point)
        rotate = configuration.jacobian(spot.link, spot.point + spot.normal) - move
        posture = np.clip(posture + _step(move, off, rotate, turn, posture, lower, upper), lower, upper)
        yield posture
    good = np.linalg.norm(off) < 2 * CLOSE and angle < TILT
    yield posture if good else None


def _step(
    move: FloatArray,
    off: FloatArray,
    rotate: FloatArray,
    turn: FloatArray,
    posture: FloatArray,
    lower: FloatArray,
    upper: FloatArray,
) -> FloatArray:
    """Return the step (n,) towards both goals, the position first; without the joints that would leave their range."""
    free = np.ones(len(posture), dtype=bool)
    for _ in range(len(posture)):
        first = _damped(move * free, off)
        kernel = np.diag(free.astype(float)) - np.linalg.pinv(move * free, rcond=1e-2) @ (move * free)
        step = first + kernel @ _damped(rotate @ kernel, turn - rotate @ first)
        stuck = free & (((posture <= lower) & (step < 0)) | ((posture >= upper) & (step > 0)))
        if not stuck.any():
            break
        free &= ~stuck
    fastest = largest(step)
    return step * min(1.0, _LONGEST / max(fastest, 1e-12))


def _damped(rows: FloatArray, aim: FloatArray) -> FloatArray:
    return rows.T @ np.linalg.solve(rows @ rows.T + _DAMPING**2 * np.eye(len(rows)), aim)
