"""Which faces of a mesh are its outer surface: those that a straight line from far away comes to first.

Inner shells, parts inside other parts and the inner walls of hollow ones are seen from nowhere. A sheet is seen from
either side, so it does not matter how a file turned it.
"""

from __future__ import annotations

import numpy as np
from igl.embree import line_mesh_intersection

from app.arrays import BoolArray, FloatArray, IntArray
from app.errors import MeshError
from app.geometry.mesh import Mesh
from app.geometry.topology import face_components

DIRECTIONS = 60
_STRIDE = 23  # taken in this stride, the first few directions already look from all around
_SEEN_FROM = 2
_GRAZING = 0.1
_SAME_DEPTH = 1e-5
"""Share of the mesh's size within which a hit is the face's own: rays are traced in single precision."""


def outer_faces(mesh: Mesh) -> BoolArray:
    """(m,) faces whose centres are seen from at least two of 60 directions.

    Args:
        mesh: At least one face, some extent.

    Raises:
        MeshError: The mesh has no faces or no extent, which native code could not bear.

    Cost: about 2 µs a face and direction, and most faces are settled by the first few; 2 s for 200,000 faces.
    """
    if not len(mesh.faces) or mesh.size == 0:
        raise MeshError("the mesh has no faces to look at")
    # Unit size about the origin, so that single precision sees a far or tiny mesh as well as any.
    vertices = np.ascontiguousarray((mesh.vertices - mesh.bounds.mean(axis=0)) / mesh.size)
    centres, normals = vertices[mesh.faces].mean(axis=1), mesh.face_normals
    seen = np.zeros(len(centres), dtype=np.int64)
    for direction in fibonacci_sphere(DIRECTIONS)[_STRIDE * np.arange(DIRECTIONS) % DIRECTIONS]:
        asked = np.flatnonzero((seen < _SEEN_FROM) & (np.abs(normals @ direction) > _GRAZING))
        if len(asked):
            seen[asked[_foremost(vertices, mesh.faces, centres, asked, direction)]] += 1
    return seen >= _SEEN_FROM


def without_islands(mesh: Mesh, chosen: BoolArray, smallest: float) -> BoolArray:
    """(m,) the choice with holes and islands smaller than ``smallest`` [m²] filled and dropped.

    Args:
        mesh: Manifold. Pieces chosen as a whole, or not at all, stay so, however small they are.
        chosen: (m,) faces.
        smallest: Area [m²].
    """
    piece = face_components(mesh.faces)
    share = np.bincount(piece, chosen) / np.bincount(piece)
    mixed = ((share > 0) & (share < 1))[piece]
    filled = chosen | (_islands(mesh, ~chosen, smallest) & mixed)
    return np.asarray(filled & ~(_islands(mesh, filled, smallest) & mixed))


def fibonacci_sphere(count: int) -> FloatArray:
    """(count, 3) evenly spread unit vectors."""
    k = np.arange(count) + 0.5
    z, turn = 1 - 2 * k / count, np.pi * (1 + 5**0.5) * k
    radius = np.sqrt(1 - z**2)
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), z], axis=1)


def _foremost(
    vertices: FloatArray, faces: IntArray, centres: FloatArray, asked: IntArray, direction: FloatArray
) -> BoolArray:
    """(k,) which of the faces ``asked`` (k,) a ray from far along ``direction`` to their centre meets first."""
    # The native ray runs both ways; from two sizes away nothing lies behind its start.
    depth = centres[asked] @ direction
    start = centres[asked] + (2.0 - depth)[:, None] * direction
    rays = np.ascontiguousarray(np.broadcast_to(-direction, start.shape))
    hits = line_mesh_intersection(start, rays, vertices, faces)
    hit, b, c = hits[:, 0].astype(np.int64), hits[:, 1], hits[:, 2]
    corners = vertices[faces[np.maximum(hit, 0)]] @ direction
    nearest = (1 - b - c) * corners[:, 0] + b * corners[:, 1] + c * corners[:, 2]
    # A miss is a ray through a crack between faces: nothing stands in the way.
    return np.asarray((hit == asked) | (hit < 0) | (nearest <= depth + _SAME_DEPTH))


def _islands(mesh: Mesh, chosen: BoolArray, smallest: float) -> BoolArray:
    """(m,) chosen faces in connected groups of less area than ``smallest``."""
    result = np.zeros(len(chosen), dtype=bool)
    if chosen.any():
        group = face_components(mesh.faces[chosen])
        result[chosen] = (np.bincount(group, mesh.face_areas[chosen]) < smallest)[group]
    return result
