"""A surface with vertices where one wants to measure; its shape stays exactly what it was."""

from __future__ import annotations

import numpy as np

from app.arrays import FloatArray, IntArray
from app.geometry.mesh import Mesh

SNAP = 2e-3
"""A point this near to a corner, as a share of the face, is taken to be that corner."""
INSET = 1e-3
"""A point on a side is moved this share of the face inwards: it must not cut a face without area off."""


def insert_points(surface: Mesh, faces: IntArray, weights: FloatArray) -> tuple[Mesh, IntArray]:
    """Give ``surface`` a vertex at each of ``faces`` (k,), ``weights`` (k, 3): the mesh and their vertices (k,).

    Each round splits every face that still holds a point into three at one of its points; the others of that face
    then lie in one of the three. Points in the same place share a vertex. A point moves at most ``SNAP`` of its face.

    Args:
        surface: Its vertices keep their numbers; new ones follow.
        faces: Triangle of each point.
        weights: Barycentric, not negative.

    Cost: one round for each point in the fullest face; 2 ms for 1000 points on 10,000 faces.
    """
    vertices, triangles = [surface.vertices], surface.faces.copy()
    face, weight, vertex_of = faces.copy(), weights.copy(), np.full(len(faces), -1, dtype=np.int64)
    count = len(surface.vertices)
    while True:
        open_ = vertex_of < 0
        at_corner = open_ & (weight.max(axis=1) >= 1 - SNAP)
        vertex_of[at_corner] = triangles[face[at_corner], weight[at_corner].argmax(axis=1)]
        waiting = np.flatnonzero(open_ & ~at_corner)
        if not len(waiting):
            return Mesh(np.concatenate(vertices), triangles), vertex_of
        split, first = np.unique(face[waiting], return_index=True)
        chosen = waiting[first]
        middle = np.maximum(weight[chosen], INSET)
        middle /= middle.sum(axis=1, keepdims=True)
        corners = triangles[split]
        vertices.append(np.einsum("kc,kcd->kd", middle, np.concatenate(vertices)[corners]))
        new = count + np.arange(len(chosen))
        count, vertex_of[chosen] = count + len(chosen), new
        children = _children(split, len(triangles))
        triangles = _split(triangles, split, new)
        others = np.setdiff1d(waiting, chosen)
        number = np.searchsorted(split, face[others])
        side, weight[others] = _within(weight[others], middle[number])
        face[others] = children[number, side]


def _children(split: IntArray, count: int) -> IntArray:
    """(s, 3) numbers of the faces opposite corner 0, 1 and 2; the last keeps the old face's number."""
    after = count + np.arange(2 * len(split))
    return np.stack([after[: len(split)], after[len(split) :], split], axis=1)


def _split(triangles: IntArray, split: IntArray, new: IntArray) -> IntArray:
    a, b, c = triangles[split].T
    triangles = triangles.copy()
    triangles[split] = np.stack([a, b, new], axis=1)
    return np.concatenate([triangles, np.stack([b, c, new], axis=1), np.stack([c, a, new], axis=1)])


def _within(weights: FloatArray, middle: FloatArray) -> tuple[IntArray, FloatArray]:
    """Of points ``weights`` (k, 3) in faces split at ``middle`` (k, 3): which child (k,), and the weights there."""
    ratio = weights / middle
    side = ratio.argmin(axis=1)
    row = np.arange(len(side))
    share = ratio[row, side]
    rest = weights - share[:, None] * middle
    return side, np.stack([rest[row, (side + 1) % 3], rest[row, (side + 2) % 3], share], axis=1)
