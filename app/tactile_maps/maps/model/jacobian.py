"""The map's Jacobian: how the map point of a place moves with it, as its triangle says or its neighbourhood.

The triangles' own Jacobian is exact for the map that was made, and as wrong as that map: where taxels are believed 2 mm
from where they are, some triangles are flipped, and a loop closed through them runs away. The affine map fitted to
a taxel and its two rings forgets the single taxel's error (at 8 mm pitch it survives 7 mm), so control uses that one.
"""

from __future__ import annotations

import math
from functools import cached_property
from typing import Literal, NamedTuple, TypeAlias

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix
from scipy.spatial import cKDTree

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.maps.model.tactile_map import SEAM_RATIO, TactileMap

JacobianKind: TypeAlias = Literal["smoothed", "raw", "isometric"]
_BLENDED = 3
"""Taxels whose fits are blended between them."""
_LEAST = 4
"""Taxels, below which a fit says less than the triangle."""
_BENT = 0.75
"""A normal that turns by more from a taxel to the rim of its second ring [rad] is fitted over one ring: there a linear
fit is wrong by more (5 degrees, measured at a pitch of 16 mm on a forearm of 36 mm) than misplaced taxels spoil."""
_FLAT = 1e-3
"""A smaller singular value below this share of the larger carries nothing."""


class _Near(NamedTuple):
    """Taxels (k,) that can be nearest to a point of one triangle, and where they are on the map (k, 2) [m]."""

    taxels: IntArray
    points: FloatArray


class _Weighted(NamedTuple):
    """A taxel whose fit counts: its number, the way from it to the point on the map (2,) [m], and its weight."""

    taxel: int
    offset: FloatArray
    weight: float


class MapJacobian:
    """Answers for points on the body. Built once for a map; the rest is made when first asked for, and kept.

    Args:
        map_: The map. A patch drawn larger has a larger Jacobian.

    Cost: 1 ms to build for 1000 taxels; 15 µs a question, 0.2 ms more where nobody asked before.
    """

    def __init__(self, map_: TactileMap) -> None:
        self._map = map_
        skin = map_.skin
        self._body = np.concatenate([patch.taxels.positions for patch in skin.patches])
        self._normals = np.concatenate([patch.taxels.normals for patch in skin.patches])
        self._trees = [cKDTree(map_.taxel_points[a:b]) for a, b in zip(skin.first[:-1], skin.first[1:], strict=True)]
        self._near: dict[tuple[int, int], _Near] = {}
        self._fits: dict[int, FloatArray | None] = {}
        self._faces: dict[tuple[int, int], FloatArray] = {}
        self._slopes: dict[int, FloatArray | None] = {}
        self._asked: tuple[SurfacePoint, list[_Weighted]] | None = None

    def at(self, point: SurfacePoint, *, kind: JacobianKind = "smoothed") -> FloatArray:
        """(2, 3) map velocity per velocity along the surface (link frame); none for motion along the normal.

        Args:
            point: Where on the body.
            kind: ``smoothed`` blends the fits of the nearest taxels, ``raw`` is the triangle's own, and so is the
                answer where none of those has enough neighbours for a fit; ``isometric`` turns as the smoothed one
                and takes a step on the map for as long as on the body, as if the map distorted nothing.
        """
        if kind == "isometric":
            return self._layout_scale(point) * nearest_isometry(self.at(point))
        if kind == "raw" or len(self._map.skin.patches[point.patch].taxels) < _LEAST:
            return self._of_face(point.patch, point.face)
        blend = np.zeros((2, 3))
        total = 0.0
        for taxel, _, weight in self._nearest(point):
            fit = self._of_taxel(taxel)
            if fit is not None:
                blend = blend + weight * fit
                total = total + weight
        return blend / total if total else self._of_face(point.patch, point.face)

    def _layout_scale(self, point: SurfacePoint) -> float:
        return self._map.layout.placements[point.patch].scale

    def normal(self, point: SurfacePoint) -> FloatArray | None:
        """(3,) outward unit normal as the taxels' two rings around have it, link frame; None where they are too few.

        Their normals, fitted linearly over the map: right on planes and cylinders, and of a calibration's error only
        that is left which is common to all of them, while a single triangle's normal is as wrong as the triangle.
        """
        if len(self._map.skin.patches[point.patch].taxels) < _LEAST:
            return None
        blend = np.zeros(3)
        for taxel, offset, weight in self._nearest(point):
            slope = self._slope(taxel)
            if slope is not None:
                blend += weight * (slope[0] + offset.dot(slope[1:]))
        length = math.sqrt(blend.dot(blend))
        return blend / length if length else None

    def _nearest(self, point: SurfacePoint) -> list[_Weighted]:
        """The taxels whose fits count; of the point asked last they are known."""
        asked = self._asked
        if asked is None or asked[0] is not point:
            asked = self._asked = point, self._found_nearest(point)
        return asked[1]

    def _found_nearest(self, point: SurfacePoint) -> list[_Weighted]:
        near = self._around(point.patch, point.face)
        offsets = self._map.to_map(point) - near.points
        away = np.einsum("ij,ij->i", offsets, offsets)
        places = away.argpartition(_BLENDED - 1)[:_BLENDED].tolist()
        return [_Weighted(int(near.taxels[k]), offsets[k], 1 / (float(away[k]) + 1e-12)) for k in places]

    def _around(self, patch: int, face: int) -> _Near:
        """The nearest of a point are no farther from the middle of its triangle than from the point and that way."""
        near = self._near.get((patch, face))
        if near is None:
            corners = self._map.uv[patch][self._map.charts[patch].faces[face]]
            middle = corners.mean(axis=0)
            reach = float(np.linalg.norm(corners - middle, axis=1).max())
            away, _ = self._trees[patch].query(middle, k=_BLENDED)
            found = self._trees[patch].query_ball_point(middle, (away[-1] + 2 * reach) * (1 + 1e-9), return_sorted=True)
            taxels = np.array(found, dtype=np.int64) + self._map.skin.first[patch]
            near = self._near[patch, face] = _Near(taxels, self._map.taxel_points[taxels])
        return near

    def _of_face(self, patch: int, face: int) -> FloatArray:
        own = self._faces.get((patch, face))
        if own is None:
            surface = self._map.skin.patches[patch].surface
            body = surface.vertices[surface.faces[face]]
            plane = self._map.uv[patch][self._map.charts[patch].faces[face]]
            own = (plane[1:] - plane[0]).T @ np.linalg.pinv((body[1:] - body[0]).T, rcond=1e-9)
            self._faces[patch, face] = own
        return own

    def _of_taxel(self, taxel: int) -> FloatArray | None:
        """The fit to a taxel's neighbourhood; None where that is too small for one."""
        if taxel not in self._fits:
            ring = self.two_rings(taxel)
            body = self._body[ring] - self._body[taxel]
            plane = self._map.taxel_points[ring]
            self._fits[taxel] = affine_fit(body, plane, self._normals[taxel]) if len(ring) >= _LEAST else None
        return self._fits[taxel]

    def _slope(self, taxel: int) -> FloatArray | None:
        """(3, 3) the normal at a taxel and its change per metre along both axes of the map; None of too few."""
        if taxel not in self._slopes:
            fit = self._fit_normals(taxel, self.two_rings(taxel))
            if fit is not None and fit[1] > _BENT:
                fit = self._fit_normals(taxel, self.one_ring(taxel)) or fit
            self._slopes[taxel] = None if fit is None else fit[0]
        return self._slopes[taxel]

    def _fit_normals(self, taxel: int, ring: IntArray) -> tuple[FloatArray, float] | None:
        """The fit in the mean square, and how far the normal turns from the taxel to the rim, about [rad]."""
        if len(ring) < _LEAST:
            return None
        offsets = self._map.taxel_points[ring] - self._map.taxel_points[taxel]
        fit = np.linalg.pinv(np.column_stack([np.ones(len(ring)), offsets]), rcond=1e-6) @ self._normals[ring]
        reach = float(np.linalg.norm(offsets, axis=1).max())
        return fit, reach * float(np.linalg.norm(fit[1:], 2))

    def one_ring(self, taxel: int) -> IntArray:
        """The taxel and its neighbours, as far as no seam lies between."""
        first = self._graph.indices[self._graph.indptr[taxel] : self._graph.indptr[taxel + 1]]
        return np.unique(np.concatenate([[taxel], first]))

    def two_rings(self, taxel: int) -> IntArray:
        """The taxel, its neighbours and theirs, as far as no seam lies between; 19 where the lattice is whole."""
        first = self.one_ring(taxel)
        return np.unique(np.concatenate([first, self._graph[first].indices]))

    @cached_property
    def _graph(self) -> csr_matrix:
        """Which taxels are neighbours on the map too."""
        pairs = self._map.skin.neighbours
        skin = self._map.skin
        on_body = np.linalg.norm(np.diff(self._body[pairs], axis=1)[:, 0], axis=1)
        on_map = np.linalg.norm(np.diff(self._map.taxel_points[pairs], axis=1)[:, 0], axis=1)
        scales = np.array([placement.scale for placement in self._map.layout.placements])
        i, j = pairs[on_map <= SEAM_RATIO * scales[skin.patch_of[pairs[:, 0]]] * on_body].T
        ends = np.concatenate([i, j]), np.concatenate([j, i])
        return coo_matrix((np.ones(2 * len(i)), ends), shape=(len(skin), len(skin))).tocsr()


def affine_fit(body: FloatArray, plane: FloatArray, normal: FloatArray) -> FloatArray:
    """The linear part (2, 3) of the affine map that fits best, in the mean square, from the tangent plane to the map.

    Args:
        body: (k, 3) points from the one in the middle [m]; each is laid into the tangent plane at its true distance.
        plane: (k, 2) where they are on the map [m].
        normal: (3,) unit normal in the middle.

    Points on one line say nothing across it; the answer is zero there.
    """
    flat = body - np.outer(body @ normal, normal)
    length = np.linalg.norm(flat, axis=1)
    true = np.linalg.norm(body, axis=1)
    flat = flat * np.divide(true, length, out=np.ones_like(true), where=length > 1e-9)[:, None]
    centred = flat - flat.mean(axis=0)
    centred -= np.outer(centred @ normal, normal)
    return (np.linalg.pinv(centred, rcond=1e-6) @ (plane - plane.mean(axis=0))).T


def nearest_isometry(jacobian: FloatArray) -> FloatArray:
    """(2, 3) the orthogonal factor of the polar decomposition: the nearest in the mean square that stretches nothing.

    Args:
        jacobian: (2, 3) of the map.
    """
    left, _, right = np.linalg.svd(jacobian, full_matrices=False)
    return np.asarray(left @ right)


def least_norm_motion(jacobian: FloatArray, velocity: FloatArray) -> FloatArray:
    """(3,) the least velocity along the skin with a ``velocity`` (2,) on the map: the answer of the pseudo-inverse.

    By the normal equations, two by two, in 2 µs; a map squeezed flat (``_FLAT``) says nothing across.

    Args:
        jacobian: (2, 3) of the map.
        velocity: (2,) wanted.
    """
    (xx, xy), (_, yy) = jacobian.dot(jacobian.T).tolist()
    determinant = xx * yy - xy * xy
    largest = 0.5 * (xx + yy) + math.hypot(0.5 * (xx - yy), xy)
    if determinant <= (_FLAT * largest) ** 2:
        return np.linalg.pinv(jacobian, rcond=_FLAT).dot(velocity)
    x, y = velocity.tolist()
    return np.array(((yy * x - xy * y) / determinant, (xx * y - xy * x) / determinant)).dot(jacobian)
