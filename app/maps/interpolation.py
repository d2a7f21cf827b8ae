"""Pressure between taxels: barycentric on the taxels' own triangulation of the map, patch by patch."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_matrix
from scipy.spatial import Delaunay, QhullError, cKDTree

from app.arrays import FloatArray, IntArray
from app.maps.tactile_map import TactileMap

_LONGEST_SIDE = 2.5
"""Triangles with a side longer than so many median spacings bridge a gap: there the nearest taxel speaks alone."""


def interpolation_weights(map_: TactileMap, patch: IntArray, points: FloatArray) -> csr_matrix:
    """Sparse (k, taxels): each row sums to one for a point on a patch, and is empty for patch -1.

    Barycentric inside the taxels' Delaunay triangles of the point's own patch, the nearest taxel elsewhere: a value is
    never taken from another patch and never beyond those of the taxels around it.

    Args:
        map_: The map.
        patch: (k,) patch of each point, -1 for none.
        points: (k, 2) [m].

    Cost: 100 ms for 100,000 points; using the matrix costs 0.2 ms.
    """
    rows, columns, values = [], [], []
    for number in range(len(map_.skin.patches)):
        asked = np.flatnonzero(patch == number)
        first, last = map_.skin.first[number], map_.skin.first[number + 1]
        taxels, weights = _weights_in_patch(map_.taxel_points[first:last], points[asked])
        rows.append(np.repeat(asked, 3))
        columns.append((taxels + first).ravel())
        values.append(weights.ravel())
    data = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))) if rows else ([], ([], []))
    matrix = csr_matrix(data, shape=(len(points), len(map_.skin)))
    matrix.eliminate_zeros()
    return matrix


def _weights_in_patch(sites: FloatArray, points: FloatArray) -> tuple[IntArray, FloatArray]:
    """Three taxels (k, 3) and their weights (k, 3) for points of one patch."""
    nearest = cKDTree(sites).query(points)[1] if len(points) else np.zeros(0, dtype=np.int64)
    taxels = np.repeat(nearest[:, None], 3, axis=1)
    weights = np.zeros((len(points), 3))
    weights[:, 0] = 1.0
    if len(sites) < 3 or not len(points):
        return taxels, weights
    try:
        triangulation = Delaunay(sites)
    except QhullError:
        return taxels, weights  # all taxels in one line: nearest is all there is
    corners = sites[triangulation.simplices]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    spacing = np.median(cKDTree(sites).query(sites, 2)[0][:, 1])
    simplex = triangulation.find_simplex(points)
    good = (simplex >= 0) & (longest[simplex] <= _LONGEST_SIDE * spacing)
    frames = triangulation.transform[simplex[good]]
    partial = np.einsum("kij,kj->ki", frames[:, :2], points[good] - frames[:, 2])
    inner = np.maximum(np.column_stack([partial, 1 - partial.sum(axis=1)]), 0.0)
    taxels[good] = triangulation.simplices[simplex[good]]
    weights[good] = inner / inner.sum(axis=1, keepdims=True)
    return taxels, weights
