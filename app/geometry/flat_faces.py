"""Faces without area taken out of a surface without leaving a slit.

A face whose three corners lie on a line has its middle corner on its longest side. Turning that side towards the face
behind it (an edge flip) splits the face behind at the middle corner: the same points, no face without area, no hole.
"""

from __future__ import annotations

import numpy as np

from app.arrays import BoolArray, FloatArray, IntArray
from app.geometry.orient import paired_sides

_ROUNDS = 1000  # a fan of flat faces along one edge is unfolded one a round


def is_flat(corners: FloatArray, tolerance: float) -> BoolArray:
    """(m,) whether the height over the longest side of triangles ``corners`` (m, 3, 3) is at most ``tolerance``."""
    longest = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2).max(axis=1)
    doubled = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    return np.asarray(doubled <= tolerance * longest)


def flip_flat_faces(vertices: FloatArray, faces: IntArray, tolerance: float) -> tuple[IntArray, IntArray, BoolArray]:
    """Flip flat faces away.

    Args:
        vertices: (n, 3).
        faces: (m, 3), at most two beside an edge, oriented alike.
        tolerance: Height below which a face is flat, in the unit of ``vertices``.

    Returns:
        (m, 3) faces; (m,) which of the old faces each lies in; (m,) those still flat: on the border, where they may
        simply go, or folded so that no flip helps.
    """
    faces, owner = faces.copy(), np.arange(len(faces))
    flat = is_flat(vertices[faces], tolerance)
    for _ in range(_ROUNDS if flat.any() else 0):
        face, behind, corners = _flips(vertices, faces, flat)
        first, second = corners[:, [0, 1, 3]], corners[:, [1, 2, 3]]
        helps = ~(is_flat(vertices[first], tolerance) | is_flat(vertices[second], tolerance))
        chosen = np.flatnonzero(helps)[_apart(face[helps], behind[helps], corners[helps][:, [1, 3]])]
        if not len(chosen):
            break
        faces[behind[chosen]], faces[face[chosen]] = first[chosen], second[chosen]
        owner[face[chosen]] = owner[behind[chosen]]
        flat[face[chosen]] = False
    return faces, owner, flat


def _flips(vertices: FloatArray, faces: IntArray, flat: BoolArray) -> tuple[IntArray, IntArray, IntArray]:
    """Flat faces that could be flipped, the faces behind their longest sides, and corners a, b, c, d of the two.

    Corner b lies on side c-a of the flat face, d is the far corner of the face behind.
    """
    touched = np.zeros(int(faces.max()) + 1, dtype=bool)
    touched[faces[flat]] = True
    near = np.flatnonzero(touched[faces].any(axis=1))  # all that meets a flat face, and nothing else
    local = faces[near]
    sides = paired_sides(local)
    sides = np.concatenate([sides, sides[:, ::-1]])
    lengths = np.linalg.norm(vertices[local] - vertices[local[:, [1, 2, 0]]], axis=2)
    longest = lengths.argmax(axis=1)[sides[:, 0] // 3] == sides[:, 0] % 3
    sides = sides[longest & flat[near[sides[:, 0] // 3]] & ~flat[near[sides[:, 1] // 3]]]
    corner = local.ravel()
    c, a, b = (corner[sides[:, 0] - sides[:, 0] % 3 + (sides[:, 0] + k) % 3] for k in range(3))
    d = corner[sides[:, 1] - sides[:, 1] % 3 + (sides[:, 1] + 2) % 3]
    base = int(faces.max()) + 1
    taken = np.unique(np.minimum(local, local[:, [1, 2, 0]]) * base + np.maximum(local, local[:, [1, 2, 0]]))
    free = (b != d) & ~np.isin(np.minimum(b, d) * base + np.maximum(b, d), taken)
    return near[sides[free, 0] // 3], near[sides[free, 1] // 3], np.stack([a, b, c, d], axis=1)[free]


def _apart(face: IntArray, behind: IntArray, edge: IntArray) -> IntArray:
    """Numbers of flips that touch no face twice and make no edge twice, so that all may be done at once."""
    number = np.arange(len(face))
    claim = np.full(int(max(face.max(initial=0), behind.max(initial=0))) + 1, len(face))
    np.minimum.at(claim, face, number)
    np.minimum.at(claim, behind, number)
    alone = np.flatnonzero((claim[face] == number) & (claim[behind] == number))
    low, high = edge[alone].min(axis=1), edge[alone].max(axis=1)
    return alone[np.unique(low * (int(edge.max(initial=0)) + 1) + high, return_index=True)[1]]
