"""Exact point location in the plane with a precomputed grid of candidates.

``BoxGrid`` is a regular grid that lists the boxes overlapping each cell, the coarse step of every search on the map.
``PointLocator`` tests the candidate triangles of a point by their barycentric weights.
"""

from __future__ import annotations

import numpy as np

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.geometry.surface.plane import cross

_MOST_CELLS = 4_000_000


class BoxGrid:
    """Axis-aligned boxes sorted into square cells. Built once, queried often.

    Args:
        low: (b, 2) lower-left corners, at least one.
        high: (b, 2) upper-right corners.
        cell: Side of a cell in the same unit; about the size of a box keeps the lists short. Increased where the plane
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
        owner, step = owner_and_rank(counts)
        row = first[owner, 0] + step % spans[owner, 0]
        column = first[owner, 1] + step // spans[owner, 0]
        key = row * self._shape[1] + column
        order = np.argsort(key, kind="stable")
        self._boxes = owner[order]
        self._start = np.searchsorted(key[order], np.arange(int(self._shape.prod()) + 1))

    def candidates(self, points: FloatArray) -> tuple[IntArray, IntArray]:
        """Return pairs (point, box) for ``points`` (k, 2) that include every box containing a point."""
        cells = np.floor((np.where(np.isfinite(points), points, -np.inf) - self._low) / self._cell)
        asked = np.flatnonzero((cells[:, 0] >= 0) & (cells[:, 1] >= 0) & np.all(cells < self._shape, axis=1))
        cell = cells[asked, 0].astype(np.int64) * self._shape[1] + cells[asked, 1].astype(np.int64)
        row, step = owner_and_rank(self._start[cell + 1] - self._start[cell])
        return asked[row], self._boxes[self._start[cell][row] + step]

    def pairs(self) -> tuple[IntArray, IntArray]:
        """Return pairs (i, j), i < j and each once, of boxes that share a cell."""
        ends = np.repeat(self._start[1:], np.diff(self._start))
        row, step = owner_and_rank(ends - np.arange(len(self._boxes)) - 1)
        i = self._boxes[row]
        j = self._boxes[row + 1 + step]
        count = int(self._boxes.max()) + 1
        return np.divmod(np.unique(np.minimum(i, j) * count + np.maximum(i, j)), count)


def owner_and_rank(counts: IntArray) -> tuple[IntArray, IntArray]:
    """Expand counts into owners and ranks: (2, 3) gives owners (0, 0, 1, 1, 1) and ranks (0, 1, 0, 1, 2)."""
    owner = np.repeat(np.arange(len(counts)), counts)
    return owner, np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)


_TOLERANCE = 1e-9
"""Weights down to minus this count as inside, so that rounding loses no point on a side."""

_BLOCK = 8192
"""Number of points whose candidates fit in the processor's cache."""


class PointLocator:
    """Finds the containing triangle among many that do not overlap.

    Args:
        triangles: (t, 3, 2) corners in either orientation; a triangle without area contains no point.
    """

    def __init__(self, triangles: FloatArray) -> None:
        a = triangles[:, 0]
        first = triangles[:, 1] - triangles[:, 0]
        second = triangles[:, 2] - triangles[:, 0]
        area = cross(first, second)
        self._sound = area != 0
        safe = np.where(self._sound, area, 1.0)
        # Weight of corner 1 is row . (p - a) with the first row, of corner 2 with the second.
        self._origin = a
        self._rows = np.stack([second[:, 1], -second[:, 0], -first[:, 1], first[:, 0]], axis=1) / safe[:, None]
        self._grid: BoxGrid | None = None
        if len(triangles):
            low = triangles.min(axis=1)
            high = triangles.max(axis=1)
            slack = 4 * _TOLERANCE * float((high - low).max())
            # At half the size of a box the total cost of building the grid and querying an image's pixels is least.
            size = 0.5 * float(np.sqrt(np.prod(high - low, axis=1).mean()))
            self._grid = BoxGrid(low - slack, high + slack, size)

    def query(self, points: FloatArray) -> tuple[IntArray, FloatArray]:
        """Return the triangle (k,) that contains each of ``points`` (k, 2), or -1, and weights (k, 3) >= 0 in it.

        On a shared side one of the two is returned; a point that is not finite is in none.
        """
        found = np.full(len(points), -1, dtype=np.int64)
        weights = np.zeros((len(points), 3))
        for start in range(0, len(points) if self._grid else 0, _BLOCK):
            part = slice(start, start + _BLOCK)
            self._find(points[part], found[part], weights[part])
        return found, weights

    def _find(self, points: FloatArray, found: IntArray, weights: FloatArray) -> None:
        """Fill ``found`` (k,) and ``weights`` (k, 3) for points inside a triangle."""
        assert self._grid is not None
        row, triangle = self._grid.candidates(points)
        x, y = (points[row] - self._origin[triangle]).T
        m = self._rows[triangle]
        second = m[:, 0] * x + m[:, 1] * y
        third = m[:, 2] * x + m[:, 3] * y
        first = 1 - second - third
        depth = np.minimum(np.minimum(first, second), third)
        held = np.flatnonzero((depth >= -_TOLERANCE) & self._sound[triangle])
        inner = np.maximum(np.stack([first[held], second[held], third[held]], axis=1), 0.0)
        found[row[held]] = triangle[held]
        weights[row[held]] = inner / inner.sum(axis=1, keepdims=True)
