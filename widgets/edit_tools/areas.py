"""What lies around some vertices of a mesh, without Qt: everything nearer to them, along each edge, than to others."""

from __future__ import annotations

import numpy as np

from app.arrays import BoolArray, FloatArray, IntArray
from app.geometry.topology import boundary_edges


def area_triangles(faces: IntArray, marked: BoolArray) -> IntArray:
    """(t, 3, 2) triangles that cover the area around ``marked`` (n,); each corner is halfway between two vertices."""
    one, two = _turned(faces, marked, 1), _turned(faces, ~marked, 1)
    whole = faces[marked[faces].all(axis=1)]
    parts = (
        np.stack([_mid(whole, k, k) for k in range(3)], axis=1),
        np.stack([_mid(one, 0, 0), _mid(one, 0, 1), _mid(one, 0, 2)], axis=1),
        np.stack([_mid(two, 1, 1), _mid(two, 2, 2), _mid(two, 0, 2)], axis=1),
        np.stack([_mid(two, 1, 1), _mid(two, 0, 2), _mid(two, 0, 1)], axis=1),
    )
    return np.concatenate(parts)


def area_outlines(faces: IntArray, marked: BoolArray, points: FloatArray) -> list[FloatArray]:
    """Each (k, 2): the loops around the area, holes too, on a chart with these ``faces`` and ``points`` (n, 2)."""
    one, two, rim = _turned(faces, marked, 1), _turned(faces, ~marked, 1), boundary_edges(faces)
    here, there = marked[rim].T
    inside, out, back = rim[here & there], rim[here & ~there], rim[there & ~here]
    starts = (_mid(one, 0, 1), _mid(two, 0, 2), _mid(inside, 0, 0), _mid(out, 0, 0), _mid(back, 0, 1))
    ends = (_mid(one, 0, 2), _mid(two, 0, 1), _mid(inside, 1, 1), _mid(out, 0, 1), _mid(back, 1, 1))
    pairs = [np.sort(np.concatenate(part), axis=1) @ [len(points), 1] for part in (starts, ends)]
    following = dict(zip(*(part.tolist() for part in pairs), strict=True))
    loops = []
    while following:
        node, after = following.popitem()
        loop = [node]
        while after in following:
            loop.append(after)
            after = following.pop(after)
        loops.append(points[np.stack(np.divmod(loop, len(points)), axis=1)].mean(axis=1))
    return loops


def _turned(faces: IntArray, marked: BoolArray, count: int) -> IntArray:
    """(k, 3) faces with so many marked corners, turned so that a marked one comes first."""
    own = faces[marked[faces].sum(axis=1) == count]
    first = marked[own].argmax(axis=1)
    return own[np.arange(len(own))[:, None], (first[:, None] + np.arange(3)) % 3]


def _mid(faces: IntArray, a: int, b: int) -> IntArray:
    """(k, 2) the pairs of vertices between which points lie halfway; a vertex itself where both are the same."""
    return faces[:, [a, b]]
