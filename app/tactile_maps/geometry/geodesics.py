"""Distances over a surface: exact ones, to compare those on the map with, and shortest paths along edges.

``edge_graph`` and the questions below it serve any graph of lengths: a mesh's edges, faces beside each other, taxels
and their neighbours.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import igl
import numpy as np
from scipy.sparse import coo_matrix, csr_matrix
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from tactile_maps.core.arrays import FloatArray, IntArray
from tactile_maps.geometry.surface.connectivity import remove_unreferenced
from tactile_maps.geometry.surface.mesh import Mesh

_THINNEST = 1e-6
"""Of a face for libigl: its area over its longest side squared. It hangs on thinner ones."""
_THIN = 1e-3
_MOST_THIN = 60
"""Thin faces cut the exact method's intervals ever finer: on 30,000 faces one source takes 1 s with 6 of them, 13 s
with 58, and over 40 s with 85 (measured on spheres drawn out to a spike)."""
_NONE = np.zeros(0, dtype=np.int64)


class Geodesics:
    """Distances between vertices of one surface. Built once, asked often.

    libigl hangs on faces without area, takes minutes where many are thin, and crashes on loose vertices. The latter are
    left out; a surface that has the former, or is not manifold, is measured along its edges instead (up to 15 % too
    long), which ``exact`` says.

    Args:
        surface: Connected, not cut.
    """

    def __init__(self, surface: Mesh) -> None:
        faces, kept = remove_unreferenced(surface.faces)
        self._mesh = Mesh(surface.vertices[kept], faces)
        self._number = np.full(len(surface.vertices), -1, dtype=np.int64)
        self._number[kept] = np.arange(len(kept))
        sides = self._mesh.vertices[faces] - np.roll(self._mesh.vertices[faces], 1, axis=1)
        self._sides = np.linalg.norm(sides, axis=2)
        areas = self._mesh.face_areas
        squares = (self._sides**2).max(axis=1)
        hangs = (areas <= _THINNEST * squares).any()
        slow = (areas <= _THIN * squares).sum() > _MOST_THIN
        connectivity = self._mesh.connectivity
        manifold = connectivity.face_count.max(initial=0) <= 2 and not len(connectivity.bow_tie_vertices)
        self.exact = bool(len(faces) and manifold and not hangs and not slow)

    def from_vertex(self, source: int, targets: IntArray) -> FloatArray:
        """Exact polyhedral distances [m] from a vertex to ``targets`` (k,) (Mitchell, Mount and Papadimitriou 1987).

        Cost: 30 ms on 3000 faces, 0.2 s on 8000.
        """
        goals = self._number[targets]
        if not self.exact:
            return shortest_path_tree(self._graph, int(self._number[source]))[0][goals]
        return _exact(self._mesh.vertices, self._mesh.faces, int(self._number[source]), goals)

    def from_vertex_within(self, source: int, targets: IntArray, reach: float) -> FloatArray:
        """The same where it is at most ``reach`` [m], and inf beyond; 1 ms for 300 faces within reach.

        A path of that length stays among the faces that meet the ball of that radius, so the others are not asked.
        """
        if not self.exact:
            found = self.from_vertex(source, targets)
            return np.where(found <= reach, found, np.inf)
        start = self._number[source]
        goals = self._number[targets]
        within = self._face_centres.query_ball_point(self._mesh.vertices[start], reach + self._reach_of_faces)
        faces = self._mesh.faces[within]
        met = np.zeros(len(self._mesh.vertices), dtype=bool)
        met[faces] = True
        kept = np.flatnonzero(met)
        place = np.cumsum(met) - 1  # of each vertex among those kept: to sort and search them takes twice as long
        inside = met[goals]
        goal = place[goals[inside]]
        beginning = int(place[start])
        found = _exact(self._mesh.vertices[kept], place[faces], beginning, goal)
        # What the ball cut off is told as 0.
        reached = (found <= reach) & ((found > 0) | (goal == beginning))
        result = np.full(len(goals), np.inf)
        result[inside] = np.where(reached, found, np.inf)
        return result

    def approximate_from_vertex(self, source: int, targets: IntArray) -> FloatArray:
        """The same within about 1 %, by the heat method (Crane, Weischedel and Wardetzky 2013); 1 ms."""
        if not self.exact or self._heat is None:
            return self.from_vertex(source, targets)
        found = np.asarray(igl.heat_geodesics_solve(self._heat, self._number[[source]])).reshape(-1)
        return found[self._number[targets]]

    @cached_property
    def _face_centres(self) -> cKDTree:
        return cKDTree(self._mesh.vertices[self._mesh.faces].mean(axis=1))

    @cached_property
    def _reach_of_faces(self) -> float:
        """No point of a face is farther from its middle than two thirds of its longest side."""
        return 2 / 3 * float(self._sides.max())

    @cached_property
    def _heat(self) -> Any:
        """Factored systems; None where libigl cannot factor them, as for a single triangle."""
        data = igl.HeatGeodesicsData()
        data.use_intrinsic_delaunay = True
        try:
            igl.heat_geodesics_precompute(self._mesh.vertices, self._mesh.faces, data)
        except RuntimeError:
            return None
        return data

    @cached_property
    def _graph(self) -> csr_matrix:
        return edge_graph(self._mesh.edges, self._mesh.edge_lengths, len(self._mesh.vertices))


def _exact(vertices: FloatArray, faces: IntArray, source: int, targets: IntArray) -> FloatArray:
    unique, back = np.unique(targets, return_inverse=True)
    if not len(unique):
        return np.zeros(0)
    found = igl.exact_geodesic(vertices, faces, np.array([source]), _NONE, unique, _NONE)
    return np.asarray(found, dtype=np.float64).reshape(-1)[back]


def edge_graph(edges: IntArray, lengths: FloatArray, count: int) -> csr_matrix:
    """Sparse (count, count) graph with ``lengths`` (e,), not negative, of ``edges`` (e, 2), each to be stated once."""
    return coo_matrix((lengths, (edges[:, 0], edges[:, 1])), shape=(count, count)).tocsr()


def distances_from(graph: csr_matrix, sources: IntArray, *, limit: float = np.inf) -> FloatArray:
    """(n,) length of the shortest path to the nearest of ``sources`` (Dijkstra 1959); inf beyond ``limit``."""
    return np.asarray(dijkstra(graph, directed=False, indices=sources, min_only=True, limit=limit))


def nearest_sources(graph: csr_matrix, sources: IntArray, *, limit: float = np.inf) -> tuple[FloatArray, IntArray]:
    """``distances_from``, and (n,) which node of ``sources`` that is; negative where none is within ``limit``."""
    distances, _, nearest = dijkstra(
        graph, directed=False, indices=sources, min_only=True, return_predecessors=True, limit=limit
    )
    return distances, nearest.astype(np.int64)


def shortest_path_tree(graph: csr_matrix, root: int) -> tuple[FloatArray, IntArray]:
    """(n,) lengths of the shortest paths from ``root``, and (n,) the node before each on it, negative for none."""
    distances, before = dijkstra(graph, directed=False, indices=root, return_predecessors=True)
    return distances, before.astype(np.int64)


def path_in_tree(before: IntArray, end: int) -> IntArray:
    """(k,) the nodes from the root of a ``shortest_path_tree`` to ``end``; only ``end`` where no way leads there."""
    path = [end]
    while before[path[-1]] >= 0:
        path.append(int(before[path[-1]]))
    return np.array(path[::-1], dtype=np.int64)


def all_path_lengths(graph: csr_matrix, chosen: IntArray | None = None) -> FloatArray:
    """(k, k) lengths of the shortest paths between ``chosen`` nodes (k,), or all; inf where none leads."""
    if chosen is None:
        return np.asarray(dijkstra(graph, directed=False))
    return np.asarray(dijkstra(graph, directed=False, indices=chosen))[:, chosen]
