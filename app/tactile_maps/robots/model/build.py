"""The last stretch of every import: a spec of anything becomes a robot alone that is known to run.

``build_robot`` strips the spec, checks its numbers, compiles it, draws its links and tries it out. ``link_mesh`` says
what a link looks like: its visual geoms, meshes and primitives alike, as one triangle mesh in the link frame.
``check_magnitudes`` and ``smoke_test`` prove that a robot is fit to simulate, before anybody sees it.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import mujoco
import numpy as np

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.core.errors import Finding, RobotError, errors_in_file
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.robots.files.mesh_files import MAX_FACES
from tactile_maps.robots.files.model_limits import LARGEST_MAGNITUDE, MAX_BODIES
from tactile_maps.robots.files.sanitize import (
    Mount,
    collision_exclusions,
    enforce_inertia_inequality,
    keyframe_home,
    limited_hulls,
    missing_meshes,
    name_unnamed_elements,
    prepare_degenerate_meshes,
    state_scaled_masses,
    strip_scene,
)
from tactile_maps.robots.model.home_posture import choose_home
from tactile_maps.robots.model.joint_limits import DriveLimits, limit_efforts
from tactile_maps.robots.model.mujoco_spec import (
    TOUCHING,
    check_names,
    compile_spec,
    editing_spec,
    parse_spec,
    spec_text,
)
from tactile_maps.robots.model.mujoco_warnings import collect_warnings, warning_findings
from tactile_maps.robots.model.robot import Joint, Link, Robot

_SPHERE_SUBDIVISIONS = 3
_CIRCLE_SECTIONS = 48
_LAST_VISIBLE_GROUP = 2  # MuJoCo's viewers hide groups from 3 on; robots keep their collision geoms there


def link_mesh(model: mujoco.MjModel, body: int) -> Mesh | None:
    """The union of a body's visual geoms in the body frame [m]; of its collision geoms where none is visual.

    Args:
        model: A compiled model.
        body: The body's number.

    Returns:
        The mesh, or None for a body without any shape.
    """
    parts = [geom_triangles(model, geom) for geom in _shown_geoms(model, body)]
    parts = [(vertices, faces) for vertices, faces in parts if len(faces)]
    if not parts:
        return None
    starts = np.cumsum([0] + [len(vertices) for vertices, _ in parts])
    faces = np.concatenate([f + start for (_, f), start in zip(parts, starts[:-1], strict=True)])
    return Mesh(np.concatenate([vertices for vertices, _ in parts]), faces)


def _shown_geoms(model: mujoco.MjModel, body: int) -> list[int]:
    first = int(model.body_geomadr[body])
    count = int(model.body_geomnum[body])
    every = list(range(first, first + count))
    shown = [geom for geom in every if model.geom_group[geom] <= _LAST_VISIBLE_GROUP and model.geom_rgba[geom, 3] > 0]
    visual = [geom for geom in shown if not (model.geom_contype[geom] or model.geom_conaffinity[geom])]
    return visual or shown or every


def _check_drawn_faces(model: mujoco.MjModel, source: str) -> None:
    """Bound the triangles of all links: each use of a mesh is a copy.

    Raises:
        RobotError: They are more than ``MAX_FACES``; the link with the most is named.
    """
    counts = [sum(_mesh_faces(model, geom) for geom in _shown_geoms(model, body)) for body in range(1, model.nbody)]
    if sum(counts) > MAX_FACES:
        problem = "the shapes of its links have more than 5 million triangles together, each use of a mesh counted"
        raise RobotError(
            problem,
            file=source,
            place=f"link {model.body(1 + int(np.argmax(counts))).name}",
            value=sum(counts),
            remedy="Simplify the meshes or use them less often",
        )


def _mesh_faces(model: mujoco.MjModel, geom: int) -> int:
    is_mesh = model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_MESH
    return int(model.mesh_facenum[model.geom_dataid[geom]]) if is_mesh else 0


def geom_triangles(model: mujoco.MjModel, geom: int) -> tuple[FloatArray, IntArray]:
    """Vertices (n, 3) [m] in the body frame and faces (m, 3) of one geom; none of a plane or a height field."""
    vertices, faces = _local_triangles(model, geom)
    rotation = np.empty(9)
    mujoco.mju_quat2Mat(rotation, model.geom_quat[geom])
    return vertices @ rotation.reshape(3, 3).T + model.geom_pos[geom], faces


def _local_triangles(model: mujoco.MjModel, geom: int) -> tuple[FloatArray, IntArray]:
    shape = mujoco.mjtGeom
    kind = shape(int(model.geom_type[geom]))
    size = model.geom_size[geom]
    if kind == shape.mjGEOM_MESH:
        return _mesh_triangles(model, int(model.geom_dataid[geom]))
    import trimesh  # 0.1 s, and a robot of meshes needs none

    if kind == shape.mjGEOM_BOX:
        solid = trimesh.creation.box(2 * size)
    elif kind == shape.mjGEOM_CYLINDER:
        solid = trimesh.creation.cylinder(size[0], 2 * size[1], sections=_CIRCLE_SECTIONS)
    elif kind == shape.mjGEOM_CAPSULE:
        solid = trimesh.creation.capsule(2 * size[1], size[0], count=[_CIRCLE_SECTIONS, _CIRCLE_SECTIONS])
        solid.apply_translation([0, 0, -solid.bounds.mean(axis=0)[2]])
    elif kind in (shape.mjGEOM_SPHERE, shape.mjGEOM_ELLIPSOID):
        solid = trimesh.creation.icosphere(_SPHERE_SUBDIVISIONS)
        solid.apply_scale(size if kind == shape.mjGEOM_ELLIPSOID else size[0])
    else:  # planes and height fields are scenery
        return np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)
    return np.asarray(solid.vertices), np.asarray(solid.faces, dtype=np.int64)


def _mesh_triangles(model: mujoco.MjModel, mesh: int) -> tuple[FloatArray, IntArray]:
    vertices = model.mesh_vert[model.mesh_vertadr[mesh] :][: model.mesh_vertnum[mesh]]
    faces = model.mesh_face[model.mesh_faceadr[mesh] :][: model.mesh_facenum[mesh]]
    return vertices.astype(np.float64), faces.astype(np.int64)


SMOKE_TEST_STEPS = 20
_TROUBLES = (mujoco.mjtWarning.mjWARN_BADQPOS, mujoco.mjtWarning.mjWARN_BADQVEL, mujoco.mjtWarning.mjWARN_BADQACC)
_REMEDY = "Check masses, inertias and joint damping in the file"


def check_magnitudes(model: mujoco.MjModel, source: str) -> None:
    """Raise RobotError, naming the body, where a place or a size is not finite or beyond ``LARGEST_MAGNITUDE``."""
    sizes = np.zeros((model.nbody, 3))
    np.maximum.at(sizes, model.geom_bodyid, np.abs(model.geom_size))
    np.maximum.at(sizes, model.geom_bodyid, np.abs(model.geom_pos))
    numbers = np.hstack([sizes, model.body_pos, model.body_quat, model.body_mass[:, None], model.body_inertia])
    bad = np.flatnonzero(~(np.abs(numbers) < LARGEST_MAGNITUDE).all(axis=1))
    if bad.size:
        row = numbers[bad[0]]
        worst = float(row[np.argmin(np.abs(row) < LARGEST_MAGNITUDE)])
        place = f"body {model.body(int(bad[0])).name}"
        raise RobotError("a place, size, mass or inertia is implausibly large", file=source, place=place, value=worst)


def smoke_test(model: mujoco.MjModel, home: FloatArray, source: str) -> list[Finding]:
    """Step the robot from rest; raise RobotError if it cannot take 20 steps of 1 ms. Changes the model's options.

    Returns:
        MuJoCo's warnings of a robot that remains stable.
    """
    data = mujoco.MjData(model)
    data.qpos[:] = home
    model.opt.timestep = 1e-3
    model.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    with collect_warnings() as texts:
        mujoco.mj_step(model, data, SMOKE_TEST_STEPS)
    if not np.isfinite(data.qpos).all() or any(data.warning[int(trouble)].number for trouble in _TROUBLES):
        value = texts[0] if texts else None
        raise RobotError("the simulation of the robot is unstable", file=source, value=value, remedy=_REMEDY)
    return warning_findings(texts, source=source)


def build_robot(
    spec: mujoco.MjSpec,
    *,
    name: str,
    source: str,
    assets: Mapping[str, bytes],
    findings: Sequence[Finding] = (),
    home: Mapping[str, float] | None = None,
    mounts: Collection[Mount] = (),
    left_out: Mapping[str, Sequence[Mesh]] | None = None,
    drives: Mapping[str, DriveLimits] | None = None,
) -> Robot:
    """Strip, check, compile and try out a spec; it is used up.

    Args:
        spec: A parsed spec whose files are bare names in ``assets``.
        name: A short name for people.
        source: Path or library name, for errors.
        assets: File contents by bare name.
        findings: What the reader noticed already.
        home: Joint values by joint name [rad, m], before those of a keyframe; others rest at zero.
        mounts: Elements that sensors are fixed to.
        left_out: Placeholders of missing meshes that are left out [m], by link and in its frame.
        drives: Speed and effort limits by joint name, as its file states them.

    Raises:
        RobotError: The robot has no links, joints that are not scalar, too many bodies, a name that is kept for what is
            added to it, or does not simulate.
    """
    if len(spec.bodies) > MAX_BODIES:
        raise RobotError(f"the robot has more than {MAX_BODIES} bodies", file=source, value=len(spec.bodies))
    check_names(spec, source=source)
    with editing_spec(source=source), errors_in_file(source):
        requested = {**keyframe_home(spec), **(home or {})}
        notes = [
            *findings,
            *strip_scene(spec, source, mounts),
            *name_unnamed_elements(spec),
            *prepare_degenerate_meshes(spec, assets),
        ]
        limit_efforts(spec.joints, drives or {})
    used = {mesh.file for mesh in spec.meshes}
    files = {file: content for file, content in assets.items() if file in used}
    first = _compile_with_masses(spec, source, notes)
    check_magnitudes(first, source)
    notes += limited_hulls(first)
    state_scaled_masses(spec, first)
    enforce_inertia_inequality(spec, first)
    with errors_in_file(source):
        if not requested:
            requested, chosen = _choose_home(first, source)
            notes += chosen
        notes += _exclude_touching(spec, first, _home(first, requested)[0])
    text = spec_text(spec, source=source)
    model = compile_spec(parse_spec(text, files, source=source), source=source)
    _check_drawn_faces(model, source)
    rest, clipped = _home(model, requested)
    if clipped:
        notes.append(Finding("home-outside-limits", ", ".join(clipped), "moved inside the limits", len(clipped)))
    notes += smoke_test(model, rest, source)
    missing = missing_meshes(spec, files)
    names = [model.body(i).name for i in range(model.nbody)]
    links = tuple(
        Link(name, link_mesh(model, i), missing.get(name, ()), tuple((left_out or {}).get(name, ())))
        for i, name in enumerate(names)
        if i  # without the world
    )
    return Robot(name, source, text, files, links, _joints(model, drives or {}), rest, tuple(notes))


def _choose_home(model: mujoco.MjModel, source: str) -> tuple[dict[str, float], list[Finding]]:
    """Return joint values by name where the posture at zero is not suitable, and the finding that reports it."""
    rest = _home(model, {})[0]
    _check_drawn_faces(model, source)
    meshes = {body: mesh for body in range(1, model.nbody) if (mesh := link_mesh(model, body)) is not None}
    home, notes = choose_home(model, rest, meshes)
    return {model.joint(i).name: float(home[i]) for i in range(model.njnt)}, notes


# kg, kg m²
_LEAST_MASS = 1e-6
_LEAST_INERTIA = 1e-6


def _compile_with_masses(spec: mujoco.MjSpec, source: str, notes: list[Finding]) -> mujoco.MjModel:
    """Compile; where a moving body has no mass, each gets a little."""
    try:
        return compile_spec(spec, source=source, findings=notes)
    except RobotError as error:
        if "mjMINVAL" not in str(error.value):
            raise
    spec.compiler.boundmass = _LEAST_MASS
    spec.compiler.boundinertia = _LEAST_INERTIA
    what = f"a moving body had none: each has at least {_LEAST_MASS} kg and {_LEAST_INERTIA} kg m²"
    notes.append(Finding("massless", source, what))
    return compile_spec(spec, source=source, findings=notes)


def _exclude_touching(spec: mujoco.MjSpec, model: mujoco.MjModel, home: FloatArray) -> list[Finding]:
    known = {frozenset((exclude.bodyname1, exclude.bodyname2)) for exclude in spec.excludes}
    pairs = [pair for pair in collision_exclusions(model, home) if frozenset(pair) not in known]
    for first, second in pairs:
        spec.add_exclude(name=f"{TOUCHING}{first} {second}", bodyname1=first, bodyname2=second)
    if not pairs:
        return []
    named = ", ".join(f"{first}-{second}" for first, second in pairs[:5]) + (", …" if len(pairs) > 5 else "")
    return [
        Finding("touching-links", named, "overlapping at home: collision disabled for these pairs of links", len(pairs))
    ]


def _joints(model: mujoco.MjModel, drives: Mapping[str, DriveLimits]) -> tuple[Joint, ...]:
    slide = mujoco.mjtJoint.mjJNT_SLIDE
    lower, upper = _limits(model)
    efforts = np.where(model.jnt_actfrclimited.astype(bool), model.jnt_actfrcrange[:, 1], np.inf)
    names = [model.joint(i).name for i in range(model.njnt)]
    return tuple(
        Joint(
            name,
            float(lower[i]),
            float(upper[i]),
            slide=bool(model.jnt_type[i] == slide),
            max_speed=drives[name].speed if name in drives else np.inf,
            max_effort=float(efforts[i]),
        )
        for i, name in enumerate(names)
    )


def _limits(model: mujoco.MjModel) -> tuple[FloatArray, FloatArray]:
    limited = model.jnt_limited.astype(bool)
    return np.where(limited, model.jnt_range[:, 0], -np.inf), np.where(limited, model.jnt_range[:, 1], np.inf)


def _home(model: mujoco.MjModel, requested: Mapping[str, float]) -> tuple[FloatArray, list[str]]:
    """The posture at rest, and the joints whose wanted value lay outside their limits."""
    lower, upper = _limits(model)
    names = [model.joint(i).name for i in range(model.njnt)]
    home = model.qpos0.copy()
    outside = (home < lower) | (home > upper)
    home[outside] = 0.5 * (lower[outside] + upper[outside])
    targets = np.array([requested.get(name, rest) for name, rest in zip(names, home, strict=True)])
    finite = np.isfinite(targets)
    inside = np.where(finite, np.clip(targets, lower, upper), home)
    moved = ~finite | ~np.isclose(inside, targets, rtol=0, atol=1e-5)
    return inside, [names[i] for i in np.flatnonzero(moved)]
