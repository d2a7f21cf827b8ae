"""What presses the skin at one instant, whoever presses: a finger, an object or another link."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from app.arrays import FloatArray, readonly
from app.errors import SimulationError
from app.geometry.pose import Pose
from app.touch.shapes import Ball, Shape

_UPRIGHT = readonly(np.eye(3))


@dataclass(frozen=True, eq=False)
class Load:
    """One body pressing one link's skin.

    Attributes:
        link: Which link.
        point: (3,) centre of pressure of the normal force, link frame [m].
        normal: (3,) outward unit normal of the skin there, link frame; the force acts against it.
        force: Normal force [N], >= 0.
        shape: The body that presses.
        pose: ``T_link_shape``: where the body is, as deep in the skin as the physics has it.
        by: Who presses, for people: a finger, an object's name, a link's name.

    Raises:
        SimulationError: The force is no such number.
    """

    link: str
    point: FloatArray
    normal: FloatArray
    force: float
    shape: Shape
    pose: Pose
    by: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "point", readonly(self.point))
        object.__setattr__(self, "normal", readonly(self.normal))
        if not (math.isfinite(self.force) and self.force >= 0):
            raise SimulationError("there is no such load", place=f"on {self.link}", value=f"{self.force} N")

    def distances(self, points: FloatArray) -> FloatArray:
        """(k,) signed distance [m] of ``points`` (k, 3) [m], link frame, from the body; negative inside."""
        return self.shape.distance((points - self.pose.translation) @ self.pose.rotation)


def ball_load(
    link: str, point: FloatArray, normal: FloatArray, force: float, radius: float, *, depth: float = 0.0
) -> Load:
    """A ball that touches the skin at ``point`` from outside, ``depth`` [m] below the surface.

    Args:
        link: Which link.
        point: (3,) on the skin, link frame [m].
        normal: (3,) outward unit normal, link frame.
        force: [N], >= 0.
        radius: Of the ball [m], > 0.
        depth: How far its lowest point is below ``point`` [m].

    Raises:
        SimulationError: Force or radius is no such number.
    """
    if not (math.isfinite(radius) and radius > 0):
        raise SimulationError("there is no such ball to press", place=f"on {link}", value=f"radius {radius} m")
    centre = np.asarray(point) + (radius - depth) * np.asarray(normal)
    centre.flags.writeable = False  # nobody else has it: no copy is needed
    return Load(link, point, normal, force, Ball(radius), Pose(_UPRIGHT, centre))
