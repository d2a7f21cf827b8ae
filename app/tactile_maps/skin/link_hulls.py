"""Convex hulls of links with their skin, and the pairs of links whose hulls overlap.

A link collides as its hull unless the hull spans hollows (``link_pieces``). Planned motions use hulls except between
links whose hulls overlap at home.
"""

from __future__ import annotations

import math
from itertools import combinations
from typing import TypeAlias

import mujoco
import numpy as np
from scipy.spatial import ConvexHull

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.caches import weak_cache
from tactile_maps.robots.model.mujoco_spec import OWN_NAMES, compile_spec, drop_found_exclusions, robot_spec
from tactile_maps.robots.model.robot import Robot
from tactile_maps.robots.model.sanitize import collision_exclusions
from tactile_maps.skin.model.skin import PLACEHOLDER_COVERED, Skin

HULL = f"{OWN_NAMES}skin "
"""Prefix of the names of hulls."""
_FLAT = 1e-4
"""Thickness over size below which points have no convex hull."""
_DEPTH = 0.003
"""Thickness of the hull of points in a plane [m]."""
_LOST_HEIGHT = 5e-6
"""Height above the rest of its hull from which a corner without faces is kept [m]."""


def hull_name(link: str) -> str:
    """Return the name of the hull of a link, which its geom and its mesh have."""
    return HULL + link


def hull_points(robot: Robot, skin: Skin, link: str) -> FloatArray:
    """Return (n, 3) vertices of a link and its skin [m], link frame.

    The placeholder of a missing mesh is included only if the skin covers it. Points in a plane, which have no convex
    hull, are repeated at a small depth below the skin.
    """
    surfaces = [patch.surface for patch in skin.patches if patch.link == link]
    points = np.concatenate([surface.vertices for surface in surfaces])
    carrier = robot.link(link)
    if carrier.mesh is not None and carries_mesh(robot, skin, link):
        points = np.concatenate([points, carrier.mesh.vertices])
    extents = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    if extents[-1] <= _FLAT * extents[0]:
        below = [surface.vertices - _DEPTH * surface.vertex_normals for surface in surfaces]
        points = np.concatenate([points, *below])
    return points


def carries_mesh(robot: Robot, skin: Skin, link: str) -> bool:
    """Return whether the mesh of a link is part of its shape; the placeholder of a missing one is only if covered."""
    covered = any(finding.kind == PLACEHOLDER_COVERED and finding.where == link for finding in skin.findings)
    return covered or not robot.link(link).missing


def corners_with_faces(points: FloatArray) -> FloatArray:
    """Return the points (n, 3) [m] without those that are corners of their convex hull but of none of its faces.

    MuJoCo merges faces that are nearly coplanar, as those of a flat skin are in float32. Where a body touches a corner
    inside a merged face, MuJoCo finds no face and one contact instead of several: a box rocks from corner to corner.
    All points are returned if each corner has a face, else the corners that have one. A corner more than 5 µm above
    the others is kept and raised by its height, once, so that its faces are not merged (forearm of the arm: 5.6 µm). If
    they still are, it is left out: on a large body it would grow into a bump. The hull of a body of 1 m can therefore
    be 0.2 mm lower than the body.

    Cost: two compilations of the hull, 15 ms for one of 400 corners and 0.2 s for 5,000.
    """
    least = _LOST_HEIGHT
    while True:
        spec = mujoco.MjSpec()
        spec.add_mesh(
            name="hull", uservert=points.ravel().tolist(), inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX
        )
        spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname="hull")
        try:
            model = spec.compile()
        except ValueError:  # reported when the robot is compiled
            return points
        count = model.mesh_graph[0]
        corners = model.mesh_graph[2 + count : 2 + 2 * count]
        has_face = model.mesh_polymapnum[corners] > 0
        if has_face.all():
            return points
        kept, merged = corners[has_face], corners[~has_face]
        planes = ConvexHull(points[kept]).equations
        heights = points[merged] @ planes[:, :3].T + planes[:, 3]
        height = heights.max(axis=1)
        high = height > least
        least = math.inf
        points = points.copy()
        points[merged[high]] += (height[:, None] * planes[heights.argmax(axis=1), :3])[high]
        points = points[np.sort(np.concatenate([kept, merged[high]]))]


@weak_cache
def _corners_of_link(robot: Robot, skin: Skin, link: str) -> FloatArray:
    return corners_with_faces(hull_points(robot, skin, link))


def add_hull(spec: mujoco.MjSpec, robot: Robot, skin: Skin, link: str) -> mujoco.MjsGeom:
    """Add the hull of a link to its body, without weight; nothing collides with it yet."""
    return add_convex(spec, link, hull_name(link), _corners_of_link(robot, skin, link))


def add_convex(spec: mujoco.MjSpec, link: str, name: str, points: FloatArray) -> mujoco.MjsGeom:
    """Add the convex hull of points (n, 3) [m] to the body of a link, without weight; nothing collides with it yet."""
    inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX
    spec.add_mesh(name=name, uservert=points.ravel().tolist(), inertia=inertia)
    return spec.body(link).add_geom(
        name=name, type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name, mass=0.0, contype=0, conaffinity=0, group=3
    )


def hulls_spec(robot: Robot, skin: Skin) -> mujoco.MjSpec:
    """Return a new spec of the robot alone, in which hulls collide in place of the shapes of links with skin.

    Raises:
        RobotError: MuJoCo refuses the robot.
    """
    spec = robot_spec(robot)
    for link in skin.links:
        for geom in spec.body(link).geoms:
            geom.contype = geom.conaffinity = 0
        hull = add_hull(spec, robot, skin, link)
        hull.contype = hull.conaffinity = 1
    return spec


LinkPairs: TypeAlias = frozenset[frozenset[str]]


@weak_cache
def overlapping_hulls(robot: Robot, skin: Skin) -> tuple[LinkPairs, LinkPairs]:
    """Return the pairs of links that never collide, and the other pairs whose hulls overlap at home or mostly.

    Neighbours and the pairs that the model of the robot excludes never collide. Pairs that overlap by the shapes of
    the model, which were found when it was loaded, are decided by hulls where one of the links has skin.

    Raises:
        RobotError: MuJoCo refuses the robot with hulls around its skin.

    Cost: a compilation and 31 collision passes, once for a robot and its skin.
    """
    spec = hulls_spec(robot, skin)
    skinned = skin.links
    bare = {pair for pair in drop_found_exclusions(spec) if pair.isdisjoint(skinned)}
    stated = {frozenset((exclude.bodyname1, exclude.bodyname2)) for exclude in spec.excludes}
    model = compile_spec(spec, source=robot.source)
    never = frozenset(stated | _neighbours(model))
    found = {frozenset(pair) for pair in collision_exclusions(model, robot.home)}
    return never, frozenset(found | bare) - never


def _neighbours(model: mujoco.MjModel) -> set[frozenset[str]]:
    """Return bodies that are welded together or joined by one joint; MuJoCo's own filter ignores explicit pairs."""
    weld = model.body_weldid
    names = [model.body(body).name for body in range(model.nbody)]
    parent = model.body_weldid[model.body_parentid[weld]]
    return {
        frozenset((names[a], names[b]))
        for a, b in combinations(range(1, model.nbody), 2)
        if weld[a] == weld[b] or (weld[a] and weld[b] and (weld[a] == parent[b] or weld[b] == parent[a]))
    }
