"""Actors of the skin: coloured by touch, bare, or textured with the map's image; on the body, flat, or in between.

``TexturedSkin`` has the pixels of the map. Its ``share`` is 0 on the body and 1 when every patch is flat in a plane of
the world. Each point first moves off the body along its normal, so that nothing sinks into the link, then straight to
its place on the map.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pyvista as pv
from scipy.sparse import csr_matrix

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.core.caches import weak_cache
from tactile_maps.geometry.surface.mesh import Mesh, SurfacePoint
from tactile_maps.maps.model.tactile_image import vertex_weights
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.session.prepare import PreparedScene
from tactile_widgets.common.colours import BETWEEN_DOTS, PressureScale, rgb
from tactile_widgets.document.taxel_selection import TAXEL_COLOURS
from tactile_widgets.views.overlays.body_overlays import SkinTexture
from tactile_widgets.views.robot.actors.camera import CameraRay
from tactile_widgets.views.robot.actors.surface_marks import TaxelMarkers, add_surface, polydata, set_matrix

PEELED = 0.1
"""Share at which the skin has left the body and begins to be flattened."""
_PEEL = 0.08
"""Distance from the body at that share, as a fraction of the patch's size."""


def peel_height(surface: Mesh) -> float:
    """Return the distance from its body at which a patch begins to be flattened [m]."""
    return _PEEL * float(np.linalg.norm(np.ptp(surface.vertices, axis=0)))


class TexturedSkin:
    """Textured actors, one for each patch, cut along its seams like the chart.

    Args:
        plotter: Plotter that draws them.
        prepared: Robot, skin and map.
        picture: Image of that map's charts.
    """

    def __init__(self, plotter: Any, prepared: PreparedScene, picture: SkinTexture) -> None:
        self._plotter = plotter
        self._picture = picture
        self._flat = prepared.map.uv
        self._faces = [chart.faces for chart in prepared.map.charts]
        self._links = [prepared.robot.link_index[patch.link] for patch in prepared.skin.patches]
        self._heights = [peel_height(patch.surface) for patch in prepared.skin.patches]
        height, width = picture.pixels.shape
        self._image = pv.ImageData(dimensions=(width, height, 1))
        self._image.point_data["picture"] = np.zeros((height * width, 3), np.uint8)
        self._texture = pv.Texture(self._image)
        self._texture.interpolate = True
        self._body_surfaces = [
            (p.surface.vertices[c.vertex_of], p.surface.vertex_normals[c.vertex_of])
            for p, c in zip(prepared.skin.patches, prepared.map.charts, strict=True)
        ]
        self._meshes = [
            polydata(points, normals, chart.faces)
            for (points, normals), chart in zip(self._body_surfaces, prepared.map.charts, strict=True)
        ]
        self.actors = [self._actor(mesh, places) for mesh, places in zip(self._meshes, picture.places, strict=True)]

    def _actor(self, mesh: pv.PolyData, places: FloatArray) -> Any:
        low, high = self._picture.extent
        mesh.active_texture_coordinates = ((places - low) / (high - low)).astype(np.float32)
        return add_surface(self._plotter, mesh, texture=self._texture)

    def lay(self, map_: TactileMap) -> None:
        """Use another arrangement of the same charts from the next ``place`` on."""
        self._flat = map_.uv

    def refresh(self) -> None:
        """Copy the current pixels of the image. Cost: 0.6 ms for 512² pixels."""
        height, width = self._picture.pixels.shape
        blue_first = self._picture.pixels.view(np.uint8).reshape(height, width, 4)
        pixels = self._image.point_data["picture"].reshape(height, width, 3)
        pixels[:] = blue_first[::-1, :, 2::-1]  # the texture's first row is the lowest
        self._image.GetPointData().GetArray("picture").Modified()
        self._image.Modified()

    def place(self, poses: FloatArray, share: float, plane: FloatArray) -> None:
        """Move the skin to its links, to the plane, or in between.

        Args:
            poses: (links, 4, 4) ``T_world_link``.
            share: Flatness, from 0 to 1.
            plane: (4, 4) ``T_world_map``; the map is in its first two axes.
        """
        for number, mesh in enumerate(self._meshes):
            points, normals = self._body_surfaces[number]
            places = self._flat[number]
            mesh.points[:], mesh.point_data["Normals"][:] = morphed(
                points, normals, places, poses[self._links[number]], plane, share, self._heights[number]
            )
            mesh.GetPoints().Modified()
            mesh.GetPointData().GetNormals().Modified()
            mesh.Modified()

    def pick(self, ray: CameraRay) -> SurfacePoint | None:
        """Return the first skin location along a ray; None without one. Cost: 7 ms for 20,000 faces."""
        best = np.inf
        found = None
        for number, (mesh, faces) in enumerate(zip(self._meshes, self._faces, strict=True)):
            away, face, weights = ray_mesh_intersection(np.asarray(mesh.points, float), faces, ray)
            if away < best:
                best = away
                found = SurfacePoint(number, face, weights)
        return found

    def remove(self) -> None:
        """Remove the actors from the plotter."""
        for actor in self.actors:
            self._plotter.remove_actor(actor, render=False)


def morphed(
    points: FloatArray,
    normals: FloatArray,
    places: FloatArray,
    pose: FloatArray,
    plane: FloatArray,
    share: float,
    height: float,
) -> tuple[FloatArray, FloatArray]:
    """Return positions and normals of skin points between body and flat map: outwards first, then straight.

    Args:
        points: (k, 3) on the body [m], link frame.
        normals: (k, 3) unit normals on the body, link frame.
        places: (k, 2) on the map [m].
        pose: (4, 4) ``T_world_link``.
        plane: (4, 4) ``T_world_map``.
        share: 0 on the body, 1 on the map.
        height: Distance from the body at which they begin to be flattened [m].

    Returns:
        Positions (k, 3) [m] and unit normals (k, 3), world frame.
    """
    flat = places @ plane[:3, :2].T + plane[:3, 3]
    outward = normals @ pose[:3, :3].T
    way = max(share - PEELED, 0.0) / (1 - PEELED)
    here = points @ pose[:3, :3].T + pose[:3, 3] + min(share / PEELED, 1.0) * height * outward
    turned = (1 - way) * outward + way * plane[:3, 2]
    length = np.linalg.norm(turned, axis=1, keepdims=True)
    return here + way * (flat - here), turned / np.maximum(length, 1e-9)


def ray_mesh_intersection(
    points: FloatArray, faces: IntArray, ray: CameraRay
) -> tuple[float, int, tuple[float, float, float]]:
    """Find the first triangle along a ray, from either side (Möller and Trumbore 1997).

    Args:
        points: (k, 3) [m], in the frame of the ray.
        faces: (t, 3).
        ray: The ray.

    Returns:
        Distance along the ray [m], infinite without an intersection; face; barycentric weights of the point.
    """
    corner, second, third = (points[faces[:, k]] for k in range(3))
    along = second - corner
    across = third - corner
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


RING_SIZE = 0.34
FEW_RING_SIZE = 0.55
"""Radius of a selected taxel's ring as a fraction of the square root of its area: one of many, and one of few."""


@weak_cache
def _weights_of(map_: TactileMap) -> list[csr_matrix]:
    """Weights of the taxels at each patch's vertices; shared by views, and kept when a scene starts again."""
    return vertex_weights(map_)


class SkinActors:
    """Actors of one skin.

    Args:
        plotter: Plotter that draws them.
        prepared: Robot, skin and map.
        scale: Colours of pressure.

    Attributes:
        link_actors: Link number and actor of everything that moves with a link.
        share: Flatness: 0 on the body, 1 as on the map.
        bare: Whether touch is left out of the colours because a layer shows it.
    """

    def __init__(self, plotter: Any, prepared: PreparedScene, scale: PressureScale) -> None:
        self._plotter = plotter
        self._prepared = prepared
        self._use_weights(_weights_of(prepared.map))
        self._surfaces: list[pv.PolyData] = []
        self._plain: list[Any] = []
        for patch in prepared.skin.patches:
            surface = polydata(patch.surface.vertices, patch.surface.vertex_normals, patch.surface.faces)
            surface.point_data["touch"] = scale.rgb(np.zeros(len(patch.surface.vertices)))
            surface.set_active_scalars("touch")
            actor = add_surface(plotter, surface)
            actor.prop.culling = "back"  # on the body its inside is never visible
            self._plain.append(actor)
            self._surfaces.append(surface)
        self._links = [prepared.robot.link_index[patch.link] for patch in prepared.skin.patches]
        self.link_actors: list[tuple[int, Any]] = list(zip(self._links, self._plain, strict=True))
        self._carried: list[TaxelMarkers] = []
        self._rings = TaxelMarkers(plotter, prepared.skin)
        self.carry(self._rings)
        self.share = 0.0
        self.bare = False
        self._always = self._moved = False
        self._picture: SkinTexture | None = None
        self._textured: TexturedSkin | None = None

    def _use_weights(self, weights: list[csr_matrix]) -> None:
        """Colour vertices by these weights from now on; no patch counts as coloured."""
        self._weights = weights
        self._taxels = [np.unique(matrix.indices) for matrix in weights]
        self._coloured: list[tuple[PressureScale, bool, FloatArray] | None] = [None] * len(weights)

    def carry(self, markers: TaxelMarkers) -> None:
        """Move these markers with the skin from now on."""
        self._carried.append(markers)
        self.link_actors += zip(self._links, markers.actors, strict=True)

    def show_map(self, map_: TactileMap) -> None:
        """Use another map of the same skin; a new chart removes the image until ``set_texture`` sets another one.

        Cost: 13 ms for 1000 taxels on 20,000 vertices; none if patches were only moved.
        """
        old = self._prepared.map
        self._prepared = replace(self._prepared, map=map_)
        if any(one is not other for one, other in zip(old.charts, map_.charts, strict=True)):
            self._use_weights(_weights_of(map_))
            self.set_texture(None, always=self._always)
        elif self._textured is not None:
            self._textured.lay(map_)

    @property
    def textured_actors(self) -> list[tuple[int, Any]]:
        """Link number and actor of each textured patch; empty while the image is not shown."""
        return [] if self._textured is None else list(zip(self._links, self._textured.actors, strict=True))

    def select(self, taxels: IntArray, inks: tuple[str, ...]) -> None:
        """Draw a ring around each of these taxels (k,) in its colour."""
        colours = (255 * np.array([rgb(ink) for ink in inks]).reshape(-1, 3)).round().astype(np.uint8)
        self._rings.show(taxels, colours, radius=RING_SIZE if len(taxels) > len(TAXEL_COLOURS) else FEW_RING_SIZE)

    def set_texture(self, picture: SkinTexture | None, *, always: bool) -> None:
        """Set the map's image: shown ``always``, or only while the skin is off the body."""
        self._picture = picture
        self._always = always
        if self._textured is not None:
            self._textured.remove()
            self._textured = None
        self._update_texture()

    def _update_texture(self) -> None:
        textured = self._picture is not None and (self._always or self.share > 0)
        if textured and self._textured is None and self._picture is not None:
            self._textured = TexturedSkin(self._plotter, self._prepared, self._picture)
        elif not textured and self._textured is not None:
            self._textured.remove()
            self._textured = None
        for actor in self._plain:
            actor.visibility = not textured

    def colour(self, pressures: FloatArray, scale: PressureScale) -> None:
        """Set the colours of pressures (taxels,) [Pa]."""
        kilopascals = 1e-3 * pressures
        if self._textured is not None:
            self._textured.refresh()
        else:
            for number, (surface, matrix) in enumerate(zip(self._surfaces, self._weights, strict=True)):
                felt = kilopascals[self._taxels[number]]
                before = self._coloured[number]
                if before is not None and before[:2] == (scale, self.bare) and np.array_equal(before[2], felt):
                    continue  # most patches are untouched most of the time
                self._coloured[number] = scale, self.bare, felt
                shown = surface.point_data["touch"]
                colours = np.broadcast_to(BETWEEN_DOTS, shown.shape) if self.bare else scale.rgb(matrix @ kilopascals)
                if not np.array_equal(shown, colours):  # VTK would send all of a patch again
                    shown[:] = colours
                    surface.GetPointData().GetArray("touch").Modified()

    def morph(self, share: float) -> None:
        """Flatten the skin by this share, from 0 to 1; ``move`` and ``colour`` show it."""
        self.share = share
        self._update_texture()

    def move(self, poses: FloatArray, plane: FloatArray) -> None:
        """Move the skin.

        Args:
            poses: (links, 4, 4) ``T_world_link``.
            plane: (4, 4) ``T_world_map`` of the flat skin.
        """
        for link, actor in self.link_actors:
            set_matrix(actor, poses[link] if self.share == 0 else np.eye(4))
        if self._textured is not None:
            self._textured.place(poses, self.share, plane)
        if self.share > 0:
            places = [self._taxels_at(number, poses, plane) for number in range(len(self._prepared.skin.patches))]
            for markers in self._carried:
                markers.place([at for at, _ in places], [normals for _, normals in places])
            self._moved = True
        elif self._moved:
            felt = [patch.taxels for patch in self._prepared.skin.patches]
            for markers in self._carried:
                markers.place([part.positions for part in felt], [part.normals for part in felt])
            self._moved = False

    def pick(self, ray: CameraRay) -> SurfacePoint | None:
        """Return the first skin location along a ray (world frame) while the skin is off the body; None without one."""
        return None if self._textured is None else self._textured.pick(ray)

    def taxels(self, poses: FloatArray, plane: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return current positions [m] and unit normals, (taxels, 3) each, world frame."""
        places = [self._taxels_at(number, poses, plane) for number in range(len(self._prepared.skin.patches))]
        return np.concatenate([at for at, _ in places]), np.concatenate([normals for _, normals in places])

    def point(self, at: SurfacePoint, poses: FloatArray, plane: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return current position (3,) [m] and unit normal (3,) of a skin location, world frame."""
        skin = self._prepared.skin
        flat = self._prepared.map.to_map(at)
        position = skin.position(at)[None]
        normal = skin.normal(at)[None]
        height = peel_height(skin.patches[at.patch].surface)
        pose = poses[self._links[at.patch]]
        where, normals = morphed(position, normal, flat[None], pose, plane, self.share, height)
        return where[0], normals[0]

    def _taxels_at(self, number: int, poses: FloatArray, plane: FloatArray) -> tuple[FloatArray, FloatArray]:
        skin = self._prepared.skin
        felt = skin.patches[number].taxels
        own = slice(*skin.first[number : number + 2])
        flat = self._prepared.map.taxel_points[own]
        height = peel_height(skin.patches[number].surface)
        return morphed(felt.positions, felt.normals, flat, poses[self._links[number]], plane, self.share, height)
