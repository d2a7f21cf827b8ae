"""The shape each face would like to keep, in a plane of its own; faces without area are made fit first."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.arrays import FloatArray, IntArray

MARGIN = 1e-5
"""By how much of the mean edge length two sides must together exceed the third."""


@dataclass(frozen=True, eq=False)
class RestTriangles:
    """Faces in their own planes: corner 0 at the origin, corner 1 at (base, 0), corner 2 at (along, across).

    Attributes:
        base: (m,) > 0.
        along: (m,).
        across: (m,) > 0.
        mollified: How many faces had no area and were given a little.
    """

    base: FloatArray
    along: FloatArray
    across: FloatArray
    mollified: int

    @property
    def areas(self) -> FloatArray:
        """(m,) in the square of the positions' unit."""
        return 0.5 * self.base * self.across


def rest_triangles(positions: FloatArray, faces: IntArray) -> RestTriangles:
    """Lay each face of ``positions`` (k, 3), ``faces`` (m, 3) in a plane of its own.

    A face that is a line or a point has no shape to compare a map with. Its sides are lengthened by the same amount
    until they form a triangle (local intrinsic mollification, Sharp and Crane 2020); no vertex moves.
    """
    corners = positions[faces]
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    base = np.linalg.norm(first, axis=1)
    height = np.linalg.norm(np.cross(first, second), axis=1)
    safe = np.where(base > 0, base, 1.0)
    along, across = (first * second).sum(axis=1) / safe, height / safe
    sides = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2)
    # The two shorter sides must exceed the longest by the margin.
    lacking = MARGIN * sides.mean() - (sides.sum(axis=1) - 2 * sides.max(axis=1))
    thin = lacking > 0
    if thin.any():
        base[thin], along[thin], across[thin] = _from_sides(sides[thin] + lacking[thin, None])
    return RestTriangles(base, along, across, int(thin.sum()))


def _from_sides(sides: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Base, along and across of triangles with ``sides`` (t, 3) from corner k to k + 1; Kahan's stable area."""
    c, b, a = np.sort(sides, axis=1).T
    square = (a + (b + c)) * (c - (a - b)) * (c + (a - b)) * (a + (b - c))
    base = sides[:, 0]
    along = (base**2 + sides[:, 2] ** 2 - sides[:, 1] ** 2) / (2 * base)
    return base, along, 0.5 * np.sqrt(square) / base
