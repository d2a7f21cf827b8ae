"""Which triangle of the plane holds a point: a grid of candidate lists, built once."""

from __future__ import annotations

import numpy as np

from app.arrays import FloatArray, IntArray

_TOLERANCE = 1e-9


class PlaneLocator:
    """Finds containing triangles among many that do not overlap.

    Args:
        triangles: (t, 3, 2) corners.
    """

    def __init__(self, triangles: FloatArray) -> None:
        self._triangles = triangles
        if not len(triangles):
            return
        low, high = triangles.min(axis=1), triangles.max(axis=1)
        self._low = low.min(axis=0)
        # Cells of about the size of a triangle: a few candidates each, whatever the map's size.
        self._cell = max(float(np.sqrt(np.prod(high - low, axis=1).mean())), 1e-12)
        first = np.floor((low - self._low) / self._cell).astype(np.int64)
        spans = np.floor((high - self._low) / self._cell).astype(np.int64) - first + 1
        self._shape = (first + spans).max(axis=0)
        counts = spans.prod(axis=1)
        owner = np.repeat(np.arange(len(triangles)), counts)
        step = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
        x = first[owner, 0] + step % spans[owner, 0]
        y = first[owner, 1] + step // spans[owner, 0]
        cell = x * self._shape[1] + y
        order = np.argsort(cell, kind="stable")
        self._candidates = owner[order]
        self._start = np.searchsorted(cell[order], np.arange(self._shape.prod() + 1))

    def query(self, points: FloatArray) -> tuple[IntArray, FloatArray]:
        """The triangle (k,) that holds each of ``points`` (k, 2), or -1, and the weights (k, 3) there, not negative.

        On a shared side the triangle with the larger smallest weight wins, so rounding never loses a point.
        """
        found, weights = np.full(len(points), -1, dtype=np.int64), np.zeros((len(points), 3))
        if not len(self._triangles) or not len(points):
            return found, weights
        finite = np.isfinite(points).all(axis=1)
        cells = np.floor((np.where(finite[:, None], points, 0.0) - self._low) / self._cell)
        inside = finite & ((cells >= 0) & (cells < self._shape)).all(axis=1)
        asked = np.flatnonzero(inside)
        cell = (cells[asked] @ [self._shape[1], 1]).astype(np.int64)
        counts = self._start[cell + 1] - self._start[cell]
        row = np.repeat(asked, counts)
        step = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
        triangle = self._candidates[np.repeat(self._start[cell], counts) + step]
        candidate = _weights(self._triangles[triangle], points[row])
        smallest = candidate.min(axis=1)
        order = np.lexsort((smallest, row))
        last = np.flatnonzero(np.r_[row[order][1:] != row[order][:-1], True]) if len(row) else np.zeros(0, int)
        best = order[last]
        best = best[smallest[best] >= -_TOLERANCE]
        found[row[best]] = triangle[best]
        clipped = np.maximum(candidate[best], 0.0)
        weights[row[best]] = clipped / clipped.sum(axis=1, keepdims=True)
        return found, weights


def _weights(corners: FloatArray, points: FloatArray) -> FloatArray:
    """Signed barycentric weights (k, 3) of points (k, 2) in triangles (k, 3, 2)."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    area = _cross(b - a, c - a)
    safe = np.where(area != 0, area, 1.0)
    wb, wc = _cross(points - a, c - a) / safe, _cross(b - a, points - a) / safe
    weights = np.stack([1 - wb - wc, wb, wc], axis=1)
    return np.where((area != 0)[:, None], weights, -1.0)


def _cross(u: FloatArray, v: FloatArray) -> FloatArray:
    return u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
