"""A process beside the window: answers in their order, each in a turn of its own; one that dies is told last."""

from __future__ import annotations

import multiprocessing as mp
import os
import signal

import pytest

from tactile_widgets.workers.worker_process import SourceToken, WorkerProcess, _work

TOKEN = SourceToken("test")


def make_handler():
    """In the process: counts up to what is asked for; asked for less than nothing it counts to one and dies."""

    def serve(request, tell):
        for number in range(max(request, 1)):
            tell("count", number)
        if request < 0:
            os._exit(1)

    return serve


@pytest.fixture
def process(qtbot):
    process = WorkerProcess("test", make_handler)
    process.told = []
    process.answered.connect(lambda number, kind, result: process.told.append((number, kind, result.value)))
    process.ended.connect(lambda token: process.told.append(token))
    yield process
    process.close()


def read(process, qtbot):
    """Turn the process's loop by hand until it has read something."""
    process._timer.stop()

    def has_read():
        process._on_timer()
        return bool(process._read)

    qtbot.waitUntil(has_read)


def test_answers_come_in_the_order_of_the_requests(process, qtbot):
    assert [process.send(count, TOKEN) for count in (2, 1)] == [1, 2]
    qtbot.waitUntil(lambda: process.told[-1:] == [(2, "done", None)], timeout=30_000)
    assert process.told == [(1, "count", 0), (1, "count", 1), (1, "done", None), (2, "count", 0), (2, "done", None)]
    assert process.ready
    assert not process._timer.isActive(), "nothing is awaited"


def test_between_reading_an_answer_and_telling_it_the_loop_turns(process, qtbot):
    process.warm()
    qtbot.waitUntil(lambda: process.ready, timeout=30_000)
    process.send(1, TOKEN)
    read(process, qtbot)
    assert not process.told
    process._on_timer()
    assert process.told[0] == (1, "count", 0)


def test_what_it_said_before_it_died_is_told_first(process, qtbot):
    process.warm()
    qtbot.waitUntil(lambda: process.ready, timeout=30_000)
    process.send(-1, TOKEN)
    process._timer.stop()
    process._process.join(10)  # so that the answer and the end wait together
    process._on_timer()
    assert process.told == [(1, "count", 0), TOKEN]
    process.send(1, TOKEN)
    qtbot.waitUntil(lambda: process.told[-1:] == [(2, "done", None)], timeout=30_000)


def test_a_closed_one_tells_nothing_of_what_was_read(process, qtbot):
    process.warm()
    qtbot.waitUntil(lambda: process.ready, timeout=30_000)
    process.send(1, TOKEN)
    read(process, qtbot)
    process.close()
    process._on_timer()
    assert not process.told


def broken_file():
    """In the process: what is asked for is in a file that ends too soon."""

    def serve(request, tell):
        raise EOFError(request)

    return serve


@pytest.mark.parametrize("asked", [(), ("a map",)], ids=["before it is ready", "while it works"])
def test_it_ends_quietly_when_the_window_has_gone(asked):
    ours, theirs = mp.Pipe()
    for request in asked:
        ours.send(request)
    ours.close()
    on_interrupt = signal.getsignal(signal.SIGINT)
    try:
        _work(theirs, broken_file)
    finally:
        signal.signal(signal.SIGINT, on_interrupt)
        theirs.close()


def test_a_file_that_ends_too_soon_is_told_and_does_not_end_it(process, qtbot):
    process._make = broken_file
    process.send("cap.tmap", TOKEN)
    qtbot.waitUntil(lambda: process.told[-1:] == [(1, "done", None)], timeout=30_000)
    assert process.told[0] == (1, "failed", "An unexpected problem: EOFError: cap.tmap.")
    assert process.ready
