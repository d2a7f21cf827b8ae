"""Where on a skin a weight can be laid: a place that lies level and free while the robot is at home."""

from __future__ import annotations

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from app.arrays import FloatArray
from app.errors import SimulationError
from app.geometry.closest import ClosestPoint
from app.geometry.mesh import Mesh
from app.geometry.surface_point import SurfacePoint
from app.robots.configuration import Configuration
from app.robots.robot import Robot
from app.simulation.contact_pairs import hull_points
from app.skin.skin import Skin

_LEVEL = 0.93
"""Vertical component of normals that count as level: 21 degrees."""
_ABOVE, _BULGE = 0.0002, 0.003
"""How far above what it will rest on the weight starts, and how far the hull may stand off the skin there [m]."""


def level_place(robot: Robot, skin: Skin, *, radius: float) -> tuple[SurfacePoint, tuple[float, float, float]]:
    """The place for the weight, and where its middle starts, world [m].

    Of the free places the one where the skin is most level and most like the hull that the physics lets touch: where
    they face different ways, what the weight rests on is not what feels it.

    Args:
        robot: At home.
        skin: On it.
        radius: Of the weight, a ball [m].

    Raises:
        SimulationError: There is none.
    """
    kinematics, best = Configuration(robot), 0.0
    found: list[tuple[float, int, FloatArray]] = []
    for number, patch in enumerate(skin.patches):
        pose = kinematics.pose(patch.link)
        places, up = pose.points(patch.taxels.positions), pose.directions(patch.taxels.normals)[:, 2]
        heights, level = _rest_on(pose.points(hull_points(robot, skin, patch.link)), places, radius)
        best = max(best, float(up.max(initial=0.0)))
        good = (up >= _LEVEL) & (level >= _LEVEL) & (heights - radius - places[:, 2] < _BULGE)
        for taxel in np.flatnonzero(good):
            penalty = abs(up[taxel] / level[taxel] - 1) + 1 - level[taxel]
            middle = np.array([*places[taxel, :2], heights[taxel] + _ABOVE])
            found.append((float(penalty), int(skin.first[number] + taxel), middle))
    sky = _Sky(robot, kinematics, radius)
    for _, number, middle in sorted(found, key=lambda row: row[:2]):
        at = skin.taxel_point(number)
        if sky.is_free(skin.link(at), middle):
            return at, (float(middle[0]), float(middle[1]), float(middle[2]))
    raise SimulationError(
        "no place on the skin lies level and free at home",
        value=f"the best faces up by {best:.2f}",
        remedy="Weigh on a robot whose home posture holds some skin level",
    )


def _rest_on(cloud: FloatArray, places: FloatArray, radius: float) -> tuple[FloatArray, FloatArray]:
    """Where a ball comes to rest that falls on the hull of ``cloud`` (n, 3) over each of ``places`` (k, 3), world [m].

    Returns:
        (k,) height of its middle, and (k,) vertical component of the hull's normal where it rests.

    Raises:
        SimulationError: The cloud has no volume.
    """
    try:
        facets = ConvexHull(cloud).equations
    except QhullError as error:
        raise SimulationError("a link is too flat to lay a weight on", value=str(error).splitlines()[0]) from error
    normals, offsets = np.split(facets[facets[:, 2] > 1e-9], [3], axis=1)
    # It touches when it is a radius off the facet that it is farthest out of.
    heights = (radius - offsets - normals[:, :2] @ places[:, :2].T) / normals[:, 2:]
    return heights.min(axis=0), normals[heights.argmin(axis=0), 2]


class _Sky:
    """Whether a weight is clear of links; search trees are built once, for the links that come near.

    Args:
        robot: The robot.
        kinematics: Its posture.
        radius: Of the weight [m].
    """

    def __init__(self, robot: Robot, kinematics: Configuration, radius: float) -> None:
        self._robot, self._kinematics, self._radius = robot, kinematics, radius
        self._trees: dict[str, ClosestPoint] = {}

    def is_free(self, wearer: str, middle: FloatArray) -> bool:
        """Whether a weight at ``middle`` (3,), world [m], is clear of all links but the one called ``wearer``."""
        return not any(
            self._is_near(link.name, link.mesh, middle)
            for link in self._robot.links
            if link.mesh is not None and len(link.mesh.faces) and link.name != wearer
        )

    def _is_near(self, name: str, mesh: Mesh, middle: FloatArray) -> bool:
        local = self._kinematics.pose(name).inverse.points(middle)
        low, high = mesh.bounds
        if (local < low - 2 * self._radius).any() or (local > high + 2 * self._radius).any():
            return False
        if name not in self._trees:
            self._trees[name] = ClosestPoint(mesh)
        return float(self._trees[name].query(local[None])[2][0]) < 1.1 * self._radius
