"""Restores the order in which readings were sent and counts transmission errors; none of them is fatal.

A packet that arrives early waits a short time for the packets before it. Packets that do not arrive in that time are
lost; if one arrives later, it is late and is dropped.

A restarted sender may count from any number, and its clock may restart as well. A known number with another time, an
old number with a new time and a number far ahead do not belong to the current count: two such packets in a row, with
similar numbers, are a restart. A single one (damaged, or from another program) is passed on and changes nothing.
Where numbers and times both repeat, as for a board that counts from power-up, the packet looks like a duplicate:
``_PROOF`` different ones in a row with similar numbers, without a packet of the old count between them, are a restart.
Packets of the old count that are still in transit are then dropped. A clock that restarts counts as a restart of the
sender once two readings in a row are earlier than those before; a single outlier does not.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from tactile_maps.live.readings.readings import Reading

PATIENCE = 0.02
"""Time for which a reading waits for readings that were sent before it [s]."""
MOST_HELD = 256
_REMEMBERED = 4096
_PROOF = 5
_LEFT_SECONDS = 1.0
_MOST_LEFT = 32
"""Packets of the old count are recognised for this time after a restart [s], and up to this number."""
_CLOCKS_APART = 0.25
"""Clocks before and after a restart that differ by more than this [s] identify the count of a packet."""
_FAR = 100_000
"""A larger jump of the number is a restart of the count, not that many losses."""
_RATE_SECONDS = 2.0
_CYCLE = 2**32


class Arrived(NamedTuple):
    """A reading in its order, its arrival by the receiver's clock [s], and its age on arrival [s]."""

    reading: Reading
    at: float
    age: float = 0.0


@dataclass(frozen=True)
class ArrivalCounts:
    """Numbers of readings by the outcome of their transmission.

    Attributes:
        received: Readings that could be decoded, including repeated and late ones.
        malformed: Packets that could not be decoded.
        duplicated: Repeated readings, which are dropped.
        reordered: Readings that arrived after one that was sent later, and were put in order.
        late: Readings that arrived after their turn, and were dropped.
        lost: Numbers that never arrived.
        restarts: Restarts of the sender: its numbers or its clock began again.
        overflowed: Readings that arrived faster than they were processed, and were dropped.
        superseded: Readings replaced by newer ones before they were processed, while motion is sent or where far too
            many wait. Packets are not decoded while motion is sent: those that begin like a reading are counted, also
            as received.
    """

    received: int = 0
    malformed: int = 0
    duplicated: int = 0
    reordered: int = 0
    late: int = 0
    lost: int = 0
    restarts: int = 0
    overflowed: int = 0
    superseded: int = 0

    @property
    def loss(self) -> float:
        """Share of the sent packets that never arrived or arrived too late, 0 to 1."""
        sent = self.received - self.duplicated + self.lost
        return (self.lost + self.late) / sent if sent else 0.0


@dataclass(frozen=True)
class Delay:
    """Delays of the latest readings relative to the fastest of them [s].

    The clocks of sender and receiver need not agree, so the absolute delay is unknown.
    """

    median: float
    p95: float
    largest: float


class ArrivalTracker:
    """Sequence of the readings of one sender. Mutable.

    Args:
        patience: Time for which a reading waits for those before it [s].

    Attributes:
        counts: Counts so far.
        patience: Value of the argument; it may be changed at any time.
    """

    def __init__(self, *, patience: float = PATIENCE) -> None:
        self.patience = patience
        self.counts = ArrivalCounts()
        self._times: deque[float] = deque(maxlen=20_000)
        self._delays: deque[float] = deque(maxlen=1000)
        self.forget_sequence()

    def forget_sequence(self) -> None:
        """Accept any number next, for a new connection."""
        self._next: int | None = None
        self._held: dict[int, Arrived] = {}
        self._delivered: dict[int, float] = {}
        self._given_up: set[int] = set()
        self._newest = self._before_newest = -np.inf
        self._set_back: float | None = None  # time of a reading that was earlier than those before it
        self._stray: Reading | None = None  # a packet that may be the first after a restart
        self._delay = 0.0  # delay of the last delivered packet
        self._behind: list[int] = []
        self._superseded = 0  # number of undecoded packets: their numbers are unknown, but not lost
        self._left: _OldCount | None = None

    def take(self, reading: Reading, now: float) -> list[Arrived]:
        """Add a reading that arrived at ``now`` [s]; return the readings whose turn it is, in order."""
        self._count(received=1)
        self._times.append(now)
        self._delays.append(now - reading.time)
        item = Arrived(reading, now)
        if reading.sequence is None:
            return [item]
        number = reading.sequence
        if self._next is None:
            self._next = number
        ahead = _ahead(number, self._next)
        if self._is_left_over(reading, now):
            self._count(late=1)
            return self.due(now)
        if ahead < 0 and self._repeats(number):
            return [*self._restart(number, now), *self._deliver(item)]
        if ahead > _FAR or (ahead < 0 and self._is_stray(number, reading.time)):
            return self._take_stray(item, now)
        if ahead < 0:
            self._drop(number, reading.time)
            return self.due(now)
        self._behind.clear()
        self._stray = None
        if ahead == 0:
            self._count(reordered=int(bool(self._held)))
            return [*self._deliver(item), *self.due(now)]
        if number in self._held:
            self._count(duplicated=1)
        else:
            self._count(reordered=int(any(_ahead(other, number) > 0 for other in self._held)))
            self._held[number] = item
        return self.due(now)

    def due(self, now: float) -> list[Arrived]:
        """Return the readings that have waited long enough; the numbers missing before them are lost."""
        ready: list[Arrived] = []
        while self._held and (
            len(self._held) > MOST_HELD or now - min(item.at for item in self._held.values()) >= self.patience
        ):
            assert self._next is not None
            following = min(self._held, key=lambda number: _ahead(number, self._next or 0))
            missing = _ahead(following, self._next)
            skipped = min(missing, self._superseded)
            self._superseded -= skipped
            self._count(lost=missing - skipped)
            self._given_up.update((self._next + i) % _CYCLE for i in range(missing))
            self._next = following
            ready += self._deliver(self._held.pop(following))
        if len(self._given_up) > _REMEMBERED:
            self._given_up = set(sorted(self._given_up, key=lambda n: _ahead(n, self._next or 0))[-_REMEMBERED // 2 :])
        return ready

    def flush(self) -> list[Arrived]:
        """Return all waiting readings, at the end of the stream."""
        return self.due(np.inf)

    def malformed(self) -> None:
        """Count a packet that is not a valid reading."""
        self._count(malformed=1)

    def overflowed(self, count: int = 1) -> None:
        """Count readings that were dropped because they were not processed in time."""
        self._count(overflowed=count)

    def supersede(self, times: Sequence[float], *, decoded: bool) -> None:
        """Count readings that newer ones have replaced.

        Args:
            times: Arrival of each [s].
            decoded: True for readings that are already counted as received.
        """
        self._count(superseded=len(times), received=0 if decoded else len(times))
        if not decoded:
            self._superseded += len(times)
            self._times.extend(times)

    def rate(self, now: float) -> float:
        """Return the rate of readings over the last two seconds [Hz]."""
        recent = [at for at in self._times if at > now - _RATE_SECONDS]
        if len(recent) < 2:
            return 0.0
        return (len(recent) - 1) / max(now - recent[0], recent[-1] - recent[0], 1e-6)

    @property
    def delay(self) -> Delay | None:
        """Delay of the last 1000 readings; None before there are two."""
        if len(self._delays) < 2:
            return None
        excess = np.array(self._delays) - min(self._delays)
        median, p95 = np.percentile(excess, [50, 95])
        return Delay(float(median), float(p95), float(excess.max()))

    def _deliver(self, item: Arrived) -> list[Arrived]:
        """Return a reading whose turn it is and those that waited for it."""
        ready = [item]
        while True:
            number = ready[-1].reading.sequence
            assert number is not None
            self._remember(number, ready[-1].reading.time)
            self._delay = ready[-1].at - ready[-1].reading.time
            self._next = (number + 1) % _CYCLE
            if self._next not in self._held:
                return ready
            ready.append(self._held.pop(self._next))

    def _remember(self, number: int, time: float) -> None:
        self._follow_clock(time)
        self._delivered[number] = time
        if len(self._delivered) > _REMEMBERED:
            del self._delivered[next(iter(self._delivered))]

    def _follow_clock(self, time: float) -> None:
        """Track the times of readings in order; two in a row that are earlier than those before are a restart."""
        if time >= self._newest:
            self._before_newest = self._newest
            self._newest = time
            self._set_back = None
        elif self._set_back is None and time < self._before_newest:
            self._set_back = time
        else:
            begun_again = self._set_back is not None and time >= self._set_back
            self._count(restarts=int(begun_again))  # otherwise the newest time was an outlier
            self._delays.clear()
            self._before_newest = time
            self._newest = time
            self._set_back = None

    def _repeats(self, number: int) -> bool:
        """Whether an old number and the numbers just before it are the count of a restarted sender."""
        if number not in self._behind:
            self._behind = [other for other in self._behind if abs(_ahead(number, other)) <= MOST_HELD]
            self._behind.append(number)
        if len(self._behind) >= _PROOF:
            return True
        return not (number in self._delivered or number in self._given_up) and _rising(self._behind[-3:])

    def _is_stray(self, number: int, time: float) -> bool:
        """Whether an old number has a time that it cannot have in the old count."""
        return self._delivered[number] != time if number in self._delivered else time > self._newest

    def _take_stray(self, item: Arrived, now: float) -> list[Arrived]:
        """Pass on a packet that does not belong to the count; two in a row with similar numbers are a restart."""
        before = self._stray
        self._stray = item.reading
        if before is None:
            return [item]
        ahead = _distance(item.reading, before)
        if ahead == 0 and item.reading.time == before.time:
            self._count(duplicated=1)
            return []
        if not 0 < abs(ahead) <= MOST_HELD:
            return [item]
        first, last = (before, item.reading) if ahead > 0 else (item.reading, before)
        assert last.sequence is not None
        ready = self._restart((last.sequence + 1) % _CYCLE, now)
        for reading in (first, last):
            assert reading.sequence is not None
            self._remember(reading.sequence, reading.time)
        self._delay = now - item.reading.time
        return [*ready, item]

    def _is_left_over(self, reading: Reading, now: float) -> bool:
        """Whether a packet belongs to the count before the restart, by its clock and its number."""
        left = self._left
        delay = now - reading.time
        if left is None or reading.sequence is None:
            return False
        if abs(left.delay - self._delay) > _CLOCKS_APART:
            old = abs(delay - left.delay) < abs(delay - self._delay)
        else:
            old = reading.time < self._newest
        return old and left.holds(reading.sequence, now)

    def _drop(self, number: int, time: float) -> None:
        if self._delivered.get(number) == time:
            self._count(duplicated=1)
        elif number in self._given_up:
            self._given_up.discard(number)
            self._count(late=1, lost=-min(self.counts.lost, 1))  # a number counted as lost may have been superseded
        else:
            self._count(late=1)

    def _restart(self, number: int, now: float) -> list[Arrived]:
        assert self._next is not None
        left = _OldCount(self._next, self._delay, now)
        ready = [self._held[key] for key in sorted(self._held, key=lambda one: _ahead(one, self._next or 0))]
        self.forget_sequence()
        self._delays.clear()
        self._next = number
        self._left = left
        self._count(restarts=1)
        return ready

    def _count(self, **more: int) -> None:
        counts = self.counts
        self.counts = replace(counts, **{name: getattr(counts, name) + number for name, number in more.items()})


@dataclass
class _OldCount:
    """The count before a restart. Mutable.

    Attributes:
        following: Next expected number.
        delay: Arrival minus the sender's time of its last packet [s].
        since: Receiver's time of the restart [s].
        seen: Number of its packets that arrived since.
    """

    following: int
    delay: float
    since: float
    seen: int = 0

    def holds(self, number: int, now: float) -> bool:
        """Count a packet of the old count that was in transit; return False where the number cannot belong to it."""
        if not -_REMEMBERED <= _ahead(number, self.following) <= MOST_HELD:
            return False
        self.seen += 1
        return self.seen <= _MOST_LEFT and now - self.since <= _LEFT_SECONDS


def _rising(numbers: list[int]) -> bool:
    return len(numbers) == 3 and numbers[1] - numbers[0] == numbers[2] - numbers[1] == 1


def _distance(reading: Reading, of: Reading) -> int:
    assert reading.sequence is not None
    assert of.sequence is not None
    return _ahead(reading.sequence, of.sequence)


def _ahead(number: int, of: int) -> int:
    """Return the distance of ``number`` from ``of`` in a cycle of 2³²; negative where it is behind."""
    return (number - of + _CYCLE // 2) % _CYCLE - _CYCLE // 2
