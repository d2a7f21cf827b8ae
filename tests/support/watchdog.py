"""Measures how long an event loop is blocked, and records where."""

from __future__ import annotations

import sys
import threading
import time
import traceback
from dataclasses import dataclass


@dataclass(frozen=True)
class Stall:
    """Period during which the event loop was blocked.

    Attributes:
        seconds: Wall time.
        cpu: CPU seconds of the process during this time, on all threads; small if the machine was busy with other work.
        label: Current activity, as passed to ``begin``.
        stack: Stack of the watched thread when the limit was exceeded, outermost call first.
    """

    seconds: float
    cpu: float
    label: str
    stack: tuple[str, ...]

    def __str__(self) -> str:
        return f"{self.seconds:.2f} s ({self.cpu:.2f} s of CPU) in {self.label}\n  " + "\n  ".join(self.stack[-8:])


class Watchdog:
    """Thread that watches the thread that created it; used as a context manager.

    The watched thread calls ``beat`` at each turn of its event loop, for example from a ``QTimer``.

    Args:
        limit: Blocking longer than this is a stall [s].
        period: Interval of the checks [s], which limits the accuracy of the recorded place.

    Attributes:
        stalls: Stalls in the order in which they ended.
    """

    def __init__(self, limit: float = 1.0, *, period: float = 0.05) -> None:
        self.stalls: list[Stall] = []
        self._limit = limit
        self._period = period
        self._watched = threading.get_ident()
        self._label = ""
        self._ended = threading.Event()
        self._stack: tuple[str, ...] = ()
        self._last = time.perf_counter()
        self._cpu = time.process_time()
        self._thread = threading.Thread(target=self._watch, name="watchdog", daemon=True)

    def __enter__(self) -> Watchdog:
        self._last = time.perf_counter()
        self._cpu = time.process_time()
        self._thread.start()
        return self

    def __exit__(self, *_error: object) -> None:
        self.beat()
        self._ended.set()
        self._thread.join()

    def begin(self, label: str) -> None:
        """Name the current activity."""
        self._label = label

    def beat(self) -> None:
        """Report a turn of the event loop; called by the watched thread only."""
        now = time.perf_counter()
        cpu = time.process_time()
        away = now - self._last
        used = cpu - self._cpu
        self._last = now
        self._cpu = cpu
        stack = self._stack
        self._stack = ()
        if away > self._limit:
            self.stalls.append(Stall(away, used, self._label, stack))

    def _watch(self) -> None:
        while not self._ended.wait(self._period):
            last = self._last
            if time.perf_counter() - last > self._limit and not self._stack:
                stack = _stack_of(self._watched)
                if self._last == last:  # otherwise the loop has turned meanwhile
                    self._stack = stack


def _stack_of(thread: int) -> tuple[str, ...]:
    """Return file, line and function of each call of a thread, outermost first."""
    frame = sys._current_frames().get(thread)
    calls = traceback.extract_stack(frame) if frame is not None else []
    return tuple(f"{call.filename}:{call.lineno} {call.name}" for call in calls)
