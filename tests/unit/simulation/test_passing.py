"""What could pass through something within a tick is stopped, and nothing else is."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from app.errors import SimulationError
from app.scene.effects import Effects
from app.simulation.assemble import assemble
from app.simulation.passing import Passing
from tests.things import thing
from tests.touch import bar, bar_skin

EFFECTS = Effects(contact="environment", timestep=0.001)


def falling(*, height: float, speed: float, kind: str = "sphere", **said):
    """A body above the bar's middle that falls with ``speed``; the watch and the state."""
    body = thing(kind, at=(0.2, 0.0, height), mass=1.0, **said)
    model = assemble(bar(), bar_skin(), EFFECTS, objects=(body,))
    data = mujoco.MjData(model)
    data.qvel[-4 if model.nv > 6 else -1] = -speed
    mujoco.mj_kinematics(model, data)
    return Passing(model, (body,)), data


def test_nothing_is_watched_where_nothing_moves():
    body = thing("box", at=(0.2, 0.0, 0.5))
    assert not Passing(assemble(bar(), bar_skin(), EFFECTS, objects=(body,)), (body,)).needed


@pytest.mark.parametrize(("height", "speed"), [(0.1, 30.0), (5.0, 100.0), (-0.5, 1.0)])
def test_slow_or_far_bodies_go_on(height, speed):
    """The ball reaches 20 mm and the bar is 40 mm thick: 30 mm a step cannot carry it past the middle."""
    watch, data = falling(height=height, speed=speed)
    assert watch.needed
    watch.check(data, 5)


def test_a_fast_body_near_the_bar_is_stopped_with_the_step_that_would_do():
    watch, data = falling(height=0.1, speed=60.0)
    before = data.qpos.copy()
    with pytest.raises(SimulationError, match=r"sphere near bar.*60 m/s, 60 mm a step.*at most 0\.67 ms"):
        watch.check(data, 1)
    np.testing.assert_array_equal(data.qpos, before)


def test_it_looks_as_far_as_the_call_goes():
    watch, data = falling(height=0.65, speed=60.0)
    watch.check(data, 1)
    with pytest.raises(SimulationError, match="too fast"):
        watch.check(data, 10)


def test_a_floor_has_nothing_behind_it():
    ball, floor = thing("sphere", at=(2.0, 0.0, 0.1), mass=1.0), thing("plane", at=(0.0, 0.0, 0.0))
    model = assemble(bar(), bar_skin(), EFFECTS, objects=(ball, floor))
    data = mujoco.MjData(model)
    data.qvel[-4] = -100.0
    mujoco.mj_kinematics(model, data)
    Passing(model, (ball,)).check(data, 1)
