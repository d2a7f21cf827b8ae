"""Cells of taxels: a surface cut where two taxels are equally far, so that each part belongs to the nearest taxel.

``sampling`` assigns whole faces to taxels. Here a face that reaches into several cells is cut by the planes that bisect
the lines between their taxels (Sutherland and Hodgman 1974, "Reentrant polygon clipping"). Only taxels that own faces
close to it are compared, so that no cell jumps across a gap or through a wall. The cells of a regular grid are equal
and centred on the taxels, whatever triangles the surface has. A part that is equally far from several taxels, because
its whole plane is, is shared evenly.

Two cells are neighbours where they touch, also in a single point, as the diagonal ones of a square grid do; or where
one of them touches no other, and faces that they own do.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray
from tactile_maps.geometry.surface.mesh import Mesh
from tactile_maps.skin.model.skin import Quadrature

_ROUNDING = 1e-10
"""Distance from a bisecting plane, as a share of the distance between the two taxels, that counts as on the plane."""
_TOUCHING = 1e-3
"""Cells whose distance is below this share of the distance between their taxels touch."""
_LEAST_PART = 1e-9
"""Smaller parts of a face, as a share of it, are rounding."""


@dataclass(frozen=True, eq=False)
class TaxelCells:
    """The cells of the taxels of a patch.

    Attributes:
        quadrature: A point at the centroid of each part of a face.
        neighbours: (e, 2) pairs of taxels whose cells touch, i < j.
    """

    quadrature: Quadrature
    neighbours: IntArray


_BLOCK = 50_000
"""Faces whose near taxels are looked up at once."""
_PLANES = 200_000
"""Planes by which parts of faces are cut at once, in about 30 MB."""


def cut_cells(surface: Mesh, points: FloatArray, owner: IntArray) -> TaxelCells:
    """Return the cells of the taxels at ``points`` (n, 3) [m] on a surface.

    The areas of the parts of a face sum to the area of the face. A taxel for which the cut leaves nothing gets half of
    each face that it owns.

    Args:
        surface: The patch's surface.
        points: (n, 3) the taxels [m].
        owner: (m,) taxel of each face, or -1 for a face that no taxel reads.

    Cost: 0.04 s for 1000 taxels on 16,000 faces, 5 s and 500 MB for 99,000 taxels on 1.2 million faces.
    """
    felt = np.flatnonzero(owner >= 0)
    around = _owners_around(surface, owner, len(points))
    blocks = np.split(felt, range(_BLOCK, len(felt), _BLOCK))
    cut = _Cut.joined([_cut_faces(surface, points, faces, around) for faces in blocks])
    face = cut.face
    taxel = cut.taxel
    centres = cut.centres
    areas = cut.areas
    empty = np.bincount(taxel, minlength=len(points)) == 0
    if empty.any():
        shared = np.flatnonzero((owner >= 0) & empty[owner])
        areas[np.isin(face, shared)] /= 2
        face = np.concatenate([face, shared])
        taxel = np.concatenate([taxel, owner[shared]])
        centres = np.concatenate([centres, surface.vertices[surface.faces[shared]].mean(axis=1)])
        areas = np.concatenate([areas, surface.face_areas[shared] / 2])
        order = np.argsort(face, kind="stable")
        face, taxel, centres, areas = face[order], taxel[order], centres[order], areas[order]
    quadrature = Quadrature(centres, surface.face_normals[face], areas, taxel)
    one, other = np.divmod(cut.pairs, len(points))
    turned = (other * len(points) + one)[one > other]
    both = np.intersect1d(cut.pairs[one < other], turned, assume_unique=True)  # each reaches the plane between them
    touching = np.stack(np.divmod(both, len(points)), axis=1)
    alone = np.bincount(touching.ravel(), minlength=len(points)) == 0
    if not alone.any():
        return TaxelCells(quadrature, touching)
    owners = _pairs_of_owners(surface, owner, alone)
    return TaxelCells(quadrature, np.unique(np.concatenate([touching, owners]), axis=0))


def _distinct(parts: Sequence[IntArray]) -> IntArray:
    """Return the numbers of all parts once, ascending: as ``np.unique``, whose hash table takes three times as long."""
    numbers = np.sort(np.concatenate(parts))
    return numbers[np.concatenate([[True], numbers[1:] != numbers[:-1]])] if len(numbers) else numbers


def _pairs_of_owners(surface: Mesh, owner: IntArray, alone: BoolArray) -> IntArray:
    """Return the pairs (e, 2) of taxels that own adjacent faces, of which one is ``alone`` (n,).

    The cell of a taxel that owns fewer faces than are nearest to it does not reach the planes that bound it.
    """
    pairs = np.sort(owner[surface.connectivity.face_pairs], axis=1)
    pairs = pairs[(pairs[:, 0] >= 0) & (pairs[:, 0] < pairs[:, 1])]
    return np.unique(pairs[alone[pairs].any(axis=1)], axis=0)


@dataclass(frozen=True, eq=False)
class _Cut:
    """The parts of some faces: ``face`` (k,), ``taxel`` (k,), ``centres`` (k, 3) [m], ``areas`` (k,) [m^2].

    ``pairs`` (p,) are the pairs of taxels whose parts reach the plane between them: one taxel times n,
    plus the other, ascending once joined.
    """

    face: IntArray
    taxel: IntArray
    centres: FloatArray
    areas: FloatArray
    pairs: IntArray

    @staticmethod
    def joined(cuts: Sequence[_Cut]) -> _Cut:
        """Return the parts of all cuts in their order, with each pair once."""
        return _Cut(
            np.concatenate([cut.face for cut in cuts]),
            np.concatenate([cut.taxel for cut in cuts]),
            np.concatenate([cut.centres for cut in cuts]),
            np.concatenate([cut.areas for cut in cuts]),
            _distinct([cut.pairs for cut in cuts]),
        )


def _cut_faces(surface: Mesh, points: FloatArray, faces: IntArray, around: csr_matrix) -> _Cut:
    """Cut ``faces`` (m,) into the parts that are nearest to each of the taxels, by face and then by taxel."""
    near = _near_taxels(surface, points, faces, around)
    counts = np.diff(near.indptr)
    cuts = [_Cut(*(np.zeros(0, dtype=np.int64),) * 2, np.zeros((0, 2)), np.zeros(0), np.zeros(0, dtype=np.int64))]
    planes = list[_Planes]()
    for count in np.unique(counts[counts > 0]).tolist():
        rows = np.flatnonzero(counts == count)
        taxels = near.indices[near.indptr[rows] + np.arange(count)[:, None]].astype(np.int64)
        away = _squared_distances(surface, points, faces[rows], taxels)
        own, place = np.nonzero(~_farther_everywhere(away))
        most = _PLANES // count + 1
        for first in range(0, len(own), most):
            some = place[first : first + most]
            places = away.take(some, axis=2)  # contiguous, unlike what an index gives
            planes.append(
                _planes_near(rows[some], taxels.take(some, axis=1), own[first : first + most], places, points)
            )
            if sum(len(several.other) for several in planes) > _PLANES:
                cuts.append(_cut_parts(planes, len(points)))
                planes = []
    if planes:
        cuts.append(_cut_parts(planes, len(points)))
    cut = _Cut.joined(cuts)
    felt = np.flatnonzero(surface.face_areas[faces[cut.face]] > 0)
    order = felt[np.argsort(cut.face[felt] * len(points) + cut.taxel[felt])]
    row = cut.face[order]
    face = faces[row]
    shares = cut.areas[order]
    areas = shares * (surface.face_areas[faces] / np.maximum(np.bincount(row, shares, len(faces)), _LEAST_PART))[row]
    corners = surface.vertices.take(surface.faces[face], axis=0)
    centres = corners[:, 0] + np.einsum("kc,kcd->kd", cut.centres[order], corners[:, 1:] - corners[:, :1])
    return _Cut(face, cut.taxel[order], centres, areas, cut.pairs)


@dataclass(frozen=True, eq=False)
class _Planes:
    """Planes that bisect the lines from the taxel of a part to others.

    Attributes:
        face: (k,) the face of each part.
        taxel: (k,) the taxel whose part it is.
        count: (k,) number of planes near each part.
        other: (p,) the other taxel of each plane, by part.
        heights: (p, 3) of the corners of the face above the plane, as a share of the distance between the taxels.
        cutting: (p,) whether a corner is above the plane.
    """

    face: IntArray
    taxel: IntArray
    count: IntArray
    other: IntArray
    heights: FloatArray
    cutting: BoolArray


def _planes_near(face: IntArray, near: IntArray, own: IntArray, away: FloatArray, points: FloatArray) -> _Planes:
    """Return the planes that bound the part of one taxel of each face, or that the face is close to.

    Differences of squared distances to two taxels are linear in a face, so that they are computed at its corners only,
    and divided by twice the squared distance of the taxels: then they are distances from the bisecting plane, as a
    share of the distance between the taxels. For two taxels at one place the plane is nowhere, and no point is beyond.

    Args:
        face: (k,) the face of each part.
        near: (n, k) taxels near it.
        own: (k,) the place in ``near`` of the taxel whose part it is.
        away: (n, 3, k) squared distance of each taxel from each corner of the face [m²].
        points: (n, 3) all taxels [m].
    """
    every = np.arange(len(face))
    taxel = near[own, every]
    between = points.take(near, axis=0)
    between -= points[taxel]
    apart = np.vecdot(between, between)
    beyond = np.ascontiguousarray(away[own, :, every].T) - away
    beyond /= np.where(apart > 0, 2 * apart, np.inf)[:, None]
    beyond[own, :, every] = -1.0
    highest = beyond.max(axis=1)
    close = highest >= -_TOUCHING
    part, place = np.nonzero(close.T)
    cutting = highest[place, part] > _ROUNDING
    return _Planes(face, taxel, close.sum(axis=0), near[place, part], beyond[place, :, part], cutting)


def _cut_parts(several: Sequence[_Planes], points: int) -> _Cut:
    """Cut the part of one taxel out of each face, where there are ``points`` taxels.

    Returns:
        The parts that are left; their centres are places (k, 2) along the two sides of the face from its first corner,
        and their areas are twice the share of the face, divided by the number of taxels that share the part.
    """
    face, taxel, count, other, values, cutting = (
        np.concatenate([getattr(planes, name) for planes in several])
        for name in ("face", "taxel", "count", "other", "heights", "cutting")
    )
    first = np.cumsum(count) - count
    before = np.concatenate([[0], np.cumsum(cutting)])
    found = list[_Cut]()
    for parts in _clipped(values[cutting], before[first + count] - before[first]):
        centres, areas = parts.moments()
        number = count[parts.part]
        row = np.repeat(np.arange(len(number)), number)
        plane = np.arange(len(row)) + np.repeat(first[parts.part] - (np.cumsum(number) - number), number)
        heights = _heights(np.ascontiguousarray(values.take(plane, axis=0).T), parts.corners.take(row, axis=2))
        pairs = (points * taxel[parts.part[row]] + other[plane])[heights.max(axis=0) >= -_TOUCHING]
        sharers = 1 + np.bincount(row[heights.min(axis=0) >= -_ROUNDING], minlength=len(areas))
        felt = areas > _LEAST_PART
        part = parts.part[felt]
        found.append(_Cut(face[part], taxel[part], centres[felt], (areas / sharers)[felt], pairs))
    return _Cut.joined(found)


def _squared_distances(surface: Mesh, points: FloatArray, faces: IntArray, taxels: IntArray) -> FloatArray:
    """Return (n, 3, m) squared distances of ``taxels`` (n, m) from the corners of ``faces`` (m,) [m²]."""
    places = points.take(taxels, axis=0)
    away = np.empty((len(taxels), 3, len(faces)))
    for corner in range(3):
        offsets = surface.vertices.take(surface.faces[faces, corner], axis=0) - places
        np.vecdot(offsets, offsets, out=away[:, corner])
    return away


def _farther_everywhere(away: FloatArray) -> BoolArray:
    """Return (n, m) whether another taxel, the nearest to a corner of the face, is nearer to all of it.

    At most rounding of the face is then nearest to the taxel: at no corner is it nearer than the other one by more
    than ``_ROUNDING`` of what it is farther at another corner. The squared distance of the two taxels is at most twice
    the sum of their squared distances from a corner, so that it is farther there by at least ``_ROUNDING``.

    Args:
        away: (n, 3, m) squared distances of taxels from the corners of faces [m²].
    """
    every = np.arange(away.shape[2])
    farther = np.zeros((len(away), len(every)), dtype=bool)
    for nearest in away.argmin(axis=0):
        least = np.ascontiguousarray(away[nearest, :, every].T)
        more = away - least
        most = more.max(axis=1)
        clear = (more > 4 * _ROUNDING * (away + least)).any(axis=1)
        farther |= clear & (more.min(axis=1) >= -_ROUNDING * most)
    return farther


def _heights(values: FloatArray, corners: FloatArray) -> FloatArray:
    """Return (v, k) the linear function with ``values`` (3, k) at the corners of a face, at ``corners`` (v, 2, k)."""
    first, one, other = values
    return first + corners[:, 0] * (one - first) + corners[:, 1] * (other - first)


def _owners_around(surface: Mesh, owner: IntArray, count: int) -> csr_matrix:
    """Sparse (v, n), positive where a taxel owns a face at a vertex or at most one ring of faces further."""
    felt = owner >= 0
    first = np.concatenate([[0], np.cumsum(felt)])
    owns = csr_matrix((np.ones(first[-1], dtype=np.int32), owner[felt], first), (len(surface.faces), count))
    corner = _corners_of(surface, np.arange(len(surface.faces)))
    at_vertex = corner.T.tocsr()
    around: csr_matrix = at_vertex @ (corner @ (at_vertex @ owns))
    return around


def _corners_of(surface: Mesh, faces: IntArray) -> csr_matrix:
    """Sparse (m, v), one where a vertex is a corner of one of the ``faces`` (m,)."""
    first = np.arange(0, 3 * len(faces) + 1, 3)
    corner = surface.faces[faces].ravel()
    return csr_matrix((np.ones(len(corner), dtype=np.int32), corner, first), (len(faces), len(surface.vertices)))


def _near_taxels(surface: Mesh, points: FloatArray, faces: IntArray, around: csr_matrix) -> csr_matrix:
    """Sparse (m, n) true where a taxel may be the nearest to a part of one of the ``faces`` (m,)."""
    found = (_corners_of(surface, faces) @ around).tocsr()
    if not len(faces):
        return found
    counts = np.diff(found.indptr)  # positive: the taxel that owns a face is near it
    corners = surface.vertices.take(surface.faces[faces], axis=0)
    centres = corners.mean(axis=1)
    corners -= centres[:, None]
    reach = np.sqrt(np.vecdot(corners, corners).max(axis=1))
    offsets = points.take(found.indices, axis=0)
    offsets -= np.repeat(centres, counts, axis=0)
    away = np.sqrt(np.vecdot(offsets, offsets))
    start = found.indptr[:-1]
    close = away <= np.repeat((np.minimum.reduceat(away, start) + 2 * reach) * (1 + _TOUCHING), counts)
    kept = np.concatenate([[0], np.cumsum(np.add.reduceat(close, start, dtype=np.int64))])
    near = csr_matrix((close[close], found.indices[close], kept), found.shape)
    near.sort_indices()
    return near


@dataclass(frozen=True, eq=False)
class _Parts:
    """Convex parts of faces with the same number v of corners.

    Attributes:
        part: (k,) number of each part.
        corners: (v, 2, k) along both sides of the face from its first corner, in order around the part.
    """

    part: IntArray
    corners: FloatArray

    @staticmethod
    def joined(several: Sequence[_Parts]) -> _Parts:
        """Return the parts of all, which have the same number of corners."""
        if len(several) == 1:
            return several[0]
        part = np.concatenate([parts.part for parts in several])
        return _Parts(part, np.concatenate([parts.corners for parts in several], axis=2))

    def select(self, rows: IntArray) -> _Parts:
        """Return some of the parts."""
        return _Parts(self.part[rows], self.corners.take(rows, axis=2))

    def cut(self, values: FloatArray) -> Iterator[_Parts]:
        """Yield what is left without what is beyond planes of heights ``values`` (3, k) (Sutherland and Hodgman).

        Parts of which the same corners are beyond the plane are cut at once.
        """
        heights = _heights(values, self.corners)
        beyond = np.packbits(heights > _ROUNDING, axis=0, bitorder="little")
        for kind in _distinct_columns(beyond):
            rows = np.flatnonzero((beyond == kind[:, None]).all(axis=0))
            outside = np.unpackbits(kind, count=len(heights), bitorder="little").tolist()
            if not any(outside):
                yield self.select(rows)
            elif not all(outside):
                yield self.select(rows).without(outside, heights[:, rows])

    def without(self, outside: Sequence[int], heights: FloatArray) -> _Parts:
        """Return the parts without the corners that are ``outside`` (v,), at ``heights`` (v, k) above the plane."""
        corners = list[FloatArray]()
        for corner, after in enumerate([*range(1, len(outside)), 0]):
            if not outside[corner]:
                corners.append(self.corners[corner])
            if outside[corner] != outside[after]:
                low = heights[corner]
                share = np.clip(low / (low - heights[after]), 0.0, 1.0)
                corners.append(self.corners[corner] + share * (self.corners[after] - self.corners[corner]))
        return _Parts(self.part, np.stack(corners))

    def moments(self) -> tuple[FloatArray, FloatArray]:
        """Return (k, 2) centroids, and (k,) areas as twice the share of the face."""
        start = self.corners[0]
        sides = self.corners[1:] - start
        one = sides[:-1]
        other = sides[1:]
        parts = one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]
        areas = parts.sum(axis=0)
        weighted = (parts[:, None] * (one + other)).sum(axis=0) / 3
        return (start + weighted / np.where(areas > 0, areas, 1.0)).T, areas


def _clipped(values: FloatArray, counts: IntArray) -> Iterator[_Parts]:
    """Yield what is left of whole faces, by the number of corners; parts of which nothing is left are left out.

    Args:
        values: (p, 3) heights of the corners of a face above each plane that cuts it, by face.
        counts: (k,) number of planes that cut each face.
    """
    whole = np.array([(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)])[:, :, None]
    every = np.arange(len(counts))
    parts = {3: _Parts(every, np.repeat(whole, len(counts), axis=2))}
    first = np.cumsum(counts) - counts
    for step in range(int(counts.max(initial=0)) + 1):
        left = dict[int, list[_Parts]]()
        for same in parts.values():
            done = counts[same.part] == step
            yield same.select(np.flatnonzero(done))
            rest = same.select(np.flatnonzero(~done))
            for cut in rest.cut(values[first[rest.part] + step].T):
                left.setdefault(len(cut.corners), []).append(cut)
        parts = {count: _Parts.joined(several) for count, several in left.items() if count > 2}


def _distinct_columns(codes: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return the distinct columns (d, b) of ``codes`` (b, k)."""
    if len(codes) == 1:
        return np.flatnonzero(np.bincount(codes[0])).astype(np.uint8)[:, None]
    return np.unique(codes, axis=1).T
