"""Stage times: measured with the wall clock, carried by every frame, never part of a result."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Timings:
    """Milliseconds spent by stage, in the order the stages first ran."""

    ms: dict[str, float] = field(default_factory=dict)

    @property
    def total_ms(self) -> float:
        """The sum over all stages [ms]."""
        return sum(self.ms.values())


class Stopwatch:
    """Adds up wall time by stage. Mutable; ``take`` hands out the sums and starts again.

    Args:
        clock: Seconds from any origin; a test passes its own.
    """

    def __init__(self, clock: Callable[[], float] = time.perf_counter) -> None:
        self._clock = clock
        self._ms: dict[str, float] = {}

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Add the time spent inside to stage ``name``."""
        start = self._clock()
        try:
            yield
        finally:
            self._ms[name] = self._ms.get(name, 0.0) + 1e3 * (self._clock() - start)

    def take(self) -> Timings:
        """Return the sums since the last take, and reset them."""
        taken, self._ms = Timings(self._ms), {}
        return taken
