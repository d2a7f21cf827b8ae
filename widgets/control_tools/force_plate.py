"""The wanted force as a handle: a small plate with its newtons, dragged up or down, turned by the wheel or by keys."""

from __future__ import annotations

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QMouseEvent, QPainter, QPen

from app.control.settings_check import RANGES
from widgets.colours import Theme
from widgets.control_tools.lead import Lead

STEP = 0.5
"""Of the force [N]."""
PIXELS = 8.0
"""Dragged for one step."""
NAME = "set the force"
_NOTCH = 120
_KEYS = {Qt.Key.Key_PageUp: 1, Qt.Key.Key_PageDown: -1}
_AWAY = QPointF(16.0, -34.0)
"""Of its upper left corner from what it belongs to [px]."""


class ForcePlate:
    """Mutable; it is where it was painted last.

    Args:
        lead: Whom to ask.

    Attributes:
        held: Whether it is being dragged.
    """

    def __init__(self, lead: Lead) -> None:
        self._lead, self._box, self.held = lead, QRectF(), False
        self._from, self._rolled = (0.0, 0.0), 0

    def holds(self, pixel: QPointF) -> bool:
        """Whether a pixel of the map is on it."""
        return self._box.contains(pixel)

    def press(self, event: QMouseEvent) -> bool:
        """Take it, if it is there."""
        self.held = self.holds(event.position())
        if self.held:
            self._from = event.position().y(), self._lead.settings.force_goal
            self._lead.begin(NAME)
        return self.held

    def drag(self, event: QMouseEvent) -> None:
        """Up is more."""
        y, force = self._from
        self._lead.change(force_goal=_stepped(force, round((y - event.position().y()) / PIXELS)))

    def release(self) -> None:
        """The drag is one step."""
        self.held = False
        self._lead.end()

    def cancel(self) -> bool:
        """The drag never was; whether there was one."""
        held, self.held = self.held, False
        if held:
            self._lead.cancel()
        return held

    def turn(self, steps: int) -> None:
        """So many steps more, or less where negative; one after the other they are taken back together."""
        self._lead.do(NAME, goes_on=True, force_goal=_stepped(self._lead.settings.force_goal, steps))

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
        metrics, text = QFontMetricsF(font), f"{self._lead.settings.force_goal:.1f}\u2009N"
        width = metrics.horizontalAdvance("00.0\u2009N") + 26
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
        x, y = self._box.right() - 11, self._box.center().y()
        for way in (-1, 1):
            painter.drawPolyline([QPointF(x + dx, y + way * dy) for dx, dy in ((-3.5, 3), (0, 6.5), (3.5, 3))])


def _stepped(force: float, steps: int) -> float:
    """A whole number of steps, within what may be set."""
    low, high = RANGES["force_goal"]
    return min(max(STEP * (round(force / STEP) + steps), low), high)
