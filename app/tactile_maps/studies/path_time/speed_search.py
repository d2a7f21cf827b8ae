"""Shortest time in which a path is followed within tolerances, found by bisection over the speed."""

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
"""Limits of the speed along the path, and the first speed that is tried [m/s]."""
LOST = 0.0
"""Maximum share of the time without contact."""
BAND_SHARE = 0.95
"""Minimum share of the time with the force in its band."""
_PATIENCE = 1.6
"""Maximum duration of a round, as a multiple of its length over the speed."""


class RunFault(Enum):
    """Violated tolerance of a run, the most severe first."""

    NOT_FINISHED = "not finished"
    CONTACT_LOST = "contact lost"
    ERROR = "error"
    FORCE = "force"


@dataclass(frozen=True)
class Tolerances:
    """Tolerances of a run.

    Attributes:
        error: Bound for 95 % of the errors on the body [m].
        force: Bound for the error of the force [N] during 95 % of the time; contact must never be lost.
    """

    error: float = 0.003
    force: float = 0.6

    def fails(self, run: PathRun, goal: float) -> RunFault | None:
        """Return the first violated tolerance; None if all are met."""
        if run.stopped or run.finished is None:
            return RunFault.NOT_FINISHED
        if run.lost > LOST:
            return RunFault.CONTACT_LOST
        if run.error_p95 is None or run.error_p95 > self.error:
            return RunFault.ERROR
        return None if run.in_band(goal, self.force) >= BAND_SHARE else RunFault.FORCE


@dataclass(frozen=True, eq=False)
class SpeedSearchResult:
    """Result of a search.

    Attributes:
        speed: Highest speed within the tolerances [m/s]; None without any.
        run: Run at that speed; without such a speed, the run with the smallest error.
        limit: Violated tolerance at the next higher tested speed, or at the lowest; None at the highest speed.
        runs: Number of runs.
    """

    speed: float | None
    run: PathRun
    limit: RunFault | None
    runs: int


def find_fastest_speed(
    setup: PathSetup, settings: ControlSettings, limits: Tolerances, *, length: float, refinements: int = 2
) -> SpeedSearchResult:
    """Return the highest speed within the tolerances, on a ladder of factors of two and then between two rungs.

    A faster run is assumed to be worse, which is true except for noise; the noise of a seed is constant.

    Args:
        setup: Truth and knowledge of the run.
        settings: Settings of the controller, at any speed.
        limits: Tolerances.
        length: Length of a round [m].
        refinements: Bisections after the ladder: the speed is known to a factor of 2 ^ (1 / 2 ^ refinements).
    """
    return bisect_speed(
        lambda speed: _run_at_speed(setup, settings, speed, length), limits, settings.force_goal, refinements
    )


def bisect_speed(
    run: Callable[[float], PathRun], limits: Tolerances, goal: float, refinements: int
) -> SpeedSearchResult:
    """Search like ``find_fastest_speed``, with any function that runs at a speed [m/s] and a force goal [N]."""
    search = _Search(run, limits, goal)
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
    """Search with a cache of its runs. Mutable."""

    def __init__(self, run: Callable[[float], PathRun], limits: Tolerances, goal: float) -> None:
        self._run = run
        self._limits = limits
        self._goal = goal
        self._runs: dict[float, PathRun] = {}

    def fails(self, speed: float) -> RunFault | None:
        """Return the violated tolerance at a speed [m/s]."""
        if speed not in self._runs:
            self._runs[speed] = self._run(speed)
        return self._limits.fails(self._runs[speed], self._goal)

    def bracket(self) -> tuple[float | None, float | None]:
        """Return a speed within the tolerances and twice that, which is not; None for an unknown one."""
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
        """Return the result between a speed within the tolerances and one that is not."""
        limit = None if high is None else self.fails(high)
        if low is not None:
            return SpeedSearchResult(low, self._runs[low], limit, len(self._runs))
        best = min(self._runs.values(), key=_least_error)
        return SpeedSearchResult(None, best, limit, len(self._runs))


def _least_error(run: PathRun) -> float:
    return math.inf if run.error_p95 is None else run.error_p95
