"""Touchable surface of rigidly joined shapes.

Where a core is inside its rubber pad, or the two are pressed together, the surface between them cannot be touched. A
face can be touched where a gap of ``_GAP`` on one of its sides is free: outside all of the shapes. Inside is decided
by winding number, with all pieces of a mesh turned outward, so that a cavity counts as inside.
"""

from __future__ import annotations

from collections.abc import Sequence

import igl
import numpy as np

from tactile_maps.core.arrays import BoolArray, FloatArray
from tactile_maps.geometry.remesh.refine import subdivide
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.geometry.surface.points import sums_by_label

_GAP = (5e-5, 5e-4)
"""Distances from a face [m] at which its side must be free. The first finds thin pads, the second spans small gaps."""
_LONGEST = 1e-3
_SHARE = 0.02
"""Faces near another shape are divided to edges of this length [m], or of this share of their shape's size."""


def touchable_surfaces(meshes: Sequence[Mesh]) -> list[Mesh | None]:
    """Return the part of each mesh that can be touched when all are joined; None where nothing can.

    Args:
        meshes: Cleaned (see ``clean_mesh``), in one frame [m].

    Returns:
        The mesh itself where none of its faces is hidden. Otherwise its faces near other shapes are divided, and the
        surface is not connected along them.

    Cost: nothing for shapes apart; 1 s of one core for two iCub links of 12,000 faces each, of which a third are near
    the other.
    """
    solids = [_turned_outward(mesh) for mesh in meshes]
    return [
        _touchable(mesh, [solids[number], *solids[:number], *solids[number + 1 :]])
        for number, mesh in enumerate(meshes)
    ]


def _touchable(mesh: Mesh, solids: Sequence[Mesh]) -> Mesh | None:
    """Return the part of ``mesh`` that can be touched; the first of the solids is its own."""
    low = mesh.corners.min(axis=1) - _GAP[-1]
    high = mesh.corners.max(axis=1) + _GAP[-1]
    near = np.zeros(len(mesh.faces), dtype=bool)
    for other in solids[1:]:
        near |= ((low <= other.bounds[1]) & (high >= other.bounds[0])).all(axis=1)
    if not near.any():
        return mesh
    longest = max(_LONGEST, _SHARE * mesh.size)
    divided = subdivide(Mesh(mesh.vertices, mesh.faces[near]), longest=longest).mesh
    free = _has_free_side(divided, solids)
    if free.all():
        return mesh
    faces = np.concatenate([mesh.faces[~near], divided.faces[free]])  # the vertices of the mesh are the first ones
    return Mesh(divided.vertices, faces) if len(faces) else None


def _turned_outward(mesh: Mesh) -> Mesh:
    """Return the mesh with each piece turned so that it encloses a positive volume."""
    pieces = mesh.connectivity.components
    corners = mesh.corners
    middles = sums_by_label(pieces, mesh.face_centres / np.bincount(pieces)[pieces][:, None])
    volumes = np.bincount(pieces, np.linalg.det(corners - middles[pieces][:, None]))
    return Mesh(mesh.vertices, np.where((volumes < 0)[pieces][:, None], mesh.faces[:, ::-1], mesh.faces))


def _has_free_side(mesh: Mesh, solids: Sequence[Mesh]) -> BoolArray:
    """Return (m,) for each face whether the gap on one of its sides is outside all solids."""
    centres = mesh.face_centres
    free = np.zeros(len(centres), dtype=bool)
    for side in (1, -1):
        left = np.flatnonzero(~free)
        for gap in _GAP:
            left = left[_outside(centres[left] + side * gap * mesh.face_normals[left], solids)]
        free[left] = True
    return free


def _outside(points: FloatArray, solids: Sequence[Mesh]) -> BoolArray:
    """Return (n,) for each of the points (n, 3) [m] whether it is in none of the solids."""
    outside = np.ones(len(points), dtype=bool)
    for solid in solids:
        low, high = solid.bounds
        near = np.flatnonzero(outside & ((points > low) & (points < high)).all(axis=1))
        if len(near):
            winding = igl.fast_winding_number(solid.vertices, solid.faces, np.ascontiguousarray(points[near]))
            outside[near] = winding <= 0.5
    return outside
