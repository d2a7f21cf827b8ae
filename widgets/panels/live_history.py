"""The last seconds of a few numbers, in a ring that never grows. No Qt."""

from __future__ import annotations

import numpy as np

from app.arrays import FloatArray, IntArray


class LiveHistory:
    """Samples of named series over time. Mutable: ``add`` and ``clear``.

    Args:
        seconds: How far back to keep [s]; also the width of the window shown.
        capacity: Most samples kept.
    """

    def __init__(self, *, seconds: float = 10.0, capacity: int = 2048) -> None:
        self.seconds = seconds
        self._times = np.full(capacity, np.nan)
        self._values: dict[str, FloatArray] = {}
        self._count = 0

    @property
    def names(self) -> tuple[str, ...]:
        """The series, in the order they first came."""
        return tuple(self._values)

    @property
    def latest(self) -> float:
        """Time of the newest sample [s]; NaN when there is none."""
        return float(self._times[(self._count - 1) % len(self._times)]) if self._count else float("nan")

    def clear(self) -> None:
        """Forget all samples and series."""
        self._values, self._count = {}, 0
        self._times.fill(np.nan)

    def add(self, time: float, values: dict[str, float]) -> None:
        """Keep ``values`` at ``time`` [s]; time running backwards or jumping ahead starts a new history."""
        if self._count and not 0 <= time - self.latest <= self.seconds:
            self.clear()
        place = self._count % len(self._times)
        for name in values:
            if name not in self._values:
                self._values[name] = np.full(len(self._times), np.nan)
        for name, series in self._values.items():
            series[place] = values.get(name, np.nan)
        self._times[place] = time
        self._count += 1

    def series(self, name: str) -> tuple[FloatArray, FloatArray]:
        """Ages (k,) [s], rising to 0 at the newest sample, and the values (k,) of the last ``seconds``; maybe none."""
        if name not in self._values:
            return np.zeros(0), np.zeros(0)
        order = self._order()
        ages = self._times[order] - self.latest
        kept = ages >= -self.seconds
        return ages[kept], self._values[name][order][kept]

    def _order(self) -> IntArray:
        size = len(self._times)
        if self._count <= size:
            return np.arange(self._count)
        return (np.arange(size) + self._count) % size
