"""The watchdog that measures freezes of the window in tests."""

from __future__ import annotations

import time
from collections.abc import Callable

from tests.support.watchdog import Watchdog


def busy(seconds: float, *, until: Callable[[], object] = lambda: True) -> None:
    """Compute for so long, and ``until`` something else has happened."""
    end = time.perf_counter() + seconds
    while time.perf_counter() < end or not until():
        pass


def test_blocked_event_loop_is_measured_and_located():
    latest = time.perf_counter() + 60
    with Watchdog(0.05, period=0.005) as dog:
        dog.beat()
        dog.begin("a long act")
        busy(0.1, until=lambda: dog._stack or time.perf_counter() > latest)  # the watching thread may be late
        dog.beat()
    (stall,) = dog.stalls
    assert stall.seconds >= 0.1
    assert stall.cpu > 0
    assert stall.label == "a long act"
    assert stall.stack[-1].split()[-1] == "busy"


def test_running_loop_is_not_reported():
    with Watchdog(5.0, period=0.005) as dog:
        for _ in range(3):
            busy(0.01)
            dog.beat()
    assert dog.stalls == []
