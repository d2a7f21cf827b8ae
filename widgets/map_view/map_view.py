"""The live tactile map under the hand: shows frames, and turns presses on it into pokes at body points."""

from __future__ import annotations

from dataclasses import replace

from PySide6.QtCore import QEvent, QPointF, QRectF, Qt, Signal
from PySide6.QtGui import QColor, QFocusEvent, QKeyEvent, QMouseEvent, QPainter, QPaintEvent, QResizeEvent, QShowEvent
from PySide6.QtWidgets import QGraphicsScene, QWidget

from app.errors import MapError
from app.geometry.surface_point import SurfacePoint
from app.maps.tactile_image import TactileImage
from app.session.frame import Frame
from app.session.prepare import Prepared
from widgets.colours import PressureScale, Theme
from widgets.hand import Act, Hand, Mode, Moved, Panned, Pressed, Released
from widgets.map_view.map_canvas import MapCanvas
from widgets.map_view.map_hit import describe, hit
from widgets.map_view.map_painter import MapPainter, Marks
from widgets.map_view.map_picture import MapPicture
from widgets.state_card import StateCard


class MapView(MapCanvas):
    """Draws the map and emits what the hand does on it; decides nothing.

    Args:
        theme: Colours of everything that is not skin.
        scale: Colours of pressure.
        parent: Qt parent.
    """

    poke_pressed = Signal(object)
    """A press on a patch: the SurfacePoint under it."""
    poke_moved = Signal(object)
    """A stroke of the pressed finger: the SurfacePoint it is at now."""
    poke_released = Signal()
    """The finger left."""
    hovered = Signal(object)
    """The SurfacePoint under the pointer, or None."""
    readout = Signal(str)
    """The words for it; the view shows them too."""
    painted = Signal(int)
    """A frame has reached the screen: its tick."""
    open_requested = Signal()
    """The button of the empty or failed state was pressed."""
    cancel_requested = Signal()
    """The button of the loading state was pressed."""

    def __init__(self, theme: Theme, scale: PressureScale, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._theme, self._scale = theme, scale
        self._picture: MapPicture | None = None
        self._frame: Frame | None = None
        self._stale = self._unseen = self._loading = self._space = False
        self._marks, self._hand = Marks(), Hand()
        self._hover: SurfacePoint | None = None
        self._painter = MapPainter(theme, self.font())
        self.setObjectName("map-view")
        self.setAccessibleName("Tactile map")
        self.setAccessibleDescription("Press a patch to poke the robot there. Drag beside the patches to pan.")
        self._card = StateCard(self.viewport())
        self._card.helped.connect(self._on_card_helped)
        self.set_theme(theme)
        self.show_empty()

    # What is shown.

    def show_prepared(self, prepared: Prepared, *, image: TactileImage | None = None) -> None:
        """Show the map of ``prepared``, framed; ``image`` saves building its tactile image here."""
        self._end_hold()
        picture = MapPicture(prepared.map, self._theme, image=image)
        picture.recolour(self._scale)
        scene = QGraphicsScene(self)
        picture.add_to(scene)
        self._picture, self._frame, self._marks = (
            picture,
            None,
            Marks(paused=self._marks.paused, replaying=self._marks.replaying),
        )
        self._hover_at(None)
        self._card.hide()
        self.show_scene(scene, picture.shapes.frame.size)

    def show_frame(self, frame: Frame) -> None:
        """Show ``frame`` of the prepared scene; while the view is hidden it is only kept."""
        self._frame, self._stale = frame, True
        if self.isVisible():
            self._refresh()

    def set_hover(self, at: SurfacePoint | None) -> None:
        """Mark the place that the pointer is over in another view; None for none."""
        if self._picture is not None:
            self._mark(replace(self._marks, hover=None if at is None else self._picture.place_of(at)))

    def pixel_of(self, at: SurfacePoint) -> QPointF:
        """Where a body point is drawn in the viewport, finer than a pixel; raises MapError without a map."""
        if self._picture is None:
            raise MapError("there is no map to find the point on", value=at, remedy="Show a prepared scene first")
        return self.viewportTransform().map(self._picture.place_of(at))

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
        self._tell("No tactile map yet", "Open a robot to see its skin laid flat.", button="Open robot…")

    def show_loading(self, text: str, progress: float) -> None:
        """Say that a map is being made: ``text`` names the stage, ``progress`` runs from 0 to 1."""
        self._tell("Making the tactile map", text, button="Cancel", progress=progress)

    def show_failed(self, text: str) -> None:
        """Say why there is no map."""
        self._tell("There is no tactile map", text, button="Open robot…")

    def show_last(self) -> None:
        """Go back to the last good map after loading another one failed or was cancelled."""
        if self._picture is None:
            self.show_empty()
        else:
            self._card.hide()

    def _tell(self, heading: str, text: str, *, button: str, progress: float | None = None) -> None:
        self._end_hold()
        self._loading = progress is not None
        self._card.setGeometry(self.viewport().rect())
        self._card.say(heading, text, button=button, progress=progress)

    def _on_card_helped(self) -> None:
        (self.cancel_requested if self._loading else self.open_requested).emit()

    def _mark(self, marks: Marks) -> None:
        self._marks = marks
        self.viewport().update()

    def _refresh(self) -> None:
        picture, frame = self._picture, self._frame
        if picture is None or frame is None or not self._stale:
            return
        picture.show(frame, self._scale)
        fingers = [picture.map.to_map(poke.at) for poke in frame.pokes]
        contours = picture.contours() if frame.regions else []
        self._mark(self._marks.of_frame(frame, picture.shapes.frame, fingers, contours))
        self._stale, self._unseen = False, True
        self._read_out()

    # The hand.

    def _at(self, position: QPointF) -> SurfacePoint | None:
        if self._picture is None or self._card.isVisible():
            return None
        place = self.scene_point(position)
        return hit(self._picture.map, self._picture.shapes.frame, place.x(), place.y())

    def _act(self, act: Act | None) -> None:
        if isinstance(act, Pressed):
            self.set_hover(None)
            self.poke_pressed.emit(act.at)
        elif isinstance(act, Moved):
            self.poke_moved.emit(act.at)
        elif isinstance(act, Released):
            self.set_hover(self._hover)
            self.poke_released.emit()
        elif isinstance(act, Panned):
            self.pan(act.dx, act.dy)
        self._show_cursor()

    def _end_hold(self) -> None:
        self._act(self._hand.cancel())

    def _hover_at(self, at: SurfacePoint | None) -> None:
        if at == self._hover:
            return
        self._hover = at
        self.set_hover(None if self._hand.mode is Mode.POKING else at)
        self._read_out()
        self._show_cursor()
        self.hovered.emit(at)

    def _read_out(self) -> None:
        words = ""
        if self._hover is not None and self._picture is not None:
            words = describe(self._picture.map, self._hover, self._picture.pressures)
        if words != self._marks.readout:
            self._mark(replace(self._marks, readout=words))
            self.readout.emit(words)

    def _show_cursor(self) -> None:
        shape = Qt.CursorShape.ArrowCursor
        if self._hand.mode is Mode.PANNING:
            shape = Qt.CursorShape.ClosedHandCursor
        elif self._space:
            shape = Qt.CursorShape.OpenHandCursor
        elif self._hover is not None:
            shape = Qt.CursorShape.CrossCursor
        self.viewport().setCursor(shape)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Qt: poke on a patch, pan beside it, or anywhere with the middle button or Space."""
        if event.button() in (Qt.MouseButton.LeftButton, Qt.MouseButton.MiddleButton):
            pan = self._space or event.button() == Qt.MouseButton.MiddleButton
            self._hover_at(self._at(event.position()))
            self._act(self._hand.press(event.position().toTuple(), self._hover, button=event.button(), pan=pan))

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Qt: stroke, pan or hover."""
        at = self._at(event.position())
        self._act(self._hand.move(event.position().toTuple(), at))
        self._hover_at(at)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """Qt: the hold ends with the button that began it."""
        self._act(self._hand.release(event.button()))

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        """Qt: frame all beside the patches; on a patch a second quick press is a second poke."""
        if event.button() == Qt.MouseButton.LeftButton and self._at(event.position()) is None:
            self.frame_all()
        else:
            self.mousePressEvent(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Qt: Escape ends a poke, Space makes the hand pan."""
        if event.key() == Qt.Key.Key_Escape and self._hand.mode is not Mode.IDLE:
            self._end_hold()
        elif event.key() == Qt.Key.Key_Space:
            self._space = True
            self._show_cursor()
        else:
            super().keyPressEvent(event)

    def keyReleaseEvent(self, event: QKeyEvent) -> None:
        """Qt: Space came up."""
        if event.key() == Qt.Key.Key_Space and not event.isAutoRepeat():
            self._space = False
            self._show_cursor()

    def focusOutEvent(self, event: QFocusEvent) -> None:
        """Qt: a finger never stays pressed where no hand can lift it."""
        self._space = False
        self._end_hold()
        super().focusOutEvent(event)

    def leaveEvent(self, event: QEvent) -> None:
        """Qt: nothing is under the pointer."""
        self._hover_at(None)
        super().leaveEvent(event)

    # Qt's drawing.

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
        painter.end()
        if self._unseen and self._frame is not None:
            self._unseen = False
            self.painted.emit(self._frame.tick)
