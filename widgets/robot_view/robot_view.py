"""The live robot under the hand: shows frames, and turns presses on the skin into pokes at body points."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from PySide6.QtCore import QEvent, QObject, QPointF, Qt, QTimer, Signal
from PySide6.QtGui import QKeyEvent, QMouseEvent, QResizeEvent, QShowEvent, QWheelEvent
from PySide6.QtWidgets import QVBoxLayout, QWidget

from app.geometry.surface_point import SurfacePoint
from app.session.frame import Frame
from app.session.prepare import Prepared
from widgets.colours import PressureScale, Theme
from widgets.hand import Act, Hand, Mode, Moved, Panned, Pressed, Released
from widgets.robot_view import orbit
from widgets.robot_view.canvas import make_canvas
from widgets.robot_view.pick import SkinPicker, camera_ray
from widgets.robot_view.robot_scene import RobotScene
from widgets.state_card import StateCard

_SHORTEST_WAIT_MS = 15.0
_WHEEL_STEP = 1.15


class RobotView(QWidget):
    """Draws the robot and emits what the hand did; decides nothing.

    Rendering waits for the event loop, so that the map is painted first, and for twice the time of the last picture, so
    that slow drawing never starves the rest.

    Args:
        theme: Colours of everything that is not skin.
        scale: Colours of pressure.
        parent: Qt parent.
        clock: Seconds, for pacing.
    """

    poke_pressed = Signal(object)
    """A press on skin: the SurfacePoint under it."""
    poke_moved = Signal(object)
    """A stroke of the pressed finger: the SurfacePoint it is at now."""
    poke_released = Signal()
    """The finger left."""
    hovered = Signal(object)
    """The SurfacePoint under the pointer, or None."""
    drawn = Signal(float)
    """A picture was rendered: its milliseconds."""
    open_requested = Signal()
    """The button of the empty or failed state was pressed."""
    cancel_requested = Signal()
    """The button of the loading state was pressed."""

    def __init__(
        self, theme: Theme, scale: PressureScale, parent: QWidget | None = None, *,
        clock: Callable[[], float] = time.perf_counter,
    ) -> None:
        super().__init__(parent)
        self._clock, self._last_ms, self._dirty = clock, 0.0, False
        self._prepared: Prepared | None = None
        self._picker: SkinPicker | None = None
        self._hand, self._button = Hand(), Qt.MouseButton.NoButton
        self._hover: SurfacePoint | None = None
        self._loading = False
        self.canvas = make_canvas(self)
        self.scene = RobotScene(self.canvas.plotter, theme, scale)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self.canvas.widget)
        self.canvas.widget.installEventFilter(self)
        self._card = StateCard(self)
        self._card.helped.connect(self._on_card_helped)
        self._timer = QTimer(self)
        self._timer.setSingleShot(True)
        self._timer.timeout.connect(self._on_timer)
        self.setObjectName("robot-view")
        self.setAccessibleName("Robot")
        self.setAccessibleDescription("Press the skin to poke it. Drag beside it to turn the view.")
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setMinimumSize(200, 200)
        self.show_empty()

    # What is shown.

    def show_prepared(self, prepared: Prepared) -> None:
        """Show the robot of ``prepared`` at home, framed."""
        self._end_hold()
        self._prepared, self._picker = prepared, SkinPicker(prepared)
        self._hover_at(None)
        self.scene.show_prepared(prepared)
        self._card.hide()
        self._refresh()

    def show_frame(self, frame: Frame) -> None:
        """Show ``frame`` of the prepared scene, at the next chance to draw."""
        if self._prepared is not None:
            self.scene.show_frame(frame)
            if self._hover is not None:
                self.scene.set_hover(self._hover if self._hand.mode is Mode.IDLE else None)
            self._refresh()

    def set_hover(self, at: SurfacePoint | None) -> None:
        """Mark the place that the pointer is over in another view; None for none."""
        self.scene.set_hover(at)
        self._refresh()

    def set_theme(self, theme: Theme) -> None:
        """Take another theme."""
        self.scene.set_theme(theme)
        self._refresh()

    def set_scale(self, scale: PressureScale) -> None:
        """Take another pressure scale."""
        self.scene.set_scale(scale)
        self._refresh()

    def frame_all(self) -> None:
        """Look at the whole robot again."""
        self.scene.frame_all()
        self._refresh()

    def show_empty(self) -> None:
        """Say what would fill the view."""
        self._tell("No robot yet", "Open a robot, or drop its file here: MJCF, URDF or a bare mesh.",
                   button="Open robot…")

    def show_loading(self, text: str, progress: float) -> None:
        """Say that a robot is being made: ``text`` names the stage, ``progress`` runs from 0 to 1."""
        self._tell("Preparing the robot", text, button="Cancel", progress=progress)

    def show_failed(self, text: str) -> None:
        """Say why there is no robot."""
        self._tell("The robot could not be opened", text, button="Open robot…")

    def show_last(self) -> None:
        """Go back to the last good robot after loading another one failed or was cancelled."""
        if self._prepared is None:
            self.show_empty()
        else:
            self._card.hide()
            self._refresh()

    def draw_now(self) -> None:
        """Render without waiting; for pictures and tests."""
        self._dirty = True
        self._on_timer()

    def close_view(self) -> None:
        """Give the graphics back; the view draws nothing after this."""
        self._timer.stop()
        self.canvas.widget.removeEventFilter(self)
        self.canvas.close_plotter()

    def _tell(self, heading: str, text: str, *, button: str, progress: float | None = None) -> None:
        self._end_hold()
        self._loading = progress is not None
        self._card.setGeometry(self.rect())
        self._card.say(heading, text, button=button, progress=progress)

    def _on_card_helped(self) -> None:
        (self.cancel_requested if self._loading else self.open_requested).emit()

    def _refresh(self) -> None:
        """Render soon: after what waits in the event loop, and not before twice the last picture's time has passed."""
        self._dirty = True
        if not self._timer.isActive() and self.isVisible():
            self._timer.start(round(max(_SHORTEST_WAIT_MS, self._last_ms)))

    def _on_timer(self) -> None:
        if not self._dirty or not self.isVisible() or self._card.isVisible():
            return
        start = self._clock()
        self.canvas.plotter.renderer.ResetCameraClippingRange()
        self.canvas.draw()
        self._dirty, self._last_ms = False, 1e3 * (self._clock() - start)
        self.drawn.emit(self._last_ms)

    # The hand.

    def pixel_of(self, at: SurfacePoint) -> QPointF:
        """Where a place on the skin is in this view now [px]; it may be hidden behind something."""
        assert self._prepared is not None
        camera, skin = self.canvas.plotter.camera, self._prepared.skin
        pose = self.scene.poses[self._prepared.robot.link_index[skin.link(at)]]
        world = pose[:3, :3] @ skin.position(at) + pose[:3, 3]
        forward = np.array(camera.focal_point) - camera.position
        forward /= np.linalg.norm(forward)
        right = np.cross(forward, camera.up)
        right /= np.linalg.norm(right)
        away = world - camera.position
        scale = self.height() / (2 * np.tan(np.radians(camera.view_angle) / 2) * (away @ forward))
        return QPointF(self.width() / 2 + scale * (away @ right),
                       self.height() / 2 - scale * (away @ np.cross(right, forward)))

    def _at(self, position: QPointF) -> SurfacePoint | None:
        if self._picker is None or self._card.isVisible():
            return None
        camera = self.canvas.plotter.camera
        ray = camera_ray((position.x(), position.y()), (self.width(), self.height()), np.array(camera.position),
                         np.array(camera.focal_point), np.array(camera.up), camera.view_angle)
        return self._picker.pick(ray, self.scene.poses)

    def _act(self, act: Act | None) -> None:
        if isinstance(act, Pressed):
            self.scene.set_hover(None)
            self.poke_pressed.emit(act.at)
        elif isinstance(act, Moved):
            self.poke_moved.emit(act.at)
        elif isinstance(act, Released):
            self.poke_released.emit()
        elif isinstance(act, Panned):
            move = orbit.orbit if self._button == Qt.MouseButton.LeftButton else orbit.pan
            move(self.canvas.plotter.camera, act.dx, act.dy, self.height())
            self._refresh()
        self._show_cursor()

    def _end_hold(self) -> None:
        self._act(self._hand.cancel())

    def _hover_at(self, at: SurfacePoint | None) -> None:
        if at == self._hover:
            return
        self._hover = at
        if self._prepared is not None:
            self.set_hover(None if self._hand.mode is Mode.POKING else at)
        self._show_cursor()
        self.hovered.emit(at)

    def _show_cursor(self) -> None:
        shape = Qt.CursorShape.OpenHandCursor
        if self._hand.mode is Mode.PANNING:
            shape = Qt.CursorShape.ClosedHandCursor
        elif self._hover is not None or self._hand.mode is Mode.POKING:
            shape = Qt.CursorShape.CrossCursor
        self.canvas.widget.setCursor(shape)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Qt: all of the canvas's mouse, wheel and keys; the canvas's own handling never sees them."""
        kind = event.type()
        if isinstance(event, QMouseEvent):
            if kind == QEvent.Type.MouseButtonPress:
                self._press(event)
            elif kind == QEvent.Type.MouseMove:
                at = self._at(event.position()) if self._hand.mode is not Mode.PANNING else None
                self._act(self._hand.move(event.position().toTuple(), at))
                self._hover_at(at)
            elif kind == QEvent.Type.MouseButtonRelease:
                self._act(self._hand.release(event.button()))
            elif kind == QEvent.Type.MouseButtonDblClick:
                self._double_click(event)
            return True
        if isinstance(event, QWheelEvent):
            orbit.zoom(self.canvas.plotter.camera, _WHEEL_STEP ** (event.angleDelta().y() / 120))
            self._refresh()
            return True
        if kind == QEvent.Type.Leave:
            self._hover_at(None)
        return False

    def _press(self, event: QMouseEvent) -> None:
        self.setFocus(Qt.FocusReason.MouseFocusReason)
        shift = bool(event.modifiers() & Qt.KeyboardModifier.ShiftModifier)
        left = event.button() == Qt.MouseButton.LeftButton
        self._button = Qt.MouseButton.LeftButton if left and not shift else Qt.MouseButton.MiddleButton
        at = self._at(event.position()) if left and not shift else None
        self._act(self._hand.press(event.position().toTuple(), at, button=event.button(), pan=at is None))

    def _double_click(self, event: QMouseEvent) -> None:
        if event.button() == Qt.MouseButton.LeftButton and self._at(event.position()) is None:
            self.frame_all()
        else:
            self._press(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Qt: Escape ends a poke, R and F frame the robot."""
        if event.key() == Qt.Key.Key_Escape and self._hand.mode is not Mode.IDLE:
            self._end_hold()
        elif event.key() in (Qt.Key.Key_R, Qt.Key.Key_F) and not event.modifiers():
            self.frame_all()
        else:
            super().keyPressEvent(event)

    def focusOutEvent(self, event: QEvent) -> None:
        """Qt: a finger never stays pressed where no hand can lift it."""
        self._end_hold()
        super().focusOutEvent(event)  # type: ignore[arg-type]

    def showEvent(self, event: QShowEvent) -> None:
        """Qt: catch up with the newest frame."""
        super().showEvent(event)
        self._refresh()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Qt: draw at the new size."""
        super().resizeEvent(event)
        self._card.setGeometry(self.rect())
        self._refresh()
