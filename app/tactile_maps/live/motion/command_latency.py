"""Delays between readings and their commands."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactile_maps.live.motion.motion_sender import DEADLINE

_KEPT = 10_000


@dataclass(frozen=True)
class LatencyFigures:
    """Times from the arrival of the newest reading to its command [s], of the last 10,000 commands.

    Attributes:
        median: Median.
        p95: 95th percentile.
        p99: 99th percentile.
        largest: Maximum of all commands.
        misses: Number of all commands that were sent after ``DEADLINE``.
    """

    median: float
    p95: float
    p99: float
    largest: float
    misses: int


class CommandLatency:
    """Collects delays. Mutable; one thread adds, any thread may read."""

    def __init__(self) -> None:
        self._times = np.zeros(_KEPT)
        self._count = self._misses = 0
        self._largest = 0.0

    def add(self, seconds: float) -> None:
        """Add one delay [s]."""
        self._times[self._count % _KEPT] = seconds
        self._count += 1
        self._misses += seconds > DEADLINE
        self._largest = max(self._largest, seconds)

    @property
    def figures(self) -> LatencyFigures | None:
        """The figures so far; None before the first command."""
        kept = self._times[: min(self._count, _KEPT)]
        if not len(kept):
            return None
        median, p95, p99 = np.percentile(kept, [50, 95, 99]).tolist()
        return LatencyFigures(median, p95, p99, self._largest, self._misses)


def latency_text(figures: LatencyFigures) -> str:
    """Return the figures in words."""
    times = f"median {1e3 * figures.median:.1f} ms, 95 % within {1e3 * figures.p95:.1f} ms"
    late = f"{figures.misses} later than {1e3 * DEADLINE:.0f} ms"
    return f"Sent after the reading: {times}, at most {1e3 * figures.largest:.1f} ms, {late}."
