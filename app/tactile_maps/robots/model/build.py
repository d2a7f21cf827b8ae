"""Last step of every import: a spec becomes a robot that can be simulated.

``build_robot`` strips the spec, checks its numbers, compiles it, creates the meshes of its links and simulates it.
``link_mesh`` returns the visible shape of a link as one mesh. ``check_magnitudes`` and ``smoke_test`` reject robots
that cannot be simulated.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import mujoco
import numpy as np

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.core.errors import Finding, RobotError, errors_in_file, places_finding
from tactile_maps.geometry.surface.mesh import Mesh, join_meshes
from tactile_maps.robots.files.mesh_files import MAX_FACES
from tactile_maps.robots.files.model_limits import LARGEST_MAGNITUDE, MAX_BODIES
from tactile_maps.robots.model.home_posture import choose_home
from tactile_maps.robots.model.joint_limits import DriveLimits, limit_efforts
from tactile_maps.robots.model.mujoco_spec import (
    TOUCHING,
    check_names,
    compile_spec,
    mujoco_errors,
    parse_spec,
    rotation_of,
    spec_text,
)
from tactile_maps.robots.model.mujoco_warnings import collect_warnings, warning_findings
from tactile_maps.robots.model.proportions import oversized_meshes, ranges_in_degrees
from tactile_maps.robots.model.robot import Joint, Link, Robot
from tactile_maps.robots.model.sanitize import (
    Mount,
    collision_exclusions,
    enforce_inertia_inequality,
    keyframe_home,
    limited_hulls,
    missing_meshes,
    name_unnamed_elements,
    neighbours_of_fixed_links,
    prepare_degenerate_meshes,
    state_scaled_masses,
    strip_scene,
)

_SPHERE_SUBDIVISIONS = 3
_CIRCLE_SECTIONS = 48
_LAST_VISIBLE_GROUP = 2  # MuJoCo's viewers hide groups from 3 on, which contain collision geoms


def link_mesh(model: mujoco.MjModel, body: int) -> Mesh | None:
    """Return the union of a body's visual geoms in the body frame [m], or of its collision geoms if none is visual.

    Args:
        model: A compiled model.
        body: Number of the body.

    Returns:
        The mesh; None for a body without shape.
    """
    parts = [geom_triangles(model, geom) for geom in _shown_geoms(model, body)]
    meshes = [Mesh(vertices, faces) for vertices, faces in parts if len(faces)]
    return join_meshes(meshes) if meshes else None


def _shown_geoms(model: mujoco.MjModel, body: int) -> list[int]:
    first = int(model.body_geomadr[body])
    count = int(model.body_geomnum[body])
    every = list(range(first, first + count))
    shown = [geom for geom in every if model.geom_group[geom] <= _LAST_VISIBLE_GROUP and model.geom_rgba[geom, 3] > 0]
    visual = [geom for geom in shown if not (model.geom_contype[geom] or model.geom_conaffinity[geom])]
    return visual or shown or every


def _check_drawn_faces(model: mujoco.MjModel, source: str) -> None:
    """Limit the triangles of all links; each use of a mesh counts, because it is a copy.

    Raises:
        RobotError: There are more than ``MAX_FACES``; the link with the most is named.
    """
    counts = [sum(_mesh_faces(model, geom) for geom in _shown_geoms(model, body)) for body in range(1, model.nbody)]
    if sum(counts) > MAX_FACES:
        problem = "the shapes of its links have more than 5 million triangles together, each use of a mesh counted"
        place = f"link {model.body(1 + int(np.argmax(counts))).name}"
        remedy = "Simplify the meshes or use them less often"
        raise RobotError(problem, file=source, place=place, value=sum(counts), remedy=remedy)


def _mesh_faces(model: mujoco.MjModel, geom: int) -> int:
    is_mesh = model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_MESH
    return int(model.mesh_facenum[model.geom_dataid[geom]]) if is_mesh else 0


def geom_triangles(model: mujoco.MjModel, geom: int) -> tuple[FloatArray, IntArray]:
    """Return vertices (n, 3) [m] in the body frame and faces (m, 3) of a geom; none for planes and height fields."""
    vertices, faces = _local_triangles(model, geom)
    return vertices @ rotation_of(model.geom_quat[geom]).T + model.geom_pos[geom], faces


def _local_triangles(model: mujoco.MjModel, geom: int) -> tuple[FloatArray, IntArray]:
    shape = mujoco.mjtGeom
    kind = shape(int(model.geom_type[geom]))
    size = model.geom_size[geom]
    if kind == shape.mjGEOM_MESH:
        return _mesh_triangles(model, int(model.geom_dataid[geom]))
    import trimesh  # 0.1 s, not needed for robots of meshes

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
    else:  # planes and height fields belong to the scene
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
    """Raise RobotError for a body with a position or size that is not finite or above ``LARGEST_MAGNITUDE``."""
    sizes = np.zeros((model.nbody, 3))
    np.maximum.at(sizes, model.geom_bodyid, np.abs(model.geom_size))
    np.maximum.at(sizes, model.geom_bodyid, np.abs(model.geom_pos))
    numbers = np.hstack([sizes, model.body_pos, model.body_quat, model.body_mass[:, None], model.body_inertia])
    bad = np.flatnonzero(~(np.abs(numbers) < LARGEST_MAGNITUDE).all(axis=1))
    if bad.size:
        row = numbers[bad[0]]
        worst = float(row[np.argmin(np.abs(row) < LARGEST_MAGNITUDE)])
        place = f"body {model.body(int(bad[0])).name}"
        raise RobotError(
            "a position, size, mass or inertia is implausibly large", file=source, place=place, value=worst
        )


def smoke_test(model: mujoco.MjModel, home: FloatArray, source: str) -> list[Finding]:
    """Simulate 20 steps of 1 ms from rest; raise RobotError if they fail. Changes the model's options.

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
    """Strip, check, compile and simulate a spec, which cannot be used afterwards.

    Args:
        spec: A parsed spec whose files are bare names in ``assets``.
        name: Short name for the user.
        source: Path or library name, for errors.
        assets: File contents by bare name.
        findings: Findings of the reader.
        home: Joint values by joint name [rad, m], which replace those of a keyframe; other joints are at zero.
        mounts: Elements that sensors are fixed to.
        left_out: Placeholders of missing meshes that are left out [m], by link and in its frame.
        drives: Speed and effort limits by joint name, as its file states them.

    Raises:
        RobotError: The robot has no links, joints that are not scalar, too many bodies or a reserved name, or its
            simulation is unstable.
    """
    if len(spec.bodies) > MAX_BODIES:
        raise RobotError(f"the robot has more than {MAX_BODIES} bodies", file=source, value=len(spec.bodies))
    check_names(spec, source=source)
    with mujoco_errors("build", source=source), errors_in_file(source):
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
    first = _first_model(spec, source, notes)
    with errors_in_file(source):
        if not requested:
            requested, chosen = _choose_home(first, source)
            notes += chosen
        notes += _exclude_touching(spec, first, _home(first, requested)[0])
    text = spec_text(spec, source=source)
    model = compile_spec(parse_spec(text, files, source=source), source=source)
    _check_drawn_faces(model, source)
    rest, clipped = _home(model, requested)
    notes += places_finding("home-outside-limits", clipped, "moved inside the limits")
    notes += smoke_test(model, rest, source)
    links = _links(model, missing_meshes(spec, files), left_out or {})
    return Robot(name, source, text, files, links, _joints(model, drives or {}), rest, tuple(notes))


def _first_model(spec: mujoco.MjSpec, source: str, notes: list[Finding]) -> mujoco.MjModel:
    """Compile the spec, check the numbers of the model, add findings to ``notes``, and state its masses in the spec."""
    model = _compile_with_masses(spec, source, notes)
    check_magnitudes(model, source)
    notes += [*limited_hulls(model), *oversized_meshes(model), *ranges_in_degrees(model)]
    state_scaled_masses(spec, model)
    enforce_inertia_inequality(spec, model)
    return model


def _links(
    model: mujoco.MjModel, missing: Mapping[str, tuple[str, ...]], left_out: Mapping[str, Sequence[Mesh]]
) -> tuple[Link, ...]:
    """Return the links: all bodies except the world."""
    names = [model.body(i).name for i in range(model.nbody)]
    return tuple(
        Link(name, link_mesh(model, i), missing.get(name, ()), tuple(left_out.get(name, ())))
        for i, name in enumerate(names)
        if i
    )


def _choose_home(model: mujoco.MjModel, source: str) -> tuple[dict[str, float], list[Finding]]:
    """Return joint values by name if the posture at zero is not suitable, and the finding that reports it."""
    rest = _home(model, {})[0]
    _check_drawn_faces(model, source)
    meshes = {body: mesh for body in range(1, model.nbody) if (mesh := link_mesh(model, body)) is not None}
    home, notes = choose_home(model, rest, meshes)
    return {model.joint(i).name: float(home[i]) for i in range(model.njnt)}, notes


_LEAST_MASS = 1e-6  # kg
_LEAST_INERTIA = 1e-6  # kg m²


def _compile_with_masses(spec: mujoco.MjSpec, source: str, notes: list[Finding]) -> mujoco.MjModel:
    """Compile the spec; if a moving body has no mass, set a minimum for all bodies."""
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
    neighbours = neighbours_of_fixed_links(model)
    named = [f"{first}-{second}" for first, second in pairs if (first, second) not in neighbours]
    note = "overlapping at home or in half of 30 random postures: collision disabled for these pairs of links"
    return places_finding("touching-links", named, note)


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
    """Return the home posture, and the joints whose requested value was outside their limits."""
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
