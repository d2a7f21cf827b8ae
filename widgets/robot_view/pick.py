"""The skin under a pixel: a ray cast in each link's own frame, so nothing is rebuilt when the arm moves."""

from __future__ import annotations

import numpy as np

from app.arrays import FloatArray
from app.geometry.raycast import RayCaster
from app.geometry.surface_point import SurfacePoint
from app.session.prepare import Prepared
from widgets.robot_view.viewpoint import CameraRay


class SkinPicker:
    """Finds skin along rays; bare links and objects in front hide it. Built once for a scene.

    Poses are those of the robot's links and then those of the scene's objects.

    Cost: about 35 µs a link or object.
    """

    def __init__(self, prepared: Prepared) -> None:
        index = prepared.robot.link_index
        self._skin = [(index[patch.link], RayCaster(patch.surface)) for patch in prepared.skin.patches]
        self._bare = [
            (index[link.name], RayCaster(link.mesh))
            for link in prepared.robot.links
            if link.mesh is not None and len(link.mesh.faces)
        ]
        first = len(prepared.robot.links)
        self._bare += [(first + k, RayCaster(body.mesh)) for k, body in enumerate(prepared.objects)]

    def pick(self, ray: CameraRay, poses: FloatArray) -> SurfacePoint | None:
        """The nearest skin along the ray, or None where there is none or a bare link is in front.

        Args:
            ray: World frame.
            poses: (links + objects, 4, 4) in the world.
        """
        best, found = np.inf, None
        for number, (link, caster) in enumerate(self._skin):
            hit = caster.first_hit(*_local(ray, poses[link]))
            if hit is not None and hit.distance < best:
                best, found = hit.distance, SurfacePoint(number, hit.face, hit.weights)
        for link, caster in self._bare:
            hit = caster.first_hit(*_local(ray, poses[link]))
            if hit is not None and hit.distance < best:
                return None
        return found

    def distance(self, ray: CameraRay, poses: FloatArray) -> float:
        """How far along the ray [m] it first meets anything; infinite where it meets nothing."""
        hits = (caster.first_hit(*_local(ray, poses[link])) for link, caster in (*self._skin, *self._bare))
        return min((hit.distance for hit in hits if hit is not None), default=np.inf)


def _local(ray: CameraRay, pose: FloatArray) -> tuple[FloatArray, FloatArray]:
    rotation = pose[:3, :3]
    return rotation.T @ (ray.origin - pose[:3, 3]), rotation.T @ ray.direction
