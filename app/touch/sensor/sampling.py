"""The bus: readings come at its own rate, and late."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from app.arrays import FloatArray, readonly
from app.touch.sensor.ranges import check_range
from app.touch.sensor.stage import Readout


@dataclass(frozen=True)
class Sampling:
    """The skin is sampled at a rate of its own and the samples take a time to arrive; between them the last one holds.

    Attributes:
        rate: Samples a second [Hz], 0.1 to 10,000.
        delay: From a sample to its arrival [s], 0 to 1.

    Raises:
        SimulationError: A number is out of its range.
    """

    rate: float = 50.0
    delay: float = 0.02

    def __post_init__(self) -> None:
        check_range("sampling.rate", self.rate, 0.1, 1e4)
        check_range("sampling.delay", self.delay, 0.0, 1.0)

    def stage(self, readout: Readout) -> SamplingStage:
        """The effect at work."""
        return SamplingStage(self, readout)


class SamplingStage:
    """Sample j is taken at the tick nearest to j / rate, the first at the first reading; none drifts off.

    The delay counts whole ticks, the nearest to what is asked. A rate above the ticks' own samples at every tick. Until
    the first sample arrives, taxels read 0. Cost at 1,000 taxels: 0.5 µs.
    """

    def __init__(self, spec: Sampling, readout: Readout) -> None:
        self._period = max(1.0 / (spec.rate * readout.tick), 1.0)
        self._delay = round(spec.delay / readout.tick)
        self._taxels = len(readout.skin)
        self._held: FloatArray
        self._on_the_way: deque[tuple[int, FloatArray]]
        self._next: int
        self.reset()

    def read(self, pressures: FloatArray) -> FloatArray:
        """(taxels,) [Pa], read-only."""
        if self._reading == self._next:
            self._on_the_way.append((self._reading + self._delay, readonly(pressures)))
            self._taken += 1
            self._next = round(self._taken * self._period)
        if self._on_the_way and self._on_the_way[0][0] <= self._reading:
            self._held = self._on_the_way.popleft()[1]
        self._reading += 1
        return self._held

    def reset(self) -> None:
        """Nothing was sampled yet."""
        self._reading, self._taken, self._next = 0, 0, 0
        self._held = readonly(np.zeros(self._taxels))
        self._on_the_way = deque()

    def state(self) -> FloatArray:
        """(2 + k + (1 + k) taxels,) readings made, samples taken, what is read [Pa], arrivals and samples on the way.

        Samples on the way fill k places, enough for all there can be; empty ones arrive at -1.
        """
        places = math.floor(self._delay / self._period) + 2
        arrivals, samples = np.full(places, -1.0), np.zeros((places, self._taxels))
        for place, (arrival, sample) in enumerate(self._on_the_way):
            arrivals[place], samples[place] = arrival, sample
        return np.concatenate([[self._reading, self._taken], self._held, arrivals, samples.ravel()])
