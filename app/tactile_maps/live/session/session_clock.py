"""Time of a session with readings of a real skin."""

from __future__ import annotations

_LONGEST_STEP = 10.0
"""A larger forward step of the clock in a file [s] means that the clock was set; the time of arrival is used then."""
_AHEAD = 0.25
"""A live sender's clock may gain at most this much [s] on the time of arrival between two readings."""


class SessionClock:
    """Session time of readings, by the sender's clock where its times are plausible. Mutable.

    If the time of a reading does not fit the previous ones, its time of arrival is used instead. Such a time becomes
    the base for later ones only if the next reading fits it, as after a restart of the sender or a change of its clock.

    Args:
        tick: Duration of a tick [s].
        finite: Whether the readings come from a file: only their own times count then, not their arrival.

    Attributes:
        time: Session time of the newest reading [s].
        ticks: Its tick; every reading has its own.
        mistimed: Number of readings with an implausible time.
    """

    def __init__(self, tick: float, *, finite: bool) -> None:
        self._tick = tick
        self._finite = finite
        self.reset()

    def reset(self) -> None:
        """Start at 0 again."""
        self.time = 0.0
        self.ticks = 0
        self.mistimed = 0
        self._times: tuple[float, float] | None = None  # sender's and receiver's time of the newest reading
        self._base: tuple[float, float, float] | None = None  # both and the session time when they last agreed

    @property
    def sent(self) -> float | None:
        """The sender's time of the newest reading [s]; None before the first."""
        return None if self._times is None else self._times[0]

    def advance(self, sent: float, arrived: float) -> None:
        """Advance to a reading with the sender's and the receiver's time [s]."""
        before = self._times
        self._times = (sent, arrived)
        if self._base is None or before is None:
            self._base = sent, arrived, self.time
        else:
            base_sent, base_arrived, base = self._base
            fits = self._follows(self._times, (base_sent, base_arrived))
            self.mistimed += not fits
            now = base + (sent - base_sent if fits else max(arrived - base_arrived, 0.0))
            self.time = max(now, self.time)
            if fits or self._finite or self._follows(self._times, before):
                self._base = sent, arrived, self.time
        self.ticks = max(round(self.time / self._tick), self.ticks + 1)

    def _follows(self, times: tuple[float, float], before: tuple[float, float]) -> bool:
        """Return whether the sender's and the receiver's time of a reading fit those of an earlier one."""
        passed = max(times[1] - before[1], 0.0)
        return 0 <= times[0] - before[0] <= (_LONGEST_STEP if self._finite else passed + _AHEAD)
