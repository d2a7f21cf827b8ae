"""One control tick with every stage on, as a multiple of bare ``mj_step`` calls on the same model in the same run."""

from __future__ import annotations

import time

import mujoco
import numpy as np
import pytest

from app.scene.scene_file import load_scene
from app.session.prepare import prepare
from app.session.session import Session
from app.simulation.assemble import assemble
from app.touch.poke import PokePressed


def _bare_step_ms(prepared) -> float:
    """Median milliseconds of one ``mj_step`` of the scene's own model, without fingers, skin or control."""
    model = assemble(prepared.robot, prepared.skin, prepared.scene.effects)
    data = mujoco.MjData(model)
    times = []
    for _ in range(2000):
        start = time.perf_counter()
        mujoco.mj_step(model, data)
        times.append(time.perf_counter() - start)
    return 1e3 * float(np.median(times))


@pytest.mark.parametrize("name", ["arm"])
def test_one_control_tick_in_contact(benchmark, name):
    prepared = prepare(load_scene(name))
    assert len(prepared.skin) >= 900
    session = Session(prepared)
    session.submit(PokePressed(1, prepared.skin.taxel_point(len(prepared.skin) // 2)))
    for _ in range(100):
        session.tick()
    assert session.frame.regions, "the tick must be measured in contact"
    benchmark.pedantic(session.tick, rounds=500, warmup_rounds=50)
    if benchmark.stats is not None:
        bare = _bare_step_ms(prepared)
        steps = round(prepared.scene.tick / prepared.scene.effects.timestep)
        median = 1e3 * float(np.median(benchmark.stats.stats.data))
        benchmark.extra_info["bare mj_step"] = f"{bare:.4f} ms"
        benchmark.extra_info["multiple of its bare steps"] = f"{median / (steps * bare):.1f} ({steps} steps a tick)"
        benchmark.extra_info["multiple of one bare step"] = f"{median / bare:.1f}"
