"""Assembly of a MuJoCo model from robot, skin and objects, with the selected effects only."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np

from tactile_maps.robots.model.mujoco_spec import compile_spec, robot_spec
from tactile_maps.robots.model.robot import Robot
from tactile_maps.scene.effects import Effects, Integrator
from tactile_maps.scene.objects import SceneObject
from tactile_maps.simulation.model.contact_pairs import add_contact_pairs, allows_self_contact
from tactile_maps.simulation.model.contact_stiffness import FRICTION_RATIO, ContactSharing
from tactile_maps.simulation.model.model_names import is_object
from tactile_maps.simulation.model.object_geoms import add_object, is_simulated
from tactile_maps.skin.model.skin import Skin
from tactile_maps.tactile.mechanics.elastic_layer import ElasticLayer
from tactile_maps.tactile.models.depth import add_taxel_sensors

_COVER = ElasticLayer()
_LEAST_MOBILITY = 0.01
"""Share of the mobility of a body's shapes below which that of its centre of mass says nothing about contacts.

Arms have 0.03 and more: the mean over directions includes the spin of a slender link about its own axis."""
_INTEGRATORS: dict[Integrator, mujoco.mjtIntegrator] = {
    "implicitfast": mujoco.mjtIntegrator.mjINT_IMPLICITFAST,
    "discrete": mujoco.mjtIntegrator.mjINT_DISCRETE,
    "euler": mujoco.mjtIntegrator.mjINT_EULER,
    "implicit": mujoco.mjtIntegrator.mjINT_IMPLICIT,
}


def assemble(
    robot: Robot, skin: Skin, effects: Effects, *, objects: Sequence[SceneObject] = (), layer: ElasticLayer = _COVER
) -> mujoco.MjModel:
    """Compile the robot with one impedance actuator per joint and the selected effects.

    Joints, bodies and actuators of the robot come first, in the robot's order. Objects that nothing can touch are left
    out. Actuator i drives joint i: force = kp ctrl - kp q - kd q'; kp and kd are changed in the model during a run.
    Without dynamics the model has no actuators and no contacts.

    Args:
        robot: The robot.
        skin: Its skin; its links collide by hulls that include the skin.
        effects: Effects to simulate.
        objects: Objects of the scene.
        layer: The skin's cover: its stiffness and friction.

    Raises:
        RobotError: MuJoCo refuses the model.
    """
    spec = robot_spec(robot)
    _set_options(spec.option, effects)
    _set_up_robot(spec, effects)
    outside = [scene_object for scene_object in objects if is_simulated(scene_object.spec.kind, effects)]
    for scene_object in outside:
        add_object(spec, scene_object, effects)
    add_contact_pairs(spec, robot, skin, objects, effects, layer)
    if outside or allows_self_contact(effects):
        if effects.skin == "depth":
            itself = allows_self_contact(effects)
            add_taxel_sensors(spec, skin, lambda mesh: itself or is_object(mesh))
    else:
        spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    model = compile_spec(spec, source=robot.source)
    _raise_inverse_masses(model)
    ContactSharing(model, layer)  # sets the model's pairs
    return model


def _raise_inverse_masses(model: mujoco.MjModel) -> None:
    """Set the inverse masses of bodies whose centre of mass hardly moves to those at their shapes.

    MuJoCo estimates how a body responds to a contact by the mobility of its centre of mass. With that on the axis of
    its only joint, as in a turret or the first phalanx of a finger, the estimate is zero and a contact with a fixed
    body is viscous: it takes minutes to reach its force. A point at the distance r from the centre of mass moves by
    2/3 r^2 times the inverse inertia, as the mean of all directions.
    """
    for body in range(1, model.nbody):
        shapes = np.flatnonzero(model.geom_bodyid == body)
        offsets = np.linalg.norm(model.geom_pos[shapes] - model.body_ipos[body], axis=1)
        reach = float((offsets + model.geom_rbound[shapes]).max(initial=0.0))
        moving, turning = model.body_invweight0[body].tolist()
        at_shapes = 2 / 3 * turning * reach**2
        if moving < _LEAST_MOBILITY * at_shapes:
            model.body_invweight0[body, 0] = at_shapes


def _set_options(option: mujoco.MjOption, effects: Effects) -> None:
    option.timestep = effects.timestep
    option.integrator = _INTEGRATORS[effects.integrator]
    # MuJoCo 4.0.0 has a wrong sparse Hessian in its Newton solver; for robots dense is as fast.
    option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    # MuJoCo would reset a diverging state to time zero, which would hide it from the guard.
    option.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
    # Constraints are changed within a step; with islands the solver would use copies of them.
    option.disableflags |= mujoco.mjtDisableBit.mjDSBL_ISLAND
    if effects.integrator == "discrete":  # it is stable for any stiffness, and this would make the contact softer
        option.disableflags |= mujoco.mjtDisableBit.mjDSBL_REFSAFE
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    option.impratio = FRICTION_RATIO
    # With MuJoCo's 1e-8 forces near the friction cone vary by 5e-5, and a body on a bare link creeps by 0.14 mm/s.
    option.tolerance = 1e-10
    option.gravity = [0, 0, 0] if effects.gravity == "off" else [0, 0, -9.81]


def _set_up_robot(spec: mujoco.MjSpec, effects: Effects) -> None:
    if effects.gravity == "compensated":
        for body in spec.bodies[1:]:
            body.gravcomp = 1.0
    for joint in spec.joints:
        if not effects.joint_limits:
            joint.limited = mujoco.mjtLimited.mjLIMITED_FALSE
        if not effects.joint_friction:
            joint.frictionloss = 0.0
        if effects.dynamics:
            _add_impedance(spec, joint.name)


def _add_impedance(spec: mujoco.MjSpec, joint: str) -> None:
    actuator = spec.add_actuator(name=f"impedance {joint}", target=joint, trntype=mujoco.mjtTrn.mjTRN_JOINT)
    actuator.gaintype = mujoco.mjtGain.mjGAIN_FIXED
    actuator.biastype = mujoco.mjtBias.mjBIAS_AFFINE
    actuator.gainprm[:3] = 0
    actuator.biasprm[:3] = 0
