"""A regular grid over the plane that lists which boxes touch which cell: the coarse half of every search on the map."""

from __future__ import annotations

import numpy as np

from app.arrays import FloatArray, IntArray

_MOST_CELLS = 4_000_000


class BoxGrid:
    """Axis-aligned boxes sorted into square cells. Built once from frozen boxes, asked often.

    Args:
        low: (b, 2) lower-left corners, at least one.
        high: (b, 2) upper-right corners.
        cell: Side of a cell, in the same unit; about a box's size keeps the lists short. Made larger where the plane
            would need more than four million cells.
    """

    def __init__(self, low: FloatArray, high: FloatArray, cell: float) -> None:
        self._low = low.min(axis=0)
        extent = high.max(axis=0) - self._low
        self._cell = max(cell, float(np.sqrt(np.prod(extent) / _MOST_CELLS)), float(extent.max()) / _MOST_CELLS, 1e-300)
        first = np.floor((low - self._low) / self._cell).astype(np.int64)
        spans = np.floor((high - self._low) / self._cell).astype(np.int64) - first + 1
        self._shape: IntArray = (first + spans).max(axis=0)
        counts = spans.prod(axis=1)
        owner, step = ranges(counts)
        row = first[owner, 0] + step % spans[owner, 0]
        column = first[owner, 1] + step // spans[owner, 0]
        key = row * self._shape[1] + column
        order = np.argsort(key, kind="stable")
        self._boxes = owner[order]
        self._start = np.searchsorted(key[order], np.arange(int(self._shape.prod()) + 1))

    def candidates(self, points: FloatArray) -> tuple[IntArray, IntArray]:
        """Pairs (point, box) for ``points`` (k, 2), such that every box that holds a point is among them."""
        cells = np.floor((np.where(np.isfinite(points), points, -np.inf) - self._low) / self._cell)
        asked = np.flatnonzero((cells[:, 0] >= 0) & (cells[:, 1] >= 0) & np.all(cells < self._shape, axis=1))
        cell = cells[asked, 0].astype(np.int64) * self._shape[1] + cells[asked, 1].astype(np.int64)
        row, step = ranges(self._start[cell + 1] - self._start[cell])
        return asked[row], self._boxes[self._start[cell][row] + step]

    def pairs(self) -> tuple[IntArray, IntArray]:
        """Pairs (i, j), i < j and each once, of boxes that share a cell."""
        ends = np.repeat(self._start[1:], np.diff(self._start))
        row, step = ranges(ends - np.arange(len(self._boxes)) - 1)
        i, j = self._boxes[row], self._boxes[row + 1 + step]
        count = int(self._boxes.max()) + 1
        return np.divmod(np.unique(np.minimum(i, j) * count + np.maximum(i, j)), count)


def ranges(counts: IntArray) -> tuple[IntArray, IntArray]:
    """For counts (2, 3): owners (0, 0, 1, 1, 1) and steps (0, 1, 0, 1, 2)."""
    owner = np.repeat(np.arange(len(counts)), counts)
    return owner, np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)
