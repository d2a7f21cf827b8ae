"""Sessions without views: how many times real time one advances, and what two processes gain on two cores."""

from __future__ import annotations

import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import pytest

from tests.benchmarks.test_tick import covered, touched

SECONDS = 5.0
"""Of simulated time."""


def advance(controller: str, taxels: int, seconds: float) -> float:
    """Wall seconds for so many simulated ones of a touched arm, ready beforehand."""
    session = touched(covered(taxels), controller, 1)
    ticks, began = round(seconds / session.prepared.scene.tick), time.perf_counter()
    for _ in range(ticks):
        session.tick()
    return time.perf_counter() - began


@pytest.mark.parametrize("controller", ["impedance", "hybrid"])
def test_a_session_without_views(benchmark, controller):
    """1,000 taxels, 200 ticks a second, one contact."""
    seconds = SECONDS if benchmark.enabled else 0.1
    wall = benchmark.pedantic(advance, args=(controller, 1_000, seconds), rounds=3 if benchmark.enabled else 1)
    benchmark.extra_info["times_real_time"] = round(seconds / wall, 1)


@pytest.mark.long  # 5 s to start two processes
def test_two_processes(benchmark):
    """Two sessions, one after the other in one process and at once in two."""
    seconds = 2 * SECONDS if benchmark.enabled else 0.1
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:

        def together() -> float:
            began = [pool.submit(advance, "hybrid", 1_000, seconds) for _ in range(2)]
            return max(future.result() for future in began)

        both = benchmark.pedantic(together, rounds=3 if benchmark.enabled else 1, warmup_rounds=1)
    alone = sum(advance("hybrid", 1_000, seconds) for _ in range(2))
    benchmark.extra_info["gain_of_two_processes"] = round(alone / both, 2)
