"""Age of readings, from the sender's times and the times of arrival.

The two clocks have no common zero, so only differences are meaningful. The difference between arrival and sender time
is smallest for the reading with the shortest delay; the age of any other reading is its difference above this floor.
One of the clocks may run faster: the floor may rise by ``DRIFT``, and it falls at once. A delay that grows more slowly
than ``DRIFT``, or that is equal for all readings, cannot be distinguished from a difference of the clocks.

A sender's clock that is set forwards or backwards by more than ``JUMP`` is counted in ``jumps``, and the floor is
measured again. While motion is sent, a jump stops it (``motion.input_monitor``).
"""

from __future__ import annotations

DRIFT = 200e-6
"""Largest difference in rate between the two clocks that is tracked: quartz clocks differ by at most 100 ppm."""
JUMP = 0.15
"""A smaller change of the sender's clock [s] cannot be distinguished from a transmission delay."""
STEADY = 0.01
SETTLE_SECONDS = 0.5
"""The floor is settled once it has not fallen by more than ``STEADY`` [s] for this long: no backlog is being read."""
_REBASE_SECONDS = 1.0
"""Readings that have all been older than ``JUMP`` for this long [s] come from a sender whose clock was set back."""


class DataAge:
    """Estimator of the age of one sender's readings. Mutable.

    Args:
        live: False for a file, whose times are in the past: its readings have the age 0.

    Attributes:
        jumps: Number of jumps of the sender's clock so far.
    """

    def __init__(self, *, live: bool = True) -> None:
        self._live = live
        self.jumps = 0
        self.reset()

    def reset(self) -> None:
        """Discard the clocks, for another sender."""
        self._floor: float | None = None
        self._newest = 0.0, 0.0  # sender's time and arrival of the newest reading
        self._settling = 0.0
        self._settling_floor = 0.0
        self._fresh_at = 0.0

    def add(self, sent: float, arrived: float) -> float:
        """Return the age of a reading on its arrival [s].

        Args:
            sent: Sender's clock [s].
            arrived: Receiver's clock [s], increasing.
        """
        if not self._live:
            return 0.0
        difference = arrived - sent
        if self._floor is None:
            self._restart(difference, arrived)
        floor = self._risen_floor(arrived)
        set_back = self._newest[0] - sent > JUMP
        set_forward = floor - difference > JUMP
        if set_back or set_forward:
            self.jumps += 1
            self._restart(difference, arrived)
            floor = difference
        self._floor = floor = min(floor, difference)
        self._newest = sent, arrived
        if floor < self._settling_floor - STEADY:
            self._settling = arrived
            self._settling_floor = floor
        if difference - floor <= JUMP:
            self._fresh_at = arrived
        elif arrived - self._fresh_at > _REBASE_SECONDS:
            self._restart(difference, arrived)
        return difference - floor

    @property
    def settled(self) -> bool:
        """True once the floor is steady, so that the ages are reliable."""
        return not self._live or (self._floor is not None and self._newest[1] - self._settling >= SETTLE_SECONDS)

    def _risen_floor(self, now: float) -> float:
        assert self._floor is not None
        return self._floor + DRIFT * max(now - self._newest[1], 0.0)

    def _restart(self, difference: float, now: float) -> None:
        self._floor = self._settling_floor = difference
        self._settling = self._fresh_at = now
        self._newest = now - difference, now
