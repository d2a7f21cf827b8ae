"""Rolling off: exact on planes, cylinders and cones, at the cost of one pass over the faces.

The surface's normals make one angle with the axis of a cylinder or cone, so the axis is the direction in which they
vary least. Around it every point has a distance from the apex and an angle, which the cone's opening makes smaller on
the map (a cylinder is a cone with its apex far away). Loses: all that is not such a surface; ``flatten`` then mends.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import breadth_first_order

from app.arrays import FloatArray, IntArray
from app.geometry.mesh import Mesh
from app.geometry.topology import edge_table
from app.maps.methods.disk import Disk

_FLAT = 1e-3
"""Normals that vary by less than this are a plane's."""
_PARALLEL = 1e-4
"""Sine of the half opening under which a cone counts as a cylinder."""


def flatten_disk(disk: Disk) -> Iterator[FloatArray]:
    """The one round of the method ``unroll``."""
    surface = Mesh(disk.positions, disk.faces)
    normals, weights = surface.face_normals, surface.face_areas / surface.area
    mean = weights @ normals
    spread = (weights[:, None] * (normals - mean)).T @ (normals - mean)
    values, axes = np.linalg.eigh(spread)
    if values[-1] < _FLAT:
        yield _plane(disk.positions, mean)
        return
    axis = axes[:, 0] * (1.0 if mean @ axes[:, 0] >= 0 else -1.0)
    sine = min(float(mean @ axis), 1.0)
    yield _rolled(disk, surface, axis, sine)


def _plane(positions: FloatArray, normal: FloatArray) -> FloatArray:
    """Seen along the mean normal."""
    along = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
    along /= np.linalg.norm(along)
    return np.stack([positions @ along, positions @ np.cross(normal / np.linalg.norm(normal), along)], axis=1)


def _rolled(disk: Disk, surface: Mesh, axis: FloatArray, sine: float) -> FloatArray:
    """A cone's points by distance from the apex and angle around the axis; a cylinder's by arc and height."""
    along = np.cross(axis, np.eye(3)[np.abs(axis).argmin()])
    along /= np.linalg.norm(along)
    across = np.cross(axis, along)
    centres, normals = surface.vertices[surface.faces].mean(axis=1), surface.face_normals
    flat = np.stack([normals @ along, normals @ across], axis=1)
    # The normals' lines all meet the axis: least squares for where it crosses the plane through the origin.
    away = np.stack([-flat[:, 1], flat[:, 0]], axis=1)
    level = np.stack([centres @ along, centres @ across], axis=1)
    middle, *_ = np.linalg.lstsq(away, (away * level).sum(axis=1), rcond=None)
    x, y = disk.positions @ along - middle[0], disk.positions @ across - middle[1]
    height, radius = disk.positions @ axis, np.hypot(x, y)
    angle = _unwound(np.arctan2(y, x), disk.faces)
    if sine < _PARALLEL:
        return np.stack([angle * radius.mean(), height], axis=1)
    # Seen from outside the radius falls along the axis, seen from inside it grows.
    outside = (level - middle) * flat
    apex = height + np.sign(outside.sum()) * radius * np.sqrt(1 - sine**2) / sine
    far = np.hypot(radius, apex.mean() - height)
    return np.stack([far * np.sin(angle * sine), -far * np.cos(angle * sine)], axis=1)


def _unwound(angle: FloatArray, faces: IntArray) -> FloatArray:
    """Angles without jumps from vertex to vertex over the cut surface."""
    edges = edge_table(faces).edges
    both = np.concatenate([edges, edges[:, ::-1]])
    graph = coo_matrix((np.ones(len(both)), (both[:, 0], both[:, 1])), shape=(len(angle),) * 2).tocsr()
    order, before = breadth_first_order(graph, 0)
    result = angle.copy()
    for vertex in order[1:].tolist():
        step = angle[vertex] - angle[before[vertex]]
        result[vertex] = result[before[vertex]] + step - 2 * np.pi * np.round(step / (2 * np.pi))
    return result
