"""Takes readings, makes frames of them and lets motion follow, on a thread of its own.

Threads, each with its own work, so that none delays another:

- *receiving*: the connection's thread; it opens the source, and keeps packets while the others are busy;
- *commands*: this loop. While motion is sent, a pass takes everything that has arrived, applies the readings in order,
  makes one frame of them, checks force and inputs, runs the controller and sends. Otherwise a pass takes one reading;
- *watchdog*: sends the stop where a pass takes too long, such as a controller that computes for a second. A computation
  that never lets another Python thread run is beyond it; the driver's ``valid_s`` covers that;
- *recording*: ``frame_recording``, or the window's own.

The program uses the loop on the command line and in the window alike.
"""

from __future__ import annotations

import gc
import sys
import threading
import time
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from typing import Any, Protocol

from tactile_maps.live.session.connection import Connection
from tactile_maps.live.session.measured_session import MeasuredSession
from tactile_maps.session.frame import Frame

POLL_SECONDS = 0.01
"""A pass without a reading is made so often [s]: it notices that readings have ceased."""
_WATCH_SECONDS = 0.01
SWITCH_SECONDS = 0.2e-3
"""Longest wait of a thread for Python's lock [s] while another one computes. Receiving a packet gives the lock away:
with the usual 5 ms, fifty packets would take 0.25 s while a recording is being packed."""


class Motion(Protocol):
    """What follows from frames; ``MotionOutput`` says more."""

    @property
    def active(self) -> bool:
        """True while motion is sent, or readings are waited for to send it."""

    def take(self) -> None:
        """Work out what follows from the session's newest frame."""

    def check(self) -> None:
        """Stop where readings have ceased."""

    def check_deadline(self) -> None:
        """Stop where ``take`` does not return; from another thread."""

    def halt(self) -> None:
        """Stop; from any thread."""


class _NoMotion:
    active = False

    def take(self) -> None: ...
    def check(self) -> None: ...
    def check_deadline(self) -> None: ...
    def halt(self) -> None: ...


class CommandLoop:
    """The passes over readings. Mutable.

    Args:
        connection: Where readings come from.
        session: That they are taken into.
        motion: What follows from its frames; None for nothing.
        each: Called with every new frame, on the loop's thread: it must not wait.
        lock: Held during a pass.
        paused: True while readings are to wait.

    Attributes:
        taken: Number of readings taken, those that do not fit included.
        finished: Set once the source has ended and all its readings were taken.
    """

    def __init__(
        self,
        connection: Connection,
        session: MeasuredSession,
        motion: Motion | None,
        each: Callable[[Frame], None],
        *,
        lock: AbstractContextManager[Any] | None = None,
        paused: Callable[[], bool] = lambda: False,
    ) -> None:
        self._connection = connection
        self._session = session
        self._motion: Motion = motion or _NoMotion()
        self._each = each
        self._paused = paused
        self._lock = lock or nullcontext()
        self._ended = threading.Event()
        self._thread: threading.Thread | None = None
        self.taken = 0
        self.finished = threading.Event()
        self._error: Exception | None = None

    def step(self) -> bool:
        """Make one pass; False where no reading waited. The caller holds the lock."""
        session = self._session
        motion = self._motion
        session.apply_inputs()
        active = motion.active
        every = not active or self._connection.source.finite
        self._connection.keep_newest(on=not every)
        if every:
            one = self._connection.take()
            items = [] if one is None else [one]
        else:
            items = self._connection.take_newest(session.missing())
        self.taken += len(items)
        fitting = [session.apply(item, compare=not active) for item in items]
        if any(fitting):
            frame = session.make_frame()
            motion.take()
            self._each(frame)
        else:
            motion.check()
        return bool(items)

    def finish(self, seconds: float, *, clock: Callable[[], float] = time.monotonic) -> None:
        """Take the readings that wait, those of a live source for ``seconds`` at most; the others are counted.

        The caller holds the lock, and nothing runs any more.
        """
        end = clock() + seconds
        while self.step():
            if not self._connection.source.finite and clock() >= end:
                self._connection.drop_waiting()

    def run(self, ended: threading.Event) -> None:
        """Make passes until ``ended`` is set. What goes wrong stops motion first, and is raised."""
        gc.freeze()  # else each full collection looks at the whole skin, for 0.2 s in which no thread runs
        switching = sys.getswitchinterval()
        sys.setswitchinterval(min(SWITCH_SECONDS, switching))
        watching = threading.Event()
        watchdog = threading.Thread(target=self._watch, args=(watching,), name="watchdog", daemon=True)
        watchdog.start()
        try:
            while not ended.is_set():
                self._connection.wait(POLL_SECONDS)
                if self._paused():  # readings wait, and those too many are counted
                    ended.wait(POLL_SECONDS)
                    with self._lock:
                        self._motion.check()
                    continue
                with self._lock:  # for one pass: the window never waits for longer
                    more = self.step()
                if not more and self._connection.ended:
                    self.finished.set()
        finally:
            self._motion.halt()
            watching.set()
            watchdog.join()
            sys.setswitchinterval(switching)
            gc.unfreeze()

    def start(self) -> None:
        """Run on a thread of its own until ``close``."""
        self._thread = threading.Thread(target=self._loop, name="commands", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop motion, then the thread of ``start``, and wait for it. Raises what the thread ended by."""
        self._motion.halt()
        self._ended.set()
        if self._thread is not None:
            self._thread.join()
            self._thread = None
        self.raise_error()

    def raise_error(self) -> None:
        """Raise what the thread of ``start`` ended by, if it ended by itself."""
        if self._error is not None:
            raise self._error

    def _loop(self) -> None:
        try:
            self.run(self._ended)
        except Exception as error:  # raised again by whoever started the thread
            self._error = error

    def _watch(self, ended: threading.Event) -> None:
        while not ended.wait(_WATCH_SECONDS):
            self._motion.check_deadline()
