"""The skin under a pixel: a ray cast in each link's own frame, so nothing is rebuilt when the arm moves.

And the taxels of the moving body: in the world, in the picture, hidden or not, and which one a place means.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.geometry.surface.raycast import RayCaster, ray_caster
from tactile_maps.session.prepare import PreparedScene
from tactile_widgets.views.robot.scene.camera import CameraRay, Viewpoint


class SkinPicker:
    """Finds skin along rays; bare links and objects in front hide it. Built once for a scene.

    Poses are those of the robot's links and then those of the scene's objects.

    Attributes:
        hidden: Links, and objects behind the links, by number, that rays pass through.

    Cost: about 35 µs a link or object.
    """

    def __init__(self, prepared: PreparedScene) -> None:
        index = prepared.robot.link_index
        self._skin = [(index[patch.link], ray_caster(patch.surface)) for patch in prepared.skin.patches]
        self._bare = [
            (index[link.name], ray_caster(link.mesh))
            for link in prepared.robot.links
            if link.mesh is not None and len(link.mesh.faces)
        ]
        first = len(prepared.robot.links)
        self._bare += [(first + k, ray_caster(body.mesh)) for k, body in enumerate(prepared.objects)]
        self.hidden: frozenset[int] = frozenset()

    def pick(self, ray: CameraRay, poses: FloatArray) -> SurfacePoint | None:
        """The nearest skin along the ray, or None where there is none or a bare link is in front.

        Args:
            ray: World frame.
            poses: (links + objects, 4, 4) in the world.
        """
        best = np.inf
        found = None
        for number, (link, caster) in enumerate(self._skin):
            if link in self.hidden:
                continue
            hit = caster.first_hit(*_local(ray, poses[link]))
            if hit is not None and hit.distance < best:
                best = hit.distance
                found = SurfacePoint(number, hit.face, hit.weights)
        for link, caster in self._seen(self._bare):
            hit = caster.first_hit(*_local(ray, poses[link]))
            if hit is not None and hit.distance < best:
                return None
        return found

    def _seen(self, casters: Iterable[tuple[int, RayCaster]]) -> list[tuple[int, RayCaster]]:
        return [one for one in casters if one[0] not in self.hidden]

    def bare_body(self, ray: CameraRay, poses: FloatArray) -> int | None:
        """The link, or the object behind the links, that the ray meets first; None where it meets nothing."""
        hits = [(caster.first_hit(*_local(ray, poses[body])), body) for body, caster in self._seen(self._bare)]
        return min(((hit.distance, body) for hit, body in hits if hit is not None), default=(0.0, None))[1]

    def any_body(self, ray: CameraRay, poses: FloatArray) -> tuple[int, float] | None:
        """The link, or the object behind the links, that the ray meets first with its skin or bare, and how far [m]."""
        bodies = self._seen((*self._skin, *self._bare))
        hits = [(caster.first_hit(*_local(ray, poses[body])), body) for body, caster in bodies]
        return min(
            ((body, hit.distance) for hit, body in hits if hit is not None), key=lambda met: met[1], default=None
        )

    def distance(self, ray: CameraRay, poses: FloatArray) -> float:
        """How far along the ray [m] it first meets anything; infinite where it meets nothing."""
        bodies = self._seen((*self._skin, *self._bare))
        hits = (caster.first_hit(*_local(ray, poses[link])) for link, caster in bodies)
        return min((hit.distance for hit in hits if hit is not None), default=np.inf)


def _local(ray: CameraRay, pose: FloatArray) -> tuple[FloatArray, FloatArray]:
    rotation = pose[:3, :3]
    return rotation.T @ (ray.origin - pose[:3, 3]), rotation.T @ ray.direction


_SKIN = 3e-3
"""What is met no more than this before a taxel is the skin around it [m]."""


class BodyTaxels:
    """The taxels of one robot. Built once, asked with the links' poses of the moment.

    Args:
        prepared: Robot and skin.
        picker: Of the same robot.
    """

    def __init__(self, prepared: PreparedScene, picker: SkinPicker) -> None:
        self._skin = prepared.skin
        self._picker = picker
        self._links = [prepared.robot.link_index[patch.link] for patch in prepared.skin.patches]

    def world(self, poses: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Positions [m] and unit normals, (taxels, 3) each, world frame; ``poses``: (links, 4, 4) ``T_world_link``."""
        positions, normals = np.zeros((2, len(self._skin), 3))
        for number, patch in enumerate(self._skin.patches):
            own = slice(*self._skin.first[number : number + 2])
            pose = poses[self._links[number]]
            positions[own] = patch.taxels.positions @ pose[:3, :3].T + pose[:3, 3]
            normals[own] = patch.taxels.normals @ pose[:3, :3].T
        return positions, normals

    def pixels(self, view: Viewpoint, size: tuple[int, int], poses: FloatArray) -> FloatArray:
        """(taxels, 2) where those are that face the eye; NaN for the others, and for those of hidden links."""
        pixels = facing_pixels(*self.world(poses), view, size)
        for number, link in enumerate(self._links):
            if link in self._picker.hidden:
                pixels[slice(*self._skin.first[number : number + 2])] = np.nan
        return pixels

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
