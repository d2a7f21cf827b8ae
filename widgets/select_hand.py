"""The hand that chooses taxels, as a small state machine without Qt: a click picks, a drag draws box, lasso or stroke.

A press that moved is never a pick, even if it came back to where it began.
"""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass

import numpy as np

from app.arrays import BoolArray, FloatArray
from widgets.tools import Change, Tool

CLICK_PX = 4.0
"""A press that stays within this of where it began is a click [px]."""
_LASSO_STEP_PX = 2.0

Pixel = tuple[float, float]


@dataclass(frozen=True)
class Picked:
    """A click at ``pixel``."""

    pixel: Pixel
    change: Change


@dataclass(frozen=True, eq=False)
class Swept:
    """A drag has drawn so far.

    Attributes:
        line: (k, 2) corners of the box, the lasso's path or the brush's newest stretch [px].
        change: What it does to what was chosen before the drag began.
        begins: Whether this is the drag's first act.
    """

    line: FloatArray
    change: Change
    begins: bool


class SelectHand:
    """Turns presses, moves and releases into picks and sweeps. Mutable; ``cancel`` brings it back to idle."""

    def __init__(self) -> None:
        self.tool = Tool.BOX
        self._path: list[Pixel] = []
        self._change = Change.REPLACE
        self._button: Hashable = None
        self._dragging = False

    @property
    def busy(self) -> bool:
        """Whether a button is held."""
        return bool(self._path)

    @property
    def outline(self) -> FloatArray | None:
        """(k, 2) of the box or lasso being drawn [px]; None while there is none."""
        if not self._dragging or self.tool is Tool.BRUSH:
            return None
        if self.tool is Tool.LASSO:
            return np.array(self._path)
        (left, top), (right, bottom) = self._path[0], self._path[-1]
        return np.array([[left, top], [right, top], [right, bottom], [left, bottom]])

    def press(self, pixel: Pixel, change: Change, *, button: Hashable = None) -> Swept | None:
        """``button`` went down."""
        if self.busy:
            return None
        self._path, self._change, self._button, self._dragging = [pixel], change, button, self.tool is Tool.BRUSH
        return Swept(np.array([pixel, pixel]), change, True) if self._dragging else None

    def move(self, pixel: Pixel) -> Swept | None:
        """The pointer moved."""
        if not self.busy:
            return None
        begins = not self._dragging
        if begins and np.hypot(pixel[0] - self._path[0][0], pixel[1] - self._path[0][1]) <= CLICK_PX:
            return None
        self._dragging = True
        if self.tool is Tool.BRUSH:
            stretch = np.array([self._path[-1], pixel])
            self._path = [pixel]
            return Swept(stretch, self._change, False)
        if self.tool is Tool.BOX:
            self._path = [self._path[0], pixel]
        elif np.hypot(pixel[0] - self._path[-1][0], pixel[1] - self._path[-1][1]) >= _LASSO_STEP_PX:
            self._path.append(pixel)
        assert self.outline is not None
        return Swept(self.outline, self._change, begins)

    def release(self, *, button: Hashable = None) -> Picked | None:
        """``button`` came up; only the one that began the hold ends it."""
        if not self.busy or button != self._button:
            return None
        clicked, pixel = not self._dragging, self._path[0]
        self.cancel()
        # With a key that adds, a second click on the same taxel takes it out again.
        change = Change.TOGGLE if self._change is Change.ADD else self._change
        return Picked(pixel, change) if clicked else None

    def cancel(self) -> bool:
        """Escape was pressed or the focus went. Whether a drag was given up."""
        given_up, self._path, self._dragging = self._dragging, [], False
        return given_up


def inside(outline: FloatArray, points: FloatArray) -> BoolArray:
    """(n,) which of ``points`` (n, 2) an outline (k, 2) encloses, by the even-odd rule; NaN is nowhere.

    Cost: 3 ms for 1000 points and a lasso of 300.
    """
    start, end = outline[:, None], np.roll(outline, -1, axis=0)[:, None]
    x, y = points.T
    spans = (start[..., 1] > y) != (end[..., 1] > y)
    rise = np.where(end[..., 1] == start[..., 1], 1.0, end[..., 1] - start[..., 1])
    with np.errstate(invalid="ignore"):
        left = x < start[..., 0] + (y - start[..., 1]) * (end[..., 0] - start[..., 0]) / rise
    return np.asarray((spans & left).sum(axis=0) % 2 == 1)


def near(stretch: FloatArray, points: FloatArray, radius: float) -> BoolArray:
    """(n,) which of ``points`` (n, 2) lie within ``radius`` of a straight stretch (2, 2); NaN is nowhere."""
    start, along = stretch[0], stretch[1] - stretch[0]
    length = float(along @ along)
    with np.errstate(invalid="ignore"):
        share = np.clip((points - start) @ along / length, 0, 1) if length > 0 else np.zeros(len(points))
        away = points - (start + share[:, None] * along)
        return np.asarray((away**2).sum(axis=1) <= radius**2)
