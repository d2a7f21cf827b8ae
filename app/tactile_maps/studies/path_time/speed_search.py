"""The shortest time in which a path can be followed well enough: found by bisection over the speed along it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np

from tactile_maps.control.motion.command import ControlSettings
from tactile_maps.studies.testbeds.path_following import PathRun, PathSetup, run_path

SLOWEST = 0.004
FASTEST = 0.128
FIRST = 0.016
"""Speeds along the path that are tried [m/s], and the first of them."""
LOST = 0.0
"""Share of the time for which contact may be lost."""
BAND_SHARE = 0.95
"""Of the time for which the force has to be in its band."""
_PATIENCE = 1.6
"""A round may take this much longer than its length over the speed."""


class CourseFault(Enum):
    """What of a course is not well enough, the gravest first."""

    NOT_FINISHED = "not finished"
    CONTACT_LOST = "contact lost"
    ERROR = "error"
    FORCE = "force"


@dataclass(frozen=True)
class Tolerances:
    """What is well enough.

    Attributes:
        error: 95 % of the errors on the body are to be within this [m].
        force: The force is to be within this of its goal [N] for 95 % of the time; contact is never to be lost.
    """

    error: float = 0.003
    force: float = 0.6

    def fails(self, course: PathRun, goal: float) -> CourseFault | None:
        """The first thing that is not well enough; None when all is."""
        if course.stopped or course.finished is None:
            return CourseFault.NOT_FINISHED
        if course.lost > LOST:
            return CourseFault.CONTACT_LOST
        if course.error_p95 is None or course.error_p95 > self.error:
            return CourseFault.ERROR
        return None if course.in_band(goal, self.force) >= BAND_SHARE else CourseFault.FORCE


@dataclass(frozen=True, eq=False)
class SpeedSearchResult:
    """What a search came to.

    Attributes:
        speed: The highest that is well enough [m/s]; None where none is.
        course: At that speed; where none is well enough, that with the least error.
        limit: What is not well enough at the next higher speed tried, or at the lowest; None at the highest.
        runs: Courses that were run.
    """

    speed: float | None
    course: PathRun
    limit: CourseFault | None
    runs: int


def find_fastest_speed(
    setup: PathSetup, settings: ControlSettings, wanted: Tolerances, *, length: float, refinements: int = 2
) -> SpeedSearchResult:
    """The highest speed at which a course is well enough, on a ladder of halvings and then between two of its rungs.

    Faster is taken to be worse. That is so but for noise, and the same seed makes the same noise.

    Args:
        setup: What to run.
        settings: Of the controller, at any speed.
        wanted: What is well enough.
        length: Of a round [m].
        refinements: Bisections after the ladder: the speed is known to a factor of 2 ^ (1 / 2 ^ refinements).
    """
    return bisect_speed(
        lambda speed: _run_at_speed(setup, settings, speed, length), wanted, settings.force_goal, refinements
    )


def bisect_speed(
    run: Callable[[float], PathRun], wanted: Tolerances, goal: float, refinements: int
) -> SpeedSearchResult:
    """The same with whatever runs a course at a speed [m/s], and the force's goal [N]."""
    search = _Search(run, wanted, goal)
    low, high = search.bracket()
    for _ in range(refinements):
        if low is None or high is None:
            break
        middle = float(np.sqrt(low * high))
        low, high = (middle, high) if search.fails(middle) is None else (low, middle)
    return search.found(low, high)


def _run_at_speed(setup: PathSetup, settings: ControlSettings, speed: float, length: float) -> PathRun:
    return run_path(setup, replace(settings, path_speed=speed), _PATIENCE * length / speed + 0.5)


class _Search:
    """Remembers what was run. Mutable."""

    def __init__(self, run: Callable[[float], PathRun], wanted: Tolerances, goal: float) -> None:
        self._run = run
        self._wanted = wanted
        self._goal = goal
        self._courses: dict[float, PathRun] = {}

    def fails(self, speed: float) -> CourseFault | None:
        """What is not well enough at a speed [m/s]."""
        if speed not in self._courses:
            self._courses[speed] = self._run(speed)
        return self._wanted.fails(self._courses[speed], self._goal)

    def bracket(self) -> tuple[float | None, float | None]:
        """A speed that is well enough and twice that, which is not; None for one that is not known to be."""
        speed = FIRST
        good = self.fails(FIRST) is None
        end = FASTEST if good else SLOWEST
        while abs(speed - end) > 1e-9:
            before = speed
            speed = speed * (2.0 if good else 0.5)
            if (self.fails(speed) is None) != good:
                return (before, speed) if good else (speed, before)
        return (speed, None) if good else (None, speed)

    def found(self, low: float | None, high: float | None) -> SpeedSearchResult:
        """The answer between a speed that is well enough and one that is not."""
        limit = None if high is None else self.fails(high)
        if low is not None:
            return SpeedSearchResult(low, self._courses[low], limit, len(self._courses))
        best = min(self._courses.values(), key=_least_error)
        return SpeedSearchResult(None, best, limit, len(self._courses))


def _least_error(course: PathRun) -> float:
    return math.inf if course.error_p95 is None else course.error_p95
