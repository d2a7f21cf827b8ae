"""The live tactile map under the hand: shows frames, and turns presses on it into pokes at body points."""

from __future__ import annotations

from dataclasses import replace

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

from app.geometry.surface_point import SurfacePoint
from app.maps.tactile_image import TactileImage
from app.session.frame import Frame
from app.session.prepare import Prepared
from widgets.colours import PressureScale, Theme
from widgets.map_view.camera import Camera
from widgets.map_view.map_hit import describe, hit
from widgets.map_view.map_items import point
from widgets.map_view.map_painter import MapPainter, Marks
from widgets.map_view.map_picture import MapPicture
from widgets.map_view.map_tools import Act, Hand, Mode, Moved, Panned, Pressed, Released
from widgets.map_view.state_card import StateCard

WHEEL_STEP = 1.2
KEY_PAN_PX = 40.0
_PAN_KEYS = {
    Qt.Key.Key_Left: (KEY_PAN_PX, 0.0),
    Qt.Key.Key_Right: (-KEY_PAN_PX, 0.0),
    Qt.Key.Key_Up: (0.0, KEY_PAN_PX),
    Qt.Key.Key_Down: (0.0, -KEY_PAN_PX),
}
_ZOOM_KEYS = {Qt.Key.Key_Plus: WHEEL_STEP, Qt.Key.Key_Equal: WHEEL_STEP, Qt.Key.Key_Minus: 1 / WHEEL_STEP}


class MapView(QGraphicsView):
    """Draws the map and emits what the hand does on it; decides nothing.

    Args:
        theme: Colours of everything that is not skin.
        scale: Colours of pressure.
        parent: Qt parent.
    """

    poke_pressed = Signal(object)
    """A press on a patch: the SurfacePoint under it."""
    poke_moved = Signal(object)
    poke_released = Signal()
    hovered = Signal(object)
    """The SurfacePoint under the pointer, or None."""
    readout = Signal(str)
    """The words for it; the view shows them too."""
    painted = Signal(int)
    """A frame has reached the screen: its tick."""
    open_requested = Signal()
    """The button of the empty or failed state."""
    cancel_requested = Signal()
    """The button of the loading state."""

    def __init__(self, theme: Theme, scale: PressureScale, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._theme, self._scale = theme, scale
        self._picture: MapPicture | None = None
        self._frame: Frame | None = None
        self._stale = self._unseen = self._space = self._loading = False
        self._marks, self._hand, self._camera = Marks(), Hand(), Camera.framing((1000.0, 1000.0))
        self._button = Qt.MouseButton.NoButton
        self._hover: SurfacePoint | None = None
        self._painter = MapPainter(theme, self.font())
        self._set_up()
        self._card = StateCard(self.viewport())
        self._card.helped.connect(self._on_card_helped)
        self.show_empty()

    def _set_up(self) -> None:
        self.setObjectName("map-view")
        self.setAccessibleName("Tactile map")
        self.setAccessibleDescription("Press a patch to poke the robot there. Drag beside the patches to pan.")
        self.setScene(QGraphicsScene(self))
        self.setInteractive(False)
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setVerticalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setTransformationAnchor(QGraphicsView.ViewportAnchor.NoAnchor)
        self.setResizeAnchor(QGraphicsView.ViewportAnchor.NoAnchor)
        self.setViewportUpdateMode(QGraphicsView.ViewportUpdateMode.FullViewportUpdate)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setMinimumSize(200, 200)
        self.viewport().setMouseTracking(True)
        self.setBackgroundBrush(QColor(self._theme.window))

    # what to show ----------------------------------------------------------------------------------------------------

    def show_prepared(self, prepared: Prepared, *, image: TactileImage | None = None) -> None:
        """Show the map of ``prepared``, framed, until the next one; ``image`` saves building its tactile image."""
        self._end_poke()
        self._hovers(None)
        scene = QGraphicsScene(self)
        picture = MapPicture(prepared.map, self._theme, image=image)
        picture.add_to(scene)
        picture.recolour(self._scale)
        width, height = picture.shapes.frame.size
        scene.setSceneRect(-width - 1e3, -height - 1e3, 3 * width + 2e3, 3 * height + 2e3)
        previous = self.scene()
        self.setScene(scene)
        previous.deleteLater()
        self._picture, self._frame, self._marks = picture, None, replace(Marks(), word=self._marks.word)
        self._card.hide()
        self._look(Camera.framing((width, height)))

    def show_frame(self, frame: Frame) -> None:
        """Show ``frame`` of the prepared scene; while the view is hidden it is only kept."""
        self._frame, self._stale = frame, True
        if self.isVisible():
            self._refresh()

    def _refresh(self) -> None:
        if self._picture is None or self._frame is None or not self._stale:
            return
        frame, picture = self._frame, self._picture
        picture.show(frame, self._scale)
        fingers = [picture.map.to_map(poke.at) for poke in frame.pokes]
        contours = picture.contours() if frame.regions else []
        self._marks = self._marks.of_frame(frame, picture.shapes.frame, fingers, contours)
        self._read_out()
        self._stale, self._unseen = False, True
        self.viewport().update()

    def set_hover(self, at: SurfacePoint | None) -> None:
        """Mark the place that the pointer is over in another view; None for none."""
        if self._picture is None:
            return
        place = None if at is None else point(self._picture.shapes.frame.to_scene(self._picture.map.to_map(at)))
        self._marks = replace(self._marks, hover=place)
        self.viewport().update()

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

    # states ----------------------------------------------------------------------------------------------------------

    def show_empty(self) -> None:
        """Say what would fill the view."""
        self._tell("No tactile map yet", "Open a robot to see its skin laid flat.", button="Open robot…")

    def show_loading(self, text: str, progress: float) -> None:
        """Say that a map is being made: ``text`` names the stage, ``progress`` runs from 0 to 1."""
        self._tell("Making the tactile map", text, button="Cancel", progress=progress)

    def show_failed(self, text: str) -> None:
        """Say why there is no map; a map shown before stays if the caller shows it again."""
        self._tell("There is no tactile map", text, button="Open robot…")

    def set_replaying(self, *, replaying: bool) -> None:
        """Mark everything shown as replayed from a recording, or as live."""
        self._marks = replace(self._marks, word="Replaying" if replaying else "")
        self.viewport().update()

    def _tell(self, heading: str, text: str, *, button: str, progress: float | None = None) -> None:
        self._end_poke()
        self._loading = progress is not None
        self._place_card()
        self._card.say(heading, text, button=button, progress=progress)

    def _on_card_helped(self) -> None:
        (self.cancel_requested if self._loading else self.open_requested).emit()

    def _place_card(self) -> None:
        self._card.setGeometry(self.viewport().rect())
