"""Keeps a map from lying on itself: the border's parts push each other away when they come close.

Barrier (Smith and Schaefer 2015) for border vertex and border side nearer than ``reach``: (reach / distance - 1)².
Where the border crosses itself it is infinite, so a descent that starts without a crossing never gets one.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix, csc_matrix

from app.arrays import FloatArray, IntArray
from app.maps.bijective import crossings
from app.maps.grid import BoxGrid
from app.maps.newton import Energy

_WEIGHT = 1e-3
_REACH = 0.25
_TOUCHING = 1e-6
"""Nearer than this share of the reach counts as met: the two sides of a slit in a flat sheet do exactly that."""


class ApartBorder:
    """An energy of maps and the border's barrier, to be minimised in its place.

    Args:
        problem: The energy without it: of stretching alone, or with pins.
        loop: (b,) border vertices in order.
        plane: (k, 2) a map without overlap, from which the reach is taken: a quarter of a mean border side.
    """

    def __init__(self, problem: Energy, loop: IntArray, plane: FloatArray) -> None:
        self._problem, self._loop, self._next = problem, loop, np.roll(loop, -1)
        self._reach = _REACH * float(np.linalg.norm(plane[self._next] - plane[loop], axis=1).mean())

    def energy(self, plane: FloatArray) -> float:
        """Mean energy by area plus the barrier; inf where a face has no area or the border meets itself."""
        energy = self._problem.energy(plane)
        if not np.isfinite(energy) or crossings(plane[self._loop]):
            return float("inf")
        _, distance, _ = self._close(plane)
        if not distance.all():
            return float("inf")  # a corner that misses a side by the last bit does not cross it
        return energy + _WEIGHT * float(((self._reach / distance - 1) ** 2).sum())

    def touches(self, plane: FloatArray) -> bool:
        """Whether the border meets itself, or would if the plane were turned and rounded anew."""
        return bool(crossings(plane[self._loop])) or bool((self._close(plane)[1] < _TOUCHING * self._reach).any())

    def gradient(self, plane: FloatArray) -> FloatArray:
        """(2k,) of the energy and the barrier."""
        vertices, distance, direction = self._close(plane)
        return self._problem.gradient(plane) + self._push(vertices, distance, direction, plane.size)

    def derivatives(self, plane: FloatArray) -> tuple[FloatArray, csc_matrix]:
        """Gradient (2k,) and the upper triangle of a positive semidefinite Hessian (2k, 2k).

        The barrier's part of the Hessian is that of a distance whose direction stays.
        """
        gradient, hessian = self._problem.derivatives(plane)
        vertices, distance, direction = self._close(plane)
        gradient += self._push(vertices, distance, direction, plane.size)
        ratio = self._reach / distance
        curvature = 2 * _WEIGHT * (ratio**2 + 2 * (ratio - 1) * ratio) / distance**2
        blocks = curvature[:, None, None] * direction[:, :, None] * direction[:, None, :]
        dofs = _dofs(vertices)
        rows, columns = np.repeat(dofs, 6, axis=1).ravel(), np.tile(dofs, (1, 6)).ravel()
        upper = rows <= columns
        entries = coo_matrix((blocks.ravel()[upper], (rows[upper], columns[upper])), shape=hessian.shape)
        total = (hessian + entries).tocsc()
        total.sort_indices()
        return gradient, total

    def _push(self, vertices: IntArray, distance: FloatArray, direction: FloatArray, size: int) -> FloatArray:
        """The barrier's gradient (size,)."""
        ratio = self._reach / distance
        slope = -2 * _WEIGHT * (ratio - 1) * ratio / distance
        entries = (slope[:, None] * direction).ravel()
        return np.bincount(_dofs(vertices).ravel(), entries, minlength=size).astype(
            np.float64
        )  # of none: whole numbers

    def largest_step(self, plane: FloatArray, step: FloatArray) -> float:
        """How far along ``step`` (k, 2) the first face loses its area; inf if none does."""
        return self._problem.largest_step(plane, step)

    def _close(self, plane: FloatArray) -> tuple[IntArray, FloatArray, FloatArray]:
        """Close pairs of a vertex and a side.

        Returns:
            (p, 3) the vertex and the side's start and end, (p,) their distance, (p, 6) its gradient.
        """
        start, end = plane[self._loop], plane[self._next]
        low, high = np.minimum(start, end) - self._reach, np.maximum(start, end) + self._reach
        point, side = BoxGrid(low, high, float((high - low).max(axis=1).mean())).candidates(start)
        others = (side != point) & (self._next[side] != self._loop[point])
        point, side = point[others], side[others]
        along = end[side] - start[side]
        share = ((start[point] - start[side]) * along).sum(axis=1) / (along**2).sum(axis=1)
        share = np.clip(share, 0.0, 1.0)
        arm = start[point] - start[side] - share[:, None] * along
        distance = np.linalg.norm(arm, axis=1)
        near = distance < self._reach
        unit, share = arm[near] / np.where(distance > 0, distance, 1.0)[near, None], share[near, None]
        vertices = np.stack([self._loop[point], self._loop[side], self._next[side]], axis=1)[near]
        return vertices, distance[near], np.concatenate([unit, (share - 1) * unit, -share * unit], axis=1)


def _dofs(vertices: IntArray) -> IntArray:
    """(p, 6) coordinates of (p, 3) vertices."""
    return (2 * vertices[:, :, None] + np.arange(2)).reshape(-1, 6)
