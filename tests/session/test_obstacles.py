"""Objects of a scene as an arm's planner sees them: the same distances as in the physics."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from tactile_maps.control.path_following.clearance import FAR, Clearance
from tactile_maps.scene.effects import Effects
from tactile_maps.session.obstacles import obstacles_of
from tactile_maps.simulation.model.model_assembly import assemble
from tactile_maps.simulation.model.model_names import body_name
from tactile_maps.skin.link_hulls import hull_name
from tests.support.scene_objects import SIZES, thing
from tests.support.touch import pair


@pytest.mark.long
@pytest.mark.parametrize("kind", SIZES)
def test_distance_of_an_object_matches_the_physics(kind):
    robot, skin = pair()
    far = (0.0, 0.0, -0.1) if kind == "plane" else (-0.2, 0.02, 0.01)
    each = thing(kind, at=far, turn=(0.0, 0.0, 0.0) if kind == "plane" else (20.0, 30.0, 0.0))
    model = assemble(robot, skin, Effects(contact="all"), objects=(each,))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    pose = np.eye(4)
    pose[:3, :3] = data.body(body_name(each.spec)).xmat.reshape(3, 3)
    pose[:3, 3] = far
    obstacles = obstacles_of((each,), pose[None])
    clearance = Clearance(robot, skin, obstacles)
    normal = np.array([0.0, 0.0, 1.0])
    clearance.begin(np.zeros(1), obstacles, "right", np.array([0.0, 0.0, 5.0]), normal)
    if kind == "plane":
        assert obstacles[0].pose.translation == pytest.approx(far)
        truth = 0.05
    else:
        geoms = model.geom(hull_name("left")).id, model.geom(body_name(each.spec)).id
        truth = mujoco.mj_geomDistance(model, data, *geoms, 1.0, None)
    assert clearance.distance(np.zeros(1), "left", kind) == pytest.approx(min(truth, FAR), abs=1e-6)
