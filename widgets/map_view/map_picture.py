"""One document ready to be drawn: built once per skin, rebuilt where a chart changed, refreshed in place by frames."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from PySide6.QtCore import QLineF, QPointF
from PySide6.QtGui import QFont
from PySide6.QtWidgets import QGraphicsScene

from app.arrays import FloatArray, IntArray
from app.contacts.reader import THRESHOLD
from app.contacts.region import ContactRegion
from app.editing.document import MapDocument
from app.editing.pins import pin_places
from app.geometry.surface_point import SurfacePoint
from app.maps.overlay import Flaws
from app.maps.tactile_map import TactileMap
from app.session.frame import Frame
from widgets.colours import BETWEEN_DOTS, PressureScale, Theme, words32
from widgets.map_view.atlas import Atlas, ImageLook
from widgets.map_view.contact_shape import ellipses_on_map
from widgets.map_view.contour import contour_segments
from widgets.map_view.fault_keys import Keys, keys_of
from widgets.map_view.faults_item import FaultsItem
from widgets.map_view.flaws_item import FlawsItem
from widgets.map_view.ground import GroundPicture, paint_ground
from widgets.map_view.live_flaws import LiveFlaws
from widgets.map_view.live_image import LiveImage
from widgets.map_view.map_hit import MapFrame, Seen
from widgets.map_view.map_items import PatchItem, lines
from widgets.map_view.map_legend import Legend, legend_of
from widgets.map_view.map_shapes import MapShapes, Net, net
from widgets.map_view.taxel_faults import NO_FAULTS, TaxelFaults
from widgets.map_view.taxels_item import TaxelsItem
from widgets.overlays import Ground, Overlays
from widgets.skin_picture import SkinPicture

TOUCHED_KPA = THRESHOLD / 1e3
"""Where the line around a touched area runs [kPa]; the pressure from which the contact reader calls a taxel touched."""
NET_LINES = 3000
"""Most lines by which a chart in the hand is drawn."""


class MapPicture:
    """The items of one skin's map in a graphics scene. Mutable: ``take`` another document, ``show`` a frame.

    Args:
        document: What to draw.
        theme: Colours of borders and seams.
        atlas: Its live image, where one exists already; building one takes some tenths of a second.

    Attributes:
        document: What is drawn.
        shapes: Where all of it lies; the frame stays the same for all documents.
        skin_picture: The pixels as drawn here, for another view; another one after each ``take`` that says so.
        fault_keys: What marks single taxels mean, now.
        held: Patches whose chart has no image yet, because it is in the hand.
    """

    def __init__(self, document: MapDocument, theme: Theme, *, atlas: Atlas | None = None) -> None:
        self.document, self.pressures = document, np.zeros(len(document.skin))
        self.shapes = MapShapes.of(document, MapFrame.around(document.map.bounds))
        self.held: tuple[int, ...] = ()
        self._nets: dict[int, Net] = {}
        self._patches = [PatchItem(theme) for _ in document.charts]
        self._taxels, self._flawed, self._finder = TaxelsItem(QFont()), FlawsItem(theme), LiveFlaws()
        self._faulty, self._faults = FaultsItem(), NO_FAULTS
        self.fault_keys: Keys = ()
        self._overlays, self._scale = Overlays(), PressureScale()
        self._wear(atlas or Atlas(document.map))
        self._place()

    def add_to(self, scene: QGraphicsScene) -> None:
        """Put the items into ``scene``, which owns them from then on."""
        for item in (*self._patches, self._flawed, self._taxels, self._faulty):
            scene.addItem(item)

    @property
    def map(self) -> TactileMap:
        """The map that is drawn."""
        return self.document.map

    def take(self, document: MapDocument, *, in_hand: bool) -> bool:
        """Draw another document of the same skin. Whether the live image is another one now.

        Args:
            document: What to draw.
            in_hand: More will follow at once: charts without an image are drawn as nets, and grounds wait.

        Cost: 2 ms where only patches were moved; that of the tiles of new charts, once nothing is in the hand.
        """
        self.document = document
        self.shapes = MapShapes.of(document, self.shapes.frame, known=self.shapes)
        pairs = enumerate(zip(self._atlas.charts, document.charts, strict=True))
        new = tuple(number for number, (old, chart) in pairs if old is not chart)
        rebuilt = bool(new) and not in_hand
        if rebuilt:
            self._wear(Atlas(document.map, known=self._atlas, look=self._atlas.look))
        elif in_hand or self.held:
            self._hold(new)
        self._place()
        if rebuilt or (not in_hand and self._grounds_of != _scales(document)):
            self._grounds.clear()
            self.overlay(self._overlays, self._scale)
        return rebuilt

    def make_image(self, look: ImageLook) -> None:
        """Make the live image otherwise. Cost: as ``Atlas``; other interpolations than the usual take up to 1 s."""
        self._wear(Atlas(self.document.map, look=look))
        self._grounds.clear()
        self._place()
        self.overlay(self._overlays, self._scale)

    def overlay(self, overlays: Overlays, scale: PressureScale) -> None:
        """Show what the setting asks for. Cost: 20 to 80 ms for a ground that has not been shown before."""
        self._overlays = overlays
        for item in self._patches:
            item.line(border=overlays.border, seams=overlays.seams)
        self._taxels.dots, self._taxels.numbered = overlays.dots, overlays.taxel_ids
        ground = self.ground
        bare = np.full(self._atlas.shape, words32(np.array(BETWEEN_DOTS, np.uint8))) if overlays.dots else None
        self._live.ground = bare if ground is None else ground.pixels
        self._live.touch_from = np.inf if overlays.dots else TOUCHED_KPA
        self.recolour(scale)

    @property
    def ground(self) -> GroundPicture | None:
        """What lies under the touch; None for the plain scale."""
        kind = self._overlays.ground
        if kind not in self._grounds:
            self._grounds_of = _scales(self.document)
            self._grounds[kind] = paint_ground(kind, self.map, self._atlas)
        return self._grounds[kind]

    @property
    def legend(self) -> Legend | None:
        """What the overlay's colours mean; None where there is nothing to say."""
        return legend_of(self.ground, self._flaws)

    def show(self, frame: Frame, scale: PressureScale) -> None:
        """Colour image and taxels by the frame's pressures. Cost: about 3 ms for 512² pixels."""
        self.pressures = frame.pressures
        self._atlas.render(frame.pressures, self._kilopascals)
        self.recolour(scale)

    def recolour(self, scale: PressureScale) -> None:
        """Show the same pressures on another scale."""
        self._scale = scale
        self._live.fill(self._kilopascals, scale)
        self._taxels.colour(self.pressures / 1e3, scale)
        self._mark_faults()

    def use_faults(self, faults: TaxelFaults) -> None:
        """Mark these from now on, and others no longer."""
        self._faults = faults
        self._mark_faults()

    def _mark_faults(self) -> None:
        found = self._faults.of(self.pressures) if self._faults.any else {}
        self._faulty.mark(found)
        self.fault_keys = keys_of(found)

    def select(self, taxels: IntArray, inks: tuple[str, ...]) -> None:
        """Ring these taxels (k,), each in its colour."""
        self._taxels.select(taxels, inks)

    def set_theme(self, theme: Theme) -> None:
        """Take the theme's line colours."""
        for item in self._patches:
            item.set_theme(theme)

    def place_of(self, at: SurfacePoint) -> QPointF:
        """Where a body point lies in the scene."""
        shape = self.shapes.patches[at.patch]
        chart = shape.chart.chart
        x, y = shape.to_scene(np.asarray(at.weights) @ chart.plane[chart.faces[at.face]])
        return QPointF(x, y)

    def mark_of(self, at: SurfacePoint | None) -> QPointF | None:
        """Where to mark a body point; None for none, and on a patch that is hidden."""
        return None if at is None or not self.shapes.patches[at.patch].shown else self.place_of(at)

    def ellipses(self, region: ContactRegion) -> tuple[FloatArray | None, FloatArray | None]:
        """Half-axes (2, 2) each of a region's ellipse and error circle [scene units]; none where not wanted."""
        if not self._overlays.shapes or not region.axes.any():
            return None, None
        scale = self.shapes.frame.scale * np.array([1.0, -1.0])
        ellipse, error = ellipses_on_map(region, self.map)
        return ellipse * scale, error * scale

    def hit(self, x: float, y: float) -> SurfacePoint | None:
        """The body point under a scene point; None outside all patches that are shown, and while a chart is held."""
        # Searching a chart that is new in every frame costs as much as the frame.
        return None if self.held else self._seen.hit(self.shapes.frame, x, y)

    def pins(self) -> tuple[QPointF, ...]:
        """Where the pins of the patches shown are wanted [scene units]; none while they are not to be seen."""
        if not self._overlays.pins:
            return ()
        places = [pin_places(self.document, k) for k, patch in enumerate(self.document.patches) if patch.visible]
        return tuple(QPointF(x, y) for part in places for x, y in self.shapes.frame.to_scene(part).tolist())

    def contours(self) -> list[QLineF]:
        """Lines around the touched areas [scene units]; none while they are not wanted."""
        found: list[QLineF] = []
        for number, tile in enumerate(self._atlas.tiles):
            shape, values = self.shapes.patches[number], self._kilopascals[self._atlas.window(number)]
            if self._overlays.contours and shape.shown and number not in self.held and values.max() >= TOUCHED_KPA:
                found += lines(shape.to_scene(tile.chart_points(contour_segments(values, TOUCHED_KPA))))
        return found

    def _wear(self, atlas: Atlas) -> None:
        """Draw every patch by this live image."""
        self._atlas, self.held = atlas, ()
        self._live = LiveImage(atlas.shape, *atlas.halo)
        planes = tuple(atlas.plane(number) for number in range(len(atlas.tiles)))
        self.skin_picture = SkinPicture(self._live.pixels, atlas.extent, planes)
        self._kilopascals = np.zeros(atlas.shape, np.float32)
        self._atlas.render(self.pressures, self._kilopascals)
        self._grounds: dict[Ground, GroundPicture | None] = {}
        self._grounds_of = _scales(self.document)
        for number in range(len(self._patches)):
            self._show_image(number)

    def _show_image(self, number: int) -> None:
        rows, columns = self._atlas.window(number)
        shape, scale = self.shapes.patches[number].chart, self.shapes.frame.scale
        self._patches[number].show_image(
            shape, scale, self._live, self._atlas.tiles[number], (rows.start, columns.start)
        )

    def _hold(self, new: Sequence[int]) -> None:
        """Draw these as nets, and those again by the image that were."""
        for number in set(self.held) - set(new):
            self._show_image(number)
        for number in new:
            shape, scale = self.shapes.patches[number].chart, self.shapes.frame.scale
            if number not in self.held:
                self._nets[number] = net(shape, self.document.skin.patches[number], most=NET_LINES)
            self._patches[number].show_net(shape, scale, self._nets[number])
        self.held = tuple(new)

    def _place(self) -> None:
        """Everything where the document's layout has it."""
        for item, shape in zip(self._patches, self.shapes.patches, strict=True):
            item.place(shape, self.shapes.frame.scale)
        self._taxels.place(self.shapes, self.held)
        self._faulty.place(self.shapes)
        self._seen = Seen(self.map, self.shapes.numbers)
        self._flaws: Flaws = self._finder.of(self.document)
        self._flawed.mark(self._flaws, self.shapes.frame)


def _scales(document: MapDocument) -> list[float]:
    return [placement.scale for placement in document.layout.placements]
