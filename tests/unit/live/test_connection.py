"""A connection survives its source: it is opened again with growing pauses, and counts what happened."""

from __future__ import annotations

import threading

from app.core.errors import LiveError
from app.live.connection import FIRST_PAUSE, LONGEST_PAUSE, MOST_WAITING, Connection, ConnectionState
from app.live.readings import MalformedReadingError, Reading, SourceEndedError


class Scripted:
    """A source that does what its script says; True opens, a LiveError in its place refuses to."""

    def __init__(self, *script, opens=(), finite=False):
        self.address, self.finite, self.slow = "scripted", finite, False
        self._script, self._opens = list(script), list(opens)
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


def test_readings_come_in_order_and_malformed_ones_are_counted():
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


def test_a_broken_source_is_opened_again_with_growing_pauses():
    clock, gone = Clock(), LiveError("gone")
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
    assert status.counts.lost == 0  # while nobody listened, nothing was lost on the way


def test_silence_is_told():
    clock = Clock()
    connection = Connection(Scripted(reading(0)), clock=clock)
    connection.open()
    connection.step(0.0)
    clock.now = 2.0
    assert connection.status.state is ConnectionState.WAITING


def test_a_file_ends_and_is_not_opened_again():
    source = Scripted(reading(0), SourceEndedError("end"), finite=True)
    connection = Connection(source)
    connection.open()
    for _ in range(5):
        connection.step(0.0)
    assert not connection.ended  # one waits to be taken
    assert taken(connection) == [0]
    assert connection.ended
    assert connection.status.state is ConnectionState.ENDED
    assert source.opened == 1


def test_a_file_that_breaks_has_failed():
    connection = Connection(Scripted(LiveError("damaged"), finite=True))
    connection.open()
    connection.step(0.0)
    assert connection.ended
    assert (connection.status.state, connection.status.problem) == (ConnectionState.FAILED, "damaged.")


def test_what_nobody_takes_is_dropped_and_counted():
    connection = Connection(Scripted(*map(reading, range(MOST_WAITING + 5))))
    connection.open()
    for _ in range(MOST_WAITING + 5):
        connection.step(0.0)
    assert connection.status.counts.overflowed == 5
    assert taken(connection) == list(range(5, MOST_WAITING + 5))


def test_on_a_thread_it_wakes_who_waits_and_ends():
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


def test_what_nobody_foresaw_is_told(monkeypatch, tmp_path):
    monkeypatch.setattr("app.core.errors.user_log_path", lambda *_a, **_k: tmp_path)
    connection = Connection(Scripted(reading(0), ZeroDivisionError("oh")))
    connection.start()
    while connection.status.state is not ConnectionState.FAILED:
        connection.wait(0.01)
    connection.close()
    assert "ZeroDivisionError: oh" in connection.status.problem
