"""What is off costs nothing: a tick with every effect off against as many bare ``mj_step`` calls on the same model."""

from __future__ import annotations

import time

import mujoco
import numpy as np

from app.scene.effects import Effects
from app.simulation.simulation import Simulation
from tests.touch import arm, hold

OFF = Effects(gravity="off", contact="off", joint_limits=False, fingers=False, skin="off")
STEPS = 5


def test_a_tick_with_everything_off(benchmark):
    prepared = arm()
    simulation, command = Simulation(prepared.robot, prepared.skin, OFF), hold(prepared.robot, 3.0, 0.5)
    simulation.step(STEPS, command)
    benchmark.pedantic(simulation.step, args=(STEPS, command), rounds=2000, warmup_rounds=100)
    assert np.isfinite(simulation.posture).all()
    if benchmark.stats is not None:
        ours, bare = _side_by_side(simulation, command)
        benchmark.extra_info["tick of 5 steps"] = f"{1e6 * ours:.2f} µs"
        benchmark.extra_info["5 bare mj_step"] = f"{1e6 * bare:.2f} µs"
        benchmark.extra_info["ratio"] = f"{ours / bare:.3f}"


def _side_by_side(simulation: Simulation, command) -> tuple[float, float]:
    """Median seconds of a tick and of as many bare steps, taken in turn, so that a busy machine slows both."""
    model, data, took = simulation._model, mujoco.MjData(simulation._model), ([], [])
    data.qpos[:], data.ctrl[:] = simulation.posture, command.posture
    for _ in range(4000):
        start = time.perf_counter()
        simulation.step(STEPS, command)
        between = time.perf_counter()
        for _ in range(STEPS):
            mujoco.mj_step(model, data)
        end = time.perf_counter()
        took[0].append(between - start)
        took[1].append(end - between)
    return float(np.median(took[0])), float(np.median(took[1]))
