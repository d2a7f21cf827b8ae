"""Whether a flat map is one-to-one: no triangle flipped, and a border that never touches itself.

Both together are enough for a disk: without flips the map is locally one-to-one, and with a simple border its degree is
one everywhere.
"""

from __future__ import annotations

import numpy as np

from app.arrays import BoolArray, FloatArray, IntArray


def signed_areas(plane: FloatArray, faces: IntArray) -> FloatArray:
    """(m,) positive for counter-clockwise faces [plane units²]."""
    a, b, c = (plane[faces[:, k]] for k in range(3))
    return 0.5 * ((b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0]))


def flipped(plane: FloatArray, faces: IntArray) -> BoolArray:
    """(m,) faces without positive area."""
    return ~(signed_areas(plane, faces) > 0)


def crossings(loop: FloatArray) -> int:
    """How many pairs of non-adjacent sides of a closed polygon (n, 2) meet; touching counts.

    Pairs whose boxes are apart are never compared; cost about n²/2 box tests, 3 ms for 500 sides.
    """
    count = len(loop)
    if count < 4:
        return 0
    start, end = loop, np.roll(loop, -1, axis=0)
    low, high = np.minimum(start, end), np.maximum(start, end)
    i, j = np.triu_indices(count, 2)
    apart = ((high[i] < low[j]) | (high[j] < low[i])).any(axis=1) | ((i == 0) & (j == count - 1))
    i, j = i[~apart], j[~apart]
    d1, d2 = _side(start[i], end[i], start[j]), _side(start[i], end[i], end[j])
    d3, d4 = _side(start[j], end[j], start[i]), _side(start[j], end[j], end[i])
    return int(((d1 * d2 <= 0) & (d3 * d4 <= 0)).sum())


def _side(a: FloatArray, b: FloatArray, p: FloatArray) -> FloatArray:
    """Which side of the line a-b each p lies on: -1, 0 or 1; within rounding is 0, which counts as touching."""
    u, v = b - a, p - a
    left, right = u[:, 0] * v[:, 1], u[:, 1] * v[:, 0]
    return np.where(np.abs(left - right) <= 4e-16 * (np.abs(left) + np.abs(right)), 0.0, np.sign(left - right))
