"""The skin on the body: coloured by touch, or wearing the map's picture; whole or in dots; on the way to flat too."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pyvista as pv

from app.arrays import FloatArray, IntArray
from app.geometry.surface_point import SurfacePoint
from app.maps.tactile_image import vertex_weights
from app.maps.tactile_map import TactileMap
from app.session.prepare import Prepared
from widgets.colours import BETWEEN_DOTS, PressureScale, rgb
from widgets.robot_view.drawn import MATTE, polydata, set_matrix
from widgets.robot_view.picture_skin import PictureSkin, between
from widgets.robot_view.taxel_rings import TaxelRings
from widgets.robot_view.viewpoint import CameraRay
from widgets.selection import INKS
from widgets.skin_picture import SkinPicture

RING_SIZE, FEW_RING_SIZE, DOT_SIZE = 0.34, 0.55, 0.4
"""Radius of the mark of a taxel, as a share of the root of its area: selected, one of few selected, and as a dot."""


class SkinActors:
    """All that is drawn of one skin. Mutable.

    Args:
        plotter: Where to draw.
        prepared: Robot, skin and map.
        scale: Colours of pressure.

    Attributes:
        riders: Link number and actor of all that moves with a link.
        share: How flat it lies: 0 on the body, 1 as on the map.
    """

    def __init__(self, plotter: Any, prepared: Prepared, scale: PressureScale) -> None:
        self._plotter, self._prepared = plotter, prepared
        self._weights = vertex_weights(prepared.map)
        self._surfaces: list[pv.PolyData] = []
        self._plain: list[Any] = []
        for patch in prepared.skin.patches:
            surface = polydata(patch.surface.vertices, patch.surface.vertex_normals, patch.surface.faces)
            surface.point_data["touch"] = scale.rgb(np.zeros(len(patch.surface.vertices)))
            self._plain.append(plotter.add_mesh(surface, scalars="touch", rgb=True, copy_mesh=False, **MATTE))
            self._surfaces.append(surface)
        self._dots = TaxelRings(plotter, prepared.skin, filled=True)
        self._rings = TaxelRings(plotter, prepared.skin)
        self._links = [prepared.robot.link_index[patch.link] for patch in prepared.skin.patches]
        kinds = (self._plain, self._dots.actors, self._rings.actors)
        self.riders: list[tuple[int, Any]] = [pair for kind in kinds for pair in zip(self._links, kind, strict=True)]
        self._every: IntArray = np.arange(len(prepared.skin))
        self.share = 0.0
        self._dotted = self._always = self._moved = False
        self._picture: SkinPicture | None = None
        self._worn: PictureSkin | None = None

    def show_map(self, map_: TactileMap) -> None:
        """Another map of the same skin; its picture comes with ``wear``, and the one of before is taken off.

        Cost: 13 ms for 1000 taxels on 20,000 vertices; nothing where patches were only moved.
        """
        old, self._prepared = self._prepared.map, replace(self._prepared, map=map_)
        if any(one is not other for one, other in zip(old.charts, map_.charts, strict=True)):
            self._weights = vertex_weights(map_)
            self.wear(None, always=self._always)
        elif self._worn is not None:
            self._worn.lay(map_)

    def select(self, taxels: IntArray, inks: tuple[str, ...]) -> None:
        """Ring these taxels (k,), each in its colour."""
        colours = (255 * np.array([rgb(ink) for ink in inks]).reshape(-1, 3)).round().astype(np.uint8)
        self._rings.show(taxels, colours, radius=RING_SIZE if len(taxels) > len(INKS) else FEW_RING_SIZE)

    def wear(self, picture: SkinPicture | None, *, always: bool) -> None:
        """Take the map's picture: shown ``always``, or only while the skin is not quite on the body."""
        self._picture, self._always = picture, always
        if self._worn is not None:
            self._worn.remove()
            self._worn = None
        self._dress()

    def _dress(self) -> None:
        wanted = self._picture is not None and (self._always or self.share > 0)
        if wanted and self._worn is None and self._picture is not None:
            self._worn = PictureSkin(self._plotter, self._prepared, self._picture)
        elif not wanted and self._worn is not None:
            self._worn.remove()
            self._worn = None
        for actor in self._plain:
            actor.visibility = not wanted

    def dot(self, *, dotted: bool) -> None:
        """Show a dot for each taxel instead of what lies between them."""
        self._dotted = dotted
        none = np.zeros((0, 3), np.uint8)
        if dotted:
            self._dots.show(self._every, np.zeros((len(self._every), 3), np.uint8), radius=DOT_SIZE)
        else:
            self._dots.show(self._every[:0], none, radius=DOT_SIZE)

    def colour(self, pressures: FloatArray, scale: PressureScale) -> None:
        """Take pressures (taxels,) [Pa]."""
        kilopascals = 1e-3 * pressures
        if self._worn is not None:
            self._worn.refresh()
        else:
            for surface, matrix in zip(self._surfaces, self._weights, strict=True):
                surface.point_data["touch"][:] = BETWEEN_DOTS if self._dotted else scale.rgb(matrix @ kilopascals)
                surface.GetPointData().GetArray("touch").Modified()
        if self._dotted:
            self._dots.colour(self._every, scale.rgb(kilopascals))

    def morph(self, share: float) -> None:
        """Lay the skin flat by this share, from 0 to 1; ``move`` and ``colour`` show it."""
        self.share = share
        self._dress()

    def move(self, poses: FloatArray, plane: FloatArray) -> None:
        """Put the skin where it belongs.

        Args:
            poses: (links, 4, 4) ``T_world_link``.
            plane: (4, 4) ``T_world_map``, where it lies when it is flat.
        """
        for link, actor in self.riders:
            set_matrix(actor, poses[link] if self.share == 0 else np.eye(4))
        if self._worn is not None:
            self._worn.place(poses, self.share, plane)
        if self.share > 0:
            places = [self._taxels_at(number, poses, plane) for number in range(len(self._prepared.skin.patches))]
            for rings in (self._dots, self._rings):
                rings.place([at for at, _ in places], [normals for _, normals in places])
            self._moved = True
        elif self._moved:
            felt = [patch.taxels for patch in self._prepared.skin.patches]
            for rings in (self._dots, self._rings):
                rings.place([part.positions for part in felt], [part.normals for part in felt])
            self._moved = False

    def pick(self, ray: CameraRay) -> SurfacePoint | None:
        """The place of the skin that a ray (world frame) meets first, while it is off the body; None beside it."""
        return None if self._worn is None else self._worn.pick(ray)

    def taxels(self, poses: FloatArray, plane: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Positions [m] and unit normals, (taxels, 3) each, of the skin as it lies now, world frame."""
        places = [self._taxels_at(number, poses, plane) for number in range(len(self._prepared.skin.patches))]
        return np.concatenate([at for at, _ in places]), np.concatenate([normals for _, normals in places])

    def point(self, at: SurfacePoint, poses: FloatArray, plane: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Position (3,) [m] and unit normal (3,) of a place on the skin as it lies now, world frame."""
        skin = self._prepared.skin
        flat = self._prepared.map.to_map(at)
        position, normal = skin.position(at)[None], skin.normal(at)[None]
        where, normals = between(position, normal, flat[None], poses[self._links[at.patch]], plane, self.share)
        return where[0], normals[0]

    def _taxels_at(self, number: int, poses: FloatArray, plane: FloatArray) -> tuple[FloatArray, FloatArray]:
        skin = self._prepared.skin
        felt, own = skin.patches[number].taxels, slice(*skin.first[number : number + 2])
        flat = self._prepared.map.taxel_points[own]
        return between(felt.positions, felt.normals, flat, poses[self._links[number]], plane, self.share)
