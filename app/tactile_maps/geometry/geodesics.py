"""Distances over a surface: exact geodesic distances, and shortest paths along edges.

Map distances are compared with the exact ones. ``edge_graph`` and the functions below it accept any graph with edge
lengths: the edges of a mesh, adjacent faces, neighbouring taxels.
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
"""Area over squared longest side up to which a face is too thin for libigl, which does not return on it."""
_THIN = 1e-3
_MOST_THIN = 60
"""Number of thin faces (``_THIN``) up to which the exact method is used. Thin faces divide its intervals ever finer: on
30,000 faces one source takes 1 s with 6 thin faces, 13 s with 58, and over 40 s with 85 (spheres with a spike)."""
_NONE = np.zeros(0, dtype=np.int64)


class Geodesics:
    """Distances between vertices of one surface. Built once, queried often.

    libigl does not return on faces without area, takes minutes on many thin faces, and crashes on unreferenced
    vertices. Unreferenced vertices are removed. A surface with thin faces, or one that is not manifold, is measured
    along its edges instead (up to 15 % too long); ``exact`` is then False.

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
        """Return exact polyhedral distances [m] from a vertex to ``targets`` (k,) (Mitchell et al. 1987).

        Cost: 30 ms on 3000 faces, 0.2 s on 8000.
        """
        goals = self._number[targets]
        if not self.exact:
            return shortest_path_tree(self._graph, int(self._number[source]))[0][goals]
        return _exact(self._mesh.vertices, self._mesh.faces, int(self._number[source]), goals)

    def from_vertex_within(self, source: int, targets: IntArray, reach: float) -> FloatArray:
        """Return the same distances up to ``reach`` [m] and inf beyond; 1 ms for 300 faces within reach.

        A path of that length stays among the faces that meet the ball of that radius, so only these are used.
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
        place = np.cumsum(met) - 1  # index among the kept vertices; sorting and searching them takes twice as long
        inside = met[goals]
        goal = place[goals[inside]]
        beginning = int(place[start])
        found = _exact(self._mesh.vertices[kept], place[faces], beginning, goal)
        # libigl returns 0 for vertices that are not connected within the ball.
        reached = (found <= reach) & ((found > 0) | (goal == beginning))
        result = np.full(len(goals), np.inf)
        result[inside] = np.where(reached, found, np.inf)
        return result

    def approximate_from_vertex(self, source: int, targets: IntArray) -> FloatArray:
        """Return distances within about 1 % by the heat method (Crane, Weischedel and Wardetzky 2013); 1 ms."""
        if not self.exact or self._heat is None:
            return self.from_vertex(source, targets)
        found = np.asarray(igl.heat_geodesics_solve(self._heat, self._number[[source]])).reshape(-1)
        return found[self._number[targets]]

    @cached_property
    def _face_centres(self) -> cKDTree:
        return cKDTree(self._mesh.vertices[self._mesh.faces].mean(axis=1))

    @cached_property
    def _reach_of_faces(self) -> float:
        """Two thirds of the longest side: no point of a face is farther from its centroid."""
        return 2 / 3 * float(self._sides.max())

    @cached_property
    def _heat(self) -> Any:
        """Factored systems; None if libigl cannot factor them, as for a single triangle."""
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
    """Return the sparse graph (count, count) of ``edges`` (e, 2), each listed once, with ``lengths`` (e,) >= 0."""
    return coo_matrix((lengths, (edges[:, 0], edges[:, 1])), shape=(count, count)).tocsr()


def distances_from(graph: csr_matrix, sources: IntArray, *, limit: float = np.inf) -> FloatArray:
    """Return the path lengths (n,) to the nearest of ``sources`` (Dijkstra 1959); inf beyond ``limit``."""
    return np.asarray(dijkstra(graph, directed=False, indices=sources, min_only=True, limit=limit))


def nearest_sources(graph: csr_matrix, sources: IntArray, *, limit: float = np.inf) -> tuple[FloatArray, IntArray]:
    """Return ``distances_from`` and the nearest source (n,) of each node; negative if none is within ``limit``."""
    distances, _, nearest = dijkstra(
        graph, directed=False, indices=sources, min_only=True, return_predecessors=True, limit=limit
    )
    return distances, nearest.astype(np.int64)


def shortest_path_tree(graph: csr_matrix, root: int) -> tuple[FloatArray, IntArray]:
    """Return the lengths (n,) of the shortest paths from ``root`` and predecessors (n,), negative for none."""
    distances, before = dijkstra(graph, directed=False, indices=root, return_predecessors=True)
    return distances, before.astype(np.int64)


def path_in_tree(before: IntArray, end: int) -> IntArray:
    """Return the nodes (k,) from the root of a ``shortest_path_tree`` to ``end``; only ``end`` if it is unreachable."""
    path = [end]
    while before[path[-1]] >= 0:
        path.append(int(before[path[-1]]))
    return np.array(path[::-1], dtype=np.int64)


def all_path_lengths(graph: csr_matrix) -> FloatArray:
    """Return the path lengths (k, k) between all nodes; inf if not connected."""
    return np.asarray(dijkstra(graph, directed=False))
