"""Points in boxes, so that a body far from a box need not be asked about each point in it."""

from __future__ import annotations

import numpy as np

from app.arrays import FloatArray, IntArray
from app.touch.load import Load


class Cells:
    """Points sorted into cubes. Built once.

    Args:
        positions: (n, 3) [m], link frame.
        size: Edge of the cubes [m]; with 8 spacings a cube holds some 60 points of a surface.

    Attributes:
        order: (n,) the points, cube after cube; ``members`` are places in it.
    """

    def __init__(self, positions: FloatArray, size: float) -> None:
        grid = np.floor((positions - positions.min(axis=0)) / size).astype(np.int64)
        wide, high = grid.max(axis=0)[1:] + 1
        _, cell, counts = np.unique(
            (grid[:, 0] * wide + grid[:, 1]) * high + grid[:, 2], return_inverse=True, return_counts=True
        )
        self.order: IntArray = np.argsort(cell, kind="stable")
        self._counts, self._starts = counts, np.cumsum(counts) - counts
        self._centres = np.stack([np.bincount(cell, positions[:, k]) for k in range(3)], axis=1) / counts[:, None]
        away = np.linalg.norm(positions - self._centres[cell], axis=1)
        self._radii = np.maximum.reduceat(away[self.order], self._starts)

    def lowest(self, load: Load) -> FloatArray:
        """(cells,) a distance [m] from the load's body that no point of the cell can be below."""
        return load.distances(self._centres) - self._radii

    def members(self, cells: IntArray) -> IntArray:
        """Places in ``order`` of the points in ``cells``, cell after cell."""
        counts = self._counts[cells]
        ends = np.cumsum(counts)
        return np.arange(counts.sum()) + np.repeat(self._starts[cells] - ends + counts, counts)
