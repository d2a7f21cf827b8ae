"""Cutting a model file down to the robot alone: no scene, no actuators, no sensors, one fixed base."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco

from app.errors import Finding, RobotError

_WIDTH = {
    mujoco.mjtJoint.mjJNT_FREE: 7,
    mujoco.mjtJoint.mjJNT_BALL: 4,
    mujoco.mjtJoint.mjJNT_SLIDE: 1,
    mujoco.mjtJoint.mjJNT_HINGE: 1,
}
_SCALAR = (mujoco.mjtJoint.mjJNT_SLIDE, mujoco.mjtJoint.mjJNT_HINGE)


def home_of_keyframe(spec: mujoco.MjSpec) -> dict[str, float]:
    """Joint values [rad, m] by joint name of the keyframe called ``home``, else of the first; empty without one."""
    keys = [key for key in spec.keys if key.name == "home"] or list(spec.keys)
    if not keys:
        return {}
    values, start, home = list(keys[0].qpos), 0, {}
    for joint in _joints_in_order(spec.worldbody):
        if joint.type in _SCALAR and start < len(values):
            home[joint.name] = float(values[start])
        start += _WIDTH[joint.type]
    return home if start == len(values) else {}


def strip_scene(spec: mujoco.MjSpec, source: str) -> list[Finding]:
    """Delete from ``spec`` everything that is not the robot; fix its base.

    Raises:
        RobotError: Nothing is left, or a joint is a ball joint.
    """
    for elements in ("keys", "cameras", "lights"):
        _delete_all(spec, list(getattr(spec, elements)))
    _delete_all(spec, list(spec.worldbody.geoms))
    findings = _drop_loose_bodies(spec) + _fix_base(spec)
    if len(spec.bodies) < 2:
        raise RobotError("the file contains no robot: there is no body with a shape or a joint", file=source)
    _refuse_ball_joints(spec, source)
    _delete_all(spec, [equality for equality in spec.equalities if not _joins_links(equality)])
    _delete_all(spec, list(spec.sites))
    used = {geom.meshname for geom in spec.geoms}
    _delete_all(spec, [mesh for mesh in spec.meshes if mesh.name not in used])
    spec.meshdir = spec.texturedir = ""
    spec.compiler.saveinertial = True
    return findings


def name_everything(spec: mujoco.MjSpec) -> list[Finding]:
    """Give bodies and joints without a name one of their own."""
    unnamed = 0
    for prefix, elements in (("link", spec.bodies), ("joint", spec.joints)):
        taken = {element.name for element in elements}
        for i, element in enumerate(elements):
            if not element.name:
                element.name = next(name for name in _candidates(prefix, i) if name not in taken)
                taken.add(element.name)
                unnamed += 1
    return [Finding("unnamed", "bodies and joints", "named link_… and joint_…", unnamed)] if unnamed else []


def _candidates(prefix: str, index: int) -> Iterator[str]:
    name = f"{prefix}_{index}"
    while True:
        yield name
        name += "_"


def _joints_in_order(body: mujoco.MjsBody) -> Iterator[mujoco.MjsJoint]:
    yield from body.joints
    for child in body.bodies:
        yield from _joints_in_order(child)


def _delete_all(spec: mujoco.MjSpec, elements: list[object]) -> None:
    for element in elements:
        spec.delete(element)


def _drop_loose_bodies(spec: mujoco.MjSpec) -> list[Finding]:
    """Remove mocap bodies, and free bodies without joints of their own when something else has some."""
    tops = list(spec.worldbody.bodies)
    jointed = [body for body in tops if any(joint.type in _SCALAR for joint in _joints_in_order(body))]
    loose = [body for body in tops if body.mocap or (jointed and body not in jointed and _is_free(body))]
    names = ", ".join(body.name or "(unnamed)" for body in loose)
    _delete_all(spec, loose)
    left = {body.name for body in spec.bodies}
    _delete_all(spec, [e for e in spec.excludes if not {e.bodyname1, e.bodyname2} <= left])
    geoms = {geom.name for geom in spec.geoms}
    _delete_all(spec, [pair for pair in spec.pairs if not {pair.geomname1, pair.geomname2} <= geoms])
    return [Finding("scene-objects", names, "left out: they are not part of the robot", len(loose))] if loose else []


def _is_free(body: mujoco.MjsBody) -> bool:
    return any(joint.type == mujoco.mjtJoint.mjJNT_FREE for joint in body.joints)


def _fix_base(spec: mujoco.MjSpec) -> list[Finding]:
    free = [joint for joint in spec.joints if joint.type == mujoco.mjtJoint.mjJNT_FREE]
    names = ", ".join(joint.parent.name for joint in free)
    _delete_all(spec, free)
    return [Finding("free-base", names, "the base is fixed to the world", len(free))] if free else []


def _refuse_ball_joints(spec: mujoco.MjSpec, source: str) -> None:
    for joint in spec.joints:
        if joint.type not in _SCALAR:
            raise RobotError(
                "ball joints are not supported",
                file=source,
                place=f"joint {joint.name or '(unnamed)'}",
                remedy="Replace it by hinge joints about three axes",
            )


def _joins_links(equality: mujoco.MjsEquality) -> bool:
    """True for couplings between joints or bodies, which belong to the robot; tendons, flexes and sites are gone."""
    kind, obj = mujoco.mjtEq, mujoco.mjtObj
    between_bodies = equality.type in (kind.mjEQ_CONNECT, kind.mjEQ_WELD) and equality.objtype == obj.mjOBJ_BODY
    return equality.type == kind.mjEQ_JOINT or between_bodies
