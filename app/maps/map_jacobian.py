"""The map's Jacobian: how the map point of a place moves with it, as its triangle says or its neighbourhood.

The triangles' own Jacobian is exact for the map that was made, and as wrong as that map: where taxels are believed 2 mm
from where they are, some triangles are turned over, and a loop closed through them runs away. The affine map fitted to
a taxel and its two rings forgets the single taxel's error (at 8 mm pitch it survives 7 mm), so control uses that one.
"""

from __future__ import annotations

from functools import cached_property
from typing import Literal, TypeAlias

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix
from scipy.spatial import cKDTree

from app.arrays import FloatArray, IntArray
from app.geometry.surface_point import SurfacePoint
from app.maps.tactile_map import TactileMap

JacobianKind: TypeAlias = Literal["smoothed", "raw"]
_TORN = 2.0
"""Neighbours farther apart on the map than this many times their distance on the body have a seam between them."""
_BLENDED = 3
"""Taxels whose fits are blended between them."""
_LEAST = 4
"""Taxels, below which a fit says less than the triangle."""


class MapJacobian:
    """Answers for points on the body. Built once for a map; fits are made when first asked for, and kept.

    Args:
        map_: The map. A patch drawn larger has a larger Jacobian.

    Cost: 1 ms to build for 1000 taxels; 30 µs a question, 0.1 ms more where nobody asked before.
    """

    def __init__(self, map_: TactileMap) -> None:
        self._map, skin = map_, map_.skin
        self._body = np.concatenate([patch.taxels.positions for patch in skin.patches])
        self._normals = np.concatenate([patch.taxels.normals for patch in skin.patches])
        self._trees = [cKDTree(map_.taxel_points[a:b]) for a, b in zip(skin.first[:-1], skin.first[1:], strict=True)]
        self._fits: dict[int, FloatArray] = {}

    def at(self, point: SurfacePoint, *, kind: JacobianKind = "smoothed") -> FloatArray:
        """(2, 3) map velocity per velocity along the surface (link frame); none for motion along the normal.

        Args:
            point: Where on the body.
            kind: ``smoothed`` blends the fits of the nearest taxels, ``raw`` is the triangle's own.
        """
        if kind == "raw":
            return self._of_face(point)
        first = int(self._map.skin.first[point.patch])
        count = int(self._map.skin.first[point.patch + 1]) - first
        if count < _LEAST:
            return self._of_face(point)
        away, near = self._trees[point.patch].query(self._map.to_map(point), k=_BLENDED)
        weights = 1 / (np.asarray(away) ** 2 + 1e-12)
        fits = np.stack([self._of_taxel(first + int(taxel), point) for taxel in near])
        return np.einsum("k,kij->ij", weights / weights.sum(), fits)

    def _of_face(self, at: SurfacePoint) -> FloatArray:
        corners = self._map.skin.patches[at.patch].surface
        body = corners.vertices[corners.faces[at.face]]
        plane = self._map.uv[at.patch][self._map.charts[at.patch].faces[at.face]]
        return (plane[1:] - plane[0]).T @ np.linalg.pinv((body[1:] - body[0]).T, rcond=1e-9)

    def _of_taxel(self, taxel: int, asked: SurfacePoint) -> FloatArray:
        if taxel not in self._fits:
            ring = self.two_rings(taxel)
            if len(ring) < _LEAST:
                return self._of_face(asked)
            body, plane = self._body[ring] - self._body[taxel], self._map.taxel_points[ring]
            self._fits[taxel] = affine_fit(body, plane, self._normals[taxel])
        return self._fits[taxel]

    def two_rings(self, taxel: int) -> IntArray:
        """The taxel, its neighbours and theirs, as far as no seam lies between; 19 where the lattice is whole."""
        first = self._graph.indices[self._graph.indptr[taxel] : self._graph.indptr[taxel + 1]]
        return np.unique(np.concatenate([[taxel], first, self._graph[first].indices]))

    @cached_property
    def _graph(self) -> csr_matrix:
        """Which taxels are neighbours on the map too."""
        pairs, skin = self._map.skin.neighbours, self._map.skin
        on_body = np.linalg.norm(np.diff(self._body[pairs], axis=1)[:, 0], axis=1)
        on_map = np.linalg.norm(np.diff(self._map.taxel_points[pairs], axis=1)[:, 0], axis=1)
        scales = np.array([placement.scale for placement in self._map.layout.placements])
        i, j = pairs[on_map <= _TORN * scales[skin.patch_of[pairs[:, 0]]] * on_body].T
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
