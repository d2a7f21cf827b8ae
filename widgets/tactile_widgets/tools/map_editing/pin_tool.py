"""Pin tool: a click adds a pin, a drag moves one and deforms the map, keys remove pins.

First the pins of a document by their body location and their drawing on the map; then ``PinDrag``, the drag of one pin:
its patch follows at every move, and between moves until it has converged; then the tool.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial

import numpy as np
from PySide6.QtCore import QObject, QPointF, Qt, QTimer
from PySide6.QtGui import QColor, QKeyEvent, QMouseEvent, QPainter, QPen

from tactile_maps.core.arrays import FloatArray
from tactile_maps.core.errors import MapError
from tactile_maps.editing.document import MapDocument
from tactile_maps.editing.pins import (
    add_pin,
    begin_pin_drag,
    chart_place,
    finish_pin_drag,
    nudge_pins,
    pin_places,
    unpin,
    with_dragged_patch,
)
from tactile_maps.flattening.chart import Pin
from tactile_maps.flattening.pinned_patch import PinnedPatch
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_widgets.common.colours import Theme
from tactile_widgets.common.make import make
from tactile_widgets.document.map_editor import MapEditor
from tactile_widgets.tools.map_editing.map_edit_tool import MapEditTool, seam_lines
from tactile_widgets.views.interaction.arrow_keys import nudge_of
from tactile_widgets.views.interaction.select_gesture import CLICK_PX
from tactile_widgets.views.interaction.view_tool import PointerHit, ToPixels
from tactile_widgets.views.overlays.body_overlays import MarkRole, PointMark, ToolMarks
from tactile_widgets.views.overlays.painting import RIM, draw_label, draw_pin

_LAG_PX = 3.0


def pins_by_point(document: MapDocument, *, seen: bool = False) -> dict[SurfacePoint, Pin]:
    """Return all pins by their body location; ``seen``: only of patches that the map view shows."""
    return {pin.at: pin for patch in document.patches if patch.visible or not seen for pin in patch.pins}


def pin_numbers(document: MapDocument, pins: frozenset[SurfacePoint]) -> dict[int, list[int]]:
    """Return the indices of pins at these body locations, by patch."""
    found = {
        number: [k for k, pin in enumerate(patch.pins) if pin.at in pins]
        for number, patch in enumerate(document.patches)
    }
    return {number: own for number, own in found.items() if own}


def with_pins(document: MapDocument, at: Iterable[SurfacePoint]) -> MapDocument:
    for place in at:
        document = add_pin(document, place)
    return document


def normalised(at: SurfacePoint) -> SurfacePoint:
    """Return the location with weights that are non-negative and sum to one, as the document stores them."""
    weights = np.clip(at.weights, 0, None)
    a, b, c = (weights / weights.sum()).tolist()
    return SurfacePoint(int(at.patch), int(at.face), (a, b, c))


def draw_pins(
    painter: QPainter,
    document: MapDocument,
    to_pixels: ToPixels,
    theme: Theme,
    *,
    chosen: frozenset[SurfacePoint] = frozenset(),
    hovered: SurfacePoint | None = None,
) -> None:
    """Draw pins as diamonds, and the offset of each pin that is not at its target as a line with text."""
    for number, patch in enumerate(document.patches):
        if patch.pins and patch.visible:
            places = np.array([document.map.to_map(p.at) for p in patch.pins])
            targets = pin_places(document, number)
            lags = np.linalg.norm(targets - places, axis=1)
            for pin, at, goal, lag in zip(patch.pins, to_pixels(places), to_pixels(targets), lags, strict=True):
                _draw_lag(painter, at, goal, float(lag), theme)
                role = MarkRole.HELD if pin.at in chosen else MarkRole.PIN
                draw_pin(painter, QPointF(*at), QColor(role.ink(theme)), large=pin.at == hovered)


def _draw_lag(painter: QPainter, at: FloatArray, goal: FloatArray, lag: float, theme: Theme) -> None:
    if np.linalg.norm(goal - at) > _LAG_PX:
        for ink, width in ((RIM, 3.0), (QColor(theme.accent), 1.2)):
            painter.setPen(QPen(ink, width))
            painter.drawLine(QPointF(*at), QPointF(*goal))
            painter.drawEllipse(QPointF(*goal), 2.5, 2.5)
        draw_label(painter, f"{1e3 * lag:.1f}\u202fmm off", theme, at=QPointF(*goal))


FRAME_MS = 16


class PinDrag(QObject):
    """Gesture of the editor that drags one pin. Mutable; finished after ``end`` or ``cancel``, or when undone.

    Args:
        editor: Editor with a gesture in progress.
        document: Document before the gesture, including the pin if it is new.
        number: Patch number.
        pin: Index of the pin in the patch.
        grab: (2,) offset from the pin to the pointer on the map [m].
        parent: Qt parent.

    Raises:
        MapError: The patch cannot be deformed interactively.

    Cost: 30 ms for 10,000 faces; a move 8 to 18 ms.
    """

    def __init__(
        self, editor: MapEditor, document: MapDocument, number: int, pin: int, grab: FloatArray, parent: QObject
    ) -> None:
        super().__init__(parent)
        self._editor = editor
        self._document = document
        self._pin = pin
        self._grab = grab
        self.number = number
        self._gripped: PinnedPatch = begin_pin_drag(document, number)
        self._rest = make(QTimer, self, singleShot=True, interval=FRAME_MS, timeout=self._on_rest)

    def move(self, point: FloatArray) -> None:
        """Move the pin with the pointer at a map point (2,) [m]."""
        try:
            self._gripped.move(self._pin, chart_place(self._document, self.number, point - self._grab))
        except MapError:
            return  # too far from the map: the pin stays at its last valid target
        self._follow()

    def end(self) -> None:
        """End the gesture as one step."""
        self._rest.stop()
        self._editor.end()

    def cancel(self) -> None:
        """Cancel the gesture."""
        self._rest.stop()
        self._editor.cancel()

    def drop(self) -> None:
        """Stop after the gesture was ended elsewhere."""
        self._rest.stop()

    def _follow(self) -> None:
        self._gripped.frame()
        edit: Callable[[MapDocument], MapDocument] = partial(
            with_dragged_patch, number=self.number, gripped=self._gripped
        )
        if self._editor.change(edit) and not self._gripped.still:
            self._rest.start()

    def _on_rest(self) -> None:
        """Continue until the patch has converged, while the pointer rests."""
        if self._editor.gesture:
            self._follow()


REACH_PX = 8.0
_ADDS = Qt.KeyboardModifier.ShiftModifier | Qt.KeyboardModifier.ControlModifier


@dataclass(frozen=True, eq=False)
class _Press:
    """Press on a pin or on the skin."""

    place: PointerHit
    pixel: QPointF
    pin: SurfacePoint | None


class PinTool(MapEditTool):
    """Tool that adds, moves and removes pins. Pins are identified by their body location, which no edit changes.

    On the map, a click on the skin adds a pin and a drag moves an old or new one; on the body, a click adds or selects.
    """

    hint = "Click the skin to pin it; drag a pin and the map follows. Arrows move pins; Edit > Remove pins deletes."

    def __init__(self, editor: MapEditor, parent: QObject | None = None) -> None:
        super().__init__(editor, parent)
        self._chosen: frozenset[SurfacePoint] = frozenset()
        self._hovered: SurfacePoint | None = None
        self._place: PointerHit | None = None
        self._press: _Press | None = None
        self._drag: PinDrag | None = None
        self._moved = False
        self._nudge: FloatArray = np.zeros(2)

    @property
    def chosen(self) -> dict[int, list[int]]:
        """Indices of the selected pins, by patch."""
        return {} if self._document is None else pin_numbers(self._document, self._chosen)

    # Actions of menus and keys, independent of the pointer.

    def add_here(self) -> None:
        """Add a pin under the pointer."""
        at = None if self._place is None else self._place.at
        if at is None:
            self._editor.notified.emit("Point at the skin to pin it there")
        else:
            self._add(at)

    def pin_taxels(self, taxels: Iterable[int]) -> None:
        """Pin these taxels at their present map positions, except those already pinned."""
        document = self._document
        if document is not None:
            places = [document.skin.taxel_point(taxel) for taxel in taxels]
            there = pins_by_point(document)
            new = [at for at in places if at not in there]
            if not new:
                self._editor.notified.emit("These taxels are pinned already" if places else "No taxels are selected")
            elif self._editor.do(f"Pin {len(new)} taxels" if len(new) > 1 else "Add a pin", partial(with_pins, at=new)):
                self._choose(new)

    def remove(self) -> None:
        """Remove the selected pins, or else the one under the pointer."""
        document = self._document
        pins = self.chosen
        if document is not None and not pins and self._hovered is not None:
            pins = pin_numbers(document, frozenset([self._hovered]))
        if not pins:
            self._editor.notified.emit("Select a pin, or point at one, to remove it")
        else:
            self._request(partial(unpin, pins_by_patch=pins))

    def remove_at(self, pin: SurfacePoint) -> None:
        """Remove the pin at a body location."""
        self._choose([pin])
        self.remove()

    def select_pinned(self) -> None:
        """Select all pins of the selected patches, or of all patches if none is selected."""
        document = self._document
        if document is not None:
            patches = self._editor.selected or range(len(document.patches))
            self._choose(pin.at for number in patches for pin in document.patches[number].pins)

    def _add(self, at: SurfacePoint) -> None:
        place = normalised(at)
        if self._editor.do("Add a pin", partial(add_pin, at=place)):
            self._choose([place])

    def _choose(self, pins: Iterable[SurfacePoint]) -> None:
        self._chosen = frozenset(pins)
        self._redraw()

    # Gestures.

    def press(self, place: PointerHit, event: QMouseEvent) -> bool:
        """Select the pin under the pointer, prepare a new pin on the skin, or clear the selection off the skin."""
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
        self._press = _Press(place, event.position(), pin)
        self._moved = False
        return True

    def move(self, place: PointerHit, event: QMouseEvent) -> None:
        """Drag the pin, or highlight the one under the pointer."""
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

    def release(self, place: PointerHit, event: QMouseEvent) -> None:
        """End the drag as a step and request its exact map; a click on the skin adds a pin."""
        press = self._press
        drag = self._drag
        self._press = None
        self._drag = None
        if drag is not None:
            drag.end()
            drag.deleteLater()
            self._request(partial(finish_pin_drag, number=drag.number), refine=True)
        elif press is not None and press.pin is None and not self._moved and press.place.at is not None:
            self._add(press.place.at)

    def _begin(self, press: _Press, point: FloatArray) -> None:
        """Start the drag of an existing or a new pin."""
        if self._editor.busy and self._mine:
            self._editor.cancel_work()  # the exact map of the previous drag; this drag requests its own
            self._editor.notified.emit("The exact map is computed on release")
        document = self._document
        at = press.pin
        if document is None or not self._can_request():
            return
        try:
            if at is None and press.place.at is not None:
                at = normalised(press.place.at)
                document = add_pin(document, at)
            assert at is not None
            ((number, (pin,)),) = pin_numbers(document, frozenset([at])).items()
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
        """Cancel the drag or the press."""
        press = self._press
        drag = self._drag
        self._press = None
        self._drag = None
        if drag is not None:
            drag.cancel()
            drag.deleteLater()
        self._redraw()
        return press is not None

    def key(self, event: QKeyEvent) -> bool:
        """Handle arrows (move the selected pins) and Delete (remove them)."""
        if event.key() == Qt.Key.Key_Delete:
            self.remove()
            return True
        by = nudge_of(event)
        if by is None or not self.chosen or self._press is not None:
            return False
        if self._can_request():
            self._nudge = self._nudge + by
            self._request(partial(nudge_pins, pins_by_patch=self.chosen, by=self._nudge))
            if not self._editor.busy:
                self._nudge = np.zeros(2)
        return True

    def leave(self) -> None:
        """Clear the pointer position."""
        self._place = None
        self._hover(None)

    def cursor(self, place: PointerHit) -> Qt.CursorShape:
        """Return the cursor for what a press there would do."""
        if self._drag is not None:
            return Qt.CursorShape.ClosedHandCursor
        if self._pin_at(place) is not None:
            return Qt.CursorShape.OpenHandCursor if place.point is not None else Qt.CursorShape.PointingHandCursor
        return Qt.CursorShape.ArrowCursor if place.at is None else Qt.CursorShape.CrossCursor

    def _hover(self, pin: SurfacePoint | None) -> None:
        if pin != self._hovered:
            self._hovered = pin
            self._redraw()

    def _pin_at(self, place: PointerHit) -> SurfacePoint | None:
        document = self._document
        best = REACH_PX * place.pixel
        found = None
        for pin in () if document is None else pins_by_point(document, seen=place.point is not None).values():
            assert document is not None
            if place.point is not None:
                away = float(np.linalg.norm(document.map.to_map(pin.at) - place.point))
            elif place.at is not None and place.at.patch == pin.at.patch:
                away = float(np.linalg.norm(document.skin.position(pin.at) - document.skin.position(place.at)))
            else:
                continue
            if away <= best:
                best = away
                found = pin.at
        return found

    # Signals of the editor.

    def _on_shown(self, document: MapDocument) -> None:
        if self._drag is not None and not self._editor.gesture:
            self._lose()  # undone in the middle of a drag
        there = pins_by_point(document)
        self._chosen = frozenset(at for at in self._chosen if at in there)
        self._hovered = self._hovered if self._hovered in there else None
        super()._on_shown(document)

    def _forget(self) -> None:
        self._place = None

    def _lose(self) -> None:
        """Abandon the drag until the next press."""
        drag = self._drag
        self._drag = None
        if drag is not None:
            drag.drop()
            drag.deleteLater()

    def _on_rested(self) -> None:
        self._nudge = np.zeros(2)
        super()._on_rested()

    # Display.

    def _mark_body(self, document: MapDocument) -> ToolMarks:
        spots = tuple(
            PointMark(at, MarkRole.HELD if at in self._chosen else MarkRole.PIN, at == self._hovered)
            for at in pins_by_point(document)
        )
        return ToolMarks(document.skin, lines=seam_lines(document), spots=spots)

    def paint(self, painter: QPainter, to_pixels: ToPixels, theme: Theme) -> None:
        """Draw pins, and the offset of pins that cannot reach their targets because others prevent it."""
        if self._document is not None:
            draw_pins(painter, self._document, to_pixels, theme, chosen=self._chosen, hovered=self._hovered)
