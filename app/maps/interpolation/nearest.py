"""The value of the nearest taxel."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_matrix
from scipy.spatial import cKDTree

from app.arrays import FloatArray
from app.maps.interpolation.triangles import TaxelTriangles, sparse_rows


def nearest(triangles: TaxelTriangles, points: FloatArray) -> csr_matrix:
    """Sparse (k, n): one weight a point; shows what was measured and nothing else, in cells with hard borders.

    Error (rms, of a field from 0 to 1, from 1000 taxels): 0.031 on smooth waves, 0.037 under a ball, steep at its rim.

    Cost: 35 ms to build 256 x 256 pixels from 1000 taxels, then 0.05 ms a frame.
    """
    taxels = cKDTree(triangles.sites).query(points)[1].reshape(-1, 1)
    return sparse_rows(taxels.astype(np.int64), np.ones(taxels.shape), len(triangles.sites))
