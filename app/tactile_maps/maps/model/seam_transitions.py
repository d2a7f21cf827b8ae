"""Across a seam: the plane of one side continued into the other, for neighbours and for paths.

Where a patch was cut, two border segments of its chart are one edge of the body. A linear map of the plane, one for
each, carries what lies beyond the one segment to where it is drawn behind the other, edge on edge and every direction
to the same direction on the body; between charts without stretch it is a rotation and a translation.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray, freeze_arrays, readonly
from tactile_maps.geometry.surface.plane import cross
from tactile_maps.maps.model.tactile_map import TactileMap

_AT_ONCE = 2_000_000
_EDGE = 1e-9
"""How far past its end a segment still counts, as a share of it: a line through a corner must meet one of the two."""


@dataclass(frozen=True, eq=False)
class BorderSegments:
    """Border segments of all charts, each with its face on the left when the chart is not mirrored.

    Attributes:
        patch: (b,).
        face: (b,) the face beside it, within the patch.
        side: (b,) from that face's corner ``side`` to corner ``side + 1``.
        ends: (b, 2, 2) where they are on the map [m].
        partner: (b,) the segment that is the same edge of the body, or -1 at a true border.
        turned: (b,) whether the partner runs the other way along that edge, as between faces that agree in direction.
        linear: (b, 2, 2) the transition's matrix A: beyond this segment, x is drawn at A x + t; zero without partner.
        offset: (b, 2) and its t [m].
    """

    patch: IntArray
    face: IntArray
    side: IntArray
    ends: FloatArray
    partner: IntArray
    turned: BoolArray
    linear: FloatArray
    offset: FloatArray

    def __post_init__(self) -> None:
        freeze_arrays(self, "patch", "face", "side", "partner", dtype=np.int64)
        freeze_arrays(self, "turned", dtype=bool)
        freeze_arrays(self, "ends", "linear", "offset")


class SeamTransitions:
    """How a map continues over its seams. Built once for a map.

    Args:
        map_: The map.

    Attributes:
        borders: All border segments, with the transition beyond each.

    Cost: 10 ms for 20,000 faces.
    """

    def __init__(self, map_: TactileMap) -> None:
        self.map = map_
        patch, face, side = (np.concatenate(parts) for parts in zip(*_segments(map_), strict=True))
        partner, turned = _partners(map_, patch, face, side)
        ends = np.stack([_corner(map_, patch, face, (side + k) % 3) for k in (0, 1)], axis=1)
        linear = np.zeros((len(patch), 2, 2))
        offset = np.zeros((len(patch), 2))
        glued = np.flatnonzero(partner >= 0)
        if len(glued):
            frames = _body_frames(map_, patch, face, side)
            linear[glued], offset[glued] = _transitions(frames, ends, glued, partner[glued], turned[glued])
        self.borders = BorderSegments(patch, face, side, ends, partner, turned, linear, offset)

    def across(self, segment: IntArray, points: FloatArray) -> FloatArray:
        """(k, 2) where points (k, 2) beyond segments (k,) of a seam are drawn: beside its other side [m]."""
        borders = self.borders
        return np.einsum("kij,kj->ki", borders.linear[segment], points) + borders.offset[segment]

    def seen(self, here: IntArray, there: IntArray) -> FloatArray:
        """(k, 2) where taxels ``there`` (k,) lie on the map, seen from taxels ``here`` (k,) over a seam if nearer [m].

        That is where they would be drawn if the map went on past the seam. Distances and directions from a taxel to
        its neighbours on the body are right in these coordinates, torn or not.

        Cost: 10 ms for 3000 pairs and 100 seam segments.
        """
        points = self.map.taxel_points
        patch_of = self.map.skin.patch_of
        best = points[there].copy()
        length = np.linalg.norm(best - points[here], axis=1)
        for patch in range(len(self.map.skin.patches)):
            seams = np.flatnonzero((self.borders.patch == patch) & (self.borders.partner >= 0))
            if not len(seams):
                continue
            pairs = np.flatnonzero((patch_of[here] == patch) & (patch_of[there] == patch))
            for asked in np.array_split(pairs, 1 + len(seams) * len(pairs) // _AT_ONCE):
                found, away = self._through(seams, points[here[asked]], points[there[asked]])
                nearer = away < length[asked]
                best[asked[nearer]] = found[nearer]
        return readonly(best)

    def _through(self, seams: IntArray, here: FloatArray, there: FloatArray) -> tuple[FloatArray, FloatArray]:
        """For pairs of points the nearest image of the second through one of ``seams``, and its distance; inf if none.

        A straight line to an image counts if it leaves the map through that very segment.
        """
        borders = self.borders
        back = self.borders.partner[seams]
        images = np.einsum("sij,kj->ksi", borders.linear[back], there) + borders.offset[back]
        steps = images - here[:, None]
        along, at = line_crossing(here[:, None], steps, borders.ends[seams][None])
        away = np.linalg.norm(steps, axis=2)
        through = (along >= -_EDGE) & (along <= 1 + _EDGE) & (at >= -_EDGE) & (at <= 1 + _EDGE)
        away = np.where(through, away, np.inf)
        pick = np.arange(len(here)), away.argmin(axis=1)
        return images[pick], away[pick]


def line_crossing(start: FloatArray, step: FloatArray, ends: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Where lines ``start + s step`` meet lines ``a + t (b - a)``: (s, t); NaN where they are parallel, as 0 / 0 is.

    NaN is in no range, so that a test for a meeting within two segments leaves parallel ones out by itself.

    Args:
        start: (..., 2).
        step: (..., 2).
        ends: (..., 2, 2) of a and b.
    """
    side = ends[..., 1, :] - ends[..., 0, :]
    gap = ends[..., 0, :] - start
    turn = cross(step, side)
    turn = np.where(turn == 0, np.nan, turn)
    return cross(gap, side) / turn, cross(gap, step) / turn


def _segments(map_: TactileMap) -> list[tuple[IntArray, IntArray, IntArray]]:
    found = []
    for number, chart in enumerate(map_.charts):
        face, side = np.divmod(chart.connectivity.boundary_sides, 3)
        found.append((np.full(len(face), number), face, side))
    return found


def _partners(map_: TactileMap, patch: IntArray, face: IntArray, side: IntArray) -> tuple[IntArray, BoolArray]:
    """For each segment the other that has the same edge of the surface, and whether they run opposite ways."""
    surfaces = [patch.surface for patch in map_.skin.patches]
    starts = np.cumsum([0, *(len(surface.vertices) for surface in surfaces)])
    edge = np.empty((len(patch), 2), dtype=np.int64)
    for number, surface in enumerate(surfaces):
        own = patch == number
        corners = surface.faces[face[own]]
        rows = np.arange(len(corners))
        edge[own] = starts[number] + np.stack([corners[rows, (side[own] + k) % 3] for k in (0, 1)], axis=1)
    low, high = np.sort(edge, axis=1).T
    order = np.argsort(low * starts[-1] + high, kind="stable")
    keys = (low * starts[-1] + high)[order]
    same = np.flatnonzero(keys[1:] == keys[:-1])
    partner = np.full(len(patch), -1, dtype=np.int64)
    partner[order[same]] = order[same + 1]
    partner[order[same + 1]] = order[same]
    return partner, (edge[:, 0] != edge[partner, 0]) & (partner >= 0)


def _corner(map_: TactileMap, patch: IntArray, face: IntArray, corner: IntArray) -> FloatArray:
    """(k, 2) where corners of faces are on the map."""
    result = np.empty((len(patch), 2))
    for number, (chart, uv) in enumerate(zip(map_.charts, map_.uv, strict=True)):
        own = patch == number
        result[own] = uv[chart.faces[face[own], corner[own]]]
    return result


def _body_frames(map_: TactileMap, patch: IntArray, face: IntArray, side: IntArray) -> FloatArray:
    """(b, 2, 2) columns: the step on the map for a metre along the segment's edge on the body, and into its face."""
    place = [_corner(map_, patch, face, (side + k) % 3) for k in range(3)]
    body = np.empty((len(patch), 3, 3))
    for number, surface in enumerate(one.surface for one in map_.skin.patches):
        own = np.flatnonzero(patch == number)
        for k in range(3):
            body[own, k] = surface.vertices[surface.faces[face[own], (side[own] + k) % 3]]
    edge = body[:, 1] - body[:, 0]
    arm = body[:, 2] - body[:, 0]
    base = np.linalg.norm(edge, axis=1)
    along = (arm * edge).sum(axis=1) / base
    across = np.linalg.norm(np.cross(edge, arm), axis=1) / base
    first = (place[1] - place[0]) / base[:, None]
    return np.stack([first, (place[2] - place[0] - along[:, None] * first) / across[:, None]], axis=2)


def _transitions(
    frames: FloatArray, ends: FloatArray, here: IntArray, there: IntArray, turned: BoolArray
) -> tuple[FloatArray, FloatArray]:
    """Matrices and offsets that carry what lies beyond segments ``here`` to the faces at ``there``.

    Beyond the edge is minus the way into the face here, and the way into the face there; the edge itself is shared,
    run the other way if ``turned``.
    """
    flip = np.where(turned, -1.0, 1.0)
    target = np.stack([flip[:, None] * frames[there][:, :, 0], -frames[there][:, :, 1]], axis=2)
    linear = target @ np.linalg.inv(frames[here])
    start = np.where(turned[:, None], ends[there][:, 1], ends[there][:, 0])
    return linear, start - np.einsum("kij,kj->ki", linear, ends[here][:, 0])
