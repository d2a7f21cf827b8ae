"""The last seconds of a few numbers, and of all taxels, in rings that never grow. No Qt."""

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

    def forget_silent(self) -> tuple[str, ...]:
        """Drop the series that said nothing in the last ``seconds``; their names. Cost: 5 µs a series."""
        recent = self._times >= self.latest - self.seconds
        silent = tuple(name for name, values in self._values.items() if not np.isfinite(values[recent]).any())
        for name in silent:
            del self._values[name]
        return silent

    def _order(self) -> IntArray:
        return _oldest_first(self._count, len(self._times))


class TaxelHistory:
    """Pressures of every taxel, so that one selected now shows what it felt before. Mutable: ``add`` and ``clear``.

    Args:
        seconds: How far back to keep [s].
        capacity: Most frames kept; ten seconds at 100 a second. They take 4 bytes a taxel each.
    """

    def __init__(self, *, seconds: float = 10.0, capacity: int = 1000) -> None:
        self.seconds = seconds
        self._times = np.full(capacity, np.nan)
        self._pressures = np.zeros((capacity, 0), np.float32)
        self._count = 0

    def clear(self) -> None:
        """Forget everything."""
        self._count = 0
        self._times.fill(np.nan)

    def add(self, time: float, pressures: FloatArray) -> None:
        """Keep pressures (taxels,) [Pa] at ``time`` [s]; another skin, or time that jumps, starts a new history."""
        latest = self._times[(self._count - 1) % len(self._times)]
        if len(pressures) != self._pressures.shape[1]:
            self._pressures = np.empty((len(self._times), len(pressures)), np.float32)
            self.clear()
        elif self._count and not 0 <= time - latest <= self.seconds:
            self.clear()
        place = self._count % len(self._times)
        self._times[place], self._pressures[place] = time, pressures
        self._count += 1

    def traces(self, taxels: IntArray) -> tuple[FloatArray, FloatArray]:
        """Ages (n,) [s], rising to 0, and pressures (n, k) [kPa] of ``taxels`` (k,) in the last ``seconds``.

        Cost: 1 ms for all of 1000 taxels at 60 frames a second.
        """
        order = _oldest_first(self._count, len(self._times))
        ages = self._times[order] - self._times[order[-1:]]
        kept = ages >= -self.seconds
        return ages[kept], 1e-3 * self._pressures[np.ix_(order[kept], taxels)].astype(float)


def _oldest_first(count: int, size: int) -> IntArray:
    """Places in a ring of ``size`` that ``count`` samples were put into."""
    return np.arange(count) if count <= size else (np.arange(size) + count) % size
