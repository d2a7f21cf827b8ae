"""Which part of a surface a finger could come to from outside: seen in a straight line from far away.

Depth maps from fixed directions instead of rays: every point is binned on a plane across the direction, and what lies
well behind the foremost point of its bin is hidden. No native code, no chance, the same answer every time.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from app.arrays import BoolArray, FloatArray
from app.geometry.mesh import Mesh
from app.geometry.outer import fibonacci_sphere

DIRECTIONS = 60
_FACING = 0.5
_SEEN_FROM = 2


def visible_from_outside(surface: Mesh, others: Sequence[Mesh], *, voxel: float) -> BoolArray:
    """(n,) vertices seen from at least two of 60 directions that they face.

    Args:
        surface: Evenly meshed with edges of about ``voxel``.
        others: What may stand in the way, in the surface's frame.
        voxel: Edge length [m]; a bin is two edges wide.
    """
    blockers = [_samples(other, voxel) for other in others]
    points = np.concatenate([surface.vertices, *(_thinned(cloud, voxel) for cloud in blockers)])
    count = len(surface.vertices)
    seen = np.zeros(count, dtype=int)
    for direction in fibonacci_sphere(DIRECTIONS):
        depth = points @ direction
        foremost = _foremost(points, depth, direction, 2 * voxel)
        facing = surface.vertex_normals @ direction
        # On a slope the bin's foremost point is ahead by the bin's width times the slope.
        slack = 2 * voxel * (1.5 + np.sqrt(np.maximum(1 - facing**2, 0)) / np.maximum(facing, _FACING))
        seen += (facing > _FACING) & (depth[:count] > foremost[:count] - slack)
    return seen >= _SEEN_FROM


def _foremost(points: FloatArray, depth: FloatArray, direction: FloatArray, bin_size: float) -> FloatArray:
    """For each point the greatest depth in its bin on the plane across ``direction``."""
    aside = np.eye(3)[np.abs(direction).argmin()]
    u = np.cross(direction, aside)
    u /= np.linalg.norm(u)
    v = np.cross(direction, u)
    i = ((points @ u - (points @ u).min()) / bin_size).astype(np.int64)
    j = ((points @ v - (points @ v).min()) / bin_size).astype(np.int64)
    cell = i * (j.max() + 1) + j
    deepest = np.full(cell.max() + 1, -np.inf)
    np.maximum.at(deepest, cell, depth)
    return deepest[cell]


def _samples(mesh: Mesh, spacing: float) -> FloatArray:
    """Corners of faces and, on faces larger than a bin, points in rows between them."""
    corners = mesh.vertices[mesh.faces]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    steps = np.minimum(np.ceil(longest / (1.5 * spacing)).astype(int), 64)
    clouds = [corners.reshape(-1, 3)]
    for number in np.unique(steps[steps > 1]):
        i, j = np.meshgrid(np.arange(number + 1), np.arange(number + 1), indexing="ij")
        inside = i + j <= number
        a, b = i[inside] / number, j[inside] / number
        clouds.append((np.stack([1 - a - b, a, b], axis=1) @ corners[steps == number]).reshape(-1, 3))
    return np.concatenate(clouds)


def _thinned(points: FloatArray, voxel: float) -> FloatArray:
    """One point of each occupied voxel: a bin is two voxels wide, so more say nothing new."""
    cell = np.floor((points - points.min(axis=0)) / voxel).astype(np.int64)
    shape = cell.max(axis=0) + 1
    key = (cell[:, 0] * shape[1] + cell[:, 1]) * shape[2] + cell[:, 2]
    return points[np.unique(key, return_index=True)[1]]
