"""The tool that arranges patches by hand: select, move, scale and turn them, each gesture one step, live."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from PySide6.QtCore import QObject, QPointF, Qt
from PySide6.QtGui import QKeyEvent, QMouseEvent, QPainter

from app.arrays import FloatArray
from app.editing.arrange import move
from app.editing.document import MapDocument
from app.editing.patches import show
from widgets.body_marks import NO_MARKS, BodyLine, BodyMarks, Role
from widgets.chooser import change_of
from widgets.colours import Theme
from widgets.edit_tool import EditTool, Place, ToPixels
from widgets.editor import Editor
from widgets.map_view.arrange_drag import Act, Grip, dragged
from widgets.map_view.arrange_frame import TURN, ArrangeFrame, outline
from widgets.map_view.arrange_marks import ArrangeMarks, paint_arrange
from widgets.select_hand import CLICK_PX, inside
from widgets.tools import Change

_HINT = (
    "Drag a patch to move it, a corner to scale it, the round handle to turn it. Shift: along one axis, about the "
    "middle, by 15°; Control does not snap. Arrow keys move by 1 mm, with Shift by 10."
)
NUDGE = 1e-3
"""By how much an arrow key moves [m]; with Shift ten times as much."""
_ARROWS = {
    Qt.Key.Key_Left: (-1.0, 0.0),
    Qt.Key.Key_Right: (1.0, 0.0),
    Qt.Key.Key_Up: (0.0, 1.0),
    Qt.Key.Key_Down: (0.0, -1.0),
}
_SHIFT, _CONTROL = Qt.KeyboardModifier.ShiftModifier, Qt.KeyboardModifier.ControlModifier


@dataclass(frozen=True, eq=False)
class _Press:
    """How a gesture began.

    Attributes:
        act: What dragging does.
        point: (2,) of the map [m]; None on the body.
        pixel: Where in the view.
        patch: The patch under it.
        adds: Whether Control or Shift was held.
        selected: The patches that were selected before.
        grip: What is edited; None where a drag edits nothing.
    """

    act: Act
    point: FloatArray | None
    pixel: QPointF
    patch: int | None
    adds: bool
    selected: tuple[int, ...]
    grip: Grip | None


class ArrangeTool(EditTool):
    """Moves, scales and turns patches on the map; on the body it selects them.

    Args:
        editor: Whose document is edited, and where the selected patches are known.
        parent: Qt parent.
    """

    hint = _HINT

    def __init__(self, editor: Editor, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._editor = editor
        self._press: _Press | None = None
        self._dragging = False
        self._hovered: int | None = None
        self._marks = ArrangeMarks()
        self._body: tuple[tuple[object, ...], BodyMarks] = ((), NO_MARKS)
        for changed in (editor.shown, editor.selection_changed, editor.enabled_changed):
            changed.connect(self._on_changed)
        editor.settled.connect(self._on_settled)

    # The mouse.

    def point_at(self, number: int | None) -> None:
        """Outline a patch that is pointed at elsewhere; None for none."""
        self._hovered = number
        self.drawn.emit()

    def press(self, place: Place, event: QMouseEvent) -> bool:
        """A handle, a patch or nothing is under it: a drag will scale or turn, move, or select."""
        document = self._editor.document
        if document is None or not self._editor.enabled or self._press is not None:
            return False
        adds, before = change_of(event.modifiers()) is Change.ADD, self._editor.selected
        handle, patch = self._handle_at(place), None if place.at is None else place.at.patch
        if handle is not None:
            act, patch = (Act.TURN if handle == TURN else Act.SCALE), None
        elif patch is not None:
            act = Act.MOVE
            if patch not in before:
                self._editor.select((*before, patch) if adds else (patch,))
        else:
            act = Act.BOX
        grip = self._grip(act, document, place.point, handle or 0)
        self._press = _Press(act, place.point, event.position(), patch, adds, before, grip)
        self._dragging = False
        return True

    def _grip(self, act: Act, document: MapDocument, point: FloatArray | None, corner: int) -> Grip | None:
        numbers = self._shown()
        frame = ArrangeFrame.around(document, numbers)
        if act is Act.BOX or frame is None or point is None:
            return None
        return Grip(act, document, numbers, frame, point, corner)

    def move(self, place: Place, event: QMouseEvent) -> None:
        """Go on with the gesture, or tell what a press would take."""
        press = self._press
        if press is None:
            self._hover(place, event.position())
            return
        away = event.position() - press.pixel
        begins = not self._dragging and np.hypot(away.x(), away.y()) > CLICK_PX
        if begins and press.point is not None:
            self._dragging = True
            if press.grip is not None and not self._editor.begin(press.act.value):
                self._forget()
                return
        if self._dragging and place.point is not None:
            self._drag(press, place.point, place.pixel, event)

    def release(self, place: Place, event: QMouseEvent) -> None:
        """The gesture is done: one step. Without a drag it was a click, which selects."""
        press, dragging = self._forget()
        away = QPointF() if press is None else event.position() - press.pixel
        if dragging:
            self._editor.end()
        elif press is not None and np.hypot(away.x(), away.y()) <= CLICK_PX:
            self._click(press)
        self._hover(place, event.position())

    def cancel(self) -> bool:
        """Give the gesture up: everything as it was before the press."""
        press, dragging = self._forget()
        if press is not None and dragging and press.grip is None:
            self._editor.select(press.selected)
        elif dragging:
            self._editor.cancel()
        return press is not None

    def leave(self) -> None:
        """Nothing is under the pointer."""
        if self._press is None:
            self._hovered, self._marks = None, ArrangeMarks()
            self.drawn.emit()

    def _click(self, press: _Press) -> None:
        if press.patch is None:
            if press.act is Act.BOX and not press.adds:
                self._editor.select(())
        elif not press.adds:
            self._editor.select((press.patch,))
        elif press.patch in press.selected:
            self._editor.select(number for number in press.selected if number != press.patch)

    def _drag(self, press: _Press, point: FloatArray, pixel: float, event: QMouseEvent) -> None:
        if press.grip is None:
            self._sweep(press, point)
        elif self._editor.gesture:
            shift, control = bool(event.modifiers() & _SHIFT), bool(event.modifiers() & _CONTROL)
            edit, self._marks = dragged(press.grip, point, pixel, shift=shift, control=control)
            self._editor.change(edit)
        else:  # it was undone, or edits are no longer taken
            self._forget()
            return
        self._marks = self._marks.at(event.position())
        self.drawn.emit()

    def _sweep(self, press: _Press, end: FloatArray) -> None:
        document = self._editor.document
        if document is None or press.point is None:
            return
        start = press.point
        box = np.array([start, [end[0], start[1]], end, [start[0], end[1]]])
        swept = [number for number in self._seen(document) if _meets(box, outline(document, number))]
        self._editor.select((*press.selected, *swept) if press.adds else swept)
        self._marks = ArrangeMarks(box=box)

    def _forget(self) -> tuple[_Press | None, bool]:
        """No gesture any more; how it began, if there was one, and whether it was a drag."""
        press, dragging = self._press, self._dragging
        self._press, self._dragging, self._marks = None, False, ArrangeMarks()
        self.drawn.emit()
        return press, dragging

    def _hover(self, place: Place, pixel: QPointF) -> None:
        handle = self._handle_at(place)
        over = None if place.at is None or handle is not None else place.at.patch
        words = "" if handle is None else "Turn · Shift by 15°" if handle == TURN else "Scale · Shift about the middle"
        if (over, words) != (self._hovered, self._marks.words) or words:
            self._hovered, self._marks = over, ArrangeMarks(words=words).at(pixel)
            self.drawn.emit()

    def _handle_at(self, place: Place) -> int | None:
        document = self._editor.document
        if document is None or place.point is None or not self._editor.enabled:
            return None
        frame = ArrangeFrame.around(document, self._shown())
        return None if frame is None else frame.handle_at(place.point, place.pixel)

    # Keys.

    def key(self, event: QKeyEvent) -> bool:
        """Arrows move, H hides, Alt+H shows all, Escape selects none."""
        held, key = event.modifiers() & ~Qt.KeyboardModifier.KeypadModifier, Qt.Key(event.key())
        shown, nothing = self._shown(), Qt.KeyboardModifier.NoModifier
        if self._press is not None:
            return key in _ARROWS or key == Qt.Key.Key_H
        if key in _ARROWS and shown and held in (nothing, _SHIFT):
            step = NUDGE * (10 if held == _SHIFT else 1)
            self._editor.do("Move", partial(move, numbers=shown, by=step * np.array(_ARROWS[key])))
        elif key == Qt.Key.Key_H and held == Qt.KeyboardModifier.AltModifier:
            self._editor.do("Show all patches", lambda document: show(document, range(len(document.patches))))
        elif key == Qt.Key.Key_H and held == nothing and shown:
            self._editor.do("Hide patches", partial(show, numbers=shown, visible=False))
        elif key == Qt.Key.Key_Escape and self._editor.selected:
            self._editor.select(())
        else:
            return False
        return True

    # What is seen.

    def _shown(self) -> tuple[int, ...]:
        """The selected patches that are seen; the others are not for the hand."""
        document = self._editor.document
        seen = () if document is None else self._seen(document)
        return tuple(number for number in self._editor.selected if number in seen)

    def _seen(self, document: MapDocument) -> tuple[int, ...]:
        return tuple(number for number, patch in enumerate(document.patches) if patch.visible)

    def paint(self, painter: QPainter, to_pixels: ToPixels, theme: Theme) -> None:
        """The selected patches and their frame, the patch under the pointer, guides and the gesture in words."""
        document = self._editor.document
        if document is None:
            return
        numbers = self._shown()
        hovered = self._hovered if self._press is None and self._hovered in self._seen(document) else None
        lines = [outline(document, number) for number in numbers]
        over = outline(document, hovered) if hovered is not None and hovered not in numbers else None
        frame = self._marks.frame or ArrangeFrame.around(document, numbers)
        marks = self._marks if self._editor.enabled else ArrangeMarks()
        paint_arrange(painter, to_pixels, theme, marks, frame if self._editor.enabled else None, lines, over)

    def body_marks(self) -> BodyMarks:
        """The borders of the selected patches."""
        document, numbers = self._editor.document, self._shown()
        key = (numbers, *(() if document is None else (id(document.charts[number].faces) for number in numbers)))
        if document is None or not numbers:
            return NO_MARKS
        if key != self._body[0]:
            rings = [(n, document.charts[n].vertex_of[document.charts[n].border]) for n in numbers]
            lines = tuple(BodyLine(n, np.append(ring, ring[0]), Role.HELD) for n, ring in rings)
            self._body = key, BodyMarks(lines=lines)
        return self._body[1]

    def cursor(self, place: Place) -> Qt.CursorShape:
        """What a press would do, or does."""
        handle = self._handle_at(place)
        act = Act.TURN if handle == TURN else Act.SCALE if handle is not None else None
        corner, over = handle or 0, place.at is not None
        if self._press is not None:
            act, corner = self._press.act, 0 if self._press.grip is None else self._press.grip.corner
        elif act is None and over:
            act = Act.MOVE
        if act is Act.SCALE:
            return Qt.CursorShape.SizeBDiagCursor if corner % 2 == 0 else Qt.CursorShape.SizeFDiagCursor
        if act is Act.TURN:
            return Qt.CursorShape.PointingHandCursor if self._press is None else Qt.CursorShape.ClosedHandCursor
        if act is Act.MOVE:
            return Qt.CursorShape.SizeAllCursor if place.point is not None else Qt.CursorShape.PointingHandCursor
        return Qt.CursorShape.CrossCursor if act is Act.BOX else Qt.CursorShape.ArrowCursor

    def _on_changed(self) -> None:
        self.drawn.emit()

    def _on_settled(self) -> None:
        """A step from elsewhere, as undo by its key, ends what the hand was doing."""
        self._forget()


def _meets(box: FloatArray, line: FloatArray) -> bool:
    """Whether a box (4, 2) and a closed outline (b, 2) have anything in common, as far as their corners tell."""
    return bool(inside(box, line).any() or inside(line, box).any())
