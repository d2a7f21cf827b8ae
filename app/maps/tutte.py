"""The first map of a disk: border on a circle, every inner vertex at its neighbours' mean (Tutte 1963).

Uniform weights, never cotangents: with them, and only with them, no triangle can flip whatever its shape.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_matrix, diags
from scipy.sparse.linalg import splu

from app.arrays import FloatArray, IntArray
from app.geometry.topology import boundary_loops, edge_table


def tutte(positions: FloatArray, faces: IntArray) -> FloatArray:
    """Map a disk to the unit circle.

    Args:
        positions: (k, 3) of the cut surface's vertices; only border lengths are used.
        faces: (m, 3), one boundary loop.

    Returns:
        (k, 2), counter-clockwise faces positive. Cost: one sparse factorisation.
    """
    (loop,) = boundary_loops(faces)
    steps = np.linalg.norm(positions[np.roll(loop, -1)] - positions[loop], axis=1)
    angle = 2 * np.pi * np.concatenate([[0.0], np.cumsum(steps)[:-1]]) / steps.sum()
    plane = np.zeros((len(positions), 2))
    plane[loop] = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    inner = np.setdiff1d(np.arange(len(positions)), loop)
    if len(inner):
        edges = edge_table(faces).edges
        both = np.concatenate([edges, edges[:, ::-1]])
        adjacency = coo_matrix((np.ones(len(both)), (both[:, 0], both[:, 1])), shape=(len(positions),) * 2).tocsr()
        laplacian = (diags(np.asarray(adjacency.sum(axis=1)).ravel()) - adjacency).tocsr()[inner]
        known = -laplacian[:, loop] @ plane[loop]
        system = laplacian[:, inner].tocsc()
        factor = splu(system, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
        plane[inner] = factor.solve(np.asarray(known))
    return plane
