"""The map's Jacobian, per triangle or fitted to a neighbourhood of taxels.

The Jacobian of a triangle is exact for the map as built, and as inaccurate as that map: with taxels 2 mm from their
assumed positions some triangles are flipped, and a controller using them diverges. The affine map fitted to a taxel and
its two rings averages out the errors of single taxels (at 8 mm pitch it tolerates 7 mm), so control uses that one.
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
"""Number of taxels whose fits are blended."""
_LEAST = 4
"""Number of taxels below which a fit is less accurate than the triangle."""
_BENT = 0.75
"""Rotation of the normal from a taxel to the rim of its second ring [rad] above which it is fitted over one ring. There
the error of a linear fit (5 degrees, measured at a pitch of 16 mm on a forearm of 36 mm) exceeds that of misplaced
taxels."""
_FLAT = 1e-3
"""Ratio of the singular values below which the smaller one is ignored."""


class _Near(NamedTuple):
    """Taxels (k,) that can be nearest to a point of one triangle, and their map points (k, 2) [m]."""

    taxels: IntArray
    points: FloatArray


class _Weighted(NamedTuple):
    """A taxel of the blend: its number, the offset from it to the point on the map (2,) [m], and its weight."""

    taxel: int
    offset: FloatArray
    weight: float


class MapJacobian:
    """Jacobian of a map at points on the body. Built once for a map; fits are computed at first use and kept.

    Args:
        map_: The map. The Jacobian of an enlarged patch is larger.

    Cost: 1 ms to build for 1000 taxels; 15 µs per query, 0.2 ms more in a new region.
    """

    def __init__(self, map_: TactileMap) -> None:
        self._map = map_
        skin = map_.skin
        self._body = skin.positions
        self._normals = skin.normals
        self._trees = [cKDTree(map_.taxel_points[a:b]) for a, b in zip(skin.first[:-1], skin.first[1:], strict=True)]
        self._near: dict[tuple[int, int], _Near] = {}
        self._fits: dict[int, FloatArray | None] = {}
        self._faces: dict[tuple[int, int], FloatArray] = {}
        self._slopes: dict[int, FloatArray | None] = {}
        self._last: tuple[SurfacePoint, list[_Weighted]] | None = None

    def at(self, point: SurfacePoint, *, kind: JacobianKind = "smoothed") -> FloatArray:
        """Return the Jacobian (2, 3): map velocity per velocity along the surface (link frame); zero along the normal.

        Args:
            point: Point on the body.
            kind: ``smoothed`` blends the fits of the nearest taxels; ``raw`` is that of the triangle, also used where
                none of those taxels has enough neighbours; ``isometric`` rotates like the smoothed one and maps steps
                on the body to steps of equal length, as if the map had no distortion.
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
        """Return the outward unit normal (3,) fitted to two rings of taxels, link frame; None if there are too few.

        The normals are fitted linearly over the map: exact on planes and cylinders. Of a calibration error only the
        part common to all taxels remains, while the normal of a single triangle is as inaccurate as the triangle.
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

    def normal_rate(self, point: SurfacePoint, velocity: FloatArray) -> FloatArray:
        """Return the rate (3,) [1/s] of ``normal`` where the point moves with a velocity (2,) on the map [m/s].

        Zero if there are too few taxels.
        """
        rate = np.zeros(3)
        total = 0.0
        if len(self._map.skin.patches[point.patch].taxels) < _LEAST:
            return rate
        for taxel, _, weight in self._nearest(point):
            slope = self._slope(taxel)
            if slope is not None:
                rate += weight * velocity.dot(slope[1:])
                total += weight
        return rate / total if total else rate

    def _nearest(self, point: SurfacePoint) -> list[_Weighted]:
        """Return the taxels of the blend, cached for the last point."""
        last = self._last
        if last is None or last[0] is not point:
            last = self._last = point, self._found_nearest(point)
        return last[1]

    def _found_nearest(self, point: SurfacePoint) -> list[_Weighted]:
        near = self._around(point.patch, point.face)
        offsets = self._map.to_map(point) - near.points
        away = np.einsum("ij,ij->i", offsets, offsets)
        places = away.argpartition(_BLENDED - 1)[:_BLENDED].tolist()
        return [_Weighted(int(near.taxels[k]), offsets[k], 1 / (float(away[k]) + 1e-12)) for k in places]

    def _around(self, patch: int, face: int) -> _Near:
        """Return candidates for the nearest taxels of any point in a triangle.

        They are at most as far from its centroid as the nearest of the centroid plus twice the radius of the triangle.
        """
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
        """Return the fit to a taxel's neighbourhood; None if that is too small."""
        if taxel not in self._fits:
            ring = self.two_rings(taxel)
            body = self._body[ring] - self._body[taxel]
            plane = self._map.taxel_points[ring]
            self._fits[taxel] = affine_fit(body, plane, self._normals[taxel]) if len(ring) >= _LEAST else None
        return self._fits[taxel]

    def _slope(self, taxel: int) -> FloatArray | None:
        """Return (3, 3) the normal at a taxel and its change per metre along both map axes; None if unknown."""
        if taxel not in self._slopes:
            fit = self._fit_normals(taxel, self.two_rings(taxel))
            if fit is not None and fit[1] > _BENT:
                fit = self._fit_normals(taxel, self.one_ring(taxel)) or fit
            self._slopes[taxel] = None if fit is None else fit[0]
        return self._slopes[taxel]

    def _fit_normals(self, taxel: int, ring: IntArray) -> tuple[FloatArray, float] | None:
        """Return the least squares fit and the approximate rotation of the normal from the taxel to the rim [rad]."""
        if len(ring) < _LEAST:
            return None
        offsets = self._map.taxel_points[ring] - self._map.taxel_points[taxel]
        fit = np.linalg.pinv(np.column_stack([np.ones(len(ring)), offsets]), rcond=1e-6) @ self._normals[ring]
        reach = float(np.linalg.norm(offsets, axis=1).max())
        return fit, reach * float(np.linalg.norm(fit[1:], 2))

    def one_ring(self, taxel: int) -> IntArray:
        """Return the taxel and its neighbours, without those across a seam."""
        first = self._graph.indices[self._graph.indptr[taxel] : self._graph.indptr[taxel + 1]]
        return np.unique(np.concatenate([[taxel], first]))

    def two_rings(self, taxel: int) -> IntArray:
        """Return the taxel, its neighbours and theirs, without those across a seam; 19 in a complete lattice."""
        first = self.one_ring(taxel)
        return np.unique(np.concatenate([first, self._graph[first].indices]))

    @cached_property
    def _graph(self) -> csr_matrix:
        """Graph of taxels that are neighbours on body and map."""
        pairs = self._map.skin.neighbours
        skin = self._map.skin
        on_body = np.linalg.norm(np.diff(self._body[pairs], axis=1)[:, 0], axis=1)
        on_map = np.linalg.norm(np.diff(self._map.taxel_points[pairs], axis=1)[:, 0], axis=1)
        scales = np.array([placement.scale for placement in self._map.layout.placements])
        i, j = pairs[on_map <= SEAM_RATIO * scales[skin.patch_of[pairs[:, 0]]] * on_body].T
        ends = np.concatenate([i, j]), np.concatenate([j, i])
        return coo_matrix((np.ones(2 * len(i)), ends), shape=(len(skin), len(skin))).tocsr()


def affine_fit(body: FloatArray, plane: FloatArray, normal: FloatArray) -> FloatArray:
    """Return the linear part (2, 3) of the least squares affine map from the tangent plane to the map.

    Args:
        body: (k, 3) points relative to the central one [m]; each is moved into the tangent plane at its true distance.
        plane: (k, 2) their map points [m].
        normal: (3,) unit normal at the centre.

    For collinear points the result is zero across their line.
    """
    flat = body - np.outer(body @ normal, normal)
    length = np.linalg.norm(flat, axis=1)
    true = np.linalg.norm(body, axis=1)
    flat = flat * np.divide(true, length, out=np.ones_like(true), where=length > 1e-9)[:, None]
    centred = flat - flat.mean(axis=0)
    centred -= np.outer(centred @ normal, normal)
    return (np.linalg.pinv(centred, rcond=1e-6) @ (plane - plane.mean(axis=0))).T


def nearest_isometry(jacobian: FloatArray) -> FloatArray:
    """Return the orthogonal factor (2, 3) of the polar decomposition: the nearest isometry in the mean square.

    Args:
        jacobian: (2, 3) of the map.
    """
    left, _, right = np.linalg.svd(jacobian, full_matrices=False)
    return np.asarray(left @ right)


def least_norm_motion(jacobian: FloatArray, velocity: FloatArray) -> FloatArray:
    """Return the smallest velocity (3,) along the skin with a ``velocity`` (2,) on the map, by the pseudo-inverse.

    Uses the 2 x 2 normal equations (2 µs); the direction in which the map is nearly flat (``_FLAT``) is ignored.

    Args:
        jacobian: (2, 3) of the map.
        velocity: (2,) requested.
    """
    (xx, xy), (_, yy) = jacobian.dot(jacobian.T).tolist()
    determinant = xx * yy - xy * xy
    largest = 0.5 * (xx + yy) + math.hypot(0.5 * (xx - yy), xy)
    if determinant <= (_FLAT * largest) ** 2:
        return np.linalg.pinv(jacobian, rcond=_FLAT).dot(velocity)
    x, y = velocity.tolist()
    return np.array(((yy * x - xy * y) / determinant, (xx * y - xy * x) / determinant)).dot(jacobian)
