"""Symmetric sparse systems: the pattern is analysed once, then matrices with this pattern are factored.

Two libraries are used, both with approximate minimum degree ordering. QDLDL factors column by column. RSLAB collects
columns into dense blocks (supernodes), which is faster where the factor has at least 6.7 times as many entries as the
matrix, for 10,000 to 200,000 unknowns, with one or two unknowns per vertex. Newton matrices of flattening, CPU time of
one factorisation with three solutions [ms] (QDLDL; RSLAB):

    unknowns  of a square    of a strip of 50 times its width   of one of 1,000 times
    8,000     30; 44         6; 16                              3; 18
    33,000    232; 155       40; 84                             5; 40
    93,000    1,759; 526     206; 276                           63; 251
    200,000   4,786; 966     864; 798                           239; 555

SuperLU takes twice as long as QDLDL. CHOLMOD's supernodal code would be a third faster than RSLAB still, but is under
the GPL; PARDISO's does not run on macOS.
"""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np
import qdldl
import rslab
from scipy.sparse import csc_matrix

from tactile_maps.core.arrays import FloatArray

SUPERNODAL_FROM = 8000
"""Number of unknowns below which supernodes are never faster, so that no analysis is needed."""
SUPERNODAL_FILL = 6.7
"""Entries of the factor per entry of the upper triangle from which supernodes are faster."""


class SparseLDL:
    """Solver of ``A x = b`` for symmetric positive definite matrices with the same pattern.

    Mutable: holds the factors of the last matrix. Results are the same bit for bit on every run, as one thread factors.
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
                self._solver = _factored(upper)
                # Kept, so that no other array can have the same address.
                self._pattern = pattern
                self._held = upper
            else:
                self._solver.update(upper)
        except (RuntimeError, ValueError) as error:
            self._solver = None
            raise ArithmeticError("the matrix cannot be factored") from error

    def solve(self, right: FloatArray) -> FloatArray:
        """Return the solution (n,) or (n, c) for right-hand sides (n,) or (n, c) with the last matrix.

        Raises:
            ArithmeticError: The matrix was singular, or none was factored.
        """
        if self._solver is None:
            raise ArithmeticError("there is no factored matrix")
        columns = [np.ascontiguousarray(column) for column in np.atleast_2d(right.T)]
        found = np.stack([self._solver.solve(column) for column in columns], axis=1)
        if not np.isfinite(found).all():
            self._solver = None
            raise ArithmeticError("the matrix is singular")
        return found.reshape(right.shape)


def _factored(upper: csc_matrix) -> _Solver:
    """Factor the matrix with the library that is faster for its pattern."""
    if upper.shape[0] >= SUPERNODAL_FROM:
        analysed = _Supernodal(upper)
        if analysed.fill >= SUPERNODAL_FILL:
            analysed.update(upper)
            return analysed
    return _ByColumns(upper)


class _Solver(Protocol):
    """Factors of a matrix."""

    def update(self, upper: csc_matrix, /) -> None:
        """Factor a matrix with the same pattern."""

    def solve(self, right: FloatArray, /) -> FloatArray:
        """Return the solution (n,) for a right-hand side (n,)."""


class _ByColumns:
    """Factors by QDLDL (Stellato et al. 2020)."""

    def __init__(self, upper: csc_matrix) -> None:
        self._solver: Any = qdldl.Solver(upper, upper=True)

    def update(self, upper: csc_matrix) -> None:
        self._solver.update(upper, upper=True)

    def solve(self, right: FloatArray) -> FloatArray:
        return np.asarray(self._solver.solve(right))


class _Supernodal:
    """Factors by RSLAB, which requires the lower triangle: the same entries in a different order.

    The constructor analyses the pattern; ``update`` factors a matrix.

    Attributes:
        fill: Entries of the factor per entry of ``upper``.
    """

    def __init__(self, upper: csc_matrix) -> None:
        numbered = csc_matrix((np.arange(upper.nnz, dtype=np.float64), upper.indices, upper.indptr), shape=upper.shape)
        lower = csc_matrix(numbered.T)
        lower.sort_indices()
        self._order = lower.data.astype(np.int64)
        self._symbolic: Any = rslab.analyze(lower, path="ldlt", ordering="amd", scaling="identity", threads=1)
        self.fill: float = self._symbolic.factor_nnz / upper.nnz

    def update(self, upper: csc_matrix) -> None:
        self._factors: Any = self._symbolic.factor(upper.data[self._order])

    def solve(self, right: FloatArray) -> FloatArray:
        return np.asarray(self._factors.solve(right))
