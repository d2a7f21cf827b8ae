"""Passes over readings: one by one, or all that has arrived while motion is sent; on threads that delay no stop."""

from __future__ import annotations

import gc
import threading
from contextlib import closing

import numpy as np
import pytest

from tactile_maps.live.motion.command_loop import CommandLoop
from tactile_maps.live.motion.motion_sender import StopReason
from tactile_maps.live.prepare import as_measured
from tactile_maps.live.readings.readings import Reading, SourceEndedError, Unit
from tactile_maps.live.session.connection import Connection
from tactile_maps.live.session.measured_session import MeasuredSession
from tests.support.touch import prepared_bar

PATIENCE = 60.0


class Source:
    """Readings of the bar's taxels."""

    address = "scripted"
    finite = False
    slow = False

    def __init__(self, count, *, finite=False):
        self.finite = finite
        self._left = []
        self._made = 0
        self.add(count)

    def add(self, count):
        numbers = range(self._made, self._made + count)
        self._left += [Reading(0.01 * n, np.full(60, float(n)), Unit.PASCAL, sequence=n) for n in numbers]
        self._made += count

    def open(self): ...
    def close(self): ...

    def receive(self, timeout):
        if self._left:
            return self._left.pop(0)
        if self.finite:
            raise SourceEndedError("end")
        return None


class Motion:
    """Motion that records the calls it receives."""

    def __init__(self, *, active=False):
        self.active = active
        self.taken = 0
        self.checked = 0
        self.halted = 0
        self.late = threading.Event()

    def take(self):
        self.taken += 1

    def check(self):
        self.checked += 1

    def check_deadline(self):
        self.late.set()

    def halt(self, reason=StopReason.BY_HAND):
        self.halted += 1


def loop_of(motion, count=5, *, finite=False, **options):
    """A loop whose readings have arrived, and the frames it makes."""
    connection = Connection(Source(count, finite=finite), clock=lambda: 0.0)
    connection.open()
    for _ in range(count + finite):
        connection.step(0.0)
    session = MeasuredSession(as_measured(prepared_bar()))
    frames = []
    return CommandLoop(connection, session, motion, frames.append, **options), frames


@pytest.mark.parametrize(("finite", "taken"), [(False, 3), (True, 20)])
def test_waiting_readings_are_processed_for_a_limited_time_at_the_end(finite, taken):
    loop, frames = loop_of(Motion(), 20, finite=finite)
    seconds = iter(range(1000))
    loop.finish(3.0, clock=lambda: float(next(seconds)))
    assert (len(frames), loop.taken) == (taken, taken)
    assert loop._connection.status.counts.overflowed == 20 - taken


def test_each_reading_is_a_frame_without_motion():
    motion = Motion()
    loop, frames = loop_of(motion)
    while loop.step():
        pass
    assert [frame.measured.sequence for frame in frames] == [0, 1, 2, 3, 4]
    assert (motion.taken, motion.checked, loop.taken) == (5, 1, 5)


def test_all_waiting_readings_form_one_frame_while_motion_is_sent():
    motion = Motion(active=True)
    loop, frames = loop_of(motion)
    assert loop.step()
    assert [frame.measured.sequence for frame in frames] == [4]
    assert motion.taken == 1
    assert not loop.step()
    assert motion.checked == 1


@pytest.mark.parametrize(("waiting", "frames"), [(5, 5), (6, 1)])
def test_loop_that_shares_its_time_combines_readings_once_it_is_late(waiting, frames):
    loop, made = loop_of(Motion(), waiting, shares=True)
    while loop.step():
        pass
    assert (len(made), loop.taken) == (frames, waiting)
    assert loop._session.facts.combined == waiting - frames
    assert made[-1].measured.sequence == waiting - 1


def test_newest_of_too_many_waiting_readings_is_used_next():
    loop, frames = loop_of(Motion(), 10, shares=True)
    connection = loop._connection
    used = loop._session.apply
    connection.source.add(3 * 990)

    def use_while_three_arrive(item, **options):
        for _ in range(3):
            connection.step(0.0)
        return used(item, **options)

    loop._session.apply = use_while_three_arrive
    shown = []
    while connection.waiting:
        loop.step()
        shown.append((frames[-1].measured.sequence, connection.waiting))
    assert shown[:4] == [(9, 30), (39, 90), (129, 270), (399, 810)]
    assert shown[4] == (1209, 3), "the newest of the 810 that waited"
    facts = loop._session.facts
    superseded = connection.status.counts.superseded
    assert superseded > 0
    assert facts.readings == facts.combined + len(frames)
    assert facts.readings + superseded == frames[-1].measured.sequence + 1


def test_file_is_processed_reading_by_reading_while_motion_is_sent():
    motion = Motion(active=True)
    loop, frames = loop_of(motion, finite=True)
    while loop.step():
        pass
    assert len(frames) == motion.taken == 5


def test_loop_on_threads_ends_with_its_source_and_stops_motion():
    motion = Motion()
    loop, frames = loop_of(motion, finite=True)
    loop.start()
    assert loop.finished.wait(PATIENCE)
    loop.close()
    assert len(frames) == 5
    assert motion.halted >= 1
    assert not {"commands", "watchdog"} & {thread.name for thread in threading.enumerate()}


def test_error_stops_motion_and_is_raised():
    motion = Motion()

    def fail(_frame):
        raise ZeroDivisionError("oh")

    loop, _frames = loop_of(motion)
    loop._each = fail
    loop.start()
    loop._thread.join(PATIENCE)
    assert motion.halted == 1
    with pytest.raises(ZeroDivisionError):
        loop.raise_error()
    with pytest.raises(ZeroDivisionError):
        loop.close()


def test_watchdog_checks_during_a_long_pass():
    motion = Motion()
    passed = []

    def take():  # a controller that is not ready before the watchdog has looked
        motion.late.clear()
        passed.append(motion.late.wait(PATIENCE))

    motion.take = take
    loop, _frames = loop_of(motion, 1, finite=True)
    with closing(loop):
        loop.start()
        assert loop.finished.wait(2 * PATIENCE)
    assert passed == [True]


def test_readings_wait_and_motion_stops_while_paused():
    motion = Motion()
    loop, frames = loop_of(motion, paused=lambda: True)
    halted = threading.Event()
    reasons = []

    def halt(reason=StopReason.BY_HAND):
        reasons.append(reason)
        halted.set()

    motion.halt = halt
    loop.start()
    assert halted.wait(PATIENCE)
    assert reasons[0] is StopReason.PAUSED
    loop.close()
    assert frames == []


@pytest.mark.parametrize("active", [False, True])
def test_swapped_channels_are_looked_for_only_while_no_motion_is_sent(active):
    loop, _frames = loop_of(Motion(active=active))
    while loop.step():
        pass
    assert (loop._session._swaps._last is None) is active


def test_objects_created_before_the_loop_are_excluded_from_garbage_collection():
    motion = Motion()
    frozen = threading.Event()
    motion.check = lambda: frozen.set() if gc.get_freeze_count() else None
    loop, _frames = loop_of(motion, 0)
    before = gc.get_freeze_count()
    with closing(loop):
        loop.start()
        assert frozen.wait(PATIENCE)
    assert gc.get_freeze_count() <= before
