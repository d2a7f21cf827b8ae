"""Motion of the robot through waypoints, joined by minimum-jerk polynomials from rest to rest."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import SceneError, check_range, did_you_mean
from tactile_maps.robots.model.robot import Joint, Robot

Unit: TypeAlias = Literal["rad", "deg"]


@dataclass(frozen=True)
class Waypoint:
    """Posture of a motion.

    Attributes:
        posture: Positions by joint name, where the other joints keep theirs; or of all joints in their order.
        seconds: Time to reach it from the previous waypoint.
        rest: Time to stay there [s].
        unit: Unit of the positions of hinges: ``rad`` or ``deg``; slides are always in metres.

    Raises:
        SceneError: A number is out of range.
    """

    posture: Mapping[str, float] | tuple[float, ...] = ()
    seconds: float = 2.0
    rest: float = 0.0
    unit: Unit = "rad"

    def __post_init__(self) -> None:
        for name, value, low in (("seconds", self.seconds, 0.01), ("rest", self.rest, 0.0)):
            check_range("the motion", value, low, 3600.0, error=SceneError, place=f"motion.{name}", unit="s")
        values = self.posture.values() if isinstance(self.posture, Mapping) else self.posture
        if not all(map(math.isfinite, values)):
            raise SceneError("a posture must be finite numbers", place="motion.posture", value=self.posture)


class Motion:
    """Repeated motion through waypoints, starting at the robot's home.

    Between two waypoints every joint follows the minimum-jerk polynomial 10 s³ - 15 s⁴ + 6 s⁵ of the share s of the
    time (Flash and Hogan 1985): position, speed and acceleration are continuous, and each waypoint is reached at rest.
    The first round starts at home, later ones at the last waypoint.

    Args:
        robot: The robot.
        waypoints: The waypoints; without any, the robot stays at home.

    Raises:
        SceneError: A waypoint names an unknown joint, is outside the joint limits, or would require a higher speed
            than the model allows.
    """

    def __init__(self, robot: Robot, waypoints: Sequence[Waypoint]) -> None:
        self._home = robot.home
        postures = [robot.home]
        for number, waypoint in enumerate(waypoints):
            postures.append(_posture(robot, waypoint, postures[-1], f"motion.{number}.posture"))
        for number, waypoint in enumerate(waypoints):
            starts = [postures[number]] if number else [robot.home, postures[-1]]  # the first one is reached from both
            for before in starts:
                _check_speeds(robot, postures[number + 1] - before, waypoint.seconds, f"motion.{number}.seconds")
        self._goals = np.array(postures[1:]).reshape(len(waypoints), len(robot.home))
        self._seconds = np.array([waypoint.seconds for waypoint in waypoints])
        lasts = self._seconds + np.array([waypoint.rest for waypoint in waypoints])
        self._starts = np.concatenate([[0.0], np.cumsum(lasts)])

    @property
    def period(self) -> float:
        """Duration of one round [s]; 0 without waypoints."""
        return float(self._starts[-1])

    def posture(self, time: float) -> FloatArray:
        """Return the posture (n,) at ``time`` >= 0 [s]. Cost: about 5 µs."""
        if not len(self._goals):
            return self._home
        rounds, within = divmod(time, self.period)
        number = int(np.searchsorted(self._starts, within, side="right")) - 1
        number = min(number, len(self._goals) - 1)
        before = self._goals[number - 1] if number or rounds else self._home
        share = min((within - self._starts[number]) / self._seconds[number], 1.0)
        eased = share**3 * (10 - 15 * share + 6 * share**2)
        return np.asarray(before + eased * (self._goals[number] - before))


_PEAK = 15 / 8
"""Ratio of the largest to the mean speed between two waypoints."""


def _check_speeds(robot: Robot, way: FloatArray, seconds: float, place: str) -> None:
    """Raise an error if a joint would exceed the speed that its model allows on a displacement ``way`` (n,)."""
    for joint, distance in zip(robot.joints, np.abs(way).tolist(), strict=True):
        least = _PEAK * distance / joint.max_speed
        if seconds < least * (1 - 1e-9):
            unit = "m/s" if joint.slide else "rad/s"
            problem = f"the joint {joint.name} would be faster than its model allows ({joint.max_speed:.4g} {unit})"
            remedy = f"Choose at least {np.ceil(1e3 * least) / 1e3:g} s"
            raise SceneError(problem, place=place, value=seconds, remedy=remedy)


def _posture(robot: Robot, waypoint: Waypoint, before: FloatArray, place: str) -> FloatArray:
    names = robot.joint_names
    if isinstance(waypoint.posture, Mapping):
        unknown = [name for name in waypoint.posture if name not in names]
        if unknown:
            remedy = did_you_mean(unknown[0], names)
            raise SceneError(
                "the robot has no such joint", place=f"{place}.{unknown[0]}", value=unknown[0], remedy=remedy
            )
        targets = dict(waypoint.posture)
    else:
        if len(waypoint.posture) != len(names):
            remedy = f"Give {len(names)} numbers, or joints by name"
            count = len(waypoint.posture)
            raise SceneError("a posture needs one number per joint", place=place, value=count, remedy=remedy)
        targets = dict(zip(names, waypoint.posture, strict=True))
    goal = before.copy()
    for number, joint in enumerate(robot.joints):
        if joint.name in targets:
            goal[number] = _position(joint, targets[joint.name], waypoint.unit, f"{place}.{joint.name}")
    return goal


def _position(joint: Joint, value: float, unit: Unit, place: str) -> float:
    scale = math.pi / 180 if unit == "deg" and not joint.slide else 1.0
    if not joint.lower - 1e-9 <= scale * value <= joint.upper + 1e-9:
        remedy = f"Choose {joint.lower / scale:.4g} to {joint.upper / scale:.4g} {'m' if joint.slide else unit}"
        raise SceneError("the joint position is out of range", place=place, value=value, remedy=remedy)
    return scale * value
