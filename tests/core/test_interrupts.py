"""Signals wait for the end of a block, and are then what they would have been."""

from __future__ import annotations

import os
import signal
import threading

import pytest

from tactile_maps.core.interrupts import TerminatedError, interrupts_held, signals_raised, terminal_closed


def test_interrupt_is_raised_after_the_block():
    done = []

    def work():
        with interrupts_held():
            os.kill(os.getpid(), signal.SIGINT)
            os.kill(os.getpid(), signal.SIGINT)
            done.append(True)

    with pytest.raises(KeyboardInterrupt):
        work()
    assert done
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_existing_handler_is_called_once_and_restored():
    called = []

    def handler(number, _frame):
        called.append(number)

    before = signal.signal(signal.SIGTERM, handler)
    try:
        with interrupts_held():
            with interrupts_held():
                os.kill(os.getpid(), signal.SIGTERM)
            assert called == []
        assert called == [signal.SIGTERM]
        assert signal.getsignal(signal.SIGTERM) is handler
    finally:
        signal.signal(signal.SIGTERM, before)


def test_held_interrupts_in_other_threads_have_no_effect():
    seen = []

    def work():
        with interrupts_held():
            seen.append(signal.getsignal(signal.SIGINT))

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert seen == [signal.default_int_handler]


ENDING = [signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT]


@pytest.mark.parametrize("number", ENDING)
def test_ending_signal_is_raised_once_and_waits_for_a_held_block(number):
    done = []

    def work():
        with signals_raised():
            # Without it the signal would end the test run.
            assert all(callable(signal.getsignal(one)) for one in ENDING)
            try:
                with interrupts_held():
                    os.kill(os.getpid(), number)
                    done.append("held")
            finally:
                for other in (*ENDING, signal.SIGINT):  # as a terminal and a batch system send them, one after another
                    os.kill(os.getpid(), other)
                done.append("cleaned up")

    with pytest.raises(TerminatedError) as stop:
        work()
    assert stop.value.number == number
    assert done == ["held", "cleaned up"]
    assert [signal.getsignal(one) for one in ENDING] == [signal.SIG_DFL] * 3
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_ignored_hangup_stays_ignored():
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)  # as nohup does
    try:
        with signals_raised():
            os.kill(os.getpid(), signal.SIGHUP)
            assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGHUP, before)


def test_closed_terminal_is_recognised_and_raised_as_hangup():
    kept = os.dup(0)
    screen, terminal = os.openpty()
    os.dup2(terminal, 0)
    os.close(terminal)

    def hang_up():
        with signals_raised():
            os.close(screen)
            threading.Event().wait(10.0)

    try:
        assert not terminal_closed()
        with pytest.raises(TerminatedError) as stop:
            hang_up()
        assert stop.value.number == signal.SIGHUP
        assert terminal_closed()
    finally:
        os.dup2(kept, 0)
        os.close(kept)
    assert not any(thread.name == "terminal" for thread in threading.enumerate())
