"""States by joint name, from one model to another."""

from __future__ import annotations

import numpy as np
import pytest

from app.scene.effects import Effects
from app.simulation.carry_state import joint_states, restore
from app.simulation.physics import Physics
from app.touch.layer import Layer
from tests.things import thing
from tests.touch import arm, bar, bar_skin

BALL, PROBE = thing("sphere", at=(5.0, 0.0, 5.0), mass=1.0), thing("probe", at=(5.0, 1.0, 5.0))


def physics(*objects, effects: Effects | None = None, robot=None, skin=None) -> Physics:
    made = Physics(robot or bar(), skin or bar_skin(), effects or Effects(contact="environment"), objects, Layer())
    made.start((robot or bar()).home)
    return made


def test_every_joint_is_carried_by_its_name_wherever_it_stands():
    one, other = physics(BALL, PROBE), physics(PROBE, BALL)
    rng = np.random.default_rng(0)
    one.data.qpos[:] = rng.normal(size=one.model.nq) * 0.1
    one.data.qpos[one.model.joint("object sphere").qposadr[0] + 3 :][:4] = (1, 0, 0, 0)
    one.data.qvel[:], one.data.qacc_warmstart[:] = rng.normal(size=(2, one.model.nv))
    states = joint_states(one.model, one.data)
    assert list(states) == ["hinge", "object sphere", "object probe x", "object probe y", "object probe z"]
    restore(other, states, 1.25)
    back = joint_states(other.model, other.data)
    for name, state in states.items():
        for field in ("position", "velocity", "acceleration"):
            assert np.array_equal(getattr(back[name], field), getattr(state, field)), (name, field)
    assert other.data.time == 1.25
    assert other.data.xpos[other.model.body("object sphere").id] == pytest.approx(states["object sphere"].position[:3])


def test_joints_without_a_state_stay_where_they_are():
    here, there = physics(effects=Effects()), physics(BALL)
    here.data.qpos[:] = 0.3
    restore(there, joint_states(here.model, here.data), 0.0)
    assert there.data.qpos[0] == 0.3
    assert there.data.qpos[1:4] == pytest.approx((5.0, 0.0, 5.0))


def test_at_rest_keeps_the_place_and_nothing_else():
    made = physics(effects=Effects(), robot=arm().robot, skin=arm().skin)
    made.data.qvel[:] = 1.0
    state = joint_states(made.model, made.data)[arm().robot.joints[2].name]
    assert state.at_rest.position == state.position == arm().robot.home[2]
    assert not state.at_rest.velocity.any()
    assert not state.at_rest.acceleration.any()
    assert not state.position.flags.writeable
