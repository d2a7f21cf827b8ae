"""A path while it is drawn, without Qt: corners clicked, a stroke of the hand, the pointer that would be the next."""

from __future__ import annotations

import numpy as np

from app.arrays import FloatArray
from app.control.command import PathKind
from widgets.control_tools.path_shape import FREE, PathShape, as_points
from widgets.simplify import simplified

_MOST_CORNERS = 200
"""Of a stroke: with more, none of them could be taken hold of."""


class PathSketch:
    """Begins with a press at a map point. Mutable.

    Args:
        kind: What is drawn.
        start: (2,) [m].
    """

    def __init__(self, kind: PathKind, start: FloatArray) -> None:
        self._kind, self._corners = kind, [start]
        self._stroke: list[FloatArray] | None = [start]
        self._tip, self._drawn, self._closed = start, False, False

    @property
    def _free(self) -> bool:
        return self._kind in FREE

    @property
    def can_end(self) -> bool:
        """Whether it is a path already."""
        return len(self._corners) > 1 and bool(np.ptp(np.array(self._corners), axis=0).max() > 0)

    @property
    def shape(self) -> PathShape:
        """What was drawn."""
        return PathShape(self._kind, as_points(np.array(self._corners)))

    @property
    def preview(self) -> PathShape | None:
        """What it would be with the pointer as its next corner; None while that is where it began."""
        points = np.array([*self._corners, *(self._stroke or [])[1:], self._tip])
        moved = np.append(True, np.abs(np.diff(points, axis=0)).max(axis=1) > 0)
        points = points[moved] if self._free else points[[0, -1]]
        if len(points) < 2 or not np.ptp(points, axis=0).any():
            return None
        return PathShape("polyline" if self._drawn else self._kind, as_points(points))

    def press(self, point: FloatArray, reach: float) -> None:
        """One more corner, from which a stroke may go on; near the first one, the path is closed.

        Args:
            point: (2,) [m].
            reach: How near is near [m].
        """
        first = self._corners[0]
        self._closed = self._free and len(self._corners) > 2 and bool(np.linalg.norm(point - first) <= reach)
        point = first if self._closed else point
        self._corners.append(point)
        self._stroke, self._tip, self._drawn = [point], point, False

    def move(self, point: FloatArray, far: float) -> None:
        """The pointer moved; with the button down and farther than ``far`` [m], it draws."""
        self._tip = point
        if self._stroke is not None:
            self._drawn |= bool(np.linalg.norm(point - self._stroke[0]) > far)
            if self._drawn and self._free and not self._closed:
                self._stroke.append(point)

    def release(self, tolerance: float, reach: float) -> bool:
        """The button came up; whether the path is complete.

        Args:
            tolerance: How far corners may leave the stroke they stand for [m].
            reach: How near to its start a stroke ends for the path to be closed [m].
        """
        stroke, drawn, self._stroke, self._drawn = self._stroke or [], self._drawn, None, False
        if self._closed:
            return True
        if not self._free:
            if drawn:
                self._corners = [self._corners[0], self._tip]
            return len(self._corners) > 1
        if not drawn:
            return False
        alone = len(self._corners) == 1
        self._corners += list(_few(np.array(stroke), tolerance))[1:]
        if len(self._corners) > 3 and np.linalg.norm(self._corners[-1] - self._corners[0]) <= reach:
            self._corners[-1] = self._corners[0]
            return True
        return alone

    def take_back(self) -> bool:
        """Without the last corner; whether any is left."""
        self._corners.pop()
        self._stroke = None
        return bool(self._corners)


def _few(stroke: FloatArray, tolerance: float) -> FloatArray:
    """(k, 2) corners of a stroke, coarser where there would be too many."""
    corners = simplified(stroke, tolerance)
    while len(corners) > _MOST_CORNERS:
        tolerance *= 2
        corners = simplified(stroke, tolerance)
    return corners
