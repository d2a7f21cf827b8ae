"""A model holds what is on and nothing of what is off."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from app.errors import RobotError
from app.simulation.assemble import assemble
from app.simulation.effects import Effects
from tests.touch import arm, bar, bar_skin, pair


def test_all_off_is_joints_and_their_impedance_alone():
    robot = arm().robot
    model = assemble(robot, arm().skin, Effects(gravity="off", contact="off", joint_limits=False))
    counts = {name: getattr(model, name) for name in ("ngeom", "nmesh", "nsensor", "nsite", "npair", "neq", "ntendon")}
    assert set(counts.values()) == {0}, counts
    assert model.nu == model.nv == len(robot.joints) == 7
    assert not model.jnt_limited.any()
    assert not model.body_gravcomp.any()
    assert not model.opt.gravity.any()


@pytest.mark.parametrize(
    ("gravity", "weight", "compensated"), [("off", 0, 0), ("on", -9.81, 0), ("compensated", -9.81, 1)]
)
def test_gravity(gravity, weight, compensated):
    model = assemble(bar(), bar_skin(), Effects(gravity=gravity))
    assert model.opt.gravity[2] == weight
    assert (model.body_gravcomp[1:] == compensated).all()


def test_joint_limits():
    assert assemble(bar(), bar_skin(), Effects(joint_limits=True)).jnt_limited.all()
    assert not assemble(bar(), bar_skin(), Effects(joint_limits=False)).jnt_limited.any()


def test_self_contact_collides_hulls_that_reach_the_skin():
    robot, skin = pair()
    raised = replace(skin.patches[0].surface, vertices=skin.patches[0].surface.vertices + [0.004, 0, 0])
    model = assemble(robot, replace(skin, patches=(replace(skin.patches[0], surface=raised), skin.patches[1])),
                     Effects(contact="self"))  # fmt: skip
    colliding = [model.geom(i).name for i in np.flatnonzero(model.geom_contype)]
    assert colliding == ["skin left", "skin right"], "the links' own shapes no longer collide"
    mesh = model.mesh("skin hull left").id
    start, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
    geom = model.geom("skin left")
    rotation = np.zeros(9)
    mujoco.mju_quat2Mat(rotation, geom.quat)
    vertices = model.mesh_vert[start : start + count].reshape(-1, 3) @ rotation.reshape(3, 3).T + geom.pos
    assert (vertices[:, 0].min(), vertices[:, 0].max()) == pytest.approx((-0.05, 0.054), abs=1e-6), "link and skin"


def test_the_arms_mass_does_not_depend_on_effects():
    masses = [
        assemble(arm().robot, arm().skin, Effects(contact=contact)).body_mass.sum() for contact in ("off", "self")
    ]
    assert masses[0] == pytest.approx(masses[1], rel=1e-12)
    assert masses[0] > 1


def test_options():
    model = assemble(bar(), bar_skin(), Effects(timestep=0.0005))
    assert model.opt.timestep == 0.0005
    assert model.opt.integrator == mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    assert model.opt.jacobian == mujoco.mjtJacobian.mjJAC_DENSE


def test_a_robot_mujoco_refuses_is_named():
    with pytest.raises(RobotError, match="by hand"):
        assemble(replace(bar(), mjcf="<mujoco><nonsense/></mujoco>"), bar_skin(), Effects())
