"""A model holds what is on and nothing of what is off."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from tactile_maps.core.errors import RobotError
from tactile_maps.scene.effects import Effects
from tactile_maps.simulation.model.model_assembly import assemble
from tests.support.scene_objects import every_kind, thing
from tests.support.touch import arm, bar, bar_skin

COUNTS = ("nq", "nv", "nu", "nbody", "njnt", "ngeom", "nmesh", "nsensor", "nsite", "npair", "neq", "ntendon")


def counts(model) -> dict[str, int]:
    return {name: int(getattr(model, name)) for name in COUNTS}


def test_model_without_effects_has_only_joints_and_impedance():
    robot = arm().robot
    model = assemble(robot, arm().skin, Effects(gravity="off", contact="off", joint_limits=False), objects=every_kind())
    found = counts(model)
    assert found.pop("nq") == found.pop("nv") == found.pop("nu") == found.pop("njnt") == len(robot.joints) == 7
    assert found.pop("nbody") == 1 + len(robot.links)
    assert set(found.values()) == {0}, found
    assert not model.jnt_limited.any()
    assert not model.body_gravcomp.any()
    assert not model.opt.gravity.any()
    assert model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_CONTACT


@pytest.mark.parametrize(
    ("gravity", "weight", "compensated"), [("off", 0, 0), ("on", -9.81, 0), ("compensated", -9.81, 1)]
)
def test_gravity_setting_sets_gravity_and_compensation(gravity, weight, compensated):
    model = assemble(bar(), bar_skin(), Effects(gravity=gravity))
    assert model.opt.gravity[2] == weight
    assert (model.body_gravcomp[1:] == compensated).all()


def test_only_robot_links_are_gravity_compensated_except_on_motors_and_springs():
    model = assemble(bar(), bar_skin(), Effects(gravity="compensated", contact="environment"), objects=every_kind())
    carried = {model.body(i).name for i in np.flatnonzero(model.body_gravcomp)}
    assert carried == {"bar", "tactile-maps/object probe", "tactile-maps/object plate"}


def test_joint_friction_is_that_of_the_model_file():
    dry = replace(bar(), mjcf=bar().mjcf.replace('name="hinge"', 'name="hinge" frictionloss="0.3"'))
    assert assemble(dry, bar_skin(), Effects(joint_friction=True)).dof_frictionloss[0] == 0.3
    assert not assemble(dry, bar_skin(), Effects(joint_friction=False)).dof_frictionloss.any()


@pytest.mark.parametrize("name", ["implicitfast", "discrete", "euler", "implicit"])
def test_integrator_setting_sets_integrator_time_step_and_jacobian(name):
    model = assemble(bar(), bar_skin(), Effects(integrator=name, timestep=0.0005))
    assert model.opt.integrator == getattr(mujoco.mjtIntegrator, f"mjINT_{name.upper()}")
    assert model.opt.timestep == 0.0005
    assert model.opt.jacobian == mujoco.mjtJacobian.mjJAC_DENSE


def test_model_without_dynamics_has_no_motion_and_no_contact():
    model = assemble(arm().robot, arm().skin, Effects(contact="all", dynamics=False), objects=every_kind())
    found = counts(model)
    assert found["nu"] == found["npair"] == found["ngeom"] == 0
    assert found["nbody"] == 1 + len(arm().robot.links)


@pytest.mark.long
def test_contact_mode_probe_has_only_probes_and_skin():
    robot = arm().robot
    skin = arm().skin
    everything = assemble(robot, skin, Effects(contact="probe"), objects=every_kind())
    probe_alone = assemble(robot, skin, Effects(contact="probe"), objects=(thing("probe", at=(5.0, 0.0, 5.0)),))
    assert counts(everything) == counts(probe_alone)
    links = {patch.link for patch in skin.patches}
    assert everything.npair == len(links)
    assert everything.ngeom == len(links) + 1
    assert everything.nv == len(robot.joints) + 3
    assert not everything.geom_contype.any()


@pytest.mark.long
def test_depth_model_has_one_sensor_per_link_and_only_with_contact():
    robot = arm().robot
    skin = arm().skin
    probe = (thing("probe", at=(5.0, 0.0, 5.0)),)
    links = {patch.link for patch in skin.patches}
    assert assemble(robot, skin, Effects(contact="probe", skin="depth"), objects=probe).nsensor == len(links)
    assert assemble(robot, skin, Effects(contact="probe", skin="depth")).nsensor == 0
    assert assemble(robot, skin, Effects(contact="off", skin="depth"), objects=probe).nsensor == 0
    assert assemble(robot, skin, Effects(contact="probe"), objects=probe).nsensor == 0


def test_robot_rejected_by_mujoco_is_named():
    with pytest.raises(RobotError, match="by hand"):
        assemble(replace(bar(), mjcf="<mujoco><nonsense/></mujoco>"), bar_skin(), Effects())
