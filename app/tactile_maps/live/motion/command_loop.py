"""Processes readings into frames and motion on a separate thread.

Threads, each with its own work, so that none delays another:

- *receiving*: the connection's thread; it opens the source and keeps packets while the others are busy.
- *commands*: this loop. While motion is sent, a pass processes everything that has arrived: it applies the readings in
  order, makes one frame of them, checks force and inputs, runs the controller and sends. Otherwise a pass processes one
  reading, or in the window all that wait if they are more than ``LATE_READINGS``, and only the newest if they are more
  than ``MOST_COMBINED``.
- *watchdog*: sends the stop if a pass takes too long, for example in a controller that computes for a second. It cannot
  interrupt a computation that never releases the interpreter lock; the driver's ``valid_s`` covers that.
- *recording*: ``frame_recording``, or the window's own thread.

The command line and the window use the same loop.
"""

from __future__ import annotations

import gc
import sys
import threading
import time
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from itertools import islice
from typing import Any, Protocol

import scipy.optimize  # noqa: F401 - modules that need it rarely import it late, which would delay a pass by 0.07 s

from tactile_maps.live.motion.motion_sender import StopReason
from tactile_maps.live.session.connection import Connection
from tactile_maps.live.session.measured_session import MeasuredSession
from tactile_maps.session.frame import Frame

POLL_SECONDS = 0.01
"""Time between passes without a reading [s], which detect that readings have ceased."""
_WATCH_SECONDS = 0.01
LATE_READINGS = 5
"""Number of waiting readings from which a loop that shares its time combines them into one frame."""
MOST_COMBINED = 500
"""Largest number of readings combined into one frame; of more, only the newest values are used, and the others are
counted as superseded. Without this limit, a sender faster than the readings can be used would delay them more and more.
"""
_LONGEST_REST = 0.05
_SHORT_PASS = 0.002
"""Passes that take less time [s] are not followed by a rest."""
SWITCH_SECONDS = 0.2e-3
"""Longest wait of a thread for the interpreter lock [s] while another one computes. Receiving a packet releases the
lock: with the default of 5 ms, fifty packets would take 0.25 s while a recording is being compressed.
"""


class Motion(Protocol):
    """Motion that follows from frames; implemented by ``MotionOutput``."""

    @property
    def active(self) -> bool:
        """True while motion is sent, or while readings are awaited to send it."""

    def take(self) -> None:
        """Compute the motion that follows from the session's newest frame."""

    def check(self) -> None:
        """Stop if readings have ceased."""

    def check_deadline(self) -> None:
        """Stop if ``take`` does not return; called from another thread."""

    def halt(self, reason: StopReason = StopReason.BY_HAND) -> None:
        """Stop; thread-safe."""


class _NoMotion:
    active = False

    def take(self) -> None: ...
    def check(self) -> None: ...
    def check_deadline(self) -> None: ...
    def halt(self, reason: StopReason = StopReason.BY_HAND) -> None: ...


class CommandLoop:
    """Loop over readings. Mutable.

    Args:
        connection: Source of the readings.
        session: Session that uses them.
        motion: Motion that follows from its frames; None if there is none.
        each: Called with every new frame on the loop's thread; it must not block.
        lock: Held during a pass.
        paused: Returns True while readings are to wait. Motion stops then: it would start again with the next reading.
        shares: Whether the loop leaves half of the time to other threads, which share the interpreter lock. Then it is
            slower on a large skin, and combines readings that wait. Neither applies while motion is sent, nor to files.

    Attributes:
        taken: Number of readings taken, including those that do not fit.
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
        shares: bool = False,
    ) -> None:
        self._connection = connection
        self._session = session
        self._motion: Motion = motion or _NoMotion()
        self._each = each
        self._paused = paused
        self._shares = shares and not connection.source.finite
        self._lock = lock or nullcontext()
        self._ended = threading.Event()
        self._thread: threading.Thread | None = None
        self.taken = 0
        self.finished = threading.Event()
        self._error: Exception | None = None

    def step(self) -> bool:
        """Make one pass; return False if no reading was waiting. The caller holds the lock."""
        session = self._session
        motion = self._motion
        session.apply_inputs()
        active = motion.active
        newest_only = active and not self._connection.source.finite
        self._connection.keep_newest(on=newest_only)
        waiting = self._connection.waiting if self._shares else 0
        if newest_only or waiting > MOST_COMBINED:
            items = self._connection.take_newest(session.missing())
        else:
            items = list(islice(iter(self._connection.take, None), waiting if waiting > LATE_READINGS else 1))
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
        """Process the waiting readings, those of a live source for at most ``seconds``; the others are counted.

        The caller holds the lock, and no thread is running.
        """
        end = clock() + seconds
        while self.step():
            if not self._connection.source.finite and clock() >= end:
                self._connection.drop_waiting()

    def run(self, ended: threading.Event) -> None:
        """Make passes until ``ended`` is set. An error stops motion first and is then raised."""
        gc.freeze()  # otherwise each full collection traverses the whole skin, which blocks all threads for 0.2 s
        switching = sys.getswitchinterval()
        sys.setswitchinterval(min(SWITCH_SECONDS, switching))
        watching = threading.Event()
        watchdog = threading.Thread(target=self._watch, args=(watching,), name="watchdog", daemon=True)
        watchdog.start()
        try:
            while not ended.is_set():
                self._connection.wait(POLL_SECONDS)
                if self._paused():  # readings wait, and those beyond the limit are counted
                    self._motion.halt(StopReason.PAUSED)
                    ended.wait(POLL_SECONDS)
                    continue
                start = time.perf_counter()
                with self._lock:  # for one pass only, so that the window waits no longer
                    more = self.step()
                passed = time.perf_counter() - start
                if self._shares and passed > _SHORT_PASS and not self._motion.active:
                    ended.wait(min(passed, _LONGEST_REST))
                if not more and self._connection.ended:
                    self.finished.set()
        finally:
            self._motion.halt()
            watching.set()
            watchdog.join()
            sys.setswitchinterval(switching)
            gc.unfreeze()

    def start(self) -> None:
        """Run on a separate thread until ``close``."""
        self._thread = threading.Thread(target=self._loop, name="commands", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """Stop motion, then the thread of ``start``, and wait for it. Raises the error that ended the thread."""
        self._motion.halt()
        self._ended.set()
        if self._thread is not None:
            self._thread.join()
            self._thread = None
        self.raise_error()

    def raise_error(self) -> None:
        """Raise the error that ended the thread of ``start``, if there is one."""
        if self._error is not None:
            raise self._error

    def _loop(self) -> None:
        try:
            self.run(self._ended)
        except Exception as error:  # raised again by ``close``
            self._error = error

    def _watch(self, ended: threading.Event) -> None:
        while not ended.wait(_WATCH_SECONDS):
            self._motion.check_deadline()
