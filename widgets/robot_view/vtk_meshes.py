"""How bodies are handed to VTK: matte, with normals of our own; and grids for floors and planes.

The floor under the robot is a faint grid, as large as what stands on it needs.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pyvista as pv
from vtkmodules.vtkCommonMath import vtkMatrix4x4

from app.core.arrays import FloatArray, IntArray

MATTE: dict[str, Any] = {
    "smooth_shading": True,
    "split_sharp_edges": False,
    "ambient": 0.34,
    "diffuse": 0.70,
    "specular": 0.0,
    "show_scalar_bar": False,
    "reset_camera": False,
}


def set_matrix(actor: Any, matrix: FloatArray) -> None:
    """Place an actor by a (4, 4) matrix, in place."""
    own = actor.GetUserMatrix()
    if own is None:
        own = vtkMatrix4x4()
        actor.SetUserMatrix(own)
    own.DeepCopy(matrix.ravel())


def polydata(vertices: FloatArray, normals: FloatArray, faces: IntArray) -> pv.PolyData:
    """Points (n, 3), unit normals (n, 3) and triangles (m, 3) as copies for VTK, so that it computes no normals."""
    surface = pv.PolyData.from_regular_faces(vertices.copy(), faces.copy())
    surface.point_data.active_normals = normals.copy()
    return surface


_MAX_WIDTH = 20.0
"""No floor is drawn wider [m]."""


def floor_grid(points: FloatArray) -> pv.PolyData:
    """A grid under points (k, 3) [m], world: at zero, or below the lowest of them."""
    span = float(np.clip(np.ptp(points[:, :2], axis=0).max(), 0.2, _MAX_WIDTH))
    step = _step(span)
    half = step * np.ceil(0.9 * span / step)
    centre = np.round(points[:, :2].mean(axis=0) / step) * step
    floor = min(float(points[:, 2].min()), 0.0) if points[:, 2].min() < -1e-3 else 0.0
    return _grid((half, half), step, np.array([*centre, floor]))


def plane_grid(bounds: FloatArray) -> pv.PolyData:
    """A grid over a plane within (2, 3) ``bounds`` [m] around its frame's origin, and lines along its edges."""
    x, y = (float(half) for half in bounds[1, :2])
    return _grid((x, y), _step(max(x, y)), np.zeros(3))


def _step(span: float) -> float:
    return float(10.0 ** np.floor(np.log10(span / 2)))


def _grid(half: tuple[float, float], step: float, centre: FloatArray) -> pv.PolyData:
    """Lines ``step`` apart from the middle out, and along the edges."""
    across, along = (_ticks(reach, step) for reach in half)
    ends = [[[t, -half[1]], [t, half[1]]] for t in across] + [[[-half[0], t], [half[0], t]] for t in along]
    lines = np.zeros((2 * len(ends), 3))
    lines[:, :2] = np.array(ends).reshape(-1, 2)
    pairs = np.insert(np.arange(len(lines)).reshape(-1, 2), 0, 2, axis=1)
    return pv.PolyData(lines + centre, lines=pairs.ravel())


def _ticks(reach: float, step: float) -> FloatArray:
    inner = step * np.arange(-np.floor(reach / step), np.floor(reach / step) + 1)
    return np.unique(np.round(np.concatenate([[-reach], inner, [reach]]), 9))
