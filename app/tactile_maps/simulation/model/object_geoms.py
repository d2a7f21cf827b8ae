"""Objects of a scene in the physics: shape, joints, motors and initial pose, and the targets of probes."""

from __future__ import annotations

import bisect
import math
from collections.abc import Sequence
from typing import assert_never

import mujoco
import numpy as np
from scipy.spatial import ConvexHull, QhullError
from scipy.spatial.transform import Rotation

from tactile_maps.core.arrays import FloatArray
from tactile_maps.scene.effects import Effects
from tactile_maps.scene.objects import MIN_MOVING_MASS, ObjectKind, ObjectSpec, SceneObject
from tactile_maps.simulation.model.model_names import body_name
from tactile_maps.skin.link_hulls import corners_with_faces
from tactile_maps.tactile.mechanics.contact_notes import ContactNote, ContactNoteKind

PROBE_STIFFNESS = 1000.0
"""Stiffness with which the motors hold a probe on its path [N/m]; their damping is critical."""
_BARE_FRICTION = 0.5
"""Default Coulomb coefficient of an object in contact with bodies without skin."""
_AXES = "xyz"
_SAME_HULL = 1e-4
"""Distance [m] of a mesh from its convex hull up to which both count as the same."""
_HULL_SAMPLES = 20_000
"""Approximate number of faces whose distance from the hull is computed."""


def is_simulated(kind: ObjectKind, effects: Effects) -> bool:
    """Whether an object of that kind can touch anything under these effects; otherwise it is not in the physics."""
    if not effects.dynamics:
        return False
    return effects.contact in ("environment", "all") or (effects.contact == "probe" and kind == "probe")


def add_object(spec: mujoco.MjSpec, scene_object: SceneObject, effects: Effects) -> None:
    """Add one object to the model: a body, its shape (which touches nothing yet), its joints and motors.

    A mesh collides as its convex hull.

    Args:
        spec: Model of the robot; changed.
        scene_object: The object.
        effects: Effects, of which ``friction`` is used.
    """
    object_spec = scene_object.spec
    rest = initial_pose(object_spec)
    body = spec.worldbody.add_body(name=body_name(object_spec), pos=rest[:3, 3], quat=_quaternion(rest[:3, :3]))
    geom = body.add_geom(name=body_name(object_spec), contype=0, conaffinity=0, group=1)
    friction = _BARE_FRICTION if object_spec.friction is None else object_spec.friction
    geom.friction = [friction, 0.005, 0.0001]
    # A stated coefficient counts against a geom without priority, such as a bare link, whose default of MuJoCo is 1.
    geom.priority = int(object_spec.friction is not None)
    geom.condim = 3 if effects.friction else 1
    _shape(spec, geom, scene_object)
    geom.mass = max(object_spec.mass, MIN_MOVING_MASS) if object_spec.kind in ("probe", "plate") else object_spec.mass
    if object_spec.kind == "probe":
        _drive(spec, body, object_spec)
    elif object_spec.kind == "plate":
        _spring(body, object_spec)
    elif object_spec.guided:
        body.add_joint(name=body_name(object_spec), type=mujoco.mjtJoint.mjJNT_SLIDE, axis=rest[2, :3])
    elif object_spec.mass > 0:
        body.add_freejoint(name=body_name(object_spec))


def hull_notes(thing: SceneObject) -> tuple[ContactNote, ...]:
    """Return the note about a mesh whose convex hull is farther than 0.1 mm from its surface; empty for others.

    Cost: 0.1 s for 20,000 faces.
    """
    if thing.spec.kind != "mesh":
        return ()
    mesh = thing.mesh
    step = len(mesh.faces) // _HULL_SAMPLES + 1
    centres = mesh.vertices[mesh.faces[::step]].mean(axis=1)
    try:
        planes = ConvexHull(mesh.vertices).equations
    except QhullError:  # the mesh is flat
        return ()
    away = _largest_gap(planes, centres, mesh.face_normals[::step])
    if away <= _SAME_HULL:
        return ()
    return (ContactNote(ContactNoteKind.CONVEX_HULL, (thing.spec.name,), depth=away),)


def _largest_gap(planes: FloatArray, points: FloatArray, normals: FloatArray) -> float:
    """Return the longest way [m] from ``points`` (n, 3) in a hull along ``normals`` (n, 3) to its ``planes`` (k, 4)."""
    largest = 0.0
    for first in range(0, len(points), 500):
        part = slice(first, first + 500)
        depths = -(points[part] @ planes[:, :3].T + planes[:, 3])
        cosines = normals[part] @ planes[:, :3].T
        ways = np.where(cosines > 1e-6, depths / np.maximum(cosines, 1e-6), np.inf).min(axis=1)
        largest = max(largest, float(ways[np.isfinite(ways)].max(initial=0.0)))
    return largest


def initial_pose(object_spec: ObjectSpec) -> FloatArray:
    """(4, 4) ``T_world_object`` at the start, as in the scene; a probe is at the start of its path."""
    pose = object_spec.pose.matrix
    if object_spec.kind == "probe":  # a ball with motors along the axes of the world
        pose[:3, :3] = np.eye(3)
        pose[:3, 3] = object_spec.path[0][1:] if object_spec.path else object_spec.at
    return pose


class ProbePath:
    """Path of a probe through the world, which is repeated.

    Args:
        object_spec: The probe.
    """

    def __init__(self, object_spec: ObjectSpec) -> None:
        rows = object_spec.path or ((0.0, *object_spec.at),)
        self._times = [row[0] for row in rows]
        self._places = [np.array(row[1:]) for row in rows]

    def place(self, time: float) -> FloatArray:
        """(3,) target of the motors at ``time`` [s], world frame [m]."""
        times = self._times
        places = self._places
        if len(times) == 1 or times[-1] <= 0:
            return places[0]
        time = math.fmod(time, times[-1])
        after = bisect.bisect_right(times, time)
        if after == 0:
            return places[0]
        share = (time - times[after - 1]) / (times[after] - times[after - 1])
        return np.asarray((1 - share) * places[after - 1] + share * places[after])


class ProbeDrives:
    """Targets of the probes' motors at every step, which move them along their paths.

    Args:
        model: The compiled model.
        objects: All objects of the scene.
    """

    def __init__(self, model: mujoco.MjModel, objects: Sequence[SceneObject]) -> None:
        self._drives = []
        for scene_object in objects:
            if scene_object.spec.kind == "probe" and has_body(model, scene_object.spec):
                first = int(model.actuator(f"{body_name(scene_object.spec)} x").id)
                self._drives.append(
                    (slice(first, first + 3), initial_pose(scene_object.spec)[:3, 3], ProbePath(scene_object.spec))
                )
        self.moving = any(scene_object.spec.path for scene_object in objects if has_body(model, scene_object.spec))

    def push(self, data: mujoco.MjData) -> None:
        """Set the targets for the present time."""
        for motors, start, path in self._drives:
            data.ctrl[motors] = path.place(data.time) - start


def has_body(model: mujoco.MjModel, object_spec: ObjectSpec) -> bool:
    """Whether the object is in the physics."""
    return bool(mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, body_name(object_spec)) >= 0)


def _shape(spec: mujoco.MjSpec, geom: mujoco.MjsGeom, scene_object: SceneObject) -> None:
    kind = scene_object.spec.kind
    size = scene_object.spec.size
    match kind:
        case "sphere" | "probe":
            geom.type = mujoco.mjtGeom.mjGEOM_SPHERE
            geom.size = [size[0], 0, 0]
        case "box" | "plate":
            geom.type = mujoco.mjtGeom.mjGEOM_BOX
            geom.size = [0.5 * edge for edge in size]
        case "cylinder":
            geom.type = mujoco.mjtGeom.mjGEOM_CYLINDER
            geom.size = [size[0], 0.5 * size[1], 0]
        case "plane":
            geom.type = mujoco.mjtGeom.mjGEOM_PLANE
            geom.size = [*(0.5 * edge for edge in size or (0, 0)), 1.0]
        case "mesh":
            spec.add_mesh(
                name=body_name(scene_object.spec),
                uservert=corners_with_faces(scene_object.mesh.vertices).ravel().tolist(),
                inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX,
            )
            geom.type = mujoco.mjtGeom.mjGEOM_MESH
            geom.meshname = body_name(scene_object.spec)
        case _:
            assert_never(kind)


def _drive(spec: mujoco.MjSpec, body: mujoco.MjsBody, object_spec: ObjectSpec) -> None:
    body.gravcomp = 1.0  # carried by its motors
    damping = 2 * math.sqrt(PROBE_STIFFNESS * max(object_spec.mass, MIN_MOVING_MASS))
    for axis, letter in zip(np.eye(3), _AXES, strict=True):
        name = f"{body_name(object_spec)} {letter}"
        body.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis)
        motor = spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        motor.gaintype = mujoco.mjtGain.mjGAIN_FIXED
        motor.biastype = mujoco.mjtBias.mjBIAS_AFFINE
        motor.gainprm[0] = PROBE_STIFFNESS
        motor.biasprm[:3] = [0.0, -PROBE_STIFFNESS, -damping]
        motor.forcelimited = mujoco.mjtLimited.mjLIMITED_TRUE
        motor.forcerange = [-object_spec.max_force, object_spec.max_force]


def _spring(body: mujoco.MjsBody, object_spec: ObjectSpec) -> None:
    body.gravcomp = 1.0  # the scene states its rest position under gravity
    joint = body.add_joint(name=body_name(object_spec), type=mujoco.mjtJoint.mjJNT_SLIDE, axis=[0, 0, 1])
    joint.stiffness[0] = object_spec.stiffness
    joint.damping[0] = (
        2 * object_spec.damping * math.sqrt(object_spec.stiffness * max(object_spec.mass, MIN_MOVING_MASS))
    )


def _quaternion(rotation: FloatArray) -> FloatArray:
    """(4,) quaternion, w first."""
    return np.asarray(Rotation.from_matrix(rotation).as_quat())[[3, 0, 1, 2]]
