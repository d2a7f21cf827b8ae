"""When settings were changed, so that plots can show what a change did. No Qt."""

from __future__ import annotations

import math

_JOINED = 0.4
"""Changes that follow each other within this are one, at the last of them [s]: a slider on its way."""


class ChangeMarks:
    """Times of changes. Mutable: ``change``, ``at`` a time, and ``clear``.

    Args:
        seconds: How far back to remember [s].
    """

    def __init__(self, *, seconds: float = 10.0) -> None:
        self._seconds = seconds
        self.clear()

    def clear(self) -> None:
        """Forget everything."""
        self._now = math.nan
        self._times: list[float] = []

    def at(self, time: float) -> None:
        """It is ``time`` [s] now; time that jumps, or runs backwards, forgets the changes before."""
        if not 0 <= time - self._now <= self._seconds:
            self._times = []
        self._now = time
        self._times = [when for when in self._times if time - when <= self._seconds]

    def change(self) -> None:
        """Something was changed just now."""
        if not math.isfinite(self._now):
            return
        if self._times and self._now - self._times[-1] <= _JOINED:
            self._times.pop()
        self._times.append(self._now)

    @property
    def ages(self) -> tuple[float, ...]:
        """Of the changes [s], 0 for now and below before."""
        return tuple(when - self._now for when in self._times)
