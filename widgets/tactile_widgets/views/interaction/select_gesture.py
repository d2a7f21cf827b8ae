"""Selecting taxels with the mouse, the same in every view: from gestures in pixels to taxels, and how they are drawn.

``SelectGesture`` is a small state machine without Qt: a click picks, a drag draws box, lasso or stroke; a press that
moved is never a pick, even if it came back to where it began. ``TaxelSelector`` feeds it with Qt's events and asks the
view which taxels are covered and which of them are hidden.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from typing import Protocol, assert_never

import numpy as np
from PySide6.QtCore import QObject, QPointF, Qt, Signal
from PySide6.QtGui import QColor, QMouseEvent, QPainter, QPen, QPolygonF

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray
from tactile_widgets.common.colours import Theme
from tactile_widgets.common.tool_kinds import BRUSH, SELECT_BOX, SELECT_BRUSH, SELECT_LASSO, SelectionMode, ToolKind
from tactile_widgets.document.taxel_selection import SelectionUpdate

CLICK_PX = 4.0
"""A press that stays within this of where it began is a click [px]."""
_LASSO_STEP_PX = 2.0

Pixel = tuple[float, float]


@dataclass(frozen=True)
class Picked:
    """A click at ``pixel``."""

    pixel: Pixel
    change: SelectionMode


@dataclass(frozen=True, eq=False)
class Swept:
    """A drag has drawn so far.

    Attributes:
        line: (k, 2) corners of the box, the lasso's path or the brush's newest stretch [px].
        change: What it does to what was chosen before the drag began.
        begins: Whether this is the drag's first act.
    """

    line: FloatArray
    change: SelectionMode
    begins: bool


class SelectGesture:
    """Turns presses, moves and releases into picks and sweeps. Mutable; ``cancel`` brings it back to idle."""

    def __init__(self) -> None:
        self.tool = SELECT_BOX
        self._path: list[Pixel] = []
        self._change = SelectionMode.REPLACE
        self._button: Hashable = None
        self._dragging = False

    @property
    def busy(self) -> bool:
        """Whether a button is held."""
        return bool(self._path)

    @property
    def outline(self) -> FloatArray | None:
        """(k, 2) of the box or lasso being drawn [px]; None while there is none."""
        if not self._dragging or self.tool == SELECT_BRUSH:
            return None
        if self.tool == SELECT_LASSO:
            return np.array(self._path)
        (left, top), (right, bottom) = self._path[0], self._path[-1]
        return np.array([[left, top], [right, top], [right, bottom], [left, bottom]])

    def press(self, pixel: Pixel, change: SelectionMode, *, button: Hashable = None) -> Swept | None:
        """``button`` went down."""
        if self.busy:
            return None
        self._path = [pixel]
        self._change = change
        self._button = button
        self._dragging = self.tool == SELECT_BRUSH
        return Swept(np.array([pixel, pixel]), change, True) if self._dragging else None

    def move(self, pixel: Pixel) -> Swept | None:
        """The pointer moved."""
        if not self.busy:
            return None
        begins = not self._dragging
        if begins and np.hypot(pixel[0] - self._path[0][0], pixel[1] - self._path[0][1]) <= CLICK_PX:
            return None
        self._dragging = True
        if self.tool == SELECT_BRUSH:
            stretch = np.array([self._path[-1], pixel])
            self._path = [pixel]
            return Swept(stretch, self._change, False)
        if self.tool == SELECT_BOX:
            self._path = [self._path[0], pixel]
        elif np.hypot(pixel[0] - self._path[-1][0], pixel[1] - self._path[-1][1]) >= _LASSO_STEP_PX:
            self._path.append(pixel)
        assert self.outline is not None
        return Swept(self.outline, self._change, begins)

    def release(self, *, button: Hashable = None) -> Picked | None:
        """``button`` came up; only the one that began the hold ends it."""
        if not self.busy or button != self._button:
            return None
        clicked = not self._dragging
        pixel = self._path[0]
        self.cancel()
        # With a key that adds, a second click on the same taxel takes it out again.
        change = SelectionMode.TOGGLE if self._change is SelectionMode.ADD else self._change
        return Picked(pixel, change) if clicked else None

    def cancel(self) -> bool:
        """Escape was pressed or the focus went. Whether a drag was given up."""
        given_up = self._dragging
        self._path = []
        self._dragging = False
        return given_up


def points_in_polygon(outline: FloatArray, points: FloatArray) -> BoolArray:
    """(n,) which of ``points`` (n, 2) an outline (k, 2) encloses, by the even-odd rule; NaN is nowhere.

    Cost: 3 ms for 1000 points and a lasso of 300.
    """
    start = outline[:, None]
    end = np.roll(outline, -1, axis=0)[:, None]
    x, y = points.T
    spans = (start[..., 1] > y) != (end[..., 1] > y)
    rise = np.where(end[..., 1] == start[..., 1], 1.0, end[..., 1] - start[..., 1])
    with np.errstate(invalid="ignore"):
        left = x < start[..., 0] + (y - start[..., 1]) * (end[..., 0] - start[..., 0]) / rise
    return np.asarray((spans & left).sum(axis=0) % 2 == 1)


def points_near_segment(stretch: FloatArray, points: FloatArray, radius: float) -> BoolArray:
    """(n,) which of ``points`` (n, 2) lie within ``radius`` of a straight stretch (2, 2); NaN is nowhere."""
    start = stretch[0]
    along = stretch[1] - stretch[0]
    length = float(along @ along)
    with np.errstate(invalid="ignore"):
        share = np.clip((points - start) @ along / length, 0, 1) if length > 0 else np.zeros(len(points))
        away = points - (start + share[:, None] * along)
        return np.asarray((away**2).sum(axis=1) <= radius**2)


class TaxelLocator(Protocol):
    """A view that knows where taxels are in it."""

    def taxel_pixels(self) -> FloatArray:
        """(taxels, 2) [px]; NaN for those turned away or behind the eye."""

    def hidden(self, taxels: IntArray) -> BoolArray:
        """(k,) which of these, though turned to the eye, something hides."""

    def taxel_at(self, pixel: Pixel) -> int | None:
        """The taxel that a click there means; None beside the skin."""


@dataclass(frozen=True, eq=False)
class RubberBand:
    """What a gesture draws over a view [px].

    Attributes:
        outline: (k, 2) of the box or lasso.
        brush: Middle of the brush.
        radius: Of the brush.
    """

    outline: FloatArray | None = None
    brush: Pixel | None = None
    radius: float = BRUSH


class TaxelSelector(QObject):
    """Gestures on one view in, choices out. Mutable.

    Args:
        places: The view.
        parent: Qt parent.
    """

    chosen = Signal(SelectionUpdate)
    """Taxels were picked or swept."""
    abandoned = Signal()
    """The choice made so far was given up."""
    drawn = Signal()
    """``rubber_band`` has changed."""

    def __init__(self, places: TaxelLocator, parent: QObject) -> None:
        super().__init__(parent)
        self._places = places
        self._hand = SelectGesture()
        self._radius = BRUSH
        self._pointer: Pixel | None = None
        self._covered: BoolArray = np.zeros(0, bool)
        self._hides: IntArray = np.zeros(0, int)

    @property
    def busy(self) -> bool:
        """Whether a button is held."""
        return self._hand.busy

    @property
    def rubber_band(self) -> RubberBand:
        """What to draw over the view."""
        return RubberBand(self._hand.outline, self._pointer, self._radius)

    def set_tool(self, tool: ToolKind) -> None:
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
        self._act(
            self._hand.press(event.position().toTuple(), selection_mode_of(event.modifiers()), button=event.button())
        )

    def move(self, event: QMouseEvent) -> None:
        """The pointer moved, held or not."""
        self._pointer = event.position().toTuple() if self._hand.tool == SELECT_BRUSH else None
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
            self.chosen.emit(SelectionUpdate(np.array([] if taxel is None else [taxel], int), act.change))
        elif isinstance(act, Swept):
            self._sweep(act)
        elif act is not None:
            assert_never(act)

    def _sweep(self, act: Swept) -> None:
        pixels = self._places.taxel_pixels()
        if act.begins:
            self._covered = np.zeros(len(pixels), bool)
            self._hides = np.full(len(pixels), -1)
        if self._hand.tool == SELECT_BRUSH:
            covered = self._covered | self._seen(points_near_segment(act.line, pixels, self._radius))
        else:
            covered = self._seen(points_in_polygon(act.line, pixels))
        if act.begins or not np.array_equal(covered, self._covered):
            self._covered = covered
            self.chosen.emit(SelectionUpdate(np.flatnonzero(covered), act.change, act.begins))

    def _seen(self, covered: BoolArray) -> BoolArray:
        """Those of the covered taxels that nothing hides; each is looked at once a gesture."""
        unknown = np.flatnonzero(covered & (self._hides < 0))
        if len(unknown):
            self._hides[unknown] = self._places.hidden(unknown)
        return covered & (self._hides != 1)


def selection_mode_of(keys: Qt.KeyboardModifier) -> SelectionMode:
    """What the keys held with a press mean: Control or Shift adds, Alt removes."""
    if keys & Qt.KeyboardModifier.AltModifier:
        return SelectionMode.REMOVE
    adds = keys & (Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.ShiftModifier)
    return SelectionMode.ADD if adds else SelectionMode.REPLACE


def paint_rubber_band(painter: QPainter, rubber_band: RubberBand, theme: Theme) -> None:
    """Draw box, lasso or brush in the viewport's pixels: a dark line under a dashed one, to be seen on any ground."""
    painter.setBrush(Qt.BrushStyle.NoBrush)
    for colour, style in (
        (QColor(29, 33, 38, 170), Qt.PenStyle.SolidLine),
        (QColor(theme.accent), Qt.PenStyle.DashLine),
    ):
        pen = QPen(colour, 1.5)
        pen.setStyle(style)
        painter.setPen(pen)
        if rubber_band.outline is not None:
            painter.drawPolygon(QPolygonF([QPointF(x, y) for x, y in rubber_band.outline.tolist()]))
        if rubber_band.brush is not None:
            painter.drawEllipse(QPointF(*rubber_band.brush), rubber_band.radius, rubber_band.radius)
