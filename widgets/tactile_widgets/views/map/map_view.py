"""The live tactile map and its gestures: a camera over what ``MapDisplay`` draws, and presses that become pokes at body
points, selections of taxels, or edits.
"""

from __future__ import annotations

from collections.abc import Mapping

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

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray
from tactile_maps.core.errors import MapError
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.session.prepare import PreparedScene
from tactile_widgets.common.colours import PressureScale, Theme
from tactile_widgets.common.placeholder_card import CardTexts, PlaceholderCard
from tactile_widgets.common.tool_kinds import ToolKind
from tactile_widgets.views.interaction.pointed_at import PointedAt
from tactile_widgets.views.interaction.poke_gesture import Panned
from tactile_widgets.views.interaction.select_gesture import Pixel, paint_rubber_band
from tactile_widgets.views.interaction.view_interaction import ViewInteraction
from tactile_widgets.views.interaction.view_tool import PointerHit, ViewTool
from tactile_widgets.views.map.items.map_coordinates import MapCamera, SceneTransform, nearest_taxel
from tactile_widgets.views.map.items.map_scene import MapLayerFactory, MapScene
from tactile_widgets.views.map.map_display import MapDisplay

_AROUND = 3.0
"""Pitches that are seen around a taxel that is looked at."""
_POKES = "Press a patch to poke the robot there. Drag beside the patches, or with the right button, to pan."
_SELECTS = "Click taxels or draw around them to select them. Escape selects none."
_EDITS = "Edit the map with the active tool. Drag with the middle button, or with Space, to pan."
_LEADS = "Draw the reference path or target. Drag with the middle button, or with Space, to pan."
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
    """A camera over a ``MapDisplay`` and the gestures on it: a ``ViewPort`` whose ``interaction`` emits what is done.

    Decides nothing.

    Args:
        theme: Colours of everything that is not skin.
        scale: Colours of pressure.
        parent: Qt parent.
        layers: Makes each layer that is drawn on the map, by name.

    Attributes:
        display: What is drawn.
        card: What is said instead.
        interaction: The gestures; its signals are also the view's.
        camera: What the viewport shows.
    """

    readout = Signal(str)
    """The words for what is under the pointer; the view shows them too."""
    beside_skin = True
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
        self.camera = MapCamera.framing((1000.0, 1000.0))
        self._set_up()
        self.display = MapDisplay(theme, scale, self.font(), self, layers=layers)
        self.display.changed.connect(self.viewport().update)
        self.display.scene_changed.connect(self._on_scene_changed)
        self.display.bounds_changed.connect(self._update_content)
        self.display.frame_waiting.connect(self._on_frame_waiting)
        self.display.frame_shown.connect(self._read_out)
        gestures = self.interaction = ViewInteraction(self, self)
        self.poke_pressed = gestures.poke_pressed
        self.poke_moved = gestures.poke_moved
        self.poke_released = gestures.poke_released
        self.hovered = gestures.hovered
        self.cleared = gestures.cleared
        self.taxel_selector = gestures.taxel_selector
        self.hovered.connect(self._read_out)
        self.taxel_selector.drawn.connect(self.viewport().update)
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

    def show_prepared(self, prepared: PreparedScene) -> None:
        """Show the map of ``prepared``, framed."""
        self.interaction.cancel()
        self.display.show_prepared(prepared)
        self.interaction.show_nothing()

    def set_tool(self, tool: ToolKind) -> None:
        """Take another tool; what the user was doing ends."""
        self.interaction.set_tool(tool)
        kinds = ((tool.edits, _EDITS), (tool.controls, _LEADS), (tool.selects, _SELECTS), (True, _POKES))
        self.setAccessibleDescription(next(words for holds, words in kinds if holds))

    def set_view_tool(self, tool: ViewTool | None) -> None:
        """Give presses of the left button, and keys, to ``tool``; what the one before was doing is given up."""
        self.interaction.set_view_tool(tool)

    def set_theme(self, theme: Theme) -> None:
        """Take another theme."""
        self.setBackgroundBrush(QColor(theme.window))
        self.display.set_theme(theme)

    def _on_covered(self, covered: bool) -> None:
        if covered:
            self.interaction.cancel()

    def _on_frame_waiting(self) -> None:
        if self.isVisible():
            self.display.refresh()

    def _read_out(self) -> None:
        words = self.display.words_for(self.interaction.hover)
        if words != self.display.marks.readout:
            self.display.read_out(words)
            self.readout.emit(words)

    # The camera.

    def _on_scene_changed(self, scene: QGraphicsScene) -> None:
        """Another skin: framed. The scene before is deleted."""
        self.card.clear()
        previous = self.scene()
        self.setScene(scene)
        previous.deleteLater()
        if self.display.picture is not None:
            self.camera = MapCamera.framing(self.display.picture.shapes.frame.size)
        self._update_content()
        self.frame_all()

    def _update_content(self) -> None:
        """Framing all is framing what is shown now; what is in view stays there."""
        bounds = self.display.bounds
        if bounds is not None:
            low, high = bounds
            size = float(high[0] - low[0]), float(high[1] - low[1])
            self.look(self.camera.over(size, (float(low[0]), float(low[1])), self._room()))

    def look(self, camera: MapCamera) -> None:
        """Look through ``camera``."""
        self.camera = camera
        scale = camera.scale(self._room())
        self.setTransform(QTransform.fromScale(scale, scale))
        # Room around the centre only: a patch moved far away would be more than scroll bars can count.
        reach = max(self._room()) / scale + 1.0
        self.setSceneRect(camera.centre[0] - reach, camera.centre[1] - reach, 2 * reach, 2 * reach)
        self.centerOn(*camera.centre)
        # Scrolling is in whole pixels; the transform carries the rest, so that the camera is met exactly.
        width, height = self._room()
        rest = QPointF(width / 2, height / 2) - self.viewportTransform().map(QPointF(*camera.centre))
        self.setTransform(QTransform(scale, 0, 0, scale, rest.x(), rest.y()))
        self.viewport().update()

    def frame_all(self) -> None:
        """Frame the whole content."""
        self.look(MapCamera.framing(self.camera.content, self.camera.origin))

    def frame_taxels(self, taxels: IntArray) -> None:
        """Look at these taxels (k,), at least one, with some of what is around them."""
        picture = self._picture
        if picture is not None:
            self._frame(picture.shapes.taxels[taxels], _AROUND * picture.shapes.pitch)

    def frame_places(self, points: FloatArray) -> None:
        """Look at points of the map (k, 2) [m], at least one, with some of what is around them."""
        picture = self._picture
        if picture is not None:
            self._frame(picture.shapes.frame.to_scene(points), _AROUND * picture.shapes.pitch)

    def _frame(self, places: FloatArray, around: float) -> None:
        low = places.min(axis=0) - around
        high = places.max(axis=0) + around
        self.look(self.camera.closing_in((float(low[0]), float(low[1])), (float(high[0]), float(high[1]))))

    def pan(self, dx: float, dy: float) -> None:
        """Drag the content by pixels."""
        self.look(self.camera.panned(dx, dy, self._room()))

    def zoom(self, factor: float, at: QPointF) -> None:
        """Zoom so that what lies under the viewport point ``at`` stays there."""
        self.look(self.camera.zoomed(factor, (at.x(), at.y()), self._room()))

    def scene_point(self, position: QPointF) -> QPointF:
        """The scene point under a viewport position, finer than a pixel."""
        inverse, _ = self.viewportTransform().inverted()
        return inverse.map(position)

    def _room(self) -> tuple[float, float]:
        return float(self.viewport().width()), float(self.viewport().height())

    # What the user asks.

    @property
    def _picture(self) -> MapScene | None:
        """What is there to be touched: nothing under a message."""
        return None if self.card.isVisible() else self.display.picture

    def point_at(self, pixel: QPointF) -> SurfacePoint | None:
        """The place of the skin under a pixel; None beside the patches, and under a message."""
        if self._picture is None:
            return None
        place = self.scene_point(pixel)
        return self._picture.hit(place.x(), place.y())

    def pointed_at(self, pixel: QPointF) -> PointedAt:
        """What is under a pixel."""
        return PointedAt(self.point_at(pixel))

    def hit_at(self, pixel: QPointF, at: SurfacePoint | None) -> PointerHit | None:
        """What a tool is told of a pixel over ``at``; None without a map, and under a message."""
        if self._picture is None:
            return None
        scene = self.scene_point(pixel)
        frame = self._picture.shapes.frame
        return PointerHit(at, frame.to_map(np.array([scene.x(), scene.y()])), self._pixel_size(frame))

    def _pixel_size(self, frame: SceneTransform) -> float:
        """Side of a pixel on the map [m]."""
        return 1.0 / (frame.scale * self.viewportTransform().m11())

    def empty_at(self, pixel: QPointF) -> bool:
        """Whether a pixel is beside the patches."""
        return self.point_at(pixel) is None

    def over_control(self, pixel: QPointF) -> bool:
        """A map has no controls of its own."""
        return False

    def click_control(self, pixel: QPointF) -> None:
        """A map has no controls of its own."""

    def set_hover(self, at: SurfacePoint | None) -> None:
        """Mark the place under the pointer."""
        self.display.set_hover(at)

    def navigate(self, drag: Panned, *, turn: bool) -> None:
        """Pan."""
        self.pan(drag.dx, drag.dy)

    def set_pointer(self, shape: Qt.CursorShape) -> None:
        """Give the pointer this shape."""
        self.viewport().setCursor(shape)

    def redraw_tool(self) -> None:
        """Paint what the active tool draws over the map."""
        self.viewport().update()

    def taxel_at(self, pixel: Pixel) -> int | None:
        """The taxel nearest to a pixel of a patch; None beside the patches."""
        at = self.point_at(QPointF(*pixel))
        return None if at is None or self._picture is None else nearest_taxel(self._picture.map, at)

    def hidden(self, taxels: IntArray) -> BoolArray:
        """Nothing hides anything on a map."""
        return np.zeros(len(taxels), bool)

    def pixel_of(self, at: SurfacePoint) -> QPointF:
        """Where a body point is drawn in the viewport, finer than a pixel; raises MapError without a map."""
        if self.display.picture is None:
            raise MapError("there is no map to find the point on", value=at, remedy="Show a prepared scene first")
        return self.viewportTransform().map(self.display.picture.place_of(at))

    def taxel_pixels(self) -> FloatArray:
        """(taxels, 2) where they are drawn in the viewport [px]."""
        picture = self.display.picture
        return np.zeros((0, 2)) if picture is None else self._scene_to_pixels(picture.shapes.taxels)

    def map_to_pixels(self, points: FloatArray) -> FloatArray:
        """Map points (k, 2) [m] as pixels of the viewport."""
        picture = self.display.picture
        return np.zeros((0, 2)) if picture is None else self._scene_to_pixels(picture.shapes.frame.to_scene(points))

    def _scene_to_pixels(self, points: FloatArray) -> FloatArray:
        view = self.viewportTransform()
        return points * [view.m11(), view.m22()] + [view.dx(), view.dy()]

    # Qt's events.

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Qt: left, middle and right button make gestures."""
        if event.button() in _BUTTONS:
            self.interaction.press(event)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Qt: part of a gesture."""
        self.interaction.move(event)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """Qt: part of a gesture."""
        self.interaction.release(event)

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        """Qt: left, middle and right button make gestures."""
        if event.button() in _BUTTONS:
            self.interaction.double_click(event)

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Qt: the tool's, where it has something to turn there; else it zooms."""
        notches = event.angleDelta().y() / 120
        if not self.interaction.wheel(event) and notches:
            self.zoom(WHEEL_STEP**notches, event.position())
        event.accept()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Qt: gestures first; else F frames all, plus and minus zoom, arrows pan."""
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
        """Qt: part of a gesture."""
        self.interaction.key_up(event)

    def focusOutEvent(self, event: QFocusEvent) -> None:
        """Qt: what is held is let go."""
        self.interaction.focus_out()
        super().focusOutEvent(event)

    def leaveEvent(self, event: QEvent) -> None:
        """Qt: nothing is under the pointer."""
        self.interaction.leave()
        super().leaveEvent(event)

    def showEvent(self, event: QShowEvent) -> None:
        """Qt: catch up with the newest frame."""
        super().showEvent(event)
        self.display.refresh()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Qt: keep showing the same part of the content, and covering it where a message does."""
        super().resizeEvent(event)
        self.look(self.camera)
        self.card.setGeometry(self.viewport().rect())

    def paintEvent(self, event: QPaintEvent) -> None:
        """Qt: the scene, then the marks, and what gesture and tool draw over it."""
        super().paintEvent(event)
        if self._picture is None:
            return
        painter = QPainter(self.viewport())
        self.display.paint(painter, self.viewportTransform(), QRectF(self.viewport().rect()))
        paint_rubber_band(painter, self.taxel_selector.rubber_band, self.display.theme)
        if (tool := self.interaction.view_tool) is not None:
            tool.paint(painter, self.map_to_pixels, self.display.theme)
        painter.end()
        self.display.tell_painted()
