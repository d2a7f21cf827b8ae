"""Corrections of the contact points that MuJoCo finds between two shapes with faces."""

from __future__ import annotations

import math

import mujoco
import numpy as np

from tactile_maps.core.arrays import FloatArray

_ALIGNED = 1 - 1e-6
"""Cosine of the angle from which on two normals are the same: 0.08 degrees."""
_NEARLY = 0.9
"""Cosine of the angle by which a normal may be corrected: 26 degrees."""
_CORNERS = 4
_ON_RIM = 1e-6
_LEVEL = 0.08
"""Cosine of the angle between the normal and a cylinder's axis up to which the cylinder is on its side."""
_SHIFT = 0.01
"""Largest correction of a point on a cylinder's side, as a share of the radius."""
_SQUARE = np.array([[1, 1, 0], [-1, 1, 0], [-1, -1, 0], [1, -1, 0]]) / math.sqrt(2)


def correct_normal(model: mujoco.MjModel, data: mujoco.MjData, numbers: list[int]) -> bool:
    """Set the normal of the points to the direction of least penetration, and their depths along it.

    MuJoCo takes faces within 5 degrees of each other as aligned, and the normal of the second shape's face for the
    contact's. A finely divided ball, or a tilted mesh, on a plane would be pushed along the normal of its own face.

    Args:
        model: The compiled model.
        data: State after collision detection; the caller must rebuild the constraints.
        numbers: Numbers of all contacts of one pair of shapes.

    Returns:
        Whether anything was changed.

    Cost: 5 us.
    """
    contact = data.contact
    ends = np.zeros(6)
    first, second = contact.geom[numbers[0]].tolist()
    distance = mujoco.mj_geomDistance(model, data, first, second, 0.0, ends)
    if distance >= 0:
        return False
    across = ends[:3] - ends[3:]
    x, y, z = across.tolist()
    before = contact.frame[numbers[0]].tolist()
    aligned = x * before[0] + y * before[1] + z * before[2]
    length = math.hypot(x, y, z)
    # At a depth of nanometres the direction may be any, also the opposite one.
    if not _NEARLY * length < aligned < _ALIGNED * length:
        return False
    normal = across / math.sqrt(across @ across)
    contact.dist[numbers] *= distance / contact.dist[numbers].min()
    contact.frame[numbers] = frame_along(normal).ravel()
    return True


def centre_on_cap(model: mujoco.MjModel, data: mujoco.MjData, numbers: list[int]) -> bool:
    """Move four points on the rim of a cylinder's cap to the corners of a square.

    MuJoCo takes four of sixteen points on the rim; which ones changes with the last digits, so that a disc at rest
    would rock. Points of a cap that reaches beyond the other shape are unchanged.

    Args:
        model: The compiled model.
        data: See ``correct_normal``.
        numbers: See ``correct_normal``.

    Returns:
        Whether anything was changed.
    """
    geom = int(data.contact.geom[numbers[0], 0])
    if model.geom_type[geom] != mujoco.mjtGeom.mjGEOM_CYLINDER or len(numbers) != _CORNERS:
        return False
    radius, half, _ = model.geom_size[geom]
    points, turn, normal = _on_cylinder(data, geom, numbers)
    if np.abs(np.hypot(points[:, 0], points[:, 1]) - radius).max() > _ON_RIM * radius:
        return False
    corners = radius * _SQUARE + (0.0, 0.0, math.copysign(half, points[0, 2]))
    deep = -data.contact.dist[numbers[0]] + (corners - points[0]) @ (normal @ turn)
    _move_points(data, geom, numbers, corners, deep)
    return True


def centre_on_side(model: mujoco.MjModel, data: mujoco.MjData, numbers: list[int]) -> bool:
    """Move the points of a cylinder on its side to the line that is deepest along the normal.

    MuJoCo finds that line within 0.1 degrees: its points are up to 30 um off, so that a roller at rest begins to roll.

    Args:
        model: The compiled model.
        data: See ``correct_normal``.
        numbers: See ``correct_normal``.

    Returns:
        Whether anything was changed.
    """
    geom = int(data.contact.geom[numbers[0], 0])
    if model.geom_type[geom] != mujoco.mjtGeom.mjGEOM_CYLINDER:
        return False
    points, turn, normal = _on_cylinder(data, geom, numbers)
    along = normal @ turn
    if abs(along[2]) > _LEVEL:
        return False
    moved = points.copy()
    radius = model.geom_size[geom, 0]
    moved[:, :2] = radius * along[:2] / math.hypot(along[0], along[1])
    if np.abs(moved - points).max() > _SHIFT * radius:
        return False
    _move_points(data, geom, numbers, moved, -data.contact.dist[numbers] + (moved - points) @ along)
    return True


def _on_cylinder(data: mujoco.MjData, geom: int, numbers: list[int]) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the points on the surface of the first shape (k, 3) in its frame, that frame (3, 3), and the normal."""
    contact = data.contact
    turn = data.geom_xmat[geom].reshape(3, 3)
    normal = contact.frame[numbers[0], :3]
    points = (contact.pos[numbers] - 0.5 * contact.dist[numbers, None] * normal - data.geom_xpos[geom]) @ turn
    return points, turn, normal


def _move_points(data: mujoco.MjData, geom: int, numbers: list[int], points: FloatArray, deep: FloatArray) -> None:
    """Set contacts to points (k, 3) of the first shape's surface, its frame, and their depths (k,) [m]."""
    contact = data.contact
    turn = data.geom_xmat[geom].reshape(3, 3)
    contact.dist[numbers] = -deep
    contact.pos[numbers] = points @ turn.T + data.geom_xpos[geom] - 0.5 * deep[:, None] * contact.frame[numbers[0], :3]


def frame_along(normal: FloatArray) -> FloatArray:
    """Return a right-handed frame (3, 3) whose first row is ``normal`` (3,)."""
    helper = np.zeros(3)
    helper[np.abs(normal).argmin()] = 1.0
    first = np.cross(normal, helper)
    first /= math.sqrt(first @ first)
    return np.stack([normal, first, np.cross(normal, first)])
