"""The live tactile map without a hand: shows frames, states, selections and overlays, and tells when it has drawn."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Signal
from PySide6.QtGui import QColor, QPainter, QPaintEvent, QResizeEvent, QShowEvent
from PySide6.QtWidgets import QGraphicsScene, QWidget

from app.core.arrays import FloatArray, IntArray
from app.core.errors import MapError
from app.editing.document import MapDocument
from app.geometry.mesh import SurfacePoint
from app.session.frame import Frame
from app.session.prepare import PreparedScene
from widgets.common.colours import PressureScale, Theme
from widgets.common.placeholder_card import PlaceholderCard
from widgets.common.settings import OverlayOptions
from widgets.interaction.select_gesture import RubberBand
from widgets.map_view.live_image import ImageAtlas, ImageSettings
from widgets.map_view.map_canvas import MapCanvas
from widgets.map_view.map_coordinates import readout_text
from widgets.map_view.map_layer import MapLayerFactory
from widgets.map_view.map_painter import MapMarks, MapPainter
from widgets.map_view.map_scene import MapScene
from widgets.map_view.taxel_faults import NO_FAULTS, TaxelFaults
from widgets.overlays.body_overlays import SkinTexture
from widgets.overlays.task_overlay import NO_TASK, TaskOverlay


class MapDisplay(MapCanvas):
    """Draws the map; decides nothing.

    Args:
        theme: Colours of everything that is not skin.
        scale: Colours of pressure.
        parent: Qt parent.
        layers: Makes each layer that has items, by name.
    """

    painted = Signal(int)
    """A frame has reached the screen: its tick."""
    picture_changed = Signal()
    """``skin_texture`` is another one."""
    open_requested = Signal()
    """The button of the empty or failed state was pressed."""
    cancel_requested = Signal()
    """The button of the loading state was pressed."""

    def __init__(
        self,
        theme: Theme,
        scale: PressureScale,
        parent: QWidget | None = None,
        *,
        layers: Mapping[str, MapLayerFactory] | None = None,
    ) -> None:
        super().__init__(parent)
        self._theme, self._scale, self._layers = theme, scale, dict(layers or {})
        self._picture: MapScene | None = None
        self._frame: Frame | None = None
        self._hovered_at: SurfacePoint | None = None
        self._stale = self._unseen = self._loading = False
        self._marks, self._overlays, self._look = MapMarks(), OverlayOptions(), ImageSettings()
        self._faults, self._task = NO_FAULTS, NO_TASK
        self._painter = MapPainter(theme, self.font())
        self.setObjectName("map-view")
        self.setAccessibleName("Tactile map")
        self._card = PlaceholderCard(self.viewport())
        self._card.helped.connect(self._on_card_helped)
        self.set_theme(theme)

    def show_prepared(self, prepared: PreparedScene, *, atlas: ImageAtlas | None = None) -> None:
        """Show the map of ``prepared``, framed; ``atlas`` saves building its live image here."""
        self._show_first(MapDocument.of(prepared.map), atlas)

    def show_document(self, document: MapDocument, *, in_hand: bool = False) -> None:
        """Show a document as it is being edited; of the skin that is shown already, the camera stays where it is.

        Args:
            document: Names and hidden patches are as it says.
            in_hand: More will follow at once. Charts that changed are then drawn as nets, and what takes long waits.

        Cost: 2 ms where only patches were moved. A new chart in the hand: 5 ms for 10,000 faces; once it is at rest,
        its part of the live image is built: 60 ms for 300² pixels.
        """
        if self._picture is None or self._picture.document.skin is not document.skin:
            self._show_first(document, None)
            return
        rebuilt = self._picture.take(document, in_hand=in_hand)
        if not in_hand:
            self._update_content_bounds()
        self._update_marks()
        if rebuilt:
            self.picture_changed.emit()

    def _show_first(self, document: MapDocument, atlas: ImageAtlas | None) -> None:
        picture = MapScene(
            document, self._theme, atlas=atlas or ImageAtlas(document.map, look=self._look), layers=self._layers
        )
        picture.overlay(self._overlays, self._scale)
        picture.use_faults(self._faults)
        scene = QGraphicsScene(self)
        picture.add_to(scene)
        self._picture, self._frame, self._hovered_at, self._task = picture, None, None, NO_TASK
        self._marks = MapMarks(paused=self._marks.paused, replaying=self._marks.replaying, legend=picture.legend)
        self._card.hide()
        self.show_scene(scene, picture.shapes.frame.size)
        self._update_content_bounds()
        self.frame_all()
        self.picture_changed.emit()

    def _update_content_bounds(self) -> None:
        """Framing all is framing what is shown now."""
        bounds = None if self._picture is None else self._picture.shapes.bounds
        if bounds is not None:
            self.set_content(bounds)

    def show_frame(self, frame: Frame, *, task: TaskOverlay = NO_TASK) -> None:
        """Show ``frame`` of the prepared scene, and its task; while the view is hidden they are only kept."""
        self._frame, self._task, self._stale = frame, task, True
        if self.isVisible():
            self._refresh()

    def show_task(self, task: TaskOverlay) -> None:
        """Show what a controller wants while there is no other frame; nothing for the same again."""
        if task is not self._task:
            self._task = task
            self._update_marks()

    def set_hover(self, at: SurfacePoint | None) -> None:
        """Mark the place that the pointer is over in another view; None for none."""
        self._hovered_at = at
        if self._picture is not None:
            self._mark(replace(self._marks, hover=self._picture.mark_of(at)))

    def set_selection(self, taxels: IntArray, inks: tuple[str, ...]) -> None:
        """Ring these taxels (k,), each in its colour."""
        if self._picture is not None:
            self._picture.select(taxels, inks)
            self.viewport().update()

    def set_overlays(self, overlays: OverlayOptions) -> None:
        """Show what View > Overlay asks for."""
        self._overlays = overlays
        if self._picture is not None:
            self._picture.overlay(overlays, self._scale)
            self._update_marks()

    def set_image(self, look: ImageSettings) -> None:
        """Make the live image otherwise, in this scene and those after it. Cost: as ``MapPicture.make_image``."""
        self._look = look
        if self._picture is not None:
            self._picture.make_image(look)
            self._update_marks()
            self.picture_changed.emit()

    def set_faults(self, faults: TaxelFaults) -> None:
        """Mark dead, stuck and saturated taxels, in this scene and those after it."""
        self._faults = faults
        if self._picture is not None:
            self._picture.use_faults(faults)
            self._update_marks()

    @property
    def skin_texture(self) -> SkinTexture | None:
        """The map's own pixels, for another view; None without a map."""
        return None if self._picture is None else self._picture.skin_texture

    def pixel_of(self, at: SurfacePoint) -> QPointF:
        """Where a body point is drawn in the viewport, finer than a pixel; raises MapError without a map."""
        if self._picture is None:
            raise MapError("there is no map to find the point on", value=at, remedy="Show a prepared scene first")
        return self.viewportTransform().map(self._picture.place_of(at))

    def words_for(self, at: SurfacePoint | None) -> str:
        """What is at a place of the skin: patch, taxel, pressure, map point, and stretch while it is shown."""
        picture = self._picture
        if at is None or picture is None:
            return ""
        stretched = "" if picture.ground is None else picture.ground.tell(picture.map, at)
        name = picture.shapes.patches[at.patch].name
        return "  ·  ".join(filter(None, (readout_text(picture.map, at, self._pressures, name=name), stretched)))

    def taxel_pixels(self) -> FloatArray:
        """(taxels, 2) where they are drawn in the viewport [px]."""
        if self._picture is None:
            return np.zeros((0, 2))
        view = self.viewportTransform()
        return self._picture.shapes.taxels * [view.m11(), view.m22()] + [view.dx(), view.dy()]

    def set_theme(self, theme: Theme) -> None:
        """Take another theme."""
        self._theme = self._painter.theme = theme
        self.setBackgroundBrush(QColor(theme.window))
        if self._picture is not None:
            self._picture.set_theme(theme)
        self.viewport().update()

    def set_scale(self, scale: PressureScale) -> None:
        """Take another pressure scale."""
        self._scale = scale
        if self._picture is not None:
            self._picture.recolour(scale)
        self.viewport().update()

    def set_replaying(self, *, replaying: bool) -> None:
        """Mark everything shown as replayed from a recording, or as live again."""
        self._mark(replace(self._marks, replaying=replaying))

    def set_paused(self, *, paused: bool) -> None:
        """Say that time stands still, or runs again."""
        self._mark(replace(self._marks, paused=paused))

    def show_empty(self) -> None:
        """Say what would fill the view."""
        self._show_card("No tactile map yet", "Open a robot to see its tactile map.", button="Open robot…")

    def show_loading(self, text: str, progress: float) -> None:
        """Say that a map is being made: ``text`` names the stage, ``progress`` runs from 0 to 1."""
        self._show_card("Computing the tactile map", text, button="Cancel", progress=progress)

    def show_failed(self, text: str) -> None:
        """Say why there is no map."""
        self._show_card("There is no tactile map", text, button="Open robot…")

    def show_last(self) -> None:
        """Go back to the last good map after loading another one failed or was cancelled."""
        if self._picture is None:
            self.show_empty()
        else:
            self._card.hide()

    def _show_card(self, heading: str, text: str, *, button: str, progress: float | None = None) -> None:
        self._loading = progress is not None
        self._card.setGeometry(self.viewport().rect())
        self._card.say(heading, text, button=button, progress=progress)

    def _on_card_helped(self) -> None:
        (self.cancel_requested if self._loading else self.open_requested).emit()

    def _mark(self, marks: MapMarks) -> None:
        self._marks = marks
        self.viewport().update()

    def _refresh(self) -> None:
        picture, frame = self._picture, self._frame
        if picture is None or frame is None or not self._stale:
            return
        picture.show(frame, self._scale)
        self._stale, self._unseen = False, True
        self._update_marks()

    def _update_marks(self) -> None:
        """Marks of the frame and of the pointer where the map has them now."""
        picture = self._picture
        if picture is None:
            return
        hover = picture.mark_of(self._hovered_at)
        marks = replace(
            self._marks, legend=picture.legend, faults=picture.fault_legend, hover=hover, pins=picture.pins()
        )
        marks = replace(marks, task=self._task, target=picture.mark_of(self._task.target))
        self._mark(marks if self._frame is None else marks.of_frame(self._frame, picture))

    @property
    def _pressures(self) -> FloatArray | None:
        return None if self._frame is None else self._frame.pressures

    def rubber_band(self) -> RubberBand:
        """What a gesture draws over the map; without a hand there is none."""
        return RubberBand()

    def _paint_over(self, painter: QPainter) -> None:
        """Draw a tool's marks; without a hand there are none."""

    def showEvent(self, event: QShowEvent) -> None:
        """Qt: catch up with the newest frame."""
        super().showEvent(event)
        self._refresh()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Qt: the message keeps covering the view."""
        super().resizeEvent(event)
        self._card.setGeometry(self.viewport().rect())

    def paintEvent(self, event: QPaintEvent) -> None:
        """Qt: the scene, then the marks over it."""
        super().paintEvent(event)
        if self._picture is None or self._card.isVisible():
            return
        room = QRectF(self.viewport().rect())
        painter = QPainter(self.viewport())
        self._painter.paint(painter, self._marks, self._picture.shapes, self.viewportTransform(), room)
        self._painter.paint_rubber(painter, self.rubber_band())
        self._paint_over(painter)
        painter.end()
        if self._unseen and self._frame is not None:
            self._unseen = False
            self.painted.emit(self._frame.tick)
