"""How bodies are handed to VTK: matte, with normals of our own."""

from __future__ import annotations

from typing import Any

import pyvista as pv
from vtkmodules.vtkCommonMath import vtkMatrix4x4

from app.arrays import FloatArray, IntArray

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
