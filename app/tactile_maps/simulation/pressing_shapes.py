"""Solid shapes of the geoms of a compiled model, and pairs of link and body that may touch.

``Solids`` returns the shape of a geom. ``contact_candidates`` lists the pairs of a link with skin and a body for the
elastic foundation, which computes the contact force itself instead of the solver.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import mujoco
import numpy as np
from scipy.spatial import ConvexHull

from tactile_maps.core.arrays import FloatArray
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.geometry.surface.pose import Pose
from tactile_maps.robots.model.build import geom_triangles
from tactile_maps.robots.model.robot import Robot
from tactile_maps.scene.effects import Effects
from tactile_maps.scene.objects import SceneObject
from tactile_maps.simulation.model.contact_pairs import allows_self_contact
from tactile_maps.simulation.model.model_names import body_name
from tactile_maps.simulation.model.object_geoms import has_body
from tactile_maps.skin.collision_shapes import excluded_pairs
from tactile_maps.skin.link_hulls import hull_name
from tactile_maps.skin.link_pieces import PIECE_DEPTH, link_pieces
from tactile_maps.skin.model.skin import Skin
from tactile_maps.tactile.mechanics.loads import Box, Cylinder, LayerShape, MeshShape, Plane, Shape, Sphere
from tactile_maps.tactile.models.foundation import ContactCandidate


@dataclass(frozen=True, eq=False)
class Solid:
    """A geom as a body that can press the skin.

    Attributes:
        body: Number of its body.
        shape: Shape in its own frame.
        pose: ``T_body_shape``.
        by: Displayed name of the object or link.
    """

    body: int
    shape: Shape
    pose: Pose
    by: str

    def seen_from(self, data: mujoco.MjData, body: int) -> Pose:
        """Pose of the shape in the frame of another body, at the state of ``data``."""
        base = data.xmat[body].reshape(3, 3)
        turn = data.xmat[self.body].reshape(3, 3)
        place = turn @ self.pose.translation + data.xpos[self.body]
        return Pose(base.T @ turn @ self.pose.rotation, (place - data.xpos[body]) @ base)


class Solids:
    """Solids of one model by geom, created on first use.

    A mesh object is its own mesh if that is closed. Every other shape that is not a ball, box, cylinder or plane is the
    convex hull of its vertices, which is also MuJoCo's collision shape.

    Args:
        model: The compiled model.
        objects: All objects of the scene.
    """

    def __init__(self, model: mujoco.MjModel, objects: Sequence[SceneObject]) -> None:
        self._model = model
        self._known: dict[int, Solid] = {}
        for scene_object in objects:
            if has_body(model, scene_object.spec):
                self._learn(scene_object)

    def __getitem__(self, geom: int) -> Solid:
        """Return the solid of a geom."""
        if geom not in self._known:
            model = self._model
            body = int(self._model.geom_bodyid[geom])
            shape, pose = _geom_shape(model, geom)
            self._known[geom] = Solid(body, shape, pose, model.body(body).name)
        return self._known[geom]

    def _learn(self, scene_object: SceneObject) -> None:
        """Add an object, whose shape is in the frame of its body."""
        name = body_name(scene_object.spec)
        geom = int(self._model.geom(name).id)
        body = int(self._model.body(name).id)
        shape: Shape
        if scene_object.spec.kind == "mesh":
            solid = (
                scene_object.mesh
                if scene_object.mesh.connectivity.is_closed_manifold
                else _hull(scene_object.mesh.vertices)
            )
            shape = MeshShape(solid, where=scene_object.spec.file)
        elif scene_object.spec.kind == "plane":
            shape = Plane()
        else:
            shape, _ = _geom_shape(self._model, geom)
        self._known[geom] = Solid(body, shape, Pose.identity(), scene_object.spec.name)


def _geom_shape(model: mujoco.MjModel, geom: int) -> tuple[Shape, Pose]:
    """Return the shape of a geom and ``T_body_shape``."""
    kind = mujoco.mjtGeom(int(model.geom_type[geom]))
    size = [float(length) for length in model.geom_size[geom]]
    rotation = np.empty(9)
    mujoco.mju_quat2Mat(rotation, model.geom_quat[geom])
    pose = Pose(rotation.reshape(3, 3), model.geom_pos[geom])
    if kind == mujoco.mjtGeom.mjGEOM_SPHERE:
        return Sphere(size[0]), pose
    if kind == mujoco.mjtGeom.mjGEOM_BOX:
        return Box((size[0], size[1], size[2])), pose
    if kind == mujoco.mjtGeom.mjGEOM_CYLINDER:
        return Cylinder(size[0], size[1]), pose
    vertices, _ = geom_triangles(model, geom)
    return MeshShape(_hull(vertices), where=model.geom(geom).name), Pose.identity()


def _hull(points: FloatArray) -> Mesh:
    """Return the convex hull of ``points`` (n, 3) with faces that point outward."""
    hull = ConvexHull(points)
    corners = points[hull.simplices]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inward = np.einsum("ij,ij->i", normals, hull.equations[:, :3]) < 0
    faces = np.where(inward[:, None], hull.simplices[:, ::-1], hull.simplices)
    used, renumbered = np.unique(faces, return_inverse=True)
    return Mesh(points[used], renumbered.reshape(-1, 3))


def contact_candidates(
    model: mujoco.MjModel, robot: Robot, skin: Skin, effects: Effects, objects: Sequence[SceneObject]
) -> tuple[ContactCandidate, ...]:
    """Return pairs of a link with skin and an object, and pairs of links, that may touch.

    Args:
        model: The compiled model.
        robot: The robot.
        skin: Its skin.
        effects: Effects, which determine the contacts.
        objects: Objects in the model.

    Raises:
        MeshError: A mesh object is not a solid.
    """
    solids = Solids(model, objects)
    links = skin.links
    things = [solids[int(model.geom(body_name(scene_object.spec)).id)] for scene_object in objects]
    outside = [_candidate(link, scene_object) for link in links for scene_object in things]
    if not allows_self_contact(effects):
        return tuple(outside)
    apart = excluded_pairs(robot, skin)
    shapes = {link: _link_solid(solids[int(model.geom(hull_name(link)).id)], robot, skin, link) for link in links}
    both = [(a, b) for a, b in combinations(links, 2) if frozenset((a, b)) not in apart]
    bare = [solids[geom] for geom in _bare_geoms(model, robot, links)]
    return (
        *outside,
        *(_candidate(first, shapes[second], own=shapes[first]) for first, second in both),
        *(_candidate(link, solid) for link in links for solid in bare if frozenset((link, solid.by)) not in apart),
    )


def _link_solid(hull: Solid, robot: Robot, skin: Skin, link: str) -> Solid:
    """Return the solid of a link with skin: its hull, or the layer behind its surface where it collides in pieces."""
    pieces = link_pieces(robot, skin, link)
    if pieces is None:
        return hull
    return replace(hull, shape=LayerShape(pieces.surface, depth=PIECE_DEPTH), pose=Pose.identity())


def _bare_geoms(model: mujoco.MjModel, robot: Robot, links: Sequence[str]) -> list[int]:
    """Colliding geoms of links without skin."""
    bodies = {int(model.body(link.name).id) for link in robot.links if link.name not in links}
    return [geom for geom in range(model.ngeom) if int(model.geom_bodyid[geom]) in bodies and model.geom_contype[geom]]


def _candidate(link: str, other: Solid, *, own: Solid | None = None) -> ContactCandidate:
    mine = None if own is None else (own.shape, own.pose)
    return ContactCandidate(link, other.body, other.shape, other.pose, other.by, mine)
