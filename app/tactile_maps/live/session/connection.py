"""A source that is kept open: reopened with growing pauses when it breaks; its readings are ordered and counted.

Normally every reading is decoded on arrival and processed in order. While motion is sent (``keep_newest``), only the
newest data matter: everything that has arrived is processed at once, the newest packet first, and older packets are
decoded only as far as they contain a taxel or joint that no newer one has. A full system buffer keeps the oldest
packets, so ``take_newest`` empties it before it looks for the newest. It does so on the thread that sends commands:
Python runs one thread at a time, and a receiving thread that waits for the interpreter lock after each packet would
fall behind a busy one.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from enum import StrEnum

from tactile_maps.core.errors import LiveError, TactileMapsError, describe_unexpected_error
from tactile_maps.live.readings.arrival import PATIENCE, ArrivalCounts, ArrivalTracker, Arrived, Delay
from tactile_maps.live.readings.data_age import DataAge
from tactile_maps.live.readings.readings import MalformedReadingError, PacketSource, Reading, Source, SourceEndedError

FIRST_PAUSE = 0.25
LONGEST_PAUSE = 5.0
"""Longest pause before a broken source is reopened [s]; the pause doubles until a reading arrives."""
MOST_WAITING = 20_000
"""Maximum number of waiting readings; the oldest beyond that are dropped and counted."""
_MOST_PACKET_BYTES = 64_000_000
"""Maximum size of packets that wait to be decoded; the oldest beyond that are dropped and counted."""
_REST = 0.001
"""Pause between two polls for packets while only the newest count [s]; it leaves the processor to the commands."""
_POLL = 0.005
"""Maximum time to wait for a source before packets that wait for missing ones are checked again [s]."""


class ConnectionState(StrEnum):
    """State of a connection."""

    CLOSED = "closed"
    WAITING = "waiting for readings"
    RECEIVING = "receiving"
    RECONNECTING = "reconnecting"
    ENDED = "ended"
    FAILED = "failed"


SILENT_SECONDS = 1.0
"""A source without a reading for this long [s] returns to the state *waiting for readings*."""


@dataclass(frozen=True)
class ConnectionStatus:
    """State and statistics of a connection at one time.

    Attributes:
        state: State of the connection.
        address: Address of the source.
        counts: Counts of what arrived.
        rate: Rate of readings [Hz].
        delay: Delay relative to the fastest reading; None before there are two.
        reconnects: Number of times the source was reopened.
        problem: Why it is not receiving; None while it is.
        next_try: Time until the source is reopened [s]; None if that is not planned.
        malformed: Error of the newest packet that could not be decoded; None if there was none.
        refused: Number of rejected packets of other senders while motion is sent, by address.
        waiting: Number of readings that arrived and were not taken yet.
    """

    state: ConnectionState
    address: str
    counts: ArrivalCounts
    rate: float
    delay: Delay | None
    reconnects: int = 0
    problem: str | None = None
    next_try: float | None = None
    malformed: str | None = None
    refused: Mapping[str, int] = field(default_factory=dict)
    waiting: int = 0


def refused_text(refused: Mapping[str, int]) -> str:
    """Return the rejected senders in words."""
    return ", ".join(f"{number} of {address}" for address, number in refused.items())


class Connection:
    """Keeps a source open. Mutable; ``step`` is for one thread, ``take`` and ``status`` are thread-safe.

    Args:
        source: The source.
        clock: Wall time [s], of the same kind as the sender's for packets with a time.
        patience: Time for which a reading waits for those sent before it [s].

    Attributes:
        source: Value of the argument.
        ages: Ages of the readings that arrived.
    """

    def __init__(self, source: Source, *, clock: Callable[[], float] = time.monotonic) -> None:
        self.source = source
        self._clock = clock
        self._lock = threading.Lock()
        self._tracker = ArrivalTracker()
        self.ages = DataAge(live=not source.finite)
        self._waiting: deque[Arrived] = deque()
        self._packets: deque[tuple[float, bytes]] = deque()
        self._packet_bytes = 0
        self._newest_only = False
        self._receiving = threading.Lock()  # guards the source of packets, which two threads receive from
        self._arrived = threading.Event()
        self._open = False
        self._ended = False
        self._pause = FIRST_PAUSE
        self._retry_at = float("-inf")
        self._last = float("-inf")
        self._reconnects = 0
        self._opened = 0
        self._problem: str | None = None
        self._malformed: str | None = None
        self._failed = False
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None

    def open(self) -> None:
        """Open the source now, so that errors are raised at once; raises LiveError."""
        self.source.open()
        self._open = True
        self._opened += 1

    def start(self) -> None:
        """Receive on a separate thread until ``close``."""
        self._thread = threading.Thread(target=self._loop, name="live input", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop and release the source; waiting readings can still be taken. Calling it again has no effect."""
        self._stop.set()
        if self._thread is not None:
            self._thread.join()
            self._thread = None
        with self._receiving:
            self.source.close()
            self._open = False
        with self._lock:
            self._decode_all()
            self._keep(self._tracker.flush())

    @property
    def ended(self) -> bool:
        """Whether the source has no more readings and none are waiting."""
        return self._ended and not (self._waiting or self._packets)

    def keep_newest(self, *, on: bool) -> None:
        """Keep only what ``take_newest`` needs, from one sender; or every reading again. A file is always read in
        order.

        The stream stays with its one sender afterwards: after a stop, the robot that was moved is displayed and
            recorded.
        """
        on = on and not self.source.finite
        if on is self._newest_only:
            return
        if on and isinstance(self.source, PacketSource):
            self.source.one_sender = True
        with self._lock:
            self._newest_only = on
            self._tracker.patience = 0.0 if on else PATIENCE
            if on:
                self._keep(self._tracker.due(self._clock()))
            else:
                self._decode_all()

    def step(self, timeout: float = _POLL) -> None:
        """Receive for at most ``timeout`` [s]; reopen a broken source when its pause is over."""
        if self._ended or not (self._open or self._reopen(timeout)):
            return
        if self._newest_only and isinstance(self.source, PacketSource):
            try:
                if self.source.wait_for_packet(timeout):
                    self._drain()
            except LiveError as error:
                self._break(error)
            return
        try:
            reading = self.source.receive(timeout)
        except SourceEndedError:
            with self._lock:
                self._ended = True
                self._keep(self._tracker.flush())
            return
        except MalformedReadingError as error:
            with self._lock:
                self._tracker.malformed()
                self._malformed = str(error)
                self._keep(self._tracker.due(self._clock()))
            return
        except LiveError as error:
            self._break(error)
            return
        with self._lock:
            at = self._clock()
            if reading is None:
                self._keep(self._tracker.due(at))
            else:
                self._received(at)
                self._keep(self._tracker.take(reading, at))

    @property
    def waiting(self) -> int:
        """Number of readings that ``take`` would return."""
        return len(self._waiting)

    def take(self) -> Arrived | None:
        """Return the next reading in order; None if none is waiting."""
        with self._lock:
            if not self._waiting:
                self._arrived.clear()
                return None
            return self._waiting.popleft()

    def take_newest(self, needed: Callable[[Reading], bool]) -> list[Arrived]:
        """Return all that has arrived, in order, without readings that newer ones have replaced; those are counted.

        Args:
            needed: Called for each reading from the newest to the oldest; returns False once the readings so far
                contain all that is needed.
        """
        if self._newest_only and self._open and isinstance(self.source, PacketSource):
            with suppress(LiveError):  # the receiving thread gets the same error and reopens the source
                self._drain()
        with self._lock:
            self._arrived.clear()
            packets = self._packets
            self._packets = deque()
            self._packet_bytes = 0
            waiting = self._waiting
            self._waiting = deque()
            more = True
            decoded: list[tuple[float, Reading]] = []
            while more and packets:
                at, packet = packets.pop()
                reading = self._decode(packet)
                if reading is not None:
                    decoded.append((at, reading))
                    more = needed(reading)
            kept: list[Arrived] = []
            while more and waiting:
                kept.append(waiting.pop())
                more = needed(kept[-1].reading)
            self._tracker.supersede(self._plausible(packets), decoded=False)
            self._tracker.supersede([item.at for item in waiting], decoded=True)
            kept.reverse()
            for at, reading in reversed(decoded):
                kept += self._aged(self._tracker.take(reading, at))
            return kept

    def wait(self, timeout: float) -> bool:
        """Wait for a reading for at most ``timeout`` [s]; return whether there is one."""
        return self._arrived.wait(timeout)

    @property
    def status(self) -> ConnectionStatus:
        """Current state and statistics."""
        with self._lock:
            now = self._clock()
            state = self._state(now)
            return ConnectionStatus(
                state,
                self.source.address,
                self._tracker.counts,
                self._tracker.rate(now),
                None if self.source.finite else self._tracker.delay,  # readings of a file have no delay
                self._reconnects,
                self._problem,
                max(self._retry_at - now, 0.0) if state is ConnectionState.RECONNECTING else None,
                self._malformed,
                self.source.refused if isinstance(self.source, PacketSource) else {},
                self.waiting,
            )

    def _state(self, now: float) -> ConnectionState:
        if self._failed:
            return ConnectionState.FAILED
        if self._ended:
            return ConnectionState.ENDED if self.ended else ConnectionState.RECEIVING
        if self._stop.is_set():
            return ConnectionState.CLOSED
        if not self._open:
            return ConnectionState.RECONNECTING if self._problem else ConnectionState.CLOSED
        return ConnectionState.RECEIVING if now - self._last < SILENT_SECONDS else ConnectionState.WAITING

    def _drain(self) -> None:
        """Receive every packet in the system's buffer; raises LiveError if the connection is lost."""
        source = self.source
        assert isinstance(source, PacketSource)
        with self._receiving:
            received = []
            size = 0
            while size < _MOST_PACKET_BYTES and self._open and (packet := source.receive_packet(0.0)) is not None:
                received.append(packet)
                size += len(packet)
            if not received:
                return
            with self._lock:
                now = self._clock()
                self._received(now)
                self._packets.extend((now, packet) for packet in received)
                self._packet_bytes += size
                while self._packet_bytes > _MOST_PACKET_BYTES:
                    self._packet_bytes -= len(self._packets.popleft()[1])
                    self._tracker.overflowed()
                if not self._newest_only:  # changed by another thread since: packets are no longer taken
                    self._decode_all()
                self._arrived.set()

    def _received(self, at: float) -> None:
        self._pause = FIRST_PAUSE
        self._problem = None
        self._last = at

    def _aged(self, arrived: list[Arrived]) -> list[Arrived]:
        """Add the ages of readings in order; readings that arrive too late to be processed do not affect the ages."""
        return [item._replace(age=self.ages.add(item.reading.time, item.at)) for item in arrived]

    def _decode(self, packet: bytes) -> Reading | None:
        """Return the reading of a packet; None for a malformed one, which is counted."""
        assert isinstance(self.source, PacketSource)
        try:
            return self.source.decode_packet(packet)
        except MalformedReadingError as error:
            self._tracker.malformed()
            self._malformed = str(error)
            return None

    def _plausible(self, packets: Iterable[tuple[float, bytes]]) -> list[float]:
        """Return the arrivals of packets that look like readings; the others are counted as malformed, not decoded."""
        times = []
        for at, packet in packets:
            assert isinstance(self.source, PacketSource)
            if self.source.is_plausible_packet(packet):
                times.append(at)
            else:
                self._tracker.malformed()
                self._malformed = self._malformed or f"it does not begin like a reading (found: {packet[:40]!r})"
        return times

    def drop_waiting(self) -> None:
        """Drop the waiting readings and count them as overflowed."""
        with self._lock:
            self._tracker.overflowed(len(self._waiting) + len(self._packets))
            self._waiting.clear()
            self._packets.clear()
            self._packet_bytes = 0

    def _decode_all(self) -> None:
        """Decode the waiting packets in order."""
        while self._packets:
            at, packet = self._packets.popleft()
            reading = self._decode(packet)
            if reading is not None:
                self._keep(self._tracker.take(reading, at))
        self._packet_bytes = 0

    def _keep(self, arrived: list[Arrived]) -> None:
        for item in self._aged(arrived):
            if len(self._waiting) >= MOST_WAITING:
                self._waiting.popleft()
                self._tracker.overflowed()
            self._waiting.append(item)
        if arrived:
            self._arrived.set()

    def _break(self, error: TactileMapsError) -> None:
        """Close a lost source and retry after a pause. A file is not retried."""
        with self._receiving:
            self.source.close()
            self._open = False
        with self._lock:
            self._open = False
            self._problem = str(error)
            self._keep(self._tracker.flush())
            self._tracker.forget_sequence()
            self.ages.reset()
            if self.source.finite:
                self._failed = self._ended = True
            self._retry_at = self._clock() + self._pause
            self._pause = min(2 * self._pause, LONGEST_PAUSE)

    def _reopen(self, timeout: float) -> bool:
        wait = self._retry_at - self._clock()
        if wait > 0:
            self._stop.wait(min(wait, timeout))
            return False
        try:
            self.source.open()
        except TactileMapsError as error:
            self._break(error)
            return False
        self._open = True
        self._reconnects += bool(self._opened)
        self._opened += 1
        return True

    def _loop(self) -> None:
        try:
            while not (self._stop.is_set() or self._ended):
                if self.source.finite and len(self._waiting) >= MOST_WAITING:
                    self._stop.wait(_POLL)  # a file waits until its readings are processed; none are dropped
                else:
                    self.step()
                    if self._newest_only:
                        self._stop.wait(_REST)
        except TactileMapsError as error:
            self._fail(str(error))
        except Exception as error:  # an uncaught error would end the thread unnoticed
            self._fail(describe_unexpected_error(error))

    def _fail(self, problem: str) -> None:
        with self._lock:
            self._problem = problem
            self._failed = True
            self._ended = True
