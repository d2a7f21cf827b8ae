"""A surface through taxels, widened by a rim, so that the outermost taxels feel all around themselves too.

The rim follows the border at half a spacing's distance, in the taxels' tangent planes, with round corners. A row of
taxels is a border without an inside, walked there and back; a single taxel is a border of one corner. So the same few
lines make a strip around a row, and a disk around a lone taxel.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from app.arrays import FloatArray, IntArray

ROUND = np.pi / 3
"""A corner that turns by more than this [rad] is rounded with more vertices, at most this far apart."""
_TRIES = 8


@dataclass(frozen=True, eq=False)
class Rim:
    """What a border grows.

    Attributes:
        vertices: (r, 3) [m], in order around.
        taxel: (r,) the taxel that each of them belongs to.
        faces: (f, 3) into the taxels, and from the number given as ``first`` on into the vertices above.
    """

    vertices: FloatArray
    taxel: IntArray
    faces: IntArray


def grow_rim(positions: FloatArray, normals: FloatArray, width: FloatArray, walk: IntArray, *, first: int) -> Rim:
    """The rim along one closed walk.

    Args:
        positions: (n, 3) the taxels [m].
        normals: (n, 3) unit.
        width: (n,) of the rim at each taxel [m], above zero.
        walk: (w,) taxels along the border, the surface on the left; a lone taxel is a walk of one.
        first: Number of the rim's first vertex.
    """
    corner, direction, reach = _spokes(positions, normals, walk)
    taxel = walk[corner]
    spokes = direction * (reach * width[taxel])[:, None]
    after = np.roll(np.arange(len(taxel)), -1)
    outer = np.stack([taxel[after], first + np.arange(len(taxel)), first + after], axis=1)
    inner = np.stack([taxel[after], taxel, first + np.arange(len(taxel))], axis=1)[taxel != taxel[after]]
    faces = np.concatenate([outer, inner])
    for _ in range(_TRIES):
        vertices = np.concatenate([positions, np.zeros((first - len(positions), 3)), positions[taxel] + spokes])
        a, b, c = (vertices[faces[:, k]] for k in range(3))
        folded = (np.cross(b - a, c - a) * normals[faces[:, 0]]).sum(axis=1) <= 0
        if not folded.any():
            break
        # In a narrow notch spokes of neighbours cross; shorter ones do not.
        crossing = np.unique(faces[folded])
        spokes[crossing[crossing >= first] - first] /= 2
    return Rim(positions[taxel] + spokes, taxel, faces)


def _spokes(positions: FloatArray, normals: FloatArray, walk: IntArray) -> tuple[IntArray, FloatArray, FloatArray]:
    """Of each rim vertex: (r,) its place in the walk, (r, 3) unit direction there, (r,) distance in rim widths."""
    up = normals[walk]
    if len(walk) == 1:
        ahead, turn = _level(np.eye(3)[np.abs(up).argmin(axis=1)], up), np.full(1, 2 * np.pi)
    else:
        step = positions[np.roll(walk, -1)] - positions[walk]
        behind, onward = _level(np.roll(step, 1, axis=0), up), _level(step, up)
        turn = np.arctan2((np.cross(behind, onward) * up).sum(axis=1), (behind * onward).sum(axis=1))
        back = np.roll(walk, 1) == np.roll(walk, -1)  # the end of a row: all the way round, not half a turn inward
        ahead, turn = behind, np.where(back, np.pi, turn)
    count = np.where(turn > ROUND, 1 + np.ceil(turn / ROUND - 1e-9), 1).astype(np.int64)
    count -= turn > 1.5 * np.pi  # the last spoke of a full turn is the first again
    corner = np.repeat(np.arange(len(walk)), count)
    place = np.arange(len(corner)) - np.repeat(np.cumsum(count) - count, count)
    share = np.where(count[corner] == 1, 0.5, place / np.maximum(np.ceil(turn / ROUND - 1e-9), 1)[corner])
    angle = share * turn[corner] - np.pi / 2  # from straight ahead to the right-hand side, then along with the turn
    side = np.cross(up, ahead)
    direction = np.cos(angle)[:, None] * ahead[corner] + np.sin(angle)[:, None] * side[corner]
    half = np.cos(np.clip(turn, -np.pi, ROUND) / 2)
    return corner, direction, np.where(turn > ROUND, 1.0, np.where(turn > 0, 1 / half, half))[corner]


def _level(vectors: FloatArray, up: FloatArray) -> FloatArray:
    """(w, 3) unit directions of ``vectors`` in the planes square to ``up``; any where a vector stands upright."""
    level = vectors - (vectors * up).sum(axis=1, keepdims=True) * up
    upright = np.linalg.norm(level, axis=1) <= 1e-6 * np.linalg.norm(vectors, axis=1)
    if upright.any():
        level[upright] = np.cross(up[upright], np.eye(3)[np.abs(up[upright]).argmin(axis=1)])
    return level / np.linalg.norm(level, axis=1, keepdims=True)
