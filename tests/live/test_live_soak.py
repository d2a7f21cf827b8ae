"""Half an hour of live input in a minute: loss, jitter, repeats, breaks; nothing grows or is lost unsaid."""

from __future__ import annotations

import gc
import heapq

import numpy as np
import psutil
import pytest

from tactile_maps.core.errors import LiveError
from tactile_maps.live.prepare import as_measured
from tactile_maps.live.readings.readings import MalformedReadingError, Reading, Unit
from tactile_maps.live.readings.wire_format import decode, encode_binary
from tactile_maps.live.session.connection import Connection
from tactile_maps.live.session.measured_session import MeasuredSession
from tests.support.touch import bar_skin, prepared_bar

RATE = 100.0
LONG = pytest.mark.long


class RoughNetwork:
    """A source whose packets are dropped, late, repeated, damaged, and whose connection breaks; time is simulated."""

    address = "rough"
    finite = False
    slow = False

    def __init__(self, packets, seed):
        self.now = 0.0
        self._packets = packets
        self._random = np.random.default_rng(seed)
        self._number = 0
        self._air = []
        self.arrived = np.zeros(packets, dtype=bool)
        self.arrivals = 0
        self.damaged = 0
        self.broken = 0
        self.connected = False
        self._values = np.zeros(len(bar_skin()))

    def __call__(self):
        return self.now

    def open(self):
        if self._random.random() < 0.5:
            raise LiveError("still broken")
        self.connected = True

    def close(self):
        """Packets stay in the air."""

    def receive(self, timeout):
        if self._random.random() < 1e-4:
            self.broken = self.broken + 1
            self.connected = False
            raise LiveError("broken")
        self._send()
        if not self._air or self._air[0][0] > self.now + timeout:
            self.now += timeout
            return None
        at, _, packet = heapq.heappop(self._air)
        self.now = max(self.now, at)
        if packet is None:
            self.damaged += 1
            raise MalformedReadingError("damaged")
        reading = decode(packet)
        self.arrived[reading.sequence] = True
        self.arrivals += 1
        return reading

    def _send(self):
        """All that was sent by now, with what the network does to it."""
        while self._number < self._packets and self._number / RATE <= self.now + 0.02:
            number = self._number
            random = self._random.random(4)
            self._number += 1
            if random[0] < 0.02:
                continue
            self._values[number % len(self._values)] = number % 50
            packet = encode_binary(Reading(number / RATE, self._values, Unit.COUNTS, sequence=number))
            delay = 0.012 * random[1]  # a packet may overtake the one before it
            for copy in range(2 if random[2] < 0.01 else 1):
                damaged = random[3] < 0.005
                at = number / RATE + delay + 0.001 * copy
                heapq.heappush(self._air, (at, 2 * number + copy, None if damaged else packet))

    @property
    def over(self):
        return self._number >= self._packets and not self._air


@pytest.mark.long
@pytest.mark.parametrize("packets", [600, pytest.param(180_000, marks=LONG)])
def test_no_received_reading_is_lost_and_memory_does_not_grow(packets):
    network = RoughNetwork(packets, seed=1)
    connection = Connection(network, clock=network)
    session = MeasuredSession(as_measured(prepared_bar()), connection.take)
    shown = np.zeros(packets, dtype=bool)
    last = -1
    sizes = []
    process = psutil.Process()

    def take():
        nonlocal last
        while (item := connection.take()) is not None:
            assert item.reading.sequence > last
            last = item.reading.sequence
            shown[last] = True
            session.show(item)

    while not network.over:
        connection.step(0.005)
        if not network.connected:
            network.now += 0.05  # the caller waits until it is opened again
        take()
        if last >= packets // 6 * (len(sizes) + 1):
            gc.collect()
            sizes.append(process.memory_info().rss)
    connection.close()
    take()
    counts = connection.status.counts
    assert counts.received == network.arrivals
    assert counts.malformed == network.damaged > 0
    assert shown.sum() == counts.received - counts.duplicated - counts.late == session.facts.readings
    assert (network.arrived & ~shown).sum() <= counts.late  # what arrived and is not shown was counted
    assert counts.duplicated > 0
    assert counts.reordered > 0
    assert counts.restarts == counts.overflowed == 0
    if packets > 100_000:
        assert network.broken > 10
        assert connection.status.reconnects > 10
        assert max(sizes[2:]) - sizes[1] < 10_000_000
