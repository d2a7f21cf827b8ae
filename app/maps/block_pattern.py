"""Where the 2 x 2 blocks of a mesh's faces go in a sparse matrix: the same at every step, so found out once."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix

from app.arrays import FloatArray, IntArray
from app.geometry.topology import edge_table

_PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))


class BlockPattern:
    """The upper triangle of matrices (2k, 2k) with a 2 x 2 block for each vertex and each edge of a mesh.

    Args:
        faces: (m, 3).
        count: Number of vertices k.

    Cost: one sort of 3 m edges; to fill it, 10 ns an entry.
    """

    def __init__(self, faces: IntArray, count: int) -> None:
        self._faces, self._count = faces, count
        table = edge_table(faces)
        # Edges by their higher vertex: each is a block in that vertex's two columns, above its diagonal block.
        order = np.lexsort((table.edges[:, 0], table.edges[:, 1]))
        self._lower = np.bincount(table.edges[:, 1], minlength=count)
        first = np.concatenate([[0], np.cumsum(self._lower)])
        self._rank = np.empty(len(order), dtype=np.int64)
        self._rank[order] = np.arange(len(order)) - first[table.edges[order, 1]]
        self._edges, self._edge_of, self._sorted = table.edges, table.edge_of, table.edges[order, 0]
        # A vertex's columns hold two entries an edge, and one and two of its diagonal block.
        lengths = np.stack([2 * self._lower + 1, 2 * self._lower + 2], axis=1).ravel()
        self.columns = np.concatenate([[0], np.cumsum(lengths)]).astype(np.int32)

    @cached_property
    def rows(self) -> NDArray[np.int32]:
        """(nnz,) row of each entry, ascending in each column."""
        result = np.empty(int(self.columns[-1]), dtype=np.int32)
        diagonal = np.arange(self._count)
        for column in range(2):
            start = self.columns[column:-1:2].astype(np.int64)
            for row in range(2):
                owner = np.repeat(diagonal, self._lower)
                step = np.arange(len(owner)) - np.repeat(np.cumsum(self._lower) - self._lower, self._lower)
                result[start[owner] + 2 * step + row] = 2 * self._sorted + row
                if row <= column:
                    result[start + 2 * self._lower + row] = 2 * diagonal + row
        return result

    @cached_property
    def _slots(self) -> IntArray:
        """Place of every entry of every block, in the order in which ``matrix`` lists them."""
        starts, parts = self.columns.astype(np.int64), []
        for k, other in _PAIRS:
            if k == other:
                v = self._faces[:, k]
                parts += [starts[2 * v + j] + 2 * self._lower[v] + i for i, j in ((0, 0), (0, 1), (1, 1))]
                continue
            edge = self._edge_of[:, {(0, 1): 0, (1, 2): 1, (0, 2): 2}[k, other]]
            high, turned = self._edges[edge, 1], self._faces[:, k] > self._faces[:, other]
            for i, j in ((0, 0), (0, 1), (1, 0), (1, 1)):
                row, column = np.where(turned, j, i), np.where(turned, i, j)
                parts.append(starts[2 * high + column] + 2 * self._rank[edge] + row)
        return np.concatenate(parts)

    def matrix(self, blocks: Mapping[tuple[int, int], tuple[FloatArray, ...]]) -> csc_matrix:
        """The sum over the faces of ``blocks``: for corners (k, l) the entries (xx, xy, yx, yy), each (m,)."""
        values: list[FloatArray] = []
        for pair in _PAIRS:
            xx, xy, yx, yy = blocks[pair]
            values += [xx, xy, yy] if pair[0] == pair[1] else [xx, xy, yx, yy]
        data = np.bincount(self._slots, np.concatenate(values), minlength=len(self.rows))
        size = 2 * self._count
        return csc_matrix((data, self.rows, self.columns), shape=(size, size))
