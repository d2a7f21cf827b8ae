"""The tactile map of the current scene and the gestures on it.

Press, move and release events become pokes, selections of taxels or edits in ``ViewInteraction``. The map itself is a
``MapCanvas`` with ``MapMarks`` painted over it; ``MapView`` passes documents, frames and overlays to both.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from PySide6.QtCore import QEvent, QPointF, QRectF, Qt, Signal
from PySide6.QtGui import (
    QColor,
    QFocusEvent,
    QKeyEvent,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QResizeEvent,
    QShowEvent,
    QTransform,
    QWheelEvent,
)
from PySide6.QtWidgets import QFrame, QGraphicsScene, QGraphicsView, QWidget

from tactile_maps.contacts.detection.regions import ContactRegion
from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray
from tactile_maps.core.errors import MapError
from tactile_maps.core.reading_units import ReadingUnits
from tactile_maps.editing.document import MapDocument
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.maps.image_atlas import ImageAtlas, ImageSettings
from tactile_maps.session.frame import Frame
from tactile_maps.session.prepare import PreparedScene
from tactile_widgets.common.colours import PressureScale, Theme
from tactile_widgets.common.settings import OverlayOptions
from tactile_widgets.common.tool_kinds import ToolKind
from tactile_widgets.overlays.taxel_faults import NO_FAULTS, TaxelFaults
from tactile_widgets.views.interaction.navigation import CameraMotion, zoom_by
from tactile_widgets.views.interaction.select_gesture import Pixel, paint_rubber_band
from tactile_widgets.views.interaction.view_interaction import ViewInteraction
from tactile_widgets.views.interaction.view_tool import NO_BOXES, PointedAt, PointerHit, ViewTool
from tactile_widgets.views.map.items.map_canvas import MapCanvas, MapLayerFactory
from tactile_widgets.views.map.items.map_coordinates import MapCamera, SceneTransform, nearest_taxel, readout_text
from tactile_widgets.views.map.painting.map_painter import MapMarks, MapPainter, outlines
from tactile_widgets.views.overlays.body_overlays import SkinTexture
from tactile_widgets.views.overlays.painting import ViewState
from tactile_widgets.views.overlays.placeholder_card import CardTexts, PlaceholderCard
from tactile_widgets.views.overlays.task_overlay import NO_TASK, TaskOverlay

_KEPT_IMAGES = 2
"""Number of skins whose map image is kept: of the scene shown before, and of one that is shown soon. An image keeps the
skin and all that was computed for it."""
_AROUND = 3.0
"""Visible surroundings of a taxel that the view looks at [taxel pitches]."""
_POKES = "Press a patch to poke the robot there. Drag next to the patches, or with the right button, to pan."
_SELECTS = "Click taxels or draw around them to select them. Escape selects none."
_EDITS = "Edit the map with the active tool. Hold Space and drag to pan."
_LEADS = "Draw the reference path or target. Hold Space and drag to pan."
_TEXTS = CardTexts(
    "No tactile map yet",
    "Open a robot to see its tactile map.",
    "Computing the tactile map",
    "There is no tactile map",
)
_BUTTONS = (Qt.MouseButton.LeftButton, Qt.MouseButton.MiddleButton, Qt.MouseButton.RightButton)
WHEEL_STEP = 1.2
"""Zoom of one notch of the wheel, or one press of plus."""
KEY_PAN_PX = 40.0
_PAN_KEYS = {
    Qt.Key.Key_Left: (KEY_PAN_PX, 0.0),
    Qt.Key.Key_Right: (-KEY_PAN_PX, 0.0),
    Qt.Key.Key_Up: (0.0, KEY_PAN_PX),
    Qt.Key.Key_Down: (0.0, -KEY_PAN_PX),
}
_ZOOM_KEYS = {Qt.Key.Key_Plus: WHEEL_STEP, Qt.Key.Key_Equal: WHEEL_STEP, Qt.Key.Key_Minus: 1 / WHEEL_STEP}


class MapView(QGraphicsView):
    """The tactile map: a ``MapCanvas``, the marks over it, a camera, and a ``ViewPort`` for the gestures.

    Args:
        theme: Colours of everything except the skin.
        scale: Colours of pressure.
        parent: Qt parent.
        layers: Factories of the layers drawn on the map, by name.

    Attributes:
        theme: Current theme.
        picture: Canvas items of the current document; None before the first one.
        marks: Everything painted over them.
        card: Placeholder shown while there is no map.
        interaction: Gestures on the map; its signals report them.
        camera: Part of the map that the viewport shows.
    """

    readout_changed = Signal(str)
    """Description of the skin location under the pointer in either view; empty without one."""
    picture_changed = Signal()
    """``skin_texture`` has been replaced."""
    painted = Signal(int)
    """A frame has been painted; its tick."""
    works_off_skin = True
    turns = False
    idle_cursor = Qt.CursorShape.ArrowCursor

    def __init__(
        self,
        theme: Theme,
        scale: PressureScale,
        parent: QWidget | None = None,
        *,
        layers: Mapping[str, MapLayerFactory] | None = None,
    ) -> None:
        super().__init__(parent)
        self.theme = theme
        self.picture: MapCanvas | None = None
        self.marks = MapMarks()
        self.camera = MapCamera.framing((1000.0, 1000.0))
        self._scale = scale
        self._layers = dict(layers or {})
        self._frame: Frame | None = None
        self._stale = False  # the frame is not in the picture yet
        self._unpainted = False  # it is in the picture, but not painted yet
        self._hovered_at: SurfacePoint | None = None
        self._described: SurfacePoint | None = None
        self._description = ""
        self._overlaid: tuple[ContactRegion, ...] = ()
        self._overlays = OverlayOptions()
        self._faults = NO_FAULTS
        self._task = NO_TASK
        self._look = ImageSettings()
        self._images: tuple[ImageAtlas, ...] = ()  # also of other skins, newest first
        self._set_up()
        self._painter = MapPainter(theme, self.font())
        self.interaction = ViewInteraction(self, self)
        self.interaction.hovered.connect(self.describe)
        self.interaction.taxel_selector.drawn.connect(self.viewport().update)
        self.card = PlaceholderCard(_TEXTS, self.viewport())
        self.card.covered.connect(self._on_covered)
        self.set_theme(theme)
        self.card.show_empty()

    def _set_up(self) -> None:
        self.setObjectName("map-view")
        self.setAccessibleName("Tactile map")
        self.setAccessibleDescription(_POKES)
        self.setScene(QGraphicsScene(self))
        self.setInteractive(False)
        self.setAcceptDrops(False)  # a file dropped here is the window's
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setVerticalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setTransformationAnchor(QGraphicsView.ViewportAnchor.NoAnchor)
        self.setResizeAnchor(QGraphicsView.ViewportAnchor.NoAnchor)
        self.setViewportUpdateMode(QGraphicsView.ViewportUpdateMode.FullViewportUpdate)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.viewport().setMouseTracking(True)

    # Content.

    def keep_image(self, image: ImageAtlas) -> None:
        """Keep a map image computed in advance for a skin that is shown soon; building it here takes some tenths of a
        second.
        """
        others = [kept for kept in self._images if kept.skin is not image.skin]
        self._images = (image, *others[: _KEPT_IMAGES - 1])

    def show_prepared(self, prepared: PreparedScene) -> None:
        """Show the whole map of ``prepared``. Cost: 15 ms, plus building its image unless that has been kept."""
        self.interaction.cancel()
        self._show_first(MapDocument.of(prepared.map))
        self.interaction.show_nothing()

    def show_document(self, document: MapDocument, *, in_gesture: bool = False) -> None:
        """Show an edited document. The camera stays where it is, unless the skin is another one.

        Args:
            document: Map, patch names and hidden patches.
            in_gesture: More changes follow at once. Changed charts are then drawn as wireframes, and slow work waits.

        Cost: 2 ms if only patches moved. A new chart during a drag: 5 ms for 10,000 faces; after the drag, building its
        part of the image takes 60 ms for 300² pixels.
        """
        if self.picture is None or self.picture.document.skin is not document.skin:
            self._show_first(document)
            return
        rebuilt = self.picture.take(document, in_gesture=in_gesture)
        if not in_gesture:
            self._update_content()
        self._update_marks()
        if rebuilt:
            self.picture_changed.emit()

    def _show_first(self, document: MapDocument) -> None:
        # A scene that restarts, or returns after a replay, has the same skin: its image exists already.
        if self.picture is not None:
            self.keep_image(self.picture.atlas)
        known = next((kept for kept in self._images if kept.skin is document.skin), None)
        if known is not None and known.look == self._look and known.has_charts(document.charts):
            atlas = known
        else:
            atlas = ImageAtlas(document.map, known=known, look=self._look)
        picture = MapCanvas(document, self.theme, atlas=atlas, layers=self._layers)
        picture.overlay(self._overlays, self._scale)
        picture.use_faults(self._faults)
        scene = QGraphicsScene(self)
        picture.add_to(scene)
        self.picture = picture
        self._frame = None
        self._hovered_at = None
        self._task = NO_TASK
        self._overlaid = ()
        self.marks = MapMarks(state=self.marks.state, legend=picture.legend)
        self.card.clear()
        previous = self.scene()
        self.setScene(scene)
        previous.deleteLater()
        self.camera = MapCamera.framing(picture.shapes.frame.size)
        self._update_content()
        self.frame_all()
        self.describe(None)
        self.picture_changed.emit()

    def show_frame(self, frame: Frame, *, task: TaskOverlay = NO_TASK) -> None:
        """Show a frame of the prepared scene and its task: at once if the view is visible, or when it is shown."""
        self._frame = frame
        self._task = task
        self._stale = True
        if self.isVisible():
            self._draw_frame()
        else:
            self._update_description()

    def _draw_frame(self) -> None:
        """Draw the newest frame unless it has been drawn. Cost: 3 to 5 ms."""
        if self.picture is None or self._frame is None or not self._stale:
            return
        self.picture.show(self._frame, self._scale)
        self._stale = False
        self._unpainted = True
        self._update_marks()

    def show_task(self, task: TaskOverlay) -> None:
        """Show the controller's task between two frames."""
        if task is not self._task:
            self._task = task
            self._update_marks()

    def show_overlaid(self, regions: Sequence[ContactRegion]) -> None:
        """Outline the contacts of a second recording on the same skin."""
        if regions or self._overlaid:
            self._overlaid = tuple(regions)
            self._update_marks()

    def set_selection(self, taxels: IntArray, inks: tuple[str, ...]) -> None:
        """Draw a ring around each of these taxels (k,) in its colour."""
        if self.picture is not None:
            self.picture.select(taxels, inks)
            self.viewport().update()

    def set_overlays(self, overlays: OverlayOptions) -> None:
        """Show the layers selected under View > Overlay."""
        self._overlays = overlays
        if self.picture is not None:
            self.picture.overlay(overlays, self._scale)
            self._update_marks()
            self._frame_again()

    def set_image(self, look: ImageSettings) -> None:
        """Set resolution and interpolation of the image, also for later scenes. Cost: that of
        ``MapCanvas.make_image``.
        """
        self._look = look
        if self.picture is not None:
            self.picture.make_image(look)
            self._update_marks()
            self.picture_changed.emit()

    def set_faults(self, faults: TaxelFaults) -> None:
        """Mark dead, stuck, saturated and blind taxels, also of later scenes."""
        self._faults = faults
        if self.picture is not None:
            self.picture.use_faults(faults)
            self._update_marks()

    def set_theme(self, theme: Theme) -> None:
        """Set the theme."""
        self.setBackgroundBrush(QColor(theme.window))
        self.theme = self._painter.theme = theme
        if self.picture is not None:
            self.picture.set_theme(theme)
        self.viewport().update()

    def set_scale(self, scale: PressureScale) -> None:
        """Set the pressure scale."""
        self._scale = scale
        if self.picture is not None:
            self.picture.recolour(scale)
            self._update_marks()
        self.viewport().update()

    def set_state(self, state: ViewState) -> None:
        """Set the state that is marked."""
        self._mark(replace(self.marks, state=state))

    @property
    def skin_texture(self) -> SkinTexture | None:
        """The map's image, as a texture for the robot view; None without a map."""
        return None if self.picture is None else self.picture.skin_texture

    def _update_marks(self) -> None:
        """Place all marks on the current map."""
        picture = self.picture
        if picture is None:
            return
        marks = replace(
            self.marks,
            legend=picture.legend,
            layers=picture.layer_legends,
            faults=picture.fault_legend,
            hover=picture.mark_of(self._hovered_at),
            overlaid=outlines(self._overlaid, picture),
            task=self._task,
            target=picture.mark_of(self._task.target),
        )
        self._mark(marks if self._frame is None else marks.of_frame(self._frame, picture))
        self._update_description()

    def _mark(self, marks: MapMarks) -> None:
        self.marks = marks
        self.viewport().update()

    # The pointer.

    def set_hover(self, at: SurfacePoint | None) -> None:
        """Mark the skin location under the pointer in either view."""
        self._hovered_at = at
        if self.picture is not None:
            self._mark(replace(self.marks, hover=self.picture.mark_of(at)))

    def describe(self, at: SurfacePoint | None) -> None:
        """Keep ``readout_changed`` up to date for a skin location, the one under the pointer in either view."""
        self._described = at
        self._update_description()

    def _update_description(self) -> None:
        """Describe the location under the pointer once per frame."""
        words = self.words_for(self._described)
        if words != self._description:
            self._description = words
            self.readout_changed.emit(words)

    def words_for(self, at: SurfacePoint | None) -> str:
        """Return patch, taxel, pressure and map point of a skin location, and the stretch while that is shown."""
        picture = self.picture
        if at is None or picture is None:
            return ""
        stretch = "" if picture.background is None else picture.background.description(picture.map, at)
        taxel = nearest_taxel(picture.map, at)
        frame = self._frame
        reading = readout_text(
            picture.map,
            at,
            None if frame is None else frame.pressures,
            shear=None if frame is None else frame.shear,
            units=ReadingUnits.CALIBRATED if frame is None else frame.units,
            name=picture.shapes.patches[at.patch].name,
            fault="" if taxel is None else picture.fault_words(taxel),
        )
        return "  ·  ".join(filter(None, (reading, stretch)))

    # The camera.

    def _update_content(self) -> None:
        """Make ``frame_all`` frame the current shapes; the part in view stays the same."""
        framed = self._framed()
        if framed is not None:
            self.look(self.camera.over(framed.content, framed.origin, self._room()))

    def legends_fit(self) -> bool:
        """Whether all legends are in view and hide neither a caption nor, if all of the map is in view, a patch."""
        return self.picture is None or self._painter.legends_fit(
            self.marks,
            self.picture,
            self.viewportTransform(),
            QRectF(self.viewport().rect()),
            whole_map=self.camera.framed,
        )

    def leave_out_hiding(self) -> tuple[frozenset[str], frozenset[str]]:
        """Stop painting names that hide skin, and forces that hide another patch than theirs; return both."""
        if self.picture is None:
            return frozenset(), frozenset()
        return self._painter.leave_out_hiding(*self._place(self.picture))

    def callouts_fit(self) -> bool:
        """Whether captions of contacts hide no other caption, contact or small patch."""
        return self.picture is None or self._painter.callouts_fit(*self._place(self.picture))

    def _place(self, picture: MapCanvas) -> tuple[MapMarks, MapCanvas, QTransform, QRectF]:
        return self.marks, picture, self.viewportTransform(), QRectF(self.viewport().rect())

    def _framed(self, *, still: bool = False) -> MapCamera | None:
        """Return the camera with the whole map in view; None without visible patches."""
        if self.picture is None:
            return None
        room = QRectF(self.viewport().rect())
        return self._painter.framing(self.marks, self.picture.shapes, room, still=still)

    def _frame_again(self) -> None:
        """Keep the whole map in view if it is, next to other legends or in another viewport."""
        before = self.camera
        self._update_content()
        if before.framed and self.camera.content != before.content:
            self.frame_all()

    def look(self, camera: MapCamera) -> None:
        """Show the part of the map that ``camera`` shows."""
        self.camera = camera
        scale = camera.scale(self._room())
        self.setTransform(QTransform.fromScale(scale, scale))
        # Only the surroundings of the centre: a patch moved far away would exceed the range of scroll bars.
        reach = max(self._room()) / scale + 1.0
        self.setSceneRect(camera.centre[0] - reach, camera.centre[1] - reach, 2 * reach, 2 * reach)
        self.centerOn(*camera.centre)
        # Scrolling is in whole pixels; the transform contains the fraction, so that the camera is exact.
        width, height = self._room()
        rest = QPointF(width / 2, height / 2) - self.viewportTransform().map(QPointF(*camera.centre))
        self.setTransform(QTransform(scale, 0, 0, scale, rest.x(), rest.y()))
        self.viewport().update()

    def frame_all(self, *, still: bool = False) -> None:
        """Frame the whole content, next to the legend of the base layer; in a ``still`` picture next to all legends."""
        self.look(self._framed(still=still) or MapCamera.framing(self.camera.content, self.camera.origin))

    def frame_taxels(self, taxels: IntArray) -> None:
        """Show these taxels (k,), at least one, and their surroundings."""
        picture = self._picture
        if picture is not None:
            self._frame_places(picture.shapes.taxels[taxels], _AROUND * picture.shapes.pitch)

    def frame_places(self, points: FloatArray) -> None:
        """Show map points (k, 2) [m], at least one, and their surroundings."""
        picture = self._picture
        if picture is not None:
            self._frame_places(picture.shapes.frame.to_scene(points), _AROUND * picture.shapes.pitch)

    def _frame_places(self, places: FloatArray, around: float) -> None:
        low = places.min(axis=0) - around
        high = places.max(axis=0) + around
        self.look(self.camera.closing_in((float(low[0]), float(low[1])), (float(high[0]), float(high[1]))))

    def pan(self, dx: float, dy: float) -> None:
        """Drag the content by pixels."""
        self.look(self.camera.panned(dx, dy, self._room()))

    def zoom(self, factor: float, at: QPointF) -> None:
        """Zoom around the viewport point ``at``."""
        self.look(self.camera.zoomed(factor, (at.x(), at.y()), self._room()))

    def scene_point(self, position: QPointF) -> QPointF:
        """Return the scene point under a viewport position, with subpixel precision."""
        inverse, _ = self.viewportTransform().inverted()
        return inverse.map(position)

    def _room(self) -> tuple[float, float]:
        return float(self.viewport().width()), float(self.viewport().height())

    # The ``ViewPort`` of the gestures.

    @property
    def _picture(self) -> MapCanvas | None:
        """Canvas items, unless the placeholder covers them."""
        return None if self.card.isVisible() else self.picture

    def point_at(self, pixel: QPointF) -> SurfacePoint | None:
        """Return the skin location under a pixel; None next to the patches and under the placeholder."""
        if self._picture is None:
            return None
        place = self.scene_point(pixel)
        return self._picture.hit(place.x(), place.y())

    def pointed_at(self, pixel: QPointF) -> PointedAt:
        """Return what is under a pixel."""
        return PointedAt(self.point_at(pixel))

    def hit_at(self, pixel: QPointF, at: SurfacePoint | None) -> PointerHit | None:
        """Return what a tool needs to know about a pixel over ``at``; None without a map."""
        if self._picture is None:
            return None
        scene = self.scene_point(pixel)
        frame = self._picture.shapes.frame
        return PointerHit(at, frame.to_map(np.array([scene.x(), scene.y()])), self._pixel_size(frame))

    def _pixel_size(self, frame: SceneTransform) -> float:
        """Side of a pixel on the map [m]."""
        return 1.0 / (frame.scale * self.viewportTransform().m11())

    def empty_at(self, pixel: QPointF) -> bool:
        """Whether a pixel is next to the patches."""
        return self.point_at(pixel) is None

    def over_control(self, pixel: QPointF) -> bool:
        """Return False: a map has no controls."""
        return False

    def click_control(self, pixel: QPointF) -> None:
        """Do nothing: a map has no controls."""

    def navigate(self, step: QPointF, motion: CameraMotion) -> None:
        """Pan or zoom."""
        if motion is CameraMotion.ZOOM:
            self.zoom(zoom_by(step.y()), QPointF(self.viewport().rect().center()))
        else:
            self.pan(step.x(), step.y())

    def set_pointer(self, shape: Qt.CursorShape) -> None:
        """Set the shape of the pointer."""
        self.viewport().setCursor(shape)

    def redraw_tool(self) -> None:
        """Paint what the active tool draws over the map."""
        self.viewport().update()

    def taxel_at(self, pixel: Pixel) -> int | None:
        """Return the taxel nearest to a pixel of a patch; None next to the patches."""
        at = self.point_at(QPointF(*pixel))
        return None if at is None or self._picture is None else nearest_taxel(self._picture.map, at)

    def hidden(self, taxels: IntArray) -> BoolArray:
        """Return (k,) False: a map hides no taxel."""
        return np.zeros(len(taxels), bool)

    def pixel_of(self, at: SurfacePoint) -> QPointF:
        """Return the pixel of a skin location, with subpixel precision; raises MapError without a map."""
        if self.picture is None:
            raise MapError("no map is shown", value=at, remedy="Show a prepared scene first")
        return self.viewportTransform().map(self.picture.place_of(at))

    def taxel_pixels(self) -> FloatArray:
        """(taxels, 2) locations in the viewport [px]."""
        picture = self.picture
        return np.zeros((0, 2)) if picture is None else self._scene_to_pixels(picture.shapes.taxels)

    def map_to_pixels(self, points: FloatArray) -> FloatArray:
        """Convert map points (k, 2) [m] to pixels of the viewport."""
        picture = self.picture
        return np.zeros((0, 2)) if picture is None else self._scene_to_pixels(picture.shapes.frame.to_scene(points))

    def _scene_to_pixels(self, points: FloatArray) -> FloatArray:
        view = self.viewportTransform()
        return points * [view.m11(), view.m22()] + [view.dx(), view.dy()]

    def set_tool(self, tool: ToolKind) -> None:
        """Set the tool; the current gesture ends."""
        self.interaction.set_tool(tool)
        kinds = ((tool.edits, _EDITS), (tool.controls, _LEADS), (tool.selects, _SELECTS), (True, _POKES))
        self.setAccessibleDescription(next(words for holds, words in kinds if holds))

    def set_view_tool(self, tool: ViewTool | None) -> None:
        """Pass presses of the left button, and keys, to ``tool``; the previous tool's gesture is cancelled."""
        self.interaction.set_view_tool(tool)

    def _on_covered(self, covered: bool) -> None:
        if covered:
            self.interaction.cancel()

    # Events.

    def mousePressEvent(self, event: QMouseEvent) -> None:
        if event.button() in _BUTTONS:
            self.interaction.press(event)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        self.interaction.move(event)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        self.interaction.release(event)

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        if event.button() in _BUTTONS:
            self.interaction.double_click(event)

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Pass the wheel to the active tool; if that does not use it, zoom."""
        notches = event.angleDelta().y() / 120
        if not self.interaction.wheel(event) and notches:
            self.zoom(WHEEL_STEP**notches, event.position())
        event.accept()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Pass keys to the gestures; of those left, F fits the view, plus and minus zoom, arrows pan."""
        if self.interaction.key(event):
            return
        key = Qt.Key(event.key())
        if key == Qt.Key.Key_F:
            self.frame_all()
        elif key in _ZOOM_KEYS:
            self.zoom(_ZOOM_KEYS[key], QPointF(self.viewport().rect().center()))
        elif key in _PAN_KEYS:
            self.pan(*_PAN_KEYS[key])
        else:
            event.ignore()

    def keyReleaseEvent(self, event: QKeyEvent) -> None:
        self.interaction.key_up(event)

    def focusOutEvent(self, event: QFocusEvent) -> None:
        """Release what is held."""
        self.interaction.focus_out()
        super().focusOutEvent(event)

    def leaveEvent(self, event: QEvent) -> None:
        self.interaction.leave()
        super().leaveEvent(event)

    def showEvent(self, event: QShowEvent) -> None:
        """Draw the newest frame."""
        super().showEvent(event)
        self._draw_frame()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Keep showing the same part of the map, and covering it with the placeholder."""
        super().resizeEvent(event)
        self.look(self.camera)
        self._frame_again()
        self.card.setGeometry(self.viewport().rect())

    def paintEvent(self, event: QPaintEvent) -> None:
        """Paint the canvas items, the marks, and what gesture and tool draw over them."""
        super().paintEvent(event)
        if self._picture is None:
            return
        painter = QPainter(self.viewport())
        tool = self.interaction.view_tool
        boxes = NO_BOXES
        if tool is not None and self.marks.contacts:
            boxes = tool.boxes(self.map_to_pixels, painter.font())
        self._painter.paint(painter, *self._place(self._picture), boxes)
        paint_rubber_band(painter, self.interaction.taxel_selector.rubber_band, self.theme)
        if tool is not None:
            tool.paint(painter, self.map_to_pixels, self.theme)
        painter.end()
        if self._unpainted and self._frame is not None:
            self._unpainted = False
            self.painted.emit(self._frame.tick)
