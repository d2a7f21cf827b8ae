"""Sums and distances of points, and places along polylines."""

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


def cumulative_lengths(line: FloatArray) -> FloatArray:
    """Return the length along a polyline from its start to each of its points (k, d)."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])


def points_along(line: FloatArray, lengths: FloatArray, at: FloatArray) -> FloatArray:
    """Return points (m, d) of a polyline (k, d) at the places ``at`` (m,), by the ``lengths`` (k,) of its points."""
    return np.stack([np.interp(at, lengths, column) for column in line.T], axis=1)
