"""Changes to a parsed MuJoCo spec that make it a robot that can be simulated.

``strip_scene`` reduces a model file to the robot: no scene, no actuators, no sensors, one fixed base.
``prepare_degenerate_meshes`` handles meshes without volume, which MuJoCo rejects unless their inertia is that of a
shell and they do not collide. ``collision_exclusions`` returns the links that never collide: neighbours whose shapes
overlap in most postures are connected, not in contact.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path

import mujoco
import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import Finding, RobotError, places_finding
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.robots.files.mesh_files import PLACEHOLDER_SIZE, MissingMesh, box_mesh, parse_mesh, placeholder
from tactile_maps.robots.files.model_files import ModelFiles
from tactile_maps.robots.model.mujoco_spec import rotation_of

_WIDTH = {
    mujoco.mjtJoint.mjJNT_FREE: 7,
    mujoco.mjtJoint.mjJNT_BALL: 4,
    mujoco.mjtJoint.mjJNT_SLIDE: 1,
    mujoco.mjtJoint.mjJNT_HINGE: 1,
}
_SCALAR = (mujoco.mjtJoint.mjJNT_SLIDE, mujoco.mjtJoint.mjJNT_HINGE)


def keyframe_home(spec: mujoco.MjSpec) -> dict[str, float]:
    """Return joint values [rad, m] by name of the keyframe ``home``, or else of the first; empty without keyframes."""
    keys = [key for key in spec.keys if key.name == "home"] or list(spec.keys)
    if not keys:
        return {}
    values = list(keys[0].qpos)
    start = 0
    home = {}
    for joint in _joints_in_order(spec.worldbody):
        if joint.type in _SCALAR and start < len(values):
            home[joint.name] = float(values[start])
        start += _WIDTH[joint.type]
    return home if start == len(values) else {}


Mount = tuple[str, str]
"""Kind (``site`` or ``geom``) and name of the element that a sensor is fixed to."""


def strip_scene(spec: mujoco.MjSpec, source: str, mounts: Collection[Mount] = ()) -> list[Finding]:
    """Delete everything from ``spec`` that is not the robot, and fix its base.

    Args:
        spec: The spec as it was read; it is changed.
        source: Path or library name, for errors.
        mounts: Elements that sensors are fixed to: the bodies that have them belong to the robot.

    Raises:
        RobotError: Nothing remains, or other joints of a body follow a ball joint.
    """
    for elements in ("keys", "cameras", "lights"):
        _delete_all(spec, list(getattr(spec, elements)))
    _delete_all(spec, list(spec.worldbody.geoms))
    findings = _remove_scene_objects(spec, mounts) + _fix_base(spec)
    if len(spec.bodies) < 2:
        raise RobotError("the file contains no robot: there is no body with a shape or a joint", file=source)
    findings += _split_ball_joints(spec, source)
    _delete_all(spec, [equality for equality in spec.equalities if not _joins_links(equality)])
    _delete_all(spec, list(spec.sites))
    used = {geom.meshname for geom in spec.geoms}
    _delete_all(spec, [mesh for mesh in spec.meshes if mesh.name not in used])
    spec.meshdir = spec.texturedir = ""
    spec.compiler.saveinertial = True
    return findings


def name_unnamed_elements(spec: mujoco.MjSpec) -> list[Finding]:
    """Name the unnamed bodies and joints."""
    unnamed = 0
    for prefix, elements in (("link", spec.bodies), ("joint", spec.joints)):
        taken = {element.name for element in elements}
        for i, element in enumerate(elements):
            if not element.name:
                element.name = next(name for name in _suffixed(f"{prefix}_{i}") if name not in taken)
                taken.add(element.name)
                unnamed += 1
    return [Finding("unnamed", "bodies and joints", "unnamed: named link_… and joint_…", unnamed)] if unnamed else []


def _suffixed(name: str) -> Iterator[str]:
    while True:
        yield name
        name += "_"


def _joints_in_order(body: mujoco.MjsBody) -> Iterator[mujoco.MjsJoint]:
    for part in _subtree(body):
        yield from part.joints


def _subtree(body: mujoco.MjsBody) -> Iterator[mujoco.MjsBody]:
    yield body
    for child in body.bodies:
        yield from _subtree(child)


MOST_DELETED = 2000


def _delete_all(spec: mujoco.MjSpec, elements: Sequence[object]) -> None:
    """Delete elements.

    Raises:
        RobotError: There are more than ``MOST_DELETED``, because the time grows with the square of the number.
    """
    if len(elements) > MOST_DELETED:
        kind = type(elements[0]).__name__.removeprefix("Mjs").lower()
        raise RobotError(
            "too many elements of the file are not part of the robot or replace missing meshes",
            place=f"elements of kind {kind}",
            value=len(elements),
            remedy=f"The maximum is {MOST_DELETED}: remove them from the file",
        )
    for element in elements:
        spec.delete(element)


def _remove_scene_objects(spec: mujoco.MjSpec, mounts: Collection[Mount]) -> list[Finding]:
    """Remove the bodies of the scene: those without joints and sensors that are not fixed to the robot.

    A body of the world with joints or sensors anywhere below it is part of the robot, also where it is free or placed
    by mocap. Of the other bodies, free ones and mocap ones belong to the scene; so do fixed ones where the whole robot
    is free, because they cannot be its base. Where nothing has joints or sensors, only mocap bodies are removed.
    """
    tops = list(spec.worldbody.bodies)
    own = [body for body in tops if _carries_joints_or_sensors(body, mounts)]
    floating = bool(own) and all(body.mocap or _is_free(body) for body in own)
    loose = [body for body in tops if body not in own and (body.mocap or floating or (bool(own) and _is_free(body)))]
    names = [body.name or "(unnamed)" for body in loose]
    _delete_all(spec, loose)
    left = {body.name for body in spec.bodies}
    _delete_all(spec, [e for e in spec.excludes if not {e.bodyname1, e.bodyname2} <= left])
    geoms = {geom.name for geom in spec.geoms}
    _delete_all(spec, [pair for pair in spec.pairs if not {pair.geomname1, pair.geomname2} <= geoms])
    return places_finding("scene-objects", names, "left out: they are not part of the robot")


def _carries_joints_or_sensors(body: mujoco.MjsBody, mounts: Collection[Mount]) -> bool:
    return any(
        any(joint.type in _SCALAR for joint in part.joints)
        or any(("site", site.name) in mounts for site in part.sites)
        or any(("geom", geom.name) in mounts for geom in part.geoms)
        for part in _subtree(body)
    )


def _is_free(body: mujoco.MjsBody) -> bool:
    return any(joint.type == mujoco.mjtJoint.mjJNT_FREE for joint in body.joints)


def _fix_base(spec: mujoco.MjSpec) -> list[Finding]:
    free = [joint for joint in spec.joints if joint.type == mujoco.mjtJoint.mjJNT_FREE]
    placed = [body for body in spec.bodies if body.mocap]
    for body in placed:
        body.mocap = False
    names = [*(joint.parent.name for joint in free), *(body.name for body in placed)]
    _delete_all(spec, free)
    return places_finding("free-base", names, "the base is fixed to the world")


def _split_ball_joints(spec: mujoco.MjSpec, source: str) -> list[Finding]:
    """Replace each ball joint by three hinges about x, y and z, in this order, each with its limit."""
    balls = [joint for joint in spec.joints if joint.type == mujoco.mjtJoint.mjJNT_BALL]
    taken = {joint.name for joint in spec.joints}
    names = list[str]()
    for ball in balls:
        body = ball.parent
        if list(body.joints)[-1].name != ball.name:
            remedy = "Replace it by hinge joints about three axes"
            place = f"joint {ball.name or '(unnamed)'}"
            raise RobotError("a ball joint must be the last of its body", file=source, place=place, remedy=remedy)
        names.append(ball.name or body.name)
        for axis, letter in enumerate("xyz"):
            name = next(name for name in _suffixed(f"{ball.name or body.name or 'ball'}_{letter}") if name not in taken)
            taken.add(name)
            hinge = body.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=np.eye(3)[axis], pos=ball.pos)
            for copied in _OF_BALL_JOINTS:
                setattr(hinge, copied, getattr(ball, copied))
            hinge.range = [-ball.range[1], ball.range[1]]
    _delete_all(spec, balls)
    return places_finding("ball-joint", names, "a ball joint: replaced by three hinges about x, y and z")


_OF_BALL_JOINTS = ("armature", "damping", "frictionloss", "limited", "group")


def _joins_links(equality: mujoco.MjsEquality) -> bool:
    """Whether a coupling is between joints or bodies and belongs to the robot; sites and tendons are deleted."""
    kind = mujoco.mjtEq
    obj = mujoco.mjtObj
    between_bodies = equality.type in (kind.mjEQ_CONNECT, kind.mjEQ_WELD) and equality.objtype == obj.mjOBJ_BODY
    return equality.type == kind.mjEQ_JOINT or between_bodies


def settle_missing_meshes(
    spec: mujoco.MjSpec, missing: Mapping[str, MissingMesh], files: ModelFiles
) -> tuple[list[Finding], dict[str, list[Mesh]]]:
    """Report the replacement of each missing mesh: the other shapes of its link, or else a small box.

    Also return the placeholders of meshes that are left out [m], by link and in its frame.

    Args:
        spec: Parsed; placeholders are deleted from links that have other shapes.
        missing: The missing files, by the name of their placeholder.
        files: Files of the model, among which the findings name similar ones.
    """
    if not missing:
        return [], {}
    placeholders = {mesh.name: mesh.file for mesh in spec.meshes if mesh.file in missing}
    shown: dict[str, tuple[list[str], bool]] = {}
    left_out: dict[str, list[Mesh]] = {}
    for body in spec.bodies:
        empty = [geom for geom in body.geoms if geom.meshname in placeholders]
        whole = len(empty) < len(list(body.geoms))
        for geom in empty:
            links, boxed = shown.get(placeholders[geom.meshname], ([], False))
            links = links if body.name in links else [*links, body.name]
            shown[placeholders[geom.meshname]] = (links, boxed or not whole)
        if whole and empty:
            left_out[body.name] = [_placeholder_at(spec, geom) for geom in empty]
            _delete_all(spec, empty)
    for mesh in spec.meshes:
        if mesh.name in placeholders:
            mesh.scale = [1.0, 1.0, 1.0]  # the box has its own size
    similar = files.similar_meshes([mesh.path for mesh in missing.values()])
    notes = [_missing_mesh(mesh, *shown.get(name, ([], False)), similar[mesh.path]) for name, mesh in missing.items()]
    return notes, left_out


def _placeholder_at(spec: mujoco.MjSpec, geom: mujoco.MjsGeom) -> Mesh:
    """Return the small box at the place of a geom [m], in the frame of its body."""
    box = box_mesh(PLACEHOLDER_SIZE)
    points = box.vertices
    element = geom
    while element is not None:  # the geom, then the frames around it
        turn = element.quat
        compiler = spec.compiler
        if element.alt.type != mujoco.mjtOrientation.mjORIENTATION_QUAT:
            turn = spec.resolve_orientation(compiler.degree, compiler.eulerseq, element.alt)
        points = points @ rotation_of(np.asarray(turn) / np.linalg.norm(turn)).T + element.pos
        element = element.frame
    return Mesh(points, box.faces)


def _missing_mesh(mesh: MissingMesh, links: list[str], boxed: bool, similar: Sequence[str]) -> Finding:
    of = f" (link {', '.join(link or '(unnamed)' for link in links)})" if links else ""
    what = "replaced by a small box" if boxed else "left out: the link has other shapes" if links else "unused"
    remedy = f"; {mesh.remedy}" if mesh.remedy else f"; similar files: {', '.join(similar)}" if similar else ""
    return Finding("missing-mesh", str(mesh.path), f"{mesh.reason}{of}; {what}{remedy}")


def missing_meshes(spec: mujoco.MjSpec, assets: Mapping[str, bytes]) -> dict[str, tuple[str, ...]]:
    """Return the bare names of missing mesh files by link, without links that have none.

    Placeholders are recognised by their bytes, also in a robot that was packed and unpacked.
    """
    absent = {mesh.name: Path(mesh.file).stem for mesh in spec.meshes if assets.get(mesh.file) == placeholder()}
    found = {
        body.name: tuple(dict.fromkeys(absent[geom.meshname] for geom in body.geoms if geom.meshname in absent))
        for body in spec.bodies
    }
    return {name: files for name, files in found.items() if files}


MAX_HULL_VERTICES = 5000
"""Vertices of a convex hull. The time to compute a hull grows with the square of their number where they are on a
circle: 50,000 take half a minute."""
_FLAT_ACTION = "too flat for a collision shape of its own; skin on it can be touched"
_FLAT = 1e-5  # thickness over size below which there is no convex hull
_INERTIA_MARGIN = 3e-5  # margin of the triangle inequality of inertias
_HOLLOW = 1e-6  # enclosed volume over that of the bounding box below which it carries no mass


def prepare_degenerate_meshes(spec: mujoco.MjSpec, assets: Mapping[str, bytes]) -> list[Finding]:
    """Compute the inertia of open sheets as shells, and disable collisions of flat meshes without hull (a Finding).

    Also limit convex hulls to ``MAX_HULL_VERTICES``.
    """
    flat = set[str]()
    for element in spec.meshes:
        if element.file not in assets:
            _limit_hull(element, len(element.uservert) // 3)
            continue
        mesh = parse_mesh(assets[element.file], Path(element.file), weld=False)
        _limit_hull(element, len(mesh.vertices))
        if _is_flat(mesh):
            flat.add(element.name)
        if element.name in flat or _is_hollow(mesh):
            element.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
    stopped = [geom for geom in spec.geoms if geom.meshname in flat and (geom.contype or geom.conaffinity)]
    for geom in stopped:
        geom.contype = geom.conaffinity = 0
    names = sorted({geom.meshname for geom in stopped})
    return places_finding("flat-mesh", names, _FLAT_ACTION, count=len(stopped))


def _limit_hull(element: mujoco.MjsMesh, vertices: int) -> None:
    if vertices > MAX_HULL_VERTICES and not 0 < element.maxhullvert <= MAX_HULL_VERTICES:
        element.maxhullvert = MAX_HULL_VERTICES


def limited_hulls(model: mujoco.MjModel) -> list[Finding]:
    """Report the meshes whose convex hull has ``MAX_HULL_VERTICES``."""
    names = [
        model.mesh(mesh).name
        for mesh in range(model.nmesh)
        if model.mesh_graphadr[mesh] >= 0 and model.mesh_graph[model.mesh_graphadr[mesh]] >= MAX_HULL_VERTICES
    ]
    note = f"collides as a convex hull of {MAX_HULL_VERTICES} vertices at most"
    return places_finding("hull-limited", names, note)


def enforce_inertia_inequality(spec: mujoco.MjSpec, model: mujoco.MjModel) -> None:
    """State the inertia of sheet-like bodies so that it remains valid when it is written with six digits.

    Principal moments must satisfy A + B >= C. A sheet has A + B = C, and rounding may violate the condition. Therefore
    C is reduced by a few parts in 100,000, less than the uncertainty of a robot's inertia.
    """
    for body in range(1, model.nbody):
        inertia = np.array(model.body_inertia[body])
        largest = int(inertia.argmax())
        bound = (1 - _INERTIA_MARGIN) * (inertia.sum() - inertia[largest])
        if 0 < bound < inertia[largest]:
            inertia[largest] = bound
            _state_inertia(spec, model, body, inertia)


def state_scaled_masses(spec: mujoco.MjSpec, model: mujoco.MjModel) -> None:
    """State the masses that the compiler's ``settotalmass`` scaled: MuJoCo before 3.17 would not write them."""
    if spec.compiler.settotalmass > 0:
        spec.compiler.settotalmass = -1.0
        for body in range(1, model.nbody):
            if model.body_mass[body] > 0:
                _state_inertia(spec, model, body, np.array(model.body_inertia[body]))


def _state_inertia(spec: mujoco.MjSpec, model: mujoco.MjModel, body: int, inertia: FloatArray) -> None:
    element = spec.body(model.body(body).name)
    element.explicitinertial = True
    element.mass = float(model.body_mass[body])
    element.ipos = model.body_ipos[body]
    element.iquat = model.body_iquat[body]
    element.inertia = inertia
    element.ialt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT
    element.fullinertia = np.full(6, np.nan)  # MuJoCo's mark for "not given"


def _is_flat(mesh: Mesh) -> bool:
    centred = mesh.vertices - mesh.vertices.mean(axis=0)
    spread = np.linalg.eigvalsh(centred.T @ centred)  # squared, so this resolves thickness down to about 1e-8
    return len(mesh.vertices) < 4 or bool(spread[0] < _FLAT**2 * spread[-1])


def _is_hollow(mesh: Mesh) -> bool:
    corners = (mesh.vertices - mesh.vertices.mean(axis=0))[mesh.faces]
    volume = abs(float(np.linalg.det(corners).sum())) / 6
    return volume < _HOLLOW * float(np.prod(np.ptp(mesh.vertices, axis=0)))


SAMPLED_POSTURES = 30
TOUCHING_SHARE = 0.5
MAX_NEAR_PAIRS = 20_000
"""Largest number of pairs of shapes near each other at rest; each is checked exactly in 31 postures."""
_ROWS = 500


def collision_exclusions(model: mujoco.MjModel, home: FloatArray) -> list[tuple[str, str]]:
    """Return the names of body pairs to exclude from collision, sorted.

    These are pairs that touch at home or in at least half of 30 random postures (the shells of iCub always overlap, and
    its simulation diverges otherwise), and the children of links fixed to the world, which MuJoCo's parent-child filter
    does not cover. Cost: 31 collision passes.

    Args:
        model: A compiled model with scalar joints only and names for all bodies.
        home: (nq,) the home posture.

    Raises:
        RobotError: Too many shapes are in the same place.
    """
    _check_crowding(model, mujoco.MjData(model), home)
    return overlapping_bodies(model, home)


def overlapping_bodies(model: mujoco.MjModel, home: FloatArray) -> list[tuple[str, str]]:
    """Return the pairs of ``collision_exclusions``, however many shapes are in the same place."""
    data = mujoco.MjData(model)
    counts: Counter[tuple[int, int]] = Counter()
    for posture in _random_postures(model):
        counts.update(touching_bodies(model, data, posture))
    pairs = {pair for pair, count in counts.items() if count >= TOUCHING_SHARE * SAMPLED_POSTURES}
    pairs |= touching_bodies(model, data, home) | _children_of_fixed_links(model)
    return _named(model, pairs)


def neighbours_of_fixed_links(model: mujoco.MjModel) -> list[tuple[str, str]]:
    """Return the pairs of a link fixed to the world and a moving link that it carries.

    They never collide, as all neighbours, whether or not they overlap.
    """
    return _named(model, _children_of_fixed_links(model))


def _named(model: mujoco.MjModel, pairs: Collection[tuple[int, int]]) -> list[tuple[str, str]]:
    return sorted((model.body(a).name, model.body(b).name) for a, b in pairs)


def _check_crowding(model: mujoco.MjModel, data: mujoco.MjData, home: FloatArray) -> None:
    """Raise an error if most shapes are inside each other; checks their bounding spheres before any collision."""
    data.qpos[:] = home
    mujoco.mj_kinematics(model, data)
    solid = np.flatnonzero((model.geom_contype | model.geom_conaffinity) != 0)
    centres = data.geom_xpos[solid]
    radii = model.geom_rbound[solid]
    bodies = model.body_weldid[model.geom_bodyid[solid]]
    near = 0
    for start in range(0, len(solid), _ROWS):
        rows = slice(start, start + _ROWS)
        squared = np.zeros((len(radii[rows]), len(solid)))
        for axis in range(3):
            squared += (centres[rows, axis, None] - centres[None, :, axis]) ** 2
        close = squared < (radii[rows, None] + radii[None, :]) ** 2
        near += int(np.count_nonzero(close & (bodies[rows, None] < bodies[None, :])))
        if near > MAX_NEAR_PAIRS:
            problem = "too many of the robot's shapes are inside each other"
            place = f"body {model.body(int(model.geom_bodyid[solid[start]])).name}"
            remedy = "Let only simple outer shapes collide, and disable collisions of the others (contype, conaffinity)"
            raise RobotError(problem, place=place, value=f"more than {MAX_NEAR_PAIRS} pairs", remedy=remedy)


def _random_postures(model: mujoco.MjModel) -> FloatArray:
    """Return uniform random postures (SAMPLED_POSTURES, nq) within the limits, or half a turn or half a metre."""
    span = np.where(model.jnt_type == mujoco.mjtJoint.mjJNT_SLIDE, 0.5, np.pi)
    limited = model.jnt_limited.astype(bool) & (np.ptp(model.jnt_range, axis=1) < 100 * span)
    lower = np.where(limited, model.jnt_range[:, 0], -span)
    upper = np.where(limited, model.jnt_range[:, 1], span)
    return np.random.default_rng(0).uniform(lower, upper, (SAMPLED_POSTURES, model.nq))


def touching_bodies(model: mujoco.MjModel, data: mujoco.MjData, posture: FloatArray) -> set[tuple[int, int]]:
    """Return the pairs of bodies with penetrating geoms at ``posture``, except pairs with the world."""
    data.qpos[:] = posture
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_collision(model, data)
    touching = data.contact.geom[data.contact.dist <= 0]
    bodies = np.sort(model.geom_bodyid[touching].reshape(-1, 2), axis=1)
    return {(int(a), int(b)) for a, b in bodies if 0 < a < b}


def _children_of_fixed_links(model: mujoco.MjModel) -> set[tuple[int, int]]:
    """Return the pairs of a moving body and its parent, if the parent is fixed to the world."""
    return {
        (int(parent), body)
        for body, parent in enumerate(model.body_parentid)
        if parent > 0 and model.body_weldid[body] != 0 and model.body_weldid[parent] == 0
    }
