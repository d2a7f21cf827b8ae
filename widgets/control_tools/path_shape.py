"""A drawn path under the hand, without Qt: its handles, what is nearest to the pointer, what dragging that does."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np

from app.arrays import FloatArray
from app.control.command import PathKind
from app.control.map_path import draw_path

Points = tuple[tuple[float, float], ...]
"""As in ``ControlSettings.path`` [m]."""
FREE: tuple[PathKind, ...] = ("polyline", "spline")
"""Kinds with as many corners as one likes; the others are laid between two points."""


class Grip(Enum):
    """What of a path is in the hand."""

    CORNER = "corner"
    MIDDLE = "middle"
    LINE = "line"


@dataclass(frozen=True)
class Held:
    """What a press would take.

    Attributes:
        grip: Which kind.
        number: Of the handle, or of the side whose middle it is; 0 for the whole line.
    """

    grip: Grip
    number: int = 0


@dataclass(frozen=True)
class PathShape:
    """A path as drawn.

    Attributes:
        kind: How its points are meant.
        points: At least two [m].
    """

    kind: PathKind
    points: Points

    @property
    def free(self) -> bool:
        """Whether corners can be added and removed."""
        return self.kind in FREE

    @property
    def closed(self) -> bool:
        """Whether it was drawn back to its start."""
        return self.free and len(self.points) > 3 and self.points[0] == self.points[-1]

    @property
    def line(self) -> FloatArray:
        """(k, 2) the curve, straight on the map as if that had no borders [m]."""
        return draw_path(self.kind, self.points).points

    @property
    def handles(self) -> FloatArray:
        """(h, 2) the corners that can be dragged [m]: of a box all four, of a closed path the first one only once."""
        points = np.array(self.points)
        if self.kind == "raster":
            (x0, y0), (x1, y1) = points.min(axis=0), points.max(axis=0)
            return np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])
        if self.kind == "lemniscate":
            return points[:2]
        return points[:-1] if self.closed else points

    @property
    def middles(self) -> FloatArray:
        """(s, 2) the middles of its sides, from which corners can be pulled [m]; none where there is nothing to add."""
        points = np.array(self.points)
        if not self.free:
            return np.zeros((0, 2))
        if self.kind == "polyline" or len(points) < 3:
            return (points[1:] + points[:-1]) / 2
        way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
        line = self.line
        share = (way[1:] + way[:-1]) / 2 / max(way[-1], 1e-12)
        return line[np.rint(share * (len(line) - 1)).astype(int)]

    def held_at(self, where: FloatArray, reach: float) -> Held | None:
        """What a press at a map point (2,) means, within ``reach`` [m]: corners before middles before the line."""
        for grip, places in ((Grip.CORNER, self.handles), (Grip.MIDDLE, self.middles)):
            away = np.linalg.norm(places - where, axis=1)
            if len(away) and away.min() <= reach:
                return Held(grip, int(away.argmin()))
        return Held(Grip.LINE) if _distance(self.line, where) <= reach else None

    def dragged(self, held: Held, by: FloatArray) -> PathShape:
        """What was held moved by (2,) [m]."""
        if held.grip is Grip.LINE:
            return self._with(np.array(self.points) + by)
        if held.grip is Grip.MIDDLE:
            corner = self.middles[held.number] + by
            return self._with(np.insert(np.array(self.points), held.number + 1, corner, axis=0))
        return self._corner_moved(held.number, by)

    def without(self, number: int) -> PathShape | None:
        """Without a corner; None where too little would be left, or corners are not what it is made of."""
        if not self.free or len(self.points) - self.closed <= 2:
            return None
        points = np.delete(self.handles, number, axis=0)
        # A ring of two corners would be walked there and back, which an open line is as well.
        return self._with(np.append(points, points[:1], axis=0) if self.closed and len(points) > 2 else points)

    def _corner_moved(self, number: int, by: FloatArray) -> PathShape:
        points = np.array(self.points)
        if self.kind == "raster":
            points = np.stack([points.min(axis=0), points.max(axis=0)])
            points[0 if number in (0, 3) else 1, 0] += by[0]
            points[0 if number in (0, 1) else 1, 1] += by[1]
        else:
            points[number] += by
            if self.closed and number == 0:
                points[-1] = points[0]
        return self._with(points)

    def _with(self, points: FloatArray) -> PathShape:
        return PathShape(self.kind, as_points(points))


def as_points(points: FloatArray) -> Points:
    """Points (k, 2) as settings have them."""
    return tuple((float(x), float(y)) for x, y in np.asarray(points).tolist())


def _distance(line: FloatArray, where: FloatArray) -> float:
    """From a point (2,) to a polyline (k, 2) [m]."""
    if len(line) < 2:
        return float(np.linalg.norm(line[0] - where))
    start, side = line[:-1], np.diff(line, axis=0)
    share = np.clip(((where - start) * side).sum(axis=1) / np.maximum((side**2).sum(axis=1), 1e-18), 0, 1)
    return float(np.linalg.norm(start + share[:, None] * side - where, axis=1).min())
