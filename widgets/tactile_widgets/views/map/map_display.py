"""What is drawn of the live tactile map: document, newest frame, selections and overlays, and the marks over them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from PySide6.QtCore import QObject, QRectF, Signal
from PySide6.QtGui import QFont, QPainter, QTransform
from PySide6.QtWidgets import QGraphicsScene

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.editing.document import MapDocument
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.maps.image_atlas import ImageAtlas, ImageSettings
from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene
from tactile_widgets.common.colours import PressureScale, Theme
from tactile_widgets.common.settings import OverlayOptions
from tactile_widgets.overlays.taxel_faults import NO_FAULTS, TaxelFaults
from tactile_widgets.views.map.items.map_coordinates import nearest_taxel, readout_text
from tactile_widgets.views.map.items.map_scene import MapLayerFactory, MapScene
from tactile_widgets.views.map.painting.map_painter import MapMarks, MapPainter, outlines
from tactile_widgets.views.overlays.body_overlays import SkinTexture
from tactile_widgets.views.overlays.task_overlay import NO_TASK, TaskOverlay

_KEPT_IMAGES = 3
"""Skins whose live image stays: a scene, the recording replayed over it, and one that was opened before."""


class MapDisplay(QObject):
    """What a map view draws; the view has the camera, and paints. Decides nothing.

    Args:
        theme: Colours of everything that is not skin.
        scale: Colours of pressure.
        font: The window's.
        parent: Qt parent.
        layers: Makes each layer that is drawn on the map, by name.

    Attributes:
        theme: As above, or as set since.
        picture: The document in a graphics scene; None before there is one.
        marks: What lies over it.
    """

    changed = Signal()
    """Something has to be painted anew."""
    scene_changed = Signal(QGraphicsScene)
    """Another skin is shown, in this graphics scene."""
    bounds_changed = Signal()
    """``bounds`` is another one."""
    frame_waiting = Signal()
    """A frame came: whoever is seen calls ``refresh``."""
    frame_shown = Signal()
    """The newest frame is in the picture, to be painted."""
    painted = Signal(int)
    """A frame has reached the screen: its tick."""
    picture_changed = Signal()
    """``skin_texture`` is another one."""

    def __init__(
        self,
        theme: Theme,
        scale: PressureScale,
        font: QFont,
        parent: QObject | None = None,
        *,
        layers: Mapping[str, MapLayerFactory] | None = None,
    ) -> None:
        super().__init__(parent)
        self.theme = theme
        self._scale = scale
        self._layers = dict(layers or {})
        self.picture: MapScene | None = None
        self._overlaid: tuple[ContactRegion, ...] = ()
        self.marks = MapMarks()
        self._frame: Frame | None = None
        self._hovered_at: SurfacePoint | None = None
        self._stale = self._unseen = False
        self._overlays = OverlayOptions()
        self._look = ImageSettings()
        self._images: tuple[ImageAtlas, ...] = ()  # of other skins too, the newest first
        self._faults = NO_FAULTS
        self._task = NO_TASK
        self._painter = MapPainter(theme, font)

    def keep_image(self, image: ImageAtlas) -> None:
        """Have this live image when its skin is shown, soon: it saves building it here, which takes some tenths."""
        others = [kept for kept in self._images if kept.skin is not image.skin]
        self._images = (image, *others[: _KEPT_IMAGES - 1])

    def show_prepared(self, prepared: PreparedScene) -> None:
        """Show the map of ``prepared``. Cost: 15 ms; where its live image is not kept from before, that of it too."""
        self._show_first(MapDocument.of(prepared.map))

    def show_document(self, document: MapDocument, *, in_gesture: bool = False) -> None:
        """Show a document as it is being edited; of the skin that is shown already, the camera stays where it is.

        Args:
            document: Names and hidden patches are as it says.
            in_gesture: More will follow at once. Charts that changed are then drawn as nets, and what takes long waits.

        Cost: 2 ms where only patches were moved. A new chart while dragging: 5 ms for 10,000 faces; once it is at rest,
        its part of the live image is built: 60 ms for 300² pixels.
        """
        if self.picture is None or self.picture.document.skin is not document.skin:
            self._show_first(document)
            return
        rebuilt = self.picture.take(document, in_gesture=in_gesture)
        if not in_gesture:
            self.bounds_changed.emit()
        self._update_marks()
        if rebuilt:
            self.picture_changed.emit()

    def _show_first(self, document: MapDocument) -> None:
        # A scene that starts again, or comes back after a replay, is on the same skin: its image is there already.
        if self.picture is not None:
            self.keep_image(self.picture.atlas)
        known = next((kept for kept in self._images if kept.skin is document.skin), None)
        atlas = ImageAtlas(document.map, known=known, look=self._look)
        picture = MapScene(document, self.theme, atlas=atlas, layers=self._layers)
        picture.overlay(self._overlays, self._scale)
        picture.use_faults(self._faults)
        scene = QGraphicsScene(self)
        picture.add_to(scene)
        self.picture = picture
        self._frame = None
        self._hovered_at = None
        self._task = NO_TASK
        self._overlaid = ()
        self.marks = MapMarks(paused=self.marks.paused, replaying=self.marks.replaying, legend=picture.legend)
        self.scene_changed.emit(scene)
        self.picture_changed.emit()

    @property
    def bounds(self) -> FloatArray | None:
        """(2, 2) smallest and largest scene point of what is shown; None for nothing."""
        return None if self.picture is None else self.picture.shapes.bounds

    def show_frame(self, frame: Frame, *, task: TaskOverlay = NO_TASK) -> None:
        """Show ``frame`` of the prepared scene, and its task; kept until ``refresh``."""
        self._frame = frame
        self._task = task
        self._stale = True
        self.frame_waiting.emit()

    def show_task(self, task: TaskOverlay) -> None:
        """Show what a controller wants while there is no other frame; nothing for the same again."""
        if task is not self._task:
            self._task = task
            self._update_marks()

    def show_overlaid(self, regions: Sequence[ContactRegion]) -> None:
        """Outline contacts of a second recording on the same skin, until others come."""
        if regions or self._overlaid:
            self._overlaid = tuple(regions)
            self._update_marks()

    def set_hover(self, at: SurfacePoint | None) -> None:
        """Mark the place that the pointer is over in another view; None for none."""
        self._hovered_at = at
        if self.picture is not None:
            self._mark(replace(self.marks, hover=self.picture.mark_of(at)))

    def set_selection(self, taxels: IntArray, inks: tuple[str, ...]) -> None:
        """Ring these taxels (k,), each in its colour."""
        if self.picture is not None:
            self.picture.select(taxels, inks)
            self.changed.emit()

    def set_overlays(self, overlays: OverlayOptions) -> None:
        """Show what View > Overlay asks for."""
        self._overlays = overlays
        if self.picture is not None:
            self.picture.overlay(overlays, self._scale)
            self._update_marks()

    def set_image(self, look: ImageSettings) -> None:
        """Make the live image otherwise, in this scene and those after it. Cost: as ``MapScene.make_image``."""
        self._look = look
        if self.picture is not None:
            self.picture.make_image(look)
            self._update_marks()
            self.picture_changed.emit()

    def set_faults(self, faults: TaxelFaults) -> None:
        """Mark dead, stuck, saturated and blind taxels, in this scene and those after it."""
        self._faults = faults
        if self.picture is not None:
            self.picture.use_faults(faults)
            self._update_marks()

    @property
    def skin_texture(self) -> SkinTexture | None:
        """The map's own pixels, for another view; None without a map."""
        return None if self.picture is None else self.picture.skin_texture

    def words_for(self, at: SurfacePoint | None) -> str:
        """What is at a place of the skin: patch, taxel, pressure, map point, and stretch while it is shown."""
        picture = self.picture
        if at is None or picture is None:
            return ""
        stretched = "" if picture.ground is None else picture.ground.tell(picture.map, at)
        name = picture.shapes.patches[at.patch].name
        taxel = nearest_taxel(picture.map, at)
        frame = self._frame
        told = readout_text(
            picture.map,
            at,
            None if frame is None else frame.pressures,
            units=ReadingUnits.CALIBRATED if frame is None else frame.units,
            name=name,
            fault="" if taxel is None else picture.fault_words(taxel),
        )
        return "  ·  ".join(filter(None, (told, stretched)))

    def set_theme(self, theme: Theme) -> None:
        """Take another theme."""
        self.theme = self._painter.theme = theme
        if self.picture is not None:
            self.picture.set_theme(theme)
        self.changed.emit()

    def set_scale(self, scale: PressureScale) -> None:
        """Take another pressure scale."""
        self._scale = scale
        if self.picture is not None:
            self.picture.recolour(scale)
        self.changed.emit()

    def set_replaying(self, *, replaying: bool) -> None:
        """Mark everything shown as replayed from a recording, or as live again."""
        self._mark(replace(self.marks, replaying=replaying))

    def set_paused(self, *, paused: bool) -> None:
        """Say that time stands still, or runs again."""
        self._mark(replace(self.marks, paused=paused))

    def _mark(self, marks: MapMarks) -> None:
        self.marks = marks
        self.changed.emit()

    def read_out(self, words: str) -> None:
        """Say what is under the pointer."""
        self._mark(replace(self.marks, readout=words))

    def refresh(self) -> None:
        """Draw the newest frame, if it is not drawn yet. Cost: 3 to 5 ms."""
        picture = self.picture
        frame = self._frame
        if picture is None or frame is None or not self._stale:
            return
        picture.show(frame, self._scale)
        self._stale = False
        self._unseen = True
        self._update_marks()
        self.frame_shown.emit()

    def _update_marks(self) -> None:
        """Marks of the frame and of the pointer where the map has them now."""
        picture = self.picture
        if picture is None:
            return
        hover = picture.mark_of(self._hovered_at)
        marks = replace(self.marks, legend=picture.legend, faults=picture.fault_legend, hover=hover)
        marks = replace(marks, overlaid=outlines(self._overlaid, picture))
        marks = replace(marks, task=self._task, target=picture.mark_of(self._task.target))
        self._mark(marks if self._frame is None else marks.of_frame(self._frame, picture))

    def paint(self, painter: QPainter, view: QTransform, room: QRectF) -> None:
        """Draw the marks over the scene; ``view`` takes scene units to pixels of the viewport ``room``."""
        if self.picture is not None:
            self._painter.paint(painter, self.marks, self.picture, view, room)

    def tell_painted(self) -> None:
        """All of it is on the screen."""
        if self._unseen and self._frame is not None:
            self._unseen = False
            self.painted.emit(self._frame.tick)
