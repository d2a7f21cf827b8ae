"""The energy of a map that is held by pins: each is a spring from a place of the body to where it is wanted.

A pin inside a face pulls at its three corners, by their weights. Springs between corners of one face are entries that
the Hessian has anyway, so that a changed set of pins costs no new analysis, and a moved pin changes the gradient alone.

Why soft springs at points and not rigid handles of a ring of faces: handles are no clear gain. A circle of a quarter of
the map in 60 frames of one Newton step, most above the least energy, points and handles: bump of 968 faces 0.5 and
0.1 %, bump of 10,000 0.4 and 13 % (a handle's turn lags a step behind), torso of 10,000 8.8 and 5.0 %; no flips by
either. Points can be anywhere on the body, and with the pull spread over the map (``pull``) they stay within 0.5 % on
all three; handles were not tried with it.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy.sparse import csc_matrix

from app.arrays import FloatArray, IntArray
from app.maps.newton import Energy

STIFFNESS = 1e4
"""Of a pin, for maps of unit area: a pull that doubles the energy of a map leaves its pin a hundredth of it behind."""


class Springs:
    """Where pins hold a map. Built once for a set of pins; where they are wanted is no part of it.

    Args:
        corners: (p, 3) vertices of the faces that hold the pins.
        weights: (p, 3) of the pins in them; they sum to one.
    """

    def __init__(self, corners: IntArray, weights: FloatArray) -> None:
        self.corners, self.weights = corners, weights
        self._slots: IntArray | None = None

    def add_to(self, hessian: csc_matrix) -> None:
        """Add the springs' part to the upper triangle of a Hessian (2k, 2k); always to one of the same pattern."""
        first, second, stiffness = self._pairs
        if self._slots is None:  # 1 ms for 10,000 faces
            size = hessian.shape[0]
            keys = np.repeat(np.arange(size), np.diff(hessian.indptr)) * size + hessian.indices
            asked = np.concatenate([(2 * second + axis) * size + 2 * first + axis for axis in range(2)])
            self._slots = np.searchsorted(keys, asked)
        np.add.at(hessian.data, self._slots, np.tile(stiffness, 2))

    @cached_property
    def _pairs(self) -> tuple[IntArray, IntArray, FloatArray]:
        """Vertices i <= j of every two corners of each pin's face, and the spring between them."""
        first, second = np.repeat(self.corners, 3, axis=1).ravel(), np.tile(self.corners, (1, 3)).ravel()
        value = (2 * STIFFNESS * self.weights[:, :, None] * self.weights[:, None, :]).ravel()
        upper = first <= second
        return first[upper], second[upper], value[upper]


class PinnedEnergy:
    """The energy of a map and of springs, to be minimised in the former's place.

    Args:
        problem: The energy of stretching, of a map of about unit area.
        springs: Where pins hold it.
        goals: (p, 2) where on the plane they are wanted.
    """

    def __init__(self, problem: Energy, springs: Springs, goals: FloatArray) -> None:
        self._problem, self._springs, self.goals = problem, springs, goals

    def towards(self, goals: FloatArray) -> PinnedEnergy:
        """The same with other ``goals`` (p, 2)."""
        return PinnedEnergy(self._problem, self._springs, goals)

    def places(self, plane: FloatArray) -> FloatArray:
        """(p, 2) where the pins are on ``plane`` (k, 2)."""
        return np.einsum("pc,pcd->pd", self._springs.weights, plane[self._springs.corners])

    def energy(self, plane: FloatArray) -> float:
        """Mean energy by area plus the springs; inf where a face has no positive area."""
        return self._problem.energy(plane) + STIFFNESS * float(((self.places(plane) - self.goals) ** 2).sum())

    def gradient(self, plane: FloatArray) -> FloatArray:
        """(2k,) of the energy; x and y of a vertex side by side."""
        return self._pulled(self._problem.gradient(plane), plane)

    def derivatives(self, plane: FloatArray) -> tuple[FloatArray, csc_matrix]:
        """Gradient (2k,) and the projected Hessian's upper triangle (2k, 2k), in the pattern of the energy's own."""
        gradient, hessian = self._problem.derivatives(plane)
        self._springs.add_to(hessian)
        return self._pulled(gradient, plane), hessian

    def largest_step(self, plane: FloatArray, step: FloatArray) -> float:
        """How far along ``step`` (k, 2) the first face loses its area; inf if none does."""
        return self._problem.largest_step(plane, step)

    def _pulled(self, gradient: FloatArray, plane: FloatArray) -> FloatArray:
        pulls = 2 * STIFFNESS * self._springs.weights[:, :, None] * (self.places(plane) - self.goals)[:, None]
        np.add.at(gradient.reshape(-1, 2), self._springs.corners, pulls)
        return gradient
