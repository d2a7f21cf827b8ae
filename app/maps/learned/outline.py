"""One simple border around points: their triangulation with the sides that are too long taken away from outside."""

from __future__ import annotations

import heapq
from dataclasses import dataclass

import numpy as np
from scipy.spatial import Delaunay, QhullError, cKDTree

from app.arrays import FloatArray, IntArray
from app.errors import MapError
from app.maps.bijective import signed_areas
from app.maps.interpolation.triangles import LONGEST_SIDE

_THINNEST = 1e-9
"""A triangle with less area for its longest side's square is a line by rounding."""


@dataclass(frozen=True, eq=False)
class Outlined:
    """Triangles over points.

    Attributes:
        faces: (m, 3) counter-clockwise; together a disk with one simple border.
        bridging: How many have a side that is too long, yet hold the disk together or span a hole inside.
    """

    faces: IntArray
    bridging: int


def outlined(points: FloatArray) -> Outlined:
    """The characteristic shape of ``points`` (n, 2): Duckham, Kulik, Worboys and Galton 2008.

    From the convex hull's Delaunay triangles, those at the border whose outer side is longer than ``LONGEST_SIDE``
    spacings are taken off, the longest first, as long as what is left is one piece with a simple border through all of
    its corners. So every point stays a corner, nothing is folded, and gaps open to the outside are not bridged; a gap
    inside, and what ties two far groups together, must be.

    Args:
        points: (n, 2), no two the same.

    Raises:
        MapError: Fewer than three points, or all in one line.

    Cost: 15 ms for 1000 points.
    """
    try:
        faces = np.asarray(Delaunay(points).simplices, dtype=np.int64)
    except (QhullError, ValueError) as error:
        raise MapError(
            "taxels in one line span no map", value=f"{len(points)} points", remedy="Record touches all over the skin"
        ) from error
    faces = np.where((signed_areas(points, faces) < 0)[:, None], faces[:, ::-1], faces)
    sides = np.linalg.norm(points[faces] - np.roll(points[faces], -1, axis=1), axis=2)
    longest = sides.max(axis=1)
    limit = longest_side(points)
    thin = signed_areas(points, faces) <= _THINNEST * longest**2
    kept = _peeled(faces, np.where(thin[:, None], np.inf, sides), limit)
    if thin[kept].any():
        raise MapError("taxels lie in one line on the learned map", value=f"{int(thin[kept].sum())} triangles")
    return Outlined(faces[kept], int((longest[kept] > limit).sum()))


def longest_side(points: FloatArray) -> float:
    """Triangles over ``points`` (n, 2) with a longer side bridge a gap."""
    return LONGEST_SIDE * float(np.median(cKDTree(points).query(points, 2)[0][:, 1]))


def _peeled(faces: IntArray, sides: FloatArray, limit: float) -> IntArray:
    """Numbers of the faces (m,) that stay.

    Args:
        faces: (m, 3).
        sides: (m, 3) length from corner k to corner k + 1.
        limit: Longer sides go.
    """
    beside = {(int(face[k]), int(face[(k + 1) % 3])): (n, k) for n, face in enumerate(faces) for k in range(3)}
    border = {start for start, end in beside if (end, start) not in beside}
    border |= {end for start, end in beside if (end, start) not in beside}
    queue = [(-sides[n, k], n, k) for (start, end), (n, k) in beside.items() if (end, start) not in beside]
    queue = [item for item in queue if -item[0] > limit]
    heapq.heapify(queue)
    gone: set[int] = set()
    while queue and len(gone) < len(faces) - 1:
        _, number, k = heapq.heappop(queue)
        corner = int(faces[number, (k + 2) % 3])
        if corner in border:
            continue  # taking it off would cut the piece in two, or leave a corner without a face
        gone.add(number)
        border.add(corner)
        for turn in (1, 2):
            start, end = int(faces[number, (k + turn) % 3]), int(faces[number, (k + turn + 1) % 3])
            other, side = beside[end, start]
            if sides[other, side] > limit:
                heapq.heappush(queue, (-sides[other, side], other, side))
    return np.setdiff1d(np.arange(len(faces)), np.array(sorted(gone), dtype=np.int64))
