"""What the tools that lead the arm share: the lead they ask, the force plate, and places of the body as map points."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QObject, QPointF, Qt
from PySide6.QtGui import QKeyEvent, QMouseEvent, QPainter, QWheelEvent

from app.arrays import FloatArray
from app.geometry.surface_point import SurfacePoint
from app.maps.tactile_map import TactileMap
from widgets.body_marks import NO_MARKS, BodyMarks
from widgets.colours import Theme
from widgets.control_tools.force_plate import ForcePlate
from widgets.control_tools.lead import Lead
from widgets.edit_tool import EditTool, Place, ToPixels

REACH_PX = 8.0
STEP, FINE_STEP = 1e-3, 1e-4
"""How far an arrow key moves what is led [m], and with Shift."""
_ARROWS = {
    Qt.Key.Key_Left: (-1.0, 0.0),
    Qt.Key.Key_Right: (1.0, 0.0),
    Qt.Key.Key_Up: (0.0, 1.0),
    Qt.Key.Key_Down: (0.0, -1.0),
}


class LeadTool(EditTool):
    """A tool that asks the lead for settings. What is said of the map holds for the body, where a place of the skin is
    its point of the map.

    Args:
        lead: Whom to ask.
        parent: Qt parent.
    """

    def __init__(self, lead: Lead, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._lead, self._plate = lead, ForcePlate(lead)
        self._place = Place(None, None, 1.0)
        self._pixel: QPointF | None = None
        self._marks: BodyMarks | None = None
        lead.changed.connect(self._redraw)

    @property
    def _map(self) -> TactileMap | None:
        """What can be drawn on; None while no arm can be led."""
        return self._lead.map if self._lead.enabled else None

    def _point(self, place: Place) -> FloatArray | None:
        """(2,) the map point [m] that is meant in either view; None beside the skin of the body."""
        if place.point is not None or place.at is None or self._lead.map is None:
            return place.point
        return self._lead.map.to_map(place.at)

    def _at(self, place: Place) -> SurfacePoint | None:
        return None if self._map is None else place.at

    def _on_plate(self, place: Place, pixel: QPointF | None) -> bool:
        """Whether the force is under the pointer: on the map only, where the plate is."""
        return place.point is not None and pixel is not None and self._plate.holds(pixel)

    def _hover(self, place: Place, event: QMouseEvent) -> None:
        self._place, self._pixel = place, event.position()

    def wheel(self, place: Place, event: QWheelEvent) -> bool:
        """On the plate it turns the force."""
        if self._map is None or not self._on_plate(place, event.position()):
            return False
        self._plate.roll(event.angleDelta().y())
        return True

    def key(self, event: QKeyEvent) -> bool:
        """Page Up and Page Down turn the force."""
        return self._map is not None and self._plate.key(Qt.Key(event.key()))

    def cancel(self) -> bool:
        """The force as it was before the drag."""
        return self._plate.cancel()

    def leave(self) -> None:
        """Nothing is under the pointer."""
        self._place, self._pixel = Place(None, None, 1.0), None
        self._redraw()

    def body_marks(self) -> BodyMarks:
        """The same object until something changes."""
        if self._marks is None:
            self._marks = NO_MARKS if self._lead.map is None else self._mark_body(self._lead.map)
        return self._marks

    def _mark_body(self, map_: TactileMap) -> BodyMarks:
        return NO_MARKS

    def _redraw(self) -> None:
        self._marks = None
        self.drawn.emit()

    def _paint_plate(self, painter: QPainter, to_pixels: ToPixels, theme: Theme, at: FloatArray | None) -> None:
        """Beside a map point (2,) [m]; nowhere for None."""
        if at is None:
            self._plate.hide()
            return
        hovered = self._on_plate(self._place, self._pixel)
        self._plate.paint(painter, QPointF(*to_pixels(at[None])[0].tolist()), theme, hovered=hovered)


def nudge_of(event: QKeyEvent) -> FloatArray | None:
    """(2,) how far an arrow key moves on the map [m]; None for other keys."""
    arrow = _ARROWS.get(Qt.Key(event.key()))
    fine = bool(event.modifiers() & Qt.KeyboardModifier.ShiftModifier)
    return None if arrow is None else (FINE_STEP if fine else STEP) * np.array(arrow)
