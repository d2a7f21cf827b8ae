"""Measures how long an event loop has been away, and names where the thread is while it is."""

from __future__ import annotations

import sys
import threading
import time
import traceback
from dataclasses import dataclass


@dataclass(frozen=True)
class Stall:
    """One absence of the event loop.

    Attributes:
        seconds: How long it was away, by the wall clock.
        cpu: CPU seconds that the process took meanwhile, on all its threads: little where the machine was busy.
        label: What was being done, as ``begin`` was told.
        stack: Of the watched thread, outermost call first, as it was when the limit was passed.
    """

    seconds: float
    cpu: float
    label: str
    stack: tuple[str, ...]

    def __str__(self) -> str:
        return f"{self.seconds:.2f} s ({self.cpu:.2f} s of CPU) in {self.label}\n  " + "\n  ".join(self.stack[-8:])


class Watchdog:
    """A thread that looks at the thread that made it; used as a context.

    Whoever is watched calls ``beat`` whenever its event loop turns: a ``QTimer`` of some milliseconds does.

    Args:
        limit: An absence longer than this is a stall [s].
        period: How often the thread looks [s]; so precise is the place.

    Attributes:
        stalls: In the order in which they ended.
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
        """Say what is done from now on."""
        self._label = label

    def beat(self) -> None:
        """The event loop turns. Called by the watched thread alone."""
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
                if self._last == last:  # else it came back meanwhile, and this is of something else
                    self._stack = stack


def _stack_of(thread: int) -> tuple[str, ...]:
    """Where a thread is: file, line and function of each call, outermost first."""
    frame = sys._current_frames().get(thread)
    calls = traceback.extract_stack(frame) if frame is not None else []
    return tuple(f"{call.filename}:{call.lineno} {call.name}" for call in calls)
