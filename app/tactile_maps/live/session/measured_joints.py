"""Posture of a robot by the joint positions in readings."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.live.readings.joint_range import JOINT_TOLERANCE, SLIDE_TOLERANCE, plausible_range
from tactile_maps.live.session.implausible import ImplausibleValues
from tactile_maps.robots.model.robot import Robot

FASTEST_JOINT = 30.0
"""Largest plausible speed of a joint [rad/s], in addition to its tolerance in one step."""
FASTEST_SLIDE = 10.0
"""The same for a slide [m/s]."""
_MOST_UNKNOWN = 100
"""Number of unknown joints that are kept by name."""


class MeasuredJoints:
    """Newest positions and velocities of a robot's joints. Mutable.

    Args:
        robot: The robot; joints without a position so far are in its home posture.
        implausible: Where impossible positions are counted.

    Attributes:
        numbers: Number of each joint by its name.
        unknown: Names of received joints that the robot does not have, at most 100.
        posture: (joints,) newest positions [rad or m].
        velocity: (joints,) velocities relative to each joint's previous position [rad/s or m/s].
    """

    def __init__(self, robot: Robot, implausible: ImplausibleValues) -> None:
        self._robot = robot
        self._implausible = implausible
        self._ranges = [plausible_range(joint) for joint in robot.joints]
        self.numbers = {joint.name: number for number, joint in enumerate(robot.joints)}
        self.unknown: set[str] = set()
        self.reset()

    def reset(self) -> None:
        """Return to the home posture."""
        self.posture = self._robot.home.copy()
        self.velocity = np.zeros(len(self.posture))
        self._times = np.full(len(self.posture), -np.inf)  # session time of the newest positions

    def match(self, received: Mapping[str, float]) -> tuple[list[int], list[float]]:
        """Return numbers and positions of the robot's joints; names of unknown joints are kept.

        Raises:
            MalformedReadingError: A position is impossible.
        """
        numbers = []
        positions = []
        for name, position in received.items():
            number = self.numbers.get(name)
            if number is None:
                if len(self.unknown) < _MOST_UNKNOWN:
                    self.unknown.add(name)
                continue
            low, high = self._ranges[number]
            if not low <= position <= high:
                limits = f"From {low:g} to {high:g}"
                self._implausible.refuse("a joint's position is impossible", f"joint {name}", f"{position:g}", limits)
            numbers.append(number)
            positions.append(position)
        return numbers, positions

    def move(self, joints: list[int], positions: list[float], time: float) -> None:
        """Use the positions of a reading at ``time`` [s]; impossible speeds are reported."""
        if not joints:
            return
        passed = time - self._times[joints]  # infinite for the first position: velocity 0
        moved = np.asarray(positions) - self.posture[joints]
        self._check_speeds(joints, np.abs(moved), passed)
        before = self.velocity[joints]
        velocity = self.velocity.copy()
        velocity[joints] = np.divide(moved, passed, out=before, where=passed > 0)
        self.velocity = velocity
        self.posture[joints] = positions
        self._times[joints] = time

    def _check_speeds(self, joints: list[int], moved: FloatArray, passed: FloatArray) -> None:
        """Report each joint that cannot have moved this far [rad or m] in the time that passed [s]."""
        for number, distance, step in zip(joints, moved, passed, strict=True):
            joint = self._robot.joints[number]
            fastest, tolerance = (FASTEST_SLIDE, SLIDE_TOLERANCE) if joint.slide else (FASTEST_JOINT, JOINT_TOLERANCE)
            if distance > fastest * step + tolerance:
                self._implausible.report(f"joint {joint.name}: moved by {distance:.3g} in {step:.3g} s")
