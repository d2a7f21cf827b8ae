"""Where a ray first meets a mesh: a search tree built once, asked at every move of the mouse."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from igl.embree import EmbreeIntersector

from app.arrays import FloatArray
from app.errors import MeshError
from app.geometry.closest import barycentric
from app.geometry.mesh import Mesh


@dataclass(frozen=True)
class RayHit:
    """The first meeting of a ray and a mesh.

    Attributes:
        face: Which triangle.
        weights: Barycentric weights there.
        distance: Along the ray [m].
    """

    face: int
    weights: tuple[float, float, float]
    distance: float


class RayCaster:
    """Casts rays against one mesh, in the mesh's own frame; a moving link moves the ray instead.

    Args:
        mesh: At least one face.
    """

    def __init__(self, mesh: Mesh) -> None:
        if not len(mesh.faces):
            raise MeshError("the mesh has no faces to hit")
        # Embree works in single precision: centre and scale first, so that far or tiny meshes keep their digits.
        self._mesh, self._centre, self._size = mesh, mesh.bounds.mean(axis=0), mesh.size or 1.0
        local = np.ascontiguousarray((mesh.vertices - self._centre) / self._size, dtype=np.float32)
        self._tree = EmbreeIntersector()
        self._tree.init(local, np.ascontiguousarray(mesh.faces, dtype=np.int32))

    def first_hit(self, origin: FloatArray, direction: FloatArray) -> RayHit | None:
        """The nearest face along the ray, from either side, or None when it misses.

        Args:
            origin: (3,) [m].
            direction: (3,), not zero; its length does not matter.
        """
        raise_if_bad(origin, direction)
        unit = np.asarray(direction, dtype=np.float64) / np.linalg.norm(direction)
        start = (np.asarray(origin, dtype=np.float64) - self._centre) / self._size
        # Start near the mesh: single precision loses a millimetre when the camera is a kilometre away.
        forward = max(float(-start @ unit) - 1.0, 0.0)
        near = (start + forward * unit).astype(np.float32)
        face, distance, _, _ = self._tree.intersectRay_first(near, unit.astype(np.float32))
        if face < 0 or not np.isfinite(distance):
            return None
        along = (forward + distance) * self._size
        return self._exact(int(face), np.asarray(origin, dtype=np.float64), unit, along)

    def _exact(self, face: int, origin: FloatArray, unit: FloatArray, along: float) -> RayHit:
        """Meet the face's plane again in double precision; grazing rays keep the single-precision distance."""
        corners = self._mesh.vertices[self._mesh.faces[face]]
        normal = self._mesh.face_normals[face]
        slope = float(normal @ unit)
        if abs(slope) > 1e-6:
            along = float(normal @ (corners[0] - origin)) / slope
        a, b, c = barycentric(corners[None], (origin + along * unit)[None])[0]
        return RayHit(face, (float(a), float(b), float(c)), along)


def raise_if_bad(origin: FloatArray, direction: FloatArray) -> None:
    """Refuse a ray that native code would choke on."""
    if not (np.isfinite(origin).all() and np.isfinite(direction).all() and np.linalg.norm(direction) > 0):
        raise MeshError("a ray needs a finite origin and a direction", value=(list(origin), list(direction)))
