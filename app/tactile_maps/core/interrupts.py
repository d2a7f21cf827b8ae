"""Signals that end the program: raised once as an exception, and delayed during critical work.

Ctrl-C, SIGTERM, SIGQUIT, SIGHUP and the closing of the terminal all raise an exception in the main thread, whose
``finally`` blocks stop a robot and complete a recording.
"""

from __future__ import annotations

import os
import select
import signal
import stat
import threading
import time
from collections.abc import Generator
from contextlib import ExitStack, contextmanager, suppress
from types import FrameType

ENDING = tuple(getattr(signal, name) for name in ("SIGTERM", "SIGHUP", "SIGQUIT") if hasattr(signal, name))
"""Signals other than Ctrl-C by which the system or the terminal ends a program."""
_REPEAT_SECONDS = 2.0
"""A terminal or batch system may send several signals at once. Signals within this time after the first are ignored,
so that they do not interrupt the clean-up."""


class TerminatedError(KeyboardInterrupt):
    """SIGTERM, SIGHUP or SIGQUIT arrived, or the terminal was closed.

    Attributes:
        number: Number of the signal.
    """

    def __init__(self, number: int) -> None:
        super().__init__()
        self.number = number


@contextmanager
def signals_raised() -> Generator[None]:
    """Raise KeyboardInterrupt for Ctrl-C and TerminatedError for the other ending signals within the block.

    A signal that was ignored before, as SIGHUP is under ``nohup``, stays ignored. A terminal that is closed without a
    SIGHUP to this process has the same effect. Does nothing in threads other than the main one.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    raised = [-float("inf")]

    def stop(number: int, _frame: FrameType | None) -> None:
        if time.monotonic() - raised[0] < _REPEAT_SECONDS:
            return
        raised[0] = time.monotonic()
        raise KeyboardInterrupt if number == signal.SIGINT else TerminatedError(number)

    with ExitStack() as restoring:
        for number in (signal.SIGINT, *ENDING):
            before = signal.getsignal(number)
            if before in (signal.SIG_DFL, signal.default_int_handler):
                restoring.callback(signal.signal, number, before)
                signal.signal(number, stop)
        if hasattr(select, "poll") and signal.getsignal(signal.SIGHUP) is stop:
            restoring.enter_context(_terminals_watched())
        yield


@contextmanager
def interrupts_held() -> Generator[None]:
    """Delay Ctrl-C, and other ending signals that the program handles, until the end of the block.

    Does nothing in threads other than the main one, which signals do not interrupt. Cost: about 20 µs.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    with ExitStack() as held:  # all are restored even if one raises at its end
        for number in (*ENDING, signal.SIGINT):
            held.enter_context(_held(number))
        yield


def terminal_closed() -> bool:
    """Whether standard input, output or error is a terminal that was closed: its other end is gone."""
    return hasattr(select, "poll") and bool(_poll(_devices()).poll(0))


@contextmanager
def _held(number: signal.Signals) -> Generator[None]:
    handler = signal.getsignal(number)
    if not callable(handler):  # a handler of the system does not raise inside the block
        yield
        return
    came: list[FrameType | None] = []
    signal.signal(number, lambda _, frame: came.append(frame))
    try:
        yield
    finally:
        signal.signal(number, handler)
        if came:
            handler(number, came[0])


@contextmanager
def _terminals_watched() -> Generator[None]:
    """Send SIGHUP to this process when a terminal that it uses is closed; the system does so only for a session's own
    terminal.
    """
    devices = _devices()
    if not any(os.isatty(number) for number in devices):
        yield
        return
    woken, wake = os.pipe()

    def watch() -> None:
        polled = _poll(devices)
        polled.register(woken, select.POLLIN)
        if all(number != woken for number, _ in polled.poll()):
            os.kill(os.getpid(), signal.SIGHUP)

    thread = threading.Thread(target=watch, name="terminal", daemon=True)
    thread.start()
    try:
        yield
    finally:
        os.close(wake)
        thread.join()
        os.close(woken)


def _devices() -> list[int]:
    """Return those standard streams that are character devices; a terminal that was closed is one, but no terminal."""
    found = []
    for number in range(3):
        with suppress(OSError):
            if stat.S_ISCHR(os.fstat(number).st_mode):
                found.append(number)
    return found


def _poll(devices: list[int]) -> select.poll:
    """Poll for the end of devices only, which is always reported."""
    polled = select.poll()
    for number in devices:
        polled.register(number, 0)
    return polled
