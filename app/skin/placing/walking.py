"""Steps of given length over a surface, and directions carried along."""

from __future__ import annotations

import numpy as np

from app.arrays import BoolArray, FloatArray, IntArray
from app.geometry.closest import ClosestPoint
from app.geometry.mesh import Mesh

_OFF = 0.2
"""A step that ends farther than this share of it off the surface went over the border."""
_FACING = 0.3
"""So did one whose end looks elsewhere: to the other side of a thin wall."""


def walk(
    surface: Mesh,
    closest: ClosestPoint,
    points: FloatArray,
    faces: IntArray,
    steps: FloatArray,
    length: float | FloatArray,
) -> tuple[FloatArray, IntArray, BoolArray]:
    """Go ``length`` [m] from each of ``points`` (s, 3) in ``faces`` (s,) along unit tangents ``steps`` (s, 3).

    Returns:
        Ends (s, 3) on the surface, about that far away in a straight line; their faces; and whether each is on the
        same side of the surface and not over its border.
    """
    length = np.broadcast_to(length, len(points))[:, None]
    at, weights, _ = closest.query(points + length * steps)
    toward = surface.points(at, weights) - points
    gone = np.linalg.norm(toward, axis=1, keepdims=True)
    # A step in the tangent plane falls short on a bent surface; the second is as long as it should be.
    at, weights, away = closest.query(points + length * toward / np.where(gone > 0, gone, 1.0))
    facing = (surface.face_normals[at] * surface.face_normals[faces]).sum(axis=1) > _FACING
    return surface.points(at, weights), at, facing & (away < _OFF * length[:, 0]) & (gone[:, 0] > length[:, 0] / 2)


def carried(directions: FloatArray, before: FloatArray, after: FloatArray) -> FloatArray:
    """(s, 3) unit tangents turned by the smallest turn that takes the normals ``before`` (s, 3) to those ``after``.

    Parallel transport in small steps; leaving out what sticks out of the new plane would turn them off a straight path.
    """
    lean = (directions * after).sum(axis=1) / (1 + (before * after).sum(axis=1))
    turned = directions - lean[:, None] * (before + after)
    return turned / np.linalg.norm(turned, axis=1, keepdims=True)  # only against rounding, over thousands of steps


def some_directions(normals: FloatArray, turns: FloatArray) -> FloatArray:
    """(s, 3) unit directions square to ``normals`` (s, 3); ``turns`` (s,) [rad] choose which."""
    first = np.cross(normals, np.eye(3)[np.abs(normals).argmin(axis=1)])
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.cos(turns)[:, None] * first + np.sin(turns)[:, None] * np.cross(normals, first)
