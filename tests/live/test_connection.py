"""A connection survives its source: it is opened again with growing pauses, and counts what happened."""

from __future__ import annotations

import threading
from typing import ClassVar

import pytest

from tactile_maps.core.errors import LiveError
from tactile_maps.live.readings.readings import MalformedReadingError, Reading, SourceEndedError
from tactile_maps.live.session.connection import FIRST_PAUSE, LONGEST_PAUSE, MOST_WAITING, Connection, ConnectionState


class Scripted:
    """A source that does what its script says; True opens, a LiveError in its place refuses to."""

    def __init__(self, *script, opens=(), finite=False):
        self.address = "scripted"
        self.finite = finite
        self.slow = False
        self._script = list(script)
        self._opens = list(opens)
        self.opened = self.closed = 0

    def open(self):
        self.opened += 1
        if self._opens and (error := self._opens.pop(0)):
            raise error

    def receive(self, timeout):
        item = self._script.pop(0) if self._script else None
        if isinstance(item, Exception):
            raise item
        return item

    def close(self):
        self.closed += 1


class Clock:
    now = 0.0

    def __call__(self):
        return self.now


def reading(number):
    return Reading(0.01 * number, [1.0], sequence=number)


def taken(connection):
    found = []
    while (item := connection.take()) is not None:
        found.append(item.reading.sequence)
    return found


def test_readings_arrive_in_order_and_malformed_ones_are_counted():
    source = Scripted(reading(0), MalformedReadingError("bad", value="x"), reading(2), reading(1), None)
    connection = Connection(source, clock=Clock())
    connection.open()
    for _ in range(5):
        connection.step(0.0)
    assert taken(connection) == [0, 1, 2]
    status = connection.status
    assert (status.counts.malformed, status.counts.reordered) == (1, 1)
    assert status.malformed == "bad (found: x)."
    assert status.state is ConnectionState.RECEIVING


def test_failed_source_is_reopened_with_increasing_pauses():
    clock = Clock()
    gone = LiveError("gone")
    source = Scripted(reading(0), gone, reading(5), opens=[None, *[gone] * 8])
    connection = Connection(source, clock=clock)
    connection.open()
    connection.step(0.0)
    connection.step(0.0)
    assert connection.status.state is ConnectionState.RECONNECTING
    assert connection.status.problem == "gone."
    tries = []
    while len(tries) < 9:
        before = source.opened
        connection.step(0.0)
        if source.opened > before:
            tries.append(clock.now)
        clock.now += 0.25
    pauses = [b - a for a, b in zip([0.0, *tries], tries, strict=False)]
    assert pauses[:4] == [FIRST_PAUSE, 0.5, 1.0, 2.0]
    assert max(pauses) == LONGEST_PAUSE
    connection.step(0.0)
    status = connection.status
    assert (status.reconnects, status.problem, status.state) == (1, None, ConnectionState.RECEIVING)
    assert taken(connection) == [0, 5]
    assert status.counts.lost == 0  # nothing counts as lost while the source was closed


def test_silence_is_reported():
    clock = Clock()
    connection = Connection(Scripted(reading(0)), clock=clock)
    connection.open()
    connection.step(0.0)
    clock.now = 2.0
    assert connection.status.state is ConnectionState.WAITING


def test_file_ends_and_is_not_reopened():
    source = Scripted(reading(0), SourceEndedError("end"), finite=True)
    connection = Connection(source)
    connection.open()
    for _ in range(5):
        connection.step(0.0)
    assert not connection.ended  # one waits to be taken
    status = connection.status
    assert (status.state, status.waiting) == (ConnectionState.RECEIVING, 1)
    assert taken(connection) == [0]
    assert connection.ended
    assert connection.status.state is ConnectionState.ENDED
    assert source.opened == 1


def test_read_error_of_a_file_is_a_failure():
    connection = Connection(Scripted(LiveError("damaged"), finite=True))
    connection.open()
    connection.step(0.0)
    assert connection.ended
    assert (connection.status.state, connection.status.problem) == (ConnectionState.FAILED, "damaged.")


@pytest.mark.long
def test_unread_readings_are_dropped_and_counted():
    connection = Connection(Scripted(*map(reading, range(MOST_WAITING + 5))))
    connection.open()
    for _ in range(MOST_WAITING + 5):
        connection.step(0.0)
    assert connection.status.counts.overflowed == 5
    assert taken(connection) == list(range(5, MOST_WAITING + 5))


def test_connection_on_a_thread_wakes_the_waiting_caller_and_ends():
    source = Scripted(*map(reading, range(100)))
    connection = Connection(source)
    connection.start()
    found = []
    while len(found) < 100:
        assert connection.wait(5.0)
        found += taken(connection)
    connection.close()
    connection.close()
    assert found == list(range(100))
    assert "live input" not in [thread.name for thread in threading.enumerate()]
    assert source.closed >= 1
    assert connection.status.state is ConnectionState.CLOSED


def test_unexpected_exception_is_reported(monkeypatch, tmp_path):
    monkeypatch.setattr("tactile_maps.core.errors.user_log_path", lambda *_a, **_k: tmp_path)
    connection = Connection(Scripted(reading(0), ZeroDivisionError("oh")))
    connection.start()
    while connection.status.state is not ConnectionState.FAILED:
        connection.wait(0.01)
    connection.close()
    assert "ZeroDivisionError: oh" in connection.status.problem


class Packets(Scripted):
    """A source of packets: the system keeps those that were sent until they are received."""

    one_sender = False
    refused: ClassVar[dict] = {}

    def __init__(self, *packets):
        super().__init__()
        self.buffer = list(packets)
        self.decoded = []

    def wait_for_packet(self, timeout):
        return bool(self.buffer)

    def receive_packet(self, timeout):
        return self.buffer.pop(0) if self.buffer else None

    def is_plausible_packet(self, packet):
        return packet != b"bad"

    def decode_packet(self, packet):
        self.decoded.append(packet)
        if packet == b"bad":
            raise MalformedReadingError("bad", value="x")
        return reading(int(packet))

    def receive(self, timeout):
        packet = self.receive_packet(timeout)
        return None if packet is None else self.decode_packet(packet)


def numbers(items):
    return [item.reading.sequence for item in items]


def test_only_needed_readings_of_a_backlog_are_decoded():
    source = Packets(b"0")
    connection = Connection(source, clock=Clock())
    connection.open()
    connection.keep_newest(on=True)
    assert numbers(connection.take_newest(lambda _: True)) == [0]
    source.decoded.clear()
    source.buffer += [b"%d" % number for number in range(1, 1000)]
    missing = {997, 999}

    def needed(found):
        missing.discard(found.sequence)
        return bool(missing)

    assert numbers(connection.take_newest(needed)) == [997, 998, 999]
    assert source.decoded == [b"999", b"998", b"997"]
    counts = connection.status.counts
    assert (counts.received, counts.superseded, counts.lost) == (1000, 996, 0)


def test_reading_ahead_of_its_turn_is_not_delayed_in_newest_only_mode():
    source = Packets(b"0", b"2", b"bad", b"1", b"4")
    connection = Connection(source, clock=Clock())
    connection.open()
    connection.keep_newest(on=True)
    assert numbers(connection.take_newest(lambda _: True)) == [0, 2, 4]
    counts = connection.status.counts
    assert (counts.malformed, counts.late, counts.lost) == (1, 1, 1)


def test_readings_already_waiting_count_as_superseded():
    source = Packets(*[b"%d" % number for number in range(5)])
    connection = Connection(source, clock=Clock())
    connection.open()
    for _ in range(5):
        connection.step(0.0)
    connection.keep_newest(on=True)
    source.buffer += [b"5"]
    connection.step(0.0)
    calls = []
    found = connection.take_newest(lambda one: calls.append(one.sequence) or len(calls) < 3)
    assert (numbers(found), calls) == ([3, 4, 5], [5, 4, 3])
    counts = connection.status.counts
    assert (counts.received, counts.superseded) == (6, 3)


def test_every_reading_is_delivered_after_newest_only_mode():
    source = Packets(b"0", b"1")
    connection = Connection(source, clock=Clock())
    connection.open()
    connection.keep_newest(on=True)
    connection.step(0.0)
    source.buffer += [b"2"]
    connection.keep_newest(on=False)
    connection.step(0.0)
    assert taken(connection) == [0, 1, 2]


def test_stream_keeps_its_one_sender_after_a_stop():
    source = Packets(b"0")
    connection = Connection(source, clock=Clock())
    connection.open()
    connection.keep_newest(on=False)
    assert not source.one_sender, "nothing was sent"
    for on in (True, False, True, False):
        connection.keep_newest(on=on)
        assert source.one_sender


def test_packets_received_while_sending_ends_are_processed_in_order():
    source = Packets(b"0", b"1", b"2")
    connection = Connection(source, clock=Clock())
    connection.open()
    connection.keep_newest(on=True)
    receive = source.receive_packet

    def ends_meanwhile(timeout):
        packet = receive(timeout)
        if packet == b"2":
            connection.keep_newest(on=False)  # as the thread that commands does
        return packet

    source.receive_packet = ends_meanwhile
    connection.step(0.0)
    source.buffer += [b"3"]
    connection.step(0.0)
    assert taken(connection) == [0, 1, 2, 3]
    counts = connection.status.counts
    assert (counts.received, counts.late, counts.restarts) == (4, 0, 0)


def test_superseded_packets_without_readings_are_not_counted_as_received():
    source = Packets(b"0", b"bad", b"bad", b"1", b"2")
    connection = Connection(source, clock=Clock())
    connection.open()
    connection.keep_newest(on=True)
    assert numbers(connection.take_newest(lambda _: False)) == [2]
    status = connection.status
    assert (status.counts.received, status.counts.superseded, status.counts.malformed) == (3, 2, 2)
    assert "bad" in status.malformed


def test_dropped_readings_are_counted():
    connection = Connection(Scripted(*map(reading, range(3))), clock=Clock())
    connection.open()
    for _ in range(3):
        connection.step(0.0)
    assert connection.take().reading.sequence == 0
    connection.drop_waiting()
    assert taken(connection) == []
    assert connection.status.counts.overflowed == 2


def test_newest_only_mode_works_for_a_source_without_packets():
    connection = Connection(Scripted(*map(reading, range(5))), clock=Clock())
    connection.open()
    connection.keep_newest(on=True)
    for _ in range(5):
        connection.step(0.0)
    assert numbers(connection.take_newest(lambda _: False)) == [4]
    assert connection.status.counts.superseded == 4


def test_file_is_always_read_in_order():
    connection = Connection(Scripted(*map(reading, range(3)), finite=True))
    connection.open()
    connection.keep_newest(on=True)
    for _ in range(3):
        connection.step(0.0)
    assert taken(connection) == [0, 1, 2]


def test_number_of_unread_packets_is_limited(monkeypatch):
    monkeypatch.setattr("tactile_maps.live.session.connection._MOST_PACKET_BYTES", 10)
    source = Packets(*[b"%d" % number for number in range(15)])
    connection = Connection(source, clock=Clock())
    connection.open()
    connection.keep_newest(on=True)
    for _ in range(3):
        connection.step(0.0)
    assert numbers(connection.take_newest(lambda _: True))[-1] == 14
    assert connection.status.counts.overflowed > 0


def test_ages_are_reported_with_readings_and_reset_with_the_connection():
    clock = Clock()
    source = Scripted(reading(0), reading(1), LiveError("gone"), reading(2))
    connection = Connection(source, clock=clock)
    connection.open()
    connection.step(0.0)
    clock.now = 0.11
    connection.step(0.0)
    assert [round(connection.take().age, 4) for _ in range(2)] == [0.0, 0.1]
    connection.step(0.0)
    clock.now = 5.0
    connection.step(0.0)
    connection.step(0.0)
    assert connection.take().age == 0.0
