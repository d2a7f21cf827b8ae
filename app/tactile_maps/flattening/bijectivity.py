"""Validity check of a flat map, and a barrier that keeps a map valid.

A map of a disk is one-to-one if no triangle is flipped and its border does not touch itself: without flips it is
locally one-to-one, and with a simple border its degree is one everywhere.

The barrier keeps a map from overlapping itself: parts of the border repel each other at close distance. Barrier (Smith
and Schaefer 2015) for a border vertex and a border side closer than ``reach``: (reach / distance - 1)². It is infinite
where the border crosses itself, so a descent that starts without a crossing never gets one.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from scipy.sparse import coo_matrix, csc_matrix

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray
from tactile_maps.flattening.newton import Energy
from tactile_maps.geometry.surface.point_location import BoxGrid

_ROUNDING = 4e-16
"""Relative rounding error of an orientation test (Shewchuk 1997: (3 + 16 e) e with e = 2^-53), rounded up."""


def signed_areas(plane: FloatArray, faces: IntArray) -> FloatArray:
    """Return the areas (m,) of faces, positive for counter-clockwise ones [plane units²]."""
    a, b, c = (plane[faces[:, k]] for k in range(3))
    return 0.5 * ((b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0]))


def flipped(plane: FloatArray, faces: IntArray) -> BoolArray:
    """Return a mask (m,) of faces without positive area."""
    return ~(signed_areas(plane, faces) > 0)


def crossings(*loops: FloatArray) -> int:
    """Return how many pairs of sides of closed polygons (n, 2) meet, within one or between two; touching counts.

    Consecutive sides share a corner and are excluded. Only sides in the same cell of a grid are compared;
    1 ms for 500 sides.
    """
    return len(crossing_sides(*loops)[0])


def crossing_sides(*loops: FloatArray) -> tuple[IntArray, IntArray]:
    """Return the pairs (i, j), i < j, of sides that meet. Side numbers continue through the loops."""
    start = np.concatenate(loops) if loops else np.zeros((0, 2))
    if len(start) < 2:
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    after = _next(loops)
    end = start[after]
    low = np.minimum(start, end)
    high = np.maximum(start, end)
    i, j = BoxGrid(low, high, float((high - low).max(axis=1).mean())).pairs()
    apart = ((high[i] < low[j]) | (high[j] < low[i])).any(axis=1) | (after[i] == j) | (after[j] == i)
    i = i[~apart]
    j = j[~apart]
    d1 = _side(start[i], end[i], start[j])
    d2 = _side(start[i], end[i], end[j])
    d3 = _side(start[j], end[j], start[i])
    d4 = _side(start[j], end[j], end[i])
    meet = (d1 * d2 <= 0) & (d3 * d4 <= 0)
    return i[meet], j[meet]


def _next(loops: Sequence[FloatArray]) -> IntArray:
    """Return the next corner of each, with corner numbers continuing through the loops."""
    firsts = np.cumsum([0, *(len(loop) for loop in loops)])
    rings = [np.roll(np.arange(a, b), -1) for a, b in pairwise(firsts)]
    return np.concatenate(rings)


def _side(a: FloatArray, b: FloatArray, p: FloatArray) -> FloatArray:
    """Return the side of the line a-b of each p: -1, 0 or 1; 0 is within rounding and counts as touching."""
    u = b - a
    v = p - a
    left = u[:, 0] * v[:, 1]
    right = u[:, 1] * v[:, 0]
    return np.where(np.abs(left - right) <= _ROUNDING * (np.abs(left) + np.abs(right)), 0.0, np.sign(left - right))


_WEIGHT = 1e-3
_REACH = 0.25
_TOUCHING = 1e-6
"""Distances below this share of the reach count as contact, as for the two sides of a slit in a flat sheet."""


class BoundaryBarrier:
    """Sum of an energy and the border's barrier.

    Args:
        problem: The energy without the barrier: of stretching alone, or with pins.
        loop: (b,) border vertices in order.
        plane: (k, 2) a map without overlap; the reach is a quarter of its mean border side.
    """

    def __init__(self, problem: Energy, loop: IntArray, plane: FloatArray) -> None:
        self._problem = problem
        self._loop = loop
        self._next = np.roll(loop, -1)
        self._reach = _REACH * float(np.linalg.norm(plane[self._next] - plane[loop], axis=1).mean())

    def energy(self, plane: FloatArray) -> float:
        """Return the mean energy by area plus the barrier; inf if a face has no area or the border meets itself."""
        energy = self._problem.energy(plane)
        if not np.isfinite(energy) or crossings(plane[self._loop]):
            return float("inf")
        _, distance, _ = self._close(plane)
        if not distance.all():
            return float("inf")  # a corner that misses a side by one bit does not cross it
        return energy + _WEIGHT * float(((self._reach / distance - 1) ** 2).sum())

    def touches(self, plane: FloatArray) -> bool:
        """Return whether the border meets itself, or would after a rotation with rounding."""
        return bool(crossings(plane[self._loop])) or bool((self._close(plane)[1] < _TOUCHING * self._reach).any())

    def gradient(self, plane: FloatArray) -> FloatArray:
        """Return the gradient (2k,) of the sum."""
        vertices, distance, direction = self._close(plane)
        return self._problem.gradient(plane) + self._push(vertices, distance, direction, plane.size)

    def derivatives(self, plane: FloatArray) -> tuple[FloatArray, csc_matrix]:
        """Return the gradient (2k,) and the upper triangle of a positive semidefinite Hessian (2k, 2k).

        The Hessian of the barrier treats the direction of each distance as constant.
        """
        gradient, hessian = self._problem.derivatives(plane)
        vertices, distance, direction = self._close(plane)
        gradient += self._push(vertices, distance, direction, plane.size)
        ratio = self._reach / distance
        curvature = 2 * _WEIGHT * (ratio**2 + 2 * (ratio - 1) * ratio) / distance**2
        blocks = curvature[:, None, None] * direction[:, :, None] * direction[:, None, :]
        dofs = _dofs(vertices)
        rows = np.repeat(dofs, 6, axis=1).ravel()
        columns = np.tile(dofs, (1, 6)).ravel()
        upper = rows <= columns
        entries = coo_matrix((blocks.ravel()[upper], (rows[upper], columns[upper])), shape=hessian.shape)
        total = (hessian + entries).tocsc()
        total.sort_indices()
        return gradient, total

    def _push(self, vertices: IntArray, distance: FloatArray, direction: FloatArray, size: int) -> FloatArray:
        """Return the barrier's gradient (size,)."""
        ratio = self._reach / distance
        slope = -2 * _WEIGHT * (ratio - 1) * ratio / distance
        entries = (slope[:, None] * direction).ravel()
        return np.bincount(_dofs(vertices).ravel(), entries, minlength=size).astype(
            np.float64
        )  # of none: whole numbers

    def largest_step(self, plane: FloatArray, step: FloatArray) -> float:
        """Return the step length at which the first face loses its area; inf if none does."""
        return self._problem.largest_step(plane, step)

    def _close(self, plane: FloatArray) -> tuple[IntArray, FloatArray, FloatArray]:
        """Find close pairs of a vertex and a side.

        Returns:
            (p, 3) the vertex and the start and end of the side, (p,) their distance, (p, 6) its gradient.
        """
        start = plane[self._loop]
        end = plane[self._next]
        low = np.minimum(start, end) - self._reach
        high = np.maximum(start, end) + self._reach
        point, side = BoxGrid(low, high, float((high - low).max(axis=1).mean())).candidates(start)
        others = (side != point) & (self._next[side] != self._loop[point])
        point = point[others]
        side = side[others]
        along = end[side] - start[side]
        share = ((start[point] - start[side]) * along).sum(axis=1) / (along**2).sum(axis=1)
        share = np.clip(share, 0.0, 1.0)
        arm = start[point] - start[side] - share[:, None] * along
        distance = np.linalg.norm(arm, axis=1)
        near = distance < self._reach
        unit = arm[near] / np.where(distance > 0, distance, 1.0)[near, None]
        share = share[near, None]
        vertices = np.stack([self._loop[point], self._loop[side], self._next[side]], axis=1)[near]
        return vertices, distance[near], np.concatenate([unit, (share - 1) * unit, -share * unit], axis=1)


def _dofs(vertices: IntArray) -> IntArray:
    """Return the coordinate numbers (p, 6) of vertices (p, 3)."""
    return (2 * vertices[:, :, None] + np.arange(2)).reshape(-1, 6)
