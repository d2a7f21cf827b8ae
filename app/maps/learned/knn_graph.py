"""The distances that can be trusted, those between near neighbours, and the rest as paths along them."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components, dijkstra

from app.arrays import FloatArray, IntArray

NEIGHBOURS = 6
_TIE = 1e-9


def knn_graph(distances: FloatArray, *, neighbours: int = NEIGHBOURS) -> csr_matrix:
    """Sparse symmetric (n, n): each node joined to its nearest ``neighbours``, whichever of the two found the other.

    Ties are all taken, so that the graph does not depend on how the nodes are numbered.

    Args:
        distances: (n, n) symmetric, >= 0; inf for a pair that must not be joined.
        neighbours: At least 1.
    """
    apart = distances.copy()
    np.fill_diagonal(apart, np.inf)
    count = len(apart)
    place = min(neighbours, count - 1) - 1
    reach = np.partition(apart, place, axis=1)[:, place] if count > 1 else np.full(count, np.inf)
    near = np.isfinite(apart) & (apart <= reach[:, None] * (1 + _TIE))
    i, j = np.nonzero(near | near.T)
    # A path may not be free: two taxels that always read the same still are two.
    least = _TIE * float(np.max(apart[i, j], initial=0.0)) or _TIE
    return csr_matrix((np.maximum(apart[i, j], least), (i, j)), shape=apart.shape)


def islands(graph: csr_matrix) -> list[IntArray]:
    """Nodes of each connected part, the largest first."""
    _, label = connected_components(graph, directed=False)
    parts = [np.flatnonzero(label == number) for number in range(label.max(initial=-1) + 1)]
    return sorted(parts, key=lambda part: (-len(part), int(part[0])))


def path_lengths(graph: csr_matrix) -> FloatArray:
    """(n, n) lengths of shortest paths; inf where none leads."""
    return dijkstra(graph, directed=False)
