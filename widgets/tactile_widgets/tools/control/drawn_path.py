"""Drawn path, without Qt: handles, picking and dragging them, and the path while it is being drawn."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from functools import lru_cache

import numpy as np

from tactile_maps.core.arrays import FloatArray
from tactile_maps.geometry.surface.points import cumulative_lengths
from tactile_maps.maps.paths import PathKind, draw_path
from tactile_widgets.views.interaction.polyline import simplify_polyline

Points = tuple[tuple[float, float], ...]
"""Points as in ``ControlSettings.path`` [m]."""
FREE: tuple[PathKind, ...] = ("polyline", "spline")
"""Kinds with any number of corners; the others are defined by two points."""


class HandleKind(Enum):
    """Part of a path that can be dragged."""

    CORNER = "corner"
    MIDDLE = "middle"
    LINE = "line"


@dataclass(frozen=True)
class PathHandle:
    """Draggable part of a path.

    Attributes:
        grip: Kind of the part.
        number: Index of the corner, or of the side of the middle; 0 for the whole line.
    """

    grip: HandleKind
    number: int = 0


@lru_cache(maxsize=4)
def _line(kind: PathKind, points: Points) -> FloatArray:
    """Return the read-only curve (k, 2) of a path [m], which is used several times in each picture."""
    line = draw_path(kind, points).points
    line.flags.writeable = False
    return line


@dataclass(frozen=True)
class DrawnPath:
    """Path drawn by the user.

    Attributes:
        kind: Meaning of the points.
        points: At least two points [m].
    """

    kind: PathKind
    points: Points

    @property
    def free(self) -> bool:
        """Whether corners can be added and removed."""
        return self.kind in FREE

    @property
    def closed(self) -> bool:
        """Whether it ends at its start."""
        return self.free and len(self.points) > 3 and self.points[0] == self.points[-1]

    @property
    def line(self) -> FloatArray:
        """Curve (k, 2) on the map [m], ignoring the map's borders."""
        return _line(self.kind, self.points)

    @property
    def handles(self) -> FloatArray:
        """Draggable corners (h, 2) [m]: all four of a box; the first of a closed path only once."""
        points = np.array(self.points)
        if self.kind == "raster":
            (x0, y0), (x1, y1) = points.min(axis=0), points.max(axis=0)
            return np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])
        if self.kind == "lemniscate":
            return points[:2]
        return points[:-1] if self.closed else points

    @property
    def middles(self) -> FloatArray:
        """Midpoints (s, 2) of the sides [m], from which corners can be pulled; empty if corners cannot be added."""
        points = np.array(self.points)
        if not self.free:
            return np.zeros((0, 2))
        if self.kind == "polyline" or len(points) < 3:
            return (points[1:] + points[:-1]) / 2
        way = cumulative_lengths(points)
        line = self.line
        share = (way[1:] + way[:-1]) / 2 / max(way[-1], 1e-12)
        return line[np.rint(share * (len(line) - 1)).astype(int)]

    def held_at(self, where: FloatArray, reach: float) -> PathHandle | None:
        """Return the part within ``reach`` [m] of a map point (2,): corners before middles before the line."""
        for grip, places in ((HandleKind.CORNER, self.handles), (HandleKind.MIDDLE, self.middles)):
            away = np.linalg.norm(places - where, axis=1)
            if len(away) and away.min() <= reach:
                return PathHandle(grip, int(away.argmin()))
        return PathHandle(HandleKind.LINE) if _distance(self.line, where) <= reach else None

    def dragged(self, held: PathHandle, by: FloatArray) -> DrawnPath:
        """Return the path with a part moved by (2,) [m]."""
        if held.grip is HandleKind.LINE:
            return self._with(np.array(self.points) + by)
        if held.grip is HandleKind.MIDDLE:
            corner = self.middles[held.number] + by
            return self._with(np.insert(np.array(self.points), held.number + 1, corner, axis=0))
        return self._corner_moved(held.number, by)

    def without(self, number: int) -> DrawnPath | None:
        """Return the path without a corner; None if too few would remain or the kind has no free corners."""
        if not self.free or len(self.points) - self.closed <= 2:
            return None
        points = np.delete(self.handles, number, axis=0)
        # A closed path with two corners is the same as an open line, which is also followed back and forth.
        return self._with(np.append(points, points[:1], axis=0) if self.closed and len(points) > 2 else points)

    def _corner_moved(self, number: int, by: FloatArray) -> DrawnPath:
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

    def _with(self, points: FloatArray) -> DrawnPath:
        return DrawnPath(self.kind, as_points(points))


def as_points(points: FloatArray) -> Points:
    """Return points (k, 2) in the form of the settings."""
    return tuple((float(x), float(y)) for x, y in np.asarray(points).tolist())


def _distance(line: FloatArray, where: FloatArray) -> float:
    """Return the distance from a point (2,) to a polyline (k, 2) [m]."""
    if len(line) < 2:
        return float(np.linalg.norm(line[0] - where))
    start = line[:-1]
    side = np.diff(line, axis=0)
    share = np.clip(((where - start) * side).sum(axis=1) / np.maximum((side**2).sum(axis=1), 1e-18), 0, 1)
    return float(np.linalg.norm(start + share[:, None] * side - where, axis=1).min())


_MOST_CORNERS = 200
"""Maximum number of corners of a stroke; more could not be picked one by one."""


class PathSketch:
    """Path while it is being drawn, from a press at a map point. Mutable.

    Args:
        kind: Kind of path.
        start: (2,) first map point [m].
    """

    def __init__(self, kind: PathKind, start: FloatArray) -> None:
        self._kind = kind
        self._corners = [start]
        self._stroke: list[FloatArray] | None = [start]
        self._tip = start
        self._drawn = False
        self._closed = False

    @property
    def _free(self) -> bool:
        return self._kind in FREE

    @property
    def can_end(self) -> bool:
        """Whether it has enough points to be a path."""
        return len(self._corners) > 1 and bool(np.ptp(np.array(self._corners), axis=0).max() > 0)

    @property
    def shape(self) -> DrawnPath:
        """Path of the corners so far."""
        return DrawnPath(self._kind, as_points(np.array(self._corners)))

    @property
    def preview(self) -> DrawnPath | None:
        """Path with the pointer as the next corner; None while the pointer is at the start."""
        points = np.array([*self._corners, *(self._stroke or [])[1:], self._tip])
        moved = np.append(True, np.abs(np.diff(points, axis=0)).max(axis=1) > 0)
        points = points[moved] if self._free else points[[0, -1]]
        if len(points) < 2 or not np.ptp(points, axis=0).any():
            return None
        return DrawnPath("polyline" if self._drawn and self._free else self._kind, as_points(points))

    def press(self, point: FloatArray, reach: float) -> None:
        """Add a corner, from which a stroke can continue; near the first corner, close the path.

        Args:
            point: (2,) map point [m].
            reach: Maximum distance from the first corner that closes the path [m].
        """
        first = self._corners[0]
        self._closed = self._free and len(self._corners) > 2 and bool(np.linalg.norm(point - first) <= reach)
        point = first if self._closed else point
        self._corners.append(point)
        self._stroke = [point]
        self._tip = point
        self._drawn = False

    def move(self, point: FloatArray, far: float) -> None:
        """Handle a pointer move; with the button down and farther than ``far`` [m], it draws."""
        self._tip = point
        if self._stroke is not None:
            self._drawn |= bool(np.linalg.norm(point - self._stroke[0]) > far)
            if self._drawn and self._free and not self._closed:
                self._stroke.append(point)

    def release(self, tolerance: float, reach: float) -> bool:
        """Handle the release of the button; return whether the path is complete.

        Args:
            tolerance: Maximum distance of the simplified corners from the stroke [m].
            reach: Maximum distance of the end from the start that closes the path [m].
        """
        stroke = self._stroke or []
        drawn = self._drawn
        self._stroke = None
        self._drawn = False
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

    def remove_last(self) -> bool:
        """Remove the last corner; return whether any is left."""
        self._corners.pop()
        self._stroke = None
        return bool(self._corners)


def _few(stroke: FloatArray, tolerance: float) -> FloatArray:
    """Return corners (k, 2) of a stroke, coarser if there would be too many."""
    corners = simplify_polyline(stroke, tolerance)
    while len(corners) > _MOST_CORNERS:
        tolerance *= 2
        corners = simplify_polyline(stroke, tolerance)
    return corners
