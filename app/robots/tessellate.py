"""What a link looks like: its visual geoms, meshes and primitives alike, as one triangle mesh in the link frame."""

from __future__ import annotations

import mujoco
import numpy as np
import trimesh

from app.arrays import FloatArray, IntArray
from app.geometry.mesh import Mesh

_SPHERE_SUBDIVISIONS = 3
_SECTIONS = 48
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
    first, count = int(model.body_geomadr[body]), int(model.body_geomnum[body])
    every = list(range(first, first + count))
    shown = [geom for geom in every if model.geom_group[geom] <= _LAST_VISIBLE_GROUP and model.geom_rgba[geom, 3] > 0]
    visual = [geom for geom in shown if not (model.geom_contype[geom] or model.geom_conaffinity[geom])]
    return visual or shown or every


def geom_triangles(model: mujoco.MjModel, geom: int) -> tuple[FloatArray, IntArray]:
    """Vertices (n, 3) [m] in the body frame and faces (m, 3) of one geom; none of a plane or a height field."""
    vertices, faces = _local_triangles(model, geom)
    rotation = np.empty(9)
    mujoco.mju_quat2Mat(rotation, model.geom_quat[geom])
    return vertices @ rotation.reshape(3, 3).T + model.geom_pos[geom], faces


def _local_triangles(model: mujoco.MjModel, geom: int) -> tuple[FloatArray, IntArray]:
    shape = mujoco.mjtGeom
    kind, size = shape(int(model.geom_type[geom])), model.geom_size[geom]
    if kind == shape.mjGEOM_MESH:
        return _mesh_triangles(model, int(model.geom_dataid[geom]))
    if kind == shape.mjGEOM_BOX:
        solid = trimesh.creation.box(2 * size)
    elif kind == shape.mjGEOM_CYLINDER:
        solid = trimesh.creation.cylinder(size[0], 2 * size[1], sections=_SECTIONS)
    elif kind == shape.mjGEOM_CAPSULE:
        solid = trimesh.creation.capsule(2 * size[1], size[0], count=[_SECTIONS, _SECTIONS])
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
