"""The solid shapes of a compiled model's geoms, as the contact models want them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from scipy.spatial import ConvexHull

from app.arrays import FloatArray
from app.geometry.mesh import Mesh
from app.geometry.pose import Pose
from app.geometry.topology import is_closed_manifold
from app.robots.tessellate import geom_triangles
from app.scene.objects import Body
from app.simulation.object_geoms import body_name, has_body, slab_name
from app.touch.mesh_shape import MeshShape
from app.touch.shapes import Ball, Box, Cylinder, Plane, Shape


@dataclass(frozen=True, eq=False)
class Solid:
    """One geom as a body that presses.

    Attributes:
        geom: Its number in the model.
        body: The number of the body it belongs to.
        shape: In its own frame.
        pose: ``T_body_shape``.
        by: Whose it is, for people.
    """

    geom: int
    body: int
    shape: Shape
    pose: Pose
    by: str

    def seen_from(self, data: mujoco.MjData, body: int) -> Pose:
        """``T_body_shape`` from another body's frame, at the state of ``data``."""
        base, turn = data.xmat[body].reshape(3, 3), data.xmat[self.body].reshape(3, 3)
        place = turn @ self.pose.translation + data.xpos[self.body]
        return Pose(base.T @ turn @ self.pose.rotation, (place - data.xpos[body]) @ base)


class Solids:
    """The solids of one model by geom, each made when first asked for.

    A mesh object is its true mesh if that is closed; every other shape that is not a ball, a box, a cylinder or a plane
    is the convex hull of its vertices, which is what MuJoCo collides.

    Args:
        model: The compiled model.
        objects: All of the scene's.
    """

    def __init__(self, model: mujoco.MjModel, objects: Sequence[Body]) -> None:
        self._model = model
        self._known: dict[int, Solid] = {}
        for thing in objects:
            if has_body(model, thing.spec):
                self._learn(thing)

    def __getitem__(self, geom: int) -> Solid:
        """The solid of a geom."""
        if geom not in self._known:
            model, body = self._model, int(self._model.geom_bodyid[geom])
            shape, pose = _geom_shape(model, geom)
            self._known[geom] = Solid(geom, body, shape, pose, model.body(body).name)
        return self._known[geom]

    def _learn(self, thing: Body) -> None:
        """Objects are about their body's own frame."""
        name = body_name(thing.spec)
        geom, body = int(self._model.geom(name).id), int(self._model.body(name).id)
        shape: Shape
        if thing.spec.kind == "mesh":
            solid = thing.mesh if is_closed_manifold(thing.mesh.faces) else _hull(thing.mesh.vertices)
            shape = MeshShape(solid, where=thing.spec.file)
        elif thing.spec.kind == "plane":
            shape = Plane()
            slab = int(self._model.geom(slab_name(thing.spec)).id)
            self._known[slab] = Solid(slab, body, shape, Pose.identity(), thing.spec.name)
        else:
            shape, _ = _geom_shape(self._model, geom)
        self._known[geom] = Solid(geom, body, shape, Pose.identity(), thing.spec.name)


def _geom_shape(model: mujoco.MjModel, geom: int) -> tuple[Shape, Pose]:
    """A geom's shape and ``T_body_shape``."""
    kind, size = mujoco.mjtGeom(int(model.geom_type[geom])), [float(length) for length in model.geom_size[geom]]
    rotation = np.empty(9)
    mujoco.mju_quat2Mat(rotation, model.geom_quat[geom])
    pose = Pose(rotation.reshape(3, 3), model.geom_pos[geom])
    if kind == mujoco.mjtGeom.mjGEOM_SPHERE:
        return Ball(size[0]), pose
    if kind == mujoco.mjtGeom.mjGEOM_BOX:
        return Box((size[0], size[1], size[2])), pose
    if kind == mujoco.mjtGeom.mjGEOM_CYLINDER:
        return Cylinder(size[0], size[1]), pose
    vertices, _ = geom_triangles(model, geom)
    return MeshShape(_hull(vertices), where=model.geom(geom).name), Pose.identity()


def _hull(points: FloatArray) -> Mesh:
    """The convex hull of ``points`` (n, 3), turned outward."""
    hull = ConvexHull(points)
    corners = points[hull.simplices]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inward = np.einsum("ij,ij->i", normals, hull.equations[:, :3]) < 0
    faces = np.where(inward[:, None], hull.simplices[:, ::-1], hull.simplices)
    used, renumbered = np.unique(faces, return_inverse=True)
    return Mesh(points[used], renumbered.reshape(-1, 3))
