"""Corrections of the contact points that MuJoCo finds between two shapes with faces."""

from __future__ import annotations

import math

import mujoco
import numpy as np

from app.core.arrays import FloatArray

_ALIGNED = 1 - 1e-6
"""Cosine of the angle from which on two normals are the same: 0.08 degrees."""
_CORNERS, _ON_RIM = 4, 1e-6
_SQUARE = np.array([[1, 1, 0], [-1, 1, 0], [-1, -1, 0], [1, -1, 0]]) / math.sqrt(2)


def correct_normal(model: mujoco.MjModel, data: mujoco.MjData, numbers: list[int]) -> bool:
    """Set the normal of the points to the direction of least penetration, and their depths along it.

    MuJoCo takes faces within 5 degrees of each other as aligned, and the normal of the second shape's face for the
    contact's. A finely divided ball, or a tilted mesh, on a plane would be pushed along the normal of its own face.

    Args:
        model: Compiled.
        data: Between its collisions and its constraints, which the caller then makes again.
        numbers: Of all contacts of one pair of shapes.

    Returns:
        Whether anything was changed.

    Cost: 5 us.
    """
    contact, ends = data.contact, np.zeros(6)
    first, second = contact.geom[numbers[0]].tolist()
    distance = mujoco.mj_geomDistance(model, data, first, second, 0.0, ends)
    across = ends[:3] - ends[3:]
    length = math.sqrt(across @ across)
    if distance >= 0 or length == 0:
        return False
    normal = across / length
    if normal @ contact.frame[numbers[0], :3] > _ALIGNED:
        return False
    contact.dist[numbers] *= distance / contact.dist[numbers].min()
    contact.frame[numbers] = frame_along(normal).ravel()
    return True


def centre_on_cap(model: mujoco.MjModel, data: mujoco.MjData, numbers: list[int]) -> bool:
    """Move four points on the rim of a cylinder's cap to the corners of a square.

    MuJoCo takes four of sixteen points on the rim; which ones changes with the last digits, so that a disc at rest
    would rock. Points of a cap that reaches beyond the other shape stay as they are.

    Args:
        model: Compiled.
        data: As for ``correct_normal``.
        numbers: Likewise.

    Returns:
        Whether anything was changed.
    """
    contact, geom = data.contact, int(data.contact.geom[numbers[0], 0])
    if model.geom_type[geom] != mujoco.mjtGeom.mjGEOM_CYLINDER or len(numbers) != _CORNERS:
        return False
    radius, half, _ = model.geom_size[geom]
    turn, normal = data.geom_xmat[geom].reshape(3, 3), contact.frame[numbers[0], :3]
    depths = -contact.dist[numbers]
    points = (contact.pos[numbers] + 0.5 * depths[:, None] * normal - data.geom_xpos[geom]) @ turn
    if np.abs(np.hypot(points[:, 0], points[:, 1]) - radius).max() > _ON_RIM * radius:
        return False
    corners = radius * _SQUARE + (0.0, 0.0, math.copysign(half, points[0, 2]))
    deep = depths[0] + (corners - points[0]) @ (normal @ turn)
    contact.dist[numbers] = -deep
    contact.pos[numbers] = corners @ turn.T + data.geom_xpos[geom] - 0.5 * deep[:, None] * normal
    return True


def frame_along(normal: FloatArray) -> FloatArray:
    """Return a right-handed frame (3, 3) whose first row is ``normal`` (3,)."""
    helper = np.zeros(3)
    helper[np.abs(normal).argmin()] = 1.0
    first = np.cross(normal, helper)
    first /= math.sqrt(first @ first)
    return np.stack([normal, first, np.cross(normal, first)])
