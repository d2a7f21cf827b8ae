"""Frames of taxels, in which three-axis taxels measure, and their directions on the map.

The frame of a taxel has the rows t1, t2 and n: n is the outward normal of the taxel, t1 the stated tangent. Where none
is stated, t1 is the direction in which the taxel's triangle moves on the body when its map point moves along the map's
x axis, projected into the tangent plane. It follows the layout: rotating a patch on the map rotates these frames.

On the skin of a calibration error, and on the true skin with the same charts, a taxel without stated tangent has
different frames, as its real and its assumed orientation differ.
"""

from __future__ import annotations

import numpy as np

from tactile_maps.core.arrays import FloatArray, readonly
from tactile_maps.core.caches import weak_cache
from tactile_maps.maps.model.tactile_map import TactileMap
from tactile_maps.skin.model.taxel_axes import tangents_on, unit_rows

_FLAT = 1e-9
"""Twice the area of a triangle over its sides squared, on the map or on the body, below which it has no directions."""


@weak_cache
def taxel_frames(map_: TactileMap) -> FloatArray:
    """Return the frames (n, 3, 3) of all taxels: rows t1, t2, n in the frame of the link, right-handed, orthonormal.

    Where a triangle is degenerate and no tangent is stated, t1 is the axis of the link that is farthest from the
    normal, projected into the tangent plane.
    """
    normals = unit_rows(map_.skin.normals)
    farthest = np.eye(3)[np.abs(normals).argmin(axis=1)]
    tangents = map_.skin.tangents
    for direction in (_velocities(map_)[:, :, 0], farthest):
        tangents = np.where(np.isnan(tangents), tangents_on(unit_rows(direction), normals), tangents)
    return readonly(np.stack([tangents, np.cross(normals, tangents), normals], axis=1))


@weak_cache
def map_directions(map_: TactileMap) -> FloatArray:
    """Return matrices (n, 2, 2) that turn a vector (along t1, along t2) of each taxel into its direction on the map.

    The direction is exact for the triangle of the taxel, so that an arrow on the map and one on the body agree. The
    determinant is 1, or -1 for a mirrored patch: lengths change only by the shear of the triangle, not with its area.
    The matrix is the identity where a triangle is degenerate.
    """
    along = taxel_frames(map_)[:, :2] @ np.nan_to_num(_velocities(map_))
    determinant = np.linalg.det(along)
    regular = np.abs(determinant) > _FLAT * (along**2).sum(axis=(1, 2))
    along[~regular] = np.eye(2)
    size = np.sqrt(np.abs(np.where(regular, determinant, 1.0)))
    return readonly(size[:, None, None] * np.linalg.inv(along))


def _velocities(map_: TactileMap) -> FloatArray:
    """Return (n, 3, 2): velocity on the body, in the triangle of each taxel, per velocity on the map along x and y.

    NaN where the triangle has no area on the map or on the body.
    """
    parts = [np.zeros((0, 3, 2))]
    for patch, chart, uv in zip(map_.skin.patches, map_.charts, map_.uv, strict=True):
        faces = patch.taxels.faces
        body = patch.surface.vertices[patch.surface.faces[faces]]
        plane = uv[chart.faces[faces]]
        body_sides = np.swapaxes(body[:, 1:] - body[:, :1], 1, 2)
        (a, b), (c, d) = np.moveaxis(plane[:, 1:] - plane[:, :1], 0, 2)
        determinant = a * d - b * c
        regular = np.abs(determinant) > _FLAT * (a * a + b * b + c * c + d * d)
        area = np.linalg.norm(np.cross(body_sides[:, :, 0], body_sides[:, :, 1]), axis=1)
        regular &= area > _FLAT * (body_sides**2).sum(axis=(1, 2))
        adjugate = np.moveaxis(np.array([[d, -c], [-b, a]]), 2, 0)
        parts.append(body_sides @ adjugate / np.where(regular, determinant, np.nan)[:, None, None])
    return np.concatenate(parts)
