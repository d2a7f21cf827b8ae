"""Iso-lines of the tactile image by marching squares: short segments, unordered, exact on the bilinear grid edges."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.arrays import FloatArray

# Edges of a cell: 0 top, 1 right, 2 bottom, 3 left.
# Bits of its corners: 1 top left, 2 top right, 4 bottom right, 8 bottom left.
_SEGMENTS = {
    1: [(3, 0)], 2: [(0, 1)], 3: [(3, 1)], 4: [(1, 2)], 5: [(3, 0), (1, 2)], 6: [(0, 2)], 7: [(3, 2)],
    8: [(2, 3)], 9: [(0, 2)], 10: [(0, 1), (2, 3)], 11: [(1, 2)], 12: [(3, 1)], 13: [(0, 1)], 14: [(3, 0)],
}  # fmt: skip
_TABLE = np.full((16, 2, 2), -1)
for _case, _pairs in _SEGMENTS.items():
    _TABLE[_case, : len(_pairs)] = _pairs


def contour_segments(image: NDArray[Any], level: float) -> FloatArray:
    """The line ``image == level``.

    Args:
        image: (h, w) finite values at pixel centres.
        level: Values at or above it are inside.

    Returns:
        (s, 2, 2) segments as (column, row) with the first pixel's centre at (0, 0). Cost: 0.3 ms for 512² pixels.
    """
    inside = (image >= level).view(np.uint8)
    upper = inside[:-1, :-1] | inside[:-1, 1:] << 1
    lower = inside[1:, 1:] << 2 | inside[1:, :-1] << 3
    cases = upper | lower
    rows, columns = np.nonzero((cases > 0) & (cases < 15))
    edges = _TABLE[cases[rows, columns]]
    crossings = _crossings(image, rows, columns, level)
    cell, pair = np.nonzero(edges[..., 0] >= 0)
    ends = edges[cell, pair]
    return crossings[cell[:, None], ends]


def _crossings(image: NDArray[Any], rows: NDArray[np.intp], columns: NDArray[np.intp], level: float) -> FloatArray:
    """(cells, 4, 2) where the level crosses each edge; meaningless for edges it does not cross."""
    corner = [image[rows + dr, columns + dc].astype(np.float64) for dr, dc in ((0, 0), (0, 1), (1, 1), (1, 0))]
    points = np.empty((len(rows), 4, 2))
    points[:, 0] = np.stack([columns + _share(corner[0], corner[1], level), rows], axis=1)
    points[:, 1] = np.stack([columns + 1, rows + _share(corner[1], corner[2], level)], axis=1)
    points[:, 2] = np.stack([columns + _share(corner[3], corner[2], level), rows + 1], axis=1)
    points[:, 3] = np.stack([columns, rows + _share(corner[0], corner[3], level)], axis=1)
    return points


def _share(start: FloatArray, end: FloatArray, level: float) -> FloatArray:
    step = end - start
    return np.divide(level - start, step, out=np.full_like(start, 0.5), where=step != 0)
