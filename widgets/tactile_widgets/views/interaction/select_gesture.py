"""Selection of taxels with the mouse, the same in both views.

A click picks a taxel; a drag draws a box, a lasso or a brush stroke. A press that moved is never a pick, even if the
pointer returns to where it began. ``TaxelSelector`` queries the view for covered and hidden taxels.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from PySide6.QtCore import QObject, QPointF, Qt, Signal
from PySide6.QtGui import QMouseEvent, QPainter

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray
from tactile_widgets.common.colours import Theme
from tactile_widgets.common.tool_kinds import BRUSH, SELECT_BOX, SELECT_BRUSH, SELECT_LASSO, SelectionMode, ToolKind
from tactile_widgets.document.taxel_selection import SelectionUpdate
from tactile_widgets.views.interaction.polyline import points_in_polygon, points_near_segment
from tactile_widgets.views.overlays.painting import polygon, rubber_pens

CLICK_PX = 4.0
"""Maximum distance between press and pointer in a click [px]."""
_LASSO_STEP_PX = 2.0

Pixel = tuple[float, float]


class TaxelLocator(Protocol):
    """A view that knows where taxels are drawn."""

    def taxel_pixels(self) -> FloatArray:
        """(taxels, 2) [px]; NaN for taxels that face away or are behind the camera."""

    def hidden(self, taxels: IntArray) -> BoolArray:
        """(k,) whether each of these taxels, though facing the camera, is hidden by something."""

    def taxel_at(self, pixel: Pixel) -> int | None:
        """Return the taxel that a click on ``pixel`` selects; None next to the skin."""


@dataclass(frozen=True, eq=False)
class RubberBand:
    """Outline of a selection gesture, drawn over a view [px].

    Attributes:
        outline: (k, 2) corners of the box or lasso.
        brush: Centre of the brush.
        radius: Radius of the brush.
    """

    outline: FloatArray | None = None
    brush: Pixel | None = None
    radius: float = BRUSH


class TaxelSelector(QObject):
    """State machine that turns the mouse events of one view into selections.

    Args:
        places: The view.
        parent: Qt parent.
    """

    chosen = Signal(SelectionUpdate)
    """Taxels were picked or swept."""
    abandoned = Signal()
    """The current sweep was cancelled."""
    drawn = Signal()
    """``rubber_band`` has changed."""

    def __init__(self, places: TaxelLocator, parent: QObject) -> None:
        super().__init__(parent)
        self._places = places
        self._tool = SELECT_BOX
        self._radius = BRUSH
        self._pointer: Pixel | None = None
        self._button = Qt.MouseButton.NoButton
        self._mode = SelectionMode.REPLACE
        self._path: list[Pixel] = []
        self._dragging = False
        self._covered: BoolArray = np.zeros(0, bool)
        self._hidden: IntArray = np.zeros(0, int)  # -1 while unknown

    @property
    def busy(self) -> bool:
        """Whether a button is held."""
        return bool(self._path)

    @property
    def rubber_band(self) -> RubberBand:
        """Shape to draw over the view."""
        return RubberBand(self._outline(), self._pointer, self._radius)

    def _outline(self) -> FloatArray | None:
        """(k, 2) box or lasso drawn so far [px]; None without one."""
        if not self._dragging or self._tool == SELECT_BRUSH:
            return None
        if self._tool == SELECT_LASSO:
            return np.array(self._path)
        left, top = self._path[0]
        right, bottom = self._path[-1]
        return np.array([[left, top], [right, top], [right, bottom], [left, bottom]])

    def set_tool(self, tool: ToolKind) -> None:
        """Set the selection tool; the current gesture is cancelled."""
        self.cancel()
        self._tool = tool
        self.leave()

    def set_radius(self, radius: float) -> None:
        """Set the radius of the brush [px]."""
        self._radius = radius
        self.drawn.emit()

    def press(self, event: QMouseEvent) -> None:
        """Start a gesture with the pressed button; another button during a gesture is ignored."""
        if self.busy:
            return
        pixel = event.position().toTuple()
        self._path = [pixel]
        self._mode = selection_mode_of(event.modifiers())
        self._button = event.button()
        self._dragging = self._tool == SELECT_BRUSH
        if self._dragging:
            self._sweep(np.array([pixel, pixel]), begins=True)

    def move(self, event: QMouseEvent) -> None:
        """Handle pointer motion, with or without a pressed button."""
        pixel = event.position().toTuple()
        self._pointer = pixel if self._tool == SELECT_BRUSH else None
        if self.busy and (self._dragging or math.dist(pixel, self._path[0]) > CLICK_PX):
            self._drag(pixel)
        if self._pointer is not None or self.busy:
            self.drawn.emit()

    def _drag(self, pixel: Pixel) -> None:
        begins = not self._dragging
        self._dragging = True
        line = np.array([self._path[-1], pixel])
        if self._tool == SELECT_BRUSH:
            self._path = [pixel]
        elif self._tool == SELECT_BOX:
            self._path = [self._path[0], pixel]
        elif math.dist(pixel, self._path[-1]) >= _LASSO_STEP_PX:
            self._path.append(pixel)
        outline = self._outline()
        self._sweep(line if outline is None else outline, begins=begins)

    def release(self, event: QMouseEvent) -> None:
        """Finish the gesture if it began with this button; without a drag it picks one taxel."""
        if self.busy and event.button() == self._button:
            clicked = not self._dragging
            pixel = self._path[0]
            self._path = []
            self._dragging = False
            if clicked:
                taxel = self._places.taxel_at(pixel)
                # With a key that adds, a second click on the same taxel removes it again.
                mode = SelectionMode.TOGGLE if self._mode is SelectionMode.ADD else self._mode
                self.chosen.emit(SelectionUpdate(np.array([] if taxel is None else [taxel], int), mode))
        self.drawn.emit()

    def leave(self) -> None:
        """Handle the pointer leaving the view."""
        self._pointer = None
        self.drawn.emit()

    def cancel(self) -> None:
        """Cancel the gesture and its selection."""
        swept = self._dragging
        self._path = []
        self._dragging = False
        if swept:
            self.abandoned.emit()
        self.drawn.emit()

    def _sweep(self, line: FloatArray, *, begins: bool) -> None:
        """Select what the gesture covers; ``line`` is the whole outline, or the latest segment of the brush [px]."""
        pixels = self._places.taxel_pixels()
        if begins:
            self._covered = np.zeros(len(pixels), bool)
            self._hidden = np.full(len(pixels), -1)
        if self._tool == SELECT_BRUSH:
            covered = self._covered | self._visible(points_near_segment(line, pixels, self._radius))
        else:
            covered = self._visible(points_in_polygon(line, pixels))
        if begins or not np.array_equal(covered, self._covered):
            self._covered = covered
            self.chosen.emit(SelectionUpdate(np.flatnonzero(covered), self._mode, begins))

    def _visible(self, covered: BoolArray) -> BoolArray:
        """Exclude hidden taxels; each taxel is tested once per gesture."""
        unknown = np.flatnonzero(covered & (self._hidden < 0))
        if len(unknown):
            self._hidden[unknown] = self._places.hidden(unknown)
        return covered & (self._hidden != 1)


def selection_mode_of(keys: Qt.KeyboardModifier) -> SelectionMode:
    """Return the mode that the keys held with a press select: Control or Shift adds, Alt removes."""
    if keys & Qt.KeyboardModifier.AltModifier:
        return SelectionMode.REMOVE
    adds = keys & (Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.ShiftModifier)
    return SelectionMode.ADD if adds else SelectionMode.REPLACE


def paint_rubber_band(painter: QPainter, rubber_band: RubberBand, theme: Theme) -> None:
    """Draw box, lasso or brush in the viewport's pixels, a dashed line on a dark one that contrasts with the skin."""
    painter.setBrush(Qt.BrushStyle.NoBrush)
    for pen in rubber_pens(theme):
        painter.setPen(pen)
        if rubber_band.outline is not None:
            painter.drawPolygon(polygon(rubber_band.outline))
        if rubber_band.brush is not None:
            painter.drawEllipse(QPointF(*rubber_band.brush), rubber_band.radius, rubber_band.radius)
