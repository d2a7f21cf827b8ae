"""A clock that a test advances: what is late depends on the test alone, not on how busy the machine is."""

from __future__ import annotations

import threading
import time

COMMAND_THREADS = ("commands", "readings")
"""Names of the threads that run the command loop: of the command line and of the window."""
LONGEST = 1.0
"""Longest time [s] that ``advance`` waits for the program."""


class SimulatedClock:
    """Clock of a program that receives readings and commands a robot.

    Attributes:
        now: Time [s].
    """

    def __init__(self) -> None:
        self.now = 1000.0
        self._reads = 0

    def __call__(self) -> float:
        """Return the time; called by the program. Each call takes a microsecond."""
        self.now += 1e-6
        self._reads += threading.current_thread().name in COMMAND_THREADS
        return self.now

    def advance(self, seconds: float) -> None:
        """Let time pass, then wait until the command loop has begun and ended a pass, so that it is never late."""
        self.now += seconds
        before = self._reads
        deadline = time.monotonic() + LONGEST
        while self._reads < before + 3 and time.monotonic() < deadline:  # one pass reads it three times at most
            threading.Event().wait(0.001)
