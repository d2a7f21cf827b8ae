"""The taxels of one patch joined by triangles: where a point lies between them, and what holds beyond their border."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_matrix
from scipy.spatial import Delaunay, QhullError, cKDTree

from app.arrays import BoolArray, FloatArray, IntArray, readonly
from app.geometry.topology import boundary_edges
from app.maps.locate import PlaneLocator

LONGEST_SIDE = 2.5
"""Triangles with a side longer than so many median spacings bridge a gap and are left out."""
_THINNEST = 1e-4
"""A triangle with less height for its longest side counts as a line: what lies in it is taken from beside it."""
_NEAR_SIDES = 6
_AT_ONCE = 32768


class TaxelTriangles:
    """Delaunay triangles of a patch's taxels, without those that bridge a gap. Built once, asked often.

    Args:
        sites: (n, 2) map points of the taxels, at least one [m].

    Attributes:
        sites: The same.
        faces: (t, 3) taxels, counter-clockwise; none where all lie in one line.
        beyond: (t, 3) the triangle across the side opposite each corner, or -1 at the border.

    Cost: 5 ms for 1000 taxels.
    """

    def __init__(self, sites: FloatArray) -> None:
        self.sites = readonly(sites)
        faces, beyond = _triangulated(self.sites)
        self.faces, self.beyond = readonly(faces, np.int64), readonly(beyond, np.int64)
        self._locator = PlaneLocator(self.sites[self.faces])
        alone = np.setdiff1d(np.arange(len(sites)), self.faces)
        border = boundary_edges(self.faces) if len(self.faces) else np.zeros((0, 2), np.int64)
        self._sides = np.concatenate([border, np.stack([alone, alone], axis=1)]).astype(np.int64)
        self._middles = cKDTree(self.sites[self._sides].mean(axis=1))

    def locate(self, points: FloatArray) -> tuple[IntArray, FloatArray]:
        """The triangle (k,) that holds each of ``points`` (k, 2), or -1, and the weights (k, 3) of its corners."""
        return self._locator.query(points)

    def beside(self, points: FloatArray) -> csr_matrix:
        """Sparse (k, n): the value at the nearest place on the border, between the two taxels of its side.

        Beyond the triangles (a patch's rim, a gap too wide to bridge) no taxel lies around a point to tell more.
        """
        near = min(_NEAR_SIDES, len(self._sides))
        sides = self._middles.query(points, near)[1].reshape(len(points), near)
        start, end = (self.sites[self._sides[sides, k]] for k in range(2))
        along = end - start
        square = (along**2).sum(axis=-1)
        share = ((points[:, None] - start) * along).sum(axis=-1) / np.where(square > 0, square, 1.0)
        share = np.clip(share, 0.0, 1.0)
        distance = np.linalg.norm(start + share[..., None] * along - points[:, None], axis=-1)
        pick = np.arange(len(points)), distance.argmin(axis=1) if len(points) else np.zeros(0, dtype=np.int64)
        return sparse_rows(self._sides[sides[pick]], np.stack([1 - share[pick], share[pick]], axis=1), len(self.sites))


def sparse_rows(taxels: IntArray, weights: FloatArray, count: int) -> csr_matrix:
    """Sparse (k, count) from ``taxels`` (k, c) and their ``weights`` (k, c)."""
    starts = np.arange(len(taxels) + 1) * taxels.shape[1]
    matrix = csr_matrix((weights.ravel(), taxels.ravel(), starts), shape=(len(taxels), count))
    matrix.sum_duplicates()
    return matrix


def merged(held: IntArray, inner: csr_matrix, outer: csr_matrix) -> csr_matrix:
    """Rows of ``inner`` where ``held`` (k,) is not negative, of ``outer`` elsewhere, each in their order."""
    inside = held >= 0
    order = np.where(inside, np.cumsum(inside) - 1, inner.shape[0] + np.cumsum(~inside) - 1)
    return stacked([inner, outer])[order]


def in_parts(held: BoolArray) -> list[IntArray]:
    """Numbers of the points that are ``held`` (k,), a part at a time, so that what is computed of each stays small."""
    numbers = np.flatnonzero(held)
    return [numbers[start : start + _AT_ONCE] for start in range(0, max(len(numbers), 1), _AT_ONCE)]


def stacked(blocks: list[csr_matrix]) -> csr_matrix:
    """Blocks of as many columns, one below the other."""
    counts = np.concatenate([np.diff(block.indptr) for block in blocks])
    data, columns = (np.concatenate([getattr(block, name) for block in blocks]) for name in ("data", "indices"))
    shape = len(counts), blocks[0].shape[1]
    return csr_matrix((data, columns, np.concatenate([[0], np.cumsum(counts)])), shape=shape)


def _triangulated(sites: FloatArray) -> tuple[IntArray, IntArray]:
    """Triangles (t, 3) and their neighbours (t, 3)."""
    none = np.zeros((0, 3), dtype=np.int64)
    if len(sites) < 3:
        return none, none
    try:
        found = Delaunay(sites)
    except QhullError:
        return none, none
    corners = sites[found.simplices]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    across = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    kept = longest <= LONGEST_SIDE * np.median(cKDTree(sites).query(sites, 2)[0][:, 1])
    kept &= across > _THINNEST * longest**2
    number = np.where(kept, np.cumsum(kept) - 1, -1)
    beyond = np.where(found.neighbors >= 0, number[found.neighbors], -1)
    return found.simplices[kept].astype(np.int64), beyond[kept]
