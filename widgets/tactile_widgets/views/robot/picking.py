"""Skin, bodies and taxels under a pixel.

Rays are cast in each link's own frame, so that nothing is rebuilt when the arm moves.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.geometry.surface.raycast import RayCaster, RayHit, ray_caster
from tactile_maps.session.prepare import PreparedScene
from tactile_widgets.views.robot.actors.camera import CameraRay, Viewpoint
from tactile_widgets.views.robot.actors.opening_view import taxels_in_world


class SkinPicker:
    """Finds skin and bodies along rays. Built once for a prepared scene.

    Bodies are numbered: the robot's links, then the scene's objects; ``poses`` are theirs, (links + objects, 4, 4)
    in the world.

    Attributes:
        hidden: Bodies that rays pass through.

    Cost: about 35 µs per link or object.
    """

    def __init__(self, prepared: PreparedScene) -> None:
        index = prepared.robot.link_index
        self._skin = [(index[patch.link], ray_caster(patch.surface)) for patch in prepared.skin.patches]
        meshes = [link.mesh for link in prepared.robot.links] + [body.mesh for body in prepared.objects]
        self._bare = [
            (number, ray_caster(mesh)) for number, mesh in enumerate(meshes) if mesh is not None and len(mesh.faces)
        ]
        self.hidden: frozenset[int] = frozenset()

    def pick(self, ray: CameraRay, poses: FloatArray) -> SurfacePoint | None:
        """Return the first skin location along the ray; None without one, or if a bare body is in front of it."""
        skin = self._first(self._skin, ray, poses)
        if skin is None:
            return None
        bare = self._first(self._bare, ray, poses)
        if bare is not None and bare.hit.distance < skin.hit.distance:
            return None
        return SurfacePoint(skin.place, skin.hit.face, skin.hit.weights)

    def bare_body(self, ray: CameraRay, poses: FloatArray) -> int | None:
        """Return the first body along the ray, without skins; None without one."""
        found = self._first(self._bare, ray, poses)
        return None if found is None else found.body

    def any_body(self, ray: CameraRay, poses: FloatArray) -> tuple[int, float] | None:
        """Return the first body along the ray, covered by skin or not, and its distance [m]; None without one."""
        found = self._first((*self._skin, *self._bare), ray, poses)
        return None if found is None else (found.body, found.hit.distance)

    def _first(self, casters: Sequence[tuple[int, RayCaster]], ray: CameraRay, poses: FloatArray) -> _Found | None:
        hits = (
            _Found(place, body, hit)
            for place, (body, caster) in enumerate(casters)
            if body not in self.hidden and (hit := caster.first_hit(*_local(ray, poses[body]))) is not None
        )
        return min(hits, key=lambda found: found.hit.distance, default=None)


class _Found(NamedTuple):
    """A hit on a body, with the body's place in the list of casters."""

    place: int
    body: int
    hit: RayHit


def _local(ray: CameraRay, pose: FloatArray) -> tuple[FloatArray, FloatArray]:
    rotation = pose[:3, :3]
    return rotation.T @ (ray.origin - pose[:3, 3]), rotation.T @ ray.direction


_SKIN = 3e-3
"""Distance up to which a surface in front of a taxel is the skin around it [m]."""


class BodyTaxels:
    """Locations and visibility of the taxels of a moving robot. Built once for a prepared scene.

    Args:
        prepared: Robot and skin.
        picker: Picker of the same robot.
    """

    def __init__(self, prepared: PreparedScene, picker: SkinPicker) -> None:
        self._prepared = prepared
        self._skin = prepared.skin
        self._picker = picker
        self._links = [prepared.robot.link_index[patch.link] for patch in prepared.skin.patches]

    def world(self, poses: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return positions [m] and unit normals, (taxels, 3) each, world frame, for link poses (links, 4, 4)."""
        return taxels_in_world(self._prepared, poses)

    def pixels(self, view: Viewpoint, size: tuple[int, int], poses: FloatArray) -> FloatArray:
        """(taxels, 2) pixels of taxels that face the camera; NaN for others, and on hidden links."""
        pixels = facing_pixels(*self.world(poses), view, size)
        for number, link in enumerate(self._links):
            if link in self._picker.hidden:
                pixels[slice(*self._skin.first[number : number + 2])] = np.nan
        return pixels

    def hidden(self, taxels: IntArray, view: Viewpoint, poses: FloatArray) -> BoolArray:
        """(k,) whether something is between each of these taxels and the camera; ``poses`` are the picker's.

        Cost: 10 µs per taxel and mesh.
        """
        positions, _ = self.world(poses)
        return np.array([self._covered(point, view.eye, poses) for point in positions[taxels]], bool)

    def _covered(self, point: FloatArray, eye: FloatArray, poses: FloatArray) -> bool:
        distance = float(np.linalg.norm(point - eye))
        found = self._picker.any_body(CameraRay(eye, (point - eye) / distance), poses)
        return found is not None and found[1] < distance - _SKIN

    def nearest(self, at: SurfacePoint) -> int | None:
        """Return the taxel of the same patch nearest to a skin location; None for a patch without taxels."""
        taxels = self._skin.patches[at.patch].taxels
        if not len(taxels):
            return None
        away = taxels.positions - self._skin.position(at)
        return int(self._skin.first[at.patch] + np.argmin(np.einsum("kd,kd->k", away, away)))


def facing_pixels(positions: FloatArray, normals: FloatArray, view: Viewpoint, size: tuple[int, int]) -> FloatArray:
    """(n, 2) pixels of points (n, 3) [m] whose normals (n, 3) face the camera; NaN for others."""
    facing = np.einsum("nk,nk->n", normals, view.eye - positions) > 0
    return np.where(facing[:, None], view.pixels(positions, size), np.nan)
