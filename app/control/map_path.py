"""Paths on the map: drawn from a few points, walked by arc length."""

from __future__ import annotations

from collections.abc import Sequence
from typing import assert_never

import numpy as np
from scipy.interpolate import CubicSpline

from app.arrays import FloatArray, readonly
from app.control.command import PathKind
from app.errors import MapError
from app.maps.layout import FARTHEST

RASTER_STEP = 0.008
"""Between two lines of a raster [m]: a taxel's width."""
_FINE = 0.001
"""Longest side of a curve's polygon [m]."""
_MOST_SIDES = 2000


class MapPath:
    """A polygon on the map, asked by the length walked along it.

    Args:
        points: (k, 2) [m], k >= 1; points that repeat are left out.

    Attributes:
        points: (k, 2) [m].
        closed: Whether it ends where it starts, so that it can be walked round and round.

    Raises:
        MapError: A point is not finite or far off every map, or there is none.
    """

    def __init__(self, points: FloatArray) -> None:
        corners = _checked(points, 1)
        moved = np.linalg.norm(np.diff(corners, axis=0), axis=1) > 1e-9
        self.points = readonly(corners[np.concatenate([[True], moved])])
        self._sides = np.diff(self.points, axis=0)
        self._lengths = np.linalg.norm(self._sides, axis=1)
        self._ends = np.concatenate([[0.0], np.cumsum(self._lengths)])
        self.closed = len(self.points) > 2 and bool(np.linalg.norm(self.points[0] - self.points[-1]) < 1e-6)

    @property
    def length(self) -> float:
        """[m]."""
        return float(self._ends[-1])

    def at(self, way: float) -> tuple[FloatArray, FloatArray]:
        """The point (2,) [m] and the direction (2,) after ``way`` metres; beyond its ends none.

        Beyond an end it is the end. A path of one point has no direction anywhere.
        """
        if not 0 <= way < self.length:
            return self.points[-1 if way > 0 else 0].copy(), np.zeros(2)
        side = int(np.searchsorted(self._ends, way, side="right")) - 1
        direction = self._sides[side] / self._lengths[side]
        return self.points[side] + (way - self._ends[side]) * direction, direction


def draw_path(kind: PathKind, points: Sequence[Sequence[float]] | FloatArray) -> MapPath:
    """The path that ``points`` (k, 2) [m] on the map mean as ``kind``.

    Raises:
        MapError: Too few points, or one is not finite or far off every map.
    """
    given = _checked(points, 2)
    if kind == "polyline":
        return MapPath(given)
    if kind == "spline":
        return MapPath(_spline(given))
    if kind == "lemniscate":
        return MapPath(_lemniscate(given[0], given[1]))
    if kind == "raster":
        return MapPath(_raster(given.min(axis=0), given.max(axis=0)))
    assert_never(kind)


def path_about(kind: PathKind, centre: FloatArray, size: float) -> MapPath:
    """A path of about ``size`` [m] around a point (2,) of the map, for when nobody drew one."""
    reach = np.array([size / 2, 0.0])
    if kind == "raster":
        reach = np.array([size / 2, size / 2])
    if kind == "spline":
        turns = 2 * np.pi * np.arange(7) / 6
        return draw_path(kind, centre + size / 2 * np.stack([np.cos(turns), np.sin(turns)], axis=1))
    return draw_path(kind, np.stack([centre - reach, centre + reach]))


def _checked(points: Sequence[Sequence[float]] | FloatArray, least: int) -> FloatArray:
    """(k, 2) to the picometre, so that no difference of two points is a number too small to divide by."""
    given = np.asarray(points, dtype=np.float64).reshape(-1, 2)
    if len(given) < least or not np.isfinite(given).all():
        needs = "at least one point" if least == 1 else "two points or more"
        raise MapError(f"a path needs {needs}, all finite", value=given[:3].tolist(), remedy="Mark its points")
    if np.abs(given).max() > FARTHEST:
        raise MapError("a path leads too far out", value=given[:3].tolist(), remedy="Draw it on the map")
    return np.round(given, 12)


def _spline(points: FloatArray) -> FloatArray:
    """Through all points, smooth, by chord length; closed if the last is the first."""
    chords = np.linalg.norm(np.diff(points, axis=0), axis=1)
    keep = np.concatenate([[True], chords > 1e-9])
    points, way = points[keep], np.concatenate([[0.0], np.cumsum(chords[chords > 1e-9])])
    if len(points) < 3:
        return points
    closed = np.linalg.norm(points[0] - points[-1]) < 1e-9
    points = np.concatenate([points[:-1], points[:1]]) if closed else points
    curve = CubicSpline(way, points, bc_type="periodic" if closed else "natural")
    return curve(np.linspace(0, way[-1], _sides_for(float(way[-1]))))


def _lemniscate(first: FloatArray, second: FloatArray) -> FloatArray:
    """Gerono's figure of eight between two ends, half as wide as long; it starts in its middle."""
    axis = (second - first) / 2
    across = np.array([-axis[1], axis[0]])
    turn = np.linspace(0, 2 * np.pi, _sides_for(6 * float(np.linalg.norm(axis))))[:, None]
    curve = (first + second) / 2 + np.sin(turn) * axis + np.sin(turn) * np.cos(turn) * across
    curve[-1] = curve[0]
    return curve


def _raster(low: FloatArray, high: FloatArray) -> FloatArray:
    """Lines along x from corner to corner, there and back, no farther apart than ``RASTER_STEP``."""
    lines = min(int(np.ceil((high[1] - low[1]) / RASTER_STEP)) + 1, _MOST_SIDES)
    rows = np.linspace(low[1], high[1], lines)
    corners = [[(low[0], y), (high[0], y)][:: 1 if k % 2 == 0 else -1] for k, y in enumerate(rows)]
    return np.array(corners).reshape(-1, 2)


def _sides_for(length: float) -> int:
    return int(np.clip(np.ceil(length / _FINE), 16, _MOST_SIDES))
