"""Taxels that broke."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.arrays import FloatArray, readonly
from app.touch.sensor.ranges import check_range
from app.touch.sensor.stage import Readout

ALIVE, DEAD, STUCK = range(3)
"""What became of a taxel."""


@dataclass(frozen=True)
class DeadTaxels:
    """Some taxels, drawn once, read nothing or always the same.

    Attributes:
        dead: Share of the taxels that read 0.
        stuck: Share of the taxels that read ``stuck_at``; with ``dead`` at most 1.
        stuck_at: What those read [Pa], 0 to 1 GPa.

    Raises:
        SimulationError: A number is out of its range.
    """

    dead: float = 0.02
    stuck: float = 0.0
    stuck_at: float = 20e3

    def __post_init__(self) -> None:
        check_range("dead_taxels.dead", self.dead, 0.0, 1.0)
        check_range("dead_taxels.stuck", self.stuck, 0.0, 1.0)
        check_range("dead_taxels.stuck_at", self.stuck_at, 0.0, 1e9)
        check_range("dead_taxels, dead and stuck together", self.dead + self.stuck, 0.0, 1.0 + 1e-9)

    def stage(self, readout: Readout) -> DeadTaxelsStage:
        """The effect at work."""
        return DeadTaxelsStage(self, readout)


class DeadTaxelsStage:
    """As many as the share says, to the nearest whole taxel; a larger share breaks the same ones and more.

    Cost at 1,000 taxels: 0.7 µs.

    Attributes:
        codes: (taxels,) int8, ``ALIVE``, ``DEAD`` or ``STUCK``.
    """

    def __init__(self, spec: DeadTaxels, readout: Readout) -> None:
        count = len(readout.skin)
        dead = round(spec.dead * count)
        stuck = min(round(spec.stuck * count), count - dead)
        order = readout.stream("dead_taxels").permutation(count)
        self._dead, self._stuck, self._stuck_at = order[:dead], order[count - stuck :], spec.stuck_at
        codes = np.full(count, ALIVE, dtype=np.int8)
        codes[self._dead], codes[self._stuck] = DEAD, STUCK
        self.codes = readonly(codes, np.int8)

    def read(self, pressures: FloatArray) -> FloatArray:
        """(taxels,) [Pa]."""
        out = pressures.copy()
        out[self._dead] = 0.0
        out[self._stuck] = self._stuck_at
        return out

    def reset(self) -> None:
        """What broke stays broken."""

    def state(self) -> FloatArray:
        """(0,)."""
        return np.zeros(0)
