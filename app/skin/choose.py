"""Which links of a robot would wear a skin, when nobody says: those that show the most of themselves and move."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from app.arrays import FloatArray
from app.errors import SkinError
from app.geometry.mesh import Mesh
from app.geometry.pose import Pose
from app.robots.configuration import Configuration
from app.robots.robot import Robot

AUTOMATIC_LINKS = 3
_SAMPLES = 200
_Hull: TypeAlias = tuple[FloatArray, ConvexHull | None]


def choose_links(robot: Robot) -> tuple[str, ...]:
    """The three links a joint moves (any, on a robot without joints) with the largest exposed hulls, in robot order.

    A hull's area counts where it does not lie inside the hull of another link at home: a thick hub buried in its
    neighbours is no place for skin.

    Raises:
        SkinError: No link has geometry.
    """
    configuration = Configuration(robot)
    hulls = {link.name: _hull(link.mesh) for link in robot.links if link.mesh is not None and len(link.mesh.faces)}
    moved = _moved_links(robot, configuration)
    candidates = [name for name in hulls if name in moved] or list(hulls)
    if not candidates:
        raise SkinError("no link of the robot has geometry", file=robot.source, remedy="Open a robot with meshes")
    poses = {name: configuration.pose(name) for name in hulls}
    exposed = {name: _exposed_area(name, hulls, poses) for name in candidates}
    largest = sorted(candidates, key=lambda name: -exposed[name])[:AUTOMATIC_LINKS]
    return tuple(name for name in hulls if name in largest)


def _exposed_area(name: str, hulls: dict[str, _Hull], poses: dict[str, Pose]) -> float:
    """Area of the link's hull outside the hulls of the others [m²], from some of its triangles."""
    vertices, hull = hulls[name]
    corners = vertices if hull is None else hull.points[hull.simplices]
    every = -(-len(corners) // _SAMPLES)
    corners = corners[::every]
    points = poses[name].points(corners.mean(axis=1))
    buried = np.zeros(len(points), dtype=bool)
    for other, (_, around) in hulls.items():
        if other != name and around is not None:
            local = poses[other].inverse.points(points)
            buried |= (local @ around.equations[:, :3].T + around.equations[:, 3] < 0).all(axis=1)
    return every * float(_areas(corners)[~buried].sum())


def hull_area(mesh: Mesh) -> float:
    """Area of the convex hull [m²]: the outer area as far as it can be told from a mesh in any state."""
    _, hull = _hull(mesh)
    return mesh.area if hull is None else float(hull.area)


def _hull(mesh: Mesh) -> _Hull:
    """The mesh's triangles (m, 3, 3), and its hull; a flat mesh has none."""
    try:
        return mesh.vertices[mesh.faces], ConvexHull(mesh.vertices)
    except QhullError:
        return mesh.vertices[mesh.faces], None


def _areas(corners: FloatArray) -> FloatArray:
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.asarray(0.5 * np.linalg.norm(cross, axis=1))


def _moved_links(robot: Robot, configuration: Configuration) -> set[str]:
    """Names of links that move when the joints do; the configuration is back at home afterwards."""
    if not robot.joints:
        return set()
    at_home = configuration.poses()
    configuration.update(robot.home + 0.1)
    moved = np.abs(configuration.poses() - at_home).max(axis=(1, 2)) > 1e-9
    configuration.reset()
    return {link.name for link, does in zip(robot.links, moved, strict=True) if does}
