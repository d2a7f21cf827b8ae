"""The physics of a model: hooks, command, refreshing, and kinds of steps."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from tactile_maps.scene.effects import Effects
from tactile_maps.simulation.physics import Physics
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tests.support.scene_objects import thing
from tests.support.touch import bar, bar_skin, hold, no_command


def physics(*objects, **effects) -> Physics:
    made = Physics(bar(), bar_skin(), Effects(**effects), objects, ElasticLayer())
    made.start(bar().home)
    return made


@pytest.mark.parametrize("integrator", ["implicitfast", "discrete"])
def test_hook_acts_in_every_step_at_the_poses_of_that_step(integrator):
    made = physics(integrator=integrator)
    seen = []

    def hand(data: mujoco.MjData) -> None:
        data.qfrc_applied[0] += 1.0
        seen.append((data.time, data.qpos[0], float(np.arctan2(-data.xmat[1, 6], data.xmat[1, 0]))))

    made.apply_command(no_command(bar()))
    made.step(50, hand)
    assert [round(time / 0.001) for time, *_ in seen] == list(range(50))
    assert all(position == pytest.approx(angle, abs=1e-12) for _, position, angle in seen), "kinematics of that step"
    assert made.data.qpos[0] == pytest.approx(0.5 * (1.0 / 0.0535) * 0.05**2, rel=0.03)
    made.step(1, None)
    assert not made.data.qfrc_applied.any(), "the hand is gone"


def test_changed_gains_act_from_the_next_step_on():
    """A spring of twice the stiffness accelerates twice as fast."""
    accelerations = []
    made = physics()
    for stiffness in (20.0, 40.0):
        command = hold(bar(), stiffness, 0.0)
        made.start(bar().home + 0.1)
        made.apply_command(command)
        made.step(1, None)
        accelerations.append(made.data.qvel[0] / made.model.opt.timestep)
    assert accelerations[1] / accelerations[0] == pytest.approx(2.0, rel=0.02)


def test_poses_are_updated_on_request():
    ball = thing("sphere", at=(5.0, 0.0, 5.0), mass=1.0)
    made = physics(ball, contact="environment")
    body = made.model.body("tactile-maps/object sphere").id
    made.step(100, None)
    stale = made.data.xpos[body].copy()
    pose = made.pose("sphere")
    assert pose[:3, 3] == pytest.approx(made.data.qpos[1:4], abs=1e-15)
    assert pose[2, 3] < stale[2]
    assert made.pose("nothing") is None


def test_contacts_are_read_at_the_poses_of_their_detection():
    """Loads at the poses after the step would be displaced from their shapes."""
    ball = thing("sphere", at=(0.3, 0.0, 0.0405), mass=1.0)
    made = physics(ball, contact="environment", gravity="on")
    made.apply_command(hold(bar(), 20.0, 0.1))
    made.data.qvel[3] = -1.0
    for _ in range(40):
        made.step(1, None)
        for load in made.loads():
            depth = -load.distances(load.point[None])[0]
            (dist,) = made.data.contact.dist
            assert depth == pytest.approx(-0.5 * dist, rel=1e-3, abs=1e-9)
            return
    pytest.fail("the ball never touched")
