"""Where an object truly touches a skin, and where a believed place truly lies: what controllers do not know."""

from __future__ import annotations

import numpy as np

from app.arrays import FloatArray
from app.geometry.closest import ClosestPoint
from app.geometry.surface_point import SurfacePoint
from app.maps.tactile_map import TactileMap
from app.robots.configuration import Configuration
from app.robots.robot import Robot
from app.skin.skin import Skin


class TrueTouch:
    """Tells how far a contact is from where it is wanted. Built once for a robot, its skin and what is believed of it.

    A misplaced skin has the true one's triangles: the same triangle is the same place. A map learned from touch has
    triangles of its own, between taxels where they truly are: what it calls a place lies where they say.

    Args:
        robot: The robot.
        skin: As it is.
        map_: What is believed.

    Cost: 20 µs a question and patch.
    """

    def __init__(self, robot: Robot, skin: Skin, map_: TactileMap) -> None:
        self._skin, self._believed, self._configuration = skin, map_.skin, Configuration(robot)
        self._nearest = [(patch, ClosestPoint(patch.surface)) for patch in skin.patches]
        self._same = [
            np.array_equal(true.surface.faces, believed.surface.faces)
            for true, believed in zip(skin.patches, map_.skin.patches, strict=True)
        ]

    def error(self, target: SurfacePoint, ball: FloatArray, posture: FloatArray) -> float:
        """From the place of the skin nearest to a ball's middle to where the target lies [m].

        Args:
            target: A place of the believed skin.
            ball: (3,) its middle, world frame [m].
            posture: (joints,) of the robot.
        """
        self._configuration.update(posture)
        skin = self._skin if self._same[target.patch] else self._believed
        wanted = self._configuration.pose(skin.link(target)).points(skin.position(target))
        return float(np.linalg.norm(self.touched(ball) - wanted))

    def touched(self, ball: FloatArray) -> FloatArray:
        """(3,) the place of the skin nearest to a ball's middle (3,), both in the world [m], at the last posture."""
        best = (np.inf, ball)
        for patch, nearest in self._nearest:
            pose = self._configuration.pose(patch.link)
            faces, weights, away = nearest.query(pose.inverse.points(ball)[None])
            if away[0] < best[0]:
                best = (float(away[0]), pose.points(patch.surface.point(int(faces[0]), weights[0])))
        return best[1]
