"""The live tactile map under the hand: presses on it become pokes at body points, selections of taxels, or edits.

``EditableMap`` hands presses, wheel and keys to the active edit tool and says what is under the pointer for it;
``MapView`` routes all gestures: poke, select, edit, pan, zoom, hover.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from PySide6.QtCore import QEvent, QPointF, Qt, Signal
from PySide6.QtGui import QFocusEvent, QKeyEvent, QMouseEvent, QPainter, QWheelEvent
from PySide6.QtWidgets import QWidget

from app.core.arrays import BoolArray, FloatArray, IntArray
from app.geometry.mesh import SurfacePoint
from app.session.prepare import PreparedScene
from widgets.common.colours import PressureScale, Theme
from widgets.common.tool_kinds import ToolKind
from widgets.interaction.poke_gesture import Moved, Panned, PokeEvent, PokeGesture, PokeState, Pressed, Released
from widgets.interaction.select_gesture import Pixel, RubberBand, TaxelSelector
from widgets.interaction.view_tool import PointerHit, ShortcutOverrideFilter, ViewTool
from widgets.map_view.live_image import ImageAtlas
from widgets.map_view.map_coordinates import nearest_taxel
from widgets.map_view.map_display import MapDisplay


class EditableMap(MapDisplay):
    """Hands presses, the wheel and keys to a tool; decides nothing.

    Args:
        theme: Colours of everything that is not skin.
        scale: Colours of pressure.
        parent: Qt parent.

    Attributes:
        view_tool: The one in the hand, or None.
    """

    def __init__(self, theme: Theme, scale: PressureScale, parent: QWidget | None = None) -> None:
        super().__init__(theme, scale, parent)
        self.view_tool: ViewTool | None = None
        self._editing, self._place, self._keys = False, PointerHit(None, None, 1.0), ShortcutOverrideFilter(self)

    def _at(self, position: QPointF) -> SurfacePoint | None:
        """The place of the skin under a pixel; None beside the patches, and under a message."""
        if self._picture is None or self._card.isVisible():
            return None
        place = self.scene_point(position)
        return self._picture.hit(place.x(), place.y())

    def _place_at(self, position: QPointF, at: SurfacePoint | None) -> PointerHit:
        if self._picture is None or self._card.isVisible():
            return PointerHit(None, None, 1.0)
        scene, frame = self.scene_point(position), self._picture.shapes.frame
        return PointerHit(at, frame.to_map(np.array([scene.x(), scene.y()])), self._pixel())

    def _pixel(self) -> float:
        """Side of a pixel on the map [m]."""
        return (
            1.0 if self._picture is None else 1.0 / (self._picture.shapes.frame.scale * self.viewportTransform().m11())
        )

    def _press_edit(self, event: QMouseEvent, at: SurfacePoint | None) -> bool:
        """Whether the edit tool has taken the press."""
        if self.view_tool is None or event.button() != Qt.MouseButton.LeftButton:
            return False
        self._place = self._place_at(event.position(), at)
        self._editing = self._place.point is not None and self.view_tool.press(self._place, event)
        return self._editing

    def _paint_over(self, painter: QPainter) -> None:
        if self.view_tool is not None:
            self.view_tool.paint(painter, self._to_pixels, self._theme)

    def _to_pixels(self, points: FloatArray) -> FloatArray:
        """Map points (k, 2) [m] as pixels of the viewport."""
        if self._picture is None:
            return np.zeros((0, 2))
        view = self.viewportTransform()
        return self._picture.shapes.frame.to_scene(points) * [view.m11(), view.m22()] + [view.dx(), view.dy()]

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Qt: the tool's, where it has something to turn there; else it zooms."""
        place = self._place_at(event.position(), None)
        if self.view_tool is not None and self.view_tool.wheel(place, event):
            event.accept()
        else:
            super().wheelEvent(event)


_POKES = "Press a patch to poke the robot there. Drag beside the patches to pan."
_CHOOSES = "Click taxels or draw around them to select them. Escape selects none."
_EDITS = "Edit the map with the active tool. Drag with the middle button, or with Space, to pan."
_LEADS = "Draw the reference path or target. Drag with the middle button, or with Space, to pan."


class MapView(EditableMap):
    """Emits what the hand does on the map; decides nothing.

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
    cleared = Signal()
    """Escape, while nothing else was going on."""

    def __init__(self, theme: Theme, scale: PressureScale, parent: QWidget | None = None) -> None:
        super().__init__(theme, scale, parent)
        self._hand, self._tool, self._space = PokeGesture(), ToolKind.POKE, False
        self._hover: SurfacePoint | None = None
        self.taxel_selector = TaxelSelector(self, self)
        self.taxel_selector.drawn.connect(self.viewport().update)
        self.setAccessibleDescription(_POKES)
        self.show_empty()

    def show_prepared(self, prepared: PreparedScene, *, atlas: ImageAtlas | None = None) -> None:
        """Show the map of ``prepared``, framed; ``atlas`` saves building its live image here."""
        self._cancel_gesture()
        super().show_prepared(prepared, atlas=atlas)
        self._hover_at(None)

    def set_tool(self, tool: ToolKind) -> None:
        """Take another tool; what the hand was doing ends."""
        self._cancel_gesture()
        self._tool = tool
        self.taxel_selector.set_tool(tool)
        kinds = ((tool.edits, _EDITS), (tool.leads, _LEADS), (tool.chooses, _CHOOSES), (True, _POKES))
        self.setAccessibleDescription(next(words for holds, words in kinds if holds))
        self._show_cursor()

    def set_view_tool(self, tool: ViewTool | None) -> None:
        """Give presses of the left button, and keys, to ``tool``; what the one before was doing is given up."""
        self._cancel_gesture()
        if self.view_tool is not None:
            self.view_tool.drawn.disconnect(self.viewport().update)
        self.view_tool = self._keys.tool = tool
        if tool is not None:
            tool.drawn.connect(self.viewport().update)
        self._show_cursor()
        self.viewport().update()

    def _show_card(self, heading: str, text: str, *, button: str, progress: float | None = None) -> None:
        self._cancel_gesture()
        super()._show_card(heading, text, button=button, progress=progress)

    def _refresh(self) -> None:
        super()._refresh()
        self._read_out()

    # Where things are, for choosing.

    def taxel_at(self, pixel: Pixel) -> int | None:
        """The taxel nearest to a pixel of a patch; None beside the patches."""
        at = self._at(QPointF(*pixel))
        return None if at is None or self._picture is None else nearest_taxel(self._picture.map, at)

    def hidden(self, taxels: IntArray) -> BoolArray:
        """Nothing hides anything on a map."""
        return np.zeros(len(taxels), bool)

    def rubber_band(self) -> RubberBand:
        """What the gesture draws over the map."""
        return self.taxel_selector.rubber_band

    # The hand.

    def _act(self, act: PokeEvent | None) -> None:
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

    def _cancel_gesture(self, *, discard_drawing: bool = True) -> bool:
        """End any gesture, and with ``discard_drawing`` what an edit tool keeps between presses; whether it did."""
        editing, self._editing = self._editing, False
        busy = self._hand.mode is not PokeState.IDLE or self.taxel_selector.busy or editing
        self._act(self._hand.cancel())
        self.taxel_selector.cancel()
        if self.view_tool is not None and (discard_drawing or editing):
            busy = self.view_tool.cancel() or busy
        return busy

    def _hover_at(self, at: SurfacePoint | None) -> None:
        if at == self._hover:
            return
        self._hover = at
        self.set_hover(None if self._hand.mode is PokeState.POKING else at)
        self._read_out()
        self._show_cursor()
        self.hovered.emit(at)

    def _read_out(self) -> None:
        words = self.words_for(self._hover)
        if words != self._marks.readout:
            self._mark(replace(self._marks, readout=words))
            self.readout.emit(words)

    def _show_cursor(self) -> None:
        shape = Qt.CursorShape.ArrowCursor
        if self._hand.mode is PokeState.PANNING:
            shape = Qt.CursorShape.ClosedHandCursor
        elif self._space and not self._editing:
            shape = Qt.CursorShape.OpenHandCursor
        elif self.view_tool is not None:
            shape = self.view_tool.cursor(self._place)
        elif self._tool.chooses or self._hover is not None:
            shape = Qt.CursorShape.CrossCursor
        self.viewport().setCursor(shape)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Qt: poke on a patch or choose taxels; pan beside it, or anywhere with the middle button or Space."""
        if event.button() not in (Qt.MouseButton.LeftButton, Qt.MouseButton.MiddleButton):
            return
        pan = self._space or event.button() == Qt.MouseButton.MiddleButton
        at = self._at(event.position())
        self._hover_at(at)
        if self._hand.mode is not PokeState.IDLE or self.taxel_selector.busy or self._editing:
            return
        if self._tool.chooses and not pan:
            if self._picture is not None and not self._card.isVisible():
                self.taxel_selector.press(event)
        elif self._tool.draws and not pan and self._press_edit(event, at):
            self._hover_at(None)
        else:
            pan = pan or self._tool.draws
            self._act(self._hand.press(event.position().toTuple(), at, button=event.button(), pan=pan))

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Qt: stroke, choose, edit, pan or hover."""
        at = self._at(event.position())
        self._act(self._hand.move(event.position().toTuple(), at))
        if self._tool.chooses:
            self.taxel_selector.move(event)
        self._place = self._place_at(event.position(), at)
        if self.view_tool is not None and self._hand.mode is PokeState.IDLE:
            self.view_tool.move(self._place, event)
            self._show_cursor()
        self._hover_at(None if self._editing else at)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """Qt: the hold ends with the button that began it."""
        self._act(self._hand.release(event.button()))
        if self._tool.chooses:
            self.taxel_selector.release(event)
        if self._editing and self.view_tool is not None and event.button() == Qt.MouseButton.LeftButton:
            self._editing = False
            at = self._at(event.position())
            self._place = self._place_at(event.position(), at)
            self.view_tool.release(self._place, event)
            self._show_cursor()
            self._hover_at(self._at(event.position()))

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        """Qt: frame all beside the patches; on a patch, or with an edit tool, a second quick press is one more."""
        beside = event.button() == Qt.MouseButton.LeftButton and self._at(event.position()) is None
        if beside and self.view_tool is None:
            self.frame_all()
        else:
            self.mousePressEvent(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Qt: Escape ends what the hand does, or selects nothing; Space makes the hand pan; a tool has its own keys."""
        escape = event.key() == Qt.Key.Key_Escape
        if escape and self._cancel_gesture():
            return
        if self.view_tool is not None and self.view_tool.key(event):
            return
        if escape:
            self.cleared.emit()
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
        self._cancel_gesture(discard_drawing=False)
        super().focusOutEvent(event)

    def leaveEvent(self, event: QEvent) -> None:
        """Qt: nothing is under the pointer."""
        self._hover_at(None)
        self.taxel_selector.leave()
        if self.view_tool is not None:
            self.view_tool.leave()
        super().leaveEvent(event)
