"""Reduced model of a large patch's map: a coarse cage of few vertices that carries all others.

The cage: its vertices are chosen on a regular lattice of the map and evenly along its border. Every other vertex
belongs to the nearest one along the mesh's edges, so that the two sides of a slit never mix. Three owners that meet in
a face form a triangle (the dual of their Voronoi cells). Every vertex keeps its weights in a triangle of its owner, so
the cage carries the vertices piecewise affinely: while no coarse triangle flips, no fine one inside it does.

The reduced energy: value, gradient and Hessian are those of the whole map as functions of the cage. No face of the map
flips, its energy decreases, and a converged map does not change. The most expensive step, the factorisation of the
Hessian, has the size of the cage.

The reduced Hessian: with sparse weights W (k, c) it is W' H W (Galerkin projection). Every 2 x 2 block of H goes,
weighted, into at most nine blocks of the small matrix. The pattern and the weights never change, so the projection is
one sparse product with the entries of H.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix, csc_matrix, csr_matrix

from tactile_maps.core.arrays import BoolArray, FloatArray, IntArray
from tactile_maps.core.errors import MapError
from tactile_maps.flattening.bijectivity import flipped, signed_areas
from tactile_maps.flattening.chart import Chart
from tactile_maps.flattening.newton import Energy
from tactile_maps.geometry.geodesics import edge_graph, nearest_sources
from tactile_maps.geometry.surface.connectivity import Connectivity, run_starts
from tactile_maps.geometry.surface.mesh import Mesh, edge_lengths
from tactile_maps.geometry.surface.point_location import owner_and_rank

_COMPONENTS = ((0, 0), (0, 1), (1, 0), (1, 1))


class GalerkinProjection:
    """Projection of upper triangles (2k, 2k) with one pattern of 2 x 2 blocks to upper triangles (2c, 2c). Built once.

    Args:
        carried: Sparse (k, c), three weights a row.
        hessian: Any matrix of the pattern, rows of each column ascending, with all diagonal blocks.

    Cost: 26 ms for 20,000 faces; to project, 1.2 ms.
    """

    def __init__(self, carried: csr_matrix, hessian: csc_matrix) -> None:
        i, j, self._components = _blocks(hessian)
        low, high, self._spread, self._turned = _sums(carried, i, j)
        size = 2 * carried.shape[1]
        rows = np.concatenate([2 * low + d for d, _ in _COMPONENTS])
        columns = np.concatenate([2 * high + e for _, e in _COMPONENTS])
        upper = rows <= columns
        order = np.lexsort((rows[upper], columns[upper]))
        self._places = np.flatnonzero(upper)[order]
        self._rows: NDArray[np.int32] = rows[self._places].astype(np.int32)
        counts = np.bincount(columns[self._places], minlength=size)
        self._columns = np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)
        self._size = size

    def project(self, hessian: csc_matrix) -> csc_matrix:
        """Return the upper triangle of the small matrix for a ``hessian`` of the pattern."""
        blocks = hessian.data[self._components]
        total = self._spread @ blocks + self._turned @ blocks[:, [0, 2, 1, 3]]
        data = total.T.ravel()[self._places]
        return csc_matrix((data, self._rows, self._columns), shape=(self._size, self._size))


def _blocks(hessian: csc_matrix) -> tuple[IntArray, IntArray, IntArray]:
    """Return vertices i <= j (b,) of each block and the data indices (b, 4) of its entries xx, xy, yx, yy."""
    size = hessian.shape[0]
    columns = np.repeat(np.arange(size), np.diff(hessian.indptr))
    keys = columns * size + hessian.indices
    first = (columns % 2 == 0) & (hessian.indices % 2 == 0)
    i = hessian.indices[first].astype(np.int64) // 2
    j = columns[first] // 2
    parts = []
    for d, e in _COMPONENTS:
        row = 2 * i + d
        column = 2 * j + e
        # a diagonal block stores yx as xy
        low = np.minimum(row, column)
        high = np.maximum(row, column)
        parts.append(np.searchsorted(keys, high * size + low))
    return i, j, np.stack(parts, axis=1)


def _sums(carried: csr_matrix, i: IntArray, j: IntArray) -> tuple[IntArray, IntArray, csr_matrix, csr_matrix]:
    """Return small blocks (low, high) and matrices that sum large blocks into them, as is and with xy, yx swapped."""
    corners = carried.indices.reshape(-1, 3).astype(np.int64)
    weights = carried.data.reshape(-1, 3)
    a = np.repeat(corners[i], 3, axis=1).ravel()
    b = np.tile(corners[j], (1, 3)).ravel()
    share = (weights[i][:, :, None] * weights[j][:, None, :]).ravel()
    block = np.repeat(np.arange(len(i)), 9)
    off = np.repeat(i != j, 9)
    # Off the diagonal each block also represents its transpose; on it the transposed pairs are among the nine.
    straight = (share != 0) & (a <= b)
    mirrored = (share != 0) & (a >= b) & off
    count = carried.shape[1]
    keys, place = np.unique(np.concatenate([(a * count + b)[straight], (b * count + a)[mirrored]]), return_inverse=True)
    low, high = np.divmod(keys, count)
    parts = [
        coo_matrix((share[kept], (at, block[kept])), shape=(len(keys), len(i))).tocsr()
        for kept, at in ((straight, place[: straight.sum()]), (mirrored, place[straight.sum() :]))
    ]
    return low, high, parts[0], parts[1]


class ReducedEnergy:
    """Energy of ``problem`` as a function of the plane of a coarse cage.

    Args:
        problem: The energy of the whole map.
        carried: Sparse (k, c) with three weights a row: the whole plane from the coarse one.
    """

    def __init__(self, problem: Energy, carried: csr_matrix) -> None:
        self._problem = problem
        self._carried = carried
        self._back: csr_matrix = carried.T.tocsr()
        self._subspace: GalerkinProjection | None = None

    def energy(self, plane: FloatArray) -> float:
        """Return the mean energy of the whole map by area; inf if a face has no positive area."""
        return self._problem.energy(self._carried @ plane)

    def gradient(self, plane: FloatArray) -> FloatArray:
        """Return the gradient (2c,); x and y of a vertex are adjacent."""
        return self._reduced(self._problem.gradient(self._carried @ plane))

    def derivatives(self, plane: FloatArray) -> tuple[FloatArray, csc_matrix]:
        """Return gradient (2c,) and upper triangle (2c, 2c) of a positive semidefinite Hessian of constant pattern."""
        gradient, hessian = self._problem.derivatives(self._carried @ plane)
        if self._subspace is None:
            self._subspace = GalerkinProjection(self._carried, hessian)
        return self._reduced(gradient), self._subspace.project(hessian)

    def largest_step(self, plane: FloatArray, step: FloatArray) -> float:
        """Return the step length at which the first face loses its area; inf if none does."""
        return self._problem.largest_step(self._carried @ plane, self._carried @ step)

    def _reduced(self, gradient: FloatArray) -> FloatArray:
        return np.asarray(self._back @ gradient.reshape(-1, 2)).ravel()


CAGE_FACES = 4000
"""Number of faces of a coarse cage; its Hessian is factored in 4 ms."""
_TRIES = 10
"""Largest number of attempts, each without the vertices that caused flips in the last one."""


@dataclass(frozen=True, eq=False)
class CoarseCage:
    """A coarse patch and the weights by which it carries the fine one.

    Attributes:
        surface: Coarse triangles on the body.
        plane: (c, 2) their vertices on the map from which the cage was built, without flips.
        chosen: (c,) fine vertices used as coarse ones.
        carried: Sparse (k, c): fine plane from coarse plane, exact for the map from which it was built.
        owners: (k,) coarse vertex that owns each fine one.
    """

    surface: Mesh
    plane: FloatArray
    chosen: IntArray
    carried: csr_matrix
    owners: IntArray

    def held(self, corners: IntArray, weights: FloatArray) -> tuple[IntArray, FloatArray]:
        """Convert points (q,) with ``weights`` (q, 3) in fine faces with ``corners`` (q, 3) to coarse faces.

        Just outside the coarse border a weight is negative.
        """
        nearest = np.take_along_axis(corners, weights.argmax(axis=1)[:, None], axis=1)[:, 0]
        points = np.einsum("qc,qcd->qd", weights, (self.carried @ self.plane)[corners])
        face, shares = _weights(self.surface.faces, self.plane, self.owners[nearest], points)
        return self.surface.faces[face], shares


def build_coarse_cage(surface: Mesh, chart: Chart, *, faces: int = CAGE_FACES, name: str = "patch") -> CoarseCage:
    """Build the coarse cage of a patch for its current map.

    Args:
        surface: Surface of the patch.
        chart: Its chart, without flips.
        faces: Approximate number of triangles.
        name: The patch's name, for errors.

    Raises:
        MapError: No valid cage was found; the patch should be edited with all faces.

    Cost: 0.1 s for 50,000 faces.
    """
    chosen = _chosen(chart, faces)
    for _ in range(_TRIES):
        owners = _owners(chart, chosen)
        coarse = Connectivity(_dual(chart.faces, owners))
        unfit = _unfit(coarse, chart.plane[chosen])
        if not unfit.any():
            if not _is_disk(coarse):
                break
            return _coarse_cage(surface, chart, chosen, owners, coarse)
        chosen = chosen[~unfit]
    raise MapError("no valid coarse cage was found", place=name, value=f"{len(chart.faces)} faces")


def _coarse_cage(surface: Mesh, chart: Chart, chosen: IntArray, owners: IntArray, coarse: Connectivity) -> CoarseCage:
    plane = chart.plane[chosen]
    face, weights = _weights(coarse.faces, plane, owners, chart.plane)
    entries = (weights.ravel(), (np.repeat(np.arange(len(owners)), 3), coarse.faces[face].ravel()))
    carried = coo_matrix(entries, shape=(len(owners), len(chosen))).tocsr()
    rest = Mesh.of(coarse, surface.vertices[chart.vertex_of[chosen]])
    return CoarseCage(rest, plane, chosen, carried, owners)


def _chosen(chart: Chart, faces: int) -> IntArray:
    """Return fine vertices on a hexagonal lattice inside and evenly along the border, for about ``faces`` triangles."""
    spacing = float(np.sqrt(4 * signed_areas(chart.plane, chart.faces).sum() / (np.sqrt(3) * faces)))
    border = chart.border
    along = np.linalg.norm(np.roll(chart.plane[border], -1, axis=0) - chart.plane[border], axis=1).cumsum()
    count = max(3, round(along[-1] / spacing))
    corners = border[np.unique(np.searchsorted(along, along[-1] * (np.arange(count) + 0.5) / count))]
    inside = np.flatnonzero(_distances(chart, border)[0] > 0.6 * spacing)
    row = np.round(chart.plane[inside, 1] / (spacing * np.sqrt(0.75)))
    column = np.round(chart.plane[inside, 0] / spacing - 0.5 * (row % 2))
    centres = np.stack([(column + 0.5 * (row % 2)) * spacing, row * spacing * np.sqrt(0.75)], axis=1)
    off = np.linalg.norm(chart.plane[inside] - centres, axis=1)
    order = np.lexsort((off, column, row))
    first = run_starts(row[order], column[order])
    # A cell cut off by the border may have no vertex near its centre.
    middle = first & (off[order] < 0.5 * spacing)
    return np.concatenate([corners, inside[order[middle]]])


def _distances(chart: Chart, sources: IntArray) -> tuple[FloatArray, IntArray]:
    """Return the distance (k,) of each vertex to the nearest of ``sources`` along map edges, and that source."""
    edges = chart.connectivity.edges
    return nearest_sources(edge_graph(edges, edge_lengths(chart.plane, edges), len(chart.plane)), sources)


def _owners(chart: Chart, chosen: IntArray) -> IntArray:
    """Return the index in ``chosen`` (k,) of the owner of each vertex."""
    number = np.zeros(len(chart.plane), dtype=np.int64)
    number[chosen] = np.arange(len(chosen))
    return number[_distances(chart, chosen)[1]]


def _dual(faces: IntArray, owners: IntArray) -> IntArray:
    """Return triangles (t, 3) of owners that meet in a face, with its orientation."""
    met = owners[faces]
    three = met[(met[:, 0] != met[:, 1]) & (met[:, 1] != met[:, 2]) & (met[:, 2] != met[:, 0])]
    first = three.argmin(axis=1)[:, None]
    return np.unique(np.take_along_axis(three, (first + np.arange(3)) % 3, axis=1), axis=0)


def _unfit(coarse: Connectivity, plane: FloatArray) -> BoolArray:
    """Return a mask (c,) of vertices to drop: unused ones, and one per flipped triangle, preferably inner."""
    faces = coarse.faces
    unfit = np.ones(len(plane), dtype=bool)
    unfit[faces] = False
    bad = flipped(plane, faces) | (coarse.face_count[coarse.edge_of] > 2).any(axis=1)
    inside = np.ones(len(plane), dtype=bool)
    inside[coarse.boundary_edges] = False
    corner = inside[faces[bad]].argmax(axis=1)
    unfit[faces[bad][np.arange(len(corner)), corner]] = True
    return unfit


def _is_disk(coarse: Connectivity) -> bool:
    return coarse.euler_characteristic == 1 and not len(coarse.bow_tie_vertices) and coarse.components.max() == 0


def _weights(faces: IntArray, plane: FloatArray, owners: IntArray, points: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return the face (q,) at the owner of each of ``points`` (q, 2) that contains it best, and its weights (q, 3)."""
    order = np.argsort(faces.ravel(), kind="stable")
    start = np.searchsorted(faces.ravel()[order], np.arange(len(plane) + 1))
    query, step = owner_and_rank(start[owners + 1] - start[owners])
    face = order[start[owners][query] + step] // 3
    a, b, c = (plane[faces[face, k]] for k in range(3))
    u = b - a
    v = c - a
    p = points[query] - a
    area = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    second = (p[:, 0] * v[:, 1] - p[:, 1] * v[:, 0]) / area
    third = (u[:, 0] * p[:, 1] - u[:, 1] * p[:, 0]) / area
    weights = np.stack([1 - second - third, second, third], axis=1)
    best = _last_of_each(query, np.lexsort((weights.min(axis=1), query)))
    return face[best], weights[best]


def _last_of_each(groups: IntArray, order: IntArray) -> IntArray:
    """Return the last element of each group of ``order``, which is sorted by ``groups``."""
    last: BoolArray = np.append(np.diff(groups[order]) != 0, True)[: len(order)]
    return order[last]
