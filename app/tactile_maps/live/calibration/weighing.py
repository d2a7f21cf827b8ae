"""Calibration with a known weight on the skin."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.core.errors import LiveError
from tactile_maps.live.calibration.calibration import Calibration, check_mass

LONGEST = 60.0
"""Longest time over which readings are averaged [s]."""
_DRIFT = 0.05
"""Largest change of the sum between the two halves of the time, as a share: a weight that is still being put down
changes it by more.
"""


@dataclass(frozen=True)
class WeighingState:
    """Progress of a calibration with a known weight.

    Attributes:
        left: Time until it is complete [s]; None while none is running.
        factor: Factor by which the newest one scaled the gains; None before there is one.
        problem: Why the newest one changed nothing; None if it succeeded.
        undoable: Whether an earlier calibration can be restored.
        falling: Whether the newest one failed because the readings fall, and a negative gain can be applied.
    """

    left: float | None = None
    factor: float | None = None
    problem: str | None = None
    undoable: bool = False
    falling: bool = False


class Weighing:
    """Average of readings under a weight. Mutable.

    Args:
        mass: Mass of the weight [kg].
        seconds: Time over which readings are averaged, by the sender's clock [s].
        taxels: (k,) taxels under the weight; None for any.
        start: Current time [s].

    Raises:
        LiveError: The mass or time is out of range, or ``taxels`` is empty.
    """

    def __init__(self, mass: float, seconds: float, taxels: IntArray | None, start: float) -> None:
        check_mass(mass)
        _check_seconds(seconds)
        if taxels is not None and not len(taxels):
            remedy = "Select the taxels under it, or none for all"
            raise LiveError("no taxel under the weight is selected", remedy=remedy)
        self._mass = mass
        self._taxels = taxels
        self._until = start + seconds
        self._count = 0
        self._sum: FloatArray | None = None

    def left(self, time: float) -> float:
        """Return the time until the average is complete [s]."""
        return max(self._until - time, 0.0)

    def add(self, change: FloatArray, time: float) -> bool:
        """Add a reading's values (n,) above those of the untouched skin; return whether it was the last one needed."""
        self._sum = change.copy() if self._sum is None else self._sum + change
        self._count += 1
        return time >= self._until

    def calibrated(self, before: Calibration, areas: FloatArray, noise: FloatArray | None) -> tuple[Calibration, float]:
        """Return the new calibration and the factor of its gains; see ``Calibration.with_weight``."""
        assert self._sum is not None
        after = before.with_weight(self._sum / self._count, areas, self._mass, taxels=self._taxels, noise=noise)
        changed = int(np.argmax(after.gain != before.gain)) if self._taxels is None else int(self._taxels[0])
        return after, float(after.gain[changed] / before.gain[changed])


class RecentReadings:
    """The most recent readings, to calibrate with a weight that is already on the skin. Mutable.

    Args:
        seconds: Time for which readings are kept, by the sender's clock [s].

    Raises:
        LiveError: The time is out of range.
    """

    def __init__(self, seconds: float) -> None:
        _check_seconds(seconds)
        self._seconds = seconds
        self._kept: deque[tuple[float, FloatArray]] = deque()

    def add(self, change: FloatArray, time: float) -> None:
        """Add a reading's values (n,) above those of the untouched skin at ``time`` [s], and drop old readings."""
        self._kept.append((time, change))
        while time - self._kept[0][0] > self._seconds:
            self._kept.popleft()

    def mean(self, weights: FloatArray) -> FloatArray:
        """Return the mean (n,) of the kept readings.

        Args:
            weights: (n,) weight of each value in the sum that must be steady.

        Raises:
            LiveError: There are no readings, or their sum differs by more than 5 % between the two halves of the time.
        """
        if not self._kept:
            remedy = "Receive readings while the weight is on the skin"
            raise LiveError("no reading has arrived to calibrate with", remedy=remedy)
        changes = np.stack([change for _, change in self._kept])
        sums = changes @ weights
        half = len(changes) // 2
        if half:
            before = sums[:half].mean()
            after = sums[half:].mean()
            drift = abs(after - before) / max(abs(before), abs(after), 1e-300)
            if drift > _DRIFT:
                found = f"{100 * drift:.0f} % within {self._seconds:g} s"
                remedy = "Wait until the weight is at rest, or average over a shorter time"
                raise LiveError("the weight is not at rest", value=found, remedy=remedy)
        return np.asarray(changes.mean(axis=0))


def _check_seconds(seconds: float) -> None:
    if not (math.isfinite(seconds) and 0 < seconds <= LONGEST):
        raise LiveError("the time is out of range", value=f"{seconds} s", remedy=f"Choose up to {LONGEST:g} s")
