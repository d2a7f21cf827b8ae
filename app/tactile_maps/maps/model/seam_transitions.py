"""Transitions across seams: the plane of one side continued into the other, for neighbours and for paths.

Where a patch was cut, two border segments of its chart are one edge of the body. An affine map of the plane for each
segment maps points beyond it to their position behind the other one, edge to edge, and every direction to the same
direction on the body. Between charts without stretch it is a rotation and a translation.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tactile_maps.core.arrays import ArrayFields, BoolArray, FloatArray, IntArray
from tactile_maps.geometry.surface.plane import cross
from tactile_maps.maps.model.tactile_map import TactileMap


@dataclass(frozen=True, eq=False)
class BorderSegments(ArrayFields):
    """Border segments of all charts, each with its face on the left if the chart is not mirrored.

    Attributes:
        patch: (b,).
        face: (b,) adjacent face, within the patch.
        side: (b,) side of that face, from corner ``side`` to corner ``side + 1``.
        ends: (b, 2, 2) end points on the map [m].
        partner: (b,) segment on the same edge of the body, or -1 at a true border.
        turned: (b,) whether the partner runs in the opposite direction, as between consistently oriented faces.
        linear: (b, 2, 2) matrix A of the transition: beyond this segment, x is drawn at A x + t; zero without partner.
        offset: (b, 2) offset t of the transition [m].
    """

    patch: IntArray
    face: IntArray
    side: IntArray
    ends: FloatArray
    partner: IntArray
    turned: BoolArray
    linear: FloatArray
    offset: FloatArray


class SeamTransitions:
    """Continuation of a map across its seams. Built once for a map.

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


def line_crossing(start: FloatArray, step: FloatArray, ends: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return (s, t) where lines ``start + s step`` meet lines ``a + t (b - a)``; NaN if they are parallel.

    NaN is in no range, so a test for an intersection of two segments excludes parallel ones.

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
    """Return the other segment on the same edge of the surface, and whether they run in opposite directions."""
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
    """Return the map points (k, 2) of face corners."""
    result = np.empty((len(patch), 2))
    for number, (chart, uv) in enumerate(zip(map_.charts, map_.uv, strict=True)):
        own = patch == number
        result[own] = uv[chart.faces[face[own], corner[own]]]
    return result


def _body_frames(map_: TactileMap, patch: IntArray, face: IntArray, side: IntArray) -> FloatArray:
    """Return (b, 2, 2) with columns: map step per metre along the segment's edge on the body, and into its face."""
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
    """Return matrices and offsets that map points beyond segments ``here`` to the faces at ``there``.

    The direction beyond the edge is minus the direction into the face here, and the direction into the face there; the
    shared edge is reversed if ``turned``.
    """
    flip = np.where(turned, -1.0, 1.0)
    target = np.stack([flip[:, None] * frames[there][:, :, 0], -frames[there][:, :, 1]], axis=2)
    linear = target @ np.linalg.inv(frames[here])
    start = np.where(turned[:, None], ends[there][:, 1], ends[there][:, 0])
    return linear, start - np.einsum("kij,kj->ki", linear, ends[here][:, 0])
