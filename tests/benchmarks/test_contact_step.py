"""Simulation step with a body at rest on skin, with 1 or 4 contact points, and ``mj_step`` of the same model."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from tactile_maps.control.motion.command import JointCommand
from tactile_maps.scene.effects import Effects
from tactile_maps.simulation.model.contact_stiffness import ContactSharing
from tactile_maps.simulation.model.model_assembly import assemble
from tactile_maps.simulation.model.passive_friction import PassiveFriction
from tactile_maps.simulation.simulation import Simulation
from tactile_maps.studies.testbeds.contact_bench import STIFFNESS, bench, lay
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer

POINTS = {"sphere": 1, "box on face": 4}
STEPS = 100
_NONE = np.zeros(0)
STILL = JointCommand(_NONE, _NONE, _NONE, _NONE)
LAYER = ElasticLayer(stiffness=STIFFNESS)
EFFECTS = Effects(contact="environment", gravity="on", fingers=False, friction=True)


@pytest.fixture(params=POINTS)
def shape(request):
    return request.param


def test_bare_step(benchmark, shape):
    model, data = resting(shape)
    benchmark.extra_info["per"] = f"{STEPS} steps, {POINTS[shape]} points"
    benchmark(lambda: mujoco.mj_step(model, data, STEPS))


def test_step_that_shares_the_stiffness_and_checks_friction(benchmark, shape):
    model, data = resting(shape)
    sharing = ContactSharing(model, LAYER)
    friction = PassiveFriction(model)

    def steps():
        for _ in range(STEPS):
            mujoco.mj_step1(model, data)
            sharing.apply(data)
            friction.finish_step(data)

    steps()
    assert data.ncon == POINTS[shape]
    benchmark.extra_info["per"] = f"{STEPS} steps, {POINTS[shape]} points"
    benchmark(steps)


def test_step_of_the_simulation(benchmark, shape):
    simulation = Simulation(bench("flat").robot, bench("flat").points, EFFECTS, objects=(body(shape),), layer=LAYER)
    simulation.step(300, STILL)
    benchmark.extra_info["per"] = f"{STEPS} steps, {POINTS[shape]} points"
    benchmark(lambda: simulation.step(STEPS, STILL))


def body(shape):
    return lay(shape, (0.0033, -0.0027, 0.0))


def resting(shape) -> tuple[mujoco.MjModel, mujoco.MjData]:
    made = bench("flat")
    model = assemble(made.robot, made.points, EFFECTS, objects=(body(shape),), layer=LAYER)
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 300)
    return model, data
