"""What the tools for path and target share: the settings they edit, the force handle, and places of the body as map
points.

The force handle is a small plate with the wanted newtons, dragged up or down, turned by the wheel or by keys.
"""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QObject, QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QKeyEvent, QMouseEvent, QPainter, QPen, QWheelEvent

from tactile_maps.control.motion.command import RANGES
from tactile_maps.core.arrays import FloatArray
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_widgets.common.colours import Theme
from tactile_widgets.tools.control.control_settings_editor import ControlSettingsEditor
from tactile_widgets.views.interaction.view_tool import PointerHit, ToPixels, ViewTool
from tactile_widgets.views.overlays.body_overlays import NO_MARKS, ToolMarks

FORCE_STEP = 0.5
"""Of the force [N]."""
PIXELS_PER_STEP = 8.0
"""Dragged for one step."""
FORCE_STEP_NAME = "set the force"
_NOTCH = 120
_KEYS = {Qt.Key.Key_PageUp: 1, Qt.Key.Key_PageDown: -1}
_AWAY = QPointF(16.0, -34.0)
"""Of its upper left corner from what it belongs to [px]."""


class ForceHandle:
    """Mutable; it is where it was painted last.

    Args:
        lead: Whom to ask.

    Attributes:
        held: Whether it is being dragged.
    """

    def __init__(self, lead: ControlSettingsEditor) -> None:
        self._settings_editor = lead
        self._box = QRectF()
        self.held = False
        self._from = (0.0, 0.0)
        self._rolled = 0

    def holds(self, pixel: QPointF) -> bool:
        """Whether a pixel of the map is on it."""
        return self._box.contains(pixel)

    def press(self, event: QMouseEvent) -> bool:
        """Take it, if it is there."""
        self.held = self.holds(event.position())
        if self.held:
            self._from = event.position().y(), self._settings_editor.settings.force_goal
            self._settings_editor.begin(FORCE_STEP_NAME)
        return self.held

    def drag(self, event: QMouseEvent) -> None:
        """Up is more."""
        y, force = self._from
        self._settings_editor.change(force_goal=_stepped(force, round((y - event.position().y()) / PIXELS_PER_STEP)))

    def release(self) -> None:
        """The drag is one step."""
        self.held = False
        self._settings_editor.end()

    def cancel(self) -> bool:
        """The drag never was; whether there was one."""
        held = self.held
        self.held = False
        if held:
            self._settings_editor.cancel()
        return held

    def turn(self, steps: int) -> None:
        """So many steps more, or less where negative; one after the other they are taken back together."""
        self._settings_editor.do(
            FORCE_STEP_NAME, goes_on=True, force_goal=_stepped(self._settings_editor.settings.force_goal, steps)
        )

    def roll(self, eighths: int) -> None:
        """The wheel turned by so many eighths of a degree; fine wheels add up to a notch."""
        self._rolled += eighths
        notches = int(self._rolled / _NOTCH)
        self._rolled -= notches * _NOTCH
        if notches:
            self.turn(notches)

    def key(self, key: Qt.Key) -> bool:
        """Page Up and Page Down; whether it was one of them."""
        if key in _KEYS and not self.held:
            self.turn(_KEYS[key])
        return key in _KEYS

    def hide(self) -> None:
        """It is nowhere."""
        self._box = QRectF()

    def paint(self, painter: QPainter, at: QPointF, theme: Theme, *, hovered: bool) -> None:
        """Draw it beside ``at`` [px]: the goal, and grooves that say that it moves up and down."""
        font = QFont(painter.font())
        font.setPixelSize(13)
        font.setWeight(QFont.Weight.DemiBold)
        metrics = QFontMetricsF(font)
        text = f"{self._settings_editor.settings.force_goal:.1f}\u202fN"
        width = metrics.horizontalAdvance("00.0\u202fN") + 26
        self._box = QRectF(at + _AWAY, at + _AWAY + QPointF(width, 24))
        ink = QColor(theme.intent)
        painter.setPen(QPen(ink, 2.0 if hovered or self.held else 1.2))
        painter.setBrush(QColor(theme.panel))
        painter.drawRoundedRect(self._box, 4, 4)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.setFont(font)
        painter.setPen(QColor(theme.text))
        painter.drawText(self._box.adjusted(6, 0, -16, 0), Qt.AlignmentFlag.AlignCenter, text)
        painter.setPen(QPen(ink, 1.6, Qt.PenStyle.SolidLine, Qt.PenCapStyle.RoundCap))
        x = self._box.right() - 11
        y = self._box.center().y()
        for way in (-1, 1):
            painter.drawPolyline([QPointF(x + dx, y + way * dy) for dx, dy in ((-3.5, 3), (0, 6.5), (3.5, 3))])


def _stepped(force: float, steps: int) -> float:
    """A whole number of steps, within what may be set."""
    low, high = RANGES["force_goal"]
    return min(max(FORCE_STEP * (round(force / FORCE_STEP) + steps), low), high)


REACH_PX = 8.0
STEP = 1e-3
FINE_STEP = 1e-4
"""How far an arrow key moves what is led [m], and with Shift."""
_ARROWS = {
    Qt.Key.Key_Left: (-1.0, 0.0),
    Qt.Key.Key_Right: (1.0, 0.0),
    Qt.Key.Key_Up: (0.0, 1.0),
    Qt.Key.Key_Down: (0.0, -1.0),
}


class ControlTool(ViewTool):
    """A tool that asks the lead for settings. What is said of the map holds for the body, where a place of the skin is
    its point of the map.

    Args:
        lead: Whom to ask.
        parent: Qt parent.
    """

    def __init__(self, lead: ControlSettingsEditor, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._settings_editor = lead
        self._plate = ForceHandle(lead)
        self._place = PointerHit(None, None, 1.0)
        self._pixel: QPointF | None = None
        self._marks: ToolMarks | None = None
        lead.changed.connect(self._redraw)

    @property
    def _map(self) -> TactileMap | None:
        """What can be drawn on; None while no arm can be led."""
        return self._settings_editor.map if self._settings_editor.enabled else None

    def _point(self, place: PointerHit) -> FloatArray | None:
        """(2,) the map point [m] that is meant in either view; None beside the skin of the body.

        While no arm can be led, none of the body's: what is shown then, as a recording, may wear another skin.
        """
        if place.point is not None or place.at is None or self._map is None:
            return place.point
        return self._map.to_map(place.at)

    def _at(self, place: PointerHit) -> SurfacePoint | None:
        return None if self._map is None else place.at

    def _on_plate(self, place: PointerHit, pixel: QPointF | None) -> bool:
        """Whether the force is under the pointer: on the map only, where the plate is."""
        return place.point is not None and pixel is not None and self._plate.holds(pixel)

    def _hover(self, place: PointerHit, event: QMouseEvent) -> None:
        self._place = place
        self._pixel = event.position()

    def wheel(self, place: PointerHit, event: QWheelEvent) -> bool:
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
        self._place = PointerHit(None, None, 1.0)
        self._pixel = None
        self._redraw()

    def body_marks(self) -> ToolMarks:
        """The same object until something changes."""
        if self._marks is None:
            self._marks = NO_MARKS if self._map is None else self._mark_body(self._map)
        return self._marks

    def _mark_body(self, map_: TactileMap) -> ToolMarks:
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
