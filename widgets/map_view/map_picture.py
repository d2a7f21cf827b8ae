"""One tactile map ready to be drawn: built once per map, then refreshed in place by each frame."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QLineF, QPointF, QRectF
from PySide6.QtWidgets import QGraphicsScene

from app.arrays import FloatArray
from app.contacts.reader import THRESHOLD
from app.geometry.surface_point import SurfacePoint
from app.maps.tactile_image import TactileImage
from app.maps.tactile_map import TactileMap
from app.session.frame import Frame
from widgets.colours import PressureScale, Theme
from widgets.map_view.contour import contour_segments
from widgets.map_view.live_image import LiveImage
from widgets.map_view.map_items import PatchesItem, TaxelsItem, lines
from widgets.map_view.map_shapes import MapShapes

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
        self._taxels = TaxelsItem(self.shapes)
        self._kilopascals = np.zeros(self._image.shape, np.float32)

    def add_to(self, scene: QGraphicsScene) -> None:
        """Put the items into ``scene``, which owns them from then on."""
        scene.addItem(self._patches)
        scene.addItem(self._taxels)

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

    def set_theme(self, theme: Theme) -> None:
        """Take the theme's line colours."""
        self._patches.set_theme(theme)

    def place_of(self, at: SurfacePoint) -> QPointF:
        """Where a body point lies in the scene."""
        x, y = self.shapes.frame.to_scene(self.map.to_map(at))
        return QPointF(x, y)

    def contours(self) -> list[QLineF]:
        """Lines around the touched areas [scene units]."""
        segments = contour_segments(self._kilopascals, TOUCHED_KPA)
        height, width = self._image.shape
        pixel = np.array([self._place.width() / width, self._place.height() / height])
        return lines((segments + 0.5) * pixel + [self._place.x(), self._place.y()])


def build_image(tactile_map: TactileMap) -> TactileImage:
    """The image as the view wants it: about ``IMAGE_PIXELS`` squared, however tall or wide the map. Cost: 0.2 s."""
    width, height = np.ptp(tactile_map.bounds, axis=0)
    return TactileImage(tactile_map, resolution=float(np.sqrt(width * height)) / IMAGE_PIXELS)
