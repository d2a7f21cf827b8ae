"""Symmetric systems solved by factoring: the pattern is analysed once, new numbers are factored into it."""

from __future__ import annotations

from typing import Any

import numpy as np
import rslab
from scipy.sparse import csc_matrix

from app.core.arrays import FloatArray, IntArray


class SparseLDL:
    """Solves ``A x = b`` for symmetric positive definite matrices that keep their pattern from one to the next.

    Mutable: holds the last matrix's factors. Supernodal LDL' in an approximate minimum degree order (RSLAB), equal to
    the bit whatever the number of threads; one is used, since studies and workers fill the other cores.
    """

    def __init__(self) -> None:
        self._pattern: tuple[int, ...] = ()
        self._held: csc_matrix | None = None
        self._symbolic: Any = None
        self._order: IntArray = np.zeros(0, dtype=np.int64)
        self._factors: Any = None

    def update(self, upper: csc_matrix) -> None:
        """Factor the matrix whose upper triangle is ``upper`` (n, n), each column's rows ascending.

        Raises:
            ArithmeticError: The matrix is singular or not finite.

        Cost: of a Newton matrix of 8,000; 30,000; 100,000 faces 13; 60; 300 ms, and 8; 40; 130 ms for a new pattern.
        """
        self._factors = None
        if not np.isfinite(upper.data).all():
            raise ArithmeticError("the matrix has entries that are not finite")
        pattern = (upper.indices.ctypes.data, upper.indptr.ctypes.data, upper.nnz)
        try:
            if pattern != self._pattern:
                self._analyse(upper)
                # Held on to, so that no other array can come to lie at the same address.
                self._pattern, self._held = pattern, upper
            self._factors = self._symbolic.factor(upper.data[self._order])
        except (RuntimeError, ValueError) as error:
            raise ArithmeticError("the matrix cannot be factored") from error

    def _analyse(self, upper: csc_matrix) -> None:
        """Take the pattern of ``upper``; RSLAB wants the lower triangle: the same entries in another order."""
        numbered = csc_matrix((np.arange(upper.nnz, dtype=np.float64), upper.indices, upper.indptr), shape=upper.shape)
        lower = csc_matrix(numbered.T)
        lower.sort_indices()
        self._order = lower.data.astype(np.int64)
        self._symbolic = rslab.analyze(lower, path="ldlt", ordering="amd", scaling="identity", threads=1)

    def solve(self, right: FloatArray) -> FloatArray:
        """The solution (n,) or (n, c) for right-hand sides (n,) or (n, c), with the last matrix.

        Raises:
            ArithmeticError: The matrix was singular, or there is none.
        """
        if self._factors is None:
            raise ArithmeticError("there is no factored matrix")
        columns = [np.ascontiguousarray(column) for column in np.atleast_2d(right.T)]
        found = np.stack([self._factors.solve(column) for column in columns], axis=1)
        if not np.isfinite(found).all():
            self._factors = None
            raise ArithmeticError("the matrix is singular")
        return found.reshape(right.shape)
