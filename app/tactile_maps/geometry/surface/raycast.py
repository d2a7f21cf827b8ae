"""Rays against a mesh: where one first meets it, and which faces can be seen from outside.

``RayCaster`` is a search tree built once, asked at every move of the mouse.

``outer_faces`` finds the outer surface of a mesh: the faces that a straight line from far away comes to first. Inner
shells, parts inside other parts and the inner walls of hollow ones are seen from nowhere. A sheet is seen from either
side, so it does not matter how a file turned it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from igl.embree import EmbreeIntersector, line_mesh_intersection

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray
from tactile_maps.core.errors import MeshError
from tactile_maps.core.weak_cache import weak_cache
from tactile_maps.geometry.surface.closest_point import barycentric
from tactile_maps.geometry.surface.connectivity import Connectivity
from tactile_maps.geometry.surface.mesh import Mesh


@dataclass(frozen=True)
class RayHit:
    """The first meeting of a ray and a mesh.

    Attributes:
        face: Which triangle.
        weights: Barycentric weights there.
        distance: Along the ray [m].
    """

    face: int
    weights: tuple[float, float, float]
    distance: float


class RayCaster:
    """Casts rays against one mesh, in the mesh's own frame; a moving link moves the ray instead.

    Args:
        mesh: At least one face.
    """

    def __init__(self, mesh: Mesh) -> None:
        if not len(mesh.faces):
            raise MeshError("the mesh has no faces to hit")
        # Embree works in single precision: centre and scale first, so that far or tiny meshes keep their digits.
        self._vertices = mesh.vertices
        self._faces = mesh.faces
        self._normals = mesh.face_normals
        self._centre = mesh.bounds.mean(axis=0)
        self._size = mesh.size or 1.0
        local = np.ascontiguousarray((mesh.vertices - self._centre) / self._size, dtype=np.float32)
        self._tree = EmbreeIntersector()
        self._tree.init(local, np.ascontiguousarray(mesh.faces, dtype=np.int32))

    def first_hit(self, origin: FloatArray, direction: FloatArray) -> RayHit | None:
        """The nearest face along the ray, from either side, or None when it misses.

        Args:
            origin: (3,) [m].
            direction: (3,), not zero; its length does not matter.
        """
        raise_if_bad(origin, direction)
        unit = np.asarray(direction, dtype=np.float64) / np.linalg.norm(direction)
        start = (np.asarray(origin, dtype=np.float64) - self._centre) / self._size
        # Start near the mesh: single precision loses a millimetre when the camera is a kilometre away.
        forward = max(float(-start @ unit) - 1.0, 0.0)
        near = (start + forward * unit).astype(np.float32)
        face, distance, _, _ = self._tree.intersectRay_first(near, unit.astype(np.float32))
        if face < 0 or not np.isfinite(distance):
            return None
        along = (forward + distance) * self._size
        return self._exact(int(face), np.asarray(origin, dtype=np.float64), unit, along)

    def _exact(self, face: int, origin: FloatArray, unit: FloatArray, along: float) -> RayHit:
        """Meet the face's plane again in double precision; grazing rays keep the single-precision distance."""
        corners = self._vertices[self._faces[face]]
        normal = self._normals[face]
        slope = float(normal @ unit)
        if abs(slope) > 1e-6:
            along = float(normal @ (corners[0] - origin)) / slope
        a, b, c = barycentric(corners[None], (origin + along * unit)[None])[0]
        return RayHit(face, (float(a), float(b), float(c)), along)


@weak_cache
def ray_caster(mesh: Mesh) -> RayCaster:
    """The search tree of a mesh that is looked at again and again, kept while the mesh lives."""
    return RayCaster(mesh)


def raise_if_bad(origin: FloatArray, direction: FloatArray) -> None:
    """Refuse a ray that native code cannot handle."""
    if not (np.isfinite(origin).all() and np.isfinite(direction).all() and np.linalg.norm(direction) > 0):
        raise MeshError("a ray needs a finite origin and a direction", value=(list(origin), list(direction)))


DIRECTIONS = 60
_STRIDE = 23  # taken in this stride, the first few directions already look from all around
_SEEN_FROM = 2
_LOOKS = 12
_GRAZING = 0.1
_SAME_DEPTH = 1e-5
"""Share of the mesh's size within which a hit is the face's own: rays are traced in single precision."""
_CLEAR_DEPTH = 1e-3
"""The same for a point in a face that may be as large as the mesh, where single precision is worse."""


def outer_faces(mesh: Mesh) -> BoolArray:
    """(m,) faces whose centres are seen from at least two of 60 directions.

    Args:
        mesh: At least one face, some extent.

    Raises:
        MeshError: The mesh has no faces or no extent, which native code cannot handle.

    Cost: about 2 µs a face and direction, and most faces are settled by the first few; 2 s for 200,000 faces.
    """
    if not len(mesh.faces) or mesh.size == 0:
        raise MeshError("the mesh has no faces to look at")
    # Unit size about the origin, so that single precision sees a far or tiny mesh as well as any.
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
    """Return (k,) which points see the outside of ``mesh`` in at least two of 24 directions.

    Args:
        mesh: At least one face, some extent.
        points: (k, 3) [m] on the mesh.
        normals: (k, 3) outward unit normals there; only directions on this side count.

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
    """(m,) the choice with holes and islands smaller than ``smallest`` [m²] filled and dropped.

    Args:
        mesh: Manifold. Pieces chosen as a whole, or not at all, stay so, however small they are.
        chosen: (m,) faces.
        smallest: Area [m²].
    """
    component = mesh.connectivity.components
    share = np.bincount(component, chosen) / np.bincount(component)
    mixed = ((share > 0) & (share < 1))[component]
    filled = chosen | (_islands(mesh, ~chosen, smallest) & mixed)
    return np.asarray(filled & ~(_islands(mesh, filled, smallest) & mixed))


def fibonacci_sphere(count: int) -> FloatArray:
    """(count, 3) evenly spread unit vectors."""
    k = np.arange(count) + 0.5
    z = 1 - 2 * k / count
    turn = np.pi * (1 + 5**0.5) * k
    radius = np.sqrt(1 - z**2)
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), z], axis=1)


def _hit_first(
    vertices: FloatArray, faces: IntArray, centres: FloatArray, asked: IntArray, direction: FloatArray
) -> BoolArray:
    """(k,) which of the faces ``asked`` (k,) a ray from far along ``direction`` to their centre meets first."""
    hit, nearest, depth = _first_hits(vertices, faces, centres[asked], np.tile(direction, (len(asked), 1)))
    # A miss is a ray through a crack between faces: nothing stands in the way.
    return np.asarray((hit == asked) | (hit < 0) | (nearest <= depth + _SAME_DEPTH))


def _first_hits(
    vertices: FloatArray, faces: IntArray, points: FloatArray, directions: FloatArray
) -> tuple[IntArray, FloatArray, FloatArray]:
    """First face (k,) on a ray from far along ``directions`` (k, 3) to each point, -1 for none; how far along the
    direction the ray meets it (k,), and how far the point is (k,).
    """
    # The native ray runs both ways; from two sizes away nothing lies behind its start.
    depth = np.vecdot(points, directions)
    start = points + (2.0 - depth)[:, None] * directions
    hits = line_mesh_intersection(start, -directions, vertices, faces)
    hit = hits[:, 0].astype(np.int64)
    b = hits[:, 1]
    c = hits[:, 2]
    corners = np.vecdot(vertices[faces[np.maximum(hit, 0)]], directions[:, None])
    return hit, (1 - b - c) * corners[:, 0] + b * corners[:, 1] + c * corners[:, 2], depth


def _islands(mesh: Mesh, chosen: BoolArray, smallest: float) -> BoolArray:
    """(m,) chosen faces in connected groups of less area than ``smallest``."""
    result = np.zeros(len(chosen), dtype=bool)
    if chosen.any():
        group = Connectivity(mesh.faces[chosen]).components
        result[chosen] = (np.bincount(group, mesh.face_areas[chosen]) < smallest)[group]
    return result
