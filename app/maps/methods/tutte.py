"""The first map of a disk: border on a circle, every inner vertex at its neighbours' mean (Tutte 1963).

Uniform weights, never cotangents: with positive weights, and only with them, no triangle can flip whatever its shape.

Cost: one sparse factorisation, 5 ms for 10,000 faces. Loses: a deep body's tip shrinks towards a point, up to where
numbers end.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.sparse import coo_matrix, csc_matrix

from app.arrays import FloatArray, IntArray
from app.errors import MapError
from app.geometry.factor import Factor
from app.geometry.topology import boundary_loops, edge_table


def flatten_disk(positions: FloatArray, faces: IntArray) -> Iterator[FloatArray]:
    """The one round of the method ``tutte``."""
    yield tutte(positions, faces)


def tutte(positions: FloatArray, faces: IntArray) -> FloatArray:
    """Map a disk to the unit circle.

    Args:
        positions: (k, 3) of the cut surface's vertices; only border lengths are used.
        faces: (m, 3), one boundary loop.

    Returns:
        (k, 2), counter-clockwise faces positive.
    """
    edges = edge_table(faces).edges
    return _relaxed(circle(positions, faces), edges, np.ones(len(edges)), faces)


def evened(positions: FloatArray, faces: IntArray, plane: FloatArray) -> FloatArray:
    """A map with the same border on which edges that were drawn too short are longer: valid as well.

    Each edge pulls in proportion to how much too long it was (Yoshizawa, Belyaev and Seidel 2004, made symmetric).
    """
    edges = edge_table(faces).edges
    on_body, on_map = (np.linalg.norm(np.diff(x[edges], axis=1)[:, 0], axis=1) for x in (positions, plane))
    tiny = np.finfo(float).tiny
    pull = np.maximum(on_map, tiny) / np.maximum(on_body, 1e-9 * on_body.max())
    return _relaxed(circle(positions, faces), edges, np.maximum(pull / pull.max(), 1e-12), faces)


def circle(positions: FloatArray, faces: IntArray) -> FloatArray:
    """(k, 2) the border on the unit circle, arcs as long as on the body; inner vertices at the origin."""
    (loop,) = boundary_loops(faces)
    steps = np.linalg.norm(positions[np.roll(loop, -1)] - positions[loop], axis=1)
    # Corners at one place would share a point of the circle; a hint of the mean step keeps them apart.
    steps = np.maximum(steps, 1e-6 * steps.mean())
    angle = 2 * np.pi * np.concatenate([[0.0], np.cumsum(steps)[:-1]]) / steps.sum()
    plane = np.zeros((len(positions), 2))
    plane[loop] = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return plane


def _relaxed(plane: FloatArray, edges: IntArray, pull: FloatArray, faces: IntArray) -> FloatArray:
    """Inner vertices where the pulls of their edges are in balance; the border stays."""
    count = len(plane)
    inner = np.ones(count, dtype=bool)
    inner[boundary_loops(faces)[0]] = False
    if not inner.any():
        return plane
    number, size = np.cumsum(inner) - 1, int(inner.sum())
    low, high = edges.T
    total = np.bincount(low, pull, count) + np.bincount(high, pull, count)
    free = inner[low] & inner[high]
    rows, columns = np.concatenate([number[low[free]], np.arange(size)]), number[high[free]]
    columns = np.concatenate([columns, np.arange(size)])
    data = np.concatenate([-pull[free], total[inner]])
    matrix = csc_matrix(coo_matrix((data, (rows, columns)), shape=(size, size)))
    matrix.sort_indices()
    right = np.zeros((count, 2))
    for here, there in ((low, high), (high, low)):
        held = inner[here] & ~inner[there]
        for axis in range(2):
            right[:, axis] += np.bincount(here[held], pull[held] * plane[there[held], axis], count)
    factor, result = Factor(), plane.copy()
    try:
        factor.update(matrix)
        result[inner] = factor.solve(right[inner])
    except ArithmeticError as error:
        raise MapError("the first map cannot be computed", value=error, remedy="Split the patch") from error
    return result
