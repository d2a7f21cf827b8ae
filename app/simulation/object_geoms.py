"""A scene's objects in the physics: shape, freedom and motors of each, and where it starts."""

from __future__ import annotations

import bisect
import math
from collections.abc import Sequence
from typing import assert_never

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from app.arrays import FloatArray
from app.scene.effects import Effects
from app.scene.objects import LIGHTEST, Body, ObjectKind, ObjectSpec

PROBE_STIFFNESS = 1000.0
"""Of the spring by which a probe's motors hold it to its path [N/m]; their damping is critical."""
SLAB = 10.0
"""Half the width of the block that stands in for a plane [m]."""
_AXES = "xyz"


def takes_part(kind: ObjectKind, effects: Effects) -> bool:
    """Whether an object of that kind can touch anything under these effects; if not, the physics leaves it out."""
    if not effects.dynamics:
        return False
    return effects.contact in ("environment", "all") or (effects.contact == "probe" and kind == "probe")


def body_name(said: ObjectSpec) -> str:
    """Of the object in the model; no link is called so."""
    return f"object {said.name}"


def slab_name(said: ObjectSpec) -> str:
    """Of the block that skin meets where the object is a plane."""
    return f"slab {said.name}"


def add_object(spec: mujoco.MjSpec, thing: Body, effects: Effects) -> None:
    """Add one object to the model: a body, its shape (which touches nothing yet), its joints and motors.

    A mesh touches as its convex hull. A plane gets a second shape, a block 20 m wide under it: MuJoCo makes up to four
    contacts between plane and hull, which would be as many times as stiff, and one between block and hull.

    Args:
        spec: The robot's model so far; changed.
        thing: The object.
        effects: With friction or without.
    """
    said = thing.spec
    rest = rest_pose(said)
    body = spec.worldbody.add_body(name=body_name(said), pos=rest[:3, 3], quat=_quaternion(rest[:3, :3]))
    geom = body.add_geom(name=body_name(said), contype=0, conaffinity=0, group=1)
    geom.friction, geom.condim = [said.friction, 0.005, 0.0001], 3 if effects.friction else 1
    _shape(spec, geom, thing)
    geom.mass = max(said.mass, LIGHTEST) if said.kind in ("probe", "plate") else said.mass
    if said.kind == "probe":
        _drive(spec, body, said)
    elif said.kind == "plate":
        _spring(body, said)
    elif said.kind == "plane":
        body.add_geom(name=slab_name(said), type=mujoco.mjtGeom.mjGEOM_BOX, size=[SLAB, SLAB, 1.0], pos=[0, 0, -1.0],
                      contype=0, conaffinity=0, group=3, mass=0.0)  # fmt: skip
    elif said.guided:
        body.add_joint(name=body_name(said), type=mujoco.mjtJoint.mjJNT_SLIDE, axis=rest[2, :3])
    elif said.mass > 0:
        body.add_freejoint(name=body_name(said))


def rest_pose(said: ObjectSpec) -> FloatArray:
    """(4, 4) ``T_world_object`` as the scene says it; a probe at the start of its path."""
    pose = said.pose.matrix
    if said.kind == "probe":  # a ball, whose motors pull along the world's axes
        pose[:3, :3] = np.eye(3)
        pose[:3, 3] = said.path[0][1:] if said.path else said.at
    return pose


class Path:
    """A probe's way through the world, walked again and again.

    Args:
        said: The probe.
    """

    def __init__(self, said: ObjectSpec) -> None:
        rows = said.path or ((0.0, *said.at),)
        self._times = [row[0] for row in rows]
        self._places = [np.array(row[1:]) for row in rows]

    def place(self, time: float) -> FloatArray:
        """(3,) where the motors pull it at ``time`` [s], world [m]."""
        times, places = self._times, self._places
        if len(times) == 1 or times[-1] <= 0:
            return places[0]
        time = math.fmod(time, times[-1])
        after = bisect.bisect_right(times, time)
        if after == 0:
            return places[0]
        share = (time - times[after - 1]) / (times[after] - times[after - 1])
        return np.asarray((1 - share) * places[after - 1] + share * places[after])


class Drives:
    """What moves the probes of one model along their paths: a target for their motors at every step.

    Args:
        model: The compiled model.
        objects: All of the scene's.
    """

    def __init__(self, model: mujoco.MjModel, objects: Sequence[Body]) -> None:
        self._drives = []
        for thing in objects:
            if thing.spec.kind == "probe" and has_body(model, thing.spec):
                first = int(model.actuator(f"{body_name(thing.spec)} x").id)
                self._drives.append((slice(first, first + 3), rest_pose(thing.spec)[:3, 3], Path(thing.spec)))
        self.moving = any(thing.spec.path for thing in objects if has_body(model, thing.spec))

    def push(self, data: mujoco.MjData) -> None:
        """Set the motors' targets for the present time."""
        for motors, start, path in self._drives:
            data.ctrl[motors] = path.place(data.time) - start


def has_body(model: mujoco.MjModel, said: ObjectSpec) -> bool:
    """Whether the physics has the object."""
    return bool(mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, body_name(said)) >= 0)


def _shape(spec: mujoco.MjSpec, geom: mujoco.MjsGeom, thing: Body) -> None:
    kind, size = thing.spec.kind, thing.spec.size
    match kind:
        case "sphere" | "probe":
            geom.type, geom.size = mujoco.mjtGeom.mjGEOM_SPHERE, [size[0], 0, 0]
        case "box" | "plate":
            geom.type, geom.size = mujoco.mjtGeom.mjGEOM_BOX, [0.5 * edge for edge in size]
        case "cylinder":
            geom.type, geom.size = mujoco.mjtGeom.mjGEOM_CYLINDER, [size[0], 0.5 * size[1], 0]
        case "plane":
            geom.type, geom.size = mujoco.mjtGeom.mjGEOM_PLANE, [*(0.5 * edge for edge in size or (0, 0)), 1.0]
        case "mesh":
            spec.add_mesh(
                name=body_name(thing.spec),
                uservert=thing.mesh.vertices.ravel().tolist(),
                userface=thing.mesh.faces.ravel().tolist(),
                inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX,
            )
            geom.type, geom.meshname = mujoco.mjtGeom.mjGEOM_MESH, body_name(thing.spec)
        case _:
            assert_never(kind)


def _drive(spec: mujoco.MjSpec, body: mujoco.MjsBody, said: ObjectSpec) -> None:
    body.gravcomp = 1.0  # its motors carry it
    damping = 2 * math.sqrt(PROBE_STIFFNESS * max(said.mass, LIGHTEST))
    for axis, letter in zip(np.eye(3), _AXES, strict=True):
        name = f"{body_name(said)} {letter}"
        body.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis)
        motor = spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        motor.gaintype, motor.biastype = mujoco.mjtGain.mjGAIN_FIXED, mujoco.mjtBias.mjBIAS_AFFINE
        motor.gainprm[0], motor.biasprm[:3] = PROBE_STIFFNESS, [0.0, -PROBE_STIFFNESS, -damping]
        motor.forcelimited, motor.forcerange = mujoco.mjtLimited.mjLIMITED_TRUE, [-said.max_force, said.max_force]


def _spring(body: mujoco.MjsBody, said: ObjectSpec) -> None:
    body.gravcomp = 1.0  # the scene says where it rests, not where it would hang
    joint = body.add_joint(name=body_name(said), type=mujoco.mjtJoint.mjJNT_SLIDE, axis=[0, 0, 1])
    joint.stiffness[0] = said.stiffness
    joint.damping[0] = 2 * said.damping * math.sqrt(said.stiffness * max(said.mass, LIGHTEST))


def _quaternion(rotation: FloatArray) -> FloatArray:
    """(4,) w first."""
    return np.asarray(Rotation.from_matrix(rotation).as_quat())[[3, 0, 1, 2]]
