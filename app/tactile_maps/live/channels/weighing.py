"""Calibrating by a known weight that lies on the skin for a while, and back again."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.core.errors import LiveError
from tactile_maps.live.channels.calibration import Calibration, check_mass

LONGEST = 60.0
"""Seconds over which readings are averaged at most."""
_DRIFT = 0.05
"""Of the sum from one half of a while to the other: a weight that is still being laid down changes it by more."""


@dataclass(frozen=True)
class WeighingState:
    """How a calibration by a known weight goes.

    Attributes:
        left: Seconds until it is done; None while none goes on.
        factor: By which the newest one scaled gains; None before there is one.
        problem: Why the newest one changed nothing; None where it did not fail.
        undoable: Whether there is a calibration to go back to.
    """

    left: float | None = None
    factor: float | None = None
    problem: str | None = None
    undoable: bool = False


class Weighing:
    """Averages readings under a weight. Mutable.

    Args:
        mass: Of the weight [kg].
        seconds: Over which readings are averaged, by the sender's clock.
        taxels: (k,) on which it lies; None for any.
        start: Time now [s].

    Raises:
        LiveError: There is no such weight, time, or taxel.
    """

    def __init__(self, mass: float, seconds: float, taxels: IntArray | None, start: float) -> None:
        check_mass(mass)
        _check_seconds(seconds)
        if taxels is not None and not len(taxels):
            raise LiveError("the weight lies on no taxel", remedy="Select the taxels under it, or none for all")
        self._mass = mass
        self._taxels = taxels
        self._until = start + seconds
        self._count = 0
        self._sum: FloatArray | None = None

    def left(self, time: float) -> float:
        """Seconds until it is done."""
        return max(self._until - time, 0.0)

    def add(self, change: FloatArray, time: float) -> bool:
        """A reading's values (n,) above the untouched skin's; whether that was the last it needs."""
        self._sum = change.copy() if self._sum is None else self._sum + change
        self._count += 1
        return time >= self._until

    def calibrated(self, before: Calibration, areas: FloatArray) -> tuple[Calibration, float]:
        """The calibration by the mean, and by what it scaled gains; raises LiveError where nothing is felt."""
        assert self._sum is not None
        after = before.with_weight(self._sum / self._count, areas, self._mass, taxels=self._taxels)
        changed = int(np.argmax(after.gain != before.gain)) if self._taxels is None else int(self._taxels[0])
        return after, float(after.gain[changed] / before.gain[changed])


class RecentReadings:
    """The readings of the last while, for a weight that turns out to have lain on the skin. Mutable.

    Args:
        seconds: How long a while, by the sender's clock.

    Raises:
        LiveError: There is no such time.
    """

    def __init__(self, seconds: float) -> None:
        _check_seconds(seconds)
        self._seconds = seconds
        self._kept: deque[tuple[float, FloatArray]] = deque()

    def add(self, change: FloatArray, time: float) -> None:
        """A reading's values (n,) above the untouched skin's, at a time [s]; what is too old by then is dropped."""
        self._kept.append((time, change))
        while time - self._kept[0][0] > self._seconds:
            self._kept.popleft()

    def mean(self, weights: FloatArray) -> FloatArray:
        """(n,) of them.

        Args:
            weights: (n,) what a value counts in the sum that must have come to rest.

        Raises:
            LiveError: There are none, or their sum still changes by more than 5 % from one half to the other.
        """
        if not self._kept:
            raise LiveError("there is no reading to weigh by", remedy="Let readings come while the weight lies there")
        changes = np.stack([change for _, change in self._kept])
        sums = changes @ weights
        half = len(changes) // 2
        if half:
            before = sums[:half].mean()
            after = sums[half:].mean()
            drift = abs(after - before) / max(abs(before), abs(after), 1e-300)
            if drift > _DRIFT:
                found = f"{100 * drift:.0f} % within {self._seconds:g} s"
                remedy = "Wait until it lies still, or average over a shorter time"
                raise LiveError("the weight has not come to rest", value=found, remedy=remedy)
        return np.asarray(changes.mean(axis=0))


def _check_seconds(seconds: float) -> None:
    if not (math.isfinite(seconds) and 0 < seconds <= LONGEST):
        raise LiveError("the time is out of range", value=f"{seconds} s", remedy=f"Choose up to {LONGEST:g} s")
