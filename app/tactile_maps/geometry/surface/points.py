"""Sums and distances of points."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from tactile_maps.core.arrays import FloatArray, IntArray


def sums_by_label(labels: IntArray, rows: FloatArray, count: int = 0) -> FloatArray:
    """Return the sums (labels, k) of the rows (n, k) with each label (n,), for at least ``count`` labels."""
    return np.stack([np.bincount(labels, column, count) for column in rows.T], axis=1)


def nearest_others(points: FloatArray, most: int) -> tuple[FloatArray, IntArray]:
    """Return the distances and numbers (n, k) of the points nearest to each of ``points``, nearest first.

    Args:
        points: (n, d), distinct.
        most: The largest k; fewer where there are not so many other points.
    """
    count = min(most, len(points) - 1)
    if count < 1:
        return np.zeros((len(points), 0)), np.zeros((len(points), 0), dtype=np.int64)
    distances, numbers = cKDTree(points).query(points, k=count + 1)
    return distances[:, 1:], numbers[:, 1:].astype(np.int64)
