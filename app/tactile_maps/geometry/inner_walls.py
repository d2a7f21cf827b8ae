"""Inner walls of thin shells: the side of a wall that faces a cavity with an opening.

A face belongs to a wall if another, nearly parallel part of the mesh is close behind or in front of it: the other side
of a shell with a thickness, or a second wall nested in the first. Connected faces of this kind form one side of a wall.
A side is an inner one if its view of the surroundings, a form factor between 0 and 1, is less than ``INNER_VIEW`` of
the view of the opposite side. A flat plate has two outer sides; a hemispherical bowl has an inner one (form factor
1/2).
"""

from __future__ import annotations

import numpy as np
from igl.embree import EmbreeIntersector

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray
from tactile_maps.geometry.surface.connectivity import components_of, connected_labels
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.geometry.surface.raycast import fibonacci_sphere

INNER_VIEW = 0.7
"""Share of the view of the opposite side below which a side of a wall is an inner one."""
THINNEST_WALL = 0.08
"""Thickness of a wall, as a share of the square root of the area of its side, up to which it counts as thin. Sides
end at edges of more than 60 degrees, so that each wall of a box has an area of its own."""
_PARALLEL = 0.5
"""Cosine of the largest angle between the two sides of a wall, and between neighbouring faces of one side."""
_SAMPLES = 200
_THIN_SHARE = 0.2
"""Number of faces sampled first (``_SAMPLES``), and the share of them that must be on a thin wall for all faces to be
tested."""
_VIEWPOINTS = 40
_DIRECTIONS = 60
_LEAST_SIDE = 0.02
"""Share of the area below which a side of a wall is not judged."""
_CLEAR = 1e-5  # share of the size; rays use single precision and must not hit their own face


def inner_walls(mesh: Mesh, chosen: BoolArray) -> BoolArray:
    """Return a mask (m,) of the ``chosen`` faces (m,) that are on the inner side of a thin wall.

    Args:
        mesh: Manifold and oriented, with some area.
        chosen: (m,) faces that are visible from outside. The others only occlude.

    Cost: two rays for each of 200 faces; on a mesh with thin walls two rays for every face (10 µs a face).
    """
    result = np.zeros(len(mesh.faces), dtype=bool)
    faces = np.flatnonzero(chosen & (mesh.face_areas > 0))
    if not len(faces):
        return result
    rays = _Rays(mesh)
    thin = THINNEST_WALL * float(np.sqrt(mesh.face_areas[faces].sum() / 2))
    # The same samples at each call, distributed by area.
    areas = mesh.face_areas[faces]
    middles = (np.arange(_SAMPLES) + 0.5) / _SAMPLES * areas.sum() * (1 - 1e-12)
    tried = faces[np.searchsorted(np.cumsum(areas), middles)]
    if (rays.opposite(tried)[1] < thin).mean() < _THIN_SHARE:
        return result
    opposite, thickness = rays.opposite(np.arange(len(result)))  # of all faces: walls behind walls are compared as well
    twins = mesh.connectivity.twins
    smooth = (mesh.face_normals[twins // 3].prod(axis=1)).sum(axis=1) > _PARALLEL
    walls = thickness < thin
    side = _groups(twins[smooth & walls[twins // 3].all(axis=1)], walls)
    inner = _inner_sides(mesh, rays, side, opposite, thickness)
    result = chosen & (side >= 0) & inner[side]
    if result.any():
        # The remaining faces of a cavity, such as ribs, face it as well.
        rest = _groups(twins[(~result & chosen)[twins // 3].all(axis=1)], ~result & chosen)
        adjacent = np.unique(rest[(twins // 3)[result[twins // 3].any(axis=1)]])
        views = np.array([rays.view(np.flatnonzero(rest == k)) for k in adjacent[adjacent >= 0]])
        result |= np.isin(rest, adjacent[adjacent >= 0][views < INNER_VIEW])
    return np.asarray(result)


def _groups(twins: IntArray, members: BoolArray) -> IntArray:
    """Return the component label (m,) of each of the ``members`` (m,), connected by ``twins``; -1 elsewhere."""
    label = components_of(twins, len(members))
    return np.where(members, label, -1)


def _inner_sides(mesh: Mesh, rays: _Rays, side: IntArray, opposite: IntArray, thickness: FloatArray) -> BoolArray:
    """Return for each label whether that side of a wall is an inner one."""
    areas = mesh.face_areas
    count = int(side.max()) + 1
    on = np.flatnonzero(side >= 0)
    total = np.bincount(side[on], areas[on], count)
    mean = np.bincount(side[on], areas[on] * thickness[on], count) / np.where(total > 0, total, 1.0)
    judged = np.flatnonzero((total > _LEAST_SIDE * areas.sum()) & (mean < THINNEST_WALL * np.sqrt(total)))
    view = np.zeros(count)
    view[judged] = [rays.view(on[side[on] == k]) for k in judged]
    # The opposite side is the one that most of the area faces. Walls behind walls are all compared with the outermost.
    across = np.full(count, -1)
    for k in judged:
        faces = on[side[on] == k]
        others = side[opposite[faces]]
        facing = np.bincount(others[others >= 0], areas[faces][others >= 0], count)
        facing[k] = 0.0
        across[k] = facing.argmax() if facing.any() else k
    stack = connected_labels(np.stack([judged, across[judged]], axis=1), count)
    best = np.zeros(count)
    np.maximum.at(best, stack, view)
    return np.asarray(view < INNER_VIEW * best[stack]) & np.isin(np.arange(count), judged)


class _Rays:
    """Casts rays from the faces of one mesh."""

    def __init__(self, mesh: Mesh) -> None:
        # Unit size about the origin: rays are traced in single precision.
        vertices = (mesh.vertices - mesh.bounds.mean(axis=0)) / mesh.size
        self._size = mesh.size
        self._normals = mesh.face_normals
        self._centres = vertices[mesh.faces].mean(axis=1)
        self._tree = EmbreeIntersector()
        self._tree.init(np.ascontiguousarray(vertices, np.float32), np.ascontiguousarray(mesh.faces, np.int32))
        self._directions = fibonacci_sphere(_DIRECTIONS).astype(np.float32)

    def opposite(self, faces: IntArray) -> tuple[IntArray, FloatArray]:
        """Return the closest nearly parallel face along either normal of each face, and its distance [m]."""
        found = np.full(len(faces), -1)
        distance = np.full(len(faces), np.inf)
        starts = self._centres[faces].astype(np.float32)
        normals = self._normals[faces].astype(np.float32)
        for sign in (1, -1):
            for row, (start, along) in enumerate(zip(starts, sign * normals, strict=True)):
                face, away, _, _ = self._tree.intersectRay_first(start, along, _CLEAR)
                nearer = face >= 0 and away < distance[row]
                if nearer and abs(float(self._normals[face] @ self._normals[faces[row]])) > _PARALLEL:
                    found[row] = face
                    distance[row] = away
        return found, self._size * distance

    def view(self, faces: IntArray) -> float:
        """Return the mean visible share of the surroundings, weighted by the cosine; both sides are summed."""
        chosen = faces[np.linspace(0, len(faces) - 1, min(len(faces), _VIEWPOINTS)).astype(np.int64)]
        weights = np.abs(self._normals[chosen] @ self._directions.T.astype(np.float64))
        free = np.zeros_like(weights)
        for row, start in enumerate(self._centres[chosen].astype(np.float32)):
            for column, along in enumerate(self._directions):
                free[row, column] = self._tree.intersectRay_first(start, along, _CLEAR)[0] < 0
        return float(2 * (weights * free).sum() / weights.sum())
