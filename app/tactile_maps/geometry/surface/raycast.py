"""Rays against a mesh: the first hit of a ray, and the faces visible from outside.

``RayCaster`` is a search tree that is built once and queried at every mouse move.

``outer_faces`` finds the outer surface of a mesh: the faces that straight lines from far away hit first. Inner shells,
parts inside other parts and the inner walls of hollow parts are not visible. A sheet is visible from either side, so
the orientation of its faces in a file does not matter.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from igl.embree import EmbreeIntersector, line_mesh_intersection

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray
from tactile_maps.core.caches import weak_cache
from tactile_maps.core.errors import MeshError
from tactile_maps.geometry.surface.closest_point import barycentric
from tactile_maps.geometry.surface.connectivity import Connectivity
from tactile_maps.geometry.surface.mesh import Mesh


@dataclass(frozen=True)
class RayHit:
    """First intersection of a ray with a mesh.

    Attributes:
        face: Index of the triangle.
        weights: Barycentric weights in it.
        distance: Along the ray [m].
    """

    face: int
    weights: tuple[float, float, float]
    distance: float


class RayCaster:
    """Casts rays against one mesh, in the frame of the mesh; for a moving link the ray is transformed instead.

    Args:
        mesh: Mesh with at least one face.
    """

    def __init__(self, mesh: Mesh) -> None:
        if not len(mesh.faces):
            raise MeshError("the mesh has no faces to hit")
        # Embree works in single precision. Centring and scaling preserves the digits of distant or tiny meshes.
        self._vertices = mesh.vertices
        self._faces = mesh.faces
        self._normals = mesh.face_normals
        self._centre = mesh.bounds.mean(axis=0)
        self._size = mesh.size or 1.0
        local = np.ascontiguousarray((mesh.vertices - self._centre) / self._size, dtype=np.float32)
        self._tree = EmbreeIntersector()
        self._tree.init(local, np.ascontiguousarray(mesh.faces, dtype=np.int32))

    def first_hit(self, origin: FloatArray, direction: FloatArray) -> RayHit | None:
        """Return the nearest face along the ray, from either side, or None if the ray misses.

        Args:
            origin: (3,) [m].
            direction: (3,), not zero; its length does not matter.
        """
        raise_if_bad(origin, direction)
        unit = np.asarray(direction, dtype=np.float64) / np.linalg.norm(direction)
        start = (np.asarray(origin, dtype=np.float64) - self._centre) / self._size
        # Start near the mesh: single precision loses a millimetre over a kilometre.
        forward = max(float(-start @ unit) - 1.0, 0.0)
        near = (start + forward * unit).astype(np.float32)
        face, distance, _, _ = self._tree.intersectRay_first(near, unit.astype(np.float32))
        if face < 0 or not np.isfinite(distance):
            return None
        along = (forward + distance) * self._size
        return self._exact(int(face), np.asarray(origin, dtype=np.float64), unit, along)

    def _exact(self, face: int, origin: FloatArray, unit: FloatArray, along: float) -> RayHit:
        """Intersect the plane of the face in double precision; grazing rays keep the single-precision distance."""
        corners = self._vertices[self._faces[face]]
        normal = self._normals[face]
        slope = float(normal @ unit)
        if abs(slope) > 1e-6:
            along = float(normal @ (corners[0] - origin)) / slope
        a, b, c = barycentric(corners[None], (origin + along * unit)[None])[0]
        return RayHit(face, (float(a), float(b), float(c)), along)


@weak_cache
def ray_caster(mesh: Mesh) -> RayCaster:
    """Return the search tree of a mesh, cached while the mesh exists."""
    return RayCaster(mesh)


def raise_if_bad(origin: FloatArray, direction: FloatArray) -> None:
    """Raise MeshError for a ray that native code cannot handle."""
    if not (np.isfinite(origin).all() and np.isfinite(direction).all() and np.linalg.norm(direction) > 0):
        raise MeshError("a ray needs a finite origin and a direction", value=(list(origin), list(direction)))


DIRECTIONS = 60
_STRIDE = 23  # with this stride the first few directions are already distributed all around
_SEEN_FROM = 2
_LOOKS = 12
_GRAZING = 0.1
_SAME_DEPTH = 1e-5
"""Share of the mesh's size within which a hit is on the face itself; rays use single precision."""
_CLEAR_DEPTH = 1e-3
"""The same for a point in a face that may be as large as the mesh, where single precision is less accurate."""


def outer_faces(mesh: Mesh) -> BoolArray:
    """Return a mask (m,) of faces whose centres are visible from at least two of 60 directions.

    Args:
        mesh: Mesh with at least one face, some extent.

    Raises:
        MeshError: The mesh has no faces or no extent, which native code cannot handle.

    Cost: about 2 µs a face and direction; the first few directions settle most faces. 2 s for 200,000 faces.
    """
    if not len(mesh.faces) or mesh.size == 0:
        raise MeshError("the mesh has no faces to look at")
    # Unit size about the origin, so that single precision suffices for distant or tiny meshes.
    vertices = np.ascontiguousarray((mesh.vertices - mesh.bounds.mean(axis=0)) / mesh.size)
    centres = vertices[mesh.faces].mean(axis=1)
    normals = mesh.face_normals
    seen = np.zeros(len(centres), dtype=np.int64)
    for direction in fibonacci_sphere(DIRECTIONS)[_STRIDE * np.arange(DIRECTIONS) % DIRECTIONS]:
        asked = np.flatnonzero((seen < _SEEN_FROM) & (np.abs(normals @ direction) > _GRAZING))
        if len(asked):
            seen[asked[_hit_first(vertices, mesh.faces, centres, asked, direction)]] += 1
    return seen >= _SEEN_FROM


def seen_from_outside(mesh: Mesh, points: FloatArray, normals: FloatArray) -> BoolArray:
    """Return whether each point (k,) sees the outside of ``mesh`` in at least two of 24 directions.

    Args:
        mesh: Mesh with at least one face, some extent.
        points: (k, 3) [m] on the mesh.
        normals: (k, 3) outward unit normals; only directions on this side count.

    Cost: 1 µs a point and direction, and two search trees; the first half of the directions settles most points.
    """
    middle = mesh.bounds.mean(axis=0)
    vertices = np.ascontiguousarray((mesh.vertices - middle) / mesh.size)
    starts = (points - middle) / mesh.size
    seen = np.zeros(len(points), dtype=np.int64)
    directions = fibonacci_sphere(DIRECTIONS)[_STRIDE * np.arange(DIRECTIONS) % DIRECTIONS]
    for block in (directions[:_LOOKS], directions[_LOOKS : 2 * _LOOKS]):
        point, look = np.nonzero((seen < _SEEN_FROM)[:, None] & (normals @ block.T > _GRAZING))
        if len(point):
            hit, nearest, depth = _first_hits(vertices, mesh.faces, starts[point], block[look])
            np.add.at(seen, point[(hit < 0) | (nearest <= depth + _CLEAR_DEPTH)], 1)
    return seen >= _SEEN_FROM


def without_islands(mesh: Mesh, chosen: BoolArray, smallest: float) -> BoolArray:
    """Return the ``chosen`` faces (m,) with holes filled and islands removed that are smaller than ``smallest`` [m²].

    Args:
        mesh: Manifold. Components chosen as a whole, or not at all, are unchanged however small they are.
        chosen: (m,) faces.
        smallest: Area [m²].
    """
    component = mesh.connectivity.components
    share = np.bincount(component, chosen) / np.bincount(component)
    mixed = ((share > 0) & (share < 1))[component]
    filled = chosen | (_islands(mesh, ~chosen, smallest) & mixed)
    return np.asarray(filled & ~(_islands(mesh, filled, smallest) & mixed))


def fibonacci_sphere(count: int) -> FloatArray:
    """Return evenly distributed unit vectors (count, 3)."""
    k = np.arange(count) + 0.5
    z = 1 - 2 * k / count
    turn = np.pi * (1 + 5**0.5) * k
    radius = np.sqrt(1 - z**2)
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), z], axis=1)


def _hit_first(
    vertices: FloatArray, faces: IntArray, centres: FloatArray, asked: IntArray, direction: FloatArray
) -> BoolArray:
    """Return for each of the faces ``asked`` (k,) whether a ray from ``direction`` to its centre hits it first."""
    hit, nearest, depth = _first_hits(vertices, faces, centres[asked], np.tile(direction, (len(asked), 1)))
    # A miss is a ray through a crack between faces: nothing occludes the centre.
    return np.asarray((hit == asked) | (hit < 0) | (nearest <= depth + _SAME_DEPTH))


def _first_hits(
    vertices: FloatArray, faces: IntArray, points: FloatArray, directions: FloatArray
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return the first face (k,) hit by a ray along ``directions`` (k, 3) to each point, -1 for none.

    Also returned are the coordinates of the hit (k,) and of the point (k,) along the direction.
    """
    # The native ray runs in both directions; from two sizes away nothing is behind its start.
    depth = np.vecdot(points, directions)
    start = points + (2.0 - depth)[:, None] * directions
    hits = line_mesh_intersection(start, -directions, vertices, faces)
    hit = hits[:, 0].astype(np.int64)
    b = hits[:, 1]
    c = hits[:, 2]
    corners = np.vecdot(vertices[faces[np.maximum(hit, 0)]], directions[:, None])
    return hit, (1 - b - c) * corners[:, 0] + b * corners[:, 1] + c * corners[:, 2], depth


def _islands(mesh: Mesh, chosen: BoolArray, smallest: float) -> BoolArray:
    """Return a mask (m,) of chosen faces in connected groups of less area than ``smallest``."""
    result = np.zeros(len(chosen), dtype=bool)
    if chosen.any():
        group = Connectivity(mesh.faces[chosen]).components
        result[chosen] = (np.bincount(group, mesh.face_areas[chosen]) < smallest)[group]
    return result
