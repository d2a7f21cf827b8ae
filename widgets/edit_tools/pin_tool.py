"""The tool for pins: a click puts one in, a drag moves one and the map follows, keys take them out."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import partial

import numpy as np
from PySide6.QtCore import QObject, QPointF, Qt
from PySide6.QtGui import QKeyEvent, QMouseEvent, QPainter

from app.arrays import FloatArray
from app.editing.document import MapDocument
from app.editing.pins import add_pin, nudge_pins, settle, unpin
from app.errors import MapError
from app.geometry.surface_point import SurfacePoint
from widgets.body_marks import BodyMarks, BodySpot, Role
from widgets.colours import Theme
from widgets.edit_tool import Place, ToPixels
from widgets.edit_tools.pin_drag import PinDrag
from widgets.edit_tools.pins_shown import draw_pins, numbers, pinned, sound, with_pins
from widgets.edit_tools.working_tool import WorkingTool, seam_lines
from widgets.editor import Editor
from widgets.select_hand import CLICK_PX

REACH_PX = 8.0
STEP, FINE_STEP = 1e-3, 1e-4
"""How far an arrow key moves a pin on the map [m], and with Shift."""
_ARROWS = {
    Qt.Key.Key_Left: (-1.0, 0.0),
    Qt.Key.Key_Right: (1.0, 0.0),
    Qt.Key.Key_Up: (0.0, 1.0),
    Qt.Key.Key_Down: (0.0, -1.0),
}
_ADDS = Qt.KeyboardModifier.ShiftModifier | Qt.KeyboardModifier.ControlModifier


@dataclass(frozen=True, eq=False)
class _Press:
    """Where the button went down: on a pin, or on the skin."""

    place: Place
    pixel: QPointF
    pin: SurfacePoint | None


class PinTool(WorkingTool):
    """Pins under the hand. Pins are known by their place of the body, which no edit changes.

    On the map a click on the skin adds a pin and a drag moves one, a new one too; on the body a click adds or selects.
    """

    hint = "Click the skin to pin it; drag a pin and the map follows. Alt+P takes pins out, arrow keys move them."

    def __init__(self, editor: Editor, parent: QObject | None = None) -> None:
        super().__init__(editor, parent)
        self._chosen: frozenset[SurfacePoint] = frozenset()
        self._hovered: SurfacePoint | None = None
        self._place: Place | None = None
        self._press: _Press | None = None
        self._drag: PinDrag | None = None
        self._moved = False
        self._nudge: FloatArray = np.zeros(2)

    @property
    def chosen(self) -> dict[int, list[int]]:
        """The selected pins: their numbers, by patch."""
        return {} if self._document is None else numbers(self._document, self._chosen)

    # What the keys do, wherever the pointer is.

    def add_here(self) -> None:
        """Pin the place under the pointer where it is."""
        at = None if self._place is None else self._place.at
        if at is None:
            self._editor.told.emit("Point at the skin to pin it there")
        else:
            self._add(at)

    def pin_taxels(self, taxels: Iterable[int]) -> None:
        """Pin each of these taxels where it is; those that are pinned already stay so."""
        document = self._document
        if document is not None:
            places = [document.skin.taxel_point(taxel) for taxel in taxels]
            there = pinned(document)
            new = [at for at in places if at not in there]
            if not new:
                self._editor.told.emit("These taxels are pinned already" if places else "No taxels are selected")
            elif self._editor.do(f"Pin {len(new)} taxels" if len(new) > 1 else "Add a pin", partial(with_pins, at=new)):
                self._choose(new)

    def remove(self) -> None:
        """Take out the selected pins, or else the one under the pointer."""
        document = self._document
        wanted = self.chosen
        if document is not None and not wanted and self._hovered is not None:
            wanted = numbers(document, frozenset([self._hovered]))
        if not wanted:
            self._editor.told.emit("Select a pin, or point at one, to remove it")
        else:
            self._ask(partial(unpin, wanted=wanted))

    def select_pinned(self) -> None:
        """Select all pins of the selected patches, or of all where none is selected."""
        document = self._document
        if document is not None:
            patches = self._editor.selected or range(len(document.patches))
            self._choose(pin.at for number in patches for pin in document.patches[number].pins)

    def _add(self, at: SurfacePoint) -> None:
        place = sound(at)
        if self._editor.do("Add a pin", partial(add_pin, at=place)):
            self._choose([place])

    def _choose(self, pins: Iterable[SurfacePoint]) -> None:
        self._chosen = frozenset(pins)
        self._redraw()

    # The hand.

    def press(self, place: Place, event: QMouseEvent) -> bool:
        """On a pin: select it; on the skin: begin a new one; beside it: select none."""
        if self._document is None:
            return False
        self._place, pin = place, self._pin_at(place)
        adds = bool(event.modifiers() & _ADDS)
        if pin is not None:
            self._choose(self._chosen ^ {pin} if adds else self._chosen if pin in self._chosen else [pin])
        elif place.at is None:
            if not adds:
                self._choose([])
            return False
        self._press, self._moved = _Press(place, event.position(), pin), False
        return True

    def move(self, place: Place, event: QMouseEvent) -> None:
        """Drag the pin, or say which one a press would take."""
        self._place = place
        if self._press is None:
            self._hover(self._pin_at(place))
            return
        away = event.position() - self._press.pixel
        begins = not self._moved and np.hypot(away.x(), away.y()) > CLICK_PX
        self._moved |= begins
        if begins and self._press.place.point is not None:
            self._begin(self._press, self._press.place.point)
        if self._drag is not None and place.point is not None:
            self._drag.move(place.point)

    def release(self, place: Place, event: QMouseEvent) -> None:
        """The drag is a step, whose exact map the worker makes; a click on the skin adds a pin."""
        press, drag, self._press, self._drag = self._press, self._drag, None, None
        if drag is not None:
            drag.end()
            drag.deleteLater()
            self._ask(partial(settle, number=drag.number), refine=True)
        elif press is not None and press.pin is None and not self._moved and press.place.at is not None:
            self._add(press.place.at)

    def _begin(self, press: _Press, point: FloatArray) -> None:
        """The press became a drag of a pin that is there or of a new one."""
        if self._editor.busy and self._mine:
            self._editor.cancel_work()  # the exact map of the drag before; this one will have its own
            self._editor.told.emit("The map is made exact when you let go")
        document, at = self._document, press.pin
        if document is None or not self._may_ask():
            return
        try:
            if at is None and press.place.at is not None:
                at = sound(press.place.at)
                document = add_pin(document, at)
            assert at is not None
            ((number, (pin,)),) = numbers(document, frozenset([at])).items()
            grab = point - document.map.to_map(at)
            self._drag = PinDrag(self._editor, document, number, pin, grab, self)
        except MapError as error:
            self._editor.failed.emit(str(error))
            return
        if self._editor.begin("Drag a pin"):
            self._choose([at])
        else:
            self._lose()

    def cancel(self) -> bool:
        """The drag never was, nor the press."""
        press, drag, self._press, self._drag = self._press, self._drag, None, None
        if drag is not None:
            drag.cancel()
            drag.deleteLater()
        self._redraw()
        return press is not None

    def key(self, event: QKeyEvent) -> bool:
        """Arrows move the selected pins, Delete takes them out."""
        if event.key() == Qt.Key.Key_Delete:
            self.remove()
            return True
        arrow = _ARROWS.get(Qt.Key(event.key()))
        if arrow is None or not self.chosen or self._press is not None:
            return False
        if self._may_ask():
            fine = event.modifiers() & Qt.KeyboardModifier.ShiftModifier
            self._nudge = self._nudge + (FINE_STEP if fine else STEP) * np.array(arrow)
            self._ask(partial(nudge_pins, wanted=self.chosen, by=self._nudge))
            if not self._editor.busy:
                self._nudge = np.zeros(2)
        return True

    def leave(self) -> None:
        """Nothing is under the pointer."""
        self._place = None
        self._hover(None)

    def cursor(self, place: Place) -> Qt.CursorShape:
        """What a press there would do."""
        if self._drag is not None:
            return Qt.CursorShape.ClosedHandCursor
        if self._pin_at(place) is not None:
            return Qt.CursorShape.OpenHandCursor if place.point is not None else Qt.CursorShape.PointingHandCursor
        return Qt.CursorShape.ArrowCursor if place.at is None else Qt.CursorShape.CrossCursor

    def _hover(self, pin: SurfacePoint | None) -> None:
        if pin != self._hovered:
            self._hovered = pin
            self._redraw()

    def _pin_at(self, place: Place) -> SurfacePoint | None:
        document, best, found = self._document, REACH_PX * place.pixel, None
        for pin in () if document is None else pinned(document, seen=place.point is not None).values():
            assert document is not None
            if place.point is not None:
                away = float(np.linalg.norm(document.map.to_map(pin.at) - place.point))
            elif place.at is not None and place.at.patch == pin.at.patch:
                away = float(np.linalg.norm(document.skin.position(pin.at) - document.skin.position(place.at)))
            else:
                continue
            if away <= best:
                best, found = away, pin.at
        return found

    # What comes from the editor.

    def _on_shown(self, document: MapDocument) -> None:
        if self._drag is not None and not self._editor.gesture:
            self._lose()  # undone in the middle of a drag
        there = pinned(document)
        self._chosen = frozenset(at for at in self._chosen if at in there)
        self._hovered = self._hovered if self._hovered in there else None
        super()._on_shown(document)

    def _lose(self) -> None:
        """The hand has nothing any more, until the button comes up."""
        drag, self._drag = self._drag, None
        if drag is not None:
            drag.drop()
            drag.deleteLater()

    def _on_rested(self) -> None:
        self._nudge = np.zeros(2)
        super()._on_rested()

    # How it looks.

    def _mark_body(self, document: MapDocument) -> BodyMarks:
        spots = tuple(
            BodySpot(at, Role.HELD if at in self._chosen else Role.PIN, at == self._hovered) for at in pinned(document)
        )
        return BodyMarks(lines=seam_lines(document), spots=spots)

    def paint(self, painter: QPainter, to_pixels: ToPixels, theme: Theme) -> None:
        """Pins, and how far those are from where they are wanted that hinder each other."""
        if self._editor.document is not None:
            draw_pins(painter, self._editor.document, to_pixels, theme, chosen=self._chosen, hovered=self._hovered)
