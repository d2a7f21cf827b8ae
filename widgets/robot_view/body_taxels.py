"""Where the taxels are on the moving body: in the world, in the picture, and which one a place means."""

from __future__ import annotations

import numpy as np

from app.arrays import BoolArray, FloatArray, IntArray
from app.geometry.surface_point import SurfacePoint
from app.session.prepare import Prepared
from widgets.robot_view.pick import SkinPicker
from widgets.robot_view.viewpoint import CameraRay, Viewpoint

_SKIN = 3e-3
"""What is met no more than this before a taxel is the skin around it [m]."""


class BodyTaxels:
    """The taxels of one robot. Built once, asked with the links' poses of the moment.

    Args:
        prepared: Robot and skin.
        picker: Of the same robot.
    """

    def __init__(self, prepared: Prepared, picker: SkinPicker) -> None:
        self._skin, self._picker = prepared.skin, picker
        self._links = [prepared.robot.link_index[patch.link] for patch in prepared.skin.patches]

    def world(self, poses: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Positions [m] and unit normals, (taxels, 3) each, world frame; ``poses``: (links, 4, 4) ``T_world_link``."""
        positions, normals = np.zeros((2, len(self._skin), 3))
        for number, patch in enumerate(self._skin.patches):
            own, pose = slice(*self._skin.first[number : number + 2]), poses[self._links[number]]
            positions[own] = patch.taxels.positions @ pose[:3, :3].T + pose[:3, 3]
            normals[own] = patch.taxels.normals @ pose[:3, :3].T
        return positions, normals

    def pixels(self, view: Viewpoint, size: tuple[int, int], poses: FloatArray) -> FloatArray:
        """(taxels, 2) where those are that face the eye; NaN for the others."""
        return facing_pixels(*self.world(poses), view, size)

    def hidden(self, taxels: IntArray, view: Viewpoint, poses: FloatArray) -> BoolArray:
        """(k,) which of these have something between them and the eye; poses as the picker's.

        Cost: 10 µs a taxel and mesh.
        """
        positions, _ = self.world(poses)
        return np.array([self._covered(point, view.eye, poses) for point in positions[taxels]], bool)

    def _covered(self, point: FloatArray, eye: FloatArray, poses: FloatArray) -> bool:
        towards = point - eye
        away = float(np.linalg.norm(towards))
        nearest = self._picker.distance(CameraRay(eye, towards / away), poses)
        return nearest < away - _SKIN

    def nearest(self, at: SurfacePoint) -> int | None:
        """The taxel of the same patch nearest to a place on the skin; None for a patch without taxels."""
        taxels = self._skin.patches[at.patch].taxels
        if not len(taxels):
            return None
        away = taxels.positions - self._skin.position(at)
        return int(self._skin.first[at.patch] + np.argmin(np.einsum("kd,kd->k", away, away)))


def facing_pixels(positions: FloatArray, normals: FloatArray, view: Viewpoint, size: tuple[int, int]) -> FloatArray:
    """(n, 2) where places (n, 3) [m] are that face the eye with their normals (n, 3); NaN for the others."""
    facing = np.einsum("nk,nk->n", normals, view.eye - positions) > 0
    return np.where(facing[:, None], view.pixels(positions, size), np.nan)
