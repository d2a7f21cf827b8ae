"""The tool for pins: a click puts one in, a drag moves one and the map follows, keys take them out.

First the pins of a document by their place on the body and how they look on the map; then ``PinDrag``, one pin under
the pointer: its patch follows at every move, and between moves until it has converged; then the tool.
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
from tactile_widgets.document.map_editor import MapEditor
from tactile_widgets.tools.map_editing.map_edit_tool import MapEditTool, seam_lines
from tactile_widgets.views.interaction.select_gesture import CLICK_PX
from tactile_widgets.views.interaction.view_tool import PointerHit, ToPixels
from tactile_widgets.views.overlays.body_overlays import MarkRole, PointMark, ToolMarks
from tactile_widgets.views.overlays.painting import RIM, draw_label, draw_pin

_LAG_PX = 3.0


def pins_by_point(document: MapDocument, *, seen: bool = False) -> dict[SurfacePoint, Pin]:
    """All pins by their place of the body; ``seen``: of the patches that the map view shows."""
    return {pin.at: pin for patch in document.patches if patch.visible or not seen for pin in patch.pins}


def pin_numbers(document: MapDocument, pins: frozenset[SurfacePoint]) -> dict[int, list[int]]:
    """Pins by their places, as numbers by patch."""
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
    """The place with weights that are exactly what they should be, as the document keeps them."""
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
    """Diamonds where the pins are, and a line and words where one is not where it is wanted."""
    for number, patch in enumerate(document.patches):
        if patch.pins and patch.visible:
            places = np.array([document.map.to_map(p.at) for p in patch.pins])
            wanted = pin_places(document, number)
            lags = np.linalg.norm(wanted - places, axis=1)
            for pin, at, goal, lag in zip(patch.pins, to_pixels(places), to_pixels(wanted), lags, strict=True):
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
    """A gesture of the editor that drags one pin. Mutable; over after ``end`` or ``cancel``, or when undone.

    Args:
        editor: A gesture is going on in it.
        document: As it was before the gesture, with the pin if that is new.
        number: Of the patch.
        pin: Of its pins, by number.
        grab: (2,) from the pin to the pointer on the map [m].
        parent: Qt parent.

    Raises:
        MapError: The patch cannot be followed by hand.

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
        self._rest = QTimer(self)
        self._rest.setSingleShot(True)
        self._rest.setInterval(FRAME_MS)
        self._rest.timeout.connect(self._on_rest)

    def move(self, point: FloatArray) -> None:
        """The pointer is at a map point (2,) [m]."""
        try:
            self._gripped.move(self._pin, chart_place(self._document, self.number, point - self._grab))
        except MapError:
            return  # a hundred maps away: the pin waits where the pointer was last near enough to be seen
        self._follow()

    def end(self) -> None:
        """The user let go: the gesture is one step."""
        self._rest.stop()
        self._editor.end()

    def cancel(self) -> None:
        """The gesture never was."""
        self._rest.stop()
        self._editor.cancel()

    def drop(self) -> None:
        """The gesture was ended by somebody else."""
        self._rest.stop()

    def _follow(self) -> None:
        self._gripped.frame()
        edit: Callable[[MapDocument], MapDocument] = partial(
            with_dragged_patch, number=self.number, gripped=self._gripped
        )
        if self._editor.change(edit) and not self._gripped.still:
            self._rest.start()

    def _on_rest(self) -> None:
        """The pointer rests and the patch does not yet."""
        if self._editor.gesture:
            self._follow()


REACH_PX = 8.0
STEP = 1e-3
FINE_STEP = 1e-4
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

    place: PointerHit
    pixel: QPointF
    pin: SurfacePoint | None


class PinTool(MapEditTool):
    """Pins under the pointer. Pins are known by their place of the body, which no edit changes.

    On the map a click on the skin adds a pin and a drag moves one, a new one too; on the body a click adds or selects.
    """

    hint = "Click the skin to pin it; drag a pin and the map follows. Arrows move pins; Edit > Remove pins takes them."

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
        """The selected pins: their numbers, by patch."""
        return {} if self._document is None else pin_numbers(self._document, self._chosen)

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
            there = pins_by_point(document)
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
            wanted = pin_numbers(document, frozenset([self._hovered]))
        if not wanted:
            self._editor.told.emit("Select a pin, or point at one, to remove it")
        else:
            self._ask(partial(unpin, pins_by_patch=wanted))

    def remove_at(self, pin: SurfacePoint) -> None:
        """Take out the pin at a place of the body."""
        self._choose([pin])
        self.remove()

    def select_pinned(self) -> None:
        """Select all pins of the selected patches, or of all where none is selected."""
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
        self._press = _Press(place, event.position(), pin)
        self._moved = False
        return True

    def move(self, place: PointerHit, event: QMouseEvent) -> None:
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

    def release(self, place: PointerHit, event: QMouseEvent) -> None:
        """The drag is a step, whose exact map the worker makes; a click on the skin adds a pin."""
        press = self._press
        drag = self._drag
        self._press = None
        self._drag = None
        if drag is not None:
            drag.end()
            drag.deleteLater()
            self._ask(partial(finish_pin_drag, number=drag.number), refine=True)
        elif press is not None and press.pin is None and not self._moved and press.place.at is not None:
            self._add(press.place.at)

    def _begin(self, press: _Press, point: FloatArray) -> None:
        """The press became a drag of a pin that is there or of a new one."""
        if self._editor.busy and self._mine:
            self._editor.cancel_work()  # the exact map of the drag before; this one will have its own
            self._editor.told.emit("The exact map is computed on release")
        document = self._document
        at = press.pin
        if document is None or not self._may_ask():
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
        """The drag never was, nor the press."""
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
            self._ask(partial(nudge_pins, pins_by_patch=self.chosen, by=self._nudge))
            if not self._editor.busy:
                self._nudge = np.zeros(2)
        return True

    def leave(self) -> None:
        """Nothing is under the pointer."""
        self._place = None
        self._hover(None)

    def cursor(self, place: PointerHit) -> Qt.CursorShape:
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

    # What comes from the editor.

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
        """Nothing is dragged any more, until the button comes up."""
        drag = self._drag
        self._drag = None
        if drag is not None:
            drag.drop()
            drag.deleteLater()

    def _on_rested(self) -> None:
        self._nudge = np.zeros(2)
        super()._on_rested()

    # How it looks.

    def _mark_body(self, document: MapDocument) -> ToolMarks:
        spots = tuple(
            PointMark(at, MarkRole.HELD if at in self._chosen else MarkRole.PIN, at == self._hovered)
            for at in pins_by_point(document)
        )
        return ToolMarks(document.skin, lines=seam_lines(document), spots=spots)

    def paint(self, painter: QPainter, to_pixels: ToPixels, theme: Theme) -> None:
        """Pins, and how far those are from where they are wanted that hinder each other."""
        if self._document is not None:
            draw_pins(painter, self._document, to_pixels, theme, chosen=self._chosen, hovered=self._hovered)
