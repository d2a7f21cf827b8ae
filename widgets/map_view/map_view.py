"""The live tactile map under the hand: presses on it become pokes at body points, or choices of taxels."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from PySide6.QtCore import QEvent, QPointF, Qt, Signal
from PySide6.QtGui import QFocusEvent, QKeyEvent, QMouseEvent
from PySide6.QtWidgets import QWidget

from app.arrays import BoolArray, IntArray
from app.geometry.surface_point import SurfacePoint
from app.session.prepare import Prepared
from widgets.chooser import Chooser, Rubber
from widgets.colours import PressureScale, Theme
from widgets.edit_tool import EditTool
from widgets.hand import Act, Hand, Mode, Moved, Panned, Pressed, Released
from widgets.map_view.atlas import Atlas
from widgets.map_view.edited_map import EditedMap
from widgets.map_view.map_hit import nearest_taxel
from widgets.select_hand import Pixel
from widgets.tools import Tool

_POKES = "Press a patch to poke the robot there. Drag beside the patches to pan."
_CHOOSES = "Click taxels or draw around them to select them. Escape selects none."
_EDITS = "Edit the map with the tool in the hand. Drag with the middle button, or with Space, to pan."
_LEADS = "Draw where the arm is to lead the contact. Drag with the middle button, or with Space, to pan."


class MapView(EditedMap):
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
        self._hand, self._tool, self._space = Hand(), Tool.POKE, False
        self._hover: SurfacePoint | None = None
        self.chooser = Chooser(self, self)
        self.chooser.drawn.connect(self.viewport().update)
        self.setAccessibleDescription(_POKES)
        self.show_empty()

    def show_prepared(self, prepared: Prepared, *, atlas: Atlas | None = None) -> None:
        """Show the map of ``prepared``, framed; ``atlas`` saves building its live image here."""
        self._end_hold()
        super().show_prepared(prepared, atlas=atlas)
        self._hover_at(None)

    def set_tool(self, tool: Tool) -> None:
        """Take another tool; what the hand was doing ends."""
        self._end_hold()
        self._tool = tool
        self.chooser.set_tool(tool)
        kinds = ((tool.edits, _EDITS), (tool.leads, _LEADS), (tool.chooses, _CHOOSES), (True, _POKES))
        self.setAccessibleDescription(next(words for holds, words in kinds if holds))
        self._show_cursor()

    def set_edit_tool(self, tool: EditTool | None) -> None:
        """Give presses of the left button, and keys, to ``tool``; what the one before was doing is given up."""
        self._end_hold()
        if self.edit_tool is not None:
            self.edit_tool.drawn.disconnect(self.viewport().update)
        self.edit_tool = self._keys.tool = tool
        if tool is not None:
            tool.drawn.connect(self.viewport().update)
        self._show_cursor()
        self.viewport().update()

    def _tell(self, heading: str, text: str, *, button: str, progress: float | None = None) -> None:
        self._end_hold()
        super()._tell(heading, text, button=button, progress=progress)

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

    def rubber(self) -> Rubber:
        """What the gesture draws over the map."""
        return self.chooser.rubber

    # The hand.

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

    def _end_hold(self, *, all_of_it: bool = True) -> bool:
        """Whatever the hand does ends, and ``all_of_it`` what an edit tool keeps between presses; whether it did."""
        editing, self._editing = self._editing, False
        busy = self._hand.mode is not Mode.IDLE or self.chooser.busy or editing
        self._act(self._hand.cancel())
        self.chooser.cancel()
        if self.edit_tool is not None and (all_of_it or editing):
            busy = self.edit_tool.cancel() or busy
        return busy

    def _hover_at(self, at: SurfacePoint | None) -> None:
        if at == self._hover:
            return
        self._hover = at
        self.set_hover(None if self._hand.mode is Mode.POKING else at)
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
        if self._hand.mode is Mode.PANNING:
            shape = Qt.CursorShape.ClosedHandCursor
        elif self._space and not self._editing:
            shape = Qt.CursorShape.OpenHandCursor
        elif self.edit_tool is not None:
            shape = self.edit_tool.cursor(self._place)
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
        if self._hand.mode is not Mode.IDLE or self.chooser.busy or self._editing:
            return
        if self._tool.chooses and not pan:
            if self._picture is not None and not self._card.isVisible():
                self.chooser.press(event)
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
            self.chooser.move(event)
        self._place = self._place_at(event.position(), at)
        if self.edit_tool is not None and self._hand.mode is Mode.IDLE:
            self.edit_tool.move(self._place, event)
            self._show_cursor()
        self._hover_at(None if self._editing else at)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """Qt: the hold ends with the button that began it."""
        self._act(self._hand.release(event.button()))
        if self._tool.chooses:
            self.chooser.release(event)
        if self._editing and self.edit_tool is not None and event.button() == Qt.MouseButton.LeftButton:
            self._editing = False
            at = self._at(event.position())
            self._place = self._place_at(event.position(), at)
            self.edit_tool.release(self._place, event)
            self._show_cursor()
            self._hover_at(self._at(event.position()))

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        """Qt: frame all beside the patches; on a patch, or with an edit tool, a second quick press is one more."""
        beside = event.button() == Qt.MouseButton.LeftButton and self._at(event.position()) is None
        if beside and self.edit_tool is None:
            self.frame_all()
        else:
            self.mousePressEvent(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Qt: Escape ends what the hand does, or selects nothing; Space makes the hand pan; a tool has its own keys."""
        escape = event.key() == Qt.Key.Key_Escape
        if escape and self._end_hold():
            return
        if self.edit_tool is not None and self.edit_tool.key(event):
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
        self._end_hold(all_of_it=False)
        super().focusOutEvent(event)

    def leaveEvent(self, event: QEvent) -> None:
        """Qt: nothing is under the pointer."""
        self._hover_at(None)
        self.chooser.leave()
        if self.edit_tool is not None:
            self.edit_tool.leave()
        super().leaveEvent(event)
