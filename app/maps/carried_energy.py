"""The energy of a large map whose vertices are carried by those of a coarse stand-in: few unknowns, all faces judged.

Value, gradient and Hessian are the whole map's, seen from the few: none of its faces flips, energy falls as it does and
a map at rest stays at rest. What costs most, factoring the Hessian, has the stand-in's size.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csc_matrix, csr_matrix

from app.arrays import FloatArray
from app.maps.newton import Energy
from app.maps.subspace import Subspace


class CarriedEnergy:
    """The energy of ``problem`` at the planes that a stand-in's carry. Built once; all questions are about the latter.

    Args:
        problem: The energy of the whole map.
        carried: Sparse (k, c) with three weights a row: the whole plane from the stand-in's.
    """

    def __init__(self, problem: Energy, carried: csr_matrix) -> None:
        self._problem, self._carried = problem, carried
        self._back: csr_matrix = carried.T.tocsr()
        self._subspace: Subspace | None = None

    def energy(self, plane: FloatArray) -> float:
        """Mean energy of the whole map by area; inf where a face has no positive area."""
        return self._problem.energy(self._carried @ plane)

    def gradient(self, plane: FloatArray) -> FloatArray:
        """(2c,) of it; x and y of a vertex side by side."""
        return self._seen(self._problem.gradient(self._carried @ plane))

    def derivatives(self, plane: FloatArray) -> tuple[FloatArray, csc_matrix]:
        """Gradient (2c,) and the upper triangle of a positive semidefinite Hessian (2c, 2c), always of one pattern."""
        gradient, hessian = self._problem.derivatives(self._carried @ plane)
        if self._subspace is None:
            self._subspace = Subspace(self._carried, hessian)
        return self._seen(gradient), self._subspace.project(hessian)

    def largest_step(self, plane: FloatArray, step: FloatArray) -> float:
        """How far along ``step`` (c, 2) the first face loses its area; inf if none does."""
        return self._problem.largest_step(self._carried @ plane, self._carried @ step)

    def _seen(self, gradient: FloatArray) -> FloatArray:
        return np.asarray(self._back @ gradient.reshape(-1, 2)).ravel()
