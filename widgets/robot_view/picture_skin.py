"""The skin wearing the map's own picture: the same pixels on the body as on the map, and all places in between.

``share`` runs from 0, on the body, to 1, where every patch lies flat in a plane of the world; on the way each point
goes straight from the one to the other. The touch is in the picture, so it goes with it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pyvista as pv

from app.arrays import FloatArray, IntArray
from app.geometry.surface_point import SurfacePoint
from app.maps.tactile_map import TactileMap
from app.session.prepare import Prepared
from widgets.robot_view.drawn import MATTE, polydata
from widgets.robot_view.viewpoint import CameraRay
from widgets.skin_picture import SkinPicture


class PictureSkin:
    """One textured actor a patch, cut along its seams as the chart is. Mutable: ``refresh`` and ``place``.

    Args:
        plotter: Where to draw.
        prepared: Robot, skin and map.
        picture: Of the charts of that map, wherever they lie in the picture.
    """

    def __init__(self, plotter: Any, prepared: Prepared, picture: SkinPicture) -> None:
        self._plotter, self._picture, self._flat = plotter, picture, prepared.map.uv
        self._faces = [chart.faces for chart in prepared.map.charts]
        self._links = [prepared.robot.link_index[patch.link] for patch in prepared.skin.patches]
        height, width = picture.pixels.shape
        self._image = pv.ImageData(dimensions=(width, height, 1))
        self._image.point_data["picture"] = np.zeros((height * width, 3), np.uint8)
        self._texture = pv.Texture(self._image)
        self._texture.interpolate = True
        self._rest = [(p.surface.vertices[c.vertex_of], p.surface.vertex_normals[c.vertex_of])
                      for p, c in zip(prepared.skin.patches, prepared.map.charts, strict=True)]  # fmt: skip
        self._meshes = [
            polydata(points, normals, chart.faces)
            for (points, normals), chart in zip(self._rest, prepared.map.charts, strict=True)
        ]
        self.actors = [self._actor(mesh, places) for mesh, places in zip(self._meshes, picture.places, strict=True)]

    def _actor(self, mesh: pv.PolyData, places: FloatArray) -> Any:
        low, high = self._picture.extent
        mesh.active_texture_coordinates = ((places - low) / (high - low)).astype(np.float32)
        return self._plotter.add_mesh(mesh, texture=self._texture, copy_mesh=False, **MATTE)

    def lay(self, map_: TactileMap) -> None:
        """Take another arrangement of the same charts; ``place`` shows it."""
        self._flat = map_.uv

    def refresh(self) -> None:
        """Take the picture's pixels as they are now. Cost: 0.6 ms for 512² pixels."""
        height, width = self._picture.pixels.shape
        blue_first = self._picture.pixels.view(np.uint8).reshape(height, width, 4)
        pixels = self._image.point_data["picture"].reshape(height, width, 3)
        pixels[:] = blue_first[::-1, :, 2::-1]  # the texture's first row is the lowest
        self._image.GetPointData().GetArray("picture").Modified()
        self._image.Modified()

    def place(self, poses: FloatArray, share: float, plane: FloatArray) -> None:
        """Put the skin on its links, flat, or in between.

        Args:
            poses: (links, 4, 4) ``T_world_link``.
            share: From 0 to 1.
            plane: (4, 4) ``T_world_map``; the map lies in its first two axes.
        """
        for number, mesh in enumerate(self._meshes):
            points, normals = self._rest[number]
            places = self._flat[number]
            mesh.points[:], mesh.point_data["Normals"][:] = between(
                points, normals, places, poses[self._links[number]], plane, share
            )
            mesh.GetPoints().Modified()
            mesh.GetPointData().GetNormals().Modified()
            mesh.Modified()

    def pick(self, ray: CameraRay) -> SurfacePoint | None:
        """The place of the skin that a ray meets first, as it lies now; None beside it. Cost: 7 ms for 20,000 faces."""
        best, found = np.inf, None
        for number, (mesh, faces) in enumerate(zip(self._meshes, self._faces, strict=True)):
            away, face, weights = first_met(np.asarray(mesh.points, float), faces, ray)
            if away < best:
                best, found = away, SurfacePoint(number, face, weights)
        return found

    def remove(self) -> None:
        """Take the actors off the plotter."""
        for actor in self.actors:
            self._plotter.remove_actor(actor, render=False)


def between(
    points: FloatArray, normals: FloatArray, places: FloatArray, pose: FloatArray, plane: FloatArray, share: float
) -> tuple[FloatArray, FloatArray]:
    """Where places of the skin are on their straight way from the body to the flat map, and their normals.

    Args:
        points: (k, 3) on the body [m], link frame.
        normals: (k, 3) unit, likewise.
        places: (k, 2) on the map [m].
        pose: (4, 4) ``T_world_link``.
        plane: (4, 4) ``T_world_map``.
        share: 0 on the body, 1 on the map.

    Returns:
        Positions (k, 3) [m] and unit normals (k, 3), world frame.
    """
    flat = places @ plane[:3, :2].T + plane[:3, 3]
    here = points @ pose[:3, :3].T + pose[:3, 3]
    turned = (1 - share) * (normals @ pose[:3, :3].T) + share * plane[:3, 2]
    length = np.linalg.norm(turned, axis=1, keepdims=True)
    return here + share * (flat - here), turned / np.maximum(length, 1e-9)


def first_met(points: FloatArray, faces: IntArray, ray: CameraRay) -> tuple[float, int, tuple[float, float, float]]:
    """Which triangle a ray meets first, from either side (Möller and Trumbore 1997).

    Args:
        points: (k, 3) [m], in the frame of the ray.
        faces: (t, 3).
        ray: From where, and whither.

    Returns:
        How far along the ray [m], infinite where it meets none; the face; the barycentric weights there.
    """
    corner, second, third = (points[faces[:, k]] for k in range(3))
    along, across = second - corner, third - corner
    normal = np.cross(ray.direction, across)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = 1 / np.einsum("tk,tk->t", along, normal)
        towards = ray.origin - corner
        u = share * np.einsum("tk,tk->t", towards, normal)
        aside = np.cross(towards, along)
        v = share * (aside @ ray.direction)
        away = share * np.einsum("tk,tk->t", across, aside)
        met = (u >= 0) & (v >= 0) & (u + v <= 1) & (away > 0)
    away = np.where(met, away, np.inf)
    face = int(away.argmin())
    if not np.isfinite(away[face]):
        return np.inf, face, (1.0, 0.0, 0.0)
    return float(away[face]), face, (float(1 - u[face] - v[face]), float(u[face]), float(v[face]))
