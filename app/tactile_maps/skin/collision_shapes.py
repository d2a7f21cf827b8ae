"""The convex shapes with which links with skin collide, and the pairs of links that never collide.

A link collides as the convex hull of link and skin, or in convex pieces where the hull spans hollows. Contacts of the
solver, self contact of the foundation and the pairs that never collide use the same shapes.
"""

from __future__ import annotations

from collections.abc import Collection

import igl
import mujoco
import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.caches import weak_cache
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.robots.model.mujoco_spec import compile_spec, drop_found_exclusions
from tactile_maps.robots.model.robot import Robot
from tactile_maps.robots.model.sanitize import overlapping_bodies
from tactile_maps.skin.link_hulls import (
    LinkPairs,
    add_hull,
    hull_name,
    hull_points,
    hulls_spec,
    overlapping_hulls,
)
from tactile_maps.skin.link_pieces import add_pieces, link_pieces
from tactile_maps.skin.model.skin import Skin

_INSIDE = 0.5
"""Winding number above which a point is inside a surface."""


def add_collision_shapes(spec: mujoco.MjSpec, robot: Robot, skin: Skin, link: str) -> list[mujoco.MjsGeom]:
    """Add the shapes with which a link collides to its body, without weight; nothing collides with them yet."""
    pieces = link_pieces(robot, skin, link)
    return [add_hull(spec, robot, skin, link)] if pieces is None else add_pieces(spec, pieces, link)


@weak_cache
def excluded_pairs(robot: Robot, skin: Skin) -> LinkPairs:
    """Return the pairs of links that never collide: neighbours, and those that overlap at home or mostly.

    Links overlap where their collision shapes touch, or where one is inside the surface of the other.

    Raises:
        RobotError: MuJoCo rejects the robot with hulls around its skin.

    Cost: that of ``overlapping_hulls``; as much again, and that of ``pieces_model``, where overlapping hulls span
    hollows.
    """
    never, overlapping = overlapping_hulls(robot, skin)
    return never | _overlapping(robot, skin, overlapping)


def _overlapping(robot: Robot, skin: Skin, pairs: LinkPairs) -> LinkPairs:
    """Return those of the pairs of links with overlapping hulls whose collision shapes overlap as well."""
    surfaces = _divided_surfaces(robot, skin, pairs)
    doubtful = _doubtful(pairs, surfaces)
    if not doubtful:
        return pairs
    kept = {frozenset(pair) for pair in overlapping_bodies(pieces_model(robot, skin), robot.home)} & doubtful
    home = Configuration(robot)
    for pair in doubtful - kept:
        for one, other in (sorted(pair), sorted(pair, reverse=True)):
            if one in surfaces and _holds(surfaces[one], home, one, other, _points(robot, skin, other)):
                kept.add(pair)
    return pairs - doubtful | kept


def _divided_surfaces(robot: Robot, skin: Skin, pairs: LinkPairs) -> dict[str, Mesh]:
    """Return the touchable surfaces of those links of the pairs that collide in pieces."""
    links = frozenset[str]().union(*pairs)
    divided = {link: link_pieces(robot, skin, link) for link in skin.links if link in links}
    return {link: pieces.surface for link, pieces in divided.items() if pieces is not None}


def _doubtful(pairs: LinkPairs, divided: Collection[str]) -> LinkPairs:
    """Return the pairs in which a link collides in pieces."""
    return frozenset(pair for pair in pairs if not pair.isdisjoint(divided))


@weak_cache
def pieces_model(robot: Robot, skin: Skin) -> mujoco.MjModel:
    """Return the robot with the collision shapes of those links that are in pairs with overlapping hulls and pieces.

    It must not be modified. No other link collides, and the bodies are those of the robot.

    Raises:
        RobotError: MuJoCo rejects the robot with hulls around its skin.

    Cost: 0.3 s for 1,200 pieces, and the pieces themselves if they were not made before.
    """
    _, pairs = overlapping_hulls(robot, skin)
    divided = _divided_surfaces(robot, skin, pairs)
    links = frozenset[str]().union(*_doubtful(pairs, divided))
    spec = hulls_spec(robot, skin)
    drop_found_exclusions(spec)
    for link in divided:
        spec.geom(hull_name(link)).contype = spec.geom(hull_name(link)).conaffinity = 0
        for piece in add_collision_shapes(spec, robot, skin, link):
            piece.contype = piece.conaffinity = 1
    for body in spec.bodies:
        if body.name not in links:
            for geom in body.geoms:
                geom.contype = geom.conaffinity = 0
    return compile_spec(spec, source=robot.source)


def _holds(surface: Mesh, home: Configuration, link: str, other: str, points: FloatArray) -> bool:
    """Return whether any of the points (n, 3) of another link is inside the surface of a link at home."""
    seen = home.pose(link).inverse.points(home.pose(other).points(points))
    low, high = surface.bounds
    seen = seen[((seen > low) & (seen < high)).all(axis=1)]
    if not len(seen):
        return False
    winding = igl.fast_winding_number(surface.vertices, surface.faces, np.ascontiguousarray(seen))
    return bool((winding > _INSIDE).any())


def _points(robot: Robot, skin: Skin, link: str) -> FloatArray:
    """Return (n, 3) points on a link and its skin [m], link frame."""
    if link in skin.links:
        return hull_points(robot, skin, link)
    mesh = robot.link(link).mesh
    return np.zeros((0, 3)) if mesh is None else mesh.vertices
