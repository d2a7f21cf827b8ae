"""The watchdog that measures freezes of the window in tests."""

from __future__ import annotations

import time

from tests.support.watchdog import Watchdog


def busy(seconds: float) -> None:
    """Compute for so long."""
    end = time.perf_counter() + seconds
    while time.perf_counter() < end:
        pass


def test_an_absence_is_measured_and_its_place_named():
    with Watchdog(0.05, period=0.005) as dog:
        dog.beat()
        dog.begin("a long act")
        busy(0.6)  # on a busy machine the watching thread is late
        dog.beat()
    (stall,) = dog.stalls
    assert stall.seconds >= 0.6
    assert stall.cpu > 0
    assert stall.label == "a long act"
    assert stall.stack[-1].split()[-1] == "busy"


def test_a_loop_that_turns_is_not_told():
    with Watchdog(5.0, period=0.005) as dog:
        for _ in range(3):
            busy(0.01)
            dog.beat()
    assert dog.stalls == []
