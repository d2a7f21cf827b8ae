"""Canvas items of one document: built once per skin, rebuilt where a chart changed, updated with every tick.

``MapLayer`` is the base class of the layers of View > Overlay on the map.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import ClassVar

import numpy as np
from PySide6.QtCore import QPointF
from PySide6.QtGui import QPainter, QTransform
from PySide6.QtWidgets import QGraphicsItem, QGraphicsScene

from tactile_maps.contacts.detection.detection import TOUCH_THRESHOLD
from tactile_maps.core.arrays import IntArray
from tactile_maps.editing.document import MapDocument
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.maps.image_atlas import ImageAtlas, ImageSettings
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.session.frame import Frame
from tactile_widgets.common.colours import BETWEEN_DOTS, PressureScale, Theme, words32
from tactile_widgets.common.settings import BaseLayer, OverlayOptions
from tactile_widgets.overlays.taxel_faults import NO_FAULTS, FaultLegend, TaxelFaults, fault_legend
from tactile_widgets.views.map.items.background import Background, BackgroundLegend, background_legend, make_background
from tactile_widgets.views.map.items.bijectivity import FlawFinder, Flaws, FlawsItem
from tactile_widgets.views.map.items.live_image import LiveImage
from tactile_widgets.views.map.items.map_coordinates import SceneTransform, visible_map
from tactile_widgets.views.map.items.map_items import PatchItem, TaxelsItem, ZOrder
from tactile_widgets.views.map.items.map_shapes import MapShapes, Wireframe, wireframe
from tactile_widgets.views.map.items.taxel_faults import FaultsItem
from tactile_widgets.views.overlays.body_overlays import SkinTexture
from tactile_widgets.views.overlays.legend import Legend

CONTACT_KPA = TOUCH_THRESHOLD / 1e3
"""Pressure from which touch is shown [kPa]: that from which the contact detector reports it by default."""
MAX_WIREFRAME_LINES = 3000
"""Maximum number of lines of a chart that is being dragged."""


class MapLayer:
    """Layer of View > Overlay on the map; subclasses override what they need. Made once per skin.

    A layer draws by ``items`` on the canvas, by ``paint`` over it, or by children of the ``patches``.

    Args:
        canvas: Items of the map that it is drawn on.

    Attributes:
        order: Drawing order; a layer that paints uses ``CONTOURS`` or above.
        replaces_image: Whether the interpolated image is hidden while the layer is shown.
        shown: Whether the layer is shown.
        items: Items for the canvas, which owns them afterwards.
    """

    order: ClassVar[ZOrder]
    replaces_image: ClassVar[bool] = False
    items: Sequence[QGraphicsItem] = ()

    def __init__(self, canvas: MapCanvas) -> None:
        self.canvas = canvas
        self.shown = False

    def set_shown(self, *, shown: bool) -> None:
        """Show or hide the layer."""
        self.shown = shown
        for item in self.items:
            item.setVisible(shown)

    def show_document(self) -> None:
        """Update after an edit of the map, with another image of it, and at the start."""

    def show_frame(self, frame: Frame) -> None:
        """Update for another instant."""

    def set_theme(self, theme: Theme) -> None:
        """Set the theme."""

    def paint(self, painter: QPainter, view: QTransform) -> None:
        """Draw over the canvas while the layer is shown; ``view`` converts scene units to pixels."""

    @property
    def legend(self) -> Legend | None:
        """Explanation of what is drawn now; None if nothing is to be explained."""
        return None


MapLayerFactory = Callable[["MapCanvas"], MapLayer]
"""Makes a layer for the items of a map."""


class MapCanvas:
    """Canvas items of one skin's map.

    Args:
        document: Document to draw.
        theme: Colours of everything except the skin.
        atlas: Live image of the map.
        layers: Factories of the layers, by name.

    Attributes:
        document: Current document.
        atlas: Live image; replaced when a chart changes.
        theme: Current theme.
        layers: Layers by name.
        patches: One item per patch, in its chart's frame.
        taxels: Item of the taxels.
        pressures: (taxels,) [Pa] as shown.
        kilopascals: (rows, columns) the same in the live image [kPa]; changes in place.
        shapes: Locations of everything on the canvas; its frame is the same for all documents.
        still: The same before the current gesture.
        scale: Current pressure scale.
        skin_texture: Pixels of the image, for the robot view; replaced when ``take`` returns True.
        fault_legend: Meaning of the current marks on faulty taxels.
        held: Patches whose chart has no image yet because it is being dragged.
    """

    def __init__(
        self,
        document: MapDocument,
        theme: Theme,
        *,
        atlas: ImageAtlas,
        layers: Mapping[str, MapLayerFactory] | None = None,
    ) -> None:
        self.document = document
        self.pressures = np.zeros(len(document.skin))
        self.shapes = self.still = MapShapes.of(document, SceneTransform.around(document.map.bounds))
        self.held: tuple[int, ...] = ()
        self._nets: dict[int, Wireframe] = {}
        self.theme = theme
        self.taxels = TaxelsItem()
        self.patches = tuple(PatchItem() for _ in document.charts)
        self._flaws_item = FlawsItem(theme)
        self._flaw_finder = FlawFinder()
        self._faults_item = FaultsItem()
        self._faults = NO_FAULTS
        self.layers = {name: make(self) for name, make in (layers or {}).items()}
        self.fault_legend: FaultLegend = ()
        self._overlays = OverlayOptions()
        self.scale = PressureScale()
        self._use_atlas(atlas)
        self._place()

    def add_to(self, scene: QGraphicsScene) -> None:
        """Add the items to ``scene``, which owns them afterwards."""
        items = (item for layer in self.layers.values() for item in layer.items)
        for item in (*self.patches, self._flaws_item, self.taxels, self._faults_item, *items):
            scene.addItem(item)

    @property
    def map(self) -> TactileMap:
        """Map of the current document."""
        return self.document.map

    def take(self, document: MapDocument, *, in_gesture: bool) -> bool:
        """Draw another document of the same skin; returns whether the live image was replaced.

        Args:
            document: Document to draw.
            in_gesture: More changes follow at once: charts without an image are drawn as wireframes, and the
                background is not updated.

        Cost: 2 ms if only patches were moved; after a drag, that of the image tiles of new charts.
        """
        self.document = document
        self.shapes = MapShapes.of(document, self.shapes.frame, known=self.shapes)
        if not in_gesture:
            self.still = self.shapes
        pairs = enumerate(zip(self.atlas.charts, document.charts, strict=True))
        new = tuple(number for number, (old, chart) in pairs if old is not chart)
        rebuilt = bool(new) and not in_gesture
        if rebuilt:
            self._use_atlas(ImageAtlas(document.map, known=self.atlas, look=self.atlas.look))
        elif in_gesture or self.held:
            self._show_wireframes(new)
        self._place()
        if rebuilt or (not in_gesture and self._background_scales != _placement_scales(document)):
            self._backgrounds.clear()
            self.overlay(self._overlays, self.scale)
        return rebuilt

    def make_image(self, look: ImageSettings) -> None:
        """Make the live image with other settings. Cost: that of ``ImageAtlas``; up to 1 s for other interpolations."""
        self._use_atlas(ImageAtlas(self.document.map, look=look))
        self._backgrounds.clear()
        self._place()
        self.overlay(self._overlays, self.scale)

    def overlay(self, overlays: OverlayOptions, scale: PressureScale) -> None:
        """Show the selected layers. Cost: 20 to 80 ms for a background that has not been shown before."""
        self._overlays = overlays
        for name, layer in self.layers.items():
            layer.set_shown(shown=overlays.shows(name))
        replaced = any(layer.shown and layer.replaces_image for layer in self.layers.values())
        self.taxels.replaced = replaced
        background = self.background
        bare = np.full(self.atlas.shape, words32(np.array(BETWEEN_DOTS, np.uint8))) if replaced else None
        self._live.background = bare if background is None else background.pixels
        self._live.touch_from = np.inf if replaced else CONTACT_KPA
        self.recolour(scale)

    @property
    def background(self) -> Background | None:
        """Background under the touch; None for the plain scale."""
        kind = self._overlays.base
        if kind not in self._backgrounds:
            self._background_scales = _placement_scales(self.document)
            self._backgrounds[kind] = make_background(kind, self.map, self.atlas)
        return self._backgrounds[kind]

    @property
    def legend(self) -> BackgroundLegend | None:
        """Legend of the background and the flaws; None if there are neither."""
        return background_legend(self.background, self._flaws, self.overlapping)

    @property
    def layer_legends(self) -> tuple[Legend, ...]:
        """Legends of the layers that are shown and have something to explain."""
        legends = (layer.legend for layer in self.layers.values() if layer.shown)
        return tuple(legend for legend in legends if legend is not None)

    @property
    def overlapping(self) -> tuple[str, ...]:
        """Names of the patches that overlap others."""
        return tuple(self.document.patches[number].name for number in self._flaws.patches)

    def show(self, frame: Frame, scale: PressureScale) -> None:
        """Colour image and taxels by the frame's pressures. Cost: 0.5 ms; 3 ms for 512² pixels that all change."""
        changed = np.flatnonzero(frame.pressures != self.pressures)
        self.pressures = frame.pressures
        pixels = self.atlas.render(frame.pressures, self.kilopascals, changed=changed)
        self.recolour(scale, changed=pixels if scale is self.scale else None)
        for layer in self.layers.values():
            layer.show_frame(frame)

    def recolour(self, scale: PressureScale, *, changed: IntArray | None = None) -> None:
        """Show the pressures on this scale; ``changed``: (k,) pixels that differ, None for all."""
        self.scale = scale
        self._live.fill(self.kilopascals, scale, changed=changed)
        self.taxels.readings = self.pressures / 1e3, scale
        self.use_faults(self._faults)

    def use_faults(self, faults: TaxelFaults) -> None:
        """Mark these faults and no others."""
        self._faults = faults
        self._faults_item.faults = faults.of(self.pressures) if faults.any else {}
        self.fault_legend = fault_legend(self._faults_item.faults, self.document.skin.identity)

    def fault_words(self, taxel: int) -> str:
        """Describe the current faults of a taxel; empty without any."""
        found = self._faults_item.faults
        return self._faults.words(found, taxel) if found else ""

    def select(self, taxels: IntArray, inks: tuple[str, ...]) -> None:
        """Draw a ring around each of these taxels (k,) in its colour."""
        self.taxels.select(taxels, inks)

    def set_theme(self, theme: Theme) -> None:
        """Set the theme."""
        self.theme = theme
        for layer in self.layers.values():
            layer.set_theme(theme)

    def place_of(self, at: SurfacePoint) -> QPointF:
        """Return the canvas point of a skin location."""
        shape = self.shapes.patches[at.patch]
        chart = shape.chart.chart
        x, y = shape.to_scene(np.asarray(at.weights) @ chart.plane[chart.faces[at.face]])
        return QPointF(x, y)

    def mark_of(self, at: SurfacePoint | None) -> QPointF | None:
        """Return the canvas point of a skin location; None for None, and on a hidden patch."""
        return None if at is None or not self.shapes.patches[at.patch].shown else self.place_of(at)

    def hit(self, x: float, y: float) -> SurfacePoint | None:
        """Return the skin location under a canvas point; None off the visible patches, and while a chart is held."""
        if self.held:  # searching a chart that changes with every tick takes as long as drawing it
            return None
        at = self._visible.to_body(self.shapes.frame.to_map(np.array([x, y])))
        return None if at is None else SurfacePoint(self.shapes.numbers[at.patch], at.face, at.weights)

    def _use_atlas(self, atlas: ImageAtlas) -> None:
        """Draw all patches by this live image."""
        self.atlas = atlas
        self.held = ()
        self._live = LiveImage(atlas.shape, *atlas.halo)
        planes = tuple(atlas.plane(number) for number in range(len(atlas.tiles)))
        self.skin_texture = SkinTexture(self._live.pixels, atlas.extent, planes)
        self.kilopascals = np.zeros(atlas.shape, np.float32)
        self.atlas.render(self.pressures, self.kilopascals)
        self._backgrounds: dict[BaseLayer, Background | None] = {}
        self._background_scales = _placement_scales(self.document)
        for number in range(len(self.patches)):
            self._show_image(number)

    def _show_image(self, number: int) -> None:
        rows, columns = self.atlas.window(number)
        shape = self.shapes.patches[number].chart
        scale = self.shapes.frame.scale
        self.patches[number].show_image(shape, scale, self._live, self.atlas.tiles[number], (rows.start, columns.start))

    def _show_wireframes(self, new: Sequence[int]) -> None:
        """Draw these patches as wireframes, and the others by the image again."""
        for number in set(self.held) - set(new):
            self._show_image(number)
        for number in new:
            shape = self.shapes.patches[number].chart
            scale = self.shapes.frame.scale
            if number not in self.held:
                self._nets[number] = wireframe(shape, self.document.skin.patches[number], most=MAX_WIREFRAME_LINES)
            self.patches[number].show_wireframe(shape, scale, self._nets[number])
        self.held = tuple(new)

    def _place(self) -> None:
        """Move everything to its place in the document's layout."""
        for item, shape in zip(self.patches, self.shapes.patches, strict=True):
            item.place(shape, self.shapes.frame.scale)
        self.taxels.place(self.shapes, self.held)
        self._faults_item.place(self.shapes)
        for layer in self.layers.values():
            layer.show_document()
        self._visible = visible_map(self.map, self.shapes.numbers)
        self._flaws: Flaws = self._flaw_finder.of(self.document)
        self._flaws_item.mark(self._flaws, self.shapes.frame)


def _placement_scales(document: MapDocument) -> list[float]:
    return [placement.scale for placement in document.layout.placements]
