"""Choosing taxels with the mouse, the same in every view: from gestures in pixels to taxels, and how they are drawn."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, assert_never

import numpy as np
from PySide6.QtCore import QObject, QPointF, Qt, Signal
from PySide6.QtGui import QColor, QMouseEvent, QPainter, QPen, QPolygonF

from app.arrays import BoolArray, FloatArray, IntArray
from widgets.colours import Theme
from widgets.select_hand import Picked, Pixel, SelectHand, Swept, inside, near
from widgets.selection import Choice
from widgets.tools import BRUSH, Change, Tool


class TaxelPlaces(Protocol):
    """A view that knows where taxels are in it."""

    def taxel_pixels(self) -> FloatArray:
        """(taxels, 2) [px]; NaN for those turned away or behind the eye."""

    def hidden(self, taxels: IntArray) -> BoolArray:
        """(k,) which of these, though turned to the eye, something hides."""

    def taxel_at(self, pixel: Pixel) -> int | None:
        """The taxel that a click there means; None beside the skin."""


@dataclass(frozen=True, eq=False)
class Rubber:
    """What a gesture draws over a view [px].

    Attributes:
        outline: (k, 2) of the box or lasso.
        brush: Middle of the brush.
        radius: Of the brush.
    """

    outline: FloatArray | None = None
    brush: Pixel | None = None
    radius: float = BRUSH


class Chooser(QObject):
    """Gestures on one view in, choices out. Mutable.

    Args:
        places: The view.
        parent: Qt parent.
    """

    chosen = Signal(object)
    """A Choice."""
    abandoned = Signal()
    """The choice made so far was given up."""
    drawn = Signal()
    """``rubber`` has changed."""

    def __init__(self, places: TaxelPlaces, parent: QObject) -> None:
        super().__init__(parent)
        self._places, self._hand = places, SelectHand()
        self._radius = BRUSH
        self._pointer: Pixel | None = None
        self._covered: BoolArray = np.zeros(0, bool)
        self._hides: IntArray = np.zeros(0, int)

    @property
    def busy(self) -> bool:
        """Whether a button is held."""
        return self._hand.busy

    @property
    def rubber(self) -> Rubber:
        """What to draw over the view."""
        return Rubber(self._hand.outline, self._pointer, self._radius)

    def set_tool(self, tool: Tool) -> None:
        """Take a tool; a gesture that is going on is given up."""
        self.cancel()
        self._hand.tool = tool
        self.leave()

    def set_radius(self, radius: float) -> None:
        """Take a brush of this radius [px]."""
        self._radius = radius
        self.drawn.emit()

    def press(self, event: QMouseEvent) -> None:
        """The left button went down."""
        self._act(self._hand.press(event.position().toTuple(), change_of(event.modifiers()), button=event.button()))

    def move(self, event: QMouseEvent) -> None:
        """The pointer moved, held or not."""
        self._pointer = event.position().toTuple() if self._hand.tool is Tool.BRUSH else None
        self._act(self._hand.move(event.position().toTuple()))
        if self._pointer is not None or self.busy:
            self.drawn.emit()

    def release(self, event: QMouseEvent) -> None:
        """A button came up."""
        self._act(self._hand.release(button=event.button()))
        self.drawn.emit()

    def leave(self) -> None:
        """The pointer left the view."""
        self._pointer = None
        self.drawn.emit()

    def cancel(self) -> None:
        """Give the gesture up, and what it chose."""
        if self._hand.cancel():
            self.abandoned.emit()
        self.drawn.emit()

    def _act(self, act: Picked | Swept | None) -> None:
        if isinstance(act, Picked):
            taxel = self._places.taxel_at(act.pixel)
            self.chosen.emit(Choice(np.array([] if taxel is None else [taxel], int), act.change))
        elif isinstance(act, Swept):
            self._sweep(act)
        elif act is not None:
            assert_never(act)

    def _sweep(self, act: Swept) -> None:
        pixels = self._places.taxel_pixels()
        if act.begins:
            self._covered, self._hides = np.zeros(len(pixels), bool), np.full(len(pixels), -1)
        if self._hand.tool is Tool.BRUSH:
            covered = self._covered | self._seen(near(act.line, pixels, self._radius))
        else:
            covered = self._seen(inside(act.line, pixels))
        if act.begins or not np.array_equal(covered, self._covered):
            self._covered = covered
            self.chosen.emit(Choice(np.flatnonzero(covered), act.change, act.begins))

    def _seen(self, covered: BoolArray) -> BoolArray:
        """Those of the covered taxels that nothing hides; each is looked at once a gesture."""
        unknown = np.flatnonzero(covered & (self._hides < 0))
        if len(unknown):
            self._hides[unknown] = self._places.hidden(unknown)
        return covered & (self._hides != 1)


def change_of(keys: Qt.KeyboardModifier) -> Change:
    """What the keys held with a press mean: Control or Shift adds, Alt removes."""
    if keys & Qt.KeyboardModifier.AltModifier:
        return Change.REMOVE
    adds = keys & (Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.ShiftModifier)
    return Change.ADD if adds else Change.REPLACE


def paint_rubber(painter: QPainter, rubber: Rubber, theme: Theme) -> None:
    """Draw box, lasso or brush in the viewport's pixels: a dark line under a dashed one, to be seen on any ground."""
    painter.setBrush(Qt.BrushStyle.NoBrush)
    for colour, style in (
        (QColor(29, 33, 38, 170), Qt.PenStyle.SolidLine),
        (QColor(theme.accent), Qt.PenStyle.DashLine),
    ):
        pen = QPen(colour, 1.5)
        pen.setStyle(style)
        painter.setPen(pen)
        if rubber.outline is not None:
            painter.drawPolygon(QPolygonF([QPointF(x, y) for x, y in rubber.outline.tolist()]))
        if rubber.brush is not None:
            painter.drawEllipse(QPointF(*rubber.brush), rubber.radius, rubber.radius)
