"""One document as items of a graphics scene: built once per skin, rebuilt where a chart changed, refreshed by frames.

With what a layer of View > Overlay is on the map, so that the scene needs to know none by name.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QPointF
from PySide6.QtGui import QPainter, QTransform
from PySide6.QtWidgets import QGraphicsItem, QGraphicsScene

from tactile_maps.contacts.detection.detection import TOUCH_THRESHOLD
from tactile_maps.core.arrays import BoolArray, IntArray
from tactile_maps.editing.document import MapDocument
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.maps.image_atlas import AtlasTile, ImageAtlas, ImageSettings
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.session.frame import Frame
from tactile_widgets.common.colours import BETWEEN_DOTS, PressureScale, Theme, words32
from tactile_widgets.common.settings import BaseLayer, OverlayOptions
from tactile_widgets.overlays.taxel_faults import NO_FAULTS, Fault, FaultLegend, TaxelFaults, fault_legend
from tactile_widgets.views.map.items.background import Background, Legend, legend_of, make_background
from tactile_widgets.views.map.items.bijectivity import FlawFinder, Flaws, FlawsItem
from tactile_widgets.views.map.items.live_image import LiveImage
from tactile_widgets.views.map.items.map_coordinates import SceneTransform, visible_map
from tactile_widgets.views.map.items.map_items import PatchItem, TaxelsItem, ZOrder
from tactile_widgets.views.map.items.map_shapes import MapShapes, Wireframe, wireframe
from tactile_widgets.views.map.items.taxel_faults import FaultsItem
from tactile_widgets.views.overlays.body_overlays import SkinTexture

CONTACT_KPA = TOUCH_THRESHOLD / 1e3
"""Where the line around a touched area runs [kPa]; the pressure from which the contact reader calls a taxel touched."""
MAX_WIREFRAME_LINES = 3000
"""Most lines by which a chart being dragged is drawn."""


class MapLayer:
    """What a layer of View > Overlay draws on the map: a subclass overrides what it needs. Made once a skin.

    It draws by ``items`` in the graphics scene, by ``paint`` over it, or by children of the scene's ``patches``.

    Args:
        scene: Whose map it is drawn on; what it knows at each call is as drawn now.

    Attributes:
        order: Where it lies; a layer that paints is at ``CONTOURS`` or above.
        replaces_image: Whether the interpolated image is left out while it is shown.
        shown: Whether it is to be seen.
        items: What goes into the graphics scene, which owns it from then on.
    """

    order: ClassVar[ZOrder]
    replaces_image: ClassVar[bool] = False
    items: Sequence[QGraphicsItem] = ()

    def __init__(self, scene: MapScene) -> None:
        self.scene = scene
        self.shown = False

    def set_shown(self, *, shown: bool) -> None:
        """Show it, or hide it."""
        self.shown = shown
        for item in self.items:
            item.setVisible(shown)

    def show_document(self) -> None:
        """The map was edited, its image is another one, or it is shown first."""

    def show_frame(self, frame: Frame) -> None:
        """Another instant."""

    def set_theme(self, theme: Theme) -> None:
        """Take another theme."""

    def paint(self, painter: QPainter, view: QTransform) -> None:
        """Draw over the scene, while it is shown; ``view`` takes scene units to pixels."""


MapLayerFactory = Callable[["MapScene"], MapLayer]
"""Makes a layer for a scene."""


class MapScene:
    """The items of one skin's map in a graphics scene. Mutable: ``take`` another document, ``show`` a frame.

    Args:
        document: What to draw.
        theme: Colours of everything that is not skin.
        atlas: Its live image.
        layers: Makes each layer, by name.

    Attributes:
        document: What is drawn.
        atlas: Its live image; another one where a chart changed.
        theme: As above, or as set since.
        layers: Those of this scene, by name.
        patches: An item for each patch, in its chart's frame.
        taxels: The taxels' item.
        shapes: Where all of it lies; the frame stays the same for all documents.
        skin_texture: The pixels as drawn here, for another view; another one after each ``take`` that says so.
        fault_legend: What marks single taxels mean, now.
        held: Patches whose chart has no image yet, because it is being dragged.
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
        self.shapes = MapShapes.of(document, SceneTransform.around(document.map.bounds))
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
        self._found: Mapping[Fault, BoolArray] = {}
        self._overlays = OverlayOptions()
        self._scale = PressureScale()
        self._use_atlas(atlas)
        self._place()

    def add_to(self, scene: QGraphicsScene) -> None:
        """Put the items into ``scene``, which owns them from then on."""
        for item in (*self.patches, self._flaws_item, self.taxels, self._faults_item):
            scene.addItem(item)
        for layer in self.layers.values():
            for item in layer.items:
                scene.addItem(item)

    @property
    def map(self) -> TactileMap:
        """The map that is drawn."""
        return self.document.map

    def take(self, document: MapDocument, *, in_gesture: bool) -> bool:
        """Draw another document of the same skin. Whether the live image is another one now.

        Args:
            document: What to draw.
            in_gesture: More will follow at once: charts without an image are drawn as nets, and grounds wait.

        Cost: 2 ms where only patches were moved; that of the tiles of new charts, once nothing is being dragged.
        """
        self.document = document
        self.shapes = MapShapes.of(document, self.shapes.frame, known=self.shapes)
        pairs = enumerate(zip(self.atlas.charts, document.charts, strict=True))
        new = tuple(number for number, (old, chart) in pairs if old is not chart)
        rebuilt = bool(new) and not in_gesture
        if rebuilt:
            self._use_atlas(ImageAtlas(document.map, known=self.atlas, look=self.atlas.look))
        elif in_gesture or self.held:
            self._show_wireframes(new)
        self._place()
        if rebuilt or (not in_gesture and self._grounds_of != _placement_scales(document)):
            self._grounds.clear()
            self.overlay(self._overlays, self._scale)
        return rebuilt

    def make_image(self, look: ImageSettings) -> None:
        """Make the live image otherwise. Cost: as ``ImageAtlas``; interpolations other than the usual: up to 1 s."""
        self._use_atlas(ImageAtlas(self.document.map, look=look))
        self._grounds.clear()
        self._place()
        self.overlay(self._overlays, self._scale)

    def overlay(self, overlays: OverlayOptions, scale: PressureScale) -> None:
        """Show what the setting asks for. Cost: 20 to 80 ms for a ground that has not been shown before."""
        self._overlays = overlays
        for name, layer in self.layers.items():
            layer.set_shown(shown=overlays.shows(name))
        replaced = any(layer.shown and layer.replaces_image for layer in self.layers.values())
        self.taxels.replaced = replaced
        ground = self.ground
        bare = np.full(self.atlas.shape, words32(np.array(BETWEEN_DOTS, np.uint8))) if replaced else None
        self._live.ground = bare if ground is None else ground.pixels
        self._live.touch_from = np.inf if replaced else CONTACT_KPA
        self.recolour(scale)

    @property
    def ground(self) -> Background | None:
        """What lies under the touch; None for the plain scale."""
        kind = self._overlays.ground
        if kind not in self._grounds:
            self._grounds_of = _placement_scales(self.document)
            self._grounds[kind] = make_background(kind, self.map, self.atlas)
        return self._grounds[kind]

    @property
    def legend(self) -> Legend | None:
        """What the overlay's colours mean; None where there is nothing to say."""
        return legend_of(self.ground, self._flaws)

    def show(self, frame: Frame, scale: PressureScale) -> None:
        """Colour image and taxels by the frame's pressures. Cost: 0.5 ms; 3 ms for 512² pixels that all change."""
        changed = np.flatnonzero(frame.pressures != self.pressures)
        self.pressures = frame.pressures
        pixels = self.atlas.render(frame.pressures, self._kilopascals, changed=changed)
        self._colour(scale, pixels if scale is self._scale else None)
        for layer in self.layers.values():
            layer.show_frame(frame)

    def recolour(self, scale: PressureScale) -> None:
        """Show the same pressures on another scale."""
        self._colour(scale, None)

    def _colour(self, scale: PressureScale, changed: IntArray | None) -> None:
        """All pixels, or those that ``changed``."""
        self._scale = scale
        self._live.fill(self._kilopascals, scale, changed=changed)
        self.taxels.colour(self.pressures / 1e3, scale)
        self._mark_faults()

    def use_faults(self, faults: TaxelFaults) -> None:
        """Mark these from now on, and others no longer."""
        self._faults = faults
        self._mark_faults()

    def _mark_faults(self) -> None:
        self._found = self._faults.of(self.pressures) if self._faults.any else {}
        self._faults_item.mark(self._found)
        self.fault_legend = fault_legend(self._found, self.document.skin.identity)

    def fault_words(self, taxel: int) -> str:
        """Return what is wrong with a taxel now, in words; empty for nothing."""
        return self._faults.words(self._found, taxel) if self._found else ""

    def select(self, taxels: IntArray, inks: tuple[str, ...]) -> None:
        """Ring these taxels (k,), each in its colour."""
        self.taxels.select(taxels, inks)

    def set_theme(self, theme: Theme) -> None:
        """Take another theme."""
        self.theme = theme
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

    def hit(self, x: float, y: float) -> SurfacePoint | None:
        """The body point under a scene point; None outside all visible patches, and while a chart is held."""
        if self.held:  # searching a chart that is new in every frame costs as much as the frame
            return None
        at = self._visible.to_body(self.shapes.frame.to_map(np.array([x, y])))
        return None if at is None else SurfacePoint(self.shapes.numbers[at.patch], at.face, at.weights)

    def tile(self, number: int) -> tuple[AtlasTile, NDArray[np.float32]]:
        """A patch's part of the image, and the pressures in it [kPa]; of a patch that is held those are old."""
        return self.atlas.tiles[number], self._kilopascals[self.atlas.window(number)]

    def _use_atlas(self, atlas: ImageAtlas) -> None:
        """Draw every patch by this live image."""
        self.atlas = atlas
        self.held = ()
        self._live = LiveImage(atlas.shape, *atlas.halo)
        planes = tuple(atlas.plane(number) for number in range(len(atlas.tiles)))
        self.skin_texture = SkinTexture(self._live.pixels, atlas.extent, planes)
        self._kilopascals = np.zeros(atlas.shape, np.float32)
        self.atlas.render(self.pressures, self._kilopascals)
        self._grounds: dict[BaseLayer, Background | None] = {}
        self._grounds_of = _placement_scales(self.document)
        for number in range(len(self.patches)):
            self._show_image(number)

    def _show_image(self, number: int) -> None:
        rows, columns = self.atlas.window(number)
        shape = self.shapes.patches[number].chart
        scale = self.shapes.frame.scale
        self.patches[number].show_image(shape, scale, self._live, self.atlas.tiles[number], (rows.start, columns.start))

    def _show_wireframes(self, new: Sequence[int]) -> None:
        """Draw these as nets, and those again by the image that were."""
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
        """Everything where the document's layout has it."""
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
