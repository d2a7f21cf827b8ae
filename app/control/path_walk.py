"""Lays a path drawn on the map as it is seen, piece by piece, on the skin.

A person draws over the plain ground between patches too. Inside a patch the path lies where it was drawn. Where it
leaves a patch over a seam it goes on behind the seam, if from there it comes back to where it was drawn, or comes into
no patch any more. Where it comes in elsewhere it crosses: from the place where it left to the one where it comes in,
however far apart these are on the body. Where there is no seam and no patch to come, it ends.
"""

from __future__ import annotations

import numpy as np

from app.arrays import FloatArray
from app.control.path_cut import Run, cut_at_borders
from app.errors import MapError
from app.geometry.surface_point import SurfacePoint
from app.maps.glue import Gluing
from app.maps.tactile_map import TactileMap
from app.maps.trace import MapPiece, Trace, trace

NEAR = 1.5
"""Places this many pitches apart on the body are near: a contact is led straight over from one to the other."""
_INWARD = (0.0, 1e-9, 1e-6, 1e-3)
"""Shares of the way inwards by which a point on a border is moved until rounding leaves it inside."""
_ROUNDING = 1e-6
"""Pieces behind a seam that are shorter [m] come of points moved inwards."""


class PathWalk:
    """The pieces of a path.

    Args:
        gluing: Of the map.
        start: The place of the first point.
        points: (k, 2) the path on the map [m].
        drawn: Whether a person drew it as the map is seen. Else it never crosses.

    Attributes:
        pieces: In order.
        jumps: Numbers of the pieces before which it crosses.
        whole: Whether all of the path that should lie behind seams does.
    """

    def __init__(self, gluing: Gluing, start: SurfacePoint, points: FloatArray, *, drawn: bool) -> None:
        self._gluing, self._map, self._start = gluing, gluing.map, start
        self.pieces: list[MapPiece] = []
        self.jumps: list[int] = []
        self.whole = True
        runs = cut_at_borders(points, gluing)
        for number in range(len(runs)):
            rest = runs[number:]
            if not (self._lay_drawn(rest, number > 0) if drawn else self._lay_on(rest)):
                self._go_behind(np.concatenate([other.points for other in rest]))
                return

    def _lay_drawn(self, runs: tuple[Run, ...], begun: bool) -> bool:
        """Lay the first of the runs; false where nothing of them comes into a patch any more."""
        run = runs[0]
        if run.patch >= 0:
            self._stay(run, crosses=begun and self._elsewhere(run))
            return True
        if len(runs) > 1:
            self._come_back(run, runs[1])
        return len(runs) > 1

    def _lay_on(self, runs: tuple[Run, ...]) -> bool:
        """The same for a path that never crosses: false where it has to go on behind a seam or to end."""
        run = runs[0]
        if run.patch >= 0 and not (self.pieces and self._elsewhere(run)):
            self._stay(run, crosses=False)
            return True
        return run.patch < 0 and len(runs) > 1 and self._come_back(run, runs[1])

    def _elsewhere(self, run: Run) -> bool:
        """Whether a run starts at another place of the body than where the path is."""
        return bool(self.pieces) and not self._near(self.pieces[-1].end, run)

    def _stay(self, run: Run, *, crosses: bool) -> None:
        """Lay what is inside a patch where it was drawn."""
        if crosses:
            self.jumps.append(len(self.pieces))
        inward = run.points.copy()
        inward[0] += _INWARD[2] * (run.points[1] - run.points[0])
        inward[-1] += _INWARD[2] * (run.points[-2] - run.points[-1])
        patch, face, weights = self._map.to_body_many(inward)
        places = [
            SurfacePoint(run.patch, int(face[k]), (float(a), float(b), float(c)))
            if patch[k] == run.patch
            else inside(self._map, run.patch, run.points[max(k - 1, 0) : k + 2].mean(axis=0), run.points[k])
            for k, (a, b, c) in enumerate(weights)
        ]
        for k in range(len(places) - 1):
            self.pieces.append(MapPiece(run.patch, run.points[k : k + 2], places[k], places[k + 1]))

    def _come_back(self, gap: Run, after: Run) -> bool:
        """Lay a gap behind a seam if it leads to where it comes in on the map."""
        walk = self._walk(gap.points)
        if walk is None or not walk.arrived or not walk.pieces or not self._near(walk.pieces[-1].end, after):
            return False
        self.pieces += walk.pieces
        return True

    def _near(self, here: SurfacePoint, run: Run) -> bool:
        """Whether a run of the same patch starts about ``here`` on the body."""
        skin = self._map.skin
        there = inside(self._map, run.patch, run.points[:2].mean(axis=0), run.points[0])
        away = np.linalg.norm(skin.position(there) - skin.position(here))
        return here.patch == there.patch and bool(away <= NEAR * np.sqrt(skin.areas.mean()))

    def _go_behind(self, points: FloatArray) -> None:
        """Lay what comes into no patch any more behind the seam, as far as there is skin."""
        walk = self._walk(points)
        self.pieces += walk.pieces if walk else ()
        self.whole = walk is not None and walk.arrived

    def _walk(self, points: FloatArray) -> Trace | None:
        """From where the path is now along ``points`` (k, 2), the first of which is there; None if it cannot be."""
        here = self.pieces[-1].end if self.pieces else self._start
        try:
            walk = trace(self._gluing, here, points[1:])
        except MapError:
            return None  # round and round a corner of the skin, or off a map that covers a place twice
        return Trace(
            tuple(piece for piece in walk.pieces if np.ptp(piece.points, axis=0).max() > _ROUNDING), walk.remaining
        )


def inside(map_: TactileMap, patch: int, inner: FloatArray, point: FloatArray) -> SurfacePoint:
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
