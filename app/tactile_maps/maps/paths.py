"""Paths on the map: traced straight across seams, drawn from a few points, and projected on the skin in segments.

``trace_path`` follows a straight path that continues across seams, so that a stroke is continuous on the body.
``MapPath`` is a polygon drawn on the map, parameterised by arc length: polyline, spline, lemniscate or raster.
``split_at_borders`` divides it where it enters and leaves patches, and ``PathProjection`` projects it on the skin.

A path may be drawn over the background between patches. Inside a patch the path is where it was drawn. Where it leaves
a patch over a seam, it continues across the seam if that leads back to where it was drawn, or if it enters no other
patch. Where it enters elsewhere it jumps: from the point where it left to the one where it enters, however far apart
these are on the body. Where there is neither a seam nor another patch, it ends.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal, TypeAlias, assert_never

import numpy as np

from tactile_maps.core.arrays import ArrayFields, FloatArray, IntArray, readonly
from tactile_maps.core.errors import MapError
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.geometry.surface.plane import cross
from tactile_maps.maps.model.layout import FARTHEST_OFFSET
from tactile_maps.maps.model.seam_transitions import SeamTransitions, line_crossing
from tactile_maps.maps.model.tactile_map import TactileMap

PathKind: TypeAlias = Literal["polyline", "spline", "lemniscate", "raster"]
"""Interpretation of drawn points: corners of a polyline or spline, ends of a lemniscate, two corners of a raster."""
_MOST_PIECES = 10_000
_INSIDE = 1e-12
_BACK = 1e-9
_STEPS_AT_ONCE = 64
"""Number of steps processed together; those beyond the next seam are processed again."""


@dataclass(frozen=True, eq=False)
class PathSegment(ArrayFields):
    """Straight part of a path within one chart.

    Attributes:
        patch: The chart's patch.
        points: (2, 2) start and end on the map [m].
        start: Start on the body.
        end: End on the body.
    """

    patch: int
    points: FloatArray
    start: SurfacePoint
    end: SurfacePoint


@dataclass(frozen=True, eq=False)
class TracedPath(ArrayFields):
    """A path in segments, separated by seams and corners.

    Attributes:
        pieces: Segments in order; each starts on the body where the previous one ended.
        remaining: (2,) remainder of the current step [m] in the last chart, if the skin ended; zero if the path was
            completed.
    """

    pieces: tuple[PathSegment, ...]
    remaining: FloatArray

    @property
    def arrived(self) -> bool:
        """Whether the path was completed."""
        return not self.remaining.any()


def trace_path(transitions: SeamTransitions, start: SurfacePoint, path: FloatArray) -> TracedPath:
    """Trace ``path`` from ``start`` across seams to its end or to the border of the skin.

    Args:
        transitions: Seam transitions of the map.
        start: Point on the skin.
        path: (k, 2) map points to visit in order [m], or (2,) one point, as if the chart of ``start`` had no border:
            points beyond a seam are mapped behind its other side, and so is the rest of the path.

    Raises:
        MapError: The path is not finite, or circles a corner of the skin endlessly.

    Cost: 10 µs per segment, 0.5 ms per seam.
    """
    targets = np.asarray(path, dtype=np.float64).reshape(-1, 2)
    if not np.isfinite(targets).all():
        raise MapError("a path must be finite", value=targets[~np.isfinite(targets).all(axis=1)][0].tolist())
    here = transitions.map.to_map(start)
    walk = _Tracer(transitions, start, here)
    left = walk.go(np.diff(targets, axis=0, prepend=here[None]))
    return TracedPath(tuple(walk.pieces), left)


class _Tracer:
    """State of a trace: position on the map and the body, and the border segment just entered."""

    def __init__(self, transitions: SeamTransitions, at: SurfacePoint, point: FloatArray) -> None:
        self._transitions = transitions
        self._at = at
        self._point = point
        self._entered = -1
        self.pieces: list[PathSegment] = []

    def go(self, steps: FloatArray) -> FloatArray:
        """Follow ``steps`` (k, 2), given in the first chart; return the remainder (2,) of the last step, if any."""
        linear = np.eye(2)
        borders = self._transitions.borders
        while len(steps := steps[steps.any(axis=1)]):
            now = steps[:_STEPS_AT_ONCE] @ linear.T
            points = self._point + np.cumsum(now, axis=0)
            count, segment, share, at = self._exit(np.concatenate([self._point[None], points[:-1]]), now)
            self._arrive(points[:count])
            if segment < 0:
                steps = steps[count:]
                continue
            self._move(self._point + share * now[count], self._on_border(segment, at))
            partner = int(borders.partner[segment])
            if partner < 0:
                return np.asarray((1 - share) * now[count])
            self._enter(segment, partner, at)
            steps = np.concatenate([(1 - share) * steps[count : count + 1], steps[count + 1 :]])
            linear = borders.linear[segment] @ linear
        return np.zeros(2)

    def _exit(self, starts: FloatArray, steps: FloatArray) -> tuple[int, int, float, float]:
        """Return how many steps (k, 2) from ``starts`` (k, 2) stay in the chart, and where the next one leaves it.

        The exit is given by the border segment (-1 if all steps stay), the share of the step, and the share of the
        segment.
        """
        borders = self._transitions.borders
        own = np.flatnonzero(borders.patch == self._at.patch)
        ends = borders.ends[own]
        along, at = line_crossing(starts[:, None], steps[:, None], ends[None])
        side = ends[:, 1] - ends[:, 0]
        met = (cross(steps[:, None], side) * self._facing() > 0) & (along >= -_INSIDE) & (along < 1)
        met &= (at >= -_INSIDE) & (at <= 1 + _INSIDE)
        met[0] &= own != self._entered
        number = int(met.any(axis=1).argmax())
        if not met[number].any():
            return len(steps), -1, 1.0, 0.0
        first = int(np.where(met[number], along[number], np.inf).argmin())
        share = float(along[number, first])
        where = float(np.clip(at[number, first], 0.0, 1.0))
        return number, int(own[first]), max(share, 0.0), where

    def _facing(self) -> float:
        """Return 1 for a chart that is not mirrored and -1 for a mirrored one, whose inside is on the other side."""
        return -1.0 if self._transitions.map.layout.placements[self._at.patch].mirrored else 1.0

    def _enter(self, segment: int, partner: int, at: float) -> None:
        borders = self._transitions.borders
        along = 1 - at if borders.turned[segment] else at
        self._entered = partner
        self._at = self._on_border(partner, along)
        self._point = (1 - along) * borders.ends[partner, 0] + along * borders.ends[partner, 1]
        if len(self.pieces) > _MOST_PIECES:
            raise MapError("the path runs in a loop around a vertex of the skin", place=f"patch {self._at.patch}")

    def _arrive(self, points: FloatArray) -> None:
        """Move to points (k, 2) of this chart in order."""
        patch, face, weights = self._transitions.map.to_body_many(points)
        for k, point in enumerate(points):
            if patch[k] == self._at.patch:
                a, b, c = weights[k].tolist()
                self._move(point, SurfacePoint(self._at.patch, int(face[k]), (a, b, c)))
                continue
            # Rounding moved the point just over a border that the path does not cross.
            at = self._transitions.map.to_body(point + _BACK * (self._point - point))
            if at is None:
                raise MapError(
                    "the path ended off the map", value=point.tolist(), remedy="Remove overlaps from the map"
                )
            self._move(point, at)

    def _move(self, point: FloatArray, at: SurfacePoint) -> None:
        self.pieces.append(PathSegment(self._at.patch, np.stack([self._point, point]), self._at, at))
        self._at = at
        self._point = point
        self._entered = -1

    def _on_border(self, segment: int, at: float) -> SurfacePoint:
        borders = self._transitions.borders
        weights = [0.0, 0.0, 0.0]
        side = int(borders.side[segment])
        weights[side] = 1.0 - at
        weights[(side + 1) % 3] = at
        a, b, c = weights
        return SurfacePoint(int(borders.patch[segment]), int(borders.face[segment]), (a, b, c))


RASTER_STEP = 0.008
"""Distance between lines of a raster [m]: the width of a taxel."""
_FINE = 0.001
"""Longest side of a curve's polygon [m]."""
_MOST_SIDES = 2000


class MapPath:
    """A polygon on the map, parameterised by arc length.

    Args:
        points: (k, 2) [m], k >= 1; repeated points are dropped.

    Attributes:
        points: (k, 2) [m].
        closed: Whether it ends where it starts, so that it can be followed repeatedly.

    Raises:
        MapError: No points, or one is not finite or too far from the origin.
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
        """Total length [m]."""
        return float(self._ends[-1])

    def at(self, way: float) -> tuple[FloatArray, FloatArray]:
        """Return the point (2,) [m] and the unit direction (2,) at arc length ``way`` [m].

        Beyond an end the point is that end and the direction zero, as for a path of one point.
        """
        if not 0 <= way < self.length:
            return self.points[-1 if way > 0 else 0].copy(), np.zeros(2)
        side = int(np.searchsorted(self._ends, way, side="right")) - 1
        direction = self._sides[side] / self._lengths[side]
        return self.points[side] + (way - self._ends[side]) * direction, direction


def draw_path(kind: PathKind, points: Sequence[Sequence[float]] | FloatArray) -> MapPath:
    """Return the path defined by ``points`` (k, 2) [m] on the map.

    Raises:
        MapError: Too few points, or one is not finite or too far from the origin.
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
    """Return a default path of about ``size`` [m] around a point (2,) of the map."""
    reach = np.array([size / 2, 0.0])
    if kind == "raster":
        reach = np.array([size / 2, size / 2])
    if kind == "spline":
        turns = 2 * np.pi * np.arange(7) / 6
        return draw_path(kind, centre + size / 2 * np.stack([np.cos(turns), np.sin(turns)], axis=1))
    return draw_path(kind, np.stack([centre - reach, centre + reach]))


def _checked(points: Sequence[Sequence[float]] | FloatArray, least: int) -> FloatArray:
    """Return points (k, 2) rounded to the picometre, so that differences are zero or large enough to divide by."""
    given = np.asarray(points, dtype=np.float64).reshape(-1, 2)
    if len(given) < least or not np.isfinite(given).all():
        needs = "at least one point" if least == 1 else "two points or more"
        raise MapError(f"a path needs {needs}, all finite", value=given[:3].tolist(), remedy="Mark its points")
    if np.abs(given).max() > FARTHEST_OFFSET:
        raise MapError("a path point is too far from the origin", value=given[:3].tolist(), remedy="Draw it on the map")
    return np.round(given, 12)


def _spline(points: FloatArray) -> FloatArray:
    """Interpolate all points by chord length; closed if the last equals the first."""
    from scipy.interpolate import CubicSpline  # 0.1 s to import, and few paths are drawn as curves

    chords = np.linalg.norm(np.diff(points, axis=0), axis=1)
    keep = np.concatenate([[True], chords > 1e-9])
    points = points[keep]
    way = np.concatenate([[0.0], np.cumsum(chords[chords > 1e-9])])
    if len(points) < 3:
        return points
    closed = np.linalg.norm(points[0] - points[-1]) < 1e-9
    points = np.concatenate([points[:-1], points[:1]]) if closed else points
    curve = CubicSpline(way, points, bc_type="periodic" if closed else "natural")
    return curve(np.linspace(0, way[-1], _sides_for(float(way[-1]))))


def _lemniscate(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return Gerono's figure of eight between two ends, half as wide as long; it starts at its centre."""
    axis = (second - first) / 2
    across = np.array([-axis[1], axis[0]])
    turn = np.linspace(0, 2 * np.pi, _sides_for(6 * float(np.linalg.norm(axis))))[:, None]
    curve = (first + second) / 2 + np.sin(turn) * axis + np.sin(turn) * np.cos(turn) * across
    curve[-1] = curve[0]
    return curve


def _raster(low: FloatArray, high: FloatArray) -> FloatArray:
    """Return lines along x in alternating direction, at most ``RASTER_STEP`` apart."""
    lines = min(int(np.ceil((high[1] - low[1]) / RASTER_STEP)) + 1, _MOST_SIDES)
    rows = np.linspace(low[1], high[1], lines)
    corners = [[(low[0], y), (high[0], y)][:: 1 if k % 2 == 0 else -1] for k, y in enumerate(rows)]
    return np.array(corners).reshape(-1, 2)


def _sides_for(length: float) -> int:
    return int(np.clip(np.ceil(length / _FINE), 16, _MOST_SIDES))


_EDGE = 1e-9
"""Tolerance beyond the ends of a border segment, as a share of its length."""
_SHORT = 1e-9
"""Lengths below this [m] are rounding errors."""
_AT_ONCE = 500_000


@dataclass(frozen=True, eq=False)
class PathRun(ArrayFields):
    """Part of a polygon within one patch, or outside all of them.

    Attributes:
        patch: Index of the patch; None outside.
        points: (k, 2) on the map [m], k >= 2.
    """

    patch: int | None
    points: FloatArray


def split_at_borders(points: FloatArray, transitions: SeamTransitions) -> tuple[PathRun, ...]:
    """Return the runs of a polygon in order, each from the end of the previous one; none for a single point.

    Args:
        points: (k, 2) on the map [m]; consecutive points differ.
        transitions: Seam transitions of the map.

    Cost: 1 ms for a small path of 100 sides, 60 ms for 2000 sides all over a map.
    """
    if len(points) < 2:
        return ()
    side, share = _met(points, transitions.borders.ends)
    corners = np.arange(len(points) - 1)
    ways = np.unique(np.concatenate([corners, side + share, [len(points) - 1.0]]))
    number = np.minimum(ways.astype(np.int64), len(points) - 2)
    places = points[number] + (ways - number)[:, None] * (points[number + 1] - points[number])
    places = places[np.concatenate([[True], np.linalg.norm(np.diff(places, axis=0), axis=1) > _SHORT])]
    if len(places) < 2:
        return ()
    patch = transitions.map.to_body_many((places[1:] + places[:-1]) / 2)[0]
    starts = np.concatenate([[0], np.flatnonzero(np.diff(patch)) + 1, [len(patch)]])
    return tuple(
        PathRun(int(patch[first]) if patch[first] >= 0 else None, places[first : last + 1])
        for first, last in pairwise(starts)
    )


def _met(points: FloatArray, ends: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return the sides of a polygon (k, 2) that meet border segments (b, 2, 2), and the share of each side up to there.

    Only segments in the box of the polygon are tested: most paths are small.
    """
    low = points.min(axis=0) - _SHORT
    high = points.max(axis=0) + _SHORT
    near = ends[((ends.max(axis=1) >= low) & (ends.min(axis=1) <= high)).all(axis=1)]
    steps = np.diff(points, axis=0)
    found = []
    for some in np.array_split(np.arange(len(steps)), 1 + len(steps) * len(near) // _AT_ONCE):
        along, at = line_crossing(points[some][:, None], steps[some][:, None], near[None])
        side, segment = np.nonzero((along > 0) & (along < 1) & (at >= -_EDGE) & (at <= 1 + _EDGE))
        found.append((some[side], along[side, segment]))
    sides, shares = zip(*found, strict=True)
    return np.concatenate(sides), np.concatenate(shares)


NEAR_PITCHES = 1.5
"""Distance on the body, in pitches, up to which a contact is moved directly from one point to another."""
_INWARD = (0.0, 1e-9, 1e-6, 1e-3)
"""Inward shifts, as shares, tried for a point on a border until rounding leaves it inside."""
_ROUNDING = 1e-6
"""Length below which segments behind a seam are artefacts of points moved inwards [m]."""


class PathProjection:
    """Projection of a path on the skin in segments.

    Args:
        transitions: Seam transitions of the map.
        start: Point on the body of the first point.
        points: (k, 2) path on the map [m].
        drawn: Whether the path was drawn on the displayed map. Other paths never jump.

    Attributes:
        pieces: Segments in order.
        jumps: Indices of segments before which the path jumps.
        whole: Whether the part of the path behind seams is complete.
    """

    def __init__(self, transitions: SeamTransitions, start: SurfacePoint, points: FloatArray, *, drawn: bool) -> None:
        self._transitions = transitions
        self._map = transitions.map
        self._start = start
        self.pieces: list[PathSegment] = []
        self.jumps: list[int] = []
        self.whole = True
        runs = split_at_borders(points, transitions)
        for number in range(len(runs)):
            rest = runs[number:]
            if not (self._lay_drawn(rest, number > 0) if drawn else self._lay_on(rest)):
                self._go_behind(np.concatenate([other.points for other in rest]))
                return

    def _lay_drawn(self, runs: tuple[PathRun, ...], begun: bool) -> bool:
        """Project the first of the runs; return False if none of them enters a patch any more."""
        run = runs[0]
        if run.patch is not None:
            self._stay(run.patch, run.points, crosses=begun and self._elsewhere(run))
            return True
        if len(runs) > 1:
            self._come_back(run, runs[1])
        return len(runs) > 1

    def _lay_on(self, runs: tuple[PathRun, ...]) -> bool:
        """Project the first run of a path without jumps; return False where it continues behind a seam or ends."""
        run = runs[0]
        if run.patch is not None and not (self.pieces and self._elsewhere(run)):
            self._stay(run.patch, run.points, crosses=False)
            return True
        return run.patch is None and len(runs) > 1 and self._come_back(run, runs[1])

    def _elsewhere(self, run: PathRun) -> bool:
        """Return whether a run starts at another point of the body than the end of the path."""
        return bool(self.pieces) and not self._near(self.pieces[-1].end, run)

    def _stay(self, patch: int, points: FloatArray, *, crosses: bool) -> None:
        """Append points (k, 2) inside a patch where they were drawn."""
        if crosses:
            self.jumps.append(len(self.pieces))
        inward = points.copy()
        inward[0] += _INWARD[2] * (points[1] - points[0])
        inward[-1] += _INWARD[2] * (points[-2] - points[-1])
        found, face, weights = self._map.to_body_many(inward)
        places = [
            SurfacePoint(patch, int(face[k]), (float(a), float(b), float(c)))
            if found[k] == patch
            else back_project_inside(self._map, patch, points[max(k - 1, 0) : k + 2].mean(axis=0), points[k])
            for k, (a, b, c) in enumerate(weights)
        ]
        for k in range(len(places) - 1):
            self.pieces.append(PathSegment(patch, points[k : k + 2], places[k], places[k + 1]))

    def _come_back(self, gap: PathRun, after: PathRun) -> bool:
        """Append a gap behind a seam if it leads to the point where the next run enters."""
        walk = self._walk(gap.points)
        if walk is None or not walk.arrived or not walk.pieces or not self._near(walk.pieces[-1].end, after):
            return False
        self.pieces += walk.pieces
        return True

    def _near(self, here: SurfacePoint, run: PathRun) -> bool:
        """Return whether a run of the same patch starts near ``here`` on the body."""
        if run.patch is None:
            return False
        skin = self._map.skin
        there = back_project_inside(self._map, run.patch, run.points[:2].mean(axis=0), run.points[0])
        away = np.linalg.norm(skin.position(there) - skin.position(here))
        return here.patch == there.patch and bool(away <= NEAR_PITCHES * np.sqrt(skin.areas.mean()))

    def _go_behind(self, points: FloatArray) -> None:
        """Continue behind the seam, as far as there is skin, a part that enters no patch any more."""
        walk = self._walk(points)
        self.pieces += walk.pieces if walk else ()
        self.whole = walk is not None and walk.arrived

    def _walk(self, points: FloatArray) -> TracedPath | None:
        """Trace ``points`` (k, 2), which start at the end of the path; return None if that is not possible."""
        here = self.pieces[-1].end if self.pieces else self._start
        try:
            walk = trace_path(self._transitions, here, points[1:])
        except MapError:
            return None  # circles a corner of the skin, or leaves a map with overlaps
        return TracedPath(
            tuple(piece for piece in walk.pieces if np.ptp(piece.points, axis=0).max() > _ROUNDING), walk.remaining
        )


def back_project_inside(map_: TactileMap, patch: int, inner: FloatArray, point: FloatArray) -> SurfacePoint:
    """Return the point on the body of a map point (2,) of a patch, even if rounding moved it just outside.

    Args:
        map_: The map.
        patch: Index of the patch.
        inner: (2,) a point well inside it [m].
        point: (2,) map point [m].

    Raises:
        MapError: There is no skin nearby.
    """
    for share in (*_INWARD, 1.0):
        at = map_.to_body(point + share * (inner - point))
        if at is not None and at.patch == patch:
            return at
    raise MapError("there is no skin at this point of the path", value=point.tolist())
