"""Straight paths on a map that go on over seams, so that a stroke is in one piece on the body."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.arrays import FloatArray, readonly
from app.errors import MapError
from app.geometry.surface_point import SurfacePoint
from app.maps.glue import Gluing, crossing

_MOST_PIECES = 10_000
_INSIDE = 1e-12
_BACK = 1e-9


@dataclass(frozen=True, eq=False)
class MapPiece:
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
        object.__setattr__(self, "points", readonly(self.points))


@dataclass(frozen=True, eq=False)
class Trace:
    """A path in pieces; between two of them it crosses a seam, or turns.

    Attributes:
        pieces: In order; each starts on the body where the one before ended.
        remaining: (2,) what was not walked of the step in hand [m], in the last chart, because the skin ended; zero if
            all was walked.
    """

    pieces: tuple[MapPiece, ...]
    remaining: FloatArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "remaining", readonly(self.remaining))

    @property
    def arrived(self) -> bool:
        """Whether the path was walked to its end."""
        return not self.remaining.any()


def trace(gluing: Gluing, start: SurfacePoint, path: FloatArray) -> Trace:
    """Walk ``path`` from ``start``, over seams, up to its end or the skin's.

    Args:
        gluing: Of the map.
        start: On the skin.
        path: (k, 2) map points to go to one after the other [m], or (2,) one, as if the chart of ``start`` had no
            border: what lies beyond a seam is found behind its other side, and so is the rest of the path.

    Raises:
        MapError: The path is not finite, or circles a corner of the skin without end.

    Cost: 50 µs for each piece.
    """
    targets = np.asarray(path, dtype=np.float64).reshape(-1, 2)
    if not np.isfinite(targets).all():
        raise MapError("a path must be finite", value=targets[~np.isfinite(targets).all(axis=1)][0].tolist())
    here = gluing.map.to_map(start)
    steps = np.diff(targets, axis=0, prepend=here[None])
    walk, linear, left = _Walk(gluing, start, here), np.eye(2), np.zeros(2)
    for step in steps:
        turned, left = walk.go(linear @ step)
        linear = turned @ linear
        if left.any():
            break
    return Trace(tuple(walk.pieces), left)


class _Walk:
    """Where the walker is: on the map, on the body, and on which border segment if just over a seam."""

    def __init__(self, gluing: Gluing, at: SurfacePoint, point: FloatArray) -> None:
        self._gluing, self._at, self._point, self._entered = gluing, at, point, -1
        self.pieces: list[MapPiece] = []

    def go(self, step: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Walk ``step`` (2,): how directions were turned on the way (2, 2), and what is left of it (2,)."""
        linear, borders = np.eye(2), self._gluing.borders
        while step.any():
            segment, share, at = self._exit(step)
            if segment < 0:
                self._arrive(self._point + step)
                return linear, np.zeros(2)
            self._move(self._point + share * step, self._on_border(segment, at))
            partner = int(borders.partner[segment])
            if partner < 0:
                return linear, (1 - share) * step
            self._enter(segment, partner, at)
            step = borders.linear[segment] @ ((1 - share) * step)
            linear = borders.linear[segment] @ linear
        return linear, step

    def _exit(self, step: FloatArray) -> tuple[int, float, float]:
        """The first border segment that ``step`` meets going outwards, how far along the step, where on the segment."""
        borders = self._gluing.borders
        own = np.flatnonzero((borders.patch == self._at.patch) & (np.arange(len(borders.patch)) != self._entered))
        ends = borders.ends[own]
        along, at = crossing(self._point, step, ends)
        side = ends[:, 1] - ends[:, 0]
        out = (step[0] * side[:, 1] - step[1] * side[:, 0]) * self._facing()
        met = np.flatnonzero((out > 0) & (along >= -_INSIDE) & (along < 1) & (at >= -_INSIDE) & (at <= 1 + _INSIDE))
        if not len(met):
            return -1, 1.0, 0.0
        first = met[along[met].argmin()]
        return int(own[first]), max(float(along[first]), 0.0), float(np.clip(at[first], 0.0, 1.0))

    def _facing(self) -> float:
        """1 where charts are drawn as they are, -1 where they are mirrored: their inside is on the other side then."""
        return -1.0 if self._gluing.map.layout.placements[self._at.patch].mirrored else 1.0

    def _enter(self, segment: int, partner: int, at: float) -> None:
        borders = self._gluing.borders
        along = 1 - at if borders.turned[segment] else at
        self._entered = partner
        self._at = self._on_border(partner, along)
        self._point = (1 - along) * borders.ends[partner, 0] + along * borders.ends[partner, 1]
        if len(self.pieces) > _MOST_PIECES:
            raise MapError("the path circles a corner of the skin", place=f"patch {self._at.patch}")

    def _arrive(self, point: FloatArray) -> None:
        at = self._gluing.map.to_body(point)
        if at is None or at.patch != self._at.patch:
            # Rounding put the end of the path just over a border that it did not cross.
            at = self._gluing.map.to_body(point + _BACK * (self._point - point))
        if at is None:
            raise MapError("the path ended off the map", value=point.tolist(), remedy="The map covers a place twice")
        self._entered = -1
        self._move(point, at)

    def _move(self, point: FloatArray, at: SurfacePoint) -> None:
        self.pieces.append(MapPiece(self._at.patch, np.stack([self._point, point]), self._at, at))
        self._at, self._point = at, point

    def _on_border(self, segment: int, at: float) -> SurfacePoint:
        borders, weights = self._gluing.borders, [0.0, 0.0, 0.0]
        side = int(borders.side[segment])
        weights[side], weights[(side + 1) % 3] = 1.0 - at, at
        a, b, c = weights
        return SurfacePoint(int(borders.patch[segment]), int(borders.face[segment]), (a, b, c))
