"""A cover's blur over some taxels, as equations: what they read is the matrix times the pressures above them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.arrays import FloatArray, readonly


@dataclass(frozen=True, eq=False)
class Blur:
    """A matrix (m, n) with its singular value decomposition: matrix = left diag(values) right.

    Attributes:
        matrix: (m, n) readings per pressure.
        left: (m, r), r = min(m, n).
        values: (r,) falling.
        right: (r, n).
    """

    matrix: FloatArray
    left: FloatArray
    values: FloatArray
    right: FloatArray

    @classmethod
    def of(cls, matrix: FloatArray) -> Blur:
        """The decomposition of a matrix. Cost: 0.2 ms for 30 x 30."""
        left, values, right = np.linalg.svd(matrix, full_matrices=False)
        return cls(readonly(matrix), readonly(left), readonly(values), readonly(right))
