"""Tool that selects, moves, scales and rotates patches with live preview; each gesture is one undo step.

First the edit that a drag makes of the document at the press; then the tool with mouse, keys and cursor.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from functools import partial

import numpy as np
from PySide6.QtCore import QObject, QPointF, Qt
from PySide6.QtGui import QKeyEvent, QMouseEvent, QPainter

from tactile_maps.core.arrays import FloatArray
from tactile_maps.editing.arrange import Snap, move, rotate, scale, snap_move
from tactile_maps.editing.document import MapDocument
from tactile_widgets.common.colours import Theme
from tactile_widgets.common.tool_kinds import SelectionMode
from tactile_widgets.document.map_editor import MapEditor
from tactile_widgets.tools.map_editing.transform_box import (
    ROTATION_HANDLE,
    ArrangeMarks,
    TransformBox,
    clamped_scale,
    paint_arrange,
    patch_outline,
    snapped_rotation,
)
from tactile_widgets.views.interaction.arrow_keys import ARROWS
from tactile_widgets.views.interaction.polyline import points_in_polygon
from tactile_widgets.views.interaction.select_gesture import CLICK_PX, selection_mode_of
from tactile_widgets.views.interaction.view_tool import PointerHit, ToPixels, ViewTool
from tactile_widgets.views.overlays.body_overlays import NO_MARKS, EdgeMark, MarkRole, ToolMarks

SNAP_PX = 8.0

Edit = Callable[[MapDocument], MapDocument]


class DragMode(Enum):
    """Action of a drag; each value is the step's name."""

    MOVE = "Move"
    SCALE = "Scale"
    TURN = "Rotate"
    BOX = "Select"


@dataclass(frozen=True, eq=False)
class DragStart:
    """State at the press.

    Attributes:
        act: Action of the drag.
        document: Document at the press.
        numbers: Patches to be edited.
        frame: Box around them.
        start: (2,) pressed map point [m].
        corner: Held corner of the box, for scaling.
    """

    act: DragMode
    document: MapDocument
    numbers: tuple[int, ...]
    frame: TransformBox
    start: FloatArray
    corner: int


def drag_edit(
    grip: DragStart, point: FloatArray, pixel: float, *, shift: bool = False, control: bool = False
) -> tuple[Edit, ArrangeMarks]:
    """Return the edit of the document at the press for the pointer at ``point``, and its marks.

    Args:
        grip: State at the press.
        point: (2,) pointer on the map [m].
        pixel: Size of a pixel [m].
        shift: Move along one axis, scale about the middle, or rotate in fixed steps.
        control: Do not snap.
    """
    if grip.act is DragMode.SCALE:
        return _scaled(grip, point - grip.start, from_middle=shift)
    if grip.act is DragMode.TURN:
        return _rotated(grip, point, stepped=shift)
    return _moved(grip, point - grip.start, reach=0.0 if control else SNAP_PX * pixel, straight=shift)


def _moved(grip: DragStart, by: FloatArray, *, reach: float, straight: bool) -> tuple[Edit, ArrangeMarks]:
    snap = snap_move(grip.document, grip.numbers, by, reach=reach)
    if straight:
        along = int(np.abs(by).argmax())
        step = np.array(by) * [along == 0, along == 1]
        met = snap_move(grip.document, grip.numbers, step, reach=reach)
        snap = Snap((met.by[0], 0.0), x=met.x) if along == 0 else Snap((0.0, met.by[1]), y=met.y)
    words = _signed(f"x {1e3 * snap.by[0]:+.1f}, y {1e3 * snap.by[1]:+.1f}\u202fmm")
    marks = ArrangeMarks(grip.frame.moved(snap.by), snap.x, snap.y, words=words)
    return partial(move, numbers=grip.numbers, by=snap.by), marks


def _scaled(grip: DragStart, by: FloatArray, *, from_middle: bool) -> tuple[Edit, ArrangeMarks]:
    pulled, about = grip.frame.scaling_of_drag(grip.corner, by, from_middle=from_middle)
    factor = clamped_scale(grip.document, grip.numbers, pulled)
    words = f"×{factor:.2f}"
    before = grip.document.layout.placements[grip.numbers[0]].scale
    if len(grip.numbers) == 1 and before != 1:
        words += f", ×{factor * before:.2f} of true size"
    marks = ArrangeMarks(grip.frame.scaled(factor, about), words=words)
    return partial(scale, numbers=grip.numbers, factor=factor, about=about), marks


def _rotated(grip: DragStart, point: FloatArray, *, stepped: bool) -> tuple[Edit, ArrangeMarks]:
    angle = grip.frame.rotation_of_drag(grip.start, point)
    if stepped:
        angle = snapped_rotation(grip.document, grip.numbers, angle)
    marks = ArrangeMarks(grip.frame.rotated(angle), words=_signed(f"{np.degrees(angle):+.1f}°"))
    return partial(rotate, numbers=grip.numbers, angle=angle, about=grip.frame.middle), marks


def _signed(words: str) -> str:
    """Use a minus sign as wide as the plus, so that the text does not jitter."""
    return words.replace("-", "\u2212")


_HINT = "Drag a patch, a corner to scale it, the handle to rotate it. Shift: one axis, or 15°. Arrows: 1 mm."
NUDGE = 1e-3
"""Distance an arrow key moves patches [m]; ten times as far with Shift."""
_SHIFT = Qt.KeyboardModifier.ShiftModifier
_CONTROL = Qt.KeyboardModifier.ControlModifier


@dataclass(frozen=True, eq=False)
class _Press:
    """Start of a gesture.

    Attributes:
        act: Action of a drag.
        point: (2,) map point [m]; None on the body.
        pixel: Position in the view.
        patch: Patch under the pointer.
        adds: Whether Control or Shift was held.
        selected: Previously selected patches.
        grip: State for editing; None if a drag edits nothing.
    """

    act: DragMode
    point: FloatArray | None
    pixel: QPointF
    patch: int | None
    adds: bool
    selected: tuple[int, ...]
    grip: DragStart | None


class ArrangeTool(ViewTool):
    """Tool that moves, scales and rotates patches on the map, and selects them on the body.

    Args:
        editor: Editor of the map document and of the selected patches.
        parent: Qt parent.
    """

    hint = _HINT

    def __init__(self, editor: MapEditor, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._editor = editor
        self._press: _Press | None = None
        self._dragging = False
        self._hovered: int | None = None
        self._marks = ArrangeMarks()
        self._body: tuple[tuple[object, ...], ToolMarks] = ((), NO_MARKS)
        for changed in (editor.shown, editor.selection_changed, editor.enabled_changed):
            changed.connect(self._on_changed)
        editor.settled.connect(self._on_settled)

    # Mouse.

    def point_at(self, number: int | None) -> None:
        """Outline a patch hovered in another widget; None if there is none."""
        self._hovered = number
        self.drawn.emit()

    def press(self, place: PointerHit, event: QMouseEvent) -> bool:
        """Prepare a drag: it scales or rotates by a handle, moves a patch, or selects with a box."""
        document = self._editor.document
        if document is None or not self._editor.enabled or self._press is not None:
            return False
        adds = selection_mode_of(event.modifiers()) is SelectionMode.ADD
        before = self._editor.selected
        handle = self._handle_at(place)
        patch = None if place.at is None else place.at.patch
        if handle is not None:
            act = DragMode.TURN if handle == ROTATION_HANDLE else DragMode.SCALE
            patch = None
        elif patch is not None:
            act = DragMode.MOVE
            if patch not in before:
                self._editor.select((*before, patch) if adds else (patch,))
        else:
            act = DragMode.BOX
        grip = self._grip(act, document, place.point, handle or 0)
        self._press = _Press(act, place.point, event.position(), patch, adds, before, grip)
        self._dragging = False
        return True

    def _grip(self, act: DragMode, document: MapDocument, point: FloatArray | None, corner: int) -> DragStart | None:
        numbers = self._shown()
        frame = TransformBox.around(document, numbers)
        if act is DragMode.BOX or frame is None or point is None:
            return None
        return DragStart(act, document, numbers, frame, point, corner)

    def move(self, place: PointerHit, event: QMouseEvent) -> None:
        """Continue the gesture, or highlight what a press would affect."""
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

    def release(self, place: PointerHit, event: QMouseEvent) -> None:
        """End the gesture as one step; without a drag, it is a click, which selects."""
        press, dragging = self._forget()
        away = QPointF() if press is None else event.position() - press.pixel
        if dragging:
            self._editor.end()
        elif press is not None and np.hypot(away.x(), away.y()) <= CLICK_PX:
            self._click(press)
        self._hover(place, event.position())

    def cancel(self) -> bool:
        """Cancel the gesture and restore the state before the press."""
        press, dragging = self._forget()
        if press is not None and dragging and press.grip is None:
            self._editor.select(press.selected)
        elif dragging:
            self._editor.cancel()
        return press is not None

    def leave(self) -> None:
        """Clear the hovered patch."""
        if self._press is None:
            self._hovered = None
            self._marks = ArrangeMarks()
            self.drawn.emit()

    def _click(self, press: _Press) -> None:
        if press.patch is None:
            if press.act is DragMode.BOX and not press.adds:
                self._editor.select(())
        elif not press.adds:
            self._editor.select((press.patch,))
        elif press.patch in press.selected:
            self._editor.select(number for number in press.selected if number != press.patch)

    def _drag(self, press: _Press, point: FloatArray, pixel: float, event: QMouseEvent) -> None:
        if press.grip is None:
            self._sweep(press, point)
        elif self._editor.gesture:
            shift = bool(event.modifiers() & _SHIFT)
            control = bool(event.modifiers() & _CONTROL)
            edit, self._marks = drag_edit(press.grip, point, pixel, shift=shift, control=control)
            self._editor.change(edit)
        else:  # undone, or editing was disabled
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
        swept = [number for number in self._seen(document) if _overlaps(box, patch_outline(document, number))]
        self._editor.select((*press.selected, *swept) if press.adds else swept)
        self._marks = ArrangeMarks(box=box)

    def _forget(self) -> tuple[_Press | None, bool]:
        """End the gesture; return its start, if there was one, and whether it was a drag."""
        press = self._press
        dragging = self._dragging
        self._press = None
        self._dragging = False
        self._marks = ArrangeMarks()
        self.drawn.emit()
        return press, dragging

    def _hover(self, place: PointerHit, pixel: QPointF) -> None:
        handle = self._handle_at(place)
        over = None if place.at is None or handle is not None else place.at.patch
        words = (
            ""
            if handle is None
            else "Rotate · Shift by 15°"
            if handle == ROTATION_HANDLE
            else "Scale · Shift about the middle"
        )
        if (over, words) != (self._hovered, self._marks.words) or words:
            self._hovered = over
            self._marks = ArrangeMarks(words=words).at(pixel)
            self.drawn.emit()

    def _handle_at(self, place: PointerHit) -> int | None:
        document = self._editor.document
        if document is None or place.point is None or not self._editor.enabled:
            return None
        frame = TransformBox.around(document, self._shown())
        return None if frame is None else frame.handle_at(place.point, place.pixel)

    # Keys.

    def key(self, event: QKeyEvent) -> bool:
        """Handle arrows (move) and Escape (clear the selection)."""
        held = event.modifiers() & ~Qt.KeyboardModifier.KeypadModifier
        key = Qt.Key(event.key())
        shown = self._shown()
        nothing = Qt.KeyboardModifier.NoModifier
        if self._press is not None:
            return key in ARROWS
        if key in ARROWS and shown and held in (nothing, _SHIFT):
            step = NUDGE * (10 if held == _SHIFT else 1)
            by = step * np.array(ARROWS[key])
            self._editor.do("Move", partial(move, numbers=shown, by=by), series=("arrows", shown))
        elif key == Qt.Key.Key_Escape and self._editor.selected:
            self._editor.select(())
        else:
            return False
        return True

    # Display.

    def _shown(self) -> tuple[int, ...]:
        """Return the selected visible patches; hidden ones are not edited."""
        document = self._editor.document
        seen = () if document is None else self._seen(document)
        return tuple(number for number in self._editor.selected if number in seen)

    def _seen(self, document: MapDocument) -> tuple[int, ...]:
        return tuple(number for number, patch in enumerate(document.patches) if patch.visible)

    def paint(self, painter: QPainter, to_pixels: ToPixels, theme: Theme) -> None:
        """Draw the selected patches and their box, the patch under the pointer, guides and the text of the gesture."""
        document = self._editor.document
        if document is None:
            return
        numbers = self._shown()
        hovered = self._hovered if self._press is None and self._hovered in self._seen(document) else None
        lines = [patch_outline(document, number) for number in numbers]
        over = patch_outline(document, hovered) if hovered is not None and hovered not in numbers else None
        frame = self._marks.frame or TransformBox.around(document, numbers)
        marks = self._marks if self._editor.enabled else ArrangeMarks()
        paint_arrange(painter, to_pixels, theme, marks, frame if self._editor.enabled else None, lines, over)

    def body_marks(self) -> ToolMarks:
        """Return the borders of the selected patches."""
        document = self._editor.document
        numbers = self._shown()
        key = (numbers, *(() if document is None else (id(document.charts[number].faces) for number in numbers)))
        if document is None or not numbers:
            return NO_MARKS
        if key != self._body[0]:
            rings = [(n, document.charts[n].vertex_of[document.charts[n].border]) for n in numbers]
            lines = tuple(EdgeMark(n, np.append(ring, ring[0]), MarkRole.HELD) for n, ring in rings)
            self._body = key, ToolMarks(document.skin, lines=lines)
        return self._body[1]

    def cursor(self, place: PointerHit) -> Qt.CursorShape:
        """Return the cursor for the current or possible action."""
        handle = self._handle_at(place)
        act = DragMode.TURN if handle == ROTATION_HANDLE else DragMode.SCALE if handle is not None else None
        corner = handle or 0
        over = place.at is not None
        if self._press is not None:
            act = self._press.act
            corner = 0 if self._press.grip is None else self._press.grip.corner
        elif act is None and over:
            act = DragMode.MOVE
        if act is DragMode.SCALE:
            return Qt.CursorShape.SizeBDiagCursor if corner % 2 == 0 else Qt.CursorShape.SizeFDiagCursor
        if act is DragMode.TURN:
            return Qt.CursorShape.PointingHandCursor if self._press is None else Qt.CursorShape.ClosedHandCursor
        if act is DragMode.MOVE:
            return Qt.CursorShape.SizeAllCursor if place.point is not None else Qt.CursorShape.PointingHandCursor
        return Qt.CursorShape.CrossCursor if act is DragMode.BOX else Qt.CursorShape.ArrowCursor

    def _on_changed(self) -> None:
        self.drawn.emit()

    def _on_settled(self) -> None:
        """End the gesture because of a step from elsewhere, such as undo by its key."""
        self._forget()


def _overlaps(box: FloatArray, line: FloatArray) -> bool:
    """Whether a corner of a box (4, 2) or of a closed outline (b, 2) is inside the other."""
    return bool(points_in_polygon(box, line).any() or points_in_polygon(line, box).any())
