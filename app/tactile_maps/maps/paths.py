"""Paths on the map: traced straight over seams, drawn from a few points, and laid on the skin piece by piece.

``trace`` follows a straight path that goes on over seams, so that a stroke is in one piece on the body. ``MapPath`` is
a polygon drawn on the map, walked by arc length: polyline, spline, lemniscate or raster. ``split_at_borders`` cuts it
where it comes into patches and where it leaves them, and ``PathProjection`` lays it, as it is seen, on the skin.

A person draws over the plain ground between patches too. Inside a patch the path lies where it was drawn. Where it
leaves a patch over a seam it goes on behind the seam, if from there it comes back to where it was drawn, or comes into
no patch any more. Where it comes in elsewhere it crosses: from the place where it left to the one where it comes in,
however far apart these are on the body. Where there is no seam and no patch to come, it ends.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal, TypeAlias, assert_never

import numpy as np
from scipy.interpolate import CubicSpline

from tactile_maps.core.arrays import FloatArray, IntArray, freeze_arrays, readonly
from tactile_maps.core.errors import MapError
from tactile_maps.geometry.surface.mesh import SurfacePoint
from tactile_maps.geometry.surface.plane import cross
from tactile_maps.maps.model.layout import FARTHEST_OFFSET
from tactile_maps.maps.model.seam_transitions import SeamTransitions, line_crossing
from tactile_maps.maps.model.tactile_map import TactileMap

PathKind: TypeAlias = Literal["polyline", "spline", "lemniscate", "raster"]
"""How drawn points are meant: corners of a polyline or spline, ends of a lemniscate, two corners of a raster."""
_MOST_PIECES = 10_000
_INSIDE = 1e-12
_BACK = 1e-9
_STEPS_AT_ONCE = 64
"""As many steps are looked at together; those behind the next seam are looked at again."""


@dataclass(frozen=True, eq=False)
class PathSegment:
    """A straight part of a path, within one chart.

    Attributes:
        patch: The chart's patch.
        points: (2, 2) from and to on the map [m].
        start: The place on the body where it starts.
        end: And where it ends.
    """

    patch: int
    points: FloatArray
    start: SurfacePoint
    end: SurfacePoint

    def __post_init__(self) -> None:
        freeze_arrays(self, "points")


@dataclass(frozen=True, eq=False)
class TracedPath:
    """A path in pieces; between two of them it crosses a seam, or turns.

    Attributes:
        pieces: In order; each starts on the body where the one before ended.
        remaining: (2,) what was not walked of the step in hand [m], in the last chart, because the skin ended; zero if
            all was walked.
    """

    pieces: tuple[PathSegment, ...]
    remaining: FloatArray

    def __post_init__(self) -> None:
        freeze_arrays(self, "remaining")

    @property
    def arrived(self) -> bool:
        """Whether the path was walked to its end."""
        return not self.remaining.any()


def trace_path(transitions: SeamTransitions, start: SurfacePoint, path: FloatArray) -> TracedPath:
    """Walk ``path`` from ``start``, over seams, up to its end or the skin's.

    Args:
        transitions: Of the map.
        start: On the skin.
        path: (k, 2) map points to go to one after the other [m], or (2,) one, as if the chart of ``start`` had no
            border: what lies beyond a seam is found behind its other side, and so is the rest of the path.

    Raises:
        MapError: The path is not finite, or circles a corner of the skin without end.

    Cost: 10 µs for each piece, 0.5 ms for each seam.
    """
    targets = np.asarray(path, dtype=np.float64).reshape(-1, 2)
    if not np.isfinite(targets).all():
        raise MapError("a path must be finite", value=targets[~np.isfinite(targets).all(axis=1)][0].tolist())
    here = transitions.map.to_map(start)
    walk = _Tracer(transitions, start, here)
    left = walk.go(np.diff(targets, axis=0, prepend=here[None]))
    return TracedPath(tuple(walk.pieces), left)


class _Tracer:
    """Where the walker is: on the map, on the body, and on which border segment if just over a seam."""

    def __init__(self, transitions: SeamTransitions, at: SurfacePoint, point: FloatArray) -> None:
        self._transitions = transitions
        self._at = at
        self._point = point
        self._entered = -1
        self.pieces: list[PathSegment] = []

    def go(self, steps: FloatArray) -> FloatArray:
        """Walk ``steps`` (k, 2), directions where it starts; what is left (2,) of the one on which the skin ended."""
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
        """How many of the steps (k, 2) from ``starts`` (k, 2) stay in the chart, and where the next one leaves it.

        That is the border segment, how far along the step, and where on the segment; segment -1 where all stay.
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
        """1 where charts are drawn as they are, -1 where they are mirrored: their inside is on the other side then."""
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
        """Come to points (k, 2) of this chart, one after the other."""
        patch, face, weights = self._transitions.map.to_body_many(points)
        for k, point in enumerate(points):
            if patch[k] == self._at.patch:
                a, b, c = weights[k].tolist()
                self._move(point, SurfacePoint(self._at.patch, int(face[k]), (a, b, c)))
                continue
            # Rounding put the point just over a border that the path did not cross.
            at = self._transitions.map.to_body(point + _BACK * (self._point - point))
            if at is None:
                raise MapError(
                    "the path ended off the map", value=point.tolist(), remedy="The map covers a place twice"
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
    if np.abs(given).max() > FARTHEST_OFFSET:
        raise MapError("a path point is too far from the origin", value=given[:3].tolist(), remedy="Draw it on the map")
    return np.round(given, 12)


def _spline(points: FloatArray) -> FloatArray:
    """Through all points, smooth, by chord length; closed if the last is the first."""
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


_EDGE = 1e-9
"""How far past its end a border segment still counts, as a share of it."""
_SHORT = 1e-9
"""What is shorter [m] is rounding."""
_AT_ONCE = 500_000


@dataclass(frozen=True, eq=False)
class PathRun:
    """A part of a polygon within one patch, or outside of all.

    Attributes:
        patch: Of the map; None outside.
        points: (k, 2) on the map [m], k >= 2.
    """

    patch: int | None
    points: FloatArray

    def __post_init__(self) -> None:
        freeze_arrays(self, "points")


def split_at_borders(points: FloatArray, transitions: SeamTransitions) -> tuple[PathRun, ...]:
    """The runs of a polygon in order, each from where the one before ended; none for a point alone.

    Args:
        points: (k, 2) on the map [m], no two that follow each other alike.
        transitions: Of the map.

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
    """Where sides of a polygon (k, 2) meet border segments (b, 2, 2): the side, and the share of it walked until there.

    Only segments in the polygon's box are looked at: most paths are small.
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
"""Places this many pitches apart on the body are near: a contact is led straight over from one to the other."""
_INWARD = (0.0, 1e-9, 1e-6, 1e-3)
"""Shares of the way inwards by which a point on a border is moved until rounding leaves it inside."""
_ROUNDING = 1e-6
"""Pieces behind a seam that are shorter [m] come of points moved inwards."""


class PathProjection:
    """The pieces of a path.

    Args:
        transitions: Of the map.
        start: The place of the first point.
        points: (k, 2) the path on the map [m].
        drawn: Whether a person drew it as the map is seen. Else it never crosses.

    Attributes:
        pieces: In order.
        jumps: Numbers of the pieces before which it crosses.
        whole: Whether all of the path that should lie behind seams does.
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
        """Lay the first of the runs; false where nothing of them comes into a patch any more."""
        run = runs[0]
        if run.patch is not None:
            self._stay(run.patch, run.points, crosses=begun and self._elsewhere(run))
            return True
        if len(runs) > 1:
            self._come_back(run, runs[1])
        return len(runs) > 1

    def _lay_on(self, runs: tuple[PathRun, ...]) -> bool:
        """The same for a path that never crosses: false where it has to go on behind a seam or to end."""
        run = runs[0]
        if run.patch is not None and not (self.pieces and self._elsewhere(run)):
            self._stay(run.patch, run.points, crosses=False)
            return True
        return run.patch is None and len(runs) > 1 and self._come_back(run, runs[1])

    def _elsewhere(self, run: PathRun) -> bool:
        """Whether a run starts at another place of the body than where the path is."""
        return bool(self.pieces) and not self._near(self.pieces[-1].end, run)

    def _stay(self, patch: int, points: FloatArray, *, crosses: bool) -> None:
        """Lay points (k, 2) inside a patch where they were drawn."""
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
        """Lay a gap behind a seam if it leads to where it comes in on the map."""
        walk = self._walk(gap.points)
        if walk is None or not walk.arrived or not walk.pieces or not self._near(walk.pieces[-1].end, after):
            return False
        self.pieces += walk.pieces
        return True

    def _near(self, here: SurfacePoint, run: PathRun) -> bool:
        """Whether a run of the same patch starts about ``here`` on the body."""
        if run.patch is None:
            return False
        skin = self._map.skin
        there = back_project_inside(self._map, run.patch, run.points[:2].mean(axis=0), run.points[0])
        away = np.linalg.norm(skin.position(there) - skin.position(here))
        return here.patch == there.patch and bool(away <= NEAR_PITCHES * np.sqrt(skin.areas.mean()))

    def _go_behind(self, points: FloatArray) -> None:
        """Lay what comes into no patch any more behind the seam, as far as there is skin."""
        walk = self._walk(points)
        self.pieces += walk.pieces if walk else ()
        self.whole = walk is not None and walk.arrived

    def _walk(self, points: FloatArray) -> TracedPath | None:
        """From where the path is now along ``points`` (k, 2), the first of which is there; None if it cannot be."""
        here = self.pieces[-1].end if self.pieces else self._start
        try:
            walk = trace_path(self._transitions, here, points[1:])
        except MapError:
            return None  # round and round a corner of the skin, or off a map that covers a place twice
        return TracedPath(
            tuple(piece for piece in walk.pieces if np.ptp(piece.points, axis=0).max() > _ROUNDING), walk.remaining
        )


def back_project_inside(map_: TactileMap, patch: int, inner: FloatArray, point: FloatArray) -> SurfacePoint:
    """The place behind a map point (2,) of a patch, though rounding may put it just outside.

    Args:
        map_: The map.
        patch: Of it.
        inner: (2,) a point well inside of it [m].
        point: (2,) the one that is meant [m].

    Raises:
        MapError: None is anywhere near.
    """
    for share in (*_INWARD, 1.0):
        at = map_.to_body(point + share * (inner - point))
        if at is not None and at.patch == patch:
            return at
    raise MapError("there is no skin at this point of the path", value=point.tolist())
