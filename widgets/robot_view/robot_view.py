"""The live robot under the hand: shows frames, and turns presses on the skin into pokes at body points."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from PySide6.QtCore import QEvent, QObject, QPointF, Qt, Signal
from PySide6.QtGui import QFocusEvent, QKeyEvent, QMouseEvent, QResizeEvent, QWheelEvent
from PySide6.QtWidgets import QWidget

from app.arrays import BoolArray, FloatArray, IntArray
from app.geometry.surface_point import SurfacePoint
from app.session.prepare import Prepared
from widgets.chooser import Chooser
from widgets.colours import PressureScale, Theme
from widgets.hand import Act, Hand, Mode, Moved, Panned, Pressed, Released
from widgets.robot_view.body_taxels import BodyTaxels
from widgets.robot_view.morph_slider import MorphSlider
from widgets.robot_view.orbit import face, orbit, pan, zoom
from widgets.robot_view.orientation_cube import CubeFace
from widgets.robot_view.pick import SkinPicker
from widgets.robot_view.robot_canvas import RobotCanvas
from widgets.select_hand import Pixel
from widgets.state_card import StateCard
from widgets.tools import Tool

_WHEEL_STEP = 1.15
_CUBE_ROOM = 78
"""Width that the orientation cube takes in the lower right corner [px]."""


class RobotView(RobotCanvas):
    """Draws the robot and emits what the hand did; decides nothing.

    Left presses poke the skin, or choose taxels, and turn the view beside it; middle or with Shift they pan; the wheel
    zooms; a click on the orientation cube looks from that side, a double click beside the skin frames the robot.

    Args:
        theme: Colours of everything that is not skin.
        scale: Colours of pressure.
        parent: Qt parent.
    """

    poke_pressed = Signal(object)
    """A press on skin: the SurfacePoint under it."""
    poke_moved = Signal(object)
    """A stroke of the pressed finger: the SurfacePoint it is at now."""
    poke_released = Signal()
    """The finger left."""
    hovered = Signal(object)
    """The SurfacePoint under the pointer, or None."""
    open_requested = Signal()
    """The button of the empty or failed state was pressed."""
    cancel_requested = Signal()
    """The button of the loading state was pressed."""
    cleared = Signal()
    """Escape, while nothing else was going on."""

    def __init__(self, theme: Theme, scale: PressureScale, parent: QWidget | None = None) -> None:
        super().__init__(theme, scale, parent)
        self._picker: SkinPicker | None = None
        self._taxels: BodyTaxels | None = None
        self._hand, self._button, self._tool = Hand(), Qt.MouseButton.NoButton, Tool.POKE
        self._hover: SurfacePoint | None = None
        self._loading = self._on_cube = False
        self.chooser = Chooser(self, self)
        self.chooser.drawn.connect(self._on_rubber_drawn)
        self.canvas.widget.installEventFilter(self)
        self.morph = MorphSlider(self)
        self.morph.moved.connect(self._on_morphed)
        self._card = StateCard(self)
        self._card.helped.connect(self._on_card_helped)
        self.setObjectName("robot-view")
        self.setAccessibleName("Robot")
        self.setAccessibleDescription("Press the skin to poke it. Drag beside it to turn the view.")
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setMinimumSize(200, 200)
        self.show_empty()

    # What is shown.

    def show_prepared(self, prepared: Prepared) -> None:
        """Show the robot of ``prepared`` at home, framed; if it cannot be, the last one stays."""
        self._end_hold()
        picker = SkinPicker(prepared)
        self._hover_at(None)
        self.morph.reset()
        self._card.hide()
        self.show_robot(prepared)
        self.morph.show()
        self._picker, self._taxels = picker, BodyTaxels(prepared, picker)

    def set_tool(self, tool: Tool) -> None:
        """Take another tool; what the hand was doing ends."""
        self._end_hold()
        self._tool = tool
        self.chooser.set_tool(tool)
        self._show_cursor()

    def show_empty(self) -> None:
        """Say what would fill the view."""
        text = "Open a robot, or drop its file here: MJCF, URDF or a bare mesh."
        self._tell("No robot yet", text, button="Open robot…")

    def show_loading(self, text: str, progress: float) -> None:
        """Say that a robot is being made: ``text`` names the stage, ``progress`` runs from 0 to 1."""
        self._tell("Preparing the robot", text, button="Cancel", progress=progress)

    def show_failed(self, text: str) -> None:
        """Say why there is no robot."""
        self._tell("The robot could not be opened", text, button="Open robot…")

    def show_last(self) -> None:
        """Go back to the last good robot after loading another one failed or was cancelled."""
        if self.prepared is None:
            self.show_empty()
        else:
            self._card.hide()
            self.request()

    def close_view(self) -> None:
        """Give the graphics back; the view draws nothing after this."""
        self._end_hold()
        self.canvas.widget.removeEventFilter(self)
        self._picker = self._taxels = None
        super().close_view()

    def _tell(self, heading: str, text: str, *, button: str, progress: float | None = None) -> None:
        self._end_hold()
        self._loading = progress is not None
        self._card.setGeometry(self.rect())
        self._card.say(heading, text, button=button, progress=progress)

    def _on_card_helped(self) -> None:
        (self.cancel_requested if self._loading else self.open_requested).emit()

    def request(self, *, moving: bool = False) -> None:
        """Draw soon, unless a message covers the view."""
        if not self._card.isVisible():
            super().request(moving=moving)

    # Where things are, for choosing.

    def taxel_pixels(self) -> FloatArray:
        """(taxels, 2) where those are that face the eye [px]; NaN for the others."""
        if self._taxels is None:
            return np.zeros((0, 2))
        return self._taxels.pixels(self.scene.viewpoint, (self.width(), self.height()), self.scene.poses)

    def hidden(self, taxels: IntArray) -> BoolArray:
        """(k,) which of these the robot itself hides."""
        if self._taxels is None:
            return np.zeros(0, bool)
        return self._taxels.hidden(taxels, self.scene.viewpoint, self.scene.poses)

    def taxel_at(self, pixel: Pixel) -> int | None:
        """The taxel nearest to the skin under a pixel; None beside the skin."""
        at = self._at(QPointF(*pixel))
        return None if at is None or self._taxels is None else self._taxels.nearest(at)

    def _on_morphed(self, share: float) -> None:
        self._end_hold()
        self.scene.morph(share)
        self.request(moving=True)

    def _on_rubber_drawn(self) -> None:
        self._say(replace(self._captions, rubber=self.chooser.rubber))

    # The hand.

    def _at(self, position: QPointF) -> SurfacePoint | None:
        if self._picker is None or self._card.isVisible() or self.scene.morphed:
            return None  # there is no pressing a skin that is off the body
        ray = self.scene.viewpoint.ray((position.x(), position.y()), (self.width(), self.height()))
        return self._picker.pick(ray, self.scene.poses)

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
            move = orbit if self._button == Qt.MouseButton.LeftButton else pan
            self.look(move(self.scene.viewpoint, act.dx, act.dy, self.height()))
        self._show_cursor()

    def _end_hold(self) -> None:
        self._act(self._hand.cancel())
        self.chooser.cancel()

    def _hover_at(self, at: SurfacePoint | None) -> None:
        if at != self._hover:
            self._hover = at
            self.set_hover(None if self._hand.mode is Mode.POKING else at)
            self._show_cursor()
            self.hovered.emit(at)

    def _cube_at(self, position: QPointF) -> CubeFace | None:
        return None if self.prepared is None or self._card.isVisible() else self._overlay.cube_face_at(position)

    def _show_cursor(self) -> None:
        shape = Qt.CursorShape.PointingHandCursor if self._on_cube else Qt.CursorShape.OpenHandCursor
        if self._hand.mode is Mode.PANNING:
            shape = Qt.CursorShape.ClosedHandCursor
        elif self._hover is not None or self._hand.mode is Mode.POKING:
            shape = Qt.CursorShape.CrossCursor
        self.canvas.widget.setCursor(shape)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Qt: all of the canvas's mouse and wheel; the canvas's own handling never sees them."""
        if isinstance(event, QMouseEvent):
            self._mouse(event)
            return True
        if isinstance(event, QWheelEvent):
            self.look(zoom(self.scene.viewpoint, _WHEEL_STEP ** (event.angleDelta().y() / 120)))
            return True
        if event.type() == QEvent.Type.Leave:
            self._hover_at(None)
            self.chooser.leave()
        return False

    def _mouse(self, event: QMouseEvent) -> None:
        kind = event.type()
        if kind == QEvent.Type.MouseButtonPress:
            self._press(event)
        elif kind == QEvent.Type.MouseMove:
            self._on_cube = self._hand.mode is Mode.IDLE and self._cube_at(event.position()) is not None
            at = None if self._hand.mode is Mode.PANNING or self._on_cube else self._at(event.position())
            self._act(self._hand.move(event.position().toTuple(), at))
            if self._tool.chooses:
                self.chooser.move(event)
            self._hover_at(at)
            self._show_cursor()
        elif kind == QEvent.Type.MouseButtonRelease:
            self._act(self._hand.release(event.button()))
            if self._tool.chooses:
                self.chooser.release(event)
        elif event.button() == Qt.MouseButton.LeftButton and self._at(event.position()) is None:
            self.frame_all()
        else:  # on the skin a second quick press is a second poke
            self._press(event)

    def _press(self, event: QMouseEvent) -> None:
        self.setFocus(Qt.FocusReason.MouseFocusReason)
        left = event.button() == Qt.MouseButton.LeftButton
        side = self._cube_at(event.position()) if left and self._hand.mode is Mode.IDLE else None
        if side is not None:
            self.look(face(self.scene.viewpoint, side.normal))
            return
        at = self._at(event.position()) if left else None
        if self._tool.chooses and left and self._hand.mode is Mode.IDLE and (at is not None or self.chooser.busy):
            self.chooser.press(event)
        elif not self.chooser.busy:
            turns = left and not event.modifiers() & Qt.KeyboardModifier.ShiftModifier
            self._button = Qt.MouseButton.LeftButton if turns else Qt.MouseButton.MiddleButton
            at = at if turns else None
            self._act(self._hand.press(event.position().toTuple(), at, button=event.button(), pan=at is None))

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Qt: Escape ends what the hand does, or selects nothing; F frames the robot."""
        if event.key() == Qt.Key.Key_Escape:
            busy = self._hand.mode is not Mode.IDLE or self.chooser.busy
            self._end_hold()
            if not busy:
                self.cleared.emit()
        elif event.key() == Qt.Key.Key_F and not event.modifiers():
            self.frame_all()
        else:
            super().keyPressEvent(event)

    def focusOutEvent(self, event: QFocusEvent) -> None:
        """Qt: a finger never stays pressed where no hand can lift it."""
        self._end_hold()
        super().focusOutEvent(event)

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Qt: the message keeps covering the view."""
        super().resizeEvent(event)
        self._card.setGeometry(self.rect())
        self.morph.move(self.width() - self.morph.width() - _CUBE_ROOM, self.height() - self.morph.height() - 11)
