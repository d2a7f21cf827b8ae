"""Symmetric systems solved by factoring: the pattern is analysed once, new numbers are factored into it.

Two libraries do it, both in an approximate minimum degree order. QDLDL goes column by column and is the faster one on
small systems; RSLAB gathers columns into dense blocks (supernodes), which pays from some thousand unknowns on. Newton's
matrices of flattening, milliseconds of CPU, a factorisation with a solution (QDLDL; RSLAB): 2,000 faces 2.1; 3.5,
8,000 faces 18; 14, 16,000 faces 49; 31, 30,000 faces 150; 70, 100,000 faces 1,500; 340. SuperLU takes twice as long as
QDLDL. CHOLMOD's supernodal code would be a third faster than RSLAB still, but is under the GPL; PARDISO's does not run
on macOS.
"""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
import qdldl
import rslab
from scipy.sparse import csc_matrix

from app.core.arrays import FloatArray

SUPERNODAL_FROM = 8000
"""Unknowns from which supernodes pay."""


class SparseLDL:
    """Solves ``A x = b`` for symmetric positive definite matrices that keep their pattern from one to the next.

    Mutable: holds the last matrix's factors. The same bits on every run: one thread factors.
    """

    def __init__(self) -> None:
        self._pattern: tuple[int, ...] = ()
        self._held: csc_matrix | None = None
        self._solver: _Solver | None = None

    def update(self, upper: csc_matrix) -> None:
        """Factor the matrix whose upper triangle is ``upper`` (n, n), each column's rows ascending.

        Raises:
            ArithmeticError: The matrix is singular or not finite.
        """
        if not np.isfinite(upper.data).all():
            raise ArithmeticError("the matrix has entries that are not finite")
        pattern = (upper.indices.ctypes.data, upper.indptr.ctypes.data, upper.nnz)
        try:
            if self._solver is None or pattern != self._pattern:
                self._solver = (_Supernodal if upper.shape[0] >= SUPERNODAL_FROM else _ByColumns)(upper)
                # Held on to, so that no other array can come to lie at the same address.
                self._pattern, self._held = pattern, upper
            else:
                self._solver.update(upper)
        except (RuntimeError, ValueError) as error:
            self._solver = None
            raise ArithmeticError("the matrix cannot be factored") from error

    def solve(self, right: FloatArray) -> FloatArray:
        """The solution (n,) or (n, c) for right-hand sides (n,) or (n, c), with the last matrix.

        Raises:
            ArithmeticError: The matrix was singular, or there is none.
        """
        if self._solver is None:
            raise ArithmeticError("there is no factored matrix")
        columns = [np.ascontiguousarray(column) for column in np.atleast_2d(right.T)]
        found = np.stack([self._solver.solve(column) for column in columns], axis=1)
        if not np.isfinite(found).all():
            self._solver = None
            raise ArithmeticError("the matrix is singular")
        return found.reshape(right.shape)


class _Solver(Protocol):
    """A matrix's factors; made with the first numbers of a pattern."""

    def update(self, upper: csc_matrix, /) -> None:
        """Factor other numbers of the pattern."""

    def solve(self, right: FloatArray, /) -> FloatArray:
        """(n,) for a right-hand side (n,)."""


class _ByColumns:
    """By QDLDL (Stellato et al. 2020)."""

    def __init__(self, upper: csc_matrix) -> None:
        self._solver: Any = qdldl.Solver(upper, upper=True)

    def update(self, upper: csc_matrix) -> None:
        self._solver.update(upper, upper=True)

    def solve(self, right: FloatArray) -> FloatArray:
        return np.asarray(self._solver.solve(right))


class _Supernodal:
    """By RSLAB, which wants the lower triangle: the same entries in another order."""

    def __init__(self, upper: csc_matrix) -> None:
        numbered = csc_matrix((np.arange(upper.nnz, dtype=np.float64), upper.indices, upper.indptr), shape=upper.shape)
        lower = csc_matrix(numbered.T)
        lower.sort_indices()
        self._order = lower.data.astype(np.int64)
        self._symbolic: Any = rslab.analyze(lower, path="ldlt", ordering="amd", scaling="identity", threads=1)
        self.update(upper)

    def update(self, upper: csc_matrix) -> None:
        self._factors: Any = self._symbolic.factor(upper.data[self._order])

    def solve(self, right: FloatArray) -> FloatArray:
        return np.asarray(self._factors.solve(right))
