"""From robot, skin and effects to a MuJoCo model that holds only what is on."""

from __future__ import annotations

import mujoco
import numpy as np

from app.geometry.mesh import Mesh
from app.robots.compile import compile_spec, drop_shapes, robot_spec
from app.robots.exclusions import pairs_to_exclude
from app.robots.robot import Robot
from app.simulation.effects import Effects
from app.skin.skin import Skin


def assemble(robot: Robot, skin: Skin, effects: Effects) -> mujoco.MjModel:
    """Compile the robot with one impedance actuator a joint and the effects that are on, nothing else.

    Skinned links collide with the convex hull of link and skin, so that what touches is what feels; others with their
    own shapes. Actuator i drives joint i: force = kp ctrl - kp q - kd q', with kp and kd set live in the model.

    Args:
        robot: The robot alone.
        skin: Whose links get colliding hulls that agree with it.
        effects: What to simulate.

    Raises:
        RobotError: MuJoCo refuses the model.
    """
    spec = robot_spec(robot)
    option = spec.option
    option.timestep, option.integrator = effects.timestep, mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    # MuJoCo 4.0.0 has a wrong sparse Hessian in its Newton solver; for robots dense is as fast.
    option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    # Left to itself MuJoCo answers a diverging state with a reset to time zero; the guard wants to see it.
    option.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
    option.gravity = [0, 0, 0] if effects.gravity == "off" else [0, 0, -9.81]
    if effects.gravity == "compensated":
        for body in spec.bodies[1:]:
            body.gravcomp = 1.0
    if not effects.joint_limits:
        for joint in spec.joints:
            joint.limited = mujoco.mjtLimited.mjLIMITED_FALSE
    for joint in spec.joints:
        _add_impedance(spec, joint.name)
    if effects.contact == "off":
        drop_shapes(spec)
        option.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    else:
        _collide_with_skin(spec, robot, skin)
    return compile_spec(spec, source=robot.source)


def _add_impedance(spec: mujoco.MjSpec, joint: str) -> None:
    actuator = spec.add_actuator(name=f"impedance {joint}", target=joint, trntype=mujoco.mjtTrn.mjTRN_JOINT)
    actuator.gaintype, actuator.biastype = mujoco.mjtGain.mjGAIN_FIXED, mujoco.mjtBias.mjBIAS_AFFINE
    actuator.gainprm[:3], actuator.biasprm[:3] = 0, 0


def _collide_with_skin(spec: mujoco.MjSpec, robot: Robot, skin: Skin) -> None:
    """Replace the colliding shapes of skinned links by hulls that hold link and skin; exclude what overlaps at rest."""
    for link in {patch.link: None for patch in skin.patches}:
        body = spec.body(link)
        for geom in body.geoms:
            geom.contype = geom.conaffinity = 0
        mesh = _hull_points(robot, skin, link)
        spec.add_mesh(
            name=f"skin hull {link}",
            uservert=mesh.vertices.ravel().tolist(),
            inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX,
        )
        body.add_geom(
            name=f"skin {link}",
            type=mujoco.mjtGeom.mjGEOM_MESH,
            meshname=f"skin hull {link}",
            mass=0.0,
            contype=1,
            conaffinity=1,
            group=3,
        )
    known = {frozenset((exclude.bodyname1, exclude.bodyname2)) for exclude in spec.excludes}
    for first, second in pairs_to_exclude(compile_spec(spec, source=robot.source), robot.home):
        if frozenset((first, second)) not in known:
            spec.add_exclude(bodyname1=first, bodyname2=second)


def _hull_points(robot: Robot, skin: Skin, link: str) -> Mesh:
    clouds = [patch.surface.vertices for patch in skin.patches if patch.link == link]
    own = robot.link(link).mesh
    if own is not None:
        clouds.append(own.vertices)
    return Mesh(np.concatenate(clouds), np.zeros((0, 3), dtype=np.int64))
