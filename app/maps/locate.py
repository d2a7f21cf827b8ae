"""Which triangle of the plane holds a point: exact, by a grid of candidates built once."""

from __future__ import annotations

import numpy as np

from app.arrays import FloatArray, IntArray
from app.maps.grid import BoxGrid

_TOLERANCE = 1e-9
"""Weights down to minus this still count as inside, so that rounding loses no point on a side."""

_AT_ONCE = 8192
"""Points whose candidates stay in the processor's cache."""


class PlaneLocator:
    """Finds containing triangles among many that do not overlap.

    Args:
        triangles: (t, 3, 2) corners, in either direction; a triangle without area holds no point.
    """

    def __init__(self, triangles: FloatArray) -> None:
        a, first, second = triangles[:, 0], triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
        area = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
        self._sound = area != 0
        safe = np.where(self._sound, area, 1.0)
        # Weight of corner 1 is row . (p - a) with the first row, of corner 2 with the second.
        self._origin = a
        self._rows = np.stack([second[:, 1], -second[:, 0], -first[:, 1], first[:, 0]], axis=1) / safe[:, None]
        self._grid: BoxGrid | None = None
        if len(triangles):
            low, high = triangles.min(axis=1), triangles.max(axis=1)
            slack = 4 * _TOLERANCE * float((high - low).max())
            # Half a box is the size at which building the grid and asking it a picture's pixels cost least together.
            size = 0.5 * float(np.sqrt(np.prod(high - low, axis=1).mean()))
            self._grid = BoxGrid(low - slack, high + slack, size)

    def query(self, points: FloatArray) -> tuple[IntArray, FloatArray]:
        """The triangle (k,) that holds each of ``points`` (k, 2), or -1, and the weights (k, 3) there, not negative.

        On a shared side it is one of the two; a point that is not finite is in none.
        """
        found, weights = np.full(len(points), -1, dtype=np.int64), np.zeros((len(points), 3))
        for start in range(0, len(points) if self._grid else 0, _AT_ONCE):
            part = slice(start, start + _AT_ONCE)
            self._find(points[part], found[part], weights[part])
        return found, weights

    def _find(self, points: FloatArray, found: IntArray, weights: FloatArray) -> None:
        """Fills in ``found`` (k,) and ``weights`` (k, 3) where a triangle holds a point."""
        assert self._grid is not None
        row, triangle = self._grid.candidates(points)
        x, y = (points[row] - self._origin[triangle]).T
        m = self._rows[triangle]
        second, third = m[:, 0] * x + m[:, 1] * y, m[:, 2] * x + m[:, 3] * y
        first = 1 - second - third
        depth = np.minimum(np.minimum(first, second), third)
        held = np.flatnonzero((depth >= -_TOLERANCE) & self._sound[triangle])
        inner = np.maximum(np.stack([first[held], second[held], third[held]], axis=1), 0.0)
        found[row[held]] = triangle[held]
        weights[row[held]] = inner / inner.sum(axis=1, keepdims=True)
