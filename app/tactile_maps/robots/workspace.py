"""Figures of a robot that determine the quality of its control: reach and ratio of inertias."""

from __future__ import annotations

import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.robots.kinematics import Configuration
from tactile_maps.robots.model.robot import Robot

_STEPS = 24
_ROUNDS = 3
_MAX_VERTICES = 100


def reach(robot: Robot) -> float | None:
    """Return the largest distance of the surface of a link from the first joint [m]; None without joints or shapes.

    Found by moving one joint after the other through its range, from home, three times; a joint without limits through
    one turn, or half a metre. Collisions are ignored.

    Cost: 0.1 s for seven joints.
    """
    clouds = [(link.name, _few(link.mesh.vertices)) for link in robot.links if link.mesh is not None]
    if not robot.joints or not clouds:
        return None
    configuration = Configuration(robot)
    posture = robot.home.copy()
    origin = configuration.joint_axes()[0][0]

    def distance() -> float:
        configuration.update(posture)
        points = (configuration.pose(link).points(cloud) for link, cloud in clouds)
        return max(float(np.linalg.norm(cloud - origin, axis=1).max()) for cloud in points)

    for _ in range(_ROUNDS):
        for number, joint in enumerate(robot.joints):
            span = 0.5 if joint.slide else np.pi
            lower = joint.lower if np.isfinite(joint.lower) else robot.home[number] - span
            upper = joint.upper if np.isfinite(joint.upper) else robot.home[number] + span
            found = list[tuple[float, float]]()
            for value in (posture[number], *np.linspace(lower, upper, _STEPS)):
                posture[number] = value
                found.append((distance(), float(value)))
            posture[number] = max(found)[1]
    return distance()


def _few(vertices: FloatArray) -> FloatArray:
    return vertices[:: max(len(vertices) // _MAX_VERTICES, 1)]


def inertia_ratio(robot: Robot) -> float | None:
    """Return the largest joint inertia at home over the smallest, of hinges; None with fewer than two hinges."""
    hinges = np.array([not joint.slide for joint in robot.joints], dtype=bool)
    if hinges.sum() < 2:
        return None
    inertia = Configuration(robot).inertia()[hinges]
    return float(inertia.max() / inertia.min())
