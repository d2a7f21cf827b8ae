"""Sessions without views: speed relative to real time, and the gain of two processes on two cores."""

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
"""Simulated time [s]."""


def advance(controller: str, taxels: int, seconds: float) -> float:
    """Return the wall time [s] of ``SECONDS`` of simulation of a touched arm, without preparation."""
    session = touched(covered(taxels), controller, 1)
    ticks = round(seconds / session.prepared.scene.tick)
    began = time.perf_counter()
    for _ in range(ticks):
        session.tick()
    return time.perf_counter() - began


@pytest.mark.parametrize("controller", ["impedance", "hybrid"])
def test_session_without_views(benchmark, controller):
    """Measure a session with 1,000 taxels, 200 ticks a second and one contact."""
    seconds = SECONDS if benchmark.enabled else 0.1
    wall = benchmark.pedantic(advance, args=(controller, 1_000, seconds), rounds=3 if benchmark.enabled else 1)
    benchmark.extra_info["times_real_time"] = round(seconds / wall, 1)


def bare_steps(count: int) -> float:
    """Return the wall time [s] of steps of the arm without a session, for comparison."""
    made = covered(1_000)
    model = assemble(made.robot, made.skin, made.scene.effects)
    data = mujoco.MjData(model)
    began = time.perf_counter()
    mujoco.mj_step(model, data, count)
    return time.perf_counter() - began


@pytest.mark.long  # 5 s for starting two processes
def test_sessions_in_two_processes(benchmark):
    """Compare two sessions in parallel with two in sequence, and the same for bare steps as the machine's limit."""
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
