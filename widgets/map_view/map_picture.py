"""One tactile map ready to be drawn: built once per map, then refreshed in place by each frame."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QLineF, QPointF, QRectF
from PySide6.QtGui import QFont
from PySide6.QtWidgets import QGraphicsScene

from app.arrays import FloatArray, IntArray
from app.contacts.reader import THRESHOLD
from app.geometry.surface_point import SurfacePoint
from app.maps.overlay import flaws
from app.maps.tactile_image import TactileImage
from app.maps.tactile_map import TactileMap
from app.session.frame import Frame
from widgets.colours import BETWEEN_DOTS, PressureScale, Theme, words32
from widgets.map_view.contour import contour_segments
from widgets.map_view.flaws_item import FlawsItem
from widgets.map_view.ground import GroundPicture, paint_ground
from widgets.map_view.live_image import LiveImage
from widgets.map_view.map_items import PatchesItem, lines
from widgets.map_view.map_legend import Legend, legend_of
from widgets.map_view.map_shapes import MapShapes
from widgets.map_view.taxels_item import TaxelsItem
from widgets.overlays import Ground, Overlays
from widgets.skin_picture import SkinPicture

TOUCHED_KPA = THRESHOLD / 1e3
"""Where the line around a touched area runs [kPa]; the pressure from which the contact reader calls a taxel touched."""


IMAGE_PIXELS = 512
"""Side of a square with as many pixels as the live image."""


class MapPicture:
    """The items of one map in a graphics scene. Mutable: ``show`` refreshes it.

    Args:
        tactile_map: What to draw.
        theme: Colours of borders and seams.
        image: Its tactile image, where one exists already; building one takes some tenths of a second.
    """

    def __init__(self, tactile_map: TactileMap, theme: Theme, *, image: TactileImage | None = None) -> None:
        self.map = tactile_map
        self.shapes = MapShapes.of(tactile_map)
        self.pressures: FloatArray | None = None
        self._image = image or build_image(tactile_map)
        self._live = LiveImage(self._image.shown)
        low, high = self.shapes.frame.to_scene(np.asarray(self._image.extent))
        self._place = QRectF(low[0], high[1], high[0] - low[0], low[1] - high[1])
        self._patches = PatchesItem(self.shapes, self._live, self._place, theme)
        self._taxels = TaxelsItem(self.shapes, QFont())
        self._flaws = flaws(tactile_map)
        self._flawed = FlawsItem(self._flaws, self.shapes.frame, theme)
        self._grounds: dict[Ground, GroundPicture | None] = {}
        self._overlays = Overlays()
        self._kilopascals = np.zeros(self._image.shape, np.float32)

    def add_to(self, scene: QGraphicsScene) -> None:
        """Put the items into ``scene``, which owns them from then on."""
        scene.addItem(self._patches)
        scene.addItem(self._flawed)
        scene.addItem(self._taxels)

    def overlay(self, overlays: Overlays, scale: PressureScale) -> None:
        """Show what the setting asks for. Cost: 20 to 80 ms for a ground that has not been shown before."""
        self._overlays = overlays
        self._patches.line(border=overlays.border, seams=overlays.seams)
        self._taxels.dots, self._taxels.numbered = overlays.dots, overlays.taxel_ids
        ground = self.ground
        bare = np.full(self._image.shape, words32(np.array(BETWEEN_DOTS, np.uint8))) if overlays.dots else None
        self._live.ground = bare if ground is None else ground.pixels
        self._live.touch_from = np.inf if overlays.dots else TOUCHED_KPA
        self.recolour(scale)

    @property
    def ground(self) -> GroundPicture | None:
        """What lies under the touch; None for the plain scale."""
        kind = self._overlays.ground
        if kind not in self._grounds:
            self._grounds[kind] = paint_ground(kind, self.map, self._image)
        return self._grounds[kind]

    @property
    def legend(self) -> Legend | None:
        """What the overlay's colours mean; None where there is nothing to say."""
        return legend_of(self.ground, self._flaws)

    @property
    def skin_picture(self) -> SkinPicture:
        """The pixels as drawn here, for another view."""
        return SkinPicture(self._live.pixels, self._image.extent, self.map.uv)

    def show(self, frame: Frame, scale: PressureScale) -> None:
        """Colour image and taxels by the frame's pressures. Cost: about 3 ms for 512² pixels."""
        self.pressures = frame.pressures
        self._kilopascals = self._image.render(frame.pressures)
        self.recolour(scale)

    def recolour(self, scale: PressureScale) -> None:
        """Show the same pressures on another scale."""
        self._live.fill(self._kilopascals, scale)
        pressures = np.zeros(len(self.shapes.taxels)) if self.pressures is None else self.pressures
        self._taxels.colour(pressures / 1e3, scale)

    def select(self, taxels: IntArray, inks: tuple[str, ...]) -> None:
        """Ring these taxels (k,), each in its colour."""
        self._taxels.select(taxels, inks)

    def set_theme(self, theme: Theme) -> None:
        """Take the theme's line colours."""
        self._patches.set_theme(theme)

    def place_of(self, at: SurfacePoint) -> QPointF:
        """Where a body point lies in the scene."""
        x, y = self.shapes.frame.to_scene(self.map.to_map(at))
        return QPointF(x, y)

    def contours(self) -> list[QLineF]:
        """Lines around the touched areas [scene units]; none while they are not wanted."""
        if not self._overlays.contours:
            return []
        segments = contour_segments(self._kilopascals, TOUCHED_KPA)
        height, width = self._image.shape
        pixel = np.array([self._place.width() / width, self._place.height() / height])
        return lines((segments + 0.5) * pixel + [self._place.x(), self._place.y()])


def build_image(tactile_map: TactileMap) -> TactileImage:
    """The image as the view wants it: about ``IMAGE_PIXELS`` squared, however tall or wide the map. Cost: 0.2 s."""
    width, height = np.ptp(tactile_map.bounds, axis=0)
    return TactileImage(tactile_map, resolution=float(np.sqrt(width * height)) / IMAGE_PIXELS)
