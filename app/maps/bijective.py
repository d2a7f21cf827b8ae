"""Whether a flat map is one-to-one: no triangle flipped, and a border that never touches itself.

Both together are enough for a disk: without flips the map is locally one-to-one, and with a simple border its degree is
one everywhere.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from app.arrays import BoolArray, FloatArray, IntArray
from app.maps.grid import BoxGrid

_ROUNDING = 4e-16
"""Relative rounding error of an orientation test (Shewchuk 1997: (3 + 16 e) e with e = 2^-53), rounded up."""


def signed_areas(plane: FloatArray, faces: IntArray) -> FloatArray:
    """(m,) positive for counter-clockwise faces [plane units²]."""
    a, b, c = (plane[faces[:, k]] for k in range(3))
    return 0.5 * ((b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0]))


def flipped(plane: FloatArray, faces: IntArray) -> BoolArray:
    """(m,) faces without positive area."""
    return ~(signed_areas(plane, faces) > 0)


def crossings(*loops: FloatArray) -> int:
    """How many pairs of sides of closed polygons (n, 2) meet, within one or between two; touching counts.

    Sides that follow each other share a corner and are left out. Only sides in the same cell of a grid are compared;
    1 ms for 500 sides.
    """
    return len(crossing_sides(*loops)[0])


def crossing_sides(*loops: FloatArray) -> tuple[IntArray, IntArray]:
    """The pairs (i, j), i < j, of sides that meet, numbered through the loops by the corner each begins with."""
    start = np.concatenate(loops) if loops else np.zeros((0, 2))
    if len(start) < 2:
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    after = _next(loops)
    end = start[after]
    low, high = np.minimum(start, end), np.maximum(start, end)
    i, j = BoxGrid(low, high, float((high - low).max(axis=1).mean())).pairs()
    apart = ((high[i] < low[j]) | (high[j] < low[i])).any(axis=1) | (after[i] == j) | (after[j] == i)
    i, j = i[~apart], j[~apart]
    d1, d2 = _side(start[i], end[i], start[j]), _side(start[i], end[i], end[j])
    d3, d4 = _side(start[j], end[j], start[i]), _side(start[j], end[j], end[i])
    meet = (d1 * d2 <= 0) & (d3 * d4 <= 0)
    return i[meet], j[meet]


def _next(loops: Sequence[FloatArray]) -> IntArray:
    """Number of the corner that follows each, with the loops' corners numbered through."""
    firsts = np.cumsum([0, *(len(loop) for loop in loops)])
    rings = [np.roll(np.arange(a, b), -1) for a, b in pairwise(firsts)]
    return np.concatenate(rings)


def _side(a: FloatArray, b: FloatArray, p: FloatArray) -> FloatArray:
    """Which side of the line a-b each p lies on: -1, 0 or 1; within rounding is 0, which counts as touching."""
    u, v = b - a, p - a
    left, right = u[:, 0] * v[:, 1], u[:, 1] * v[:, 0]
    return np.where(np.abs(left - right) <= _ROUNDING * (np.abs(left) + np.abs(right)), 0.0, np.sign(left - right))
