"""Sessions without views: how many times real time one advances, and what two processes gain on two cores."""

from __future__ import annotations

import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import mujoco
import numpy as np
import pytest

from tactile_maps.simulation.model.model_assembly import assemble
from tests.benchmarks.test_tick import covered, touched

SECONDS = 5.0
"""Of simulated time."""


def advance(controller: str, taxels: int, seconds: float) -> float:
    """Wall seconds for so many simulated ones of a touched arm, ready beforehand."""
    session = touched(covered(taxels), controller, 1)
    ticks = round(seconds / session.prepared.scene.tick)
    began = time.perf_counter()
    for _ in range(ticks):
        session.tick()
    return time.perf_counter() - began


@pytest.mark.parametrize("controller", ["impedance", "hybrid"])
def test_a_session_without_views(benchmark, controller):
    """1,000 taxels, 200 ticks a second, one contact."""
    seconds = SECONDS if benchmark.enabled else 0.1
    wall = benchmark.pedantic(advance, args=(controller, 1_000, seconds), rounds=3 if benchmark.enabled else 1)
    benchmark.extra_info["times_real_time"] = round(seconds / wall, 1)


def bare_steps(count: int) -> float:
    """Wall seconds for so many steps of the arm without a session: what a core can do besides."""
    made = covered(1_000)
    model = assemble(made.robot, made.skin, made.scene.effects)
    data = mujoco.MjData(model)
    began = time.perf_counter()
    mujoco.mj_step(model, data, count)
    return time.perf_counter() - began


@pytest.mark.long  # 5 s to start two processes
def test_two_processes(benchmark):
    """Two at once against one after the other, of sessions and, for what the machine gives at all, of bare steps."""
    works = {"sessions": (advance, "hybrid", 1_000, SECONDS if benchmark.enabled else 0.1)}
    works["bare steps"] = (bare_steps, 500_000 if benchmark.enabled else 100)
    gains: dict[str, list[float]] = {name: [] for name in works}
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:

        def compare() -> None:
            for name, work in works.items():
                alone = sum(pool.submit(*work).result() for _ in range(2))
                both = [pool.submit(*work) for _ in range(2)]
                gains[name].append(alone / max(future.result() for future in both))

        benchmark.pedantic(compare, rounds=5 if benchmark.enabled else 1, warmup_rounds=1)
    for name, found in gains.items():
        benchmark.extra_info[f"gain of two processes, {name}"] = f"{np.median(found):.2f}"
