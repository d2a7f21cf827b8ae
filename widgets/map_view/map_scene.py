"""One document as items of a graphics scene: built once per skin, rebuilt where a chart changed, refreshed by frames.

With the iso-lines around touched areas: marching squares, as short unordered segments, exact on the bilinear grid
edges.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QLineF, QPointF
from PySide6.QtGui import QFont
from PySide6.QtWidgets import QGraphicsScene

from app.contacts.detection import TOUCH_THRESHOLD
from app.contacts.regions import ContactRegion
from app.core.arrays import FloatArray, IntArray
from app.editing.document import MapDocument
from app.editing.pins import pin_places
from app.geometry.mesh import SurfacePoint
from app.maps.distortion import Flaws
from app.maps.tactile_map import TactileMap
from app.session.frame import Frame
from widgets.common.colours import BETWEEN_DOTS, PressureScale, Theme, words32
from widgets.common.settings import BaseLayer, OverlayOptions
from widgets.map_view.background import Background, Legend, legend_of, make_background
from widgets.map_view.bijectivity import FlawFinder, FlawsItem
from widgets.map_view.contact_ellipses import ellipses_on_map
from widgets.map_view.live_image import ImageAtlas, ImageSettings, LiveImage
from widgets.map_view.map_coordinates import SceneTransform, VisiblePatches
from widgets.map_view.map_items import PatchItem, TaxelsItem, to_lines
from widgets.map_view.map_layer import MapLayerFactory
from widgets.map_view.map_shapes import MapShapes, Wireframe, wireframe
from widgets.map_view.taxel_faults import NO_FAULTS, FaultLegend, FaultsItem, TaxelFaults, fault_legend
from widgets.overlays.body_overlays import SkinTexture

# Edges of a cell: 0 top, 1 right, 2 bottom, 3 left.
# Bits of its corners: 1 top left, 2 top right, 4 bottom right, 8 bottom left.
_SEGMENTS = {
    1: [(3, 0)], 2: [(0, 1)], 3: [(3, 1)], 4: [(1, 2)], 5: [(3, 0), (1, 2)], 6: [(0, 2)], 7: [(3, 2)],
    8: [(2, 3)], 9: [(0, 2)], 10: [(0, 1), (2, 3)], 11: [(1, 2)], 12: [(3, 1)], 13: [(0, 1)], 14: [(3, 0)],
}  # fmt: skip
_TABLE = np.full((16, 2, 2), -1)
for _case, _pairs in _SEGMENTS.items():
    _TABLE[_case, : len(_pairs)] = _pairs


def contour_segments(image: NDArray[Any], level: float) -> FloatArray:
    """The line ``image == level``.

    Args:
        image: (h, w) finite values at pixel centres.
        level: Values at or above it are inside.

    Returns:
        (s, 2, 2) segments as (column, row) with the first pixel's centre at (0, 0). Cost: 0.3 ms for 512² pixels.
    """
    inside = (image >= level).view(np.uint8)
    upper = inside[:-1, :-1] | inside[:-1, 1:] << 1
    lower = inside[1:, 1:] << 2 | inside[1:, :-1] << 3
    cases = upper | lower
    rows, columns = np.nonzero((cases > 0) & (cases < 15))
    edges = _TABLE[cases[rows, columns]]
    crossings = _crossings(image, rows, columns, level)
    cell, pair = np.nonzero(edges[..., 0] >= 0)
    ends = edges[cell, pair]
    return crossings[cell[:, None], ends]


def _crossings(image: NDArray[Any], rows: NDArray[np.intp], columns: NDArray[np.intp], level: float) -> FloatArray:
    """(cells, 4, 2) where the level crosses each edge; meaningless for edges it does not cross."""
    corner = [image[rows + dr, columns + dc].astype(np.float64) for dr, dc in ((0, 0), (0, 1), (1, 1), (1, 0))]
    points = np.empty((len(rows), 4, 2))
    points[:, 0] = np.stack([columns + _interpolation(corner[0], corner[1], level), rows], axis=1)
    points[:, 1] = np.stack([columns + 1, rows + _interpolation(corner[1], corner[2], level)], axis=1)
    points[:, 2] = np.stack([columns + _interpolation(corner[3], corner[2], level), rows + 1], axis=1)
    points[:, 3] = np.stack([columns, rows + _interpolation(corner[0], corner[3], level)], axis=1)
    return points


def _interpolation(start: FloatArray, end: FloatArray, level: float) -> FloatArray:
    step = end - start
    return np.divide(level - start, step, out=np.full_like(start, 0.5), where=step != 0)


CONTACT_KPA = TOUCH_THRESHOLD / 1e3
"""Where the line around a touched area runs [kPa]; the pressure from which the contact reader calls a taxel touched."""
MAX_WIREFRAME_LINES = 3000
"""Most lines by which a chart in the hand is drawn."""


class MapScene:
    """The items of one skin's map in a graphics scene. Mutable: ``take`` another document, ``show`` a frame.

    Args:
        document: What to draw.
        theme: Colours of borders and seams.
        atlas: Its live image, where one exists already; building one takes some tenths of a second.
        layers: Makes each layer that has items of its own, by name.

    Attributes:
        document: What is drawn.
        shapes: Where all of it lies; the frame stays the same for all documents.
        skin_texture: The pixels as drawn here, for another view; another one after each ``take`` that says so.
        fault_legend: What marks single taxels mean, now.
        held: Patches whose chart has no image yet, because it is in the hand.
    """

    def __init__(
        self,
        document: MapDocument,
        theme: Theme,
        *,
        atlas: ImageAtlas | None = None,
        layers: Mapping[str, MapLayerFactory] | None = None,
    ) -> None:
        self.document, self.pressures = document, np.zeros(len(document.skin))
        self.shapes = MapShapes.of(document, SceneTransform.around(document.map.bounds))
        self.held: tuple[int, ...] = ()
        self._nets: dict[int, Wireframe] = {}
        self._patches = [PatchItem(theme) for _ in document.charts]
        self._taxels, self._flaws_item, self._flaw_finder = TaxelsItem(QFont()), FlawsItem(theme), FlawFinder()
        self._faults_item, self._faults = FaultsItem(), NO_FAULTS
        self.layers = {name: make(document, theme) for name, make in (layers or {}).items()}
        self.fault_legend: FaultLegend = ()
        self._overlays, self._scale = OverlayOptions(), PressureScale()
        self._use_atlas(atlas or ImageAtlas(document.map))
        self._place()

    def add_to(self, scene: QGraphicsScene) -> None:
        """Put the items into ``scene``, which owns them from then on."""
        for item in (*self._patches, self._flaws_item, self._taxels, self._faults_item):
            scene.addItem(item)
        for layer in self.layers.values():
            for item in layer.items:
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
            self._use_atlas(ImageAtlas(document.map, known=self._atlas, look=self._atlas.look))
        elif in_hand or self.held:
            self._show_wireframes(new)
        self._place()
        if rebuilt or (not in_hand and self._grounds_of != _placement_scales(document)):
            self._grounds.clear()
            self.overlay(self._overlays, self._scale)
        return rebuilt

    def make_image(self, look: ImageSettings) -> None:
        """Make the live image otherwise. Cost: as ``Atlas``; other interpolations than the usual take up to 1 s."""
        self._use_atlas(ImageAtlas(self.document.map, look=look))
        self._grounds.clear()
        self._place()
        self.overlay(self._overlays, self._scale)

    def overlay(self, overlays: OverlayOptions, scale: PressureScale) -> None:
        """Show what the setting asks for. Cost: 20 to 80 ms for a ground that has not been shown before."""
        self._overlays = overlays
        for item in self._patches:
            item.line(border=overlays.shows("border"), seams=overlays.shows("seams"))
        dots = overlays.shows("dots")
        self._taxels.dots, self._taxels.numbered = dots, overlays.shows("taxel_ids")
        for name, layer in self.layers.items():
            layer.set_shown(shown=overlays.shows(name))
        ground = self.ground
        bare = np.full(self._atlas.shape, words32(np.array(BETWEEN_DOTS, np.uint8))) if dots else None
        self._live.ground = bare if ground is None else ground.pixels
        self._live.touch_from = np.inf if dots else CONTACT_KPA
        self.recolour(scale)

    @property
    def ground(self) -> Background | None:
        """What lies under the touch; None for the plain scale."""
        kind = self._overlays.ground
        if kind not in self._grounds:
            self._grounds_of = _placement_scales(self.document)
            self._grounds[kind] = make_background(kind, self.map, self._atlas)
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
        for layer in self.layers.values():
            layer.show_frame(frame)

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
        self._faults_item.mark(found)
        self.fault_legend = fault_legend(found)

    def select(self, taxels: IntArray, inks: tuple[str, ...]) -> None:
        """Ring these taxels (k,), each in its colour."""
        self._taxels.select(taxels, inks)

    def set_theme(self, theme: Theme) -> None:
        """Take the theme's line colours."""
        for item in self._patches:
            item.set_theme(theme)
        for layer in self.layers.values():
            layer.set_theme(theme)

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
        if not self._overlays.shows("shapes") or not region.link_axes.any():
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
        if not self._overlays.shows("pins"):
            return ()
        places = [pin_places(self.document, k) for k, patch in enumerate(self.document.patches) if patch.visible]
        return tuple(QPointF(x, y) for part in places for x, y in self.shapes.frame.to_scene(part).tolist())

    def contours(self) -> list[QLineF]:
        """Lines around the touched areas [scene units]; none while they are not wanted."""
        found: list[QLineF] = []
        for number, tile in enumerate(self._atlas.tiles):
            shape, values = self.shapes.patches[number], self._kilopascals[self._atlas.window(number)]
            if (
                self._overlays.shows("contours")
                and shape.shown
                and number not in self.held
                and values.max() >= CONTACT_KPA
            ):
                found += to_lines(shape.to_scene(tile.chart_points(contour_segments(values, CONTACT_KPA))))
        return found

    def _use_atlas(self, atlas: ImageAtlas) -> None:
        """Draw every patch by this live image."""
        self._atlas, self.held = atlas, ()
        self._live = LiveImage(atlas.shape, *atlas.halo)
        planes = tuple(atlas.plane(number) for number in range(len(atlas.tiles)))
        self.skin_texture = SkinTexture(self._live.pixels, atlas.extent, planes)
        self._kilopascals = np.zeros(atlas.shape, np.float32)
        self._atlas.render(self.pressures, self._kilopascals)
        self._grounds: dict[BaseLayer, Background | None] = {}
        self._grounds_of = _placement_scales(self.document)
        for number in range(len(self._patches)):
            self._show_image(number)

    def _show_image(self, number: int) -> None:
        rows, columns = self._atlas.window(number)
        shape, scale = self.shapes.patches[number].chart, self.shapes.frame.scale
        self._patches[number].show_image(
            shape, scale, self._live, self._atlas.tiles[number], (rows.start, columns.start)
        )

    def _show_wireframes(self, new: Sequence[int]) -> None:
        """Draw these as nets, and those again by the image that were."""
        for number in set(self.held) - set(new):
            self._show_image(number)
        for number in new:
            shape, scale = self.shapes.patches[number].chart, self.shapes.frame.scale
            if number not in self.held:
                self._nets[number] = wireframe(shape, self.document.skin.patches[number], most=MAX_WIREFRAME_LINES)
            self._patches[number].show_wireframe(shape, scale, self._nets[number])
        self.held = tuple(new)

    def _place(self) -> None:
        """Everything where the document's layout has it."""
        for item, shape in zip(self._patches, self.shapes.patches, strict=True):
            item.place(shape, self.shapes.frame.scale)
        self._taxels.place(self.shapes, self.held)
        self._faults_item.place(self.shapes)
        for layer in self.layers.values():
            layer.show_document(self.document, self.shapes)
        self._seen = VisiblePatches(self.map, self.shapes.numbers)
        self._flaws: Flaws = self._flaw_finder.of(self.document)
        self._flaws_item.mark(self._flaws, self.shapes.frame)


def _placement_scales(document: MapDocument) -> list[float]:
    return [placement.scale for placement in document.layout.placements]
