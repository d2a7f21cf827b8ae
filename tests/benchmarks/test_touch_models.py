"""Reading of each contact model, and the share of each sensor effect, as multiples of ``mj_step`` of the same arm."""

from __future__ import annotations

import time

import mujoco
import numpy as np
import pytest

from tactile_maps.control.motion.command import JointCommand
from tactile_maps.robots.library import load_robot
from tactile_maps.robots.model.mujoco_spec import robot_spec
from tactile_maps.scene.effects import Effects
from tactile_maps.simulation.simulation import Simulation
from tactile_maps.skin.fitting.cover import CoverSpec, cover_robot
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.mechanics.loads import Load, sphere_load
from tactile_maps.tactile.models.contact_model import CONTACT_MODELS
from tactile_maps.tactile.poke import PokePressed
from tactile_maps.tactile.sensors.sensor_chain import SensorChain
from tactile_maps.tactile.sensors.sensor_effects import SensorEffects
from tests.support.sensors import ALL_ON, only
from tests.support.touch import bar_skin

FORCE = 10.0
RADIUS = 0.008
SPEED = 0.05
STEP = 0.001


@pytest.fixture(scope="module")
def robot():
    return load_robot("arm")


@pytest.fixture(scope="module", params=[100, 1000, 10_000])
def skin(request, robot):
    return cover_robot(robot, CoverSpec(taxels=request.param))


def _loads(skin, count: int) -> list[Load]:
    """Return the loads of a ball that slides over the skin, one for each step."""
    at = skin.taxel_point(len(skin) // 2)
    point = skin.position(at)
    normal = skin.normal(at)
    along = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
    return [sphere_load(skin.link(at), point + k * SPEED * STEP * along, normal, FORCE, RADIUS) for k in range(count)]


def _bare_step(robot) -> float:
    """Return the median time of ``mj_step`` of the bare arm [s]."""
    model = robot_spec(robot).compile()
    data = mujoco.MjData(model)
    times = []
    for _ in range(2000):
        start = time.perf_counter()
        mujoco.mj_step(model, data)
        times.append(time.perf_counter() - start)
    return float(np.median(times))


def _report(benchmark, robot) -> None:
    if benchmark.stats is not None:
        bare = _bare_step(robot)
        median = float(np.median(benchmark.stats.stats.data))
        benchmark.extra_info["bare mj_step"] = f"{1e6 * bare:.1f} µs"
        benchmark.extra_info["multiple of one bare step"] = f"{median / bare:.1f}"


@pytest.mark.parametrize("name", CONTACT_MODELS)
def test_reading_under_a_ball_at_rest(benchmark, robot, skin, name):
    model, (load,) = CONTACT_MODELS[name].build(skin, ElasticLayer(), SensorEffects()), _loads(skin, 1)
    pressures = benchmark.pedantic(model.pressures, args=([load],), rounds=200, iterations=10, warmup_rounds=20)
    assert pressures @ skin.areas == pytest.approx(FORCE, rel=1e-6), "the reading must be measured in contact"
    _report(benchmark, robot)


@pytest.mark.parametrize("name", CONTACT_MODELS)
def test_reading_under_a_sliding_ball(benchmark, robot, skin, name):
    """Measure readings at 5 cm/s, at which the points near the ball are sometimes searched again."""
    model = CONTACT_MODELS[name].build(skin, ElasticLayer(), SensorEffects())
    loads = _loads(skin, 200)
    state = {"step": 0}

    def read() -> None:
        state["step"] += 1
        state["pressures"] = model.pressures([loads[state["step"] % len(loads)]])

    benchmark.pedantic(read, rounds=len(loads), warmup_rounds=5)
    assert state["pressures"].max() > 0
    _report(benchmark, robot)


def test_complete_step_with_a_reading(benchmark, robot, skin):
    """Measure a step with a reading; the target is 5 bare steps with 1,000 taxels, 12 with 10,000."""
    simulation = Simulation(robot, skin, Effects())
    simulation.apply(PokePressed(1, skin.taxel_point(len(skin) // 2)))
    ones = np.ones(len(robot.joints))
    command = JointCommand(robot.home, 100 * ones, 10 * ones, 0 * ones)

    def step() -> None:
        simulation.step(1, command)
        simulation.sense()

    for _ in range(300):
        step()
    assert simulation.pokes[0].force > 1, "the step must be measured in contact"
    benchmark.pedantic(step, rounds=500, warmup_rounds=20)
    _report(benchmark, robot)


def _pressed(taxels):
    """Return a contact on 5 % of the taxels, some beyond the highest reading."""
    rng = np.random.default_rng(0)
    return rng.uniform(0, 250e3, taxels) * (rng.random(taxels) < 0.05)


@pytest.mark.parametrize(
    "effects", [*only(ALL_ON).values(), ALL_ON, SensorEffects()], ids=[*only(ALL_ON), "all", "none"]
)
def test_reading_of_1000_taxels(benchmark, effects):
    skin = bar_skin(1000, finer=4)
    assert len(skin) == 1000
    assert 5 < 2 * len(skin.neighbours) / len(skin) < 6, "neighbours as on a body"
    chain = SensorChain(skin, effects, tick=0.005, seed=0)
    pressures = _pressed(1000)
    read = benchmark.pedantic(chain.read, args=(pressures,), rounds=200, iterations=20, warmup_rounds=20)
    assert read.shape == (1000,)
    if benchmark.stats is not None:
        benchmark.extra_info["median"] = f"{1e6 * benchmark.stats.stats.median:.1f} µs"
